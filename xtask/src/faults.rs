//! `cargo xtask faults`: how each flag and status is reached, for docs/faults.md and its Russian form; and what
//! reports each fault, for the safety manual.

use std::process::ExitCode;

use crate::run::{self, StepResult};
use crate::{TaskResult, flag, verify};

mod russian;

/// The pages, and the section of each that is generated.
const PAGES: [(&str, &str); 4] = [
    ("docs/faults.md", "faults"),
    ("docs/faults.ru.md", "faults"),
    ("docs/safety-manual.md", "detected"),
    ("docs/safety-manual.ru.md", "detected"),
];
/// What the program prints between two tables.
const BETWEEN: char = '\u{c}';

pub fn faults(arguments: &[String]) -> TaskResult {
    if flag(arguments, Some("--check"))? {
        return check().map(|()| ExitCode::SUCCESS);
    }
    let tables = tables()?;
    println!("{}", tables[0]);
    for ((path, name), table) in PAGES.iter().zip(&tables) {
        let old = run::read(path)?;
        let new = run::put(path, &old, name, table)?;
        std::fs::write(run::root().join(path), &new).map_err(|e| format!("{path}: {e}"))?;
        println!("   {path}: {}", if old == new { "was up to date" } else { "written" });
    }
    Ok(ExitCode::SUCCESS)
}

/// Fails on a flag or status that is not reached, and on an outdated table.
pub fn check() -> StepResult {
    let tables = tables()?;
    for ((path, name), table) in PAGES.iter().zip(&tables) {
        let page = run::read(path)?;
        compare(path, &page, &run::put(path, &page, name, table)?)?;
    }
    let summary = tables[0].lines().next().unwrap_or_default();
    let paths = PAGES.map(|(path, _)| path).join(", ");
    println!("   {summary}\n   up to date: {paths}");
    Ok(())
}

fn compare(path: &str, page: &str, fresh: &str) -> StepResult {
    if page == fresh {
        return Ok(());
    }
    let place = page.lines().zip(fresh.lines()).position(|(old, new)| old != new);
    let line = place.unwrap_or_else(|| page.lines().count().min(fresh.lines().count())) + 1;
    let want = fresh.lines().nth(line - 1).unwrap_or("(the end)");
    Err(format!("{path}:{line} is out of date: run `cargo xtask faults`. It should read\n  {want}"))
}

/// Runs every row in the simulator; an error names the rows that fail and the flags without a row. The
/// tables in the order of the pages.
fn tables() -> Result<[String; 4], String> {
    let [faults, english, translated] = split(&run::output(&mut verify::tested("faults"))?)?;
    Ok([faults.clone(), russian::table(&faults)?, english, translated])
}

fn split(text: &str) -> Result<[String; 3], String> {
    let tables: Vec<String> = text.split(BETWEEN).map(str::to_owned).collect();
    let count = tables.len();
    tables.try_into().map_err(|_| format!("`faults` printed {count} tables, not 3"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn regenerate(page: &str, table: &str) -> Result<String, String> {
        run::put("docs/faults.md", page, "faults", table)
    }

    #[test]
    fn each_page_has_its_table() {
        assert_eq!(split("a\n\u{c}b\n\u{c}c\n").unwrap(), ["a\n", "b\n", "c\n"]);
        for text in ["", "a\n\u{c}b\n", "a\u{c}b\u{c}c\u{c}d"] {
            assert!(split(text).unwrap_err().contains("not 3"), "{text:?}");
        }
    }

    #[test]
    fn an_outdated_line_is_named() {
        assert!(compare("page", "a\nb\n", "a\nb\n").is_ok());
        for (old, new) in [("a\nb\n", "a\nc\n"), ("a\n", "a\nb\n")] {
            assert!(compare("page", old, new).unwrap_err().starts_with("page:2 "), "{old:?}");
        }
    }

    #[test]
    fn the_table_is_put_between_its_marks() {
        let page = "# Faults\n<!-- faults:begin -->\nold\n<!-- faults:end -->\nthe end\n";
        let new = regenerate(page, "new | row\n").unwrap();
        assert_eq!(new, page.replace("old", "new | row"));
        assert_eq!(regenerate(&new, "new | row\n").unwrap(), new);
    }

    #[test]
    fn marks_that_are_missing_are_errors() {
        for page in ["", "<!-- faults:begin -->\n", "<!-- faults:end -->\n<!-- faults:begin -->\n"]
        {
            assert!(regenerate(page, "").unwrap_err().contains("is missing"), "{page}");
        }
    }
}
