//! `cargo xtask physics`: the tables of docs/physics.md, computed by the simulator.

use std::process::ExitCode;

use crate::run::{self, StepResult};
use crate::{TaskResult, flag, verify};

const PAGE: &str = "docs/physics.md";

pub fn physics(arguments: &[String]) -> TaskResult {
    if flag(arguments, Some("--check"))? {
        return check().map(|()| ExitCode::SUCCESS);
    }
    let tables = tables()?;
    let old = run::read(PAGE)?;
    let new = regenerate(&old, &tables)?;
    for (name, table) in &tables {
        println!("{name}\n{table}");
    }
    std::fs::write(run::root().join(PAGE), &new).map_err(|e| format!("{PAGE}: {e}"))?;
    println!("   {PAGE}: {}", if old == new { "was up to date" } else { "written" });
    Ok(ExitCode::SUCCESS)
}

/// Fails on a table that differs from the models.
pub fn check() -> StepResult {
    let page = run::read(PAGE)?;
    let fresh = regenerate(&page, &tables()?)?;
    let Some(line) = page.lines().zip(fresh.lines()).position(|(old, new)| old != new) else {
        return if page.len() == fresh.len() {
            println!("   the tables of {PAGE} are up to date");
            Ok(())
        } else {
            Err(format!("{PAGE}: a table has more or fewer rows: run `cargo xtask physics`"))
        };
    };
    let want = fresh.lines().nth(line).unwrap_or("(the end)");
    let line = line + 1;
    Err(format!(
        "{PAGE}:{line} is out of date: run `cargo xtask physics`. It should read\n  {want}"
    ))
}

/// The tables by name, as the simulator prints them.
fn tables() -> Result<Vec<(String, String)>, String> {
    let printed = run::output(&mut verify::tested("physics"))?;
    let mut tables: Vec<(String, String)> = Vec::new();
    for line in printed.lines().filter(|line| !line.is_empty()) {
        match (line.strip_prefix("== "), tables.last_mut()) {
            (Some(name), _) => tables.push((name.to_owned(), String::new())),
            (None, Some((_, table))) => *table += &format!("{line}\n"),
            (None, None) => return Err(format!("`physics` started with `{line}`")),
        }
    }
    Ok(tables)
}

/// The page with new tables between `<!-- NAME:begin -->` and `<!-- NAME:end -->`. Every table must
/// have its place, and every place its table.
fn regenerate(page: &str, tables: &[(String, String)]) -> Result<String, String> {
    let mut fresh = String::new();
    let mut left: Vec<&str> = tables.iter().map(|(name, _)| name.as_str()).collect();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        fresh += line;
        fresh.push('\n');
        let mark = line.strip_prefix("<!-- ").and_then(|line| line.strip_suffix(":begin -->"));
        let Some(name) = mark else { continue };
        let table = tables.iter().find(|(known, _)| known == name);
        let (_, table) = table.ok_or_else(|| format!("{PAGE}: no table is called `{name}`"))?;
        let end = format!("<!-- {name}:end -->");
        if !lines.any(|line| line == end) {
            return Err(format!("{PAGE}: `{end}` is missing"));
        }
        fresh += &format!("{table}{end}\n");
        left.retain(|known| *known != name);
    }
    match left[..] {
        [] => Ok(fresh),
        _ => Err(format!("{PAGE}: no marks for {}", left.join(", "))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_find_their_places() {
        let tables = vec![("flow".to_owned(), "| new |\n".to_owned())];
        let page = "head\n<!-- flow:begin -->\n| old |\n<!-- flow:end -->\ntail\n";
        let fresh = regenerate(page, &tables).unwrap();
        assert_eq!(fresh, page.replace("old", "new"));
        assert!(regenerate("no marks\n", &tables).is_err());
        assert!(regenerate("<!-- flow:begin -->\n", &tables).is_err());
        assert!(regenerate("<!-- flood:begin -->\n<!-- flood:end -->\n", &tables).is_err());
    }
}
