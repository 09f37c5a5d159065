//! Finds the built console, which becomes part of the program; without it an empty folder does.

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use std::{env, fs, io};

fn main() {
    let manifest = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let console = manifest.join("../../console");
    let folder = if console.is_dir() {
        console.join("dist")
    } else {
        PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default()).join("no-console")
    };
    if !folder.is_dir() {
        empty(&folder).expect("the folder of the console can be written");
    }
    println!("cargo:rerun-if-changed={}", folder.display());
    println!("cargo:rustc-env=LAFET_CONSOLE={}", folder.display());
}

/// An empty folder that is old: what is missing or newer than this run counts as changed at the next
/// build, which would compile the hub again.
fn empty(folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    let long_ago = SystemTime::UNIX_EPOCH + Duration::from_secs(86_400);
    // Where this is not possible the next build compiles it again, once.
    _ = fs::File::open(folder).and_then(|it| it.set_modified(long_ago));
    Ok(())
}
