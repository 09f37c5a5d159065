//! An answer that breaks the protocol fails what asked for it, and the run goes on.

use lafet_conform::raw::{self, Rec};
use lafet_conform::{Level, Options, Outcome, Report, TestReport, run};
use lafet_proto::{RequestId as R, SubsystemId as S};
use lafet_sim::sim::Sim;

use crate::support::{Between, Frames, SimLine, ask, monitor};

/// Odd bytes of an answer: a record that is cut short.
const CUT: [u8; 6] = [0xD4, 0x5D, 0, 10, 1, 2];

/// A monitor some of whose answers are odd.
struct Odd<F> {
    frames: Frames,
    /// Whether the answer to this frame is odd.
    is_odd: F,
    /// Whether something was to move.
    moved: bool,
}

impl<F: FnMut(&[Rec]) -> bool> Between for Odd<F> {
    fn receive(&mut self, sim: &mut Sim, bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        for (src, payload) in self.frames.take(sim, bytes) {
            let asked = Rec::all(&payload).unwrap_or_default();
            self.moved |=
                asked.iter().any(|rec| [R::MOVE, R::OPEN, R::DEPLOY].contains(&rec.request));
            let answer = ask(sim, &payload);
            let odd = !asked.is_empty() && (self.is_odd)(&asked);
            let answer = if odd { CUT.to_vec() } else { answer };
            out.extend(raw::frame(src, sim.address(), &answer));
        }
        out
    }
}

fn tested(level: Level, is_odd: impl FnMut(&[Rec]) -> bool) -> (Report, Sim, bool) {
    let odd = Odd { frames: Frames::default(), is_odd, moved: false };
    let mut line = SimLine::new(monitor("full"), odd);
    let report = run(&mut line, &Options { level, ..Options::default() }, &mut |_| {});
    (report, line.sim, line.between.moved)
}

/// The test that failed for its odd answer, whose bytes it shows.
fn shown<'a>(report: &'a Report, name: &str) -> &'a TestReport {
    let test = report.tests.iter().find(|test| test.name == name).expect("it is listed");
    assert_eq!(test.outcome, Outcome::Fail, "{test:?}");
    let wire = raw::frame(0x81, 1, &CUT);
    assert!(test.log.iter().any(|exchange| exchange.received == wire), "{test:?}");
    test
}

#[test]
fn one_odd_answer_to_the_first_look_fails_that_look_alone() {
    let mut asked = 0;
    let (report, _, _) = tested(Level::ReadOnly, |_| {
        asked += 1;
        asked == 3
    });
    shown(&report, "first-look");
    assert_eq!((report.aborted.as_ref(), report.failures().count()), (None, 1));
    assert!(report.count(Outcome::Pass) > 50, "{}", report.count(Outcome::Pass));
    assert_eq!(report.exit_code(), 1);
}

/// Where the state of a drive is never readable, its rest cannot be seen: nothing is moved.
#[test]
fn a_state_that_cannot_be_read_leaves_the_reads() {
    let status =
        |rec: &Rec| rec.request == R::GET_STATUS && [S::ALL, S::VERTICAL].contains(&rec.device);
    let (report, _, moved) = tested(Level::Motion, |asked| asked.iter().any(status));
    let test = shown(&report, "first-look");
    assert_eq!(test.item, "§2");
    let looks = report.tests.iter().filter(|test| test.name == "first-look").count();
    assert_eq!(looks, 1, "the same mistake, however often it is made");
    assert_eq!(report.aborted, None);
    assert_eq!(report.not_restored, None);
    assert!(!moved, "it was moved");
    let motions = report.tests.iter().filter(|test| test.level == Level::Motion);
    let not = motions.filter(|test| test.outcome == Outcome::NotApplicable);
    assert!(
        not.clone().count() > 20 && not.clone().all(|test| test.found.en.contains("not tried"))
    );
    assert!(report.count(Outcome::Pass) > 20, "{}", report.count(Outcome::Pass));
}

/// What was slowed down before the odd answer gets its speed back.
#[test]
fn an_odd_answer_while_slowing_down_loses_no_speed() {
    let speed = |sim: &mut Sim| {
        let id = lafet_proto::ParamId::of("Speed").0.to_le_bytes();
        ask(sim, &Rec::new(R::GET_PARAM, S::HORIZONTAL, &id).bytes())
    };
    let before = speed(&mut monitor("full"));
    let set = |rec: &Rec| rec.request == R::SET_PARAM && rec.device == S::VERTICAL;
    let mut slowed = 0;
    let (report, mut sim, moved) = tested(Level::Motion, |asked| {
        slowed += usize::from(
            asked.iter().any(|rec| rec.request == R::SET_PARAM && rec.device == S::HORIZONTAL),
        );
        let odd = slowed == 1 && asked.iter().any(set);
        slowed += usize::from(odd);
        odd
    });
    shown(&report, "slow-down");
    assert_eq!((report.aborted.as_ref(), report.not_restored.as_ref()), (None, None));
    assert!(!moved && slowed >= 3, "{slowed}");
    assert_eq!(speed(&mut sim), before);
}
