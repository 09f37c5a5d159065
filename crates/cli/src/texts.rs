//! Messages of lafet-proto in the user's language; that crate itself has English only.

use lafet_client::parse_error_text;
use lafet_proto::text::ParseError;
use lafet_proto::{DecodeError, Expected};

use crate::lang::{Lang, current};

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
    match current() {
        Lang::En => error.to_string(),
        Lang::Ru => format!("байт {}: {}", error.offset, expected_ru(error)),
    }
}

fn expected_ru(error: &DecodeError) -> String {
    let got = error.got;
    match error.expected {
        Expected::Header => format!("заголовок записи — 4 байта, осталось {got}"),
        Expected::Data(size) => format!("data_size обещает {size} байт, осталось {got}"),
        Expected::Size => format!("{got} байт данных: у этой записи такого размера не бывает"),
        Expected::Value => format!("значение {got} вне допустимых пределов"),
        Expected::RequestId => format!("неизвестный запрос {got:#04x}"),
        Expected::FrameStart => format!("кадр начинается с FF C0, а здесь {got:#04x}"),
        Expected::Escape => {
            format!("после DB может следовать только DC или DD, а здесь {got:#04x}")
        }
        Expected::Crc(crc) => format!("CRC должна быть {crc:#06x}, в кадре {got:#06x}"),
        Expected::Crc32c(crc) => {
            format!("CRC-32C должна быть {crc:#010x}, в кадре {got:#010x}")
        }
        Expected::FrameEnd => "кадр не завершён байтом C0".into(),
        Expected::Room => format!("кадр длиннее {got} байт, которые хранит приёмник"),
        // A later version of the protocol crate may expect more.
        _ => format!("байты не соответствуют протоколу ({got})"),
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
