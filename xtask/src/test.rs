//! `cargo xtask test`: the README's test command.

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;
use std::process::{Command, ExitCode, Output, Stdio};
use std::time::Instant;

use crate::run::{self, StepResult, Steps, TestProgram, cargo, output, root, show_tests};
use crate::{TaskResult, docs, faults, flag, layers, physics, setup, spec};

/// Packages whose tests mostly wait for time that passes: those of a row one after another, the rows at the same time.
const WAIT: [&[&str]; 2] = [&["crates/cli"], &["crates/client", "crates/hub"]];
/// What of them measures time or memory, or takes the whole machine: each has it alone.
const ALONE: [&str; 5] = ["flood", "light", "memory", "poll_cost", "real"];
/// Tests at a time where they mostly wait, a processor.
const WAIT_AT_A_TIME: usize = 2;
/// A test that failed beside others is run so often by itself: it is unsteady if it passes each time.
const ALONE_AGAIN: usize = 3;
/// More failures than this have a common cause, and are none of single tests.
const UNSTEADY_MAX: usize = 6;
/// Task for cargo: runs a program that is none of the workspace's tests.
pub const RUN_EXAMPLE: &str = "run-example";

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
    steps.step("examples in the documentation", examples);
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
    let (waiting, computing): (Vec<_>, Vec<_>) = others.into_iter().partition(|it| waits(it));
    let all_of = |programs: Vec<&'_ TestProgram>| {
        let failures = programs.into_iter().filter_map(|it| Some((it.clone(), run_all(it).err()?)));
        failures.collect::<Vec<Failed>>()
    };
    let failed = std::thread::scope(|scope| {
        let rows = WAIT.map(|row| {
            let of_row = waiting.iter().filter(|it| row.contains(&folder(it))).copied().collect();
            scope.spawn(move || all_of(of_row))
        });
        let mut failed = all_of(computing);
        failed.extend(rows.into_iter().flat_map(|row| row.join().unwrap_or_default()));
        failed.extend(all_of(alone));
        failed
    });
    run::verdict("programs whose tests failed", &failed_alone(&failed, passes_alone))
}

/// A program and its tests that failed; none where it ended otherwise.
type Failed = (TestProgram, Vec<String>);

/// What failed for good.
fn failed_alone(failed: &[Failed], passes: impl Fn(&TestProgram, &str) -> bool) -> Vec<String> {
    let few = failed.iter().map(|(_, tests)| tests.len()).sum::<usize>() <= UNSTEADY_MAX;
    let mut left = Vec::new();
    for (program, tests) in failed {
        let name = format!("{} of {}", program.name, folder(program));
        if !few || !pass_alone(&name, tests, |test| passes(program, test)) {
            left.push(format!("{name}: {}", program.path.display()));
        }
    }
    left
}

/// Whether a few tests of a program that failed beside others pass by themselves, each time. Then they are reported as
/// unsteady: other work of the machine made them fail, which is to be looked into and is no fault of the change.
pub fn pass_alone(program: &str, tests: &[String], passes: impl Fn(&str) -> bool) -> bool {
    let few = !tests.is_empty() && tests.len() <= UNSTEADY_MAX;
    let pass = few && tests.iter().all(|test| (0..ALONE_AGAIN).all(|_| passes(test)));
    if pass {
        let tests = tests.join(", ");
        run::unsteady(format!(
            "{program}: {tests} failed beside others, and passed {ALONE_AGAIN} times alone"
        ));
    }
    pass
}

/// Folder of its package in the workspace.
fn folder(program: &TestProgram) -> &str {
    let path = program.package.split('#').next().unwrap_or_default();
    let root = root();
    let within = path.split_once(root.to_str().unwrap_or_default()).map_or(path, |(_, it)| it);
    within.trim_start_matches('/')
}

fn waits(program: &TestProgram) -> bool {
    WAIT.iter().any(|row| row.contains(&folder(program)))
}

/// As cargo starts it.
fn command(program: &TestProgram) -> Command {
    let package = root().join(folder(program));
    let mut command = Command::new("nice");
    let waits = waits(program);
    command.args(["-n", if waits { "0" } else { "10" }]).arg(&program.path);
    command.env("CARGO_MANIFEST_DIR", &package).current_dir(package).stdin(Stdio::null());
    command
}

/// Runs all its tests; the error is those that failed.
fn run_all(program: &TestProgram) -> Result<(), Vec<String>> {
    let mut command = command(program);
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    if waits(program) && !ALONE.contains(&program.name.as_str()) {
        command.arg("--test-threads").arg((WAIT_AT_A_TIME * processors).to_string());
    }
    match run_shown(program, &mut command) {
        Some(ran) if ran.status.success() => Ok(()),
        ran => Err(ran.map(|it| run::failed_in(&printed_by(&it))).unwrap_or_default()),
    }
}

/// Runs one of its tests.
fn passes_alone(program: &TestProgram, test: &str) -> bool {
    let ran = run_shown(program, command(program).args(["--exact", test]));
    ran.is_some_and(|it| {
        it.status.success() && printed_by(&it).contains("test result: ok. 1 passed")
    })
}

/// Runs tests, and shows what they printed when they have ended: others run at the same time.
fn run_shown(program: &TestProgram, command: &mut Command) -> Option<Output> {
    let start = Instant::now();
    let ran = command.output();
    let time = start.elapsed().as_secs_f32();
    let mut out = std::io::stdout().lock();
    // A closed stdout must not stop a check.
    let _ = writeln!(out, "\n   {} of {}, {time:.1} s", program.name, folder(program));
    match &ran {
        Ok(ran) => {
            let _ = out.write_all(&ran.stdout).and_then(|()| out.write_all(&ran.stderr));
            let _ = out.flush();
        }
        Err(error) => {
            let _ = writeln!(out, "   {}: {error}", program.path.display());
        }
    }
    ran.ok()
}

fn printed_by(ran: &Output) -> Cow<'_, str> {
    String::from_utf8_lossy(&ran.stdout)
}

/// Runs the examples. With `--doc` cargo would select other packages and build their dependencies again with other
/// features: it runs all tests, but through [`run_example`].
fn examples() -> StepResult {
    let own = std::env::current_exe().map_err(|e| e.to_string())?;
    let host = run::host()?.to_uppercase().replace('-', "_");
    let mut all = cargo(&["test", "--workspace", "--no-fail-fast", "--quiet"]);
    all.env(format!("CARGO_TARGET_{host}_RUNNER"), format!("{} {RUN_EXAMPLE}", own.display()));
    show_tests(&mut all)
}

/// Whether a program is one of the tests that are built in this folder.
fn is_test(program: &Path, built: &Path) -> bool {
    program.starts_with(built.join("deps")) || program.starts_with(built.join("examples"))
}

/// Runs a program, unless it is one of the workspace's tests.
pub fn run_example(arguments: &[String]) -> TaskResult {
    let (program, rest) = arguments.split_first().ok_or("no program is named")?;
    // The folder of this program is that of all of them; an example is compiled in a folder of its own.
    let own = std::env::current_exe().map_err(|e| e.to_string())?;
    if own.parent().is_some_and(|built| is_test(Path::new(program), built)) {
        return Ok(ExitCode::SUCCESS);
    }
    let status = Command::new(program).args(rest).status();
    let status = status.map_err(|error| format!("{program}: {error}"))?;
    Ok(if status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
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
        assert!(run_all(&program("xtask", "good", "true")).is_ok());
        assert!(run_all(&program("xtask", "bad", "false")).is_err());
        assert!(run_all(&program("crates/hub", "missing", "/nonexistent/it")).is_err());
        assert!(!passes_alone(&program("xtask", "good", "true"), "none"), "no test was run");
    }

    /// A test is unsteady if it passes by itself each time; with one that does not, or with many, its program failed.
    #[test]
    fn a_test_that_fails_alone_has_failed() {
        let left = |tests: &[&str], passes: &dyn Fn(&str) -> bool| {
            let tests = tests.iter().map(ToString::to_string).collect();
            failed_alone(&[(program("xtask", "it", "it"), tests)], |_, test| passes(test)).len()
        };
        assert_eq!(left(&["a", "b", "c"], &|_| true), 0);
        assert_eq!(left(&["a", "b"], &|test| test == "a"), 1);
        assert_eq!(left(&["a"; UNSTEADY_MAX + 1], &|_| true), 1, "too many");
        assert_eq!(left(&[], &|_| true), 1, "it ended without a list");
        let third = std::cell::Cell::new(0);
        let at_the_third = |_: &str| third.replace(third.get() + 1) < 2;
        assert_eq!(left(&["a"], &at_the_third), 1);
    }

    #[test]
    fn an_example_is_run_and_a_test_is_not() {
        let code = |program: &str| run_example(&[program.to_owned()]);
        let failing = |program: &str| code(program).is_ok_and(|it| it == ExitCode::FAILURE);
        assert!(failing("/bin/false") && !failing("/bin/true"));
        let built = Path::new("/w/target/debug");
        assert!(
            is_test(&built.join("deps/it-0"), built)
                && is_test(&built.join("examples/hal-0"), built)
        );
        assert!(!is_test(&std::env::temp_dir().join("rustdoctest1/rust_out"), built));
        assert!(code("/nonexistent/example").is_err());
    }
}
