//! The correct monitors: no test fails, at any level, in any profile.

use crate::support::{BOARD, Between, SimLine, UPDATED, monitor};
use lafet_conform::raw::{Rec, frame};
use lafet_conform::{Level, Options, Outcome, Report, TestReport, run};
use lafet_device::Source;
use lafet_device::port::Port;
use lafet_proto::{RequestId, Status, SubsystemId};
use lafet_sim::sim::Sim;

/// The monitor's own port, unchanged.
struct Plain(Port);

impl Plain {
    fn new() -> Self {
        Self(Port::new(Source::ExternalConn))
    }
}

impl Between for Plain {
    fn receive(&mut self, sim: &mut Sim, bytes: &[u8]) -> Vec<u8> {
        sim.receive(&mut self.0, bytes)
    }
}

fn tested(profile: &str, level: Level) -> Report {
    let mut line = SimLine::new(monitor(profile), Plain::new());
    let board = Some(BOARD.to_owned());
    let options = Options { level, board, strict: true, ..Options::default() };
    run(&mut line, &options, &mut |_| {})
}

fn passes(profile: &str) {
    for level in Level::ALL {
        let report = tested(profile, level);
        let bad: Vec<String> = report
            .tests
            .iter()
            .filter(|test| !matches!(test.outcome, Outcome::Pass | Outcome::NotApplicable))
            .map(|test| {
                let log = test.log.iter().rev().take(6);
                let log: Vec<String> =
                    log.map(|e| format!("      {} {}", e.at_ms, e.words)).collect();
                format!(
                    "  {} {}: expected {}; found {}\n{}",
                    test.item,
                    test.name,
                    test.expected.en,
                    test.found.en,
                    log.join("\n")
                )
            })
            .collect();
        println!(
            "{profile} {}: {} pass, {} n/a, {} frames, {} s",
            level.name(),
            report.count(Outcome::Pass),
            report.count(Outcome::NotApplicable),
            report.frames,
            report.took_ms / 1000
        );
        assert!(
            report.is_good(),
            "{profile} {}:\n{}\naborted {:?}, not restored {:?}",
            level.name(),
            bad.join("\n"),
            report.aborted,
            report.not_restored
        );
        assert!(report.count(Outcome::Pass) > 40);
    }
}

/// The read-only tests on a monitor that was locked out before.
fn locked_out(between: impl Between + 'static) -> Report {
    let mut sim = monitor("full");
    let key = [0xFA, 0x2F];
    let lockout = Rec::new(RequestId::LOCKOUT, SubsystemId::ALL, &key).bytes();
    let answer = sim.receive(&mut Port::new(Source::Radio), &frame(1, 0x81, &lockout));
    assert!(!answer.is_empty(), "no answer to Lockout");
    sim.advance_ms(5000);
    run(
        &mut SimLine::new(sim, between),
        &Options { strict: true, ..Options::default() },
        &mut |_| {},
    )
}

#[test]
fn a_monitor_that_is_locked_out_passes_its_reads() {
    let report = locked_out(Plain::new());
    let failed =
        |test: &&TestReport| !matches!(test.outcome, Outcome::Pass | Outcome::NotApplicable);
    let failed: Vec<&str> = report.tests.iter().filter(failed).map(|test| test.name).collect();
    assert!(report.is_good() && failed.is_empty(), "{failed:?}, aborted {:?}", report.aborted);
    assert!(report.count(Outcome::Pass) > 40);
    let of =
        |name: &str| report.tests.iter().find(|test| test.name == name).expect("a test").outcome;
    assert_eq!(of("stop-wrong-addressee"), Outcome::Pass);
    assert_eq!(of("stop-all-at-rest"), Outcome::NotApplicable);
}

/// Answers one Stop as if it were not locked out.
struct Careless(Plain);

impl Between for Careless {
    fn receive(&mut self, sim: &mut Sim, bytes: &[u8]) -> Vec<u8> {
        let stop = Rec::new(RequestId::STOP, SubsystemId::GENERAL, &[]).bytes();
        if bytes == frame(1, 0x81, &stop) {
            let refusal = [RequestId::STOP.0, SubsystemId::GENERAL.0, Status::WRONG_REQUEST.0, 0];
            return frame(0x81, 1, &refusal);
        }
        self.0.receive(sim, bytes)
    }
}

#[test]
fn a_lockout_that_lets_a_request_through_fails() {
    let report = locked_out(Careless(Plain::new()));
    let failed = report.tests.iter().filter(|test| test.outcome == Outcome::Fail);
    assert_eq!(failed.map(|test| test.name).collect::<Vec<_>>(), ["stop-wrong-addressee"]);
}

#[test]
fn full() {
    passes("full");
}

#[test]
fn updated() {
    passes(UPDATED);
}

#[test]
fn remote() {
    passes("remote");
}

#[test]
fn mini() {
    passes("mini");
}

#[test]
fn ex() {
    passes("ex");
}

#[test]
fn limit_switch() {
    passes("limit-switch");
}
