//! `cargo xtask dissector`: tests the Wireshark dissector in a real tshark.

use std::process::{Command, ExitCode};

use crate::run::{StepResult, output, root, show_tests};
use crate::{TaskResult, flag, plugs, setup};

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
    let folder = "crates/capture";
    let mut tests = Command::new(plugs::tests_of(&plugs::all_tests()?, folder)?);
    show_tests(tests.args(["--ignored", "dissector::"]).current_dir(root().join(folder)))
}
