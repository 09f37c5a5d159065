//! Packs the built console, which becomes part of the program; without it an empty folder does.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use std::{env, fs, io};

use flate2::{Compression, GzBuilder};

/// What is packed: texts, as `kind` in src/api/assets.rs has them.
const TEXTS: [&str; 9] = ["html", "js", "mjs", "css", "json", "map", "webmanifest", "svg", "txt"];

fn main() {
    let manifest = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let console = manifest.join("../../console");
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    let folder = if console.is_dir() { console.join("dist") } else { out.join("no-console") };
    if !folder.is_dir() {
        empty(&folder).expect("the folder of the console can be written");
    }
    let packed = out.join("console");
    // What an earlier run has left.
    _ = fs::remove_dir_all(&packed);
    pack(&folder, &packed).expect("the console can be packed");
    println!("cargo:rerun-if-changed={}", folder.display());
    println!("cargo:rustc-env=LAFET_CONSOLE={}", packed.display());
}

/// Texts as `name.gz`, the same bytes wherever they are packed; the rest as it is.
fn pack(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let from = entry?.path();
        let to = to.join(from.file_name().unwrap_or_default());
        let ending = from.extension().and_then(|it| it.to_str()).unwrap_or_default();
        if from.is_dir() {
            pack(&from, &to)?;
        } else if TEXTS.contains(&ending) {
            let file = File::create(to.with_extension(format!("{ending}.gz")))?;
            // Without name and time.
            let mut packer = GzBuilder::new().write(file, Compression::best());
            io::copy(&mut File::open(&from)?, &mut packer)?;
            packer.finish()?;
        } else {
            fs::copy(&from, &to)?;
        }
    }
    Ok(())
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
