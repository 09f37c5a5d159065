//! `cargo xtask firmware`: the monitor's program on a Cortex-M3, built for each board, tested on the
//! emulated one, or run there.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use crate::run::{StepResult, cargo, output, root, show};
use crate::{TaskResult, no_std, setup, size};

pub const BOARDS: [&str; 2] = [EMULATED, "stm32f103"];
/// The board that QEMU knows.
pub const EMULATED: &str = "lm3s6965";
const QEMU: &str = "qemu-system-arm";

pub fn firmware(arguments: &[String]) -> TaskResult {
    let Some((what, rest)) = arguments.split_first() else {
        return Err("firmware build, firmware test or firmware run?".into());
    };
    match (what.as_str(), rest) {
        ("build", []) => BOARDS.into_iter().try_for_each(|board| build(board).map(|_| ()))?,
        ("test", rest) => test(rest)?,
        ("run", rest) => run(rest)?,
        _ => return Err(format!("firmware {}: build, test or run", arguments.join(" "))),
    }
    Ok(ExitCode::SUCCESS)
}

/// Links the program for every board, which fails when a panic can be reached, looks how much it takes,
/// and compares the emulated chip with the host for a while.
pub fn check() -> StepResult {
    size::check()?;
    test(&["--seeds".into(), "2".into(), "--steps".into(), "1000".into()])
}

/// Builds the program for a board; the ELF file.
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
    show(on_host(&["--package", "lafet-sim", "--example", "chip"]).arg(&program).args(arguments))
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

/// Bytes of flash and of RAM that a program's sections take.
pub fn memory(program: &Path) -> Result<(u64, u64), String> {
    let bytes = std::fs::read(program).map_err(|e| format!("{}: {e}", program.display()))?;
    let damaged = || format!("{}: not an ELF file for the Cortex-M3", program.display());
    sections(&bytes).ok_or_else(damaged)
}

/// Sections that are loaded or cleared: those in flash, and those in RAM from 0x2000_0000.
fn sections(elf: &[u8]) -> Option<(u64, u64)> {
    const RAM: u32 = 0x2000_0000;
    const ALLOCATED: u32 = 2;
    const NO_BITS: u32 = 8;
    let word = |at: usize| Some(u32::from_le_bytes(*elf.get(at..)?.first_chunk()?));
    let half = |at: usize| Some(u16::from_le_bytes(*elf.get(at..)?.first_chunk()?));
    let (table, size, count) = (word(32)? as usize, usize::from(half(46)?), usize::from(half(48)?));
    let (mut flash, mut ram) = (0, 0);
    for section in (0..count).map(|index| table + index * size) {
        let (kind, flags) = (word(section + 4)?, word(section + 8)?);
        let (address, len) = (word(section + 12)?, u64::from(word(section + 20)?));
        if flags & ALLOCATED == 0 {
            continue;
        }
        if address >= RAM {
            ram += len;
        }
        // Data that is not zero stands in both.
        if address < RAM || kind != NO_BITS {
            flash += len;
        }
    }
    elf.starts_with(b"\x7fELF").then_some((flash, ram))
}
