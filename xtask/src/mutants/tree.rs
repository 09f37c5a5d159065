//! A copy of the device, in which mutants are built.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::list::Mutant;
use super::weave::{self, Woven};
use crate::run::{cargo, output, read, root, target, test_programs};

/// The crates whose mutants are tried, and their paths.
pub const SOURCES: [(&str, &str); 2] =
    [("lafet-device", "crates/device/src/"), ("lafet-ballistics", "crates/ballistics/src/")];
/// The short tests.
pub const FEW: [&str; 3] = ["--lib", "--test", "it"];
/// The program of the short tests that are not beside the code.
const MANY: &str = "it";
/// Contents of the copy.
const PARTS: [&str; 7] = [
    "Cargo.lock",
    "rust-toolchain.toml",
    "crates/proto",
    "crates/ballistics",
    "crates/device",
    // A test of the device includes it.
    "crates/verify/src/interlock.rs",
    "clippy.toml",
];
/// Source of the switch for woven mutants.
const SWITCH: &str = r#"
/// Whether this mutant is on.
#[inline(always)]
pub fn woven(id: usize) -> bool {
    static ON: std::sync::OnceLock<usize> = std::sync::OnceLock::new();
    let on = || std::env::var("LAFET_MUTANT").map_or(usize::MAX, |id| id.parse().unwrap());
    *ON.get_or_init(on) == id
}
"#;
/// `std` for the switch; as long as what it replaces, so that positions in the file stay the same.
const UNCONDITIONAL: &str = "            \nextern crate std;";
/// More rounds than any source needs.
const ROUNDS_MAX: usize = 40;

/// A test binary, or a module of one.
pub struct Test {
    pub name: String,
    pub path: PathBuf,
    /// Part of the names of its tests; if empty, all of the binary are.
    pub filter: String,
}

impl Test {
    /// Its modules, if it has many: the quickest is run first, and none after one that fails.
    fn modules(self) -> Result<Vec<Self>, String> {
        if self.name != MANY {
            return Ok(vec![self]);
        }
        let listed = output(Command::new(&self.path).args(["--list", "--format", "terse"]))?;
        let modules: BTreeSet<&str> =
            listed.lines().filter_map(|line| Some(line.split_once("::")?.0)).collect();
        let module = |name: &str| Self {
            name: name.to_owned(),
            path: self.path.clone(),
            filter: format!("{name}::"),
        };
        Ok(modules.into_iter().map(module).collect())
    }
}

pub struct Tree {
    path: PathBuf,
}

impl Tree {
    pub fn new() -> Result<Self, String> {
        let tree = Self { path: target().join("mutants/tree") };
        let _ = std::fs::remove_dir_all(&tree.path);
        for part in PARTS {
            copy(&root().join(part), &tree.path.join(part))?;
        }
        let manifest = read("Cargo.toml")?;
        let members = r#"members = ["crates/*", "xtask"]"#;
        if !manifest.contains(members) {
            return Err(format!("Cargo.toml: expected {members}"));
        }
        let few = r#"members = ["crates/proto", "crates/ballistics", "crates/device"]"#;
        write(&tree.path.join("Cargo.toml"), &manifest.replace(members, few))?;
        Ok(tree)
    }

    /// Weaves the mutants in; returns those that can be switched.
    pub fn weave(&self, mutants: &BTreeMap<usize, Mutant>) -> Result<BTreeSet<usize>, String> {
        let mut alive: BTreeSet<usize> = mutants.keys().copied().collect();
        let mut constant = BTreeSet::new();
        for _ in 0..ROUNDS_MAX {
            let mut woven = BTreeMap::new();
            let files: BTreeSet<&str> = mutants.values().map(|m| m.file.as_str()).collect();
            for file in files {
                let of_file = mutants.iter().filter(|(id, m)| m.file == file && alive.contains(id));
                let of_file = of_file.map(|(id, mutant)| (*id, mutant.clone())).collect();
                let result = weave::weave(&read(file)?, &of_file, &constant)?;
                for id in &result.left_out {
                    alive.remove(id);
                }
                write(&self.path.join(file), &result.text)?;
                woven.insert(file.to_owned(), result);
            }
            self.add_switch()?;
            let errors = self.errors()?;
            if errors.is_empty() {
                return Ok(alive);
            }
            let before = (alive.len(), constant.len());
            for error in &errors {
                error.blame(&woven, &mut alive, &mut constant);
            }
            if before == (alive.len(), constant.len()) {
                let texts: Vec<&str> = errors.iter().map(|error| error.text.as_str()).collect();
                return Err(format!("the woven device does not build:\n{}", texts.join("\n")));
            }
        }
        Err("the woven device does not build".into())
    }

    fn add_switch(&self) -> Result<(), String> {
        for (_, source) in SOURCES {
            // Mutants woven into it earlier stay.
            let path = self.path.join(source).join("lib.rs");
            let text = std::fs::read_to_string(&path).map_err(|e| e.to_string())?;
            let text = text.replace("#[cfg(test)]\nextern crate std;", UNCONDITIONAL);
            if !text.contains(SWITCH) {
                write(&path, &format!("{text}{SWITCH}"))?;
            }
        }
        Ok(())
    }

    /// Compiler errors of the tests; some are reported only during code generation.
    fn errors(&self) -> Result<Vec<CompileError>, String> {
        for how in [["check", "--tests"], ["test", "--no-run"]] {
            let mut command = self.cargo(&how);
            command.args(["-q", "--offline", "--message-format=json"]).args(packages());
            let output = command.output().map_err(|e| e.to_string())?;
            let stdout = String::from_utf8_lossy(&output.stdout);
            let messages = stdout.lines().filter_map(|line| serde_json::from_str(line).ok());
            let errors: Vec<_> = messages.filter_map(|json| CompileError::of(&json)).collect();
            if !errors.is_empty() {
                return Ok(errors);
            }
            if !output.status.success() {
                return Err(String::from_utf8_lossy(&output.stderr).into_owned());
            }
        }
        Ok(Vec::new())
    }

    /// Builds the tests.
    pub fn tests(&self) -> Result<Vec<Test>, String> {
        self.build(&[])?.ok_or_else(|| "the tests of the device do not build".into())
    }

    fn build(&self, tests: &[&str]) -> Result<Option<Vec<Test>>, String> {
        let arguments = ["test", "-q", "--offline", "--no-run", "--message-format=json"];
        let mut command = self.cargo(&arguments);
        let output = command.args(packages()).args(tests).output().map_err(|e| e.to_string())?;
        if !output.status.success() {
            return Ok(None);
        }
        let stdout = String::from_utf8_lossy(&output.stdout);
        let tests = test_programs(&stdout);
        let tests = tests.map(|it| Test { name: it.name, path: it.path, filter: String::new() });
        let modules: Vec<Vec<Test>> = tests.map(Test::modules).collect::<Result<_, _>>()?;
        Ok(Some(modules.into_iter().flatten().collect()))
    }

    /// Builds the device with this mutant alone, and these tests or all; `None` if it does not
    /// build.
    pub fn build_apart(
        &self,
        mutant: &Mutant,
        tests: &[&str],
    ) -> Result<Option<Vec<Test>>, String> {
        for (_, source) in SOURCES {
            copy(&root().join(source), &self.path.join(source))?;
        }
        let source = read(&mutant.file)?;
        write(&self.path.join(&mutant.file), &weave::replace(&source, mutant))?;
        self.build(tests)
    }

    fn cargo(&self, arguments: &[&str]) -> Command {
        let mut command = cargo(arguments);
        command.current_dir(&self.path).env("CARGO_TARGET_DIR", self.path.with_file_name("target"));
        command
    }
}

/// `-p` for each of the crates.
pub fn packages() -> impl Iterator<Item = &'static str> {
    SOURCES.into_iter().flat_map(|(package, _)| ["-p", package])
}

struct CompileError {
    text: String,
    spans: Vec<(String, usize, usize)>,
    /// A function that has to stay const.
    constant: Option<String>,
}

impl CompileError {
    fn of(json: &Value) -> Option<Self> {
        let message = json.get("message").filter(|message| message["level"] == "error")?;
        let spans = message["spans"].as_array()?.iter().filter(|span| span["is_primary"] == true);
        let spans: Vec<(String, usize, usize)> = spans
            .filter_map(|span| {
                let file = span["file_name"].as_str()?.to_owned();
                let number = |key: &str| Some(span[key].as_u64()? as usize);
                Some((file, number("byte_start")?, number("byte_end")?))
            })
            .collect();
        let what = message["message"].as_str()?;
        let constant = (message["code"]["code"] == "E0015").then(|| {
            let name = what.split('`').nth(1).unwrap_or_default();
            name.rsplit("::").next().unwrap_or_default().to_owned()
        });
        if spans.is_empty() {
            return None;
        }
        let text = message["rendered"].as_str().unwrap_or(what).to_owned();
        Some(Self { text, spans, constant })
    }

    /// Removes the cause of an error: the narrowest place around it, or else everything around it.
    fn blame(
        &self,
        woven: &BTreeMap<String, Woven>,
        alive: &mut BTreeSet<usize>,
        constant: &mut BTreeSet<String>,
    ) {
        if let Some(name) = &self.constant {
            constant.insert(name.clone());
            return;
        }
        for (file, start, end) in &self.spans {
            let Some(woven) = woven.get(file) else { continue };
            let mut places: Vec<&weave::Place> = woven.places.iter().collect();
            places.retain(|place| place.range.start < *end && *start < place.range.end);
            let inside =
                |place: &&&weave::Place| place.range.start <= *start && *end <= place.range.end;
            let size = |place: &&&weave::Place| place.range.len();
            match places.iter().filter(inside).min_by_key(size) {
                Some(place) => place.ids.iter().for_each(|id| {
                    alive.remove(id);
                }),
                // The error spans several places.
                None => places.iter().flat_map(|place| &place.ids).for_each(|id| {
                    alive.remove(id);
                }),
            }
        }
    }
}

/// Copies a file or a directory. Identical files keep their modification time.
fn copy(from: &Path, to: &Path) -> Result<(), String> {
    if from.is_file() {
        return write(
            to,
            &std::fs::read_to_string(from).map_err(|e| format!("{}: {e}", from.display()))?,
        );
    }
    let entries = std::fs::read_dir(from).map_err(|e| format!("{}: {e}", from.display()))?;
    entries.flatten().try_for_each(|entry| copy(&entry.path(), &to.join(entry.file_name())))
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    if std::fs::read_to_string(path).is_ok_and(|old| old == text) {
        return Ok(());
    }
    let directory = path.parent().unwrap_or(path);
    std::fs::create_dir_all(directory)
        .and_then(|()| std::fs::write(path, text))
        .map_err(|e| format!("{}: {e}", path.display()))
}
