//! A real monitor over a radio channel that is slow, half duplex and loses packets, on virtual time.

use std::time::Duration;

use lafet_client::session::line::Line;
use lafet_client::session::{Outcome, Slot, Terms, Ticket};
use lafet_client::{Addresses, CheckMode, Config, RequestBuf};
use lafet_device::Source;
use lafet_device::port::Port;
use lafet_proto::answer::Reply;
use lafet_proto::request::Body;
use lafet_proto::{Ints, ParamId, Request, SubsystemId};
use lafet_sim::radio::{Radio, RadioConfig, Station};
use lafet_sim::sim::{self, Sim};

/// Two consoles and a monitor with its modem.
struct World {
    now_us: u64,
    radio: Radio,
    sim: Sim,
    port: Port,
    monitor: Station,
    consoles: Vec<(Station, Line)>,
}

impl World {
    fn new(config: RadioConfig, check: CheckMode, seed: u32) -> Self {
        let mut radio = Radio::new(config, seed.into());
        let monitor = radio.join();
        let consoles = [129, 130].map(|source| {
            let addresses = Addresses { monitor: 1, source };
            let timeout = Duration::from_secs(3);
            let first_number = Some(seed);
            let config = Config { addresses, timeout, check, first_number, ..Config::default() };
            let mut line = Line::new(config);
            line.handle_connected(Duration::ZERO);
            (radio.join(), line)
        });
        let mut sim = Sim::new(sim::Config::default());
        sim.advance_ms(200);
        let port = Port::new(Source::Radio);
        Self { now_us: 0, radio, sim, port, monitor, consoles: consoles.into() }
    }

    fn now(&self) -> Duration {
        Duration::from_micros(self.now_us)
    }

    fn ask(&mut self, console: usize, to: SubsystemId, body: Body<'_>) -> Ticket {
        let request = RequestBuf::new(&Request::new(to, body)).unwrap();
        let now = self.now();
        self.consoles[console].1.submit(now, 1, Terms::default(), vec![request]).unwrap()
    }

    /// Runs until all of these have ended.
    fn end(&mut self, tickets: &[(usize, Ticket)]) -> Vec<Outcome> {
        let mut ends = vec![None; tickets.len()];
        for _ in 0..100_000 {
            let now = self.now();
            for (index, (station, line)) in self.consoles.iter_mut().enumerate() {
                while let Some(bytes) = line.poll_transmit(now) {
                    self.radio.send(*station, self.now_us, &bytes);
                }
                while let Some((ticket, outcome)) = line.poll_outcome() {
                    if let Some(at) = tickets.iter().position(|known| *known == (index, ticket)) {
                        ends[at] = Some(outcome);
                    }
                }
            }
            if ends.iter().all(Option::is_some) {
                return ends.into_iter().flatten().collect();
            }
            self.advance();
        }
        panic!("it never ended");
    }

    fn advance(&mut self) {
        let now = self.now();
        let timers = self.consoles.iter().filter_map(|(_, line)| line.poll_timeout(now));
        let timers = timers.map(|time| time.as_micros() as u64 + 1);
        let next = timers.chain(self.radio.next_us()).min().expect("a waiter");
        self.now_us = self.now_us.max(next);
        let passed_ms = self.now_us / 1000 - self.sim.now_ms().min(self.now_us / 1000);
        self.sim.advance_ms(passed_ms);
        while let Some((to, bytes)) = self.radio.poll(self.now_us) {
            if to == self.monitor {
                let answers = self.sim.receive(&mut self.port, &bytes);
                if !answers.is_empty() {
                    self.radio.send(to, self.now_us, &answers);
                }
            }
            let now = Duration::from_micros(self.now_us);
            let console = self.consoles.iter_mut().find(|(station, _)| *station == to);
            if let Some((_, line)) = console {
                line.handle_bytes(now, &bytes);
            }
        }
    }
}

const PARAM: ParamId = ParamId::of("MoveTimeout");

fn value(outcome: &Outcome) -> Option<i32> {
    let Outcome::Answered(slots) = outcome else { return None };
    let Some(Slot::Answered(answers)) = slots.first() else { return None };
    match answers.first().decode().ok()?.data {
        Reply::Param { values, .. } => values.iter().next(),
        _ => None,
    }
}

/// Two consoles read and write over a bad channel: what is read is what was written last. In how
/// many rounds both used a CRC-32C.
fn run(config: RadioConfig, check: CheckMode, seed: u32, rounds: i32) -> (World, u32) {
    let mut world = World::new(config, check, seed);
    let (mut certain, mut read, mut both) = (0, 0, 0);
    for n in 0..rounds {
        let wanted = 1000 + n;
        let values = [wanted];
        let body = Body::SetParam { id: PARAM, values: Ints::Values(&values) };
        let set = world.ask(0, SubsystemId::GENERAL, body);
        // The other one speaks when it likes; within 3 ms neither hears the other.
        world.end(&[]);
        world.now_us += (n as u64 % 8) * 2_000;
        let other = world.ask(1, SubsystemId::VERTICAL, Body::GetStatus);
        let ends = world.end(&[(0, set), (1, other)]);
        let applied = matches!(ends[0], Outcome::Answered(_));
        let get = world.ask(1, SubsystemId::GENERAL, Body::GetParam { id: PARAM });
        let got = value(&world.end(&[(1, get)])[0]);
        certain += u32::from(applied);
        both += u32::from(world.consoles.iter().all(|(_, line)| line.total().crc32c == 1));
        if let Some(got) = got {
            read += 1;
            // Without an answer it may have been executed or not; never is anything else read.
            assert!(got == wanted || (!applied && got < wanted), "{got} instead of {wanted}");
        }
    }
    let all = rounds as u32;
    assert!(certain * 2 >= all && read * 10 >= all * 8, "{certain}, {read} of {all}");
    (world, both)
}

#[test]
fn a_channel_that_loses_packets() {
    let config = RadioConfig { latency_ms: 150, loss: 0.1, ..RadioConfig::default() };
    let (world, _) = run(config, CheckMode::Crc16, 11, 200);
    let stats = world.radio.stats();
    assert!(stats.lost > 50 && stats.collided > 0, "{stats:?}");
    assert!(world.consoles[1].1.total().retries > 10);
}

#[test]
fn a_noisy_channel_with_a_crc32c() {
    let config = RadioConfig { bit_error_rate: 1e-4, loss: 0.02, ..RadioConfig::default() };
    for seed in 0..20 {
        // A probe that is lost, after requests without answer, costs the CRC-32C a second or more.
        let (_, both) = run(config, CheckMode::Auto, seed, 100);
        assert!(both >= 70, "seed {seed}: {both} of 100");
    }
}

/// A Stop comes through a channel that loses a third of all packets: of its seven tries within 9 s,
/// one and its answer get through in 98 of 100 cases.
#[test]
fn a_stop_comes_through() {
    let config = RadioConfig { latency_ms: 100, loss: 0.33, ..RadioConfig::default() };
    let mut world = World::new(config, CheckMode::Crc16, 11);
    let (mut longest, mut answered) = (Duration::ZERO, 0);
    for _ in 0..50 {
        let began = world.now();
        let stop = world.ask(0, SubsystemId::ALL, Body::Stop);
        if matches!(world.end(&[(0, stop)])[0], Outcome::Answered(_)) {
            answered += 1;
            longest = longest.max(world.now() - began);
        }
    }
    assert!(answered >= 47, "{answered} of 50");
    assert!(longest < Duration::from_secs(9), "{longest:?}");
}
