//! The results of a run, and their forms: text, JSON, JUnit, HTML.

mod html;
mod text;

use lafet_proto::SubsystemId;

use crate::bench::Exchange;
use crate::spec::{Label, Unseen};
use crate::verdict::{Note, Outcome};
use crate::{Level, Options};

pub use html::html;
pub use text::{json, junit, summary, test_lines, text};

/// Result of a test.
#[derive(Clone, Debug)]
pub struct TestReport {
    /// Name of the test.
    pub name: &'static str,
    /// Item that it tests.
    pub item: &'static str,
    /// Source of the item.
    pub label: Label,
    /// Level that it needs.
    pub level: Level,
    /// Outcome of the test.
    pub outcome: Outcome,
    /// What the item requires.
    pub expected: Note,
    /// What was observed, or why there is nothing to test.
    pub found: Note,
    /// Exchanges with the monitor.
    pub log: Vec<Exchange>,
    /// Duration, ms of the monitor's clock.
    pub took_ms: u64,
}

/// Results of a run.
#[derive(Clone, Debug)]
pub struct Report {
    /// The monitor: its URL or another name for the user.
    pub url: String,
    /// Level that was permitted.
    pub level: Level,
    /// Differences from our rulings count as failures.
    pub strict: bool,
    /// Results of the tests, in order of execution.
    pub tests: Vec<TestReport>,
    /// Subsystems of the monitor.
    pub present: Vec<SubsystemId>,
    /// Why the run ended early.
    pub aborted: Option<Note>,
    /// What could not be restored.
    pub not_restored: Option<Note>,
    /// The connection was lost at the end: what was started was not seen at rest.
    pub cut: bool,
    /// The monitor never answered.
    pub unreachable: bool,
    /// Number of frames sent, including those repeated.
    pub frames: u64,
    /// Number of frames repeated because no answer came.
    pub repeats: u64,
    /// Duration of the run, ms of the monitor's clock.
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

    /// Number of tests with this outcome.
    pub fn count(&self, outcome: Outcome) -> usize {
        self.tests.iter().filter(|test| test.outcome == outcome).count()
    }

    /// Failed tests; with --strict, also those that differ.
    pub fn failures(&self) -> impl Iterator<Item = &TestReport> {
        self.tests.iter().filter(|test| match test.outcome {
            Outcome::Fail => true,
            Outcome::Differs => self.strict,
            Outcome::Pass | Outcome::NotApplicable => false,
        })
    }

    /// Items that no test can observe, and why.
    pub fn unseen(&self) -> &'static [Unseen] {
        crate::spec::unseen()
    }

    /// Whether nothing failed, and everything was tried and restored.
    pub fn is_good(&self) -> bool {
        self.failures().next().is_none() && self.aborted.is_none() && self.not_restored.is_none()
    }

    /// 0 nothing failed; 1 a test failed, or the run was broken off; 3 no answer; 4 it may still
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
