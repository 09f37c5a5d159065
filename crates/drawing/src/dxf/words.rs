//! Texts of a DXF file: their encoding, and what is written in them besides letters.

use encoding_rs::{Encoding, IBM866, UTF_8, WINDOWS_1252};

/// Bytes of a text that are looked at: names are shorter.
const LONGEST: usize = 1024;

/// Decodes the texts of a file.
#[derive(Clone, Copy, Debug)]
pub struct Decoder {
    page: &'static Encoding,
}

impl Default for Decoder {
    fn default() -> Self {
        Self { page: WINDOWS_1252 }
    }
}

impl Decoder {
    /// By `$DWGCODEPAGE`: `ANSI_1251`.
    pub fn of_page(name: &[u8]) -> Self {
        let name = String::from_utf8_lossy(name).trim().to_ascii_lowercase();
        let number = name.trim_start_matches(|c: char| !c.is_ascii_digit());
        let label = match number {
            "932" => "shift_jis",
            "936" => "gbk",
            "949" => "euc-kr",
            "950" => "big5",
            "866" => return Self { page: IBM866 },
            number => &format!("windows-{number}"),
        };
        Self { page: Encoding::for_label(label.as_bytes()).unwrap_or(WINDOWS_1252) }
    }

    /// A text. Many programs write UTF-8 whatever the header says, and hardly any other text is valid UTF-8.
    pub fn text(self, bytes: &[u8]) -> String {
        let bytes = &bytes[..bytes.len().min(LONGEST)];
        let is_utf8 = match std::str::from_utf8(bytes) {
            Ok(_) => true,
            // Only the last letter is cut.
            Err(error) => error.error_len().is_none(),
        };
        let page = if is_utf8 { UTF_8 } else { self.page };
        let (text, _) = page.decode_without_bom_handling(bytes);
        unescaped(&text)
    }
}

/// Letters that are written by number, `\U+0411`, and the signs of `%%c`, `%%d`, `%%p`.
fn unescaped(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("\\U+").into_iter().chain(rest.find("%%")).min() {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let number = rest.strip_prefix("\\U+").and_then(|it| it.get(..4));
        let letter =
            number.and_then(|it| u32::from_str_radix(it, 16).ok()).and_then(char::from_u32);
        let sign = rest.strip_prefix("%%").and_then(|it| it.chars().next());
        let (shown, length) = match (letter, sign) {
            (Some(letter), _) => (Some(letter), 7),
            (None, Some('c' | 'C')) => (Some('⌀'), 3),
            (None, Some('d' | 'D')) => (Some('°'), 3),
            (None, Some('p' | 'P')) => (Some('±'), 3),
            (None, Some('u' | 'U' | 'o' | 'O' | 'k' | 'K')) => (None, 3),
            (None, _) => (rest.chars().next(), 1),
        };
        out.extend(shown);
        rest = rest.get(length..).unwrap_or_default();
    }
    out.push_str(rest);
    out
}

/// The letters of a text of several lines (MTEXT), without its fonts, heights and colours.
pub fn plain(text: &str) -> String {
    let mut out = String::new();
    let mut letters = text.chars();
    while let Some(letter) = letters.next() {
        match letter {
            '{' | '}' => {}
            '\\' => match letters.next() {
                Some('P' | 'N' | 'X' | '~') => out.push(' '),
                Some('A' | 'C' | 'c' | 'f' | 'F' | 'H' | 'Q' | 'T' | 'W' | 'p') => {
                    letters.by_ref().find(|it| *it == ';');
                }
                Some('S') => out.extend(letters.by_ref().take_while(|it| *it != ';')),
                Some('L' | 'l' | 'O' | 'o' | 'K' | 'k') | None => {}
                Some(other) => out.push(other),
            },
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_any_page() {
        let russian = Decoder::of_page(b"ANSI_1251");
        assert_eq!(russian.text(b"\xd0\xc2\xd1-1"), "РВС-1");
        assert_eq!(russian.text("РВС-1".as_bytes()), "РВС-1");
        assert_eq!(Decoder::of_page(b"dos866").text(b"\x90\x82\x91"), "РВС");
        assert_eq!(Decoder::default().text(br"\U+0420\U+0412-%%c12"), "РВ-⌀12");
        assert_eq!(Decoder::default().text(br"\U+zz 50%% %%"), r"\U+zz 50%% %%");
        assert_eq!(plain(r"{\fArial|b0;\H2.5;T-1}\Ptank \S1/2;"), "T-1 tank 1/2");
    }
}
