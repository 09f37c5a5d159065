//! The language of everything a user sees, chosen once at the start.

use std::sync::OnceLock;

pub use lafet_client::Lang;
use lafet_proto::dictionary::Key;
use lafet_texts::{Decimal, Fixed, Text as _};

static CURRENT: OnceLock<Lang> = OnceLock::new();

/// Chooses the language from `--lang`, else from LC_ALL, LC_MESSAGES or LANG.
///
/// Works on the raw arguments, because clap's help and errors need the language too.
pub fn choose(arguments: &[String]) -> Lang {
    let asked = asked(arguments).and_then(|value| parse(&value));
    let environment = || {
        ["LC_ALL", "LC_MESSAGES", "LANG"]
            .iter()
            .find_map(|name| std::env::var(name).ok().filter(|value| !value.is_empty()))
            .map_or(Lang::En, |locale| of_locale(&locale))
    };
    *CURRENT.get_or_init(|| asked.unwrap_or_else(environment))
}

/// The language that was chosen.
pub fn current() -> Lang {
    CURRENT.get().copied().unwrap_or_default()
}

/// A text without arguments in the current language.
pub fn of(text: &impl Said) -> &'static str {
    text.fixed().str(current())
}

/// A text without arguments: a key of the dictionary, or the words themselves.
pub trait Said {
    /// Its words in every language.
    fn fixed(&self) -> Fixed;
}

impl Said for Key {
    fn fixed(&self) -> Fixed {
        lafet_texts::dictionary(*self)
    }
}

impl Said for Fixed {
    fn fixed(&self) -> Fixed {
        *self
    }
}

/// A text with the decimal mark of the current language in its numbers.
pub fn decimals(text: String) -> String {
    match lafet_texts::decimal_mark(current()) {
        "." => text,
        mark => marked(&text, mark),
    }
}

/// A number with so many decimal digits, in the current language.
pub fn decimal(value: f64, digits: usize) -> String {
    Decimal(value, digits).of(current())
}

fn marked(text: &str, mark: &str) -> String {
    let mut before = ' ';
    let mut result = String::new();
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        let is_decimal = letter == '.'
            && before.is_ascii_digit()
            && letters.peek().is_some_and(char::is_ascii_digit);
        if is_decimal {
            result.push_str(mark);
        } else {
            result.push(letter);
        }
        before = letter;
    }
    result
}

/// Parses the value of `--lang`.
pub fn parse(value: &str) -> Option<Lang> {
    Lang::ALL.into_iter().find(|lang| value.eq_ignore_ascii_case(lang.code()))
}

fn asked(arguments: &[String]) -> Option<String> {
    let before_dashes = arguments.iter().take_while(|argument| *argument != "--");
    let arguments: Vec<&String> = before_dashes.collect();
    arguments.iter().enumerate().find_map(|(index, argument)| {
        if *argument == "--lang" {
            return arguments.get(index + 1).map(|value| (*value).clone());
        }
        argument.strip_prefix("--lang=").map(str::to_owned)
    })
}

fn of_locale(locale: &str) -> Lang {
    Lang::ALL.into_iter().find(|lang| locale.starts_with(lang.code())).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_option_is_found_before_the_arguments_are_read() {
        let find = |text: &str| {
            let arguments: Vec<String> = text.split(' ').map(str::to_owned).collect();
            asked(&arguments)
        };
        assert_eq!(find("lafet --lang ru status").as_deref(), Some("ru"));
        assert_eq!(find("lafet status --lang=en").as_deref(), Some("en"));
        assert_eq!(find("lafet send -- --lang ru"), None);
        assert_eq!(find("lafet --lang"), None);
    }

    #[test]
    fn locales() {
        assert_eq!(of_locale("ru_RU.UTF-8"), Lang::Ru);
        assert_eq!(of_locale("C"), Lang::En);
        assert_eq!(parse("RU"), Some(Lang::Ru));
        assert_eq!(parse("de"), None);
    }
}
