//! `cargo xtask model`: model-checks the interlock with `lafet-model`.

use std::process::ExitCode;

use crate::TaskResult;
use crate::run::{self, StepResult};

/// Longest time for each configuration without arguments, s: 12 minutes together.
const SECONDS: &str = "75";

pub fn model(arguments: &[String]) -> TaskResult {
    let mut command = command();
    if arguments.is_empty() {
        command.args(["--seconds", SECONDS]);
    }
    let status = command.args(arguments).status().map_err(|e| format!("cannot run cargo: {e}"))?;
    Ok(if status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Fails on a broken law and on a behaviour that is never seen.
pub fn check() -> StepResult {
    run::show(command().args(["--quick"]))
}

fn command() -> std::process::Command {
    let mut command = run::cargo(&["run", "--quiet", "--release", "--package", "lafet-model"]);
    command.arg("--");
    command
}
