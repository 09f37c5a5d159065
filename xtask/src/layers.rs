//! `cargo xtask layers`: the dependencies between the crates, and the laws that text can show.

use std::process::ExitCode;

use crate::metadata::{self, Kind, Package};
use crate::{TaskResult, flag, laws, run};

/// Each crate and the workspace crates that it may depend on. Device and client meet only in the
/// program (cli) and in tests: the wire is their only contract.
const ARROWS: &[(&str, &[&str])] = &[
    ("lafet-proto", &[]),
    ("lafet-ballistics", &[]),
    ("lafet-place", &["lafet-ballistics"]),
    ("lafet-device", &["lafet-ballistics", "lafet-proto"]),
    ("lafet-plant", &["lafet-device", "lafet-proto"]),
    ("lafet-sim", &["lafet-ballistics", "lafet-device", "lafet-plant", "lafet-proto"]),
    ("lafet-fuzz", &["lafet-device", "lafet-proto"]),
    ("lafet-site", &["lafet-ballistics"]),
    ("lafet-model", &["lafet-device", "lafet-proto"]),
    ("lafet-client", &["lafet-proto"]),
    ("lafet-capture", &["lafet-proto"]),
    // Its tests have their own link code, because the tester relies on no other.
    ("lafet-conform", &["lafet-client", "lafet-proto"]),
    (
        "lafet-hub",
        &["lafet-ballistics", "lafet-capture", "lafet-client", "lafet-proto", "lafet-site"],
    ),
    (
        "lafet",
        &[
            "lafet-capture",
            "lafet-client",
            "lafet-conform",
            "lafet-hub",
            "lafet-place",
            "lafet-sim",
            "lafet-device",
            "lafet-proto",
        ],
    ),
    ("xtask", &[]),
];

/// Further dependencies of tests.
const TEST_ARROWS: &[(&str, &[&str])] = &[
    ("lafet-client", &["lafet-sim", "lafet-device"]),
    ("lafet-conform", &["lafet-sim", "lafet-device"]),
    ("lafet-hub", &["lafet-sim", "lafet-device"]),
];

pub fn layers(arguments: &[String]) -> TaskResult {
    flag(arguments, None)?;
    check().map(|()| ExitCode::SUCCESS)
}

/// Fails on a dependency that is not listed here and on a broken law.
pub fn check() -> run::StepResult {
    let packages = metadata::workspace()?;
    let mut problems = wrong_arrows(&packages);
    problems.extend(laws::broken()?);
    run::verdict("broken laws", &problems)?;
    println!("   {} crates, dependencies and laws are as listed", packages.len());
    Ok(())
}

fn wrong_arrows(packages: &[Package]) -> Vec<String> {
    let mut problems = Vec::new();
    for Package { name, dependencies, .. } in packages {
        let Some(allowed) = row(ARROWS, name) else {
            problems.push(format!("{name}: not in ARROWS of xtask/src/layers.rs; add it there"));
            continue;
        };
        let in_tests = row(TEST_ARROWS, name).unwrap_or_default();
        for dependency in dependencies {
            let ours = packages.iter().any(|package| package.name == dependency.name);
            let to = dependency.name.as_str();
            let test = dependency.kind == Kind::Dev;
            if ours && !allowed.contains(&to) && !(test && in_tests.contains(&to)) {
                let kind = if test { " in tests" } else { "" };
                problems.push(format!("{name} must not depend on {to}{kind}"));
            }
        }
    }
    problems
}

fn row<'a>(table: &[(&str, &'a [&'a str])], name: &str) -> Option<&'a [&'a str]> {
    table.iter().find(|(from, _)| *from == name).map(|(_, to)| *to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metadata::Dependency;

    fn problems(arrows: &[(&str, &str, Kind)]) -> Vec<String> {
        let names = ["lafet-proto", "lafet-device", "lafet-sim", "lafet-client", "lafet"];
        let package = |name: &&str| Package {
            name: (*name).into(),
            version: String::new(),
            licence: None,
            source: None,
            rust_version: None,
            dependencies: arrows
                .iter()
                .filter(|(from, _, _)| from == name)
                .map(|(_, to, kind)| Dependency { name: (*to).into(), kind: *kind })
                .collect(),
        };
        wrong_arrows(&names.iter().map(package).collect::<Vec<_>>())
    }

    #[test]
    fn drawn_arrows_hold() {
        let arrows = [
            ("lafet-device", "lafet-proto", Kind::Normal),
            ("lafet-client", "tokio", Kind::Normal),
            ("lafet-client", "lafet-sim", Kind::Dev),
            ("lafet", "lafet-device", Kind::Normal),
        ];
        assert_eq!(problems(&arrows), [""; 0]);
    }

    #[test]
    fn device_and_client_never_meet() {
        let arrows = [
            ("lafet-client", "lafet-device", Kind::Normal),
            ("lafet-client", "lafet-sim", Kind::Build),
            ("lafet-device", "lafet-client", Kind::Dev),
        ];
        let expected = [
            "lafet-device must not depend on lafet-client in tests",
            "lafet-client must not depend on lafet-device",
            "lafet-client must not depend on lafet-sim",
        ];
        assert_eq!(problems(&arrows), expected);
    }

    #[test]
    fn the_protocol_depends_on_nothing_of_ours() {
        assert_eq!(problems(&[("lafet-proto", "lafet-sim", Kind::Dev)]).len(), 1);
    }

    #[test]
    fn a_crate_without_a_place_is_named() {
        let package = Package {
            name: "lafet-new".into(),
            version: String::new(),
            licence: None,
            source: None,
            rust_version: None,
            dependencies: Vec::new(),
        };
        assert!(wrong_arrows(&[package])[0].starts_with("lafet-new: not in ARROWS"));
    }
}
