//! `cargo xtask fuzz`: builds the targets of `fuzz/` with libFuzzer and runs them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use crate::run::{self, StepResult};
use crate::{TaskResult, setup};

/// The targets of crates/verify/src/fuzz.
const TARGETS: [&str; 7] = ["link", "records", "text", "device", "store", "update", "drawing"];
/// Longest time for an input.
const SLOWEST_MS: u32 = 10;
/// How many times an input that takes a millisecond or more is tried.
const TRIES: usize = 5;
const INPUTS_PER_RUN: usize = 1000;
/// Longest input of a target, bytes.
const INPUT_MAX: usize = 2048;

struct Options {
    targets: Vec<String>,
    minutes: f64,
    /// Reduce the committed corpus to the inputs that reach something new.
    merge: bool,
}

pub fn fuzz(arguments: &[String]) -> TaskResult {
    let options = options(arguments)?;
    setup::rust()?;
    tool()?;
    build()?;
    let mut rows = Vec::new();
    let mut problems = Vec::new();
    for target in &options.targets {
        match run_target(target, &options) {
            Ok(row) => rows.push(row),
            Err(error) => problems.push(error),
        }
    }
    println!("\n| target | executions | per second | edges | slowest input | finds |");
    println!("|---|--:|--:|--:|--:|--:|");
    rows.iter().for_each(|row| println!("{row}"));
    run::verdict("finds", &problems)?;
    Ok(ExitCode::SUCCESS)
}

fn options(arguments: &[String]) -> Result<Options, String> {
    let mut options = Options { targets: Vec::new(), minutes: 1.0, merge: false };
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        match argument.as_str() {
            "--merge" => options.merge = true,
            "--minutes" => {
                let number = rest.next().and_then(|text| text.parse().ok());
                options.minutes = number
                    .filter(|minutes: &f64| *minutes > 0.0 && minutes.is_finite())
                    .ok_or("--minutes: expected a number")?;
            }
            name if TARGETS.contains(&name) => options.targets.push(name.into()),
            other => {
                let known = TARGETS.join(", ");
                return Err(format!("unexpected `{other}`: targets are {known}"));
            }
        }
    }
    if options.targets.is_empty() {
        options.targets = TARGETS.map(String::from).to_vec();
    }
    Ok(options)
}

/// Installs cargo-fuzz if it is missing.
fn tool() -> StepResult {
    if run::output(&mut run::cargo(&["fuzz", "--version"])).is_ok() {
        return Ok(());
    }
    if run::output(Command::new("c++").arg("--version")).is_err() {
        setup::debian(&["g++"])?;
    }
    println!("   cargo-fuzz is missing: installing it");
    run::show(&mut run::cargo(&["install", "cargo-fuzz", "--locked"]))
}

/// Without sanitizer: there is no unsafe code to check, and so the stable compiler can be used.
fn build() -> StepResult {
    let mut build = run::cargo(&["fuzz", "build", "--fuzz-dir", "fuzz", "--sanitizer", "none"]);
    build.arg("--target-dir").arg(folder("target/fuzz")).env("RUSTC_BOOTSTRAP", "1");
    run::show(&mut build)
}

fn folder(path: &str) -> PathBuf {
    run::root().join(path)
}

fn run_target(target: &str, options: &Options) -> Result<String, String> {
    let archive = folder("fuzz/corpus").join(format!("{target}.tar.gz"));
    let committed = folder("target/fuzz/committed").join(target);
    let working = folder("target/fuzz/corpus").join(target);
    let artifacts = folder("fuzz/artifacts").join(target);
    _ = std::fs::remove_dir_all(&committed);
    for path in [&committed, &working, &artifacts] {
        std::fs::create_dir_all(path).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    run::show(Command::new("tar").arg("-xzf").arg(&archive).arg("-C").arg(&committed))?;
    let mut command = Command::new(program(target)?);
    command.current_dir(run::root());
    command.args([format!("-max_len={INPUT_MAX}"), "-timeout=5".into()]);
    command.arg(format!("-artifact_prefix={}/", artifacts.display()));
    if options.merge {
        let fresh = folder("target/fuzz/merged").join(target);
        _ = std::fs::remove_dir_all(&fresh);
        std::fs::create_dir_all(&fresh).map_err(|e| format!("{}: {e}", fresh.display()))?;
        command.arg("-set_cover_merge=1").arg(&fresh).args([&committed, &working]);
        run::show(&mut command)?;
        pack(&fresh, &archive)?;
        return Ok(format!("| {target} | merged | | | | |"));
    }
    let seconds = (options.minutes * 60.0).ceil();
    command
        .arg(format!("-max_total_time={seconds}"))
        .args(["-print_final_stats=1", "-verbosity=1"]);
    command.arg(&working).arg(&committed);
    println!("   {target}: {seconds} s");
    let output = command.output().map_err(|e| format!("{target}: {e}"))?;
    let text = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        let from = text.find("panicked").unwrap_or(0);
        let what: String = text[from..].lines().take(4).collect::<Vec<_>>().join("\n  ");
        return Err(format!("{target}: see {}\n  {what}", artifacts.display()));
    }
    let slowest_ms = slowest_ms(&program(target)?, &[&working, &committed])?;
    if slowest_ms > SLOWEST_MS {
        return Err(format!("{target}: an input took {slowest_ms} ms"));
    }
    Ok(row(target, &text, slowest_ms))
}

/// Packs the files of a folder; the archive is the same on every machine.
fn pack(folder: &Path, archive: &Path) -> StepResult {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut names: Vec<_> = entries.flatten().map(|entry| entry.file_name()).collect();
    names.sort();
    let mut tar = Command::new("tar");
    tar.args(["--mtime=@0", "--owner=0", "--group=0", "--numeric-owner", "--format=ustar"]);
    tar.args(["--mode=0644", "--use-compress-program=gzip -n9", "-cf"]).arg(archive);
    run::output(tar.arg("-C").arg(folder).args(names)).map(|_| ())
}

/// Time of the slowest of these inputs, each run alone. A busy machine slows any of them now and
/// then, so slow ones are repeated.
fn slowest_ms(program: &Path, folders: &[&PathBuf]) -> Result<u32, String> {
    let mut inputs = Vec::new();
    for folder in folders {
        let entries = std::fs::read_dir(folder).map_err(|e| e.to_string())?;
        inputs.extend(entries.flatten().map(|entry| entry.path()));
    }
    let mut least = BTreeMap::new();
    for _ in 0..TRIES {
        for (path, ms) in took_ms(program, &inputs)? {
            let least: &mut u32 = least.entry(path).or_insert(ms);
            *least = ms.min(*least);
        }
        let slow = least.iter().filter(|(_, ms)| **ms > 0);
        inputs = slow.map(|(path, _)| path.into()).collect();
    }
    Ok(least.into_values().max().unwrap_or(0))
}

fn took_ms(program: &Path, inputs: &[PathBuf]) -> Result<BTreeMap<String, u32>, String> {
    let mut took = BTreeMap::new();
    for some in inputs.chunks(INPUTS_PER_RUN) {
        let output = Command::new(program).args(some).output().map_err(|e| e.to_string())?;
        took.extend(String::from_utf8_lossy(&output.stderr).lines().filter_map(executed));
    }
    Ok(took)
}

/// Parses a line of libFuzzer: "Executed PATH in N ms".
fn executed(line: &str) -> Option<(String, u32)> {
    let (path, ms) = line.strip_prefix("Executed ")?.strip_suffix(" ms")?.rsplit_once(" in ")?;
    Some((path.into(), ms.parse().ok()?))
}

fn program(target: &str) -> Result<PathBuf, String> {
    Ok(folder("target/fuzz").join(run::host()?).join("release").join(target))
}

/// The final output of libFuzzer as a table row.
fn row(target: &str, text: &str, slowest_ms: u32) -> String {
    let stat = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name));
        line.map_or("?", str::trim)
    };
    let done = text.lines().rfind(|line| line.contains("cov: ")).unwrap_or_default();
    let edges = done.split("cov: ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap_or("?");
    let executions = stat("stat::number_of_executed_units:");
    let pace = stat("stat::average_exec_per_sec:");
    let slowest = if slowest_ms == 0 { "< 1 ms".into() } else { format!("{slowest_ms} ms") };
    format!("| {target} | {executions} | {pace} | {edges} | {slowest} | 0 |")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_a_run_is_read() {
        let text = "#9\tNEW    cov: 3 ft: 4\n#99\tDONE   cov: 344 ft: 1880 corp: 389/29Kb\n\
                    stat::number_of_executed_units: 299160\nstat::average_exec_per_sec:     6503\n";
        assert_eq!(row("link", text, 0), "| link | 299160 | 6503 | 344 | < 1 ms | 0 |");
        assert_eq!(executed("Executed corpus/in 7 in 12 ms"), Some(("corpus/in 7".into(), 12)));
        assert_eq!(executed("Running: corpus/in 7"), None);
    }

    #[test]
    fn arguments() {
        let read = |words: &[&str]| options(&words.iter().map(|w| (*w).into()).collect::<Vec<_>>());
        let some = read(&["store", "--minutes", "2.5"]).unwrap();
        assert_eq!((some.targets, some.minutes), (vec!["store".to_string()], 2.5));
        assert_eq!(read(&[]).unwrap().targets.len(), TARGETS.len());
        assert!(read(&["stroe"]).is_err() && read(&["--minutes", "x"]).is_err());
    }
}
