//! Finds the built console, which becomes part of the program; without it an empty folder does.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    let manifest = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let built = manifest.join("../../console/dist");
    println!("cargo:rerun-if-changed={}", built.display());
    let folder = if built.join("index.html").is_file() {
        built
    } else {
        let empty = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default()).join("no-console");
        fs::create_dir_all(&empty).expect("the folder of build results can be written");
        empty
    };
    println!("cargo:rustc-env=LAFET_CONSOLE={}", folder.display());
}
