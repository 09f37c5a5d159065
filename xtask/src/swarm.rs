//! `cargo xtask swarm`: random lives of simulated monitors, for any time.

use std::process::ExitCode;

use crate::TaskResult;
use crate::run::{StepResult, cargo, show};

/// The run for CI: enough seeds to see every behaviour, in at most two minutes.
const SHORT: [&str; 4] = ["--seeds", "0..600", "--minutes", "2"];
/// Every pair of faults once.
const PAIRS: [&str; 2] = ["--pairs", "1"];

pub fn swarm(arguments: &[String]) -> TaskResult {
    let status = command(arguments).status().map_err(|e| format!("cannot run cargo: {e}"))?;
    Ok(if status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The short runs of `cargo xtask ci`.
pub fn check() -> StepResult {
    show(&mut command(&SHORT.map(String::from)))?;
    show(&mut command(&PAIRS.map(String::from)))
}

fn command(arguments: &[String]) -> std::process::Command {
    let mut command =
        cargo(&["run", "--quiet", "--release", "--package", "lafet-sim", "--example", "swarm"]);
    command.arg("--").args(arguments);
    command
}
