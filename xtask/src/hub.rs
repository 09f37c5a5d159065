//! `cargo xtask hub-load`: the hub under load and failures, and its part of the benchmarks.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use crate::run::{self, StepResult, output, show, target};
use crate::{TaskResult, demo, setup};

const PACKAGE: &str = "lafet-hub";
const GENERATOR: &str = "hub_load";
/// A thousand connections need two thousand files, half of them the hub's.
const LIMITED: &str = "ulimit -n 8192 2>/dev/null || ulimit -n $(ulimit -H -n); exec \"$0\" \"$@\"";

pub fn load(arguments: &[String]) -> TaskResult {
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let size = match words[..] {
        [] => None,
        ["--quick"] => Some("--quick"),
        [size @ ("--long" | "--large")] => return floods(&[size]),
        ["--flood", kind] => return floods(&["--apart", kind]),
        _ => {
            return Err("usage: cargo xtask hub-load [--quick | --long | --large | --flood KIND]"
                .to_owned());
        }
    };
    loads(&demo::optimised()?, &optimised()?, size)?;
    Ok(ExitCode::SUCCESS)
}

fn floods(what: &[&str]) -> TaskResult {
    show(command("floods", &demo::optimised()?, &optimised()?)?.args(what))?;
    Ok(ExitCode::SUCCESS)
}

/// Runs it for three minutes, on the unoptimized program that the other steps of CI use, as a slower one has
/// less room; but with the allocator of the installed one, whose memory is what the bounds are about.
pub fn check() -> StepResult {
    // The profile of the tests, which have built it already; it optimises what is simulated.
    let generator = run::example(PACKAGE, GENERATOR)?;
    loads(&demo::program_for_memory()?, &generator, Some("--quick"))
}

fn loads(lafet: &Path, generator: &Path, size: Option<&str>) -> StepResult {
    show(command("robust", lafet, generator)?.args(size))?;
    show(command("floods", lafet, generator)?.args(size))
}

/// The figures for docs/performance.md.
pub fn bench() -> Result<String, String> {
    output(&mut command("bench", &demo::optimised()?, &optimised()?)?)
}

fn optimised() -> Result<PathBuf, String> {
    run::optimised_example(PACKAGE, GENERATOR)
}

/// The load generator with this program, in an emptied folder.
fn command(what: &str, lafet: &Path, generator: &Path) -> Result<Command, String> {
    setup::program("prlimit", "util-linux")?;
    let folder = target().join("hub-load");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    let mut command = Command::new("sh");
    command.args(["-c", LIMITED]).arg(generator);
    command.arg(what).arg(lafet).arg(folder);
    command.current_dir(run::root());
    Ok(command)
}
