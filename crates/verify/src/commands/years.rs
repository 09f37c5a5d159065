//! Years in the life of a monitor: `cargo xtask years`.

use std::time::Instant;

use clap::Args;
use lafet_verify::years::{YEAR_DAYS, Years};

#[derive(Args)]
pub struct Options {
    /// How many years
    #[arg(default_value_t = 10)]
    years: u32,
    /// Seed of the life
    #[arg(default_value_t = 1)]
    seed: u64,
}

/// Runs the years and prints each.
pub fn run(options: &Options) -> Result<(), String> {
    let mut years = Years::new(options.seed);
    let start = Instant::now();
    for year in 1..=options.years {
        for _ in 0..YEAR_DAYS {
            years.day()?;
        }
        let seconds = start.elapsed().as_secs_f64();
        let report = years.report();
        println!(
            "year {year:>3}: {} tests, {} fires, {} faults, {} wraps, {:.0} m³ in {seconds:.1} s",
            report.tests, report.fires, report.faults, report.wraps, report.water_m3
        );
    }
    let seconds = start.elapsed().as_secs_f64();
    let pace = years.report().ms as f64 / 1_000.0 / seconds;
    print!("\n{}", years.report());
    println!("{:<30} {seconds:.1} s, {pace:.0} × real time on one core", "took");
    Ok(())
}
