//! `cargo xtask late`: the client against late, lost and duplicate answers, for any number of
//! exchanges; within one session, or with a session for each operation.

use std::process::ExitCode;

use crate::TaskResult;
use crate::run;

/// Number of exchanges by default.
const DEFAULT: u32 = 10_000_000;
const TEST: &str = "session::tests::late::no_late_answer_is_believed_in_a_long_run";

/// Number of processes for each medium by default.
const PROCESSES: u32 = 300_000;

pub fn late(arguments: &[String]) -> TaskResult {
    if let Some((word, rest)) = arguments.split_first()
        && word == "--processes"
    {
        return processes(rest);
    }
    let exchanges = exchanges(arguments, DEFAULT)?;
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
    run::show_tests(command.env("LAFET_EXCHANGES", exchanges.to_string()))?;
    Ok(ExitCode::SUCCESS)
}

fn processes(arguments: &[String]) -> TaskResult {
    let processes = exchanges(arguments, PROCESSES)?;
    let mut command = run::cargo(&[
        "test",
        "--release",
        "-p",
        "lafet-client",
        "--test",
        "it",
        "--",
        "processes::",
        "--nocapture",
        "--test-threads=1",
    ]);
    run::show_tests(command.env("LAFET_PROCESSES", processes.to_string()))?;
    Ok(ExitCode::SUCCESS)
}

fn exchanges(arguments: &[String], default: u32) -> Result<u32, String> {
    match arguments {
        [] => Ok(default),
        [count] => match count.replace('_', "").parse() {
            Ok(count @ 1..) => Ok(count),
            _ => Err(format!("`{count}` is not a number of exchanges, like {default}")),
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
            let words: Vec<_> = words.iter().map(|word| (*word).to_owned()).collect();
            exchanges(&words, DEFAULT)
        };
        assert_eq!(of(&[]), Ok(DEFAULT));
        assert_eq!(of(&["1_000_000"]), Ok(1_000_000));
        for wrong in [&["0"][..], &["many"], &["1", "2"]] {
            assert!(of(wrong).is_err(), "{wrong:?}");
        }
    }
}
