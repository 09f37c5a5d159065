//! Where a program that verifies signatures can panic. The library that does so checks its indices, and the compiler
//! cannot see that none of them is ever wrong; nothing else of the program may contain such a check.
//!
//! The other boards have no panic at all, or they would not link.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::elf::Elf;
use crate::run::StepResult;
use crate::thumb::{self, Effect};

/// Whose functions may: those of the library, and the one of ours that they may have become a part of.
const MAY: [&str; 2] = ["ed25519_compact::", "lafet_update::sign::check"];
/// How the functions of `core` are named that panic.
const PANICS: [&str; 3] = ["panic", "_fail", "_failed"];

/// Fails if anything else of the program can; says what can.
pub fn check(what: &str, program: &Path) -> StepResult {
    let elf = Elf::read(program)?;
    let functions = elf.functions();
    let panicking = callers(&elf, &functions)?;
    let (may, others): (Vec<_>, Vec<_>) =
        panicking.iter().partition(|name| MAY.iter().any(|of| own(name).starts_with(of)));
    let list =
        |names: &[&String]| names.iter().map(|it| it.as_str()).collect::<Vec<_>>().join(", ");
    println!("   {what}: of {} functions {} can panic: {}", functions.len(), may.len(), list(&may));
    match others.is_empty() {
        true => Ok(()),
        false => Err(format!("{what}: a panic can be reached from {}", list(&others))),
    }
}

/// The functions that call one of `core` which panics, or which calls such a one, without those of `core`.
fn callers(
    elf: &Elf,
    functions: &BTreeMap<u32, (u32, String)>,
) -> Result<BTreeSet<String>, String> {
    let mut panics: BTreeSet<u32> =
        functions.iter().filter(|(_, (_, name))| is_panic(name)).map(|(start, _)| *start).collect();
    if panics.is_empty() {
        return Err("no function of core panics: they have other names now".to_owned());
    }
    let mut calling = BTreeSet::new();
    loop {
        let known = panics.len();
        for (start, (end, name)) in functions {
            if !panics.contains(start) && goes_to(elf, *start, *end).any(|to| panics.contains(&to))
            {
                match is_of_core(name) {
                    true => _ = panics.insert(*start),
                    false => _ = calling.insert(name.clone()),
                }
            }
        }
        if panics.len() == known {
            return Ok(calling);
        }
    }
}

fn is_of_core(name: &str) -> bool {
    own(name).starts_with("core::")
}

fn is_panic(name: &str) -> bool {
    is_of_core(name) && PANICS.iter().any(|word| name.contains(word))
}

/// A name without the brackets of an implementation.
fn own(name: &str) -> &str {
    name.trim_start_matches(['<', '&'])
}

/// Where the instructions of a function lead to, without calls by register.
fn goes_to(elf: &Elf, start: u32, end: u32) -> impl Iterator<Item = u32> {
    let mut at = start;
    std::iter::from_fn(move || {
        while at < end {
            let first = elf.half(at)?;
            let here = at;
            let is_wide = thumb::is_wide(first) && !elf.is_data(here);
            at += if is_wide { 4 } else { 2 };
            let effect = match is_wide {
                _ if elf.is_data(here) => Effect::None,
                true => thumb::wide(here, first, elf.half(here + 2)?),
                false => thumb::narrow(here, first),
            };
            if let Effect::Goes(to) | Effect::Calls(to) = effect {
                return Some(to);
            }
        }
        None
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_panics_is_known_by_its_name() {
        for name in [
            "core::panicking::panic_bounds_check",
            "core::slice::index::slice_index_fail",
            "core::option::unwrap_failed",
        ] {
            assert!(is_panic(name), "{name}");
        }
        for name in ["core::ptr::write", "lafet_device::panics", "<u8 as core::fmt::Debug>::fmt"] {
            assert!(!is_panic(name), "{name}");
        }
        assert_eq!(
            own("<ed25519_compact::sha512::Hash>::update"),
            "ed25519_compact::sha512::Hash>::update"
        );
    }
}
