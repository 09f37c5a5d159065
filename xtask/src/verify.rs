//! What the program of `crates/verify` does: `cargo xtask swarm`, `replay`, `years`, `model`.

use std::process::{Command, ExitCode};

use crate::TaskResult;
use crate::run::{self, StepResult, cargo, show};

/// Runs of the swarm for CI: enough seeds to see every behaviour, in at most two minutes, and every
/// pair of faults once.
const SWARM: [&[&str]; 2] = [&["--seeds", "0..1400", "--minutes", "2"], &["--pairs", "1"]];
/// Longest time for each configuration of the model without arguments, s: 12 minutes together.
const SECONDS: &str = "75";

/// The program with one of its commands, optimised.
fn program(name: &str) -> Command {
    let mut command = cargo(&["run", "--quiet", "--release", "--package", "lafet-verify", "--"]);
    command.arg(name);
    command
}

/// The same in the profile of the tests, which have built it already; it optimises what is simulated.
pub fn tested(name: &str) -> Command {
    let mut command = run::tested("lafet-verify");
    command.arg(name);
    command
}

pub fn swarm(arguments: &[String]) -> TaskResult {
    run("swarm", arguments)
}

pub fn replay(arguments: &[String]) -> TaskResult {
    run("replay", arguments)
}

pub fn years(arguments: &[String]) -> TaskResult {
    run("years", arguments)
}

pub fn model(arguments: &[String]) -> TaskResult {
    let limits = ["--seconds", SECONDS].map(String::from);
    run("model", if arguments.is_empty() { &limits } else { arguments })
}

/// Fails on an output that nothing explains, and on a behaviour that is never seen. In the profile of the
/// tests, which checks arithmetic too.
pub fn swarm_check() -> StepResult {
    SWARM.into_iter().try_for_each(|arguments| show(tested("swarm").args(arguments)))
}

/// Fails on a broken law and on a behaviour that is never seen.
pub fn model_check() -> StepResult {
    show(tested("model").arg("--quick"))
}

fn run(name: &str, arguments: &[String]) -> TaskResult {
    let status = program(name).args(arguments).status();
    let status = status.map_err(|error| format!("cannot run cargo: {error}"))?;
    Ok(if status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
