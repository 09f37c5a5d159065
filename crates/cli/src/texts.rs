//! Messages of lafet-proto in the user's language; that crate itself has English only.

use lafet_client::{Undecodable, parse_error_text};
use lafet_proto::DecodeError;
use lafet_proto::text::ParseError;
use lafet_texts::Text as _;

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
    Undecodable(error).of(current())
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
