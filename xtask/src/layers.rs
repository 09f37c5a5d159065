//! `cargo xtask layers`: the dependencies between the crates, and the laws that text can show.

use std::collections::BTreeSet;
use std::process::ExitCode;

use crate::metadata::{self, Kind, Package};
use crate::{TaskResult, flag, laws, run};

/// Each crate and the workspace crates that it may depend on. Device and client meet only in the
/// program (cli) and in tests: the wire is their only contract.
const ARROWS: &[(&str, &[&str])] = &[
    ("lafet-proto", &[]),
    ("lafet-ballistics", &[]),
    ("lafet-texts", &["lafet-proto"]),
    ("lafet-place", &["lafet-ballistics", "lafet-texts"]),
    ("lafet-drawing", &["lafet-texts"]),
    ("lafet-device", &["lafet-ballistics", "lafet-proto"]),
    ("lafet-plant", &["lafet-device", "lafet-proto"]),
    ("lafet-update", &["lafet-device", "lafet-proto"]),
    (
        "lafet-sim",
        &[
            "lafet-ballistics",
            "lafet-device",
            "lafet-plant",
            "lafet-proto",
            "lafet-texts",
            "lafet-update",
        ],
    ),
    ("lafet-site", &["lafet-texts"]),
    // It tests what is behind the API of a hub, and must know neither hub nor simulator.
    ("lafet-acceptance", &["lafet-texts"]),
    ("lafet-eyes", &[]),
    ("lafet-play", &["lafet-device", "lafet-proto", "lafet-sim", "lafet-texts"]),
    (
        "lafet-verify",
        &[
            "lafet-ballistics",
            "lafet-device",
            "lafet-drawing",
            "lafet-plant",
            "lafet-proto",
            "lafet-sim",
            "lafet-texts",
            "lafet-update",
        ],
    ),
    ("lafet-client", &["lafet-proto", "lafet-texts"]),
    ("lafet-capture", &["lafet-proto", "lafet-texts"]),
    // Its tests have their own link code, because the tester relies on no other.
    ("lafet-conform", &["lafet-client", "lafet-proto", "lafet-texts"]),
    (
        "lafet-hub",
        &[
            "lafet-ballistics",
            "lafet-capture",
            "lafet-client",
            "lafet-eyes",
            "lafet-place",
            "lafet-proto",
            "lafet-site",
            "lafet-texts",
        ],
    ),
    (
        "lafet",
        &[
            "lafet-acceptance",
            "lafet-capture",
            "lafet-client",
            "lafet-conform",
            "lafet-drawing",
            "lafet-eyes",
            "lafet-hub",
            "lafet-place",
            "lafet-sim",
            "lafet-device",
            "lafet-proto",
            "lafet-texts",
            "lafet-update",
        ],
    ),
    ("xtask", &[]),
];

/// Further dependencies of tests.
const TEST_ARROWS: &[(&str, &[&str])] = &[
    ("lafet-client", &["lafet-sim", "lafet-device", "lafet-update"]),
    ("lafet-conform", &["lafet-sim", "lafet-device"]),
    ("lafet-hub", &["lafet-sim", "lafet-device", "lafet-update"]),
    ("lafet-acceptance", &["lafet-hub", "lafet-sim", "lafet-device", "lafet-proto"]),
];

/// Says of each direct dependency what it is for.
const LIST: &str = "docs/design.md";
const SECTION: &str = "What it depends on";

pub fn layers(arguments: &[String]) -> TaskResult {
    flag(arguments, None)?;
    check().map(|()| ExitCode::SUCCESS)
}

/// Fails on a dependency that is not listed here and on a broken law.
pub fn check() -> run::StepResult {
    let packages = metadata::workspace()?;
    let mut problems = wrong_arrows(&packages);
    problems.extend(laws::broken()?);
    let design = run::read(LIST)?;
    problems.extend(unlisted(&packages, &design));
    problems.extend(spare_arrows(&packages));
    problems.extend(other_arrows(&design));
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

/// Arrows that no crate has.
fn spare_arrows(packages: &[Package]) -> Vec<String> {
    let mut problems = Vec::new();
    for (from, to) in ARROWS.iter().flat_map(|(from, to)| to.iter().map(move |to| (from, to))) {
        let package = packages.iter().find(|package| package.name == *from);
        let has = package.is_some_and(|it| it.dependencies.iter().any(|its| its.name == *to));
        if !has {
            problems.push(format!("{from} does not depend on {to}: delete it from ARROWS"));
        }
    }
    problems
}

/// The arrows as the page has them: `from → to, to; from → to (`…, without the common start of the names.
fn other_arrows(page: &str) -> Vec<String> {
    let short = |name: &str| match name.strip_prefix("lafet-") {
        Some(short) => short.to_owned(),
        None => name.replace("lafet", "cli"),
    };
    let text = page.split_once("\nArrows: ").and_then(|(_, rest)| rest.split_once(" ("));
    let text = text.map_or("", |(text, _)| text).replace('\n', " ");
    let clauses = text.split("; ").filter_map(|clause| clause.split_once(" → "));
    let written: BTreeSet<(String, String)> = clauses
        .flat_map(|(from, to)| to.split(", ").map(|to| (from.to_owned(), to.trim().to_owned())))
        .collect();
    let ours: BTreeSet<(String, String)> =
        ARROWS.iter().flat_map(|(from, to)| to.iter().map(|to| (short(from), short(to)))).collect();
    let row = |verb, (from, to): &(String, String)| format!("{LIST}: “{from} → {to}” {verb}");
    let lacks = ours.difference(&written).map(|arrow| row("is missing from “Arrows”", arrow));
    lacks.chain(written.difference(&ours).map(|arrow| row("is not in ARROWS", arrow))).collect()
}

/// Dependencies on other people's packages that the list lacks, and rows of it that no crate needs.
fn unlisted(packages: &[Package], list: &str) -> Vec<String> {
    let ours = |name: &str| packages.iter().any(|package| package.name == name);
    let all = packages.iter().flat_map(|package| &package.dependencies);
    let needed: BTreeSet<&str> =
        all.map(|dependency| dependency.name.as_str()).filter(|name| !ours(name)).collect();
    let section = list.split("\n## ").find(|part| part.starts_with(SECTION)).unwrap_or_default();
    let row = |line: &'_ str| Some(line.strip_prefix("| `")?.split_once('`')?.0.to_owned());
    let listed: BTreeSet<String> = section.lines().filter_map(row).collect();
    let lacks = needed.iter().filter(|name| !listed.contains(**name));
    let spare = listed.iter().filter(|name| !needed.contains(name.as_str()));
    lacks
        .map(|name| format!("{LIST}: `{name}` is not in the table of “{SECTION}”"))
        .chain(spare.map(|name| format!("{LIST}: no crate depends on `{name}`: delete its row")))
        .collect()
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
    fn every_dependency_has_its_row() {
        let package = |name: &str, to: &[&str]| Package {
            name: name.into(),
            version: String::new(),
            licence: None,
            source: None,
            rust_version: None,
            dependencies: to
                .iter()
                .map(|name| Dependency { name: (*name).into(), kind: Kind::Dev })
                .collect(),
        };
        let packages = [package("lafet", &["lafet-proto", "clap"]), package("lafet-proto", &[])];
        let list =
            "# Why\n\n## What it depends on\n\n| `clap` | arguments |\n\n## Next\n| `tar` |\n";
        assert_eq!(unlisted(&packages, list), [""; 0]);
        let spare = list.replace("| arguments |", "| arguments |\n| `url` | addresses |");
        assert_eq!(unlisted(&packages, &spare).len(), 1);
        assert!(unlisted(&packages, "# Why")[0].contains("`clap`"));
    }

    #[test]
    fn arrows_of_the_page_are_those_of_the_code() {
        let page = run::read(LIST).unwrap();
        assert_eq!(other_arrows(&page), [""; 0]);
        let wrong = page.replace("site → texts", "site → texts, hub");
        assert_eq!(other_arrows(&wrong), [format!("{LIST}: “site → hub” is not in ARROWS")]);
        let short = page.replace("site → texts; ", "");
        assert_eq!(
            other_arrows(&short),
            [format!("{LIST}: “site → texts” is missing from “Arrows”")]
        );
        assert!(spare_arrows(&[]).len() > 30);
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
