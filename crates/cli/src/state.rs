//! Where programs of this user keep their state.

use std::env;
use std::path::PathBuf;

/// The folder of `lafet` in it; `None` if the environment names no such place.
pub fn folder() -> Option<PathBuf> {
    let set = |name| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let state = set("XDG_STATE_HOME").or_else(|| Some(set("HOME")?.join(".local/state")))?;
    Some(state.join("lafet"))
}
