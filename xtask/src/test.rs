//! `cargo xtask test`: the README's test command.

use std::io::Write;
use std::process::{Command, Stdio};

use crate::run::{self, StepResult, Steps, TestProgram, cargo, output, root, show};
use crate::{TaskResult, docs, faults, flag, layers, physics, setup, spec};

/// Packages whose tests mostly wait for time that passes.
const WAIT: [&str; 3] = ["crates/cli", "crates/client", "crates/hub"];
/// What of them measures time or memory, or takes the whole machine: each has it alone.
const ALONE: [&str; 4] = ["flood", "light", "memory", "poll_cost"];
/// Tests at a time where they mostly wait, a processor.
const WAIT_AT_A_TIME: usize = 2;

pub fn test(arguments: &[String]) -> TaskResult {
    flag(arguments, None)?;
    setup::rust()?;
    setup::program("python3", "python3")?;
    setup::program("curl", "curl")?;
    setup::program("openssl", "openssl")?;
    setup::postgres()?;
    let mut steps = Steps::default();
    steps.step("build of all tests", run::build_tests);
    steps.step("tests of all crates", tests);
    steps.step("examples in the documentation", || {
        show(&mut cargo(&["test", "--workspace", "--doc", "--no-fail-fast"]))
    });
    steps.step("the protocol: every section has code and tests", spec::check);
    steps.step("faults: every flag and status is reached", faults::check);
    steps.step("physics: the tables of docs/physics.md", physics::check);
    steps.step("layers and laws", layers::check);
    steps.step("documentation: generated tables and links", docs::check);
    Ok(steps.finish("cargo xtask test"))
}

/// Runs every test program, as `cargo test --workspace` does, but those that compute beside those that wait.
fn tests() -> StepResult {
    let build = ["test", "--workspace", "--no-run", "--message-format=json"];
    let programs: Vec<TestProgram> = run::test_programs(&output(&mut cargo(&build))?).collect();
    let is_alone = |it: &&TestProgram| ALONE.contains(&it.name.as_str());
    let (alone, others): (Vec<_>, Vec<_>) = programs.iter().partition(is_alone);
    let (waiting, computing): (Vec<_>, Vec<_>) =
        others.into_iter().partition(|it| WAIT.contains(&folder(it)));
    let failed = std::thread::scope(|scope| {
        let beside = scope.spawn(|| computing.iter().filter(|it| !quietly(it)).collect::<Vec<_>>());
        let mut failed: Vec<_> = waiting.iter().filter(|it| !openly(it)).collect();
        failed.extend(beside.join().unwrap_or_default());
        failed.extend(alone.iter().filter(|it| !openly(it)));
        failed
    });
    let name = |it: &&&TestProgram| format!("{} of {}: {}", it.name, folder(it), it.path.display());
    run::verdict("programs whose tests failed", &failed.iter().map(name).collect::<Vec<_>>())
}

/// Folder of its package in the workspace.
fn folder(program: &TestProgram) -> &str {
    let path = program.package.split('#').next().unwrap_or_default();
    let root = root();
    let within = path.split_once(root.to_str().unwrap_or_default()).map_or(path, |(_, it)| it);
    within.trim_start_matches('/')
}

/// As cargo starts it.
fn command(program: &TestProgram) -> Command {
    let package = root().join(folder(program));
    let mut command = Command::new("nice");
    let waits = WAIT.contains(&folder(program));
    command.args(["-n", if waits { "0" } else { "10" }]).arg(&program.path);
    command.env("CARGO_MANIFEST_DIR", &package).current_dir(package).stdin(Stdio::null());
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    if waits && !ALONE.contains(&program.name.as_str()) {
        command.arg("--test-threads").arg((WAIT_AT_A_TIME * processors).to_string());
    }
    command
}

/// Runs it, and shows what it prints as it comes.
fn openly(program: &TestProgram) -> bool {
    println!("\n   {} of {}", program.name, folder(program));
    show(&mut command(program)).inspect_err(|error| println!("   {error}")).is_ok()
}

/// Runs it, and shows what it printed when it has ended.
fn quietly(program: &TestProgram) -> bool {
    let ran = command(program).stderr(Stdio::piped()).output();
    let mut out = std::io::stdout().lock();
    // A closed stdout must not stop a check.
    let _ = writeln!(out, "\n   {} of {}", program.name, folder(program));
    match ran {
        Ok(ran) => {
            let _ = out.write_all(&ran.stdout).and_then(|()| out.write_all(&ran.stderr));
            ran.status.success()
        }
        Err(error) => {
            let _ = writeln!(out, "   {}: {error}", program.path.display());
            false
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program(package: &str, name: &str, path: &str) -> TestProgram {
        let package = format!("path+file://{}/{package}#0.1.0", root().display());
        TestProgram { package, name: name.to_owned(), path: path.into() }
    }

    #[test]
    fn a_package_has_its_folder() {
        assert_eq!(folder(&program("crates/hub", "it", "")), "crates/hub");
        assert_eq!(folder(&program("xtask", "xtask", "")), "xtask");
    }

    #[test]
    fn a_program_that_fails_or_is_missing_is_noticed() {
        assert!(quietly(&program("xtask", "good", "true")));
        assert!(!quietly(&program("xtask", "bad", "false")));
        assert!(!openly(&program("crates/hub", "missing", "/nonexistent/it")));
    }
}
