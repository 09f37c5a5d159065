//! `cargo xtask years`: years in a monitor's life, checked continuously.

use std::process::ExitCode;

use crate::TaskResult;
use crate::run;

pub fn years(arguments: &[String]) -> TaskResult {
    if arguments.len() > 2 || arguments.iter().any(|text| text.parse::<u32>().is_err()) {
        return Err("expected at most two whole numbers: how many years, and the seed".into());
    }
    let mut command = run::cargo(&["run", "--quiet", "--release", "--package", "lafet-sim"]);
    command.args(["--example", "years", "--"]).args(arguments);
    run::show(&mut command).map(|()| ExitCode::SUCCESS)
}
