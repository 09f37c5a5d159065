//! Texts of the catalogues (`crates/texts`) that no code uses. The rest of what must hold of them is
//! checked when they are compiled.

use std::collections::BTreeSet;

use crate::run;
use crate::source::{self, File};

/// The catalogues of the first language; the others have the same keys.
const CATALOGUES: &str = "crates/texts/catalogues/en";
/// Catalogues whose keys belong to rows of tables, of which other tests find those without one: the dictionary of
/// the protocol (a test of lafet-texts), commands and arguments (a test of lafet), faults of the simulator (a test of
/// lafet-play).
const OF_TABLES: [&str; 3] = ["proto", "help", "fault"];
/// How a crate calls the texts of a catalogue: `use lafet_texts::site as text`.
const PATH: &str = "text::";

/// A line for each text that no crate which imports its catalogue uses.
pub fn unused() -> Result<Vec<String>, String> {
    let files = source::workspace()?;
    let mut problems = Vec::new();
    for path in source::files_under(&run::root().join(CATALOGUES), "ftl")? {
        let path = source::relative(&path);
        let Some(area) = path.rsplit('/').next().and_then(|name| name.strip_suffix(".ftl")) else {
            continue;
        };
        if OF_TABLES.contains(&area) {
            continue;
        }
        let import = format!("{area} as text");
        let imports = |file: &&File| file.product().any(|(_, line)| line.code.contains(&import));
        let users: BTreeSet<_> = files.iter().filter(imports).map(File::crate_name).collect();
        let of_area = files.iter().filter(|file| users.contains(&file.crate_name()));
        let code = of_area.flat_map(File::product).map(|(_, line)| line.code.as_str());
        problems.extend(unused_in(&path, &run::read(&path)?, &used(code)));
    }
    Ok(problems)
}

/// The names behind `text::`.
fn used<'a>(lines: impl Iterator<Item = &'a str>) -> BTreeSet<&'a str> {
    let of_name = |c: char| c.is_alphanumeric() || c == '_';
    lines
        .flat_map(|line| line.match_indices(PATH).map(move |(start, _)| line.split_at(start)))
        .filter(|(before, _)| !before.ends_with(of_name))
        .filter_map(|(_, from)| from[PATH.len()..].split(|c| !of_name(c)).next())
        .collect()
}

fn unused_in(path: &str, text: &str, used: &BTreeSet<&str>) -> Vec<String> {
    let lines = text.lines().enumerate();
    let keys = lines.filter(|(_, line)| line.starts_with(|c: char| c.is_ascii_lowercase()));
    let keys = keys.filter_map(|(index, line)| Some((index + 1, line.split_once(" =")?.0)));
    keys.filter(|(_, key)| !used.contains(type_name(key).as_str()))
        .map(|(number, key)| {
            let name = type_name(key);
            format!("{path}:{number}: {key} is not used: delete it, or use it as `{PATH}{name}`")
        })
        .collect()
}

/// The name of the structure that a text becomes.
fn type_name(key: &str) -> String {
    key.split('-').map(|word| word[..1].to_uppercase() + &word[1..]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_that_no_code_uses_are_named() {
        let catalogue = "# not = a key\nlost = lost\nall-out = { $a } = all\n";
        let code = ["say(text::Lost, 1);", "let a = text::AllOut { a: 1 };"];
        assert_eq!(unused_in("a.ftl", catalogue, &used(code.into_iter())), [""; 0]);
        let without = unused_in("a.ftl", catalogue, &used(code.into_iter().take(1)));
        assert_eq!(without.len(), 1);
        assert!(without[0].starts_with("a.ftl:3: all-out is not used"), "{without:?}");
    }

    #[test]
    fn another_path_or_a_longer_name_is_no_use() {
        let code = ["context::Lost", "text::LostAgain", "Lost"];
        assert_eq!(unused_in("a.ftl", "lost = lost\n", &used(code.into_iter())).len(), 1);
    }

    #[test]
    fn every_text_of_the_project_is_used() {
        assert_eq!(unused(), Ok(Vec::new()));
    }
}
