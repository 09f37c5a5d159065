//! Gives the linker the memory of the board.

use std::{env, fs, path::PathBuf};

fn main() {
    let boards = ["lm3s6965", "mps2", "stm32f103"];
    let chosen: Vec<_> = boards
        .into_iter()
        .filter(|board| env::var_os(format!("CARGO_FEATURE_{}", board.to_uppercase())).is_some())
        .collect();
    let [board] = chosen[..] else {
        panic!("choose one board: --no-default-features --features {}", boards.join(" or "));
    };
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("set by cargo"));
    let slot = match (board, env::var_os("CARGO_FEATURE_SLOT_B")) {
        ("mps2", None) => "-a",
        ("mps2", Some(_)) => "-b",
        _ => "",
    };
    let memory = format!("memory/{board}{slot}.x");
    fs::copy(&memory, out.join("memory.x")).expect("the board's memory");
    // cortex-m-rt asks for the names of the interrupts' handlers: no board has one of its own.
    fs::write(out.join("device.x"), "").expect("a place for what is made");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rerun-if-changed={memory}");
    println!("cargo:rerun-if-changed=build.rs");
}
