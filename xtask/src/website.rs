//! `cargo xtask website`: the documentation as a site, in website/dist.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::run::{self, StepResult, root, show};
use crate::{TaskResult, console, setup};

const CHROMIUM: &str = "chromium";

pub fn website(arguments: &[String]) -> TaskResult {
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        [] => build()?,
        ["--check"] => check()?,
        ["serve"] => npm(&["run", "--silent", "serve"])?,
        _ => return Err(format!("website {}: nothing, --check or serve", arguments.join(" "))),
    }
    Ok(ExitCode::SUCCESS)
}

/// Builds the site; the help of the commands in it is that of the program.
fn build() -> StepResult {
    console::node()?;
    console::packages_of(&folder())?;
    let program = run::program("lafet")?;
    show(console::npm_command(&folder(), &["run", "--silent", "build"]).env("LAFET_BIN", program))?;
    println!("   website/dist is the site; `cargo xtask website serve` shows it");
    Ok(())
}

/// Builds the site and tests it: links, search, and in a browser appearance, keyboard and print.
pub fn check() -> StepResult {
    build()?;
    npm(&["test"])?;
    setup::program(CHROMIUM, CHROMIUM)?;
    npm(&["run", "test:browser"])
}

fn npm(arguments: &[&str]) -> StepResult {
    console::npm_in(&folder(), arguments)
}

fn folder() -> PathBuf {
    root().join("website")
}
