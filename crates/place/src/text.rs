//! What is wrong with an input.

use std::fmt;
use std::ops::RangeInclusive;

use lafet_texts::{Text, Words, place as text};

/// Why an input is refused: what is wrong, where, and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem(pub Words);

impl Problem {
    /// Says so.
    pub(crate) fn new(text: impl Text) -> Self {
        Self(text.words())
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.en)
    }
}

impl std::error::Error for Problem {}

/// Refuses a number that is outside of its bounds, infinite or no number.
pub(crate) fn within(
    what: &dyn Text,
    value: f64,
    allowed: RangeInclusive<f64>,
) -> Result<(), Problem> {
    if allowed.contains(&value) {
        return Ok(());
    }
    let (least, most) = (*allowed.start(), *allowed.end());
    Err(Problem::new(text::OutOfRange { what, value, least, most }))
}

/// Refuses more things than there may be, or none where one is needed.
pub(crate) fn counted(
    what: &dyn Text,
    count: usize,
    allowed: RangeInclusive<usize>,
) -> Result<(), Problem> {
    if allowed.contains(&count) {
        return Ok(());
    }
    let (least, most) = (*allowed.start(), *allowed.end());
    Err(Problem::new(text::TooMany { what, count, least, most }))
}
