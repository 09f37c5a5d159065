//! Prints the tables of docs/physics.md, each behind a line `== name`: `cargo xtask physics`.

fn main() {
    for (name, table) in lafet_sim::validation::page() {
        println!("== {name}\n{table}");
    }
}
