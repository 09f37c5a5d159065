//! Names of users and tokens that cannot be mistaken for one another.

use unicode_security::{GeneralSecurityProfile, MixedScript, skeleton};

use crate::text::{Both, both};

/// Longest name, characters.
const NAME_MAX: usize = 64;
/// Names under which the hub itself, its zone controller, and a hub without login are in the audit log.
const RESERVED: [&str; 3] = ["hub", "zones", "demo"];
/// First word of the names under which devices report detectors: `modbus panel unit 1`.
const DEVICES: &str = "modbus";

/// What is wrong with a new name, beside those that there are.
pub fn problem<'a>(name: &str, taken: impl IntoIterator<Item = &'a str>) -> Option<Both> {
    let fine = |c: char| c.identifier_allowed() || " .-_@+'".contains(c);
    let length = name.chars().count();
    if !(1..=NAME_MAX).contains(&length) || name.trim() != name || name.contains("  ") {
        return Some(both(
            "A name has 1…64 characters, without spaces at its ends.",
            "Имя — 1…64 знака, без пробелов по краям.",
        ));
    }
    if !name.chars().all(fine) {
        return Some(both(
            "A name has letters, digits, spaces and . - _ @ + ' only.",
            "В имени допустимы буквы, цифры, пробелы и . - _ @ + '.",
        ));
    }
    if !name.split(|c: char| !c.is_alphanumeric()).all(MixedScript::is_single_script) {
        return Some(both(
            "A word of a name has letters of one alphabet: Latin and Cyrillic ones look alike.",
            "Слово в имени — из букв одного алфавита: латинские и кириллические похожи.",
        ));
    }
    let looks = looks_of(name);
    let device = looks.split(' ').next() == Some(&looks_of(DEVICES));
    if device || RESERVED.iter().any(|it| looks_of(it) == looks) {
        return Some(both("This name is the hub's own.", "Это имя занято самим сервером объекта."));
    }
    let other = taken.into_iter().find(|it| *it != name && looks_of(it) == looks)?;
    Some(both(
        format!("This name looks like “{other}”, which there is already."),
        format!("Это имя похоже на «{other}», которое уже есть."),
    ))
}

/// Names that look alike have the same.
fn looks_of(name: &str) -> String {
    skeleton(&name.to_lowercase()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_can_be_taken_for_others_are_refused() {
        for name in ["anna", "Анна Петрова", "o'neill", "scada-2", "operator.west", "ab@site"]
        {
            assert_eq!(problem(name, ["root"]), None, "{name}");
        }
        let bidi = "an\u{202e}na";
        let zero_width = "ro\u{200b}ot";
        for name in [
            "",
            " a",
            "a\tb",
            bidi,
            zero_width,
            "r\u{43e}ot",
            "hub",
            "Demo",
            "a/b",
            "Modbus a unit 1",
        ] {
            assert!(problem(name, []).is_some(), "{name:?}");
        }
        // All of it Cyrillic, and looks like a Latin name.
        assert!(problem("\u{441}\u{43e}\u{441}\u{43e}", ["coco"]).is_some());
        assert!(problem("Root", ["root"]).is_some());
        assert_eq!(problem("root", ["root"]), None, "the same name is another matter");
    }
}
