//! Reads `cargo metadata`: the workspace and its dependencies.

use serde_json::Value;

use crate::run;

/// A package in `cargo metadata`.
pub struct Package {
    pub name: String,
    pub version: String,
    pub licence: Option<String>,
    /// Source of the package; `None` for a package of this workspace.
    pub source: Option<String>,
    pub rust_version: Option<String>,
    pub dependencies: Vec<Dependency>,
}

/// A dependency of a package on another.
pub struct Dependency {
    pub name: String,
    pub kind: Kind,
}

/// When a dependency is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Normal,
    Build,
    Dev,
}

/// The packages of this workspace.
pub fn workspace() -> Result<Vec<Package>, String> {
    packages(&["metadata", "--format-version=1", "--no-deps"])
}

/// The packages of this workspace and all their dependencies, on every platform.
pub fn everything() -> Result<Vec<Package>, String> {
    packages(&["metadata", "--format-version=1", "--all-features"])
}

fn packages(arguments: &[&str]) -> Result<Vec<Package>, String> {
    let text = run::output(&mut run::cargo(arguments))?;
    let json: Value = serde_json::from_str(&text).map_err(|e| format!("cargo metadata: {e}"))?;
    json["packages"].as_array().into_iter().flatten().map(package).collect()
}

fn package(json: &Value) -> Result<Package, String> {
    let text = |key: &str| json[key].as_str().map(String::from);
    let dependencies = json["dependencies"].as_array().into_iter().flatten();
    Ok(Package {
        name: text("name").ok_or("cargo metadata: a package without a name")?,
        version: text("version").unwrap_or_default(),
        licence: text("license"),
        source: text("source"),
        rust_version: text("rust_version"),
        dependencies: dependencies.filter_map(dependency).collect(),
    })
}

fn dependency(json: &Value) -> Option<Dependency> {
    let kind = match json["kind"].as_str() {
        None => Kind::Normal,
        Some("build") => Kind::Build,
        Some(_) => Kind::Dev,
    };
    Some(Dependency { name: json["name"].as_str()?.into(), kind })
}
