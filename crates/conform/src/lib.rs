//! A conformance tester for robotic fire monitors: what the protocol says, asked over the wire.
//!
//! ```text
//! run ─▶ checks::* ─▶ Bench (one frame, one answer; what moves is watched; all is undone) ─▶ Line
//!  └──▶ Report ─▶ text, JSON, JUnit, HTML
//! ```
//!
//! It knows the monitor by its bytes only, and makes those itself ([`raw`]): no part of the monitor
//! or of the client that speaks to it is trusted.

mod bench;
mod checks;
pub mod line;
pub mod raw;
pub mod report;
mod run;
mod safety;
pub mod spec;
mod verdict;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use lafet_client::Framing;

pub use report::{Report, TestReport};
pub use run::{Progress, is_known, run, tests};
pub use verdict::{Note, Outcome};

/// What the tester may do to the monitor; each level includes those before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Reads, Stop, and frames that nobody may take for anything else.
    #[default]
    ReadOnly,
    /// Drives move a little and slowly, with the valves closed; parameters change and change back.
    Motion,
    /// Water, programs, searches, lockout and restart.
    Full,
    /// The memory is erased, and written back from a copy.
    Erase,
}

impl Level {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::ReadOnly, Self::Motion, Self::Full, Self::Erase];

    /// As the command line calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ReadOnly => "read-only",
            Self::Motion => "motion",
            Self::Full => "full",
            Self::Erase => "erase",
        }
    }
}

/// How to test.
#[derive(Clone, Debug)]
pub struct Options {
    /// What may be done.
    pub level: Level,
    /// What differs from a ruling of ours counts as failed too.
    pub strict: bool,
    /// End at the first failure.
    pub fail_fast: bool,
    /// Only the tests of these items (`§3.1` includes `§3.1/4`); empty: all.
    pub only: Vec<String>,
    /// The monitor's address.
    pub monitor: u8,
    /// The tester's.
    pub source: u8,
    /// What travels on the line.
    pub framing: Framing,
    /// How long to wait for an answer, ms of the monitor's clock.
    pub timeout_ms: u64,
    /// Set from outside to end: everything is stopped and put back first.
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
            interrupt: Arc::default(),
        }
    }
}

/// The examples of the README are compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
