//! A conformance tester for robotic fire monitors: tests the statements of the protocol over the
//! wire.
//!
//! ```text
//! run ─▶ checks::* ─▶ Bench (one frame, one answer; what moves is watched; all is undone) ─▶ Line
//!  └──▶ Report ─▶ text, JSON, JUnit, HTML
//! ```
//!
//! It knows the monitor only by its bytes, and makes those itself ([`raw`]): it relies on no code
//! of the monitor or of the client.

mod bench;
mod checks;
pub mod line;
pub mod raw;
pub mod report;
mod run;
mod safety;
pub mod spec;
mod verdict;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use lafet_client::Framing;

pub use report::{Report, TestReport};
pub use run::{Progress, is_known, run, tests};
pub use verdict::{Note, Outcome};

/// What the tester may do to the monitor; each level includes the previous ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Reads, Stop, and frames that cannot be mistaken for commands.
    #[default]
    ReadOnly,
    /// Drives move a little and slowly, with the valves closed; parameters are changed and
    /// restored.
    Motion,
    /// Water, programs, searches, lockout and restart.
    Full,
    /// The memory is erased, and restored from a copy.
    Erase,
}

impl Level {
    /// All levels, in ascending order.
    pub const ALL: [Self; 4] = [Self::ReadOnly, Self::Motion, Self::Full, Self::Erase];

    /// Name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ReadOnly => "read-only",
            Self::Motion => "motion",
            Self::Full => "full",
            Self::Erase => "erase",
        }
    }
}

/// Settings of a run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Level that is permitted.
    pub level: Level,
    /// A difference from a ruling of ours counts as a failure too.
    pub strict: bool,
    /// End at the first failure.
    pub fail_fast: bool,
    /// Only the tests of these items (`§3.1` includes `§3.1/4`); if empty, all.
    pub only: Vec<String>,
    /// Address of the monitor, 1…127.
    pub monitor: u8,
    /// Address of the tester, 129…254.
    pub source: u8,
    /// Framing of the line: link frames or bare records.
    pub framing: Framing,
    /// How long to wait for an answer, ms of the monitor's clock.
    pub timeout_ms: u64,
    /// The board that images for this monitor name (§U), where it is known: without it, no header gets as far as
    /// its signature.
    pub board: Option<String>,
    /// Folder of the file with the stored parameters, as `lafet param restore` takes it, that there is
    /// while a test may erase them, and that stays when they could not be written back.
    pub keep_in: PathBuf,
    /// Set from outside to end the run; everything is stopped and restored first.
    pub interrupt: Arc<AtomicBool>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            level: Level::ReadOnly,
            strict: false,
            fail_fast: false,
            only: Vec::new(),
            monitor: 1,
            source: 0x81,
            framing: Framing::Link,
            timeout_ms: 1000,
            board: None,
            keep_in: std::env::temp_dir(),
            interrupt: Arc::default(),
        }
    }
}

/// The examples of the README are compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
