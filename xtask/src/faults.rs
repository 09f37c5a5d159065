//! `cargo xtask faults`: how each flag and status is reached, for docs/faults.md.

use std::process::ExitCode;

use crate::run::{self, StepResult};
use crate::{TaskResult, flag};

const PAGE: &str = "docs/faults.md";

pub fn faults(arguments: &[String]) -> TaskResult {
    if flag(arguments, Some("--check"))? {
        return check().map(|()| ExitCode::SUCCESS);
    }
    let table = table()?;
    print!("{table}");
    let old = run::read(PAGE)?;
    let new = regenerate(&old, &table)?;
    std::fs::write(run::root().join(PAGE), &new).map_err(|e| format!("{PAGE}: {e}"))?;
    println!("\n   {PAGE}: {}", if old == new { "was up to date" } else { "written" });
    Ok(ExitCode::SUCCESS)
}

/// Fails on a flag or status that is not reached, and on an outdated table.
pub fn check() -> StepResult {
    let table = table()?;
    let page = run::read(PAGE)?;
    let fresh = regenerate(&page, &table)?;
    if page == fresh {
        let summary = table.lines().next().unwrap_or_default();
        println!("   {summary}\n   the table of {PAGE} is up to date");
        return Ok(());
    }
    let place = page.lines().zip(fresh.lines()).position(|(old, new)| old != new);
    let line = place.unwrap_or_else(|| page.lines().count().min(fresh.lines().count())) + 1;
    let want = fresh.lines().nth(line - 1).unwrap_or("(the end)");
    Err(format!("{PAGE}:{line} is out of date: run `cargo xtask faults`. It should read\n  {want}"))
}

/// Runs every row in the simulator; an error names the rows that fail and the flags without a row.
fn table() -> Result<String, String> {
    let arguments = ["run", "--quiet", "--package", "lafet-sim", "--example", "faults"];
    run::output(&mut run::cargo(&arguments))
}

fn regenerate(page: &str, table: &str) -> Result<String, String> {
    run::put(PAGE, page, "faults", table)
}

#[cfg(test)]
mod tests {
    use super::*;

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
