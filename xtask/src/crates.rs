//! The picture of the crates and their arrows in ARCHITECTURE.md, drawn from `cargo metadata`.

use std::collections::BTreeMap;

use crate::metadata::{self, Kind, Package};
use crate::run;

/// The page that has the picture.
pub const PAGE: &str = "ARCHITECTURE.md";
const BEGIN: &str = "<!-- crates:begin -->\n";
const END: &str = "<!-- crates:end -->";
/// Runs the tasks; depends on no crate of the product.
const TASKS: &str = "xtask";

/// What each crate needs of the workspace.
type Needs = BTreeMap<String, Vec<String>>;

/// The page with a fresh picture.
pub fn page() -> Result<String, String> {
    let text = run::read(PAGE)?;
    let between = text.split_once(BEGIN).and_then(|(before, rest)| {
        let (_, after) = rest.split_once(END)?;
        Some((before, after))
    });
    let (before, after) = between
        .ok_or_else(|| format!("{PAGE}: the marks of the picture of the crates are missing"))?;
    let picture = picture(&needs(&metadata::workspace()?));
    Ok(format!("{before}{BEGIN}{picture}{END}{after}"))
}

/// Without dependencies of tests and build scripts.
fn needs(packages: &[Package]) -> Needs {
    let known = |name: &str| name != TASKS && packages.iter().any(|package| package.name == name);
    let all = packages.iter().filter(|package| known(&package.name));
    all.map(|package| {
        let needed = package.dependencies.iter().filter(|it| it.kind == Kind::Normal);
        let mut needed: Vec<String> =
            needed.map(|it| it.name.clone()).filter(|name| known(name)).collect();
        needed.sort();
        needed.dedup();
        (package.name.clone(), needed)
    })
    .collect()
}

/// A Mermaid diagram. Where one crate leads to another by way of a third there is no arrow of its own.
fn picture(needs: &Needs) -> String {
    let mut text = String::from("```mermaid\ngraph TD\n");
    for (name, needed) in needs {
        for other in needed {
            let by_way = needed.iter().any(|via| via != other && leads(needs, via, other));
            if !by_way {
                text += &format!("  {name} --> {other}\n");
            }
        }
    }
    text + "```\n"
}

/// Whether one crate needs another, itself or by way of others. Cargo allows no circles.
fn leads(needs: &Needs, from: &str, to: &str) -> bool {
    let next = needs.get(from).into_iter().flatten();
    next.into_iter().any(|name| name == to || leads(needs, name, to))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(all: &[(&str, &[&str])]) -> Needs {
        let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        all.iter().map(|(name, needed)| ((*name).to_owned(), owned(needed))).collect()
    }

    /// An arrow for each crate that is needed directly and by no other way.
    #[test]
    fn arrows() {
        let needs = of(&[("hub", &["client", "proto"]), ("client", &["proto"]), ("proto", &[])]);
        let picture = picture(&needs);
        assert_eq!(picture, "```mermaid\ngraph TD\n  client --> proto\n  hub --> client\n```\n");
        assert!(leads(&needs, "hub", "proto") && !leads(&needs, "proto", "hub"));
    }
}
