//! Errors of decoding in the language of the user; lafet-proto has them in English only.

use std::fmt;

use lafet_proto::{DecodeError, Expected};

use crate::{Argument, Lang, Text, client as text};

/// Why bytes cannot be decoded, as an argument of a text: a clause without a full stop.
#[derive(Clone, Copy, Debug)]
pub struct Undecodable<'a>(pub &'a DecodeError);

impl Argument for Undecodable<'_> {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        let Self(error) = *self;
        text::AtByte { offset: error.offset, what: Expectation(error) }.write(lang, out)
    }
}

impl Text for Undecodable<'_> {}

struct Expectation<'a>(&'a DecodeError);

impl Argument for Expectation<'_> {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        let got = self.0.got;
        let hex = format_args!("{got:#04x}");
        match self.0.expected {
            Expected::Header => text::HeaderExpected { got }.write(lang, out),
            Expected::Data(size) => text::DataExpected { size, got }.write(lang, out),
            Expected::Size => text::OtherSizeExpected { got }.write(lang, out),
            Expected::Value => text::OtherValueExpected { got }.write(lang, out),
            Expected::RequestId => text::RequestUnknown { got: hex }.write(lang, out),
            Expected::FrameStart => text::FrameStartExpected { got: hex }.write(lang, out),
            Expected::Escape => text::EscapeExpected { got: hex }.write(lang, out),
            Expected::Crc(crc) => {
                let (crc, got) = (format_args!("{crc:#06x}"), format_args!("{got:#06x}"));
                text::CrcExpected { crc, got }.write(lang, out)
            }
            Expected::Crc32c(crc) => {
                let (crc, got) = (format_args!("{crc:#010x}"), format_args!("{got:#010x}"));
                text::Crc32cExpected { crc, got }.write(lang, out)
            }
            Expected::FrameEnd => text::FrameEndExpected.write(lang, out),
            Expected::Room => text::FrameTooLong { got }.write(lang, out),
            // A later version of lafet-proto may expect more.
            _ => text::BytesWrong { got }.write(lang, out),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The English texts are those of lafet-proto; the others have no English sentence in them.
    #[test]
    fn every_expectation_is_said_in_the_language() {
        for expected in [
            Expected::Header,
            Expected::Data(5),
            Expected::Size,
            Expected::Value,
            Expected::RequestId,
            Expected::FrameStart,
            Expected::Escape,
            Expected::Crc(0x12),
            Expected::Crc32c(0x12),
            Expected::FrameEnd,
            Expected::Room,
        ] {
            let error = DecodeError { offset: 3, expected, got: 7 };
            let (en, ru) = (Undecodable(&error).of(Lang::En), Undecodable(&error).of(Lang::Ru));
            assert_eq!(en, error.to_string());
            let words = |word: &&str| word.chars().filter(char::is_ascii_lowercase).count() > 3;
            let english: Vec<&str> = ru.split_whitespace().filter(words).collect();
            assert!(english.iter().all(|word| *word == "data_size"), "{ru}");
        }
    }
}
