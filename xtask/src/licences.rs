//! `cargo xtask licences`: checks the dependencies against deny.toml, without cargo-deny.

use std::collections::BTreeMap;
use std::process::ExitCode;

use spdx::{Expression, ParseMode};

use crate::metadata::{self, Package};
use crate::{TaskResult, flag, run};

const POLICY: &str = "deny.toml";
const CRATES_IO: &str = "registry+https://github.com/rust-lang/crates.io-index";

pub fn licences(arguments: &[String]) -> TaskResult {
    flag(arguments, None)?;
    check().map(|()| ExitCode::SUCCESS)
}

/// Fails on a licence, crate or source that deny.toml does not allow.
pub fn check() -> run::StepResult {
    let policy = Policy::parse(&run::read(POLICY)?)?;
    let packages = metadata::everything()?;
    let problems: Vec<String> = packages.iter().filter_map(|p| policy.problem(p)).collect();
    run::verdict("dependencies that deny.toml does not allow", &problems)?;
    println!("   {} packages, every licence is in {POLICY}", packages.len());
    for twin in twins(&packages) {
        println!("   note: {twin}");
    }
    Ok(())
}

struct Policy {
    allowed: Vec<String>,
    /// Crates that may have further licences.
    exceptions: BTreeMap<String, Vec<String>>,
    /// Banned crates and the reasons.
    banned: BTreeMap<String, String>,
}

impl Policy {
    fn parse(text: &str) -> Result<Self, String> {
        let table: toml::Table = text.parse().map_err(|e| format!("{POLICY}: {e}"))?;
        let array = |section: &str, key: &str| {
            let value = table.get(section).and_then(|section| section.get(key));
            value.and_then(toml::Value::as_array).cloned().unwrap_or_default()
        };
        if !array("licenses", "clarify").is_empty() {
            return Err(format!("{POLICY}: licenses.clarify is not supported by this check"));
        }
        let allowed = texts(&array("licenses", "allow"));
        let exceptions = array("licenses", "exceptions");
        let exceptions = exceptions.iter().map(exception).collect::<Option<_>>();
        let exceptions = exceptions.ok_or(format!("{POLICY}: an exception is not understood"))?;
        if allowed.is_empty() {
            return Err(format!("{POLICY}: [licenses] allow is empty"));
        }
        let banned = array("bans", "deny").iter().filter_map(ban).collect();
        Ok(Self { allowed, exceptions, banned })
    }

    fn problem(&self, package: &Package) -> Option<String> {
        let Package { name, version, source, .. } = package;
        let say = |what: String| Some(format!("{name} {version}: {what}"));
        if let Some(reason) = self.banned.get(name) {
            return say(format!("banned: {reason}"));
        }
        if let Some(source) = source.as_ref().filter(|source| *source != CRATES_IO) {
            return say(format!("comes from {source}, not from crates.io"));
        }
        let Some(licence) = &package.licence else {
            return say("states no licence".into());
        };
        match Expression::parse_mode(licence, ParseMode::LAX) {
            Err(error) => say(format!("unreadable licence `{licence}`: {}", error.reason)),
            Ok(expression) => {
                let own = self.exceptions.get(name).into_iter().flatten();
                let allowed: Vec<&String> = self.allowed.iter().chain(own).collect();
                let allowed = |licence: &spdx::LicenseReq| {
                    allowed.iter().any(|allowed| **allowed == licence.to_string())
                };
                match expression.evaluate(allowed) {
                    true => None,
                    false => say(format!("licence `{licence}` is not allowed")),
                }
            }
        }
    }
}

fn texts(array: &[toml::Value]) -> Vec<String> {
    array.iter().filter_map(|it| it.as_str().map(String::from)).collect()
}

/// Parses an entry of `[licenses] exceptions`: a crate, and what it may have beside what all may.
fn exception(value: &toml::Value) -> Option<(String, Vec<String>)> {
    let allowed = texts(value.get("allow")?.as_array()?);
    Some((value.get("crate")?.as_str()?.into(), allowed))
}

/// Parses an entry of `[bans] deny`: a name, or a table with name and reason.
fn ban(value: &toml::Value) -> Option<(String, String)> {
    let text = |key: &str| value.get(key).and_then(toml::Value::as_str);
    let name = value.as_str().or(text("crate")).or(text("name"))?;
    Some((name.into(), text("reason").unwrap_or("see deny.toml").into()))
}

/// Crates present in more than one version.
fn twins(packages: &[Package]) -> Vec<String> {
    let mut versions: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for package in packages {
        versions.entry(&package.name).or_default().push(&package.version);
    }
    let twins = versions.iter().filter(|(_, versions)| versions.len() > 1);
    twins.map(|(name, versions)| format!("{name} in versions {}", versions.join(", "))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const POLICY_TEXT: &str = r#"
        licenses.allow = ["MIT", "Apache-2.0 WITH LLVM-exception", "Unicode-3.0"]
        licenses.exceptions = [{ crate = "own", allow = ["MPL-2.0"] }]
        bans.deny = [{ crate = "bad", reason = "why" }]
    "#;

    fn problem(name: &str, licence: Option<&str>, source: Option<&str>) -> Option<String> {
        let package = Package {
            name: name.into(),
            version: "1.0.0".into(),
            licence: licence.map(String::from),
            source: source.map(String::from),
            rust_version: None,
            dependencies: Vec::new(),
        };
        Policy::parse(POLICY_TEXT).unwrap().problem(&package)
    }

    #[test]
    fn expressions_are_evaluated() {
        assert_eq!(problem("a", Some("GPL-3.0-only OR MIT"), None), None);
        assert_eq!(problem("a", Some("MIT/AGPL-3.0"), None), None);
        assert_eq!(problem("a", Some("(GPL-2.0-only OR MIT) AND Unicode-3.0"), None), None);
        assert_eq!(problem("a", Some("Apache-2.0 WITH LLVM-exception"), None), None);
        assert!(problem("a", Some("MIT AND GPL-3.0-only"), None).unwrap().contains("not allowed"));
        assert!(problem("a", Some("Apache-2.0"), None).is_some());
        assert!(problem("a", Some("Beerware-ish"), None).unwrap().contains("unreadable"));
        assert!(problem("a", None, None).unwrap().contains("states no licence"));
    }

    #[test]
    fn an_exception_is_for_one_crate() {
        assert_eq!(problem("own", Some("MPL-2.0"), None), None);
        assert_eq!(problem("own", Some("MIT"), None), None);
        assert!(problem("other", Some("MPL-2.0"), None).is_some());
        assert!(problem("own", Some("GPL-3.0-only"), None).is_some());
    }

    #[test]
    fn banned_crates_and_foreign_sources_are_named() {
        assert_eq!(problem("bad", Some("MIT"), None).unwrap(), "bad 1.0.0: banned: why");
        assert_eq!(problem("a", Some("MIT"), Some(CRATES_IO)), None);
        assert!(problem("a", Some("MIT"), Some("git+https://example.org/a")).is_some());
    }

    #[test]
    fn a_policy_that_is_not_understood_is_an_error() {
        assert!(Policy::parse("licenses.allow = []").is_err());
        assert!(Policy::parse("licenses.allow = ['MIT']\nlicenses.clarify = [1]").is_err());
        assert!(Policy::parse("licenses.allow = ['MIT']\nlicenses.exceptions = [1]").is_err());
        assert!(Policy::parse("not toml").is_err());
    }
}
