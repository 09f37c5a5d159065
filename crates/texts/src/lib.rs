//! What lafet says to people: texts in every language, compiled from catalogues.
//!
//! A text is a structure, in the module of the crate that says it, and its fields are the arguments. It
//! becomes words where it is shown: [`Text::of`] a language, [`Text::words`] in all of them.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt;
use std::sync::LazyLock;

use common as text;
use lafet_proto::dictionary::Key;

mod decode_error;
mod parse_error;
pub mod toml;

pub use decode_error::Undecodable;
pub use parse_error::parse_error_text;

include!(concat!(env!("OUT_DIR"), "/texts.rs"));

/// What may be an argument of a text: ready text, a number, or another text, which is put in the same
/// language.
pub trait Argument {
    /// Writes it in a language.
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result;
}

/// A text for people: a key of a catalogue with its arguments.
pub trait Text: Argument {
    /// In a language.
    fn of(&self, lang: Lang) -> String {
        let mut text = String::new();
        // A string takes whatever is written to it.
        _ = self.write(lang, &mut text);
        text
    }

    /// In every language.
    fn words(&self) -> Words {
        Words::each(|lang| self.of(lang))
    }
}

impl<T: Argument + ?Sized> Argument for &T {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        (**self).write(lang, out)
    }
}

impl<T: Text + ?Sized> Text for &T {}

impl Argument for Words {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(self.of(lang))
    }
}

impl Text for Words {}

/// In English, as errors show themselves to programmers.
impl fmt::Display for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.of(Lang::En))
    }
}

/// What a text that is read has wrong.
impl std::error::Error for Words {}

impl Argument for Fixed {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        out.write_str(self.str(lang))
    }
}

impl Text for Fixed {}

/// What shows itself, the same in every language: names, addresses, errors.
#[derive(Clone, Copy, Debug)]
pub struct Shown<T>(pub T);

impl<T: fmt::Display> Argument for Shown<T> {
    fn write(&self, _: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        write!(out, "{}", self.0)
    }
}

impl<T: fmt::Display> Text for Shown<T> {}

/// The mark between whole and decimal digits.
pub const fn decimal_mark(lang: Lang) -> &'static str {
    text::DecimalMark.str(lang)
}

/// The words of a key of the protocol's dictionary; one that is in no catalogue is shown as it is.
pub fn dictionary(key: Key) -> Fixed {
    static ALL: LazyLock<HashMap<&str, Fixed>> =
        LazyLock::new(|| proto::BY_KEY.iter().copied().collect());
    ALL.get(key.name()).copied().unwrap_or(Fixed::same(key.name()))
}

impl Argument for Key {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        dictionary(*self).write(lang, out)
    }
}

impl Text for Key {}

/// Arguments that are the same in all languages.
macro_rules! same_in_all {
    ($($type:ty),*) => {
        $(impl Argument for $type {
            fn write(&self, _: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
                write!(out, "{self}")
            }
        })*
    };
}

same_in_all!(str, String, char, bool, Cow<'_, str>, fmt::Arguments<'_>);
same_in_all!(u8, u16, u32, u64, usize, i8, i16, i32, i64, isize);

/// Numbers with the decimal digits that they need.
macro_rules! with_mark {
    ($($type:ty),*) => {
        $(impl Argument for $type {
            fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
                out.write_str(&self.to_string().replace('.', decimal_mark(lang)))
            }
        })*
    };
}

with_mark!(f32, f64);

/// A number with so many decimal digits.
#[derive(Clone, Copy, Debug)]
pub struct Decimal(pub f64, pub usize);

impl Argument for Decimal {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        let Self(value, digits) = *self;
        out.write_str(&format!("{value:.digits$}").replace('.', decimal_mark(lang)))
    }
}

impl Text for Decimal {}

/// A part of a text.
#[derive(Clone, Copy)]
enum Piece {
    /// As it is.
    Text(&'static str),
    /// The argument at this place.
    Argument(usize),
}

/// Writes the parts of a text.
fn put(
    pieces: &[Piece],
    arguments: &[&dyn Argument],
    lang: Lang,
    out: &mut dyn fmt::Write,
) -> fmt::Result {
    pieces.iter().try_for_each(|piece| match *piece {
        Piece::Text(text) => out.write_str(text),
        Piece::Argument(index) => {
            arguments.get(index).map_or(Ok(()), |argument| argument.write(lang, out))
        }
    })
}

/// The examples of the README are compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
