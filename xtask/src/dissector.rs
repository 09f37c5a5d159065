//! `cargo xtask dissector`: tests the Wireshark dissector in a real tshark.

use std::process::{Command, ExitCode};

use crate::run::{StepResult, cargo, output, show_tests};
use crate::{TaskResult, flag, setup};

pub fn dissector(arguments: &[String]) -> TaskResult {
    flag(arguments, None)?;
    check().map(|()| ExitCode::SUCCESS)
}

/// Runs the tests that need tshark, which is installed if permitted.
pub fn check() -> StepResult {
    let there = |program| output(Command::new(program).arg("--version")).is_ok();
    if !there("tshark") || !there("text2pcap") {
        setup::debian(&["tshark"])?;
    }
    let test = ["test", "--package", "lafet-capture", "--test", "it", "--", "--ignored"];
    show_tests(cargo(&test).arg("dissector::"))
}
