//! `cargo xtask semver`: what the packages for other people's programs have changed in their interfaces.

use std::process::{Command, ExitCode};

use serde_json::Value;

use crate::TaskResult;
use crate::package;
use crate::{run, setup};

const VERSION: &str = "0.51.0";

pub fn semver(arguments: &[String]) -> TaskResult {
    let baseline = match arguments {
        [] => newest_tag()?,
        [revision] if !revision.starts_with('-') => revision.clone(),
        _ => return Err("usage: cargo xtask semver [REVISION]".to_owned()),
    };
    let (compared, added): (Vec<_>, Vec<_>) =
        libraries()?.into_iter().partition(|library| exists(&baseline, &library.manifest));
    if compared.is_empty() {
        return Err(format!("{baseline} has none of the packages: is it a revision?"));
    }
    for library in added {
        println!("   {}: not in {baseline}, so nothing to compare", library.name);
    }
    // Compiling it takes minutes.
    let tool = setup::tool("cargo-semver-checks", VERSION, false)?;
    let mut command = Command::new(tool);
    command.current_dir(run::root()).args(["semver-checks", "--baseline-rev", &baseline]);
    command.args(compared.iter().flat_map(|library| ["--package", &library.name]));
    run::show(&mut command)?;
    Ok(ExitCode::SUCCESS)
}

/// Nothing is on a registry yet, so a release is its tag.
fn newest_tag() -> Result<String, String> {
    let mut describe = Command::new("git");
    describe.current_dir(run::root()).args(["describe", "--tags", "--abbrev=0"]);
    let none = |_| "no release has a tag yet: name a revision to compare with".to_owned();
    run::output(&mut describe).map(|tag| tag.trim().to_owned()).map_err(none)
}

struct Library {
    name: String,
    /// From the root.
    manifest: String,
}

/// Published packages that have an interface of Rust.
fn libraries() -> Result<Vec<Library>, String> {
    let text = run::output(&mut run::cargo(&["metadata", "--format-version=1", "--no-deps"]))?;
    let json: Value = serde_json::from_str(&text).map_err(|e| format!("cargo metadata: {e}"))?;
    let root = run::root();
    let library = |package: &Value| {
        let manifest = package["manifest_path"].as_str()?;
        let manifest = manifest.strip_prefix(root.to_str()?)?.trim_start_matches('/').to_owned();
        Some(Library { name: package::name(package).to_owned(), manifest })
    };
    let packages = json["packages"].as_array().into_iter().flatten();
    let published = packages.filter(|it| package::is_published(it) && is_library(it));
    Ok(published.filter_map(library).collect())
}

fn is_library(package: &Value) -> bool {
    let targets = package["targets"].as_array().into_iter().flatten();
    let mut kinds = targets.flat_map(|target| target["kind"].as_array().into_iter().flatten());
    kinds.any(|kind| kind == "lib")
}

fn exists(revision: &str, manifest: &str) -> bool {
    let mut show = Command::new("git");
    show.current_dir(run::root()).args(["cat-file", "-e", &format!("{revision}:{manifest}")]);
    run::output(&mut show).is_ok()
}
