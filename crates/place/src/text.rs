//! Texts in English and Russian, and what is wrong with an input.

use std::fmt;

/// A text in both languages.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Both {
    /// English.
    pub en: String,
    /// Russian.
    pub ru: String,
}

/// A text from its two forms.
pub fn both(en: impl Into<String>, ru: impl Into<String>) -> Both {
    Both { en: en.into(), ru: ru.into() }
}

/// Why an input is refused: what is wrong, where, and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem(pub Both);

impl Problem {
    /// From the two forms of its text.
    pub fn new(en: impl Into<String>, ru: impl Into<String>) -> Self {
        Self(both(en, ru))
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
    what: (&str, &str),
    value: f64,
    allowed: std::ops::RangeInclusive<f64>,
) -> Result<(), Problem> {
    if allowed.contains(&value) {
        return Ok(());
    }
    let (least, most) = (allowed.start(), allowed.end());
    Err(Problem::new(
        format!("{} is {value}; allowed: {least} … {most}", what.0),
        format!("{}: {value}; допустимо: {least} … {most}", what.1),
    ))
}

/// Refuses more things than there may be, or none where one is needed.
pub(crate) fn counted(
    what: (&str, &str),
    count: usize,
    allowed: std::ops::RangeInclusive<usize>,
) -> Result<(), Problem> {
    if allowed.contains(&count) {
        return Ok(());
    }
    let (least, most) = (allowed.start(), allowed.end());
    Err(Problem::new(
        format!("{count} {}; allowed: {least} … {most}", what.0),
        format!("{}: {count}; допустимо: {least} … {most}", what.1),
    ))
}
