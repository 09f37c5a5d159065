//! Splits a line into words: blanks separate, quotes group, `#` starts a comment.

use lafet_texts::cli as text;
use std::ops::Range;

use crate::lang::current;

/// A word and its place in the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    /// Its text, without quotes.
    pub text: String,
    /// Its byte range in the line, with quotes.
    pub span: Range<usize>,
    /// Whether its closing quote is missing.
    pub open: bool,
}

/// Splits a line. Only a quote at the start of a word quotes: angles are written `12°30'`.
pub fn split(line: &str) -> Vec<Word> {
    let mut words = Vec::new();
    let mut rest = line;
    loop {
        rest = rest.trim_start();
        let start = line.len() - rest.len();
        let Some(first) = rest.chars().next().filter(|first| *first != '#') else { return words };
        let quoted = matches!(first, '"' | '\'');
        let (text, length, open) = if quoted {
            let inside = &rest[1..];
            match inside.find(first) {
                Some(end) => (&inside[..end], end + 2, false),
                None => (inside, rest.len(), true),
            }
        } else {
            let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
            (&rest[..end], end, false)
        };
        words.push(Word { text: text.to_owned(), span: start..start + length, open });
        rest = &rest[length..];
    }
}

/// The words of a complete line; an unclosed quote is an error.
pub fn words(line: &str) -> Result<Vec<String>, String> {
    let words = split(line);
    if words.iter().any(|word| word.open) {
        return Err(text::QuoteOpen.str(current()).into());
    }
    Ok(words.into_iter().map(|word| word.text).collect())
}

/// Whether a line asks for a stop: with any arguments, in Russian, or typed in the wrong keyboard
/// layout.
pub fn is_stop(line: &str) -> bool {
    let first = split(line).into_iter().next();
    first.is_some_and(|word| ["stop", "стоп", "ыещз"].contains(&word.text.to_lowercase().as_str()))
}

/// Whether a line begins nothing that moves or opens: it closes, locks out, stops or leaves.
pub fn only_ends(line: &str) -> bool {
    let words: Vec<String> = split(line).into_iter().map(|word| word.text.to_lowercase()).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let ends =
        matches!(words[..], [] | ["close" | "exit" | "quit" | "выход", ..] | ["lockout", "on", ..]);
    ends || is_stop(line)
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_only_ends() {
        for line in ["close", "close valve2", "lockout on", "exit", "стоп", ""] {
            assert!(super::only_ends(line), "{line}");
        }
        for line in ["open", "deploy", "lockout off", "send \"Close Valve1\"", "closed"] {
            assert!(!super::only_ends(line), "{line}");
        }
    }

    use super::*;

    #[test]
    fn lines_are_taken_apart() {
        for (line, expected) in [
            ("", &[][..]),
            ("  move  vertical 20deg ", &["move", "vertical", "20deg"]),
            ("move vertical 12°30'", &["move", "vertical", "12°30'"]),
            (
                "send \"Open Valve1\" 'GetStatus Valve1'",
                &["send", "Open Valve1", "GetStatus Valve1"],
            ),
            ("stop # at once", &["stop"]),
            ("# nothing", &[]),
            ("send \"\"", &["send", ""]),
            ("a#b", &["a#b"]),
        ] {
            assert_eq!(words(line).as_deref(), Ok(expected.map_str().as_slice()), "{line}");
        }
        assert!(words("send \"Open").is_err());
    }

    trait MapStr {
        fn map_str(&self) -> Vec<String>;
    }

    impl MapStr for [&str] {
        fn map_str(&self) -> Vec<String> {
            self.iter().map(|text| (*text).to_owned()).collect()
        }
    }

    #[test]
    fn a_word_knows_its_place() {
        let line = "send \"Open V";
        let word = split(line).pop().unwrap();
        assert_eq!((word.text.as_str(), &line[word.span], word.open), ("Open V", "\"Open V", true));
    }

    #[test]
    fn a_stop_is_understood() {
        for line in ["stop", " STOP", "стоп", "ыещз", "stop verticla", "stop # now"] {
            assert!(is_stop(line), "{line}");
        }
        for line in ["", "move vertical 3", "stopp", "# stop"] {
            assert!(!is_stop(line), "{line}");
        }
    }
}
