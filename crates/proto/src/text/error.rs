//! Errors of [`parse`](super::parse): where, what was expected, which word may have been meant.

use super::write_list;
use crate::dictionary::{self, REQUESTS, SUBSYSTEMS};
use crate::id::{RequestId, SubsystemId};
use crate::param::Param;
use core::fmt;

/// Error in the text of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ParseError {
    /// Byte offset of the wrong word; the end of the text when something is missing.
    pub column: usize,
    /// Length of the wrong word, bytes; 0 when something is missing.
    pub len: usize,
    /// What was expected there.
    pub expected: Wanted,
    /// The known word that is most similar to the wrong one.
    pub suggestion: Option<&'static str>,
}

/// What [`parse`](super::parse) expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Wanted {
    /// Name of a request, or its number.
    Request,
    /// Name of a subsystem that accepts this request, or its number.
    Addressee(RequestId),
    /// Name of a parameter of this subsystem, its number, or `@` and any name.
    Param(SubsystemId),
    /// One of these words.
    Word(&'static [&'static str]),
    /// A number in this range.
    Number {
        /// What the number means.
        what: &'static str,
        /// The smallest valid value.
        min: i64,
        /// The greatest valid value.
        max: i64,
    },
    /// A given number of values with commas between them.
    Numbers {
        /// What the values mean.
        what: &'static str,
        /// Number of values.
        count: usize,
    },
    /// A part that this request needs.
    Missing(&'static str),
    /// A part that may be given only once.
    Once,
    /// Two parts that belong to different variants of the request.
    NotTogether(&'static str, &'static str),
    /// Bytes in hexadecimal.
    Hex,
    /// The end of the text.
    End,
    /// At most 255 bytes of data.
    FewerData,
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "column {}: {}", self.column.saturating_add(1), self.expected)?;
        match self.suggestion {
            Some(name) => write!(f, "; did you mean `{name}`?"),
            None => Ok(()),
        }
    }
}

impl core::error::Error for ParseError {}

impl fmt::Display for Wanted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Request => {
                f.write_str("expected a request (0x and two digits, or one of ")?;
                write_list(f, ", ", REQUESTS.iter().map(|info| info.name))?;
                f.write_str(")")
            }
            Self::Addressee(request) => {
                f.write_str("expected a subsystem (0x and two digits, or one of ")?;
                write_addressees(f, request)?;
                f.write_str(")")
            }
            Self::Param(subsystem) => {
                write!(f, "expected a parameter of {subsystem} (0x and four digits, @AnyName")?;
                let mut own = Param::of(subsystem).map(Param::name).peekable();
                if own.peek().is_some() {
                    f.write_str(", or one of ")?;
                }
                write_list(f, ", ", own)?;
                f.write_str(")")
            }
            Self::Word(words) => {
                f.write_str("expected ")?;
                write_list(f, " or ", words)
            }
            Self::Number { what, min, max } => {
                write!(f, "expected {what}, a number from {min} to {max}")
            }
            Self::Numbers { what, count } => {
                write!(f, "expected {what}, {count} numbers with commas between them")
            }
            Self::Missing(what) => write!(f, "{what} is missing"),
            Self::Once => f.write_str("given twice"),
            Self::NotTogether(one, other) => {
                write!(f, "{one} and {other} belong to different variants of the request")
            }
            Self::Hex => f.write_str("expected bytes in hexadecimal, like `de ad be`"),
            Self::End => f.write_str("expected nothing more"),
            Self::FewerData => f.write_str("too many data: a request carries 255 bytes at most"),
        }
    }
}

fn write_addressees(f: &mut fmt::Formatter<'_>, request: RequestId) -> fmt::Result {
    match dictionary::request(request) {
        Some(info) if !info.addressees.is_empty() => write_list(f, ", ", info.addressees),
        _ => write_list(f, ", ", SUBSYSTEMS.iter().map(|info| info.name)),
    }
}

/// The name most similar to a word; `None` if all differ too much.
pub fn nearest(word: &str, names: impl Iterator<Item = &'static str>) -> Option<&'static str> {
    // A swap of two letters counts as two changes, and must be allowed even in `Move`.
    let limit = (word.len() / 3 + 1).clamp(1, 4);
    names
        .map(|name| (distance(word, name), name))
        .filter(|(distance, _)| *distance <= limit)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

/// Edit distance (Levenshtein), regardless of case. Names here have at most 24 bytes; longer words
/// are cut.
fn distance(word: &str, name: &str) -> usize {
    const LONGEST: usize = 24;
    let mut row = [0usize; LONGEST + 1];
    for (index, cell) in row.iter_mut().enumerate() {
        *cell = index;
    }
    let mut last = name.len().min(LONGEST);
    for a in word.bytes().take(LONGEST) {
        let Some((first, rest)) = row.split_first_mut() else { break };
        let mut diagonal = *first;
        *first += 1;
        let mut left = *first;
        for (cell, b) in rest.iter_mut().zip(name.bytes()) {
            let changed = diagonal + usize::from(!a.eq_ignore_ascii_case(&b));
            diagonal = *cell;
            left = changed.min(left + 1).min(*cell + 1);
            *cell = left;
        }
        last = left;
    }
    last
}
