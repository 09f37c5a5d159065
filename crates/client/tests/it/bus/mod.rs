//! A controller, monitors and consoles on one simulated line.

mod between;
mod medium;
mod modbus;
mod probes;
mod programs;
mod respect;
mod scan;
mod world;

use std::time::Duration;

use lafet_client::bus::{Change, Controller, ControllerConfig};
use lafet_client::session::{Outcome, Slot};
use lafet_proto::request::Body;
use lafet_proto::{RequestId, Status, SubsystemId};
use lafet_sim::line::Noise;
use world::{Bus, request, status_of_all};

const SECOND: Duration = Duration::from_secs(1);

fn first_status(outcome: &Outcome) -> Option<Status> {
    match outcome {
        Outcome::Answered(slots) => match slots.first()? {
            Slot::Answered(answers) => Some(answers.first().status()),
            _ => None,
        },
        _ => None,
    }
}

/// Everything a console has received, as text.
fn told(outcomes: &[Outcome]) -> Vec<String> {
    let slots = outcomes.iter().flat_map(|outcome| match outcome {
        Outcome::Answered(slots) => slots.iter(),
        other => panic!("{other:?}"),
    });
    slots
        .map(|slot| match slot {
            Slot::Answered(answers) => answers.first().decode().expect("an answer").to_string(),
            other => panic!("{other:?}"),
        })
        .collect()
}

#[test]
fn everybody_is_found_and_the_map_says_so() {
    let mut bus = Bus::new(115_200, 4, 2, Noise::default());
    bus.run(SECOND, |_| {});
    assert!(bus.controller.present().iter().eq([1, 2, 3, 4, 129, 130]));
    let changes: Vec<Change> = std::iter::from_fn(|| bus.controller.poll_change()).collect();
    assert_eq!(changes.len(), 6);
    assert_eq!(bus.line.collisions(), 0);
}

#[test]
fn a_console_speaks_when_it_has_access_and_is_answered() {
    let mut bus = Bus::new(115_200, 2, 2, Noise::default());
    bus.run(SECOND, |_| {});
    bus.ask(0, 2, request(Body::Deploy, SubsystemId::DEPLOYER));
    bus.ask(1, 1, status_of_all());
    bus.run(SECOND, |_| {});
    assert_eq!(first_status(&bus.consoles[0].outcomes[0]), Some(Status::ACCEPTED));
    assert_eq!(first_status(&bus.consoles[1].outcomes[0]), Some(Status::OK));
    assert_eq!(bus.line.collisions(), 0);
    let journal: Vec<_> = bus.controller.journal().lines().collect();
    assert_eq!(journal.len(), 1, "reading is not in it");
    let line = journal[0];
    assert_eq!((line.dst, line.src, line.request), (2, 129, RequestId::DEPLOY));
    let stats = bus.controller.stats();
    assert_eq!((stats.requests, stats.answers), (2, 2));
}

/// However many urgent frames the controller's own client has, each console has its turns, with a Stop
/// of its own among them.
#[test]
fn a_flood_of_stops_leaves_consoles_their_turns() {
    let stop = || request(Body::Stop, SubsystemId::ALL);
    let mut bus = Bus::new(19_200, 2, 3, Noise::default());
    bus.run(2 * SECOND, |_| {});
    bus.ask_own(1, stop());
    let mut floods = 0;
    let mut flood = |bus: &mut Bus| {
        bus.controller.set_urgent(true);
        if bus.own_outcomes.pop().is_some() {
            floods += 1;
            bus.ask_own(1, stop());
        }
    };
    bus.run(SECOND, &mut flood);
    for console in 0..3 {
        bus.ask(console, 2, stop());
    }
    bus.run(2 * SECOND, &mut flood);
    for console in &bus.consoles {
        assert_eq!(console.outcomes.iter().map(first_status).collect::<Vec<_>>().len(), 1);
        assert!(first_status(&console.outcomes[0]).is_some());
    }
    assert!(floods > 20, "{floods}");
}

/// A monitor that falls silent is tried three times, dropped, and found again when it is back.
#[test]
fn a_silent_monitor_is_dropped_and_found_again() {
    let mut bus = Bus::new(115_200, 2, 1, Noise::default());
    bus.run(SECOND, |_| {});
    while bus.controller.poll_change().is_some() {}
    bus.monitors[0].silent = true;
    bus.ask(0, 1, status_of_all());
    bus.run(2 * SECOND, |_| {});
    assert_eq!(bus.controller.poll_change(), Some(Change::Dropped(1)));
    assert_eq!(bus.controller.stats().repeated, 2);
    assert!(bus.controller.present().iter().eq([2, 129]));
    bus.ask(0, 2, status_of_all());
    bus.run(3 * SECOND, |_| {});
    assert!(bus.consoles[0].outcomes.iter().any(|o| first_status(o) == Some(Status::OK)));
    bus.monitors[0].silent = false;
    bus.run(3 * SECOND, |_| {});
    assert_eq!(bus.controller.poll_change(), Some(Change::Appeared(1)));
}

/// A console that is switched on late is found soon while the bus is idle, on any free address.
#[test]
fn whoever_comes_late_is_found() {
    let mut bus = Bus::new(19_200, 1, 2, Noise::default());
    bus.controller = Controller::new(ControllerConfig {
        turnaround: world::TURNAROUND,
        ..ControllerConfig::default()
    });
    bus.consoles[1].silent = true;
    bus.run(20 * SECOND, |_| {});
    assert!(bus.controller.present().iter().eq([1, 129]));
    bus.consoles[1].silent = false;
    bus.run(30 * SECOND, |_| {});
    assert!(bus.controller.present().iter().eq([1, 129, 130]));
    assert_eq!(bus.line.collisions(), 0);
}

/// §B/1: who is there, and what was asked, in the controller's own words.
#[test]
fn services() {
    let mut bus = Bus::new(19_200, 3, 1, Noise::default());
    bus.run(2 * SECOND, |_| {});
    bus.ask(0, 3, request(Body::Move { destination: 5 }, SubsystemId::VERTICAL));
    bus.run(SECOND, |_| {});
    bus.ask(0, 128, request(Body::GetNetworkStatus, SubsystemId::GENERAL));
    bus.ask(0, 128, request(Body::GetLog { first: 0, count: 10 }, SubsystemId::GENERAL));
    bus.ask(0, 128, request(Body::Deploy, SubsystemId::DEPLOYER));
    bus.run(2 * SECOND, |_| {});
    let told = told(&bus.consoles[0].outcomes);
    assert_eq!(told.len(), 4, "{told:?}");
    assert!(told[1].contains("[1, 2, 3, 129]"), "{}", told[1]);
    assert!(told[2].contains("Move"), "{}", told[2]);
    assert!(told[3].contains("WrongRequest"), "{}", told[3]);
}

/// Of the line that is polled, 8N1: ten bits a byte.
const BAUD: u32 = 115_200;

fn data_bytes(outcome: &Outcome) -> usize {
    let Outcome::Answered(slots) = outcome else { return 0 };
    let Some(Slot::Answered(answers)) = slots.first() else { return 0 };
    answers.iter().map(|answer| answer.data().len()).sum()
}

/// What was seen of some rounds in which every monitor is polled.
struct Polled {
    cycle: Duration,
    data_bytes: usize,
    share: f64,
}

/// The controller's own client polls all, while the first console asks whenever it has been answered.
fn poll(bus: &mut Bus, monitors: u8, rounds: u32) -> Polled {
    let (busy, from) = (bus.line.busy_ns(), bus.now());
    let (mut answered, mut data) = (0, 0);
    for _ in 0..rounds {
        for monitor in 1..=monitors {
            bus.ask_own(monitor, status_of_all());
        }
        while bus.own_outcomes.len() < monitors.into() {
            bus.run(Duration::from_millis(1), |_| {});
            if bus.consoles.first().is_some_and(|console| console.outcomes.len() == answered) {
                answered += 1;
                bus.ask(0, 7, status_of_all());
            }
        }
        data = bus.own_outcomes.iter().map(data_bytes).sum();
        assert!(bus.own_outcomes.drain(..).all(|o| first_status(&o) == Some(Status::OK)));
    }
    let time = bus.now() - from;
    let share = (bus.line.busy_ns() - busy) as f64 / time.as_nanos() as f64;
    Polled { cycle: time / rounds, data_bytes: data, share }
}

/// For `cargo xtask bench --only bus`: a round, the bytes that are sent in it, and how much of the
/// time of the next sender.
fn row(who: &str, cycle: Duration, share: f64) {
    let bytes = cycle.as_secs_f64() * share * f64::from(BAUD) / 10.0;
    let (ms, percent) = (cycle.as_secs_f64() * 1e3, 100.0 * share);
    println!("| {who} | {ms:.1} ms | {bytes:.0} | {percent:.1} % |");
}

/// Every monitor is polled by the controller's own client while consoles have their turns.
#[test]
fn thirty_two_monitors_and_three_consoles() {
    let mut bus = Bus::new(BAUD, 32, 3, Noise::default());
    bus.run(4 * SECOND, |_| {});
    assert_eq!(bus.controller.present().iter().count(), 35);
    let Polled { cycle, share, .. } = poll(&mut bus, 32, 10);
    row("lafet, with 3 consoles and their turns", cycle, share);
    assert!(share > 0.95 && cycle < SECOND, "{share} {cycle:?}");
    assert_eq!(bus.line.collisions(), 0);
}

/// The same bytes of state by one client alone, and by Modbus RTU, which has no consoles.
#[test]
fn thirty_two_monitors_beside_modbus() {
    let mut bus = Bus::new(BAUD, 32, 0, Noise::default());
    bus.run(4 * SECOND, |_| {});
    let lafet = poll(&mut bus, 32, 10);
    let registers = (lafet.data_bytes / 32).div_ceil(2);
    let modbus = modbus::poll(BAUD, 32, registers as u16, 10);
    row("lafet, without consoles", lafet.cycle, lafet.share);
    row("Modbus RTU (rmodbus), without consoles", modbus.cycle, modbus.share);
    assert!(2 * modbus.registers >= lafet.data_bytes);
    assert!(lafet.share > modbus.share);
}
