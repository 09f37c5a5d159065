//! What is wrong with a drawing or with what is stated about it.

use std::fmt;

use lafet_texts::{Lang, Text, Words, drawing as text};

/// What is wrong, in which line of the file, what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Line of the file, from 1.
    pub line: Option<usize>,
    /// What is wrong.
    pub what: Words,
    /// What to do.
    pub remedy: Words,
}

impl Problem {
    pub(crate) fn new(what: impl Text, remedy: impl Text) -> Self {
        Self { line: None, what: what.words(), remedy: remedy.words() }
    }

    /// Line 0 is none.
    pub(crate) fn at(line: usize, what: impl Text, remedy: impl Text) -> Self {
        Self { line: (line > 0).then_some(line), ..Self::new(what, remedy) }
    }

    /// The message in a language.
    pub fn localized(&self, lang: Lang) -> String {
        let (what, remedy) = (self.what.of(lang), self.remedy.of(lang));
        match self.line {
            Some(line) => text::ProblemAtLine { line, what, remedy }.of(lang),
            None => text::ProblemOfAll { what, remedy }.of(lang),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.localized(Lang::En))
    }
}

impl std::error::Error for Problem {}
