//! What the hub says to people: the texts are in `catalogues/LANGUAGE/hub.ftl` of `lafet-texts`.

use std::fmt;

pub use lafet_texts::Words as Both;
use lafet_texts::{Argument, Lang};

/// Words that are in no catalogue.
pub fn both(en: impl Into<String>, ru: impl Into<String>) -> Both {
    Both { en: en.into(), ru: ru.into() }
}

/// A number with the decimal mark of the language.
#[derive(Clone, Copy, Debug)]
pub struct Decimal<'a>(pub &'a str);

impl Argument for Decimal<'_> {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(&self.0.replace('.', lafet_texts::decimal_mark(lang)))
    }
}
