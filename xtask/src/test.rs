//! `cargo xtask test`: the README's test command.

use crate::run::{self, Steps, cargo, show};
use crate::{TaskResult, docs, faults, flag, layers, physics, setup, spec};

pub fn test(arguments: &[String]) -> TaskResult {
    flag(arguments, None)?;
    setup::rust()?;
    setup::program("python3", "python3")?;
    setup::program("curl", "curl")?;
    setup::program("openssl", "openssl")?;
    setup::postgres()?;
    let mut steps = Steps::default();
    steps.step("build of all tests", run::build_tests);
    steps.step("tests of all crates", || {
        show(&mut cargo(&["test", "--workspace", "--no-fail-fast"]))
    });
    steps.step("the protocol: every section has code and tests", spec::check);
    steps.step("faults: every flag and status is reached", faults::check);
    steps.step("physics: the tables of docs/physics.md", physics::check);
    steps.step("layers and laws", layers::check);
    steps.step("documentation: generated tables and links", docs::check);
    Ok(steps.finish("cargo xtask test"))
}
