//! `cargo xtask model`: the interlock, model-checked by `lafet-model`.

use std::process::ExitCode;

use crate::TaskResult;
use crate::run::{self, StepResult};

/// Without arguments each configuration is walked for this long at most, s: 12 minutes together.
const SECONDS: &str = "75";

pub fn model(arguments: &[String]) -> TaskResult {
    let mut command = command();
    if arguments.is_empty() {
        command.args(["--seconds", SECONDS]);
    }
    let status = command.args(arguments).status().map_err(|e| format!("cannot run cargo: {e}"))?;
    Ok(if status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Fails on a law that is broken and on a behaviour that is never seen.
pub fn check() -> StepResult {
    run::show(command().args(["--quick"]))
}

fn command() -> std::process::Command {
    let mut command = run::cargo(&["run", "--quiet", "--release", "--package", "lafet-model"]);
    command.arg("--");
    command
}
