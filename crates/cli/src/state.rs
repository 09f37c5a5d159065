//! Where programs of this user keep their state, and what two of them must not do to a monitor at once.

use std::env;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

pub use lafet_client::note::monitor;

use crate::failure::Failure;

/// The folder of `lafet` in it; `None` if the environment names no such place.
pub fn folder() -> Option<PathBuf> {
    let set = |name| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let state = set("XDG_STATE_HOME").or_else(|| Some(set("HOME")?.join(".local/state")))?;
    Some(state.join("lafet"))
}

/// The folder of the notes of a command.
pub fn notes(command: &str) -> Result<PathBuf, Failure> {
    let state =
        folder().ok_or_else(|| Failure::io("XDG_STATE_HOME", io::ErrorKind::NotFound.into()))?;
    Ok(state.join(command))
}

/// Takes a monitor for one command, as long as the file is open: the note of one that runs is not of one
/// that was cut off. `taken` says that another command has it.
pub fn occupy(path: &Path, taken: &'static str) -> Result<File, Failure> {
    let failed = |error: io::Error| Failure::io(path.display().to_string(), error);
    let made = path.parent().map_or(Ok(()), fs::create_dir_all);
    let file = made.and_then(|()| File::create(path)).map_err(failed)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(Failure::Ended(taken.into())),
        Err(TryLockError::Error(error)) => Err(failed(error)),
    }
}
