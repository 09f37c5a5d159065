//! `cargo xtask docs`: everything generated from the protocol dictionary (the tables of
//! docs/protocol.md in both languages, the names for C, the copy for the console's tests), the
//! description of the hub's API, the picture of the crates, and a check of all links.

use std::process::ExitCode;

use serde_json::Value;

use crate::run::{self, StepResult};
use crate::tables::{self, Page};
use crate::{TaskResult, c_header, crates, flag, links, pictures, sections, spec};

/// The copy of the dictionary for the console's unit tests.
const DICTIONARY: &str = "console/test/unit/files/dictionary.json";
const C_HEADER: &str = "bindings/c/include/lafet_protocol.h";
/// The description of the hub's API, from which the console's types are generated.
const API: &str = "docs/schema/hub-1.json";

pub fn docs(arguments: &[String]) -> TaskResult {
    let tables = arguments == ["--tables"];
    if tables || !flag(arguments, Some("--check"))? {
        println!("   building lafet, for `lafet schema`");
        let schema = schema()?;
        let mut files = copies(&schema)?.to_vec();
        for page in &tables::PAGES {
            files.push((page.path, tables::regenerate(page, &run::read(page.path)?, &schema)?));
        }
        for (file, new) in files {
            let was = run::read(file).unwrap_or_default();
            std::fs::write(run::root().join(file), &new).map_err(|e| format!("{file}: {e}"))?;
            println!("   {file}: {}", if was == new { "was up to date" } else { "written" });
        }
        if tables {
            return Ok(ExitCode::SUCCESS);
        }
        println!("   running the scenarios of the pictures");
        pictures::write()?;
    }
    check().map(|()| ExitCode::SUCCESS)
}

/// Fails on an outdated table and on a broken link.
pub fn check() -> StepResult {
    run::verdict("broken links", &links::broken()?)?;
    pictures::check()?;
    let schema = schema()?;
    for (file, fresh) in copies(&schema)? {
        if run::read(file)? != fresh {
            return Err(format!("{file} is out of date: run `cargo xtask docs --tables`"));
        }
    }
    tables::PAGES.iter().try_for_each(|page| check_page(page, &schema))
}

/// Fails on an outdated table of a page.
fn check_page(page: &Page, schema: &Value) -> StepResult {
    let path = page.path;
    let text = run::read(path)?;
    let fresh = tables::regenerate(page, &text, schema)?;
    if text == fresh {
        println!("   links resolve; the tables of {path} are up to date");
        return Ok(());
    }
    let place = text.lines().zip(fresh.lines()).position(|(old, new)| old != new);
    let line = place.unwrap_or_else(|| text.lines().count().min(fresh.lines().count())) + 1;
    let want = fresh.lines().nth(line - 1).unwrap_or("(the end)");
    Err(format!("{path}:{line} is out of date: run `cargo xtask docs`. It should read\n  {want}"))
}

/// The dictionary of the protocol, as `lafet schema` prints it.
fn schema() -> Result<Value, String> {
    printed(&[])
}

/// The JSON that `lafet schema` prints.
fn printed(options: &[&str]) -> Result<Value, String> {
    let text = run::output(run::tested("lafet").arg("schema").args(options))?;
    serde_json::from_str(&text).map_err(|e| format!("`lafet schema` did not print JSON: {e}"))
}

/// The description of the API with one path or structure per line.
fn api() -> Result<String, String> {
    let api = printed(&["--hub"])?;
    let lines = |value: &Value| {
        let entries = value.as_object().into_iter().flatten();
        let line =
            |(name, entry): (&String, &Value)| format!("{}:{entry}", Value::from(name.as_str()));
        entries.map(line).collect::<Vec<_>>().join(",\n")
    };
    Ok(format!(
        "{{\"openapi\":{},\n\"info\":{},\n\"paths\":{{\n{}\n}},\n\"components\":{{\"schemas\":{{\n{}\n}}}}}}\n",
        api["openapi"],
        api["info"],
        lines(&api["paths"]),
        lines(&api["components"]["schemas"]),
    ))
}

/// The files that are generated as a whole, and the page with the picture of the crates.
fn copies(schema: &Value) -> Result<[(&'static str, String); 5], String> {
    Ok([
        (DICTIONARY, lines(schema)),
        (C_HEADER, c_header::header(schema)?),
        (API, api()?),
        (sections::PAGE, spec::page()?),
        (crates::PAGE, crates::page()?),
    ])
}

/// JSON with one list entry per line.
fn lines(schema: &Value) -> String {
    let list = |value: &Value| match value {
        Value::Array(entries) => {
            let lines: Vec<String> = entries.iter().map(Value::to_string).collect();
            format!("[\n{}\n]", lines.join(",\n"))
        }
        other => other.to_string(),
    };
    let parts = schema.as_object().into_iter().flatten();
    let parts: Vec<String> =
        parts.map(|(name, value)| format!("\"{name}\": {}", list(value))).collect();
    format!("{{\n{}\n}}\n", parts.join(",\n"))
}
