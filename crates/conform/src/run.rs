//! A run: inspects the monitor, executes the tests, restores everything.

use lafet_client::SystemError;
use lafet_texts::{Text as _, conform as text};
use std::sync::atomic::Ordering;

use crate::bench::Bench;
use crate::checks::{TESTS, Test};
use crate::line::Line;
use crate::report::{Report, TestReport};
use crate::safety::{Odd, Undo};
use crate::spec::{self, Label};
use crate::verdict::{Halt, Note, Outcome};
use crate::{Level, Options};

/// How often the monitor is looked at if its answers break the protocol.
const LOOKS: u32 = 2;
/// Names and items of what is done before the first test.
const FIRST_LOOK: (&str, &str) = ("first-look", "§3.3");
const SLOW_DOWN: (&str, &str) = ("slow-down", "§3.5");

/// Progress of a run.
#[derive(Clone, Copy, Debug)]
pub enum Progress<'a> {
    /// A test begins.
    Begins {
        /// Number of the test, from 1.
        number: usize,
        /// Number of tests.
        of: usize,
        /// Name and item of the test.
        test: (&'a str, &'a str),
    },
    /// A test has ended.
    Ended(&'a TestReport),
    /// Everything is being restored.
    PuttingBack,
}

/// Tests a monitor. An answer that breaks the protocol fails what asked for it, and the run goes on.
pub fn run(line: &mut dyn Line, options: &Options, see: &mut dyn FnMut(Progress<'_>)) -> Report {
    let reads = Options { level: Level::ReadOnly, ..options.clone() };
    let mut bench = Bench::new(line, options);
    let mut report = Report::new(options);
    let looked = first_look(&mut bench, &mut report);
    let mut slowed = Vec::new();
    if looked.is_ok() && !bench.blind {
        slow_down(&mut bench, &mut slowed, &mut report);
    }
    report.tests.iter().for_each(|test| see(Progress::Ended(test)));
    if looked.is_err() || report.aborted.is_some() && slowed.is_empty() {
        finish(&mut report, &mut bench);
        return report;
    }
    if bench.blind {
        bench.options = &reads;
    }
    bench.log.clear();
    if report.aborted.is_none() && !(options.fail_fast && report.failures().next().is_some()) {
        all(&mut bench, options, &mut report, see);
    }
    if bench.options.level > Level::ReadOnly || !slowed.is_empty() {
        see(Progress::PuttingBack);
        restore(&mut bench, slowed, &mut report);
    }
    finish(&mut report, &mut bench);
    report
}

/// Looks at the monitor, once more if an answer breaks the protocol. If one does so again, the monitor
/// cannot be seen to be at rest: only reads are tested.
fn first_look(bench: &mut Bench<'_>, report: &mut Report) -> Result<(), ()> {
    for _ in 0..LOOKS {
        let (began_ms, mut odd) = (bench.now_ms(), Vec::new());
        let looked = bench.look(&mut odd);
        bench.blind = !odd.is_empty();
        let took_ms = bench.now_ms() - began_ms;
        for odd in odd {
            // A mistake of every answer is one failure, with the bytes of the first.
            let failed = failed(FIRST_LOOK, odd, took_ms);
            if report.tests.iter().all(|test| test.item != failed.item) {
                report.tests.push(failed);
            }
        }
        if let Err(halt) = looked {
            report.unreachable = bench.found.present.is_empty() && !bench.was_answered;
            report.aborted = Some(told(&halt));
            return Err(());
        }
        if !bench.blind {
            break;
        }
    }
    Ok(())
}

/// Slows the drives down. Where an answer breaks the protocol, they are not moved.
fn slow_down(bench: &mut Bench<'_>, slowed: &mut Vec<Undo>, report: &mut Report) {
    let began_ms = bench.now_ms();
    bench.log.clear();
    match bench.slow_down(slowed) {
        Ok(()) => {}
        Err(Halt::Fail { expected, found }) => {
            bench.blind = true;
            let (log, silent) = (std::mem::take(&mut bench.log), bench.silent);
            let odd = Odd { expected, found, log, silent };
            report.tests.push(failed(SLOW_DOWN, odd, bench.now_ms() - began_ms));
        }
        Err(halt) => report.aborted = Some(told(&halt)),
    }
}

/// Executes the chosen tests; those that are not executed because the monitor is not moved are listed.
fn all(
    bench: &mut Bench<'_>,
    options: &Options,
    report: &mut Report,
    see: &mut dyn FnMut(Progress<'_>),
) {
    let chosen = TESTS.iter().filter(|test| is_chosen(test, options));
    let (now, not): (Vec<&Test>, Vec<_>) =
        chosen.partition(|test| test.level <= bench.options.level);
    for (index, test) in now.iter().enumerate() {
        let (number, of) = (index + 1, now.len());
        see(Progress::Begins { number, of, test: (test.name, test.item) });
        let (ended, halt) = one(bench, test);
        see(Progress::Ended(&ended));
        let failed =
            ended.outcome == Outcome::Fail || (options.strict && ended.outcome == Outcome::Differs);
        report.tests.push(ended);
        report.aborted = halt;
        if report.aborted.is_some() || (failed && options.fail_fast) {
            return;
        }
    }
    for test in not {
        let found = text::NotMoved.words();
        let skipped = TestReport { outcome: Outcome::NotApplicable, found, ..blank(test) };
        see(Progress::Ended(&skipped));
        report.tests.push(skipped);
    }
}

/// Restores what was changed. The barrel returns while the drives are still slowed down, and is left where it
/// is if anything speaks against a motion.
fn restore(bench: &mut Bench<'_>, slowed: Vec<Undo>, report: &mut Report) {
    bench.log.clear();
    bench.dirty = true;
    let stays = bench.no_motion || bench.options.interrupt.load(Ordering::Relaxed);
    let home = bench.put_back().and_then(|()| match bench.options.level {
        Level::ReadOnly => Ok(()),
        _ if stays => bench.left(),
        _ => bench.return_home(),
    });
    bench.undo.extend(slowed);
    let back = home.and(bench.put_back());
    report.cut = matches!(back, Err(Halt::Link(_))) || (back.is_err() && bench.silent);
    report.not_restored = back.err().map(|halt| told(&halt));
}

/// A failure outside of the tests belongs to an item too: the one that the expectation names, or else
/// the usual one.
fn failed((name, usual): (&'static str, &'static str), odd: Odd, took_ms: u64) -> TestReport {
    let Odd { expected, found, log, .. } = odd;
    let named = expected.en.split_once(": ").and_then(|(id, _)| spec::item(id));
    let item = named.or_else(|| spec::item(usual));
    TestReport {
        name,
        item: item.map_or(usual, |item| item.id),
        label: item.map_or(Label::Read, |item| item.label),
        level: Level::ReadOnly,
        outcome: Outcome::Fail,
        expected,
        found,
        log,
        took_ms,
    }
}

/// A test that passes, without exchanges.
fn blank(test: &Test) -> TestReport {
    let label = match test.ours {
        true => Label::Ours,
        false => spec::item(test.item).map_or(Label::Ours, |item| item.label),
    };
    TestReport {
        name: test.name,
        item: test.item,
        label,
        level: test.level,
        outcome: Outcome::Pass,
        expected: Note::default(),
        found: Note::default(),
        log: Vec::new(),
        took_ms: 0,
    }
}

fn finish(report: &mut Report, bench: &mut Bench<'_>) {
    bench.stop_if_given_up();
    report.present.clone_from(&bench.found.present);
    report.frames = bench.frames;
    report.repeats = bench.repeats;
    report.took_ms = bench.now_ms();
}

/// Every test: its item, its name, and the level that it needs.
pub fn tests() -> impl Iterator<Item = (&'static str, &'static str, Level)> {
    TESTS.iter().map(|test| (test.item, test.name, test.level))
}

/// Whether there is a test of this name, or of this item.
pub fn is_known(id: &str) -> bool {
    TESTS.iter().any(|test| is_within(test, id))
}

fn is_within(test: &Test, id: &str) -> bool {
    let of_item = |rest: &str| rest.is_empty() || rest.starts_with(['.', '/']);
    test.name == id || test.item.strip_prefix(id).is_some_and(of_item)
}

fn is_chosen(test: &Test, options: &Options) -> bool {
    let chosen = options.only.is_empty() || options.only.iter().any(|id| is_within(test, id));
    test.level <= options.level && chosen
}

/// Runs a test and undoes it. The second value, if any, ends the run.
fn one(bench: &mut Bench<'_>, test: &Test) -> (TestReport, Option<Note>) {
    bench.log.clear();
    let began_ms = bench.now_ms();
    let result = (test.run)(bench).and_then(|()| bench.watch());
    let back = bench.put_back();
    let mut ended = blank(test);
    let against = if ended.label == Label::Read { Outcome::Fail } else { Outcome::Differs };
    let mut end = None;
    match result {
        Ok(()) => {}
        Err(Halt::NotApplicable(why)) => {
            ended.outcome = Outcome::NotApplicable;
            ended.found = why;
        }
        Err(Halt::Fail { expected, found }) => {
            ended.outcome = against;
            (ended.expected, ended.found) = (expected, found);
        }
        Err(halt) => {
            bench.no_motion |= matches!(halt, Halt::Abort(_));
            // An interrupt by the user is not a fault of the monitor.
            let wished = bench.options.interrupt.load(Ordering::Relaxed);
            ended.outcome = if wished { Outcome::NotApplicable } else { Outcome::Fail };
            ended.found = told(&halt);
            end = Some(told(&halt));
        }
    }
    if let Err(halt) = back {
        // What the test did cannot be undone: that is a failure whatever the rulings, and nothing
        // else is tried. Where nothing is moved, an answer that breaks the protocol ends nothing.
        let odd = matches!(halt, Halt::Fail { .. }) && bench.options.level == Level::ReadOnly;
        if !odd {
            end = Some(told(&halt));
            bench.no_motion = true;
        }
        if ended.outcome != Outcome::Fail {
            ended.outcome = Outcome::Fail;
            ended.expected = text::AsBeforeTheTest.words();
            ended.found = told(&halt);
        }
    }
    ended.log = std::mem::take(&mut bench.log);
    ended.took_ms = bench.now_ms() - began_ms;
    // What a lockout by others refuses fails a test. What the test has locked out is released by now.
    let failed = matches!(ended.outcome, Outcome::Fail | Outcome::Differs);
    if failed
        && end.is_none()
        && bench.options.level > Level::ReadOnly
        && let Err(halt @ Halt::Abort(_)) = bench.unlocked()
    {
        bench.no_motion = true;
        end = Some(told(&halt));
    }
    (ended, end)
}

fn told(halt: &Halt) -> Note {
    match halt {
        Halt::Abort(note) | Halt::NotApplicable(note) => note.clone(),
        Halt::Link(error) => text::LinkFailed { error: SystemError(error) }.words(),
        Halt::Fail { expected, found } => text::ExpectedAndFound { expected, found }.words(),
    }
}
