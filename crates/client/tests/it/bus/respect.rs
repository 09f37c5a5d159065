//! Where a controller orders the line: a direct client respects it from its first byte, and the doctor
//! finds nothing wrong with a healthy bus.

use std::time::Duration;

use lafet_client::bus::{ControllerConfig, Driver, DriverConfig};
use lafet_client::doctor::{Finding, Options, examine, findings};
use lafet_client::session::Outcome;
use lafet_client::session::Terms;
use lafet_client::session::line::Line;
use lafet_client::transport::Link;
use lafet_client::transport::memory::Memory;
use lafet_client::{Config, Endpoint};
use lafet_proto::SubsystemId;
use lafet_proto::bus::CONTROLLER;
use lafet_proto::request::Body;

use super::medium::{Medium, Program, Station, encoded};
use super::world::request;

const MS: Duration = Duration::from_millis(1);
const GRANT: [u8; 4] = [0xE6, 0xC2, 0, 0];

fn fresh() -> Line {
    let url: Endpoint = "serial:///x?addr=5".parse().unwrap();
    let mut line = Line::new(Config::default().of(&url));
    line.handle_connected(Duration::ZERO);
    line
}

#[test]
fn a_direct_client_listens_before_its_first_byte() {
    let moving = || vec![request(Body::Move { destination: 1 }, SubsystemId::VERTICAL)];
    let mut line = fresh();
    line.submit(MS, 5, Terms::default(), moving()).unwrap();
    assert_eq!(line.poll_transmit(MS), None);
    assert_eq!(line.poll_timeout(MS), Some(101 * MS));
    // A controller gives access to a device: nothing is sent.
    line.handle_bytes(60 * MS, &encoded(130, CONTROLLER, &GRANT));
    assert_eq!(line.poll_transmit(101 * MS), None);
    assert!(matches!(line.poll_outcome(), Some((_, Outcome::ControllerPresent))));
    // Silence: then it goes out, and what follows at once.
    let mut line = fresh();
    line.submit(MS, 5, Terms::default(), moving()).unwrap();
    assert_eq!(line.poll_transmit(MS), None);
    assert!(line.poll_transmit(101 * MS).is_some());
    // What stops waits for nothing.
    let mut line = fresh();
    line.submit(MS, 5, Terms::default(), vec![request(Body::Stop, SubsystemId::ALL)]).unwrap();
    assert!(line.poll_transmit(MS).is_some());
}

/// A line as a program has it that sends for as long as it runs.
fn heeding(url: &str) -> Line {
    let url: Endpoint = url.parse().unwrap();
    let mut line = Line::new(Config { heed: true, ..Config::default() }.of(&url));
    line.handle_connected(Duration::ZERO);
    line
}

fn ask(line: &mut Line, now: Duration, body: Body<'_>) {
    line.submit(now, 5, Terms::default(), vec![request(body, SubsystemId::GENERAL)]).unwrap();
}

/// Whether something is sent within what half a frame may keep the line, from this time on, ms.
fn is_sent_from(line: &mut Line, from: u32) -> bool {
    (from..from + 500).any(|ms| {
        line.handle_timeout(ms * MS);
        line.poll_transmit(ms * MS).is_some()
    })
}

#[test]
fn a_program_that_stays_listens_until_a_controller_would_have_been_heard() {
    let mut line = heeding("serial:///x?addr=5&late=0");
    ask(&mut line, MS, Body::GetStatus);
    assert_eq!(line.poll_transmit(MS), None);
    assert_eq!(line.poll_timeout(MS), Some(3001 * MS));
    assert!(line.poll_transmit(3001 * MS).is_some());
    // A monitor has answered: a link that is opened again is used soon.
    let answer = [0xD4, 0xC2, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    line.handle_bytes(3050 * MS, &encoded(129, 5, &answer));
    assert!(matches!(line.poll_outcome(), Some((_, Outcome::Answered(_)))));
    line.handle_disconnected(4000 * MS);
    line.handle_connected(5000 * MS);
    ask(&mut line, 5001 * MS, Body::GetStatus);
    assert_eq!(line.poll_transmit(5001 * MS), None);
    assert!(line.poll_transmit(5101 * MS).is_some());
    // Nor does noise hold it back any more.
    line.handle_disconnected(6000 * MS);
    line.handle_connected(6000 * MS);
    for ms in (6000..9000).step_by(20) {
        line.handle_bytes(ms * MS, &[0xF8, 0x80]);
    }
    while line.poll_outcome().is_some() {}
    ask(&mut line, 9000 * MS, Body::GetStatus);
    assert!(is_sent_from(&mut line, 9000));
}

#[test]
fn a_program_that_stays_sends_nothing_but_a_stop_beside_what_it_cannot_read() {
    let mut line = heeding("serial:///x?addr=5&late=0");
    // As a controller at another speed is heard that has no device to ask.
    for second in [1, 3, 5, 7, 9] {
        let now = second * 1000 * MS;
        line.handle_bytes(now, &[0x00, 0xF8, 0x80]);
        ask(&mut line, now + 10 * MS, Body::GetStatus);
        assert_eq!(line.poll_transmit(now + 900 * MS), None, "{second} s");
        let refused = line.poll_outcome().map(|(_, outcome)| outcome);
        assert_eq!(refused, (second > 1).then_some(Outcome::Unreadable), "{second} s");
        while line.poll_outcome().is_some() {}
    }
    // What waits for silence is refused when bytes go on, not when they end.
    let mut waiting = heeding("serial:///x?addr=5&late=0");
    ask(&mut waiting, MS, Body::GetStatus);
    assert_eq!(waiting.poll_transmit(MS), None);
    for second in [1, 3] {
        assert_eq!(waiting.poll_outcome(), None, "{second} s");
        waiting.handle_bytes(second * 1000 * MS, &[0xF8, 0x80]);
    }
    assert_eq!(waiting.poll_outcome().map(|(_, outcome)| outcome), Some(Outcome::Unreadable));
    ask(&mut line, 9901 * MS, Body::Stop);
    assert!(line.poll_transmit(9901 * MS).is_some());
    // They have gone.
    ask(&mut line, 15_000 * MS, Body::GetStatus);
    assert!(line.poll_transmit(15_000 * MS).is_some());
    // Who insists sends, and who is no program that stays does.
    for mut line in [heeding("serial:///x?addr=5&late=0&insist=1"), fresh()] {
        for ms in (0..3000).step_by(20) {
            line.handle_bytes(ms * MS, &[0xF8, 0x80]);
        }
        ask(&mut line, 3000 * MS, Body::GetStatus);
        assert!(is_sent_from(&mut line, 3000));
    }
}

/// Bytes that are no frames may be the first of many: what is asked after them is held back before
/// they have gone on for long enough to be refused, and the listening at the start is long over.
#[test]
fn the_first_bytes_that_are_no_frame_hold_back_a_program_that_stays() {
    for url in ["serial:///x?addr=5&late=0", "serial:///x?addr=5&late=0&src=128"] {
        let mut line = heeding(url);
        line.handle_timeout(MS);
        line.handle_bytes(5000 * MS, &[0xF8, 0x80]);
        ask(&mut line, 5010 * MS, Body::GetStatus);
        assert_eq!(line.poll_transmit(5900 * MS), None, "{url}");
        assert_eq!(line.poll_outcome(), None, "{url}");
        assert_eq!(line.poll_timeout(5900 * MS), Some(8000 * MS), "{url}");
        // They were the only ones.
        assert!(line.poll_transmit(8000 * MS).is_some(), "{url}");
    }
}

/// A line may float while nothing is sent, with good monitors on it.
#[test]
fn noise_keeps_a_program_from_its_monitors_for_half_a_minute_only() {
    let mut line = heeding("serial:///x?addr=5&late=0");
    let mut sent = Vec::new();
    for ms in (0..60_000).step_by(20) {
        line.handle_bytes(ms * MS, &[0xF8]);
        if ms % 200 == 0 {
            ask(&mut line, ms * MS, Body::GetStatus);
        }
        if line.poll_transmit((ms + 15) * MS).is_some() {
            sent.push(ms);
        }
        while line.poll_outcome().is_some() {}
    }
    assert!((30_000..31_000).contains(&sent[0]), "{sent:?}");
    assert!(sent.windows(2).all(|two| two[1] - two[0] >= 10_000), "{sent:?}");
    assert_eq!(sent.len(), 3, "{sent:?}");
}

/// Where a monitor has answered, a controller that only probes is beside us.
#[test]
fn a_controller_that_comes_later_does_not_end_the_work() {
    let mut line = heeding("serial:///x?addr=5&late=0");
    ask(&mut line, MS, Body::GetStatus);
    assert_eq!(line.poll_transmit(MS), None);
    assert!(line.poll_transmit(3001 * MS).is_some());
    let answer = [0xD4, 0xC2, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    line.handle_bytes(3050 * MS, &encoded(129, 5, &answer));
    while line.poll_outcome().is_some() {}
    line.handle_bytes(4000 * MS, &encoded(7, CONTROLLER, &[]));
    ask(&mut line, 4010 * MS, Body::GetStatus);
    assert!(is_sent_from(&mut line, 4010));
}

#[test]
fn a_controller_that_only_probes_holds_back_a_program_that_stays() {
    let mut line = heeding("serial:///x?addr=5&late=0");
    line.handle_bytes(2500 * MS, &encoded(7, CONTROLLER, &[]));
    ask(&mut line, 3100 * MS, Body::GetStatus);
    assert_eq!(line.poll_transmit(3100 * MS), None);
    assert_eq!(line.poll_outcome().map(|it| it.1), Some(Outcome::ControllerPresent));
    ask(&mut line, 3200 * MS, Body::Stop);
    assert!(line.poll_transmit(3200 * MS).is_some());
}

/// A monitor that answers GetStatus General, and what is none of its business not at all.
async fn monitor(own: u8, station: Station) {
    let mut line = Program::thorough(station);
    loop {
        let Some((dst, src, payload)) = line.frame(None).await else { return };
        if dst == own {
            let mut answer = payload.clone();
            if !payload.is_empty() {
                answer = vec![0xD4, 0xC2, 0, 10];
                answer.extend([0; 10]);
            }
            line.say(src, own, &answer).await;
        }
    }
}

/// What the doctor finds as a console of a bus with one line or two.
async fn found(two_lines: bool, addr: u8) -> Vec<Finding> {
    let monitors = Medium::new(19_200, 0, 1);
    let consoles = if two_lines { Medium::new(19_200, 0, 2) } else { monitors.clone() };
    for own in [4, 5] {
        tokio::spawn(monitor(own, monitors.station(false)));
    }
    let url = |name: &str| -> Endpoint { format!("serial:///{name}").parse().unwrap() };
    let lines = [monitors.clone(), consoles.clone()];
    let config = DriverConfig {
        controller: ControllerConfig {
            addresses: vec![4, 5, 6, 130, 131],
            turnaround: MS,
            watch: Some(Duration::from_secs(5)),
            ..ControllerConfig::default()
        },
        monitors: url("monitors"),
        consoles: two_lines.then(|| url("consoles")),
        programs: None,
    };
    let second = url("consoles");
    let mut driver = Driver::opening(config, move |endpoint| {
        let station = lines[usize::from(endpoint == second)].station(false);
        async move { Ok(Link::Memory(Memory::new(station))) }
    });
    tokio::spawn(async move { driver.run(|_| ()).await });
    let endpoint: Endpoint =
        format!("serial:///x?role=active&src=130&addr={addr}").parse().unwrap();
    let dial = async |_: &Endpoint| Ok(Link::Memory(Memory::new(consoles.station(false))));
    let evidence = examine(&endpoint, &Options::of(&endpoint), dial, |_| {}).await;
    findings(&evidence)
}

#[tokio::test(start_paused = true)]
async fn a_healthy_bus_is_called_healthy() {
    for two_lines in [false, true] {
        assert_eq!(found(two_lines, 5).await, [Finding::Well], "two lines: {two_lines}");
    }
    assert_eq!(found(true, 6).await, [Finding::MonitorSilent]);
}

#[tokio::test(start_paused = true)]
async fn a_console_without_a_controller() {
    let line = Medium::new(19_200, 0, 1);
    tokio::spawn(monitor(5, line.station(false)));
    let endpoint: Endpoint = "serial:///x?role=active&src=130&addr=5".parse().unwrap();
    let dial = async |_: &Endpoint| Ok(Link::Memory(Memory::new(line.station(false))));
    let evidence = examine(&endpoint, &Options::of(&endpoint), dial, |_| {}).await;
    assert_eq!(findings(&evidence), [Finding::NoAccess { controller: false }]);
    assert!(line.log().is_empty(), "and nothing was sent");
}
