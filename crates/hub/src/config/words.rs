//! What the readers of TOML say, in words of both languages.

use crate::text::{Both, both};

/// Kinds of values: as serde says it, English, Russian.
const KINDS: [[&str; 3]; 16] = [
    ["a string", "a text in quotes", "текст в кавычках"],
    ["a boolean", "true or false", "true или false"],
    ["a sequence", "a list: [[…]] or […]", "список: [[…]] или […]"],
    ["a map", "a table", "таблица"],
    ["i16", "a whole number", "целое число"],
    ["u16", "a whole number from 0", "целое число от 0"],
    ["u32", "a whole number from 0", "целое число от 0"],
    ["u64", "a whole number from 0", "целое число от 0"],
    ["usize", "a whole number from 0", "целое число от 0"],
    ["f64", "a number", "число"],
    ["path string", "a path in quotes", "путь в кавычках"],
    ["an array of length 2", "two numbers: [east, north]", "два числа: [восток, север]"],
    ["integer", "the number", "число"],
    ["floating point", "the fraction", "дробь"],
    ["string", "the text", "текст"],
    ["boolean", "the value", "значение"],
];

/// Names that are so like each other are the same, mistyped.
const LIKE: f64 = 0.8;

/// The message of a reader in both languages; one that is not known stays as it is.
pub fn of(said: &str) -> Both {
    let list = |listed: &str| listed.trim_start_matches("one of ").replace(" or ", ", ");
    if let Some((name, listed)) = said.strip_prefix("unknown field ").and_then(expected) {
        return both(
            format!("{name} is not known here; what is: {}.", list(listed)),
            format!("{name} здесь неизвестно; возможно: {}.", list(listed)),
        );
    }
    if let Some((name, listed)) = said.strip_prefix("unknown variant ").and_then(expected) {
        return both(
            format!("{name} is not one of {}.", list(listed)),
            format!("{name} — не то; возможно: {}.", list(listed)),
        );
    }
    if let Some(name) = said.strip_prefix("missing field ") {
        return both(format!("{name} is missing."), format!("Не хватает {name}."));
    }
    if said.starts_with("duplicate key") || said.starts_with("duplicate field") {
        return both("This is given twice.", "Это указано дважды.");
    }
    if let Some((votes, _)) = said.split_once(" is no vote: ") {
        return both(
            format!("{votes} is no vote: write 2oo3 for two of three detectors."),
            format!("{votes} — не число голосов: напишите 2oo3, то есть два из трёх извещателей."),
        );
    }
    let wrong =
        said.strip_prefix("invalid type: ").or_else(|| said.strip_prefix("invalid value: "));
    if let Some((given, wanted)) = wrong.and_then(expected) {
        let ([given_en, given_ru], [wanted_en, wanted_ru]) = (kind(given), kind(wanted));
        return both(
            format!("{given_en} where {wanted_en} is needed."),
            format!("Указано: {given_ru}, а нужно: {wanted_ru}."),
        );
    }
    both(format!("TOML: {said}."), format!("TOML: {said}."))
}

/// What was meant, where a name is nearly one that is known; else the usual remedy.
pub fn meant(said: &str, usual: Both) -> Both {
    let rest =
        said.strip_prefix("unknown field ").or_else(|| said.strip_prefix("unknown variant "));
    let nearest = rest.and_then(expected).and_then(|(name, listed)| {
        let name = name.trim_matches('`');
        let names = listed.split('`').skip(1).step_by(2);
        let near = names.map(|it| (strsim::jaro_winkler(name, it), it));
        near.filter(|(likeness, _)| *likeness > LIKE).max_by(|a, b| a.0.total_cmp(&b.0))
    });
    match nearest {
        None => usual,
        Some((_, name)) => {
            both(format!("Did you mean {name}?"), format!("Возможно, имелось в виду {name}."))
        }
    }
}

fn expected(rest: &str) -> Option<(&str, &str)> {
    rest.split_once(", expected ").or_else(|| Some((rest, rest.split_once(", there are no ")?.1)))
}

/// A kind of value, and the value.
fn kind(said: &str) -> [String; 2] {
    for [kind, en, ru] in KINDS {
        if let Some(value) = said.strip_prefix(kind)
            && (value.is_empty() || value.starts_with(' '))
        {
            return [format!("{en}{value}"), format!("{ru}{value}")];
        }
    }
    [said.to_owned(), said.to_owned()]
}
