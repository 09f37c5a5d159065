//! What the readers of TOML say, in words of both languages.

use lafet_texts::{Text, hub as text};

use crate::text::Both;

/// Kinds of values, as serde says them.
const KINDS: [(&str, &(dyn Text + Sync)); 18] = [
    ("a string", &text::KindAString),
    ("a boolean", &text::KindABoolean),
    ("a sequence", &text::KindAList),
    ("a map", &text::KindATable),
    ("i16", &text::KindWhole),
    ("u16", &text::KindWholeFrom0),
    ("u32", &text::KindWholeFrom0),
    ("u64", &text::KindWholeFrom0),
    ("usize", &text::KindWholeFrom0),
    ("f64", &text::KindANumber),
    ("path string", &text::KindAPath),
    ("an array of length 2", &text::KindTwoNumbers),
    ("integer", &text::KindInteger),
    ("floating point", &text::KindFraction),
    ("string", &text::KindString),
    ("boolean", &text::KindBoolean),
    ("sequence", &text::KindAList),
    ("map", &text::KindATable),
];

/// Names that are so like each other are the same, mistyped.
const LIKE: f64 = 0.8;

/// The message of a reader in both languages; one that is not known stays as it is.
pub fn of(said: &str) -> Both {
    let list = |listed: &str| listed.trim_start_matches("one of ").replace(" or ", ", ");
    if let Some((name, listed)) = said.strip_prefix("unknown field ").and_then(expected) {
        return text::TomlUnknown { name, known: list(listed) }.words();
    }
    if let Some((name, listed)) = said.strip_prefix("unknown variant ").and_then(expected) {
        return text::TomlNotOneOf { name, known: list(listed) }.words();
    }
    if let Some(name) = said.strip_prefix("missing field ") {
        return text::TomlMissing { name }.words();
    }
    if said.starts_with("duplicate key") || said.starts_with("duplicate field") {
        return text::TomlTwice.words();
    }
    if let Some((votes, _)) = said.split_once(" is no vote: ") {
        return text::TomlNoVote { votes }.words();
    }
    let wrong =
        said.strip_prefix("invalid type: ").or_else(|| said.strip_prefix("invalid value: "));
    if let Some((given, wanted)) = wrong.and_then(expected) {
        let (given, wanted) = (kind(given), kind(wanted));
        return text::TomlKind { given, wanted }.words();
    }
    let told = lafet_texts::toml::said(said);
    Both { en: format!("TOML: {}.", told.en), ru: format!("TOML: {}.", told.ru) }
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
        Some((_, name)) => text::TomlMeant { name }.words(),
    }
}

fn expected(rest: &str) -> Option<(&str, &str)> {
    rest.split_once(", expected ").or_else(|| Some((rest, rest.split_once(", there are no ")?.1)))
}

/// A kind of value, and the value.
fn kind(said: &str) -> Both {
    let of = |(kind, text): &(&str, &(dyn Text + Sync))| {
        let value = said.strip_prefix(kind)?;
        let whole = value.is_empty() || value.starts_with(' ');
        whole.then(|| text::TomlKindValue { kind: *text, value }.words())
    };
    KINDS.iter().find_map(of).unwrap_or_else(|| Both::same(said))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What was written and what is needed are in the language, whatever the kind.
    #[test]
    fn kinds_are_in_the_language() {
        for given in ["sequence", "map", "string \"5\"", "integer `5`", "floating point `5.5`"] {
            for wanted in ["a string", "a boolean", "a map", "a sequence", "u16", "f64"] {
                let said = of(&format!("invalid type: {given}, expected {wanted}"));
                let words = said.ru.split(|c: char| !c.is_ascii_alphabetic());
                let strange: Vec<&str> = words.filter(|word| word.len() > 1).collect();
                assert!(strange.is_empty() || said.ru.contains("true"), "{}", said.ru);
            }
        }
    }
}
