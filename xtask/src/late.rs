//! `cargo xtask late`: the client against late, lost and doubled answers, for as long as is wanted.

use std::process::ExitCode;

use crate::TaskResult;
use crate::run;

/// Exchanges without an argument.
const DEFAULT: u32 = 10_000_000;
const TEST: &str = "session::tests::no_late_answer_is_believed_in_a_long_run";

pub fn late(arguments: &[String]) -> TaskResult {
    let exchanges = exchanges(arguments)?;
    let mut command = run::cargo(&[
        "test",
        "--release",
        "-p",
        "lafet-client",
        "--lib",
        "--",
        "--ignored",
        "--exact",
        "--nocapture",
        TEST,
    ]);
    run::show(command.env("LAFET_EXCHANGES", exchanges.to_string()))?;
    Ok(ExitCode::SUCCESS)
}

fn exchanges(arguments: &[String]) -> Result<u32, String> {
    match arguments {
        [] => Ok(DEFAULT),
        [count] => match count.replace('_', "").parse() {
            Ok(count @ 1..) => Ok(count),
            _ => Err(format!("`{count}` is no number of exchanges, like {DEFAULT}")),
        },
        [_, more, ..] => Err(format!("unexpected argument `{more}`: one number at most")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_or_none() {
        let of = |words: &[&str]| {
            exchanges(&words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>())
        };
        assert_eq!(of(&[]), Ok(DEFAULT));
        assert_eq!(of(&["1_000_000"]), Ok(1_000_000));
        for wrong in [&["0"][..], &["many"], &["1", "2"]] {
            assert!(of(wrong).is_err(), "{wrong:?}");
        }
    }
}
