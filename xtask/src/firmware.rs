//! `cargo xtask firmware`: builds the monitor's program for each board with a Cortex-M3, and tests
//! or runs it on the emulated one.

use std::path::PathBuf;
use std::process::{Command, ExitCode};

use crate::run::{StepResult, cargo, output, root, show};
use crate::{TaskResult, no_std, setup, size};

pub const BOARDS: [&str; 2] = [EMULATED, "stm32f103"];
/// The board that QEMU emulates.
pub const EMULATED: &str = "lm3s6965";
const QEMU: &str = "qemu-system-arm";

pub fn firmware(arguments: &[String]) -> TaskResult {
    let Some((what, rest)) = arguments.split_first() else {
        return Err("firmware build, test, load or run?".into());
    };
    match (what.as_str(), rest) {
        ("build", []) => BOARDS.into_iter().try_for_each(|board| build(board).map(|_| ()))?,
        ("test", rest) => test(rest)?,
        ("load", []) => load()?,
        ("run", rest) => run(rest)?,
        _ => {
            return Err(format!("firmware {}: build, test, load or run", arguments.join(" ")));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Links the program for every board, which fails if a panic can be reached; checks its size,
/// compares the emulated chip with the host, and lets it extinguish a fire.
pub fn check() -> StepResult {
    size::check()?;
    test(&["--seeds".into(), "2".into(), "--steps".into(), "1000".into()])?;
    load()
}

/// Builds the program for a board; returns the path of the ELF file.
pub fn build(board: &str) -> Result<PathBuf, String> {
    let folder = no_std::target().join("firmware").join(board);
    let mut build = no_std::build(Some(&folder))?;
    build.current_dir(root().join("firmware"));
    build.args(["--release", "--locked", "--no-default-features", "--features", board]);
    show(&mut build)?;
    Ok(folder.join(no_std::TARGET).join("release/lafet-firmware"))
}

fn test(arguments: &[String]) -> StepResult {
    emulator()?;
    let program = build(EMULATED)?;
    let stack = size::stack_of(&program)?.to_string();
    let mut test = on_host(&["--package", "lafet-sim", "--example", "chip"]);
    show(test.arg(&program).args(["--stack", &stack]).args(arguments))
}

/// Counts the instructions of steps and answers on the emulated chip.
fn load() -> StepResult {
    emulator()?;
    let program = build(EMULATED)?;
    show(on_host(&["--package", "lafet-sim", "--example", "load"]).arg(&program))
}

fn run(arguments: &[String]) -> StepResult {
    emulator()?;
    let program = build(EMULATED)?;
    let mut sim = on_host(&["--package", "lafet"]);
    sim.args(["sim", "--on", "qemu", "--firmware"]).arg(&program);
    show(sim.args(arguments))
}

fn on_host(package: &[&str]) -> Command {
    let mut command = cargo(&["run", "--quiet", "--release"]);
    command.args(package).arg("--");
    command
}

fn emulator() -> StepResult {
    if output(Command::new(QEMU).arg("--version")).is_ok() {
        return Ok(());
    }
    setup::debian(&[QEMU])
}
