//! `cargo xtask python`: builds lafet for Python as a wheel, and tests it as it is installed.

use std::path::PathBuf;
use std::process::{Command, ExitCode};

use crate::run::{self, StepResult, cargo, output, root, show};
use crate::{TaskResult, flag, no_std, setup};

/// What builds and checks it; one version for all.
const TOOLS: [&str; 5] = [
    "maturin==1.16.0",
    "mypy==2.4.1",
    "pytest==9.2.0",
    "pytest-timeout==2.4.0",
    "pytest-xdist==3.8.0",
];
/// The tests wait for simulated monitors most of the time.
const AT_ONCE: &str = "4";

pub fn python(arguments: &[String]) -> TaskResult {
    let release = flag(arguments, Some("--release"))?;
    let wheel = wheel(if release { "release" } else { "quick" })?;
    println!("   {}", wheel.display());
    test(&wheel)?;
    Ok(ExitCode::SUCCESS)
}

/// Checks it, builds it quickly, installs and tests it.
pub fn check() -> StepResult {
    show(cargo(&["fmt", "--check"]).current_dir(folder()))?;
    let mut clippy = cargo(&["clippy", "--locked", "--profile", "quick", "--", "-D", "warnings"]);
    show(clippy.current_dir(folder()).env("CARGO_TARGET_DIR", built()))?;
    test(&wheel("quick")?)
}

fn built() -> PathBuf {
    no_std::target().join("python")
}

fn folder() -> PathBuf {
    root().join("bindings/python")
}

/// A program of the environment for it.
fn tool(name: &str) -> Result<Command, String> {
    let programs = setup::python("python-tools", &TOOLS)?;
    let mut tool = Command::new(programs.join(name));
    tool.current_dir(folder());
    Ok(tool)
}

/// Builds the wheel; returns its path.
fn wheel(profile: &str) -> Result<PathBuf, String> {
    let wheels = run::target().join("wheels").join(profile);
    if wheels.exists() {
        std::fs::remove_dir_all(&wheels).map_err(|e| format!("{}: {e}", wheels.display()))?;
    }
    let mut build = tool("maturin")?;
    build.args(["build", "--quiet", "--locked", "--profile", profile, "--out"]).arg(&wheels);
    build.env("CARGO_TARGET_DIR", built());
    show(&mut build)?;
    let made = std::fs::read_dir(&wheels).map_err(|e| format!("{}: {e}", wheels.display()))?;
    let mut paths = made.flatten().map(|entry| entry.path());
    paths.next().ok_or_else(|| format!("{}: no wheel was made", wheels.display()))
}

fn test(wheel: &PathBuf) -> StepResult {
    output(tool("pip")?.args(["install", "--quiet", "--force-reinstall"]).arg(wheel))?;
    show(tool("mypy")?.args(["python", "tests"]))?;
    // The package that was installed is tested, not the folder with its sources.
    show(tool("pytest")?.args(["tests", "--import-mode=importlib", "-n", AT_ONCE]))
}
