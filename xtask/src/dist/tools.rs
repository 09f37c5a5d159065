//! Programs that make and check the packages; what is missing is installed.

use std::path::PathBuf;
use std::process::Command;

use crate::{run, setup};

/// The linker and C compiler for other systems, and what lets cargo use it. Both are on PyPI as
/// programs, so that nothing is compiled to get them.
const ZIG: [&str; 2] = ["cargo-zigbuild==0.24.1", "ziglang==0.15.2"];
/// Checks a bill of materials against the schemas of CycloneDX.
const CYCLONEDX: [&str; 1] = ["cyclonedx-python-lib[json-validation]==11.12.0"];

/// A program of a Debian package.
pub fn command(name: &str, package: &str) -> Result<Command, String> {
    let mut probe = Command::new("sh");
    if run::output(probe.args(["-c", "command -v \"$0\"", name])).is_err() {
        println!("   {name} is missing: installing it");
        setup::debian(&[package])?;
    }
    Ok(Command::new(name))
}

/// The folder of `cargo-zigbuild` and of the Python that has zig.
pub fn zig() -> Result<PathBuf, String> {
    setup::python("dist-zig", &ZIG)
}

/// A Python that can check bills of materials.
pub fn cyclonedx() -> Result<Command, String> {
    Ok(Command::new(setup::python("dist-cyclonedx", &CYCLONEDX)?.join("python3")))
}
