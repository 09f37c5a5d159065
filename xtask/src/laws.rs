//! Checks the laws that the text of a file can show.

use std::collections::BTreeSet;
use std::path::Path;

use crate::run;
use crate::source::{self, File, Line};

/// Crates that run inside the monitor: no_std, no unsafe, no panicking path.
const CORE: [&str; 4] = ["ballistics", "proto", "device", "update"];
/// The files that contain the protocol's numbers.
const IDS: [&str; 2] = ["crates/proto/src/id.rs", "crates/proto/src/bus.rs"];
/// Bytes of the document that the tester sends: these must not come from proto.
const LITERAL: &str = "crates/conform/src/checks/literal.rs";
/// What a check finds is read by people.
const CHECKS: &str = "crates/conform/src/checks/";
const LONGEST_FILE: usize = 800;

/// Lints that the core crates deny outside their tests.
const NO_PANIC: [&str; 6] = [
    "clippy::unwrap_used",
    "clippy::expect_used",
    "clippy::panic",
    "clippy::indexing_slicing",
    "clippy::unreachable",
    "clippy::todo",
];

/// Words that no lint above catches, or that need std.
const NOT_IN_CORE: [&str; 7] =
    ["unimplemented!", "assert!", "assert_eq!", "assert_ne!", "std::", "extern crate", "alloc::"];

/// Every broken law, with its place.
pub fn broken() -> Result<Vec<String>, String> {
    let files = source::workspace()?;
    let mut problems = Vec::new();
    for name in CORE {
        let manifest = run::read(&format!("crates/{name}/Cargo.toml"))?;
        let path = format!("crates/{name}/src/lib.rs");
        match files.iter().find(|file| file.path == path) {
            Some(file) => problems.extend(head(file, &manifest)),
            None => problems.push(format!("{path} is missing")),
        }
    }
    let ids = wire_ids(&files)?;
    for file in &files {
        if is_core(file) {
            problems.extend(core_text(file));
        }
        if file.path != LITERAL && file.crate_name().is_some_and(|name| name != "proto") {
            problems.extend(wire_constants(file, &ids));
        }
        if file.path.starts_with(CHECKS) {
            problems.extend(debug_texts(file));
        }
        if file.lines.len() > LONGEST_FILE {
            let length = file.lines.len();
            problems.push(format!("{}: {length} lines, {LONGEST_FILE} at most", file.path));
        }
    }
    let mut page = Vec::new();
    texts(&run::root().join("console/src"), &mut page)?;
    problems.extend(page.iter().flat_map(|(path, text)| flights(path, text)));
    Ok(problems)
}

/// Collects the TypeScript files of a folder, with their texts.
fn texts(folder: &Path, all: &mut Vec<(String, String)>) -> Result<(), String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            texts(&path, all)?;
        } else if path.extension().is_some_and(|it| it == "ts") {
            let text = std::fs::read_to_string(&path).map_err(|e| e.to_string())?;
            all.push((path.strip_prefix(run::root()).unwrap_or(&path).display().to_string(), text));
        }
    }
    Ok(())
}

/// The flight of a jet is computed only in `crates/ballistics`; the console asks the hub for it.
fn flights(path: &str, text: &str) -> Vec<String> {
    let falls = |line: &str| {
        let line = line.to_lowercase();
        line.contains("gravity") || line.contains("9.80") || line.contains("9.81")
    };
    let lines = text.lines().enumerate().filter(|(_, line)| falls(line));
    let say = |number: usize| {
        format!("{path}:{number}: the page computes no flight; it asks the hub (/api/jets)")
    };
    lines.map(|(index, _)| say(index + 1)).collect()
}

fn is_core(file: &File) -> bool {
    file.crate_name().is_some_and(|name| CORE.contains(&name)) && file.path.contains("/src/")
}

/// Checks the attributes at the top of a core crate.
fn head(file: &File, manifest: &str) -> Vec<String> {
    let code: String = file.lines.iter().map(|line| line.code.trim()).collect();
    let mut problems = Vec::new();
    if !code.contains("#![no_std]") && !code.contains("#![cfg_attr(not(test),no_std)]") {
        problems.push(format!("{}: #![no_std] is missing", file.path));
    }
    let lints: String = manifest.split("[lints]").skip(1).flat_map(str::split_whitespace).collect();
    if !code.contains("#![forbid(unsafe_code)]") && !lints.starts_with("workspace=true") {
        problems.push(format!("{}: #![forbid(unsafe_code)] is missing", file.path));
    }
    let plain: String = code.split_whitespace().collect();
    let denied =
        plain.split("#![cfg_attr(not(test),deny(").nth(1).and_then(|c| c.split(')').next());
    let denied: Vec<&str> = denied.unwrap_or_default().split(',').collect();
    for lint in NO_PANIC.iter().filter(|lint| !denied.contains(lint)) {
        problems.push(format!("{}: #![cfg_attr(not(test), deny({lint}))] is missing", file.path));
    }
    problems
}

/// Finds circumventions of the lints in the product code of a core crate.
fn core_text(file: &File) -> Vec<String> {
    let mut problems = Vec::new();
    let mut constant_end = 0;
    for (number, line) in file.product() {
        let code = line.code.trim();
        // An assertion in a constant is evaluated by the compiler and never runs.
        let constant = line.code.find("const _: () =").or_else(|| line.code.find("const {"));
        if let Some(column) = constant {
            constant_end = source::item_end(&file.lines, number - 1, column) + 1;
        }
        for word in NOT_IN_CORE.iter().filter(|word| has_word(code, word)) {
            if number > constant_end || !word.starts_with("assert") {
                problems.push(format!("{}:{number}: `{word}` is not allowed here", file.path));
            }
        }
        // Only the head of lib.rs may mention these lints.
        if !file.path.ends_with("/src/lib.rs") {
            for lint in NO_PANIC.iter().filter(|lint| code.contains(*lint)) {
                problems.push(format!("{}:{number}: {lint} applies to the whole crate", file.path));
            }
        }
    }
    problems
}

/// Finds texts that show a value as Rust writes it for its programmers.
fn debug_texts(file: &File) -> Vec<String> {
    let debug =
        |line: &Line| [":?}", ":#?}", "dbg!", "Debug::fmt"].iter().any(|it| line.text.contains(it));
    let shown = file.product().filter(|(_, line)| debug(line));
    let problem = |number| format!("{}:{number}: not `{{:?}}`, but words or values", file.path);
    shown.map(|(number, _)| problem(number)).collect()
}

/// Whether the code contains this word, not only as the end of a longer one.
fn has_word(code: &str, word: &str) -> bool {
    code.match_indices(word).any(|(at, _)| {
        let before = code[..at].chars().next_back();
        !before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':')
    })
}

/// The values of the ids in the protocol crate.
fn wire_ids(files: &[File]) -> Result<BTreeSet<u64>, String> {
    let mut ids = BTreeSet::new();
    for path in IDS {
        let file = files.iter().find(|file| file.path == path);
        let lines = file.into_iter().flat_map(File::product);
        let before = ids.len();
        ids.extend(lines.flat_map(|(_, line)| hex_literals(&line.code)));
        if ids.len() == before {
            return Err(format!("{path} has no ids: name the right file in IDS of laws.rs"));
        }
    }
    Ok(ids)
}

/// Finds ids of the protocol written as numbers outside the protocol crate.
fn wire_constants(file: &File, ids: &BTreeSet<u64>) -> Vec<String> {
    let mut problems = Vec::new();
    for (number, line) in file.product() {
        for value in hex_literals(&line.code).iter().filter(|value| ids.contains(value)) {
            let place = format!("{}:{number}", file.path);
            problems.push(format!("{place}: {value:#04x} is a wire constant: name it from proto"));
        }
    }
    problems
}

/// Hexadecimal literals of two or four digits.
fn hex_literals(code: &str) -> Vec<u64> {
    let literals = code.match_indices("0x").filter_map(|(at, _)| {
        let rest = &code[at + 2..];
        let end = rest.find(|c: char| !c.is_ascii_hexdigit() && c != '_').unwrap_or(rest.len());
        let digits = rest[..end].replace('_', "");
        matches!(digits.len(), 2 | 4).then(|| u64::from_str_radix(&digits, 16).ok())?
    });
    literals.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: &str, text: &str) -> File {
        File { path: path.into(), lines: source::lines(text) }
    }

    const HEAD: &str = "#![no_std]\n#![forbid(unsafe_code)]\n#![cfg_attr(\n    not(test),\n    \
        deny(\n        clippy::unwrap_used,\n        clippy::expect_used,\n        clippy::panic,\n\
        clippy::indexing_slicing,\n        clippy::unreachable,\n        clippy::todo\n    )\n)]\n";

    #[test]
    fn the_page_has_no_law_of_flight() {
        let text = "const G = 9.81;\nconst rising = 9.7;\n// GRAVITY\n";
        let problems = flights("console/src/a.ts", text);
        assert_eq!(problems.len(), 2, "{problems:?}");
        assert!(problems[0].starts_with("console/src/a.ts:1: "));
    }

    #[test]
    fn the_head_of_a_core_crate_is_complete() {
        let path = "crates/proto/src/lib.rs";
        assert_eq!(head(&file(path, HEAD), ""), [""; 0]);
        let without = HEAD.replace("clippy::panic,", "").replace("#![no_std]", "// #![no_std]");
        assert_eq!(head(&file(path, &without), "").len(), 2);
        let by_workspace = HEAD.replace("#![forbid(unsafe_code)]", "");
        assert_eq!(head(&file(path, &by_workspace), "[lints]\nworkspace = true\n"), [""; 0]);
        assert_eq!(head(&file(path, &by_workspace), "").len(), 1);
    }

    #[test]
    fn ways_around_the_lints_are_found() {
        let problems = |text| core_text(&file("crates/proto/src/a.rs", text)).len();
        assert_eq!(problems("fn a() { assert!(b); }"), 1);
        assert_eq!(problems("fn a() { debug_assert!(b); }"), 0);
        assert_eq!(problems("const _: () = assert!(A);\n"), 0);
        assert_eq!(problems("fn a() {\nconst {\nassert!(A);\n}\n}\n"), 0);
        assert_eq!(problems("fn a() {\nconst {\nassert!(A);\n}\nassert!(b);\n}\n"), 1);
        assert_eq!(problems("const _: () = {\n    assert!(A);\n};\nfn a() { assert!(b); }"), 1);
        assert_eq!(problems("#[allow(clippy::panic)]\nfn a() {}"), 1);
        assert_eq!(problems("use std::vec::Vec; // std::"), 1);
        assert_eq!(problems("#[cfg(test)]\nextern crate std;\n"), 0);
    }

    #[test]
    fn what_is_found_is_no_debug_text() {
        let text = "fn a() { format!(\"{b:?}\") }\nfn a() { format!(\"{:#?} {b}\", c) }\n\
                    fn a() { format!(\"{b}\") }\n\
                    #[cfg(test)]\nmod tests { fn a() { format!(\"{b:?}\") } }\n";
        let problems = debug_texts(&file("crates/conform/src/checks/a.rs", text));
        assert_eq!(problems.len(), 2, "{problems:?}");
        assert!(problems[1].starts_with("crates/conform/src/checks/a.rs:2: "));
    }

    #[test]
    fn wire_constants_belong_to_the_protocol() {
        let ids = BTreeSet::from([0x5D, 0x4C70]);
        let text =
            "a(0x5d, 0x4C_70, 0x0000_005D, 0x5E);\n#[cfg(test)]\nmod t { const A: u8 = 0x5D; }\n";
        let problems = wire_constants(&file("crates/device/src/a.rs", text), &ids);
        assert_eq!(problems.len(), 2);
        assert!(problems[0].starts_with("crates/device/src/a.rs:1: 0x5d is a wire constant"));
    }
}
