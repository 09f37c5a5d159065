//! `cargo xtask no-std`: builds the core crates for the Cortex-M3.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use crate::run::{StepResult, cargo, output, root, show};
use crate::{TaskResult, flag, setup};

pub const TARGET: &str = "thumbv7m-none-eabi";
const CRATES: [&str; 8] = [
    "--package",
    "lafet-ballistics",
    "--package",
    "lafet-proto",
    "--package",
    "lafet-device",
    "--package",
    "lafet-update",
];

/// Debian's Rust, which includes the sources of `core`, and a linker, which it lacks.
const DEBIAN_PACKAGES: [&str; 4] =
    ["rustc-web", "cargo-web", "rust-web-src", "binutils-arm-none-eabi"];
const DEBIAN_LINKER: &str = "arm-none-eabi-ld";
const DEBIAN_CARGO: &str = "/usr/bin/cargo";
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";

pub fn no_std(arguments: &[String]) -> TaskResult {
    flag(arguments, None)?;
    check().map(|()| ExitCode::SUCCESS)
}

/// Builds with rustup's target, else with Debian's compiler; fails without either.
pub fn check() -> StepResult {
    show(build(None)?.arg("--lib").args(CRATES))
}

/// `cargo build` for the Cortex-M3, with whichever compiler is available; the output goes to
/// `folder`.
pub fn build(folder: Option<&Path>) -> Result<Command, String> {
    let mut command = match setup::target(TARGET) {
        Ok(()) => cargo(&["build", "--target", TARGET]),
        Err(why) => {
            println!("   rustup has no {TARGET} ({}): taking Debian's Rust", first_line(&why));
            debian_build().map_err(|e| {
                format!("{e}\nEither is enough: rustup target add {TARGET}, or Debian's packages")
            })?
        }
    };
    if let Some(folder) = folder {
        command.env("CARGO_TARGET_DIR", folder);
    }
    Ok(command)
}

/// `cargo clippy` for the Cortex-M3; Debian's compiler has no lints for it.
pub fn clippy(folder: &Path) -> Option<Command> {
    if let Err(why) = setup::target(TARGET) {
        println!("   rustup has no {TARGET} ({}): it is not linted", first_line(&why));
        return None;
    }
    let mut command = cargo(&["clippy", "--target", TARGET]);
    command.env("CARGO_TARGET_DIR", folder);
    Some(command)
}

/// Builds `core` from its sources along with the crates.
fn debian_build() -> Result<Command, String> {
    let sources = Path::new("/usr/src").read_dir().into_iter().flatten().flatten();
    let have_sources =
        sources.into_iter().any(|e| e.file_name().to_string_lossy().starts_with("rustc-"));
    let have_linker = output(Command::new(DEBIAN_LINKER).arg("--version")).is_ok();
    let have_rust = Path::new(DEBIAN_CARGO).exists() && Path::new(DEBIAN_RUSTC).exists();
    if !(have_sources && have_rust && have_linker) {
        setup::debian(&DEBIAN_PACKAGES)?;
    }
    let mut build = Command::new(DEBIAN_CARGO);
    build.args(["build", "-Zbuild-std=core", "--ignore-rust-version", "--target", TARGET]);
    build.current_dir(root());
    // A separate folder: two compilers must not share one.
    build.env("CARGO_TARGET_DIR", target().join("debian"));
    build.env("RUSTC_BOOTSTRAP", "1").env("RUSTC", DEBIAN_RUSTC);
    build.env("CARGO_TARGET_THUMBV7M_NONE_EABI_LINKER", DEBIAN_LINKER);
    build.env_remove("RUSTUP_TOOLCHAIN").env_remove("CARGO");
    Ok(build)
}

/// Cargo's target folder.
pub fn target() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    root().join(target)
}

fn first_line(text: &str) -> &str {
    text.lines().next().unwrap_or_default()
}
