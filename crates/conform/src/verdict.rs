//! Outcome of a test.

use std::io;

use lafet_texts::{Shown, Text};

/// A sentence in every language.
pub use lafet_texts::Words as Note;

/// Why a test ends early.
#[derive(Debug)]
pub enum Halt {
    /// The monitor did not do what the item says.
    Fail {
        /// What the item requires.
        expected: Note,
        /// What was observed.
        found: Note,
    },
    /// This monitor has nothing to test here.
    NotApplicable(Note),
    /// Nothing more may be tried: something moves that should not, or the user ended the run.
    Abort(Note),
    /// The link has failed.
    Link(io::Error),
}

/// Result of a step of a test.
pub type Step<T = ()> = Result<T, Halt>;

/// Outcome of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// As the item requires.
    Pass,
    /// Not as the item requires.
    Fail,
    /// Not as ruled by us where the document is silent.
    Differs,
    /// Nothing to test on this monitor.
    NotApplicable,
}

impl Outcome {
    /// One-word name, for programs and tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Differs => "differs",
            Self::NotApplicable => "n/a",
        }
    }
}

/// Ends the test as a failure.
pub fn fail<T>(expected: impl Text, found: impl Text) -> Step<T> {
    Err(Halt::Fail { expected: expected.words(), found: found.words() })
}

/// Fails unless the condition holds.
pub fn must(so: bool, expected: impl Text, found: impl Into<String>) -> Step {
    if so { Ok(()) } else { fail(expected, Shown(found.into())) }
}

/// Ends the test as not applicable.
pub fn not_applicable<T>(why: impl Text) -> Step<T> {
    Err(Halt::NotApplicable(why.words()))
}
