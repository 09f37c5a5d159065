//! Prints how each flag and each status is reached, from `conformance/faults.txt`: the table that
//! `cargo xtask faults` writes into docs/faults.md; behind a form feed each, what detects which fault, in English and
//! in Russian, for the safety manuals.

use std::path::Path;

use lafet_texts::Lang;
use lafet_verify::faults_table::{Table, detected, page};

/// Prints the tables.
pub fn run() -> Result<(), String> {
    print!("{}", table()?);
    Ok(())
}

fn table() -> Result<String, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../conformance/faults.txt");
    let text = std::fs::read_to_string(&path)
        .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    let table = Table::parse("faults.txt", &text).map_err(|failure| failure.to_string())?;
    let holes = table.holes();
    if !holes.is_empty() {
        return Err(format!("faults.txt has {} holes:\n  {}", holes.len(), holes.join("\n  ")));
    }
    let measured = table.measure().map_err(|failures| {
        let texts: Vec<String> = failures.iter().map(ToString::to_string).collect();
        format!("{} rows do not hold:\n\n{}", texts.len(), texts.join("\n\n"))
    })?;
    let english = detected(&measured, Lang::En);
    let russian = detected(&measured, Lang::Ru);
    Ok([page(&measured), english, russian].join("\u{c}"))
}
