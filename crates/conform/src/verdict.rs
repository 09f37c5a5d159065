//! Outcome of a test.

use std::io;

/// A sentence in both languages.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Note {
    /// English text.
    pub en: String,
    /// Russian text.
    pub ru: String,
}

impl Note {
    /// A sentence from both texts.
    pub fn new(en: impl Into<String>, ru: impl Into<String>) -> Self {
        Self { en: en.into(), ru: ru.into() }
    }

    /// Protocol identifiers, which are the same in both languages.
    pub fn same(text: impl Into<String>) -> Self {
        let text = text.into();
        Self { en: text.clone(), ru: text }
    }
}

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
pub fn fail<T>(expected: Note, found: Note) -> Step<T> {
    Err(Halt::Fail { expected, found })
}

/// Fails unless the condition holds.
pub fn must(so: bool, en: &str, ru: &str, found: impl Into<String>) -> Step {
    if so { Ok(()) } else { fail(Note::new(en, ru), Note::same(found)) }
}

/// Ends the test as not applicable.
pub fn not_applicable<T>(en: &str, ru: &str) -> Step<T> {
    Err(Halt::NotApplicable(Note::new(en, ru)))
}
