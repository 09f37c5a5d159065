//! A run: inspects the monitor, executes the tests, restores everything.

use lafet_client::SystemError;
use lafet_texts::{Text as _, conform as text};
use std::sync::atomic::Ordering;

use crate::bench::Bench;
use crate::checks::{TESTS, Test};
use crate::line::Line;
use crate::report::{Report, TestReport};
use crate::spec::{self, Label};
use crate::verdict::{Halt, Note, Outcome};
use crate::{Level, Options};

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

/// Tests a monitor.
pub fn run(line: &mut dyn Line, options: &Options, see: &mut dyn FnMut(Progress<'_>)) -> Report {
    let mut bench = Bench::new(line, options);
    let mut report = Report::new(options);
    if let Err(halt) = bench.look().and_then(|()| bench.is_ready()) {
        report.unreachable = bench.found.present.is_empty() && !bench.was_answered;
        report.aborted = Some(told(&halt));
        if let Halt::Fail { expected, found } = halt
            && !report.unreachable
        {
            report.tests.push(first_look(&mut bench, expected, found));
        }
        finish(&mut report, &mut bench);
        return report;
    }
    let slowed = bench.slow_down();
    bench.log.clear();
    let chosen: Vec<&Test> = TESTS.iter().filter(|test| is_chosen(test, options)).collect();
    if let Err(halt) = &slowed {
        report.aborted = Some(told(halt));
    } else {
        for (index, test) in chosen.iter().enumerate() {
            let (number, of) = (index + 1, chosen.len());
            see(Progress::Begins { number, of, test: (test.name, test.item) });
            let (ended, halt) = one(&mut bench, test);
            see(Progress::Ended(&ended));
            let failed = ended.outcome == Outcome::Fail
                || (options.strict && ended.outcome == Outcome::Differs);
            report.tests.push(ended);
            report.aborted = halt;
            if report.aborted.is_some() || (failed && options.fail_fast) {
                break;
            }
        }
    }
    if options.level > Level::ReadOnly {
        see(Progress::PuttingBack);
        bench.log.clear();
        bench.undo.extend(slowed.unwrap_or_default());
        bench.dirty = true;
        let back = bench.put_back();
        let home = bench.return_home();
        let back = back.and(home);
        report.cut = matches!(back, Err(Halt::Link(_))) || (back.is_err() && bench.silent);
        report.not_restored = back.err().map(|halt| told(&halt));
    }
    finish(&mut report, &mut bench);
    report
}

/// A failure of the very first frame belongs to an item too: the one that the expectation names, or
/// else that of the status.
fn first_look(bench: &mut Bench<'_>, expected: Note, found: Note) -> TestReport {
    let named = expected.en.split_once(": ").and_then(|(id, _)| spec::item(id));
    let item = named.or_else(|| spec::item("§3.3"));
    TestReport {
        name: "first-look",
        item: item.map_or("§3.3", |item| item.id),
        label: item.map_or(Label::Read, |item| item.label),
        level: Level::ReadOnly,
        outcome: Outcome::Fail,
        expected,
        found,
        log: std::mem::take(&mut bench.log),
        took_ms: bench.now_ms(),
    }
}

fn finish(report: &mut Report, bench: &mut Bench<'_>) {
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
    let label = match test.ours {
        true => Label::Ours,
        false => spec::item(test.item).map_or(Label::Ours, |item| item.label),
    };
    let against = if label == Label::Read { Outcome::Fail } else { Outcome::Differs };
    let mut ended = TestReport {
        name: test.name,
        item: test.item,
        label,
        level: test.level,
        outcome: Outcome::Pass,
        expected: Note::default(),
        found: Note::default(),
        log: Vec::new(),
        took_ms: 0,
    };
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
            // An interrupt by the user is not a fault of the monitor.
            let wished = bench.options.interrupt.load(Ordering::Relaxed);
            ended.outcome = if wished { Outcome::NotApplicable } else { Outcome::Fail };
            ended.found = told(&halt);
            end = Some(told(&halt));
        }
    }
    if let Err(halt) = back {
        // What the test did cannot be undone: that is a failure whatever the rulings, and nothing
        // else is tried.
        end = Some(told(&halt));
        if ended.outcome != Outcome::Fail {
            ended.outcome = Outcome::Fail;
            ended.expected = text::AsBeforeTheTest.words();
            ended.found = told(&halt);
        }
    }
    ended.log = std::mem::take(&mut bench.log);
    ended.took_ms = bench.now_ms() - began_ms;
    (ended, end)
}

fn told(halt: &Halt) -> Note {
    match halt {
        Halt::Abort(note) | Halt::NotApplicable(note) => note.clone(),
        Halt::Link(error) => text::LinkFailed { error: SystemError(error) }.words(),
        Halt::Fail { expected, found } => text::ExpectedAndFound { expected, found }.words(),
    }
}
