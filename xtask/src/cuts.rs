//! `cargo xtask cuts`: random power cuts, in any number.

use std::process::ExitCode;
use std::time::Instant;

use crate::TaskResult;
use crate::run::{cargo, show, show_tests};

/// A program with a test `random_cuts`, and the variable that sets their number.
struct Level {
    name: &'static str,
    package: &'static str,
    test: &'static str,
    variable: &'static str,
}

const LEVELS: [Level; 2] = [
    Level { name: "store", package: "lafet-device", test: "store", variable: "LAFET_STORE_CUTS" },
    Level { name: "monitor", package: "lafet-sim", test: "it", variable: "LAFET_MONITOR_CUTS" },
];

pub fn cuts(arguments: &[String]) -> TaskResult {
    let wanted = "it takes store or monitor, and a number of cuts";
    let (name, count) = match arguments {
        [name, count] => (name, count),
        [name] => (name, &"1000000".to_owned()),
        _ => return Err(wanted.into()),
    };
    let level = LEVELS.iter().find(|level| level.name == name).ok_or(wanted)?;
    let count: u64 = count.replace('_', "").parse().map_err(|_| wanted)?;
    let test = |arguments: &[&str]| {
        let mut command = cargo(&["test", "--release", "-q", "-p", level.package]);
        command.args(["--test", level.test]).args(arguments);
        command.env(level.variable, count.to_string());
        command
    };
    // Built first, so that the measured rate is that of the cuts alone.
    show(&mut test(&["--no-run"]))?;
    let start = Instant::now();
    show_tests(&mut test(&["random_cuts", "--", "--nocapture"]))?;
    let seconds = start.elapsed().as_secs_f64();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let rate = count as f64 / seconds;
    println!(
        "{count} cuts of a {name} in {seconds:.0} s: {rate:.0} a second on {threads} threads; \
         1e8 would take {:.1} h",
        1e8 / rate / 3600.0
    );
    Ok(ExitCode::SUCCESS)
}
