//! `cargo xtask demo`: the first command for a newcomer.

use std::process::Command;

use crate::{TaskResult, console, run, setup};

pub fn demo(arguments: &[String]) -> TaskResult {
    setup::rust()?;
    console::build()?;
    become_command(&mut command(arguments))
}

/// `lafet demo` as users run it, from the release build.
pub fn command(arguments: &[String]) -> Command {
    let mut command = run::cargo(&[
        "run",
        "--profile",
        "demo",
        "--package",
        "lafet",
        "--no-default-features",
        "--",
        "demo",
    ]);
    command.args(arguments);
    command
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
