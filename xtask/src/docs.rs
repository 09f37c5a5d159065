//! `cargo xtask docs`: everything generated from the protocol dictionary (the tables of
//! docs/protocol.md, the names for C, the copy for the console's tests), the description of the
//! hub's API, and a check of all links.

use std::process::ExitCode;

use serde_json::Value;

use crate::citation::citations;
use crate::run::{self, StepResult};
use crate::{TaskResult, c_header, flag, links, pictures, sections, spec};

const PAGE: &str = "docs/protocol.md";
/// The copy of the dictionary for the console's unit tests.
const DICTIONARY: &str = "console/test/unit/files/dictionary.json";
const C_HEADER: &str = "bindings/c/include/lafet_protocol.h";
/// The description of the hub's API, from which the console's types are generated.
const API: &str = "docs/schema/hub-1.json";
/// Sections with a flag table, and their classes in the dictionary. The common flags are part of
/// every class.
const CLASSES: [(&str, &str); 9] = [
    (COMMON, "GeneralFlags"),
    ("§3.3.2", "GeneralFlags"),
    ("§3.3.3", "ClimaticsFlags"),
    ("§3.3.4", "DriveFlags"),
    ("§3.3.5", "ValveFlags"),
    ("§3.3.6", "ControlFlags"),
    ("§3.3.7", "DetectorFlags"),
    ("§3.3.8", "DeployerFlags"),
    ("§3.3.10", "ButtonsFlags"),
];
const COMMON: &str = "§3.3.1";
const COMMON_BITS: u64 = 16;

pub fn docs(arguments: &[String]) -> TaskResult {
    let tables = arguments == ["--tables"];
    if tables || !flag(arguments, Some("--check"))? {
        println!("   building lafet, for `lafet schema`");
        let schema = schema()?;
        let old = run::read(PAGE)?;
        let page = (PAGE, regenerate(&old, &schema)?);
        for (file, new) in copies(&schema)?.into_iter().chain([page]) {
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
    let page = run::read(PAGE)?;
    let schema = schema()?;
    for (file, fresh) in copies(&schema)? {
        if run::read(file)? != fresh {
            return Err(format!("{file} is out of date: run `cargo xtask docs --tables`"));
        }
    }
    let fresh = regenerate(&page, &schema)?;
    if page == fresh {
        println!("   links resolve; the tables of {PAGE} are up to date");
        return Ok(());
    }
    let place = page.lines().zip(fresh.lines()).position(|(old, new)| old != new);
    let line = place.unwrap_or_else(|| page.lines().count().min(fresh.lines().count())) + 1;
    let want = fresh.lines().nth(line - 1).unwrap_or("(the end)");
    Err(format!("{PAGE}:{line} is out of date: run `cargo xtask docs`. It should read\n  {want}"))
}

/// The dictionary of the protocol, as `lafet schema` prints it.
fn schema() -> Result<Value, String> {
    printed(&[])
}

/// The JSON that `lafet schema` prints.
fn printed(options: &[&str]) -> Result<Value, String> {
    let command = ["run", "--quiet", "--package", "lafet", "--", "schema"];
    let text = run::output(run::cargo(&command).args(options))?;
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

/// The files that are generated as a whole.
fn copies(schema: &Value) -> Result<[(&'static str, String); 4], String> {
    Ok([
        (DICTIONARY, lines(schema)),
        (C_HEADER, c_header::header(schema)?),
        (API, api()?),
        (sections::PAGE, spec::page()?),
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

/// The page with new text between `<!-- params:begin -->` and its end, and between `<!--
/// flags:begin -->` and its end under each heading of §3.3.1–§3.3.10.
fn regenerate(page: &str, schema: &Value) -> Result<String, String> {
    let mut fresh = String::new();
    let mut section = String::new();
    let mut done = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        fresh += line;
        fresh.push('\n');
        if line.starts_with('#') {
            section = citations(line).into_iter().next().unwrap_or_default();
        }
        let mark = line.strip_prefix("<!-- ").and_then(|line| line.strip_suffix(":begin -->"));
        let Some(name) = mark else { continue };
        let text = match name {
            "params" => params(schema)?,
            "flags" => flags(schema, &section)?,
            other => return Err(format!("{PAGE}: no table is called `{other}`")),
        };
        let end = format!("<!-- {name}:end -->");
        if !lines.any(|line| line == end) {
            return Err(format!("{PAGE}: `{end}` is missing ({section})"));
        }
        fresh.extend([&text, &end, "\n"]);
        done.push(if name == "flags" { section.clone() } else { name.into() });
    }
    let wanted = CLASSES.iter().map(|(section, _)| *section).chain(["params"]);
    let missing: Vec<&str> = wanted.filter(|name| !done.iter().any(|d| d == name)).collect();
    match missing[..] {
        [] => Ok(fresh),
        _ => Err(format!("{PAGE}: no marks for a generated table of {}", missing.join(", "))),
    }
}

fn params(schema: &Value) -> Result<String, String> {
    let columns = [
        ("subsystem", "subsystem"),
        ("parameter", "name"),
        ("id", "id"),
        ("values", "len"),
        ("unit", "unit"),
        ("min", "min"),
        ("max", "max"),
        ("default", "default"),
        ("access", "access"),
        ("acts", "effect"),
        ("kept", "placement"),
        ("meaning", "text"),
    ];
    table(rows(&schema["params"], "params")?.iter(), &columns)
}

fn flags(schema: &Value, section: &str) -> Result<String, String> {
    let columns = [
        ("bit", "shift"),
        ("flag", "name"),
        ("severity", "severity"),
        ("meaning", "meaning"),
        ("likely cause", "cause"),
        ("what to do", "remedy"),
    ];
    let Some((_, class)) = CLASSES.iter().find(|(known, _)| *known == section) else {
        return Err(format!("{PAGE}: `{section}` has no flags of its own"));
    };
    let rows = rows(&schema["flags"][class], class)?;
    // Every class starts with the common flags, which are listed only in their own section.
    let common = section == COMMON;
    let own = rows.iter().filter(|row| common == (row["shift"].as_u64() < Some(COMMON_BITS)));
    table(own, &columns)
}

fn rows<'a>(list: &'a Value, name: &str) -> Result<&'a Vec<Value>, String> {
    let rows = list.as_array().filter(|rows| !rows.is_empty());
    rows.ok_or_else(|| format!("`lafet schema`: `{name}` is not a list, or is empty"))
}

fn table<'a>(
    rows: impl Iterator<Item = &'a Value>,
    columns: &[(&str, &str)],
) -> Result<String, String> {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut text = line(columns.iter().map(|(title, _)| (*title).into()).collect());
    text += &line(columns.iter().map(|_| "---".into()).collect());
    for row in rows {
        let cells: Result<Vec<String>, String> =
            columns.iter().map(|(_, key)| cell(row, key)).collect();
        text += &line(cells?);
    }
    Ok(text)
}

fn cell(row: &Value, key: &str) -> Result<String, String> {
    let value = row.get(key).ok_or_else(|| format!("`lafet schema`: no `{key}` in {row}"))?;
    // A flag of two bits.
    if key == "shift" && row["width"].as_u64().is_some_and(|width| width > 1) {
        let (shift, width) = (value.as_u64().unwrap_or(0), row["width"].as_u64().unwrap_or(1));
        return Ok(format!("{shift}…{}", shift + width - 1));
    }
    Ok(match key {
        "name" => format!("`{}`", words(value)),
        "id" => format!("0x{:04X}", value.as_u64().unwrap_or(0)),
        "len" => length(value),
        "min" | "max" | "default" => bound(row, value),
        _ => words(value),
    })
}

/// The number of values of a parameter.
fn length(len: &Value) -> String {
    let [min, max, step] = ["min", "max", "step"].map(|key| len[key].as_u64().unwrap_or(0));
    match (min == max, step) {
        (true, _) => max.to_string(),
        (false, 0 | 1) => format!("{min}…{max}"),
        (false, _) => format!("{min}…{max} by {step}"),
    }
}

/// A bound or default: empty for measured values, hexadecimal for bit masks, and a list for values
/// with different units.
fn bound(row: &Value, value: &Value) -> String {
    if row["access"] == "read-only" {
        return String::new();
    }
    match value.as_u64() {
        Some(bits) if row["quantity"] == "Bits" => format!("0x{bits:X}"),
        _ => words(value),
    }
}

/// A value as a table cell: for a text in two languages, the English one.
fn words(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::Array(list) => list.iter().map(words).collect::<Vec<_>>().join(", "),
        Value::Object(texts) => texts.get("en").map(words).unwrap_or_default(),
        Value::String(text) => text.replace('|', "\\|").replace('\n', " "),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn flag(name: &str, shift: u32, width: u32) -> Value {
        json!({"name": name, "shift": shift, "width": width, "severity": "info",
               "meaning": {"en": "a | b", "ru": "в"}, "cause": null, "remedy": {"en": "look"}})
    }

    fn schema() -> Value {
        let both = [flag("ConfigFault", 0, 1), flag("Move", 16, 1)];
        let mut flags = json!({"ButtonsFlags": [flag("Left", 16, 2)]});
        for (_, class) in CLASSES.iter().filter(|(_, class)| *class != "ButtonsFlags") {
            flags[class] = json!(both);
        }
        let param = json!({"subsystem": "General", "name": "Address", "id": 4342,
            "len": {"min": 1, "max": 1, "step": 1}, "unit": "", "min": 1, "max": 127, "default": 1, "access": "rw", "effect": "restart",
            "placement": "local", "text": {"en": "Address", "ru": "Адрес"}});
        json!({"flags": flags, "params": [param]})
    }

    fn page() -> String {
        let mut page = String::new();
        for (section, class) in CLASSES {
            page +=
                &format!("#### {section} {class}\n<!-- flags:begin -->\nold\n<!-- flags:end -->\n");
        }
        page + "## Parameters\n<!-- params:begin -->\n<!-- params:end -->\nthe end\n"
    }

    #[test]
    fn each_section_gets_its_own_flags() {
        let new = regenerate(&page(), &schema()).unwrap();
        assert!(!new.contains("old") && new.ends_with("the end\n"), "{new}");
        assert_eq!(new.matches("| 0 | `ConfigFault` |").count(), 1);
        assert_eq!(new.matches("| 16 | `Move` | info | a \\| b |  | look |\n").count(), 7);
        assert_eq!(new.matches("| 16…17 | `Left` |").count(), 1);
        assert_eq!(new.matches("| General | `Address` | 0x10F6 | 1 |").count(), 1);
        assert_eq!(regenerate(&new, &schema()).unwrap(), new);
    }

    #[test]
    fn marks_that_are_missing_or_wrong_are_errors() {
        let error = |page: String| regenerate(&page, &schema()).unwrap_err();
        assert!(error(page().replace("params:end", "params")).contains("is missing"));
        assert!(error(page().replace("§3.3.4", "§3.3.9")).contains("no flags of its own"));
        assert!(
            error(page().replace("params:begin", "param:begin")).contains("no table is called")
        );
        assert!(error("# nothing\n".into()).contains("§3.3.1, §3.3.2"));
    }

    #[test]
    fn a_schema_of_another_shape_is_an_error() {
        assert!(flags(&json!({}), COMMON).is_err());
        assert!(params(&json!({"params": []})).is_err());
        let error = params(&json!({"params": [{"subsystem": "General"}]})).unwrap_err();
        assert!(error.contains("no `name`"), "{error}");
    }
}
