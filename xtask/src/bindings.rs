//! `cargo xtask bindings`: builds lafet for C, for the host and the Cortex-M3, and tests it.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use serde_json::Value;

use crate::run::{self, StepResult, output, root, show};
use crate::{TaskResult, flag, no_std, setup};

const HEADER: &str = "bindings/c/include/lafet.h";
const CBINDGEN_VERSION: &str = "0.29.4";
const WARNINGS: [&str; 5] = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-O1"];
const CROSS: &str = "arm-none-eabi-gcc";
const VALGRIND: [&str; 3] = ["--quiet", "--error-exitcode=9", "--leak-check=full"];

pub fn bindings(arguments: &[String]) -> TaskResult {
    if flag(arguments, Some("--header"))? {
        std::fs::write(root().join(HEADER), header()?).map_err(|e| format!("{HEADER}: {e}"))?;
        println!("   {HEADER}: written");
    } else {
        check()?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Builds and tests everything.
pub fn check() -> StepResult {
    if run::read(HEADER)? != header()? {
        return Err(format!("{HEADER} is out of date: cargo xtask bindings --header"));
    }
    setup::program("cc", "gcc")?;
    setup::program("valgrind", "valgrind")?;
    let target = no_std::target().join("bindings");
    let mut build = run::cargo(&["build", "--release", "--locked"]);
    show(build.current_dir(folder()).env("CARGO_TARGET_DIR", &target))?;
    let library = target.join("release/liblafet.a");
    let programs = ["vectors", "interface", "monitor", "controller"].map(|name| target.join(name));
    let [vectors, interface, monitor, controller] = &programs;
    let posix = "examples/platform_posix.c";
    compile(&["tests/vectors.c"], &library, vectors)?;
    compile(&["tests/interface.c"], &library, interface)?;
    compile(&["examples/monitor.c", posix], &library, monitor)?;
    compile(&["examples/controller.c", posix], &library, controller)?;
    hold_vectors(vectors)?;
    show(Command::new("valgrind").args(VALGRIND).arg(interface))?;
    talk(monitor, controller)?;
    cross(&target)
}

fn folder() -> PathBuf {
    root().join("bindings/c")
}

/// The header as cbindgen generates it.
fn header() -> Result<String, String> {
    let tool = setup::tool("cbindgen", CBINDGEN_VERSION, true)?;
    output(Command::new(&tool).arg(folder()).arg("--config").arg(folder().join("cbindgen.toml")))
}

fn compile(sources: &[&str], library: &Path, program: &Path) -> StepResult {
    let mut cc = Command::new("cc");
    cc.current_dir(folder()).args(WARNINGS).args(["-g", "-Iinclude", "-Iexamples"]);
    cc.args(sources).arg(library).args(["-lpthread", "-ldl", "-lm", "-o"]).arg(program);
    show(&mut cc)
}

/// Runs the golden vectors through the C interface, under valgrind.
fn hold_vectors(program: &Path) -> StepResult {
    let mut command = Command::new("valgrind");
    command.args(VALGRIND).arg(program).stdin(Stdio::piped());
    let mut child = command.spawn().map_err(|e| format!("valgrind: {e}"))?;
    let mut input = child.stdin.take().ok_or("no standard input")?;
    let written = input.write_all(lines()?.as_bytes());
    drop(input);
    let status = child.wait().map_err(|e| e.to_string())?;
    written.map_err(|e| format!("vectors: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("vectors from C: {status}")) }
}

/// The vectors in the form that the C program reads.
fn lines() -> Result<String, String> {
    let mut lines = String::new();
    let digits = |value: &Value| value.as_str().unwrap_or_default().replace(' ', "");
    let mut each = |file: &str, list: &str, line: &dyn Fn(&Value) -> String| {
        let text = run::read(&format!("conformance/vectors/{file}.json"))?;
        let all: Value = serde_json::from_str(&text).map_err(|e| format!("{file}: {e}"))?;
        let entries = all[list].as_array().ok_or_else(|| format!("{file}: no `{list}`"))?;
        entries.iter().for_each(|entry| lines += &line(entry));
        Ok::<_, String>(())
    };
    each("link", "frames", &|frame| {
        // The C interface does not support the longer checksum.
        match frame.get("check") {
            None => format!("frame {} {}\n", digits(&frame["body"]), digits(&frame["wire"])),
            Some(_) => String::new(),
        }
    })?;
    let record = |entry: &Value| format!("record {}\n", digits(&entry["bytes"]));
    each("requests", "requests", &record)?;
    each("answers", "answers", &record)?;
    Ok(lines)
}

/// Runs the two examples at the two ends of a line, the monitor under valgrind.
fn talk(monitor: &Path, controller: &Path) -> StepResult {
    let mut command = Command::new("valgrind");
    command.args(VALGRIND).arg(monitor).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut monitor = command.spawn().map_err(|e| format!("monitor: {e}"))?;
    let ends = (monitor.stdout.take(), monitor.stdin.take());
    let (Some(from), Some(to)) = ends else { return Err("the monitor has no line".into()) };
    let asked = Command::new(controller).stdin(from).stdout(to).status();
    // The monitor ends by itself when its line closes, and valgrind then reports its findings.
    let ended = monitor.wait().map_err(|e| e.to_string())?;
    let asked = asked.map_err(|e| format!("controller: {e}"))?;
    if asked.success() && ended.success() {
        return Ok(());
    }
    Err(format!("controller.c: {asked}; monitor.c: {ended}"))
}

/// Builds the library, and the examples against it, for a Cortex-M3.
fn cross(target: &Path) -> StepResult {
    if output(Command::new(CROSS).arg("--version")).is_err() {
        setup::debian(&["gcc-arm-none-eabi", "libnewlib-arm-none-eabi"])?;
    }
    let mut build = no_std::build(Some(target))?;
    show(build.current_dir(folder()).args(["--release", "--locked"]))?;
    let library = target.join(no_std::TARGET).join("release/liblafet.a");
    for example in ["monitor", "controller"] {
        let program = target.join(format!("{example}.elf"));
        let mut cc = Command::new(CROSS);
        cc.current_dir(folder()).args(WARNINGS).args(["-mcpu=cortex-m3", "-mthumb", "-Os"]);
        cc.args(["--specs=nosys.specs", "--specs=nano.specs", "-Wl,--gc-sections"]);
        cc.args(["-Wl,--no-warn-rwx-segments", "-Iinclude", "-Iexamples"]);
        cc.arg(format!("examples/{example}.c")).arg("examples/platform_lm3s6965.c");
        show(cc.arg(&library).arg("-o").arg(&program))?;
    }
    Ok(())
}
