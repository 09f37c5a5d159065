//! The right monitors: nothing in them fails, at any level, in any profile.

#[allow(dead_code, reason = "the wrong monitors need the rest")]
mod support;

use lafet_conform::{Level, Options, Outcome, Report, run};
use lafet_device::Source;
use lafet_device::port::Port;
use lafet_sim::sim::Sim;
use support::{Between, SimLine, monitor};

/// The monitor's own port: nothing is changed.
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
    let options = Options { level, strict: true, ..Options::default() };
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

#[test]
fn full() {
    passes("full");
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
