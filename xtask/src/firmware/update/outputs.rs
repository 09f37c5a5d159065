//! What a panic does to the outputs. The board has a lamp that is lit while the monitor drives anything, in a register that
//! a reset puts to rest; the emulator notes each write to it, each exception and each reset, in their order.

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::firmware::QEMU;
use crate::run::output;

/// What the emulator is to note.
const NOTES: &str = "int,trace:mps2_fpgaio_write,trace:mps2_fpgaio_reset";
/// As it notes them.
const WRITE: &str = "mps2_fpgaio_write MPS2 FPGAIO write: offset 0x0 data 0x";
const RESET: &str = "mps2_fpgaio_reset ";
const EXCEPTION: &str = "...taking pending nonsecure exception ";
/// The fault that a panic ends in.
const HARD_FAULT: u32 = 3;

/// Makes a folder with the emulator in it, under its own name, that notes all this in a file.
pub fn noting(folder: &Path, file: &Path) -> Result<(), String> {
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    let real = output(Command::new("sh").args(["-c", &format!("command -v {QEMU}")]))?;
    let (real, file) = (real.trim(), file.display());
    let script = format!("#!/bin/sh\nexec '{real}' \"$@\" -d {NOTES} -D '{file}'\n");
    std::fs::create_dir_all(folder).map_err(failed)?;
    let program: PathBuf = folder.join(QEMU);
    std::fs::write(&program, script).map_err(failed)?;
    let mode = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(&program, mode).map_err(failed)
}

/// What has been noted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Noted {
    /// Something is driven from now on, or nothing is.
    Driven(bool),
    Exception(u32),
    Reset,
}

/// How far the board is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Far {
    /// No panic has met a monitor that drives anything.
    Before,
    /// One has.
    Panicked,
    /// All was at rest at once, and has stayed so up to the next panic.
    Rested,
}

/// What the notes say.
///
/// # Errors
///
/// The panic is not followed by a reset at once, or something is driven after it.
pub fn judge(notes: &str) -> Result<Far, String> {
    let mut notes = notes.lines().filter_map(noted);
    let mut driven = false;
    let panicked = notes.by_ref().any(|it| match it {
        Noted::Driven(on) => {
            driven = on;
            false
        }
        Noted::Exception(HARD_FAULT) => driven,
        Noted::Exception(_) => false,
        Noted::Reset => {
            driven = false;
            false
        }
    });
    if !panicked {
        return Ok(Far::Before);
    }
    match notes.next() {
        None => return Ok(Far::Panicked),
        Some(Noted::Reset) => {}
        Some(other) => return Err(format!("a panic while something is driven leads to {other:?}")),
    }
    for it in notes {
        match it {
            Noted::Driven(true) => return Err("after a panic something is driven again".into()),
            Noted::Exception(HARD_FAULT) => return Ok(Far::Rested),
            Noted::Driven(false) | Noted::Exception(_) | Noted::Reset => {}
        }
    }
    Ok(Far::Panicked)
}

fn noted(line: &str) -> Option<Noted> {
    // A line that is being written has no end yet: the next look sees it whole.
    if let Some(rest) = line.strip_prefix(WRITE) {
        let (value, _) = rest.split_once(" size")?;
        return u32::from_str_radix(value, 16).ok().map(|bits| Noted::Driven(bits & 1 != 0));
    }
    if let Some(number) = line.strip_prefix(EXCEPTION) {
        return number.trim().parse().ok().map(Noted::Exception);
    }
    line.starts_with(RESET).then_some(Noted::Reset)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ON: &str = "mps2_fpgaio_write MPS2 FPGAIO write: offset 0x0 data 0x1 size 4";
    const OFF: &str = "mps2_fpgaio_write MPS2 FPGAIO write: offset 0x0 data 0x0 size 4";
    const FAULT: &str = "Taking exception 1 [Undefined Instruction] on CPU 0\n\
                         ...taking pending nonsecure exception 3\n\
                         ...loaded new PC 0x61";
    const NMI: &str = "...taking pending nonsecure exception 2";
    const AGAIN: &str = "mps2_fpgaio_reset MPS2 FPGAIO: reset";

    fn judged(notes: &[&str]) -> Result<Far, String> {
        judge(&notes.join("\n"))
    }

    #[test]
    fn a_panic_puts_everything_to_rest() {
        assert_eq!(judged(&[AGAIN, ON, OFF, FAULT, AGAIN]), Ok(Far::Before));
        assert_eq!(judged(&[AGAIN, ON, AGAIN, FAULT, AGAIN]), Ok(Far::Before));
        assert_eq!(judged(&[AGAIN, ON]), Ok(Far::Before));
        assert_eq!(judged(&[AGAIN, ON, FAULT]), Ok(Far::Panicked));
        assert_eq!(judged(&[AGAIN, ON, FAULT, AGAIN]), Ok(Far::Panicked));
        assert_eq!(judged(&[AGAIN, ON, FAULT, AGAIN, OFF, FAULT]), Ok(Far::Rested));
    }

    #[test]
    fn a_panic_that_leaves_something_driven_is_found() {
        // It hangs, up to the watchdog.
        assert!(judged(&[AGAIN, ON, FAULT, NMI, AGAIN, FAULT]).is_err());
        assert!(judged(&[AGAIN, ON, FAULT, OFF, AGAIN, FAULT]).is_err());
        assert!(judged(&[AGAIN, ON, FAULT, AGAIN, ON, FAULT]).is_err());
    }
}
