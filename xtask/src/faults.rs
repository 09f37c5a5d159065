//! `cargo xtask faults`: how each flag and status is reached, for docs/faults.md and
//! docs/faults.ru.md.

use std::process::ExitCode;

use crate::run::{self, StepResult};
use crate::{TaskResult, flag};

mod russian;

const PAGE: &str = "docs/faults.md";
const RUSSIAN_PAGE: &str = "docs/faults.ru.md";

pub fn faults(arguments: &[String]) -> TaskResult {
    if flag(arguments, Some("--check"))? {
        return check().map(|()| ExitCode::SUCCESS);
    }
    let table = table()?;
    print!("{table}");
    for (page, old, new) in pages(&table)? {
        std::fs::write(run::root().join(page), &new).map_err(|e| format!("{page}: {e}"))?;
        println!("\n   {page}: {}", if old == new { "was up to date" } else { "written" });
    }
    Ok(ExitCode::SUCCESS)
}

/// Fails on a flag or status that is not reached, and on an outdated table.
pub fn check() -> StepResult {
    let table = table()?;
    for (path, page, fresh) in pages(&table)? {
        if page == fresh {
            continue;
        }
        let place = page.lines().zip(fresh.lines()).position(|(old, new)| old != new);
        let line = place.unwrap_or_else(|| page.lines().count().min(fresh.lines().count())) + 1;
        let want = fresh.lines().nth(line - 1).unwrap_or("(the end)");
        return Err(format!(
            "{path}:{line} is out of date: run `cargo xtask faults`. It should read\n  {want}"
        ));
    }
    let summary = table.lines().next().unwrap_or_default();
    println!("   {summary}\n   the tables of {PAGE} and {RUSSIAN_PAGE} are up to date");
    Ok(())
}

/// The pages as they are, and with this table.
fn pages(table: &str) -> Result<[(&'static str, String, String); 2], String> {
    let translated = russian::table(table)?;
    let page = |path, table: &str| {
        let old = run::read(path)?;
        let new = regenerate(path, &old, table)?;
        Ok::<_, String>((path, old, new))
    };
    Ok([page(PAGE, table)?, page(RUSSIAN_PAGE, &translated)?])
}

/// Runs every row in the simulator; an error names the rows that fail and the flags without a row.
fn table() -> Result<String, String> {
    let arguments = ["run", "--quiet", "--package", "lafet-sim", "--example", "faults"];
    run::output(&mut run::cargo(&arguments))
}

fn regenerate(path: &str, page: &str, table: &str) -> Result<String, String> {
    run::put(path, page, "faults", table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_put_between_its_marks() {
        let page = "# Faults\n<!-- faults:begin -->\nold\n<!-- faults:end -->\nthe end\n";
        let new = regenerate(PAGE, page, "new | row\n").unwrap();
        assert_eq!(new, page.replace("old", "new | row"));
        assert_eq!(regenerate(PAGE, &new, "new | row\n").unwrap(), new);
    }

    #[test]
    fn marks_that_are_missing_are_errors() {
        for page in ["", "<!-- faults:begin -->\n", "<!-- faults:end -->\n<!-- faults:begin -->\n"]
        {
            assert!(regenerate(PAGE, page, "").unwrap_err().contains("is missing"), "{page}");
        }
    }

    #[test]
    fn the_table_of_the_page_has_a_russian_form() {
        let page = run::read(PAGE).unwrap();
        let (_, rest) = page.split_once("<!-- faults:begin -->\n").unwrap();
        let (table, _) = rest.split_once("<!-- faults:end -->").unwrap();
        let translated = russian::table(table).unwrap();
        assert_eq!(
            regenerate(RUSSIAN_PAGE, &run::read(RUSSIAN_PAGE).unwrap(), &translated),
            run::read(RUSSIAN_PAGE)
        );
    }
}
