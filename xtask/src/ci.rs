//! `cargo xtask ci`: what a change must pass.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::run::{self, StepResult, Steps, cargo, output, read, root, show, target};
use crate::{
    TaskResult, api, bench, bindings, console, demo, dissector, dist, firmware, hub, licences,
    links, no_std, package, playground, plugs, python, setup, verify, website, words,
};

/// Start of the README's test command.
const TEST_COMMAND: &str = "cargo xtask test";
const READMES: [&str; 2] = ["README.md", "README.ru.md"];
/// The demo without a terminal, much faster than real time.
const SMOKE: [&str; 5] = ["--seed", "7", "--speed", "50", "--plain"];
/// Includes the build; the demo itself takes seconds.
const SMOKE_TIMEOUT: Duration = Duration::from_secs(900);

/// A step: when it runs, its name on the command line, its headline, its function.
type CiStep = (When, &'static str, &'static str, fn() -> StepResult);

/// When a step of the whole run has its turn.
#[derive(Clone, Copy, PartialEq, Eq)]
enum When {
    /// One after another, before all others.
    First,
    /// What mostly waits: one after another, after the first.
    Then,
    /// What mostly computes: one after another beside those that wait, with what they leave of the processor.
    Beside,
    /// One after another when all others have ended, as it measures time.
    Last,
}

/// More steps that failed beside others than this have a common cause.
const AGAIN_MAX: usize = 3;
/// The summary of the whole begins with it.
const SUMMARY: &str = "cargo xtask ci: summary";

/// The console comes first because it is built into the hub. The first two that run beside others have cargo's
/// lock of the tests' folder for seconds at most, so that the tests need not wait for it.
const STEPS: [CiStep; 27] = [
    (
        When::First,
        "console",
        "the console: types, style, templates, unit tests, build",
        console::check,
    ),
    (When::First, "lock", "lock file is up to date", lock_file),
    (When::First, "licences", "licences and sources of the dependencies", licences::check),
    (When::First, "words", "words that must not appear", words::check),
    (When::First, "fmt", "format", format),
    (When::First, "build", "all tests are built", run::build_tests),
    (When::Then, "test", "the README's test command", readme_tests),
    (When::Then, "python", "lafet for Python", python::check),
    (When::Then, "plugs", "other protocols, with clients of others", plugs::check),
    (When::Then, "api", "the API and its description", api::check),
    (When::Then, "browser", "the console in a browser", console::browser),
    (When::Then, "playground", "the protocol in a page", playground::check),
    (When::Then, "dist", "the package, installed in a bare Debian", dist::check),
    (When::Beside, "no-std", "no_std build for Cortex-M3", no_std::check),
    (
        When::Beside,
        "firmware",
        "the firmware: no panic to reach, chip and host the same",
        firmware::check,
    ),
    (When::Beside, "clippy", "lints", lints),
    (When::Beside, "doc", "reference documentation", reference),
    (When::Beside, "website", "the documentation as a site", website::check),
    (When::Beside, "package", "packages that can be published", package::all),
    (When::Beside, "model", "the interlock, model-checked", verify::model_check),
    (When::Beside, "dissector", "the Wireshark dissector in tshark", dissector::check),
    (When::Beside, "bindings", "lafet for C", bindings::check),
    (When::Beside, "bench", "instructions of the codec and the device", bench::check),
    (
        When::Last,
        "update",
        "a monitor in QEMU is updated while all goes wrong",
        firmware::update::quick,
    ),
    (When::Last, "swarm", "the swarm, for a while", verify::swarm_check),
    (When::Last, "hub", "the hub in trouble", hub::check),
    (When::Last, "demo", "the demo", smoke),
];

pub fn ci(arguments: &[String]) -> TaskResult {
    let names: Vec<&str> = STEPS.iter().map(|(_, name, ..)| *name).collect();
    if let Some(unknown) = arguments.iter().find(|it| !names.contains(&it.as_str())) {
        return Err(format!("no step `{unknown}`; the steps are: {}", names.join(", ")));
    }
    setup::rust()?;
    if !arguments.is_empty() {
        let mut steps = Steps::default();
        run_steps(&mut steps, |_, name| arguments.iter().any(|it| it == name));
        run_later(&mut steps);
        return Ok(steps.finish("cargo xtask ci"));
    }
    // The packages come while the first steps compile; a step by itself gets its own.
    let ahead = std::thread::spawn(setup::ahead);
    let mut steps = Steps::default();
    let at = |now: When| move |when: When, _: &str| when == now;
    run_steps(&mut steps, at(When::First));
    // The package manager allows one at a time, and another process would not wait for it.
    let _ = ahead.join();
    let beside = Beside::start()?;
    run_steps(&mut steps, at(When::Then));
    let mut failed = Vec::new();
    steps.step("what ran beside these", || {
        failed = beside.end()?;
        Ok(())
    });
    for (_, _, headline, run) in failed {
        steps.step(headline, || passes_alone(headline, run));
    }
    run_later(&mut steps);
    run_steps(&mut steps, at(When::Last));
    Ok(steps.finish("cargo xtask ci"))
}

fn run_steps(steps: &mut Steps, chosen: impl Fn(When, &str) -> bool) {
    for (when, name, headline, run) in STEPS {
        if chosen(when, name) {
            steps.step(headline, run);
        }
    }
}

/// Runs what steps have left until nothing else runs.
fn run_later(steps: &mut Steps) {
    for (headline, run) in run::take_later() {
        steps.step(headline, run);
    }
}

/// Runs a step again that failed beside others.
fn passes_alone(headline: &str, run: fn() -> StepResult) -> StepResult {
    run()?;
    run::unsteady(format!("{headline}: failed beside others, and passed alone"));
    Ok(())
}

/// The steps that run beside others, in a process of lower priority; what they print comes at their end.
struct Beside {
    process: Child,
    log: PathBuf,
}

impl Beside {
    fn start() -> Result<Self, String> {
        let beside = STEPS.iter().filter(|(when, ..)| *when == When::Beside);
        let names: Vec<&str> = beside.map(|(_, name, ..)| *name).collect();
        let log = target().join("ci-beside.log");
        let failed = |e: std::io::Error| format!("{}: {e}", log.display());
        let file = std::fs::File::create(&log).map_err(failed)?;
        let mut command = run::behind(&[&["ci"], &names[..]].concat())?;
        command.stdin(Stdio::null()).stderr(file.try_clone().map_err(failed)?).stdout(file);
        let process = command.spawn().map_err(|e| format!("cannot run nice: {e}"))?;
        run::limit::spare(process.id());
        println!("\nbeside the next steps run: {}", names.join(", "));
        Ok(Self { process, log })
    }

    /// Waits for its end; returns the steps that failed, if they are few.
    fn end(mut self) -> Result<Vec<CiStep>, String> {
        let ended = self.process.wait().map_err(|e| e.to_string())?;
        let printed =
            std::fs::read(&self.log).map_err(|e| format!("{}: {e}", self.log.display()))?;
        let printed = String::from_utf8_lossy(&printed);
        println!("{printed}");
        if ended.success() {
            return Ok(Vec::new());
        }
        let failed: Vec<CiStep> = failed_beside(&printed).collect();
        match failed.len() {
            1..=AGAIN_MAX => Ok(failed),
            _ => Err("steps above failed".to_owned()),
        }
    }
}

/// The steps that failed, by the summary of the process that ran beside others.
fn failed_beside(printed: &str) -> impl Iterator<Item = CiStep> {
    let (_, summary) = printed.rsplit_once(SUMMARY).unwrap_or_default();
    let beside = STEPS.into_iter().filter(|(when, ..)| *when == When::Beside);
    beside.filter(move |(_, _, headline, _)| {
        summary.lines().any(|line| line.starts_with("   FAILED") && line.ends_with(headline))
    })
}

fn lock_file() -> StepResult {
    output(&mut cargo(&["metadata", "--locked", "--format-version=1"]))
        .map(|_| ())
        .map_err(|e| format!("{e}\nCommit Cargo.lock as `cargo check` leaves it."))
}

fn format() -> StepResult {
    setup::component("rustfmt", "fmt")?;
    show(&mut cargo(&["fmt", "--all", "--check"]))?;
    firmware::format()
}

fn lints() -> StepResult {
    setup::component("clippy", "clippy")?;
    let lints = ["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"];
    show(&mut cargo(&lints))?;
    firmware::lints()
}

fn reference() -> StepResult {
    let mut doc = cargo(&["doc", "--workspace", "--no-deps"]);
    show(doc.env("RUSTDOCFLAGS", "-D warnings"))
}

/// Runs the test command as a reader would copy it.
fn readme_tests() -> StepResult {
    let mut commands = Vec::new();
    for path in READMES {
        let command = command_in(&read(path)?, TEST_COMMAND)
            .ok_or_else(|| format!("{path}: no block of code has the line `{TEST_COMMAND}`"))?;
        commands.push(command);
    }
    commands.dedup();
    let [command] = &commands[..] else {
        return Err(format!("the READMEs disagree: `{}`", commands.join("`, `")));
    };
    show(Command::new("sh").args(["-c", command]).current_dir(root()))
}

/// The line of a code block that starts like this, without prompt and comment.
fn command_in(text: &str, beginning: &str) -> Option<String> {
    let prose: Vec<usize> = links::prose(text).map(|(number, _)| number).collect();
    let blocks = text.lines().enumerate().filter(|(i, _)| prose.binary_search(&(i + 1)).is_err());
    let mut lines = blocks.map(|(_, line)| {
        let line = line.trim().trim_start_matches("$ ");
        line.split(" #").next().unwrap_or(line).trim()
    });
    lines.find(|line| line.starts_with(beginning)).map(String::from)
}

/// Checks that the demo ends by itself, with success.
fn smoke() -> StepResult {
    let arguments: Vec<String> = SMOKE.iter().map(|argument| (*argument).into()).collect();
    let printed = bounded(&mut demo::command(&arguments), SMOKE_TIMEOUT)?;
    print!("{printed}");
    if printed.trim().is_empty() { Err("the demo printed nothing".into()) } else { Ok(()) }
}

/// Runs a command for its output, and kills it when it takes too long.
fn bounded(command: &mut Command, timeout: Duration) -> Result<String, String> {
    let child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|e| format!("cannot run the demo: {e}"))?;
    let (output, killed) = run::limit::output(child, timeout);
    if killed {
        return Err(format!("the demo did not end within {} s", timeout.as_secs()));
    }
    let output = output.map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        Ok(text)
    } else {
        Err(format!("the demo failed: {}\n{text}", output.status))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_is_taken_from_a_block_of_code() {
        let text = "Run `cargo xtask test`:\ncargo xtask test --no\n\n```sh\n$ cargo xtask demo\n\
                    cargo xtask test   # all of it\n```\n";
        assert_eq!(command_in(text, TEST_COMMAND).as_deref(), Some("cargo xtask test"));
        assert_eq!(command_in("cargo xtask test\n", TEST_COMMAND), None);
    }

    /// What the steps print is no summary, and a step of the same name that is not beside is another one.
    #[test]
    fn what_failed_beside_is_in_the_summary() {
        let mut steps = Steps::default();
        let name = |(_, name, ..): CiStep| name;
        let summary = "   FAILED, 1.0 s: x\n   FAILED lints\n== cargo xtask ci: summary (time)\n   ok   1 s  \
                       lints\n   FAILED   1.0 s  1.0 s  lafet for C\n   FAILED   1.0 s  1.0 s  format\n";
        assert_eq!(failed_beside(summary).map(name).collect::<Vec<_>>(), ["bindings"]);
        assert_eq!(failed_beside("   FAILED   1.0 s  1.0 s  lints\n").count(), 0);
        run::later("again", Box::new(|| passes_alone("it", || Err("no".to_owned()))));
        run_later(&mut steps);
        assert_eq!(steps.finish("later"), std::process::ExitCode::FAILURE);
    }

    #[test]
    fn a_command_that_hangs_is_ended() {
        let mut hangs = Command::new("sh");
        hangs.args(["-c", "exec tail -f /dev/null"]);
        let error = bounded(&mut hangs, Duration::from_millis(50)).unwrap_err();
        assert!(error.contains("did not end"), "{error}");
        let mut fails = Command::new("sh");
        fails.args(["-c", "echo out; exit 3"]);
        let error = bounded(&mut fails, Duration::from_secs(60)).unwrap_err();
        assert!(error.contains("exit status: 3") && error.contains("out"), "{error}");
    }
}
