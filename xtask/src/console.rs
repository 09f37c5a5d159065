//! `cargo xtask console`: the operator's console, which is built into the hub.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::SystemTime;

use serde_json::{Map, Value};

use crate::run::{self, StepResult, output, root, show};
use crate::{TaskResult, demo, setup};

/// The oldest Node.js version that supports the console's tools.
const NODE: u32 = 20;
/// The description of the hub's API.
const DESCRIPTION: &str = "docs/schema/hub-1.json";
const CHROMIUM: &str = "chromium";
/// More files with failures than this have a common cause.
const AGAIN_MAX: usize = 6;

pub fn console(arguments: &[String]) -> TaskResult {
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["build"] => build()?,
        ["check"] => check()?,
        ["api"] => api(&[])?,
        ["browser", ref names @ ..] => with_browser("test:browser", names)?,
        ["pictures"] => with_browser("pictures", &[])?,
        ["measure", ref what @ ..] => with_browser("measure", what)?,
        ["monkey", ref how @ ..] => with_browser("monkey", how)?,
        _ => {
            return Err(format!(
                "console {}: build, check, api, browser [NAME...], pictures, measure [SLOWED [pages|scene|memory]] or monkey [SECONDS [SEED]]",
                arguments.join(" ")
            ));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Builds the console if any of its files changed since the last build.
pub fn build() -> StepResult {
    let built = modified(&folder().join("dist/index.html"));
    if built.is_some_and(|built| newest(&folder()).is_some_and(|newest| newest < built)) {
        return Ok(());
    }
    packages()?;
    npm(&["run", "build"])
}

/// Checks types, style, templates and unit tests, and builds.
pub fn check() -> StepResult {
    packages()?;
    packages_of(&folder().join("templates"))?;
    api(&["--check"])?;
    npm(&["run", "check"])?;
    npm(&["run", "build"])
}

/// Runs the tests in a real browser, against the program and simulated monitors. Files that fail, if they are few,
/// are run once more when nothing else runs: what passes then is unsteady.
pub fn browser() -> StepResult {
    let failed = failed_once()?;
    if !failed.is_empty() {
        let headline = "tests of the console that failed beside others";
        run::later(headline, Box::new(move || again(&failed)));
    }
    Ok(())
}

/// Runs the tests in a real browser; returns the files that failed, if they are few.
fn failed_once() -> Result<Vec<String>, String> {
    let file = root().join(run::target()).join("browser.json");
    // What an earlier run has left must not be taken for the result of this one.
    let _ = std::fs::remove_file(&file);
    let output = format!("--outputFile.json={}", file.display());
    let all = ["--reporter=default", "--reporter=json", &output];
    let Err(failed) = with_browser("test:browser", &all) else { return Ok(Vec::new()) };
    let files = std::fs::read_to_string(file).map(|it| failed_files(&it)).unwrap_or_default();
    match files.len() {
        1..=AGAIN_MAX => Ok(files),
        _ => Err(failed),
    }
}

/// Runs these files of tests once more.
fn again(files: &[String]) -> StepResult {
    let names: Vec<&str> = files.iter().map(String::as_str).collect();
    with_browser("test:browser", &names)?;
    run::unsteady(format!("{} failed beside other work, and passed once more", names.join(", ")));
    Ok(())
}

/// The files of tests that failed, in the report of vitest.
fn failed_files(report: &str) -> Vec<String> {
    let report: Value = serde_json::from_str(report).unwrap_or_default();
    let files = report["testResults"].as_array().into_iter().flatten();
    let failed = files.filter(|it| it["status"] != "passed").filter_map(|it| it["name"].as_str());
    failed.map(str::to_owned).collect()
}

/// Builds what the browser tests need, and runs a script of the console's package.
fn with_browser(script: &str, arguments: &[&str]) -> StepResult {
    build()?;
    setup::program(CHROMIUM, CHROMIUM)?;
    let program = if script == "measure" { demo::optimised()? } else { demo::program()? };
    let words = [&["run", script, "--"], arguments].concat();
    show(npm_command(&folder(), &words).env("LAFET_BIN", program))
}

/// Generates the types of the hub's API from its description: only the structures, as no page uses
/// the operations.
fn api(options: &[&str]) -> StepResult {
    packages_of(&folder().join("generator"))?;
    let mut description: Value = serde_json::from_str(&run::read(DESCRIPTION)?)
        .map_err(|e| format!("{DESCRIPTION}: {e}"))?;
    description["paths"] = Value::Object(Map::new());
    let file = root().join(run::target()).join("hub-structures.json");
    std::fs::write(&file, description.to_string())
        .map_err(|e| format!("{}: {e}", file.display()))?;
    let command = ["--prefix", "generator", "run", "--silent", "api", "--"];
    show(npm_command(&folder(), &command).arg(&file).args(options))
}

fn packages() -> StepResult {
    node()?;
    packages_of(&folder())
}

/// Installs the packages of a folder as its lock has them, if that changed.
pub fn packages_of(folder: &Path) -> StepResult {
    let lock = modified(&folder.join("package-lock.json"));
    let installed = modified(&folder.join("node_modules/.package-lock.json"));
    if installed.is_some() && lock <= installed {
        return Ok(());
    }
    show(&mut npm_command(folder, &["ci", "--no-audit", "--no-fund"]))
}

/// Checks that Node.js is there, or installs it.
pub fn node() -> StepResult {
    let version = || output(Command::new("node").arg("--version"));
    if version().is_err() || output(Command::new("npm").arg("--version")).is_err() {
        setup::debian(&["nodejs", "npm"])?;
    }
    let version = version()?;
    let major = version.trim().trim_start_matches('v').split('.').next().unwrap_or_default();
    if major.parse().is_ok_and(|major: u32| major >= NODE) {
        return Ok(());
    }
    Err(format!("Node.js {NODE} or newer is needed, this is {}", version.trim()))
}

fn npm(arguments: &[&str]) -> StepResult {
    npm_in(&folder(), arguments)
}

/// Runs npm in a folder; the user sees what it prints.
pub fn npm_in(folder: &Path, arguments: &[&str]) -> StepResult {
    show(&mut npm_command(folder, arguments))
}

/// npm in a folder.
pub fn npm_command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new("npm");
    command.args(arguments).current_dir(folder);
    command
}

fn folder() -> PathBuf {
    root().join("console")
}

fn modified(file: &Path) -> Option<SystemTime> {
    file.metadata().ok()?.modified().ok()
}

/// Time of the last change in a folder, without build output and installed packages.
fn newest(folder: &Path) -> Option<SystemTime> {
    let entries = folder.read_dir().ok()?.flatten();
    let kept =
        entries.filter(|entry| entry.file_name() != "dist" && entry.file_name() != "node_modules");
    kept.filter_map(|entry| {
        let path = entry.path();
        if path.is_dir() { newest(&path) } else { modified(&path) }
    })
    .max()
}

#[cfg(test)]
mod tests {
    use super::failed_files;

    #[test]
    fn files_that_failed_are_those_that_did_not_pass() {
        let report = r#"{"testResults":[{"name":"/a.test.ts","status":"passed"},
            {"name":"/b.test.ts","status":"failed"},{"name":"/c.test.ts"}]}"#;
        assert_eq!(failed_files(report), ["/b.test.ts", "/c.test.ts"]);
        assert!(failed_files("").is_empty() && failed_files("{}").is_empty());
    }
}
