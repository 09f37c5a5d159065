//! What it costs to make bytes of values and values of bytes: lafet beside its peers.
//!
//! `cargo xtask bench --only codec` has it print the tables of docs/performance.md, and
//! `cargo xtask bench --check` compare instructions with those that are written down.

mod callgrind;
mod case;
mod client;
mod gate;
mod lafet;
mod page;
#[cfg(feature = "peers")]
mod peers;
mod values;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

use case::Case;

const USAGE: &str = "report | check FILE | write FILE | count N [PART OF A NAME]";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words[..] {
        ["report"] => report(),
        ["check", file] => counted().and_then(|counts| gate::check(Path::new(file), &counts)),
        ["write", file] => {
            let written = counted().and_then(|counts| gate::write(Path::new(file), &counts));
            written.map(|()| String::new())
        }
        ["count", times] => count(times, ""),
        ["count", times, only] => count(times, only),
        _ => Err(USAGE.into()),
    };
    match done {
        Ok(text) => {
            println!("{text}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn cases() -> Vec<Case> {
    let cases = lafet::cases().into_iter();
    #[cfg(feature = "peers")]
    let cases = cases.chain(peers::cases());
    cases.collect()
}

/// Runs the cases so often and no more: for callgrind.
fn count(times: &str, only: &str) -> Result<String, String> {
    let times = times.parse().map_err(|_| USAGE)?;
    let mut cases = cases();
    cases
        .iter_mut()
        .filter(|case| case.name.contains(only))
        .try_for_each(|case| case.run(times))?;
    Ok(String::new())
}

/// Instructions of each case.
fn counted() -> Result<BTreeMap<&'static str, f64>, String> {
    let counts = callgrind::instructions()?;
    let cases = cases();
    let of = |case: &Case| {
        let mut same = cases.iter().filter(|other| other.address == case.address);
        let count = same.find_map(|case| counts.get(case.symbol).copied());
        count.map(|count| (case.name, count)).ok_or_else(|| format!("{}: not seen", case.symbol))
    };
    cases.iter().map(of).collect()
}

fn report() -> Result<String, String> {
    let counts = counted()?;
    let mut figures = page::Figures::new();
    for mut case in cases() {
        case.run(1)?;
        let count = counts.get(case.name).copied().unwrap_or(f64::NAN);
        figures.insert(case.name, (count, case.nanoseconds(), case.bytes));
    }
    page::print(&figures);
    Ok(String::new())
}
