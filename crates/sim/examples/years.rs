//! Years in the life of a monitor: `years [how many] [seed]`, ten if not told.

use std::time::Instant;

use lafet_sim::years::{YEAR_DAYS, Years};

fn main() -> Result<(), String> {
    let number = |index: usize, default: u64| match std::env::args().nth(index) {
        Some(text) => text.parse().map_err(|_| format!("`{text}`: expected a whole number")),
        None => Ok(default),
    };
    let (count, seed) = (number(1, 10)?, number(2, 1)?);
    let mut years = Years::new(seed);
    let start = Instant::now();
    for year in 1..=count {
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
