//! `cargo xtask demo`: the first command for a newcomer.

use std::path::PathBuf;
use std::process::Command;

use crate::{TaskResult, console, run, setup};

pub fn demo(arguments: &[String]) -> TaskResult {
    setup::rust()?;
    console::build()?;
    become_command(&mut command(arguments))
}

/// What selects the program that the demo runs: quick to build.
const PROGRAM: [&str; 5] = ["--profile", "demo", "--package", "lafet", "--no-default-features"];

/// `lafet demo` as users run it.
pub fn command(arguments: &[String]) -> Command {
    let mut command = run::cargo(&["run"]);
    command.args(PROGRAM).args(["--", "demo"]).args(arguments);
    command
}

/// Builds the program that the demo runs; returns its path. All steps of CI that need a program take this
/// one, so that none waits for link-time optimization.
pub fn program() -> Result<PathBuf, String> {
    run::show(run::cargo(&["build", "--quiet"]).args(PROGRAM))?;
    Ok(run::target().join("demo/lafet"))
}

/// As [`program`], with the allocator of what is installed: for bounds of memory.
pub fn program_for_memory() -> Result<PathBuf, String> {
    let allocator = ["--features", "jemalloc"];
    run::show(run::cargo(&["build", "--quiet"]).args(PROGRAM).args(allocator))?;
    Ok(run::target().join("demo/lafet"))
}

/// Builds the program as it is installed, for figures; returns its path.
pub fn optimised() -> Result<PathBuf, String> {
    run::show(&mut run::cargo(&["build", "--quiet", "--release", "--package", "lafet"]))?;
    Ok(run::target().join("release/lafet"))
}

/// On Unix this process becomes the demo, so Ctrl-C, signals and the exit code are the demo's own.
#[cfg(unix)]
fn become_command(command: &mut Command) -> TaskResult {
    use std::os::unix::process::CommandExt;
    Err(format!("cannot run cargo: {}", command.exec()))
}

#[cfg(not(unix))]
fn become_command(command: &mut Command) -> TaskResult {
    let status = command.status().map_err(|e| format!("cannot run cargo: {e}"))?;
    Ok(std::process::ExitCode::from(status.code().and_then(|c| u8::try_from(c).ok()).unwrap_or(1)))
}
