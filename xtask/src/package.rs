//! `cargo xtask package`: what the packages for other people's programs need to be published.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::process::{Command, ExitCode};

use serde_json::Value;

use crate::run::{self, StepResult};
use crate::source;
use crate::{TaskResult, flag};

const LICENCES: [&str; 2] = ["LICENSE-APACHE", "LICENSE-MIT"];
const README: &str = "README.md";
/// Has the examples of the README compiled and run.
const DOCTEST: &str = "#[doc = include_str!(\"../README.md\")]";
/// What a registry takes at most.
const KEYWORDS_MAX: usize = 5;
const CATEGORIES_MAX: usize = 5;
/// Macros that read a file when a package is built.
const INCLUDES: [&str; 2] = ["include_str!(", "include_bytes!("];

/// What the session of the client needs besides the standard library.
const SESSION_NEEDS: [&str; 7] =
    ["lafet-client", "lafet-proto", "lafet-texts", "bitflags", "crc", "crc-catalog", "smallvec"];

pub fn package(arguments: &[String]) -> TaskResult {
    let oldest = flag(arguments, Some("--oldest"))?;
    let published = checked()?;
    if oldest {
        oldest_compiler(&published)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Everything that CI checks of them.
pub fn all() -> StepResult {
    checked().map(|_| ())
}

fn checked() -> Result<Published, String> {
    let published = check()?;
    session_alone()?;
    rehearse()?;
    Ok(published)
}

/// Makes every package as it would be published, in the order of their dependencies. They are not
/// built again from their archives: what could differ there, a file from outside, is looked for
/// above, and the workspace builds the rest.
fn rehearse() -> StepResult {
    let publish = ["publish", "--workspace", "--dry-run", "--no-verify", "--allow-dirty"];
    run::show(&mut run::cargo(&publish))
}

/// The packages are built by the oldest compiler that they name; rustup installs it if it is missing.
fn oldest_compiler(published: &Published) -> StepResult {
    let version = &published.rust_version;
    let install = ["toolchain", "install", version, "--profile=minimal", "--no-self-update"];
    run::output(Command::new("rustup").args(install))?;
    let mut build = Command::new("rustup");
    build.args(["run", version, "cargo", "check", "--locked"]).current_dir(run::root());
    build.args(published.names.iter().flat_map(|name| ["--package", name]));
    // A folder of its own: neither compiler can use the output of the other.
    run::show(build.env("CARGO_TARGET_DIR", run::target().join("oldest")))
}

/// The client without its features is built, and needs no more than it says.
fn session_alone() -> StepResult {
    run::show(&mut run::cargo(&["check", "--package", "lafet-client", "--no-default-features"]))?;
    let tree = ["tree", "--package=lafet-client", "--no-default-features", "--edges=normal"];
    let tree = run::output(run::cargo(&tree).args(["--prefix=none", "--format={p}"]))?;
    let names: BTreeSet<&str> = tree.lines().filter_map(|line| line.split(' ').next()).collect();
    let more = names.into_iter().filter(|name| !SESSION_NEEDS.contains(name));
    let more: Vec<String> = more.map(String::from).collect();
    run::verdict("the client without features needs", &more)
}

/// The packages that are published, and the oldest compiler for all of them.
struct Published {
    names: Vec<String>,
    rust_version: String,
}

/// Fails on a package that lacks something, and on a file that is read from outside of its package.
fn check() -> Result<Published, String> {
    let text = run::output(&mut run::cargo(&["metadata", "--format-version=1", "--no-deps"]))?;
    let json: Value = serde_json::from_str(&text).map_err(|e| format!("cargo metadata: {e}"))?;
    let packages: Vec<&Value> = json["packages"].as_array().into_iter().flatten().collect();
    let all: BTreeSet<&str> = packages.iter().map(|package| name(package)).collect();
    let published: Vec<&Value> = packages.into_iter().filter(|it| is_published(it)).collect();
    let names: BTreeSet<&str> = published.iter().map(|package| name(package)).collect();
    let mut problems = Vec::new();
    for package in &published {
        let mut found = missing(package);
        found.extend(unpublished(package, &all, &names));
        found.extend(files(&folder(package)));
        problems.extend(found.into_iter().map(|problem| format!("{}: {problem}", name(package))));
    }
    problems.extend(includes()?);
    run::verdict("packages that cannot be published", &problems)?;
    println!("   {} packages have what a registry and their users need", published.len());
    let versions = published.iter().filter_map(|package| package["rust_version"].as_str());
    let rust_version = versions.max().unwrap_or_default().to_owned();
    Ok(Published { names: names.into_iter().map(String::from).collect(), rust_version })
}

pub fn name(package: &Value) -> &str {
    package["name"].as_str().unwrap_or_default()
}

/// `publish` is null where every registry may have it, and an empty list where none may.
pub fn is_published(package: &Value) -> bool {
    package["publish"].is_null()
}

fn folder(package: &Value) -> PathBuf {
    let manifest = Path::new(package["manifest_path"].as_str().unwrap_or_default());
    manifest.parent().unwrap_or(manifest).to_path_buf()
}

/// What the manifest does not say.
fn missing(package: &Value) -> Vec<String> {
    let mut problems = Vec::new();
    for key in ["description", "license", "readme", "rust_version"] {
        if package[key].as_str().is_none_or(str::is_empty) {
            problems.push(format!("no {}", key.replace('_', "-")));
        }
    }
    for (key, most) in [("keywords", KEYWORDS_MAX), ("categories", CATEGORIES_MAX)] {
        let count = package[key].as_array().map_or(0, Vec::len);
        if count == 0 || count > most {
            problems.push(format!("{count} {key}, 1…{most} wanted"));
        }
    }
    problems
}

/// Crates of the workspace that it needs and no registry has.
fn unpublished(package: &Value, all: &BTreeSet<&str>, published: &BTreeSet<&str>) -> Vec<String> {
    let dependencies = package["dependencies"].as_array().into_iter().flatten();
    let names = dependencies.filter_map(|dependency| dependency["name"].as_str());
    let lacking = names.filter(|name| all.contains(name) && !published.contains(name));
    lacking.map(|name| format!("depends on {name}, which is not published")).collect()
}

/// Licences as in the root, a README whose examples are compiled.
fn files(folder: &Path) -> Vec<String> {
    let read = |path: PathBuf| fs::read_to_string(path).unwrap_or_default();
    let mut problems = Vec::new();
    for licence in LICENCES {
        if read(folder.join(licence)) != read(run::root().join(licence)) {
            problems.push(format!("{licence} is not that of the project"));
        }
    }
    if !read(folder.join(README)).contains("```rust") {
        problems.push(format!("{README} has no example"));
    }
    if !read(folder.join("src/lib.rs")).contains(DOCTEST) {
        problems.push(format!("src/lib.rs lacks {DOCTEST} for documentation tests"));
    }
    problems
}

/// Files that sources of the crates read from outside of their package.
fn includes() -> Result<Vec<String>, String> {
    let mut problems = Vec::new();
    for file in source::workspace()? {
        // This program names includes in its own examples.
        if file.crate_name().is_none() || !file.path.contains("/src/") {
            continue;
        }
        for (number, line) in file.numbered() {
            for path in included(&line.text).filter(|path| leaves(&file.path, path)) {
                let place = format!("{}:{number}", file.path);
                problems.push(format!("{place}: {path} is outside of the package"));
            }
        }
    }
    Ok(problems)
}

/// Paths of files that a line includes: the first text after the macro, also inside `concat!`.
fn included(line: &str) -> impl Iterator<Item = &str> {
    INCLUDES.iter().flat_map(move |macro_name| {
        line.match_indices(macro_name).filter_map(|(at, _)| line[at..].split('"').nth(1))
    })
}

/// Whether a path, from the folder of a source `crates/NAME/src/…`, leads out of `crates/NAME`.
fn leaves(source: &str, path: &str) -> bool {
    let inside = Path::new(source).components().count().saturating_sub(3);
    let mut depth = inside as isize;
    for component in Path::new(path).components() {
        match component {
            Component::ParentDir => depth -= 1,
            Component::Normal(_) => depth += 1,
            _ => {}
        }
        if depth < 0 {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_complete_manifest_has_no_problem() {
        let package = json!({
            "description": "d", "license": "MIT", "readme": "README.md", "rust_version": "1.88",
            "keywords": ["a"], "categories": ["embedded"],
        });
        assert_eq!(missing(&package), [""; 0]);
    }

    #[test]
    fn what_a_manifest_lacks_is_named() {
        let package = json!({
            "description": "", "license": "MIT", "readme": null, "rust_version": "1.88",
            "keywords": ["a", "b", "c", "d", "e", "f"], "categories": [],
        });
        let expected = ["no description", "no readme", "6 keywords, 1…5 wanted"];
        let problems = missing(&package);
        assert_eq!(problems[..3], expected);
        assert_eq!(problems[3..], ["0 categories, 1…5 wanted"]);
    }

    #[test]
    fn a_dependency_must_be_published_too() {
        let package = json!({"dependencies": [{"name": "a"}, {"name": "b"}, {"name": "serde"}]});
        let all = BTreeSet::from(["a", "b", "c"]);
        let published = BTreeSet::from(["a"]);
        let problems = unpublished(&package, &all, &published);
        assert_eq!(problems, ["depends on b, which is not published"]);
    }

    #[test]
    fn paths_out_of_the_package_are_found() {
        let paths = |line| included(line).collect::<Vec<_>>();
        assert_eq!(paths("const A: &str = include_str!(\"a.txt\");"), ["a.txt"]);
        assert_eq!(paths("text: include_str!(concat!(\"../../x/\", $name)),"), ["../../x/"]);
        assert_eq!(paths("let a = \"include\";"), [""; 0]);
        assert!(!leaves("crates/sim/src/exercise/shipped.rs", "../../scenarios/"));
        assert!(leaves("crates/sim/src/exercise/shipped.rs", "../../../scenarios/"));
        assert!(!leaves("crates/hub/src/lib.rs", "../hub.example.toml"));
        assert!(leaves("crates/hub/src/lib.rs", "../../client/a.txt"));
    }
}
