//! How a test ends.

use std::io;

/// A sentence in both languages.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Note {
    /// English.
    pub en: String,
    /// Russian.
    pub ru: String,
}

impl Note {
    /// Both texts.
    pub fn new(en: impl Into<String>, ru: impl Into<String>) -> Self {
        Self { en: en.into(), ru: ru.into() }
    }

    /// Words of the protocol, which are the same in both.
    pub fn same(text: impl Into<String>) -> Self {
        let text = text.into();
        Self { en: text.clone(), ru: text }
    }
}

/// Why a test does not go on.
#[derive(Debug)]
pub enum Halt {
    /// The monitor did not do what the item says.
    Fail {
        /// What it should have done.
        expected: Note,
        /// What it did.
        found: Note,
    },
    /// This monitor has nothing to test here.
    NotApplicable(Note),
    /// Nothing more may be tried: something moves that should not, or the user wants an end.
    Abort(Note),
    /// The link does not carry any more.
    Link(io::Error),
}

/// Result of a step of a test.
pub type Step<T = ()> = Result<T, Halt>;

/// How a test ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// As the item says.
    Pass,
    /// Not as the item says.
    Fail,
    /// Not as we have ruled where the document is silent.
    Differs,
    /// Nothing to test on this monitor.
    NotApplicable,
}

impl Outcome {
    /// One word of it, for machines and for tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Differs => "differs",
            Self::NotApplicable => "n/a",
        }
    }
}

/// A failure.
pub fn fail<T>(expected: Note, found: Note) -> Step<T> {
    Err(Halt::Fail { expected, found })
}

/// A failure unless it is so.
pub fn must(so: bool, en: &str, ru: &str, found: impl Into<String>) -> Step {
    if so { Ok(()) } else { fail(Note::new(en, ru), Note::same(found)) }
}

/// Nothing to test here.
pub fn not_applicable<T>(en: &str, ru: &str) -> Step<T> {
    Err(Halt::NotApplicable(Note::new(en, ru)))
}
