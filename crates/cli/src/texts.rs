//! Messages of lafet-proto in the user's language; that crate itself has English only.

use std::fmt;

use lafet_client::parse_error_text;
use lafet_proto::text::ParseError;
use lafet_proto::{DecodeError, Expected};
use lafet_texts::{Argument, Lang, Text as _, cli as text};

use crate::lang::current;

/// Why a text is not a valid request, with the text and a mark under the error.
pub fn parse_error(text: &str, error: &ParseError) -> String {
    let column = text.get(..error.column).map_or(0, |before| before.chars().count());
    let word = text.get(error.column..error.column.saturating_add(error.len));
    let length = word.map_or(1, |word| word.chars().count()).max(1);
    let mark = format!("  {text}\n  {}{}", " ".repeat(column), "^".repeat(length));
    format!("{}\n{mark}", parse_error_text(text, error, current()))
}

/// Why bytes could not be decoded.
pub fn decode_error(error: &DecodeError) -> String {
    text::AtByte { offset: error.offset, what: Expectation(error) }.of(current())
}

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
            // A later version of the protocol crate may expect more.
            _ => text::BytesWrong { got }.write(lang, out),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_is_marked() {
        let mut buffer = [0; lafet_proto::text::BUFFER_SIZE];
        let error = lafet_proto::text::parse("Move Vertikal 1", &mut buffer).unwrap_err();
        let shown = parse_error("Move Vertikal 1", &error);
        assert!(shown.ends_with("  Move Vertikal 1\n       ^^^^^^^^"), "{shown}");
    }
}
