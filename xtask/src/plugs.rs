//! `cargo xtask plugs`: the servers of other protocols with clients that are not ours.

use std::process::ExitCode;

use crate::run::{StepResult, cargo, show_tests};
use crate::{TaskResult, flag, setup};

/// What Python has of Modbus, on this side and that.
const PACKAGES: [&str; 2] = ["pymodbus==3.16.1", "pyserial==3.5"];

pub fn plugs(arguments: &[String]) -> TaskResult {
    flag(arguments, None)?;
    check().map(|()| ExitCode::SUCCESS)
}

/// Runs the tests that need programs of others, which are installed if permitted.
pub fn check() -> StepResult {
    let programs = setup::python("modbus-tools", &PACKAGES)?;
    setup::program("mbpoll", "mbpoll")?;
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::iter::once(programs).chain(std::env::split_paths(&path));
    let path = std::env::join_paths(folders).map_err(|e| e.to_string())?;
    // All packages, so that what is built for the other tests serves here.
    let test = ["test", "--workspace", "--test", "it", "--", "--ignored", "foreign::"];
    show_tests(cargo(&test).env("PATH", path))
}
