//! What a run has found, and how it is told: text, JSON, JUnit, HTML.

mod html;
mod text;

use lafet_proto::SubsystemId;

use crate::bench::Exchange;
use crate::spec::{Label, Unseen};
use crate::verdict::{Note, Outcome};
use crate::{Level, Options};

pub use html::html;
pub use text::{json, junit, summary, test_lines, text};

/// How a test ended.
#[derive(Clone, Debug)]
pub struct TestReport {
    /// Its name.
    pub name: &'static str,
    /// The item that it tests.
    pub item: &'static str,
    /// Whose statement it is.
    pub label: Label,
    /// The level it needs.
    pub level: Level,
    /// How it ended.
    pub outcome: Outcome,
    /// What should have been.
    pub expected: Note,
    /// What was, or why there is nothing to test.
    pub found: Note,
    /// What travelled.
    pub log: Vec<Exchange>,
    /// How long it took, ms of the monitor's clock.
    pub took_ms: u64,
}

/// What a run has found.
#[derive(Clone, Debug)]
pub struct Report {
    /// Which monitor: for people, whatever names it.
    pub url: String,
    /// What was allowed.
    pub level: Level,
    /// Differences from our rulings count as failures.
    pub strict: bool,
    /// Each test.
    pub tests: Vec<TestReport>,
    /// Subsystems of the monitor.
    pub present: Vec<SubsystemId>,
    /// Why it ended early.
    pub aborted: Option<Note>,
    /// What could not be put back.
    pub not_restored: Option<Note>,
    /// The way to it was lost at the end: what was started was not seen at rest.
    pub cut: bool,
    /// It never answered.
    pub unreachable: bool,
    /// Frames sent, and those repeated because no answer came.
    pub frames: u64,
    /// Frames repeated.
    pub repeats: u64,
    /// Time of the whole run, ms of the monitor's clock.
    pub took_ms: u64,
}

impl Report {
    /// An empty report.
    pub fn new(options: &Options) -> Self {
        Self {
            url: String::new(),
            level: options.level,
            strict: options.strict,
            tests: Vec::new(),
            present: Vec::new(),
            aborted: None,
            not_restored: None,
            cut: false,
            unreachable: false,
            frames: 0,
            repeats: 0,
            took_ms: 0,
        }
    }

    /// How many tests ended so.
    pub fn count(&self, outcome: Outcome) -> usize {
        self.tests.iter().filter(|test| test.outcome == outcome).count()
    }

    /// What failed; with --strict, what differs too.
    pub fn failures(&self) -> impl Iterator<Item = &TestReport> {
        self.tests.iter().filter(|test| match test.outcome {
            Outcome::Fail => true,
            Outcome::Differs => self.strict,
            Outcome::Pass | Outcome::NotApplicable => false,
        })
    }

    /// What no test can see, and why.
    pub fn unseen(&self) -> &'static [Unseen] {
        crate::spec::unseen()
    }

    /// Nothing failed, everything was tried and put back.
    pub fn is_good(&self) -> bool {
        self.failures().next().is_none() && self.aborted.is_none() && self.not_restored.is_none()
    }

    /// 0 nothing failed; 1 something did, or the run was broken off; 3 nobody answers; 4 it may still
    /// move or flow.
    pub fn exit_code(&self) -> u8 {
        match () {
            () if self.unreachable => 3,
            () if self.cut => 4,
            () if self.is_good() => 0,
            () => 1,
        }
    }
}
