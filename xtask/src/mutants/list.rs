//! Lists the mutants, using cargo-mutants.

use std::process::Command;

use serde_json::Value;

use crate::run::{output, root};
use crate::setup;

const VERSION: &str = "27.1.0";

/// The kind of change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Genre {
    FnValue,
    BinaryOperator,
    UnaryOperator,
    MatchArm,
    MatchArmGuard,
    StructField,
}

/// A change to the code that a test should notice.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// Path in the workspace.
    pub file: String,
    /// The change and the function it is in.
    pub name: String,
    /// The source line.
    pub line: String,
    pub genre: Genre,
    /// Line and column, from 1.
    pub start: (usize, usize),
    pub end: (usize, usize),
    pub replacement: String,
}

impl Mutant {
    /// Path of its file relative to the source of the device; for another crate, to `crates`.
    pub fn short_file(&self) -> &str {
        let file = self.file.as_str();
        let short = file.strip_prefix("crates/device/src/").or(file.strip_prefix("crates/"));
        short.unwrap_or(file)
    }

    /// Identifies the mutant without its position, which changes with every line above it.
    pub fn key(&self) -> (&str, &str, &str) {
        (self.short_file(), &self.name, &self.line)
    }
}

/// All mutants of the device and its ballistics.
pub fn mutants() -> Result<Vec<Mutant>, String> {
    let mut list = Command::new(setup::tool("cargo-mutants", VERSION, true)?);
    list.current_dir(root()).args(["mutants", "--list", "--json"]).args(super::tree::packages());
    let json = output(&mut list)?;
    let json: Value = serde_json::from_str(&json).map_err(|e| e.to_string())?;
    json.as_array().into_iter().flatten().map(mutant).collect()
}

fn mutant(json: &Value) -> Result<Mutant, String> {
    let text = |key: &str| json[key].as_str().unwrap_or_default().to_owned();
    let at = |which: &str| {
        let number = |of: &str| json["span"][which][of].as_u64().unwrap_or(0) as usize;
        (number("line"), number("column"))
    };
    let genre = match json["genre"].as_str().unwrap_or_default() {
        "FnValue" => Genre::FnValue,
        "BinaryOperator" => Genre::BinaryOperator,
        "UnaryOperator" => Genre::UnaryOperator,
        "MatchArm" => Genre::MatchArm,
        "MatchArmGuard" => Genre::MatchArmGuard,
        "StructField" => Genre::StructField,
        other => {
            return Err(format!("cargo-mutants has a genre that xtask does not support: {other}"));
        }
    };
    let file = text("file");
    let source = crate::run::read(&file)?;
    let start = at("start");
    let line = source.lines().nth(start.0.saturating_sub(1)).unwrap_or_default().trim().to_owned();
    // Form: path:line:column: change
    let name = text("name").split_once(": ").map_or_else(String::new, |(_, what)| what.into());
    Ok(Mutant { file, name, line, genre, start, end: at("end"), replacement: text("replacement") })
}

impl std::fmt::Display for Mutant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}: {}", self.file, self.start.0, self.name)
    }
}
