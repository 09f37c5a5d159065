//! Gives the linker the memory of the bootloader.

use std::{env, fs, path::PathBuf};

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("set by cargo"));
    fs::copy("memory.x", out.join("memory.x")).expect("the bootloader's memory");
    // cortex-m-rt asks for the names of the interrupts' handlers: there are none.
    fs::write(out.join("device.x"), "").expect("a place for what is made");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rerun-if-changed=build.rs");
}
