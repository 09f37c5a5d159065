//! What it costs to make bytes of values and values of bytes: lafet beside its peers.
//!
//! `count N` runs each case N times (with a part of a name: those alone) and prints nothing but the cases: for callgrind. `time` prints the
//! nanoseconds of each. `cargo xtask bench --only codec` runs both and makes the tables.

mod case;
mod lafet;
#[cfg(feature = "peers")]
mod peers;
mod values;

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (count, only) = match words[..] {
        ["count", n] => (n.parse().unwrap_or(0), ""),
        ["count", n, only] => (n.parse().unwrap_or(0), only),
        ["time"] => (1, ""),
        _ => (0, ""),
    };
    let timed = words == ["time"];
    if count == 0 {
        eprintln!("count N [PART OF A NAME] | time");
        return ExitCode::from(2);
    }
    let mut cases = lafet::cases();
    #[cfg(feature = "peers")]
    cases.extend(peers::cases());
    for case in cases.iter_mut().filter(|case| case.name.contains(only)) {
        if let Err(wrong) = case.run(count) {
            eprintln!("{wrong}");
            return ExitCode::FAILURE;
        }
        let ns = if timed { case.nanoseconds() } else { 0.0 };
        println!("{}\t{}\t{}\t{ns:.2}", case.name, case.symbol, case.bytes);
    }
    ExitCode::SUCCESS
}
