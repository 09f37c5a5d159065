//! What the tests of the update (§U) must not do: no update is started, committed or disturbed by them.

use lafet_conform::raw::Rec;
use lafet_conform::{Level, Outcome, Report};
use lafet_proto::flags::GeneralFlags;
use lafet_proto::id::key;
use lafet_proto::{RequestId as R, Status, SubsystemId as S};
use lafet_sim::sim::Sim;

use crate::harm::tested;
use crate::support::{UPDATED, monitor};
use crate::wrong::{each, flags, pass, secretly};

/// The report of the monitor but for the reason of the last order.
fn state(sim: &mut Sim) -> Vec<u8> {
    let mut answers = secretly(sim, R::UPDATE, S::GENERAL, &[0]);
    let mut rec = answers.pop().expect("an answer");
    assert_eq!((rec.status, rec.data.len()), (Status::OK, 24), "{rec:?}");
    rec.data[3] = 0;
    rec.data
}

fn is_locked(sim: &mut Sim) -> bool {
    flags(sim, S::GENERAL) & GeneralFlags::LOCKED_OUT.bits() != 0
}

/// The orders to General but the state.
fn orders(asked: &[Rec]) -> impl Iterator<Item = u8> + '_ {
    let updates = asked.iter().filter(|it| it.request == R::UPDATE && it.device == S::GENERAL);
    updates.filter_map(|it| it.data.first().copied()).filter(|kind| *kind > 0)
}

fn outcome(report: &Report, name: &str) -> Outcome {
    report.tests.iter().find(|test| test.name == name).expect("a test").outcome
}

#[test]
fn the_software_is_as_it_was_found() {
    let mut sim = monitor(UPDATED);
    let (before, running) = (state(&mut sim), sim.running());
    let mut phases = Vec::new();
    let (report, mut sim) = tested(sim, Level::Full, "§U", |sim, asked| {
        let answers = pass(sim, asked);
        let reports = answers.iter().filter(|it| it.request == R::UPDATE && it.data.len() == 24);
        phases.extend(reports.map(|it| it.data[0]));
        Some(answers)
    });
    let failed: Vec<_> = report.failures().map(|it| (it.name, it.found.en.clone())).collect();
    assert!(report.is_good(), "{failed:?} {:?} {:?}", report.aborted, report.not_restored);
    assert!(phases.len() > 100 && phases.iter().all(|phase| *phase == 0), "{phases:?}");
    assert_eq!((state(&mut sim), sim.running()), (before, running));
    assert!(!is_locked(&mut sim));
    let passed = report.tests.iter().filter(|test| test.outcome == Outcome::Pass);
    assert_eq!(passed.count(), 12, "all but those of a monitor without it");
}

/// Without the name of its board, a header of another one is all that can be tried.
#[test]
fn a_monitor_without_it() {
    let (report, _) =
        tested(monitor("full"), Level::Full, "§U", |sim, asked| Some(pass(sim, asked)));
    assert!(report.is_good(), "{:?}", report.aborted);
    let (passes, not) = (report.count(Outcome::Pass), report.count(Outcome::NotApplicable));
    assert_eq!((passes, not), (2, 12));
    assert_eq!(outcome(&report, "update-absent-locked-out"), Outcome::Pass);
}

#[test]
fn a_lockout_that_was_there_is_kept() {
    let mut sim = monitor(UPDATED);
    secretly(&mut sim, R::LOCKOUT, S::ALL, &key::ENABLE.to_le_bytes());
    sim.advance_ms(5000);
    let before = state(&mut sim);
    let (report, mut sim) =
        tested(sim, Level::ReadOnly, "§U", |sim, asked| Some(pass(sim, asked)));
    assert!(report.is_good(), "{:?}", report.failures().map(|it| it.name).collect::<Vec<_>>());
    assert!(is_locked(&mut sim));
    assert_eq!(state(&mut sim), before);
    assert_eq!(outcome(&report, "update-key"), Outcome::Pass);
    assert_eq!(outcome(&report, "update-not-locked-out"), Outcome::NotApplicable);
}

/// Another program has started one: only its state is asked for.
#[test]
fn an_update_under_way_is_left_alone() {
    for (at, value) in [(0, 1), (0, 3), (2, 1), (2, 8)] {
        let mut sent = Vec::new();
        let (report, _) = tested(monitor(UPDATED), Level::Full, "§U", |sim, asked| {
            sent.extend(orders(asked));
            let mut answers = pass(sim, asked);
            each(&mut answers, R::UPDATE, |rec| {
                if rec.data.len() == 24 {
                    (rec.data[at], rec.data[8]) = (value, 16);
                }
            });
            Some(answers)
        });
        assert!(sent.is_empty(), "{at} {value}: {sent:?}");
        assert_eq!(outcome(&report, "update-headers"), Outcome::NotApplicable);
    }
}

/// A monitor that starts an update with any header gets no data, and no order to verify or commit them.
#[test]
fn what_was_started_by_mistake_is_not_committed() {
    let (mut started, mut after) = (false, Vec::new());
    let (report, mut sim) = tested(monitor(UPDATED), Level::Full, "§U", |sim, asked| {
        if started {
            after.extend(orders(asked));
        }
        let mut answers = pass(sim, asked);
        let accepted = answers.iter().any(|it| it.status == Status::ACCEPTED);
        started |= orders(asked).any(|kind| kind == 1) && accepted;
        if started {
            each(&mut answers, R::UPDATE, |rec| {
                if rec.data.len() == 24 {
                    (rec.data[0], rec.data[3], rec.data[8]) = (1, 0, 8);
                }
            });
        }
        Some(answers)
    });
    assert!(started, "no header was sent");
    assert_eq!(outcome(&report, "update-headers"), Outcome::Differs);
    assert!(after.is_empty(), "{after:?}");
    assert!(!is_locked(&mut sim));
}
