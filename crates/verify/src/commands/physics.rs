//! Prints the tables of docs/physics.md, each behind a line `== name`: `cargo xtask physics`.

/// Prints the tables.
pub fn run() -> Result<(), String> {
    for (name, table) in lafet_verify::validation::page() {
        println!("== {name}\n{table}");
    }
    Ok(())
}
