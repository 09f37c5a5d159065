//! `cargo xtask stops`: Stops and Lockouts at random moments, in any number.

use std::process::ExitCode;
use std::time::Instant;

use crate::TaskResult;
use crate::run::{cargo, show, show_tests};

pub fn stops(arguments: &[String]) -> TaskResult {
    let wanted = "it takes --cases N";
    let count = match arguments {
        [] => "1000000".into(),
        [flag, count] if flag == "--cases" => count.replace('_', ""),
        _ => return Err(wanted.into()),
    };
    count.parse::<u64>().map_err(|_| wanted)?;
    let test = |arguments: &[&str]| {
        let mut command = cargo(&["test", "--release", "-q", "-p", "lafet-device"]);
        command.args(["--test", "stops"]).args(arguments);
        command.env("LAFET_STOP_CASES", &count);
        command
    };
    show(&mut test(&["--no-run"]))?;
    let start = Instant::now();
    show_tests(&mut test(&["--", "--nocapture"]))?;
    println!("{:.0} s", start.elapsed().as_secs_f64());
    Ok(ExitCode::SUCCESS)
}
