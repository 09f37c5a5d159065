//! docs/sections.md: where each section of the protocol document is implemented and tested.

use std::collections::BTreeSet;

/// The file, relative to the root.
pub const PAGE: &str = "docs/sections.md";

const HEAD: &str = "# Sections of the protocol, code and tests

Written by `cargo xtask docs --tables` from the citations (`§3.1/4`) in code, tests and scenarios; `cargo xtask spec` prints the same
with line numbers, and fails in CI when a section has no code or no test. The statements are those of
[crates/conform/src/spec.txt](../crates/conform/src/spec.txt), the protocol is described in [protocol.md](protocol.md). `read` is what the document
says, `ours` what it leaves open and we decided ([questions.md](questions.md)).
";

/// A section and the files that cite it, relative to the root.
pub struct Row<'a> {
    pub id: &'a str,
    pub title: &'a str,
    pub label: &'a str,
    pub code: BTreeSet<String>,
    pub tests: BTreeSet<String>,
}

/// The page: a table for each chapter, which ends where the number before the slash changes.
pub fn page(rows: &[Row<'_>]) -> String {
    let mut text = HEAD.to_owned();
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
        let page = page(&rows);
        let line = "| §3.1 | A \\| B | read | [device/execute.rs](../crates/device/src/execute.rs) | \
                    [3.01-move](../conformance/scenarios/3.01-move.txt) | \
                    [device/tests/a.rs](../crates/device/tests/a.rs) |";
        assert!(page.lines().any(|it| it == line), "{page}");
        assert_eq!(page.matches("\n## ").count(), 2);
    }
}
