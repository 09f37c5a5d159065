//! Names of users and tokens that cannot be mistaken for one another.

use lafet_texts::{Text as _, hub as text};
use unicode_security::{GeneralSecurityProfile, MixedScript, skeleton};

use crate::text::Both;

/// Longest name, characters.
const NAME_MAX: usize = 64;
/// Names under which the hub itself, its zone controller, and a hub without login are in the audit log.
const RESERVED: [&str; 3] = ["hub", "zones", "demo"];
/// First words of names of devices and plugs: `modbus panel unit 1`, `mqtt scada`, `opcua site`.
const DEVICES: [&str; 3] = ["modbus", "mqtt", "opcua"];

/// What is wrong with a new name, beside those that there are.
pub fn problem<'a>(name: &str, taken: impl IntoIterator<Item = &'a str>) -> Option<Both> {
    let fine = |c: char| c.identifier_allowed() || " .-_@+'".contains(c);
    let length = name.chars().count();
    if !(1..=NAME_MAX).contains(&length) || name.trim() != name || name.contains("  ") {
        return Some(text::NameLength.words());
    }
    if !name.chars().all(fine) {
        return Some(text::NameCharacters.words());
    }
    // An address ends names of dots alone: such a user could not be removed from a browser.
    if !name.contains(char::is_alphanumeric) {
        return Some(text::NameLetters.words());
    }
    if !name.split(|c: char| !c.is_alphanumeric()).all(MixedScript::is_single_script) {
        return Some(text::NameAlphabets.words());
    }
    let first = name.split(' ').next().unwrap_or_default();
    if DEVICES.iter().any(|it| are_alike(first, it))
        || RESERVED.iter().any(|it| are_alike(it, name))
    {
        return Some(text::NameOfHub.words());
    }
    let other = taken.into_iter().find(|it| *it != name && are_alike(it, name))?;
    Some(text::NameAlike { other }.words())
}

/// Whether names look alike, in any case of their letters. The capital I looks like 1 and l and the
/// small one does not, so names are compared before and after their letters are made small.
fn are_alike(one: &str, other: &str) -> bool {
    let looks = |name: &str| skeleton(&name.to_lowercase()).collect::<String>();
    let as_written = |name: &str| looks(&skeleton(name).collect::<String>());
    looks(one) == looks(other) || as_written(one) == as_written(other)
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
            ".",
            "..",
            "-",
            "Modbus a unit 1",
            "mqtt scada",
            "opcua site",
        ] {
            assert!(problem(name, []).is_some(), "{name:?}");
        }
        // All of it Cyrillic, and looks like a Latin name.
        assert!(problem("\u{441}\u{43e}\u{441}\u{43e}", ["coco"]).is_some());
        for (one, other) in
            [("Root", "root"), ("Il1", "l1l"), ("Ivan", "ivan"), ("o0o", "00O"), ("rn1", "Ml")]
        {
            assert!(problem(one, [other]).is_some(), "{one} {other}");
            assert!(problem(other, [one]).is_some(), "{other} {one}");
        }
        assert!(problem("a  b", []).is_some());
        assert_eq!(problem("root", ["root"]), None, "the same name is another matter");
    }
}
