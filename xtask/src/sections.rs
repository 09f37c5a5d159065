//! docs/sections.md: where each section of the protocol document is implemented and tested.

use std::collections::BTreeSet;

/// The file, relative to the root.
pub const PAGE: &str = "docs/sections.md";

const HEAD: &str = "# Sections of the protocol, code and tests

Written by `cargo xtask docs --tables` from the citations (`§3.1/4`) in code, tests and scenarios; `cargo xtask spec` prints the same
with line numbers, and fails in CI when a section has no code or no test. The statements are those of
[crates/conform/src/spec.txt](../crates/conform/src/spec.txt), the protocol is described in [protocol.md](protocol.md). `read` is what the document
says, `ours` what it leaves open and we decided ([questions.md](questions.md)).

## Files by section

Requests, and the flags of §3.3, have files with the number of their section. After a change to §3.14: the tests of its row, such as
`cargo test -p lafet-device --test it requests::`, and its scenario, `cargo test -p lafet-sim --test it scenarios::s3_14`.

| § | | protocol | device | scenario | tests |
|---|---|---|---|---|---|
";

/// A section with files of its own, relative to the root.
pub struct Own {
    pub id: String,
    pub title: String,
    /// Its request or flags on the wire.
    pub proto: BTreeSet<String>,
    /// What executes it: the file of this number, then others that cite it.
    pub device: Vec<String>,
    pub scenarios: BTreeSet<String>,
    /// Tests of these two crates that cite it.
    pub tests: BTreeSet<String>,
}

impl Own {
    /// What it lacks.
    pub fn missing(&self) -> Vec<&'static str> {
        let lacks = [
            ("no file of its number in crates/proto/src", self.proto.is_empty()),
            ("no file in crates/device/src", self.device.is_empty()),
            ("no scenario of its number", self.scenarios.is_empty()),
            ("no test in crates/proto or crates/device", self.tests.is_empty()),
        ];
        lacks.into_iter().filter(|(_, lacks)| *lacks).map(|(what, _)| what).collect()
    }
}

/// The section that the name of a file begins with: §3.14 for `s3_14_quench.rs` and `3.14-quench.txt`.
pub fn number_of(path: &str) -> Option<String> {
    let (name, extension) = path.rsplit('/').next()?.rsplit_once('.')?;
    let number: String = match extension {
        "rs" => {
            let parts = name.strip_prefix('s')?.split('_');
            let digits = |part: &&str| part.chars().all(|c| c.is_ascii_digit());
            parts.take_while(digits).collect::<Vec<_>>().join(".")
        }
        _ => name.split('-').next()?.into(),
    };
    let parts: Option<Vec<u8>> = number.split('.').map(|part| part.parse().ok()).collect();
    let parts: Vec<String> = parts?.iter().map(u8::to_string).collect();
    Some(format!("§{}", parts.join(".")))
}

/// A section and the files that cite it, relative to the root.
pub struct Row<'a> {
    pub id: &'a str,
    pub title: &'a str,
    pub label: &'a str,
    pub code: BTreeSet<String>,
    pub tests: BTreeSet<String>,
}

/// The page: a table for each chapter, which ends where the number before the slash changes.
pub fn page(own: &[Own], rows: &[Row<'_>]) -> String {
    let mut text = HEAD.to_owned();
    for Own { id, title, proto, device, scenarios, tests } in own {
        let (proto, device) = (links(proto), links(device));
        let (scenarios, tests) = (links(scenarios), links(tests));
        text += &format!("| {id} | {title} | {proto} | {device} | {scenarios} | {tests} |\n");
    }
    let mut chapter = "";
    for row in rows {
        let own = row.id.split('/').next().unwrap_or(row.id);
        if own != chapter {
            chapter = own;
            text += &format!(
                "\n## {own}\n\n| § | statement | | code | scenarios | tests |\n|---|---|---|---|---|---|\n"
            );
        }
        let (scenarios, tests): (BTreeSet<&String>, BTreeSet<&String>) =
            row.tests.iter().partition(|file| file.starts_with("conformance/"));
        text += &format!(
            "| {} | {} | {} | {} | {} | {} |\n",
            row.id,
            row.title.replace('|', "\\|"),
            row.label,
            links(&row.code),
            links(scenarios),
            links(tests),
        );
    }
    text
}

fn links<'a>(files: impl IntoIterator<Item = &'a String>) -> String {
    let link = |file: &String| {
        let short = file.trim_start_matches("crates/").trim_start_matches("conformance/scenarios/");
        format!("[{}](../{file})", short.replace("/src/", "/").trim_end_matches(".txt"))
    };
    files.into_iter().map(link).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chapter_has_a_table_and_a_file_a_link() {
        let files = |all: &[&str]| all.iter().map(|it| (*it).to_owned()).collect::<BTreeSet<_>>();
        let row = |id, tests: &[&str]| Row {
            id,
            title: "A | B",
            label: "read",
            code: files(&["crates/device/src/execute.rs"]),
            tests: files(tests),
        };
        let rows = [
            row("§3.1", &["conformance/scenarios/3.01-move.txt", "crates/device/tests/a.rs"]),
            row("§3.1/1", &[]),
            row("§3.2/1", &[]),
        ];
        let own = Own {
            id: "§3.1".into(),
            title: "Move".into(),
            proto: files(&["crates/proto/src/request/s3_01_move.rs"]),
            device: vec!["crates/device/src/execute/s3_01_move.rs".into()],
            scenarios: files(&[]),
            tests: files(&[]),
        };
        let page = page(&[own], &rows);
        let first = "| §3.1 | Move | \
                     [proto/request/s3_01_move.rs](../crates/proto/src/request/s3_01_move.rs) | \
                     [device/execute/s3_01_move.rs](../crates/device/src/execute/s3_01_move.rs) |  |  |";
        assert!(page.lines().any(|it| it == first), "{page}");
        let line = "| §3.1 | A \\| B | read | [device/execute.rs](../crates/device/src/execute.rs) | \
                    [3.01-move](../conformance/scenarios/3.01-move.txt) | \
                    [device/tests/a.rs](../crates/device/tests/a.rs) |";
        assert!(page.lines().any(|it| it == line), "{page}");
        assert_eq!(page.matches("\n## ").count(), 3);
    }

    #[test]
    fn a_name_begins_with_the_number_of_its_section() {
        let number = |path| number_of(path).unwrap_or_default();
        assert_eq!(number("crates/proto/src/request/s3_01_move.rs"), "§3.1");
        assert_eq!(number("crates/proto/src/status/s3_03_10_buttons.rs"), "§3.3.10");
        assert_eq!(number("conformance/scenarios/3.14-quench.txt"), "§3.14");
        assert_eq!(number("conformance/scenarios/3.03.05-valves.txt"), "§3.3.5");
        for other in
            ["crates/proto/src/request/mod.rs", "crates/sim/src/sim.rs", "s_1.rs", "D-x.txt"]
        {
            assert_eq!(number_of(other), None, "{other}");
        }
    }

    #[test]
    fn what_a_section_lacks_is_named() {
        let mut own = Own {
            id: "§3.1".into(),
            title: String::new(),
            proto: BTreeSet::new(),
            device: Vec::new(),
            scenarios: BTreeSet::new(),
            tests: BTreeSet::new(),
        };
        assert_eq!(own.missing().len(), 4);
        own.tests.insert("crates/device/tests/it/drive.rs".into());
        own.device.push("crates/device/src/execute/s3_01_move.rs".into());
        let missing = own.missing();
        assert_eq!(
            missing,
            ["no file of its number in crates/proto/src", "no scenario of its number"]
        );
    }
}
