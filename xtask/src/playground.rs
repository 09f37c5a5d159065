//! `cargo xtask playground`: the protocol in a web page, with the simulator as WebAssembly.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use crate::run::{self, StepResult, cargo, root, show};
use crate::{TaskResult, console, flag, no_std, setup};

const TARGET: &str = "wasm32-unknown-unknown";
const CHROMIUM: &str = "chromium";
/// All files of the page, compressed by gzip, bytes.
const SIZE_MAX: usize = 600_000;
/// Where the page expects the simulator.
const MODULE: &str = "src/lafet.wasm";

pub fn playground(arguments: &[String]) -> TaskResult {
    if flag(arguments, Some("--check"))? {
        check()?
    } else {
        build()?
    }
    Ok(ExitCode::SUCCESS)
}

/// Builds the page into playground/dist, and fails if it is too large.
fn build() -> StepResult {
    module()?;
    console::node()?;
    console::packages_of(&folder())?;
    npm(&["run", "build"])?;
    let mut sizes = Vec::new();
    for file in files(&folder().join("dist"))? {
        sizes.push((compressed(&file)?, file));
    }
    sizes.sort();
    for (size, file) in &sizes {
        let name = file.strip_prefix(folder()).unwrap_or(file).display();
        println!("   {:>7.1} kB  {name}", *size as f64 / 1000.0);
    }
    let all: usize = sizes.iter().map(|(size, _)| size).sum();
    println!("   {:>7.1} kB  in all, compressed by gzip", all as f64 / 1000.0);
    if all > SIZE_MAX {
        return Err(format!(
            "the playground has {all} bytes, {SIZE_MAX} at most: `cargo tree --manifest-path \
             playground/wasm/Cargo.toml` shows what came in"
        ));
    }
    Ok(())
}

/// Builds it, checks its code, compares it with the native program, and tests it in a browser.
pub fn check() -> StepResult {
    if !run::is_built() {
        run::show_tests(&mut cargo(&["test", "--package", "lafet-play"]))?;
    }
    let replies = run::example("lafet-play", "replies")?;
    build()?;
    lints()?;
    show(console::npm_command(&folder(), &["run", "check"]).env("LAFET_REPLIES", replies))?;
    setup::program(CHROMIUM, CHROMIUM)?;
    npm(&["run", "test:browser"])
}

/// Builds the simulator for the page.
fn module() -> StepResult {
    setup::target(TARGET)?;
    let target = output_folder();
    let mut build = cargo(&["build", "--release", "--locked", "--target", TARGET]);
    show(build.current_dir(folder().join("wasm")).env("CARGO_TARGET_DIR", &target))?;
    let built = target.join(TARGET).join("release/lafet.wasm");
    let to = folder().join(MODULE);
    // What has not changed keeps its time.
    let bytes = std::fs::read(&built).map_err(|e| format!("{}: {e}", built.display()))?;
    if std::fs::read(&to).is_ok_and(|before| before == bytes) {
        return Ok(());
    }
    std::fs::write(&to, bytes).map_err(|e| format!("{}: {e}", to.display()))
}

fn lints() -> StepResult {
    setup::component("clippy", "clippy")?;
    setup::component("rustfmt", "fmt")?;
    let folder = folder().join("wasm");
    show(cargo(&["fmt", "--check"]).current_dir(&folder))?;
    let arguments = ["clippy", "--release", "--locked", "--target", TARGET, "--", "-D", "warnings"];
    let mut clippy = cargo(&arguments);
    show(clippy.current_dir(&folder).env("CARGO_TARGET_DIR", output_folder()))
}

fn output_folder() -> PathBuf {
    no_std::target().join("playground")
}

fn folder() -> PathBuf {
    root().join("playground")
}

fn npm(arguments: &[&str]) -> StepResult {
    console::npm_in(&folder(), arguments)
}

/// All files below a folder.
fn files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = folder.read_dir().map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut all = Vec::new();
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            all.extend(files(&path)?);
        } else {
            all.push(path);
        }
    }
    Ok(all)
}

/// Bytes of a file after gzip.
fn compressed(file: &Path) -> Result<usize, String> {
    let mut gzip = Command::new("gzip");
    let output = gzip.args(["-9", "--stdout"]).arg(file).output();
    let output = output.map_err(|e| format!("gzip: {e}"))?;
    match output.status.success() {
        true => Ok(output.stdout.len()),
        false => Err(format!("gzip {}: {}", file.display(), output.status)),
    }
}
