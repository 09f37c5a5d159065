//! Runs commands and steps, and sums up the results.

pub mod limit;

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::Value;

/// Result of a step; the error is the text for the user.
pub type StepResult = Result<(), String>;

/// Root of the workspace. Taken from cargo at run time: a copy of the workspace may run a program
/// built in another one.
pub fn root() -> PathBuf {
    let now = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let mut manifest = now.unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    manifest.pop();
    manifest
}

/// Folder of the build output.
pub fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

/// A command for the cargo that started us, run in the workspace root.
pub fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root()).args(arguments);
    command
}

/// The kind of machine that this is, as rustc names it.
pub fn host() -> Result<String, String> {
    let version = output(Command::new("rustc").arg("-vV").current_dir(root()))?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "rustc -vV names no host".to_owned())
}

/// A command for git, run in the workspace root.
pub fn git() -> Command {
    let mut command = Command::new("git");
    command.current_dir(root());
    command
}

/// Set once the tests of the workspace are built, here or by the process that started us: with them all
/// programs and examples are, and cargo with other packages selected would build their dependencies again,
/// with fewer features.
static BUILT: AtomicBool = AtomicBool::new(false);
const BUILT_BEFORE: &str = "LAFET_XTASK_BUILT";

/// Builds the tests of all crates, and so every program in the profile of the tests.
pub fn build_tests() -> StepResult {
    show(&mut cargo(&["test", "--workspace", "--no-run"]))?;
    BUILT.store(true, Ordering::Relaxed);
    Ok(())
}

/// Whether the tests of the workspace are built.
pub fn is_built() -> bool {
    BUILT.load(Ordering::Relaxed) || std::env::var_os(BUILT_BEFORE).is_some()
}

/// The program of a package in the profile of the tests.
pub fn tested(package: &str) -> Command {
    if is_built() {
        let mut program = Command::new(target().join("debug").join(package));
        program.current_dir(root());
        return program;
    }
    cargo(&["run", "--quiet", "--package", package, "--"])
}

/// Builds the program of a package in the profile of the tests; returns its path.
pub fn program(package: &str) -> Result<PathBuf, String> {
    if !is_built() {
        show(&mut cargo(&["build", "--quiet", "--package", package]))?;
    }
    Ok(target().join("debug").join(package))
}

/// Builds an example in the profile of the tests; returns its path.
pub fn example(package: &str, name: &str) -> Result<PathBuf, String> {
    if !is_built() {
        show(&mut cargo(&["build", "--quiet", "--package", package, "--example", name]))?;
    }
    Ok(target().join("debug/examples").join(name))
}

/// The same as it would be shipped: a load that is not to slow itself down.
pub fn optimised_example(package: &str, name: &str) -> Result<PathBuf, String> {
    let build = ["build", "--quiet", "--release", "--package", package, "--example", name];
    show(&mut cargo(&build))?;
    Ok(target().join("release/examples").join(name))
}

/// This program with other arguments, behind everything else that wants a processor.
pub fn behind(arguments: &[&str]) -> Result<Command, String> {
    let program = std::env::current_exe().map_err(|e| format!("this program: {e}"))?;
    let mut command = Command::new("nice");
    command.args(["-n", "19"]).arg(program).args(arguments).current_dir(root());
    if is_built() {
        command.env(BUILT_BEFORE, "1");
    }
    Ok(command)
}

/// Runs a command whose output the user sees.
pub fn show(command: &mut Command) -> StepResult {
    let text = line(command);
    println!("   {text}");
    flush();
    let status = command.status().map_err(|e| format!("cannot run `{text}`: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("`{text}` failed: {status}")) }
}

/// Runs tests whose output the user sees; an error if none of them was chosen.
pub fn show_tests(command: &mut Command) -> StepResult {
    shown_tests(command).map_err(|(error, _)| error)
}

/// The same; the error has the names of the tests that failed, too.
pub fn shown_tests(command: &mut Command) -> Result<(), (String, Vec<String>)> {
    let text = line(command);
    println!("   {text}");
    flush();
    let failed = |e: std::io::Error| (format!("cannot run `{text}`: {e}"), Vec::new());
    let mut child = command.stdout(Stdio::piped()).spawn().map_err(failed)?;
    let (mut passed, mut all) = (0, String::new());
    if let Some(printed) = child.stdout.take() {
        for line in BufReader::new(printed).lines().map_while(Result::ok) {
            println!("{line}");
            passed += passed_in(&line);
            all += &format!("{line}\n");
        }
    }
    let status = child.wait().map_err(failed)?;
    match (status.success(), passed) {
        (false, _) => Err((format!("`{text}` failed: {status}"), failed_in(&all))),
        (true, 0) => Err((format!("`{text}` ran no test: they have other names now"), Vec::new())),
        _ => Ok(()),
    }
}

/// The tests that failed, from the list at the end of what a test program prints.
pub fn failed_in(printed: &str) -> Vec<String> {
    let Some((_, list)) = printed.rsplit_once("\nfailures:\n") else { return Vec::new() };
    list.lines().map_while(|line| line.strip_prefix("    ")).map(str::to_owned).collect()
}

/// A test program, as cargo names it in its messages.
#[derive(Clone, Debug, PartialEq)]
pub struct TestProgram {
    /// The package, with its folder.
    pub package: String,
    /// The name of the target.
    pub name: String,
    /// The program.
    pub path: PathBuf,
}

/// The test programs in what cargo prints with `--message-format=json`.
pub fn test_programs(messages: &str) -> impl Iterator<Item = TestProgram> {
    messages.lines().filter_map(|line| {
        let json: Value = serde_json::from_str(line).ok()?;
        let package = json["package_id"].as_str()?.to_owned();
        let name = json["target"]["name"].as_str()?.to_owned();
        let path = json["executable"].as_str()?.into();
        json["profile"]["test"].as_bool()?.then_some(TestProgram { package, name, path })
    })
}

/// How many tests a line of the summary counts.
fn passed_in(line: &str) -> u64 {
    let counts = line.strip_prefix("test result: ok. ");
    let first = counts.and_then(|counts| counts.split(' ').next());
    first.and_then(|count| count.parse().ok()).unwrap_or(0)
}

/// Runs a command and returns its output.
pub fn output(command: &mut Command) -> Result<String, String> {
    let text = line(command);
    let output = command.output().map_err(|e| format!("cannot run `{text}`: {e}"))?;
    if !output.status.success() {
        let stderr = String::from_utf8_lossy(&output.stderr);
        return Err(format!("`{text}` failed: {}\n{}", output.status, stderr.trim_end()));
    }
    String::from_utf8(output.stdout).map_err(|e| format!("`{text}` did not print UTF-8: {e}"))
}

/// Asks a process to end, so that it closes its files and ends what it has started, and waits for it.
pub fn end(process: &mut Child) {
    // It may have ended already.
    let _ = output(Command::new("kill").args(["-TERM", &process.id().to_string()]));
    let _ = process.wait();
}

/// Reads a file of the workspace.
pub fn read(path: &str) -> Result<String, String> {
    std::fs::read_to_string(root().join(path)).map_err(|e| format!("cannot read {path}: {e}"))
}

/// A page of the project with this text between `<!-- NAME:begin -->` and `<!-- NAME:end -->`.
pub fn put(path: &str, page: &str, name: &str, text: &str) -> Result<String, String> {
    let (begin, end) = (format!("<!-- {name}:begin -->"), format!("<!-- {name}:end -->"));
    let missing = |mark: &str| format!("{path}: `{mark}` is missing");
    let (head, rest) = page.split_once(&format!("{begin}\n")).ok_or_else(|| missing(&begin))?;
    let (_, tail) = rest.split_once(&end).ok_or_else(|| missing(&end))?;
    Ok(format!("{head}{begin}\n{text}{end}{tail}"))
}

/// Joins problems into one error; none is success.
pub fn verdict(headline: &str, problems: &[String]) -> StepResult {
    if problems.is_empty() {
        return Ok(());
    }
    Err(format!("{headline} ({}):\n  {}", problems.len(), problems.join("\n  ")))
}

/// What passed only when nothing else ran: shown beside the summary.
static UNSTEADY: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Reports something that passed only when nothing else ran.
pub fn unsteady(what: String) {
    println!("   UNSTEADY: {what}");
    flush();
    UNSTEADY.lock().unwrap_or_else(PoisonError::into_inner).push(what);
}

/// Something that is run when nothing else runs, and its headline.
pub type Later = (&'static str, Box<dyn FnOnce() -> StepResult + Send>);

static LATER: Mutex<Vec<Later>> = Mutex::new(Vec::new());

/// Has something run when nothing else runs.
pub fn later(headline: &'static str, run: Box<dyn FnOnce() -> StepResult + Send>) {
    LATER.lock().unwrap_or_else(PoisonError::into_inner).push((headline, run));
}

/// What is to be run now that nothing else runs.
pub fn take_later() -> Vec<Later> {
    std::mem::take(&mut LATER.lock().unwrap_or_else(PoisonError::into_inner))
}

fn line(command: &Command) -> String {
    let program = Path::new(command.get_program());
    let name = program.file_name().unwrap_or(program.as_os_str()).to_string_lossy();
    let mut text = name.into_owned();
    for argument in command.get_args() {
        text.push(' ');
        text += &argument.to_string_lossy();
    }
    text
}

fn too_long() -> String {
    format!("took more than {} min", STEP_LIMIT.as_secs() / 60)
}

fn flush() {
    // A closed stdout must not stop a check.
    let _ = std::io::stdout().flush();
}

/// Longest time of a step: more than twice what the longest takes beside others on two cores.
const STEP_LIMIT: Duration = Duration::from_secs(45 * 60);

/// Steps that run one after another, whether or not the others fail.
#[derive(Default)]
pub struct Steps {
    done: Vec<Step>,
}

struct Step {
    name: &'static str,
    time: Duration,
    /// Processor time of its commands, s.
    processor: f32,
    result: StepResult,
}

/// Processor time of all commands that have ended, s; 0 where the system does not say.
fn processor_s() -> f32 {
    const TICKS_A_SECOND: f32 = 100.0;
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // User and system time of the children are the 14th and 15th field after the name in brackets.
    let fields = stat.rsplit_once(')').map_or("", |(_, fields)| fields).split_whitespace();
    let ticks: f32 = fields.skip(13).take(2).filter_map(|field| field.parse::<f32>().ok()).sum();
    ticks / TICKS_A_SECOND
}

impl Steps {
    /// Runs a step with its headline.
    pub fn step(&mut self, name: &'static str, run: impl FnOnce() -> StepResult) {
        println!("\n== {name}");
        flush();
        let (start, before) = (Instant::now(), processor_s());
        let (result, killed) = limit::within(STEP_LIMIT, run);
        let result = match (result, killed) {
            (result, false) => result,
            (Ok(()), true) => Err(too_long()),
            (Err(message), true) => Err(format!("{}: {message}", too_long())),
        };
        let (time, processor) = (start.elapsed(), processor_s() - before);
        match &result {
            Ok(()) => println!("   ok, {:.1} s", time.as_secs_f32()),
            Err(message) => println!("   FAILED, {:.1} s: {message}", time.as_secs_f32()),
        }
        flush();
        self.done.push(Step { name, time, processor, result });
    }

    /// Prints the table and the closing line.
    pub fn finish(self, title: &str) -> ExitCode {
        let failed = self.done.iter().filter(|step| step.result.is_err()).count();
        println!("\n== {title}: summary (time that passed, processor time)");
        for Step { name, time, processor, result } in &self.done {
            let word = if result.is_ok() { "ok" } else { "FAILED" };
            println!("   {word:<6} {:>7.1} s {processor:>7.1} s  {name}", time.as_secs_f32());
        }
        for what in UNSTEADY.lock().unwrap_or_else(PoisonError::into_inner).iter() {
            println!("   UNSTEADY {what}");
        }
        println!("{} passed, {failed} failed", self.done.len() - failed);
        if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processor_time_is_that_of_the_commands() {
        let before = processor_s();
        let mut busy = Command::new("sh");
        busy.args(["-c", "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done"]);
        assert_eq!(show(&mut busy), Ok(()));
        assert!(processor_s() > before);
    }

    #[test]
    fn failed_tests_are_read_from_the_list_at_the_end() {
        let printed = "test a::b ... FAILED\n\nfailures:\n\n---- a::b stdout ----\nfailures:\n    it said\n\n\
            failures:\n    a::b\n    c\n\ntest result: FAILED. 3 passed; 2 failed\n";
        assert_eq!(failed_in(printed), ["a::b", "c"]);
        assert_eq!(failed_in("killed"), Vec::<String>::new());
        let mut failing = Command::new("sh");
        let (_, names) =
            shown_tests(failing.args(["-c", "printf '%s' \"$0\"; exit 101", printed])).unwrap_err();
        assert_eq!(names, ["a::b", "c"]);
    }

    #[test]
    fn a_command_that_runs_no_test_is_an_error() {
        let printing = |text: &str| {
            let mut command = Command::new("printf");
            command.arg(text);
            show_tests(&mut command)
        };
        let summary = "running 2 tests\n..\ntest result: ok. 2 passed; 0 failed; 0 ignored\n";
        assert_eq!(printing(summary), Ok(()));
        let none = printing("running 0 tests\n\ntest result: ok. 0 passed; 0 failed; 7 ignored\n");
        assert!(none.unwrap_err().contains("ran no test"));
        assert!(show_tests(&mut Command::new("false")).unwrap_err().contains("failed"));
    }
}
