//! `cargo xtask bench`: measures lafet and its peers side by side, for docs/performance.md.

use std::process::{Command, ExitCode};

use crate::elf::Elf;
use crate::run::{self, StepResult};
use crate::{TaskResult, demo, hub, no_std, setup};

const PAGE: &str = "docs/performance.md";
/// Instruction counts of our own code.
const COUNTS: &str = "bench/instructions.txt";

const QEMU: &str = "qemu-system-arm";

/// A part of the benchmarks: a program of bench/ that prints sections.
struct Part {
    name: &'static str,
    needs: fn() -> StepResult,
    print: fn() -> Result<String, String>,
}

const PARTS: &[Part] = &[
    Part { name: "codec", needs: valgrind, print: codec },
    Part { name: "roundtrip", needs: modbus, print: roundtrip },
    Part { name: "bus", needs: nothing, print: bus },
    Part { name: "sim", needs: nothing, print: sim },
    Part { name: "capture", needs: mavlink, print: capture },
    Part { name: "hub", needs: nothing, print: hub::bench },
    Part { name: "footprint", needs: emulator, print: footprint },
];

pub fn bench(arguments: &[String]) -> TaskResult {
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["--check"] => check()?,
        [] => PARTS.iter().try_for_each(measure)?,
        ["--only", name] => {
            let part = PARTS.iter().find(|part| part.name == name);
            measure(part.ok_or_else(|| format!("no part `{name}`: {}", names()))?)?;
        }
        _ => return Err(format!("bench [--check | --only {}]", names())),
    }
    Ok(ExitCode::SUCCESS)
}

/// Fails when the programs of bench/ measure wrongly, or instruction counts have drifted from those in
/// [`COUNTS`].
pub fn check() -> StepResult {
    valgrind()?;
    tests()?;
    let counts = run::root().join(COUNTS);
    let mut command = program("lafet-bench-codec", &["--no-default-features"])?;
    let printed = run::output(command.arg("check").arg(counts))?;
    println!("   {}", printed.trim());
    Ok(())
}

/// The tests of bench/, which is no part of the workspace whose tests `cargo xtask test` runs.
fn tests() -> StepResult {
    let mut test = run::cargo(&["test", "--quiet", "--locked", "--manifest-path"]);
    test.arg(run::root().join("bench/Cargo.toml")).args([
        "--package",
        "lafet-bench-trips",
        "--package",
        "lafet-bench-report",
    ]);
    test.env("CARGO_TARGET_DIR", no_std::target().join("bench"));
    run::show(&mut test)
}

fn names() -> String {
    PARTS.iter().map(|part| part.name).collect::<Vec<_>>().join("|")
}

fn measure(part: &Part) -> StepResult {
    (part.needs)()?;
    println!("== {}", part.name);
    let printed = (part.print)()?;
    println!("{printed}");
    let mut page = run::read(PAGE)?;
    for (name, text) in sections(&printed)? {
        if name.ends_with(".svg") {
            let path = run::root().join("docs/images").join(format!("bench-{name}"));
            std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))?;
        } else {
            page = run::put(PAGE, &page, name, &text)?;
        }
    }
    std::fs::write(run::root().join(PAGE), page).map_err(|e| format!("{PAGE}: {e}"))
}

fn codec() -> Result<String, String> {
    // This check builds without the peers, so the counts that it compares with must too.
    let counts = run::root().join(COUNTS);
    let mut write = program("lafet-bench-codec", &["--no-default-features"])?;
    run::output(write.arg("write").arg(counts))?;
    run::output(program("lafet-bench-codec", &[])?.arg("report"))
}

fn roundtrip() -> Result<String, String> {
    let lafet = demo::optimised()?;
    let folder = run::root().join("bench/trips");
    run::output(program("lafet-bench-trips", &[])?.arg("report").arg(lafet).arg(folder))
}

/// Rounds of polls on a simulated line, as printed by a test of the client.
fn bus() -> Result<String, String> {
    const GOAL: f64 = 95.0;
    let words = ["test", "--quiet", "--package", "lafet-client", "--test", "it", "--"];
    let mut test = run::cargo(&words);
    let printed =
        run::output(test.args(["--nocapture", "--test-threads", "1", "bus::thirty_two"]))?;
    let mut table = String::from(
        "| | a round | bytes sent in it | share of time the line is busy |\n\
         |---|---:|---:|---:|\n",
    );
    let mut goals = String::from("| goal | at least | measured | |\n|---|---:|---:|---|\n");
    for row in printed.lines().filter(|line| line.starts_with("| ")) {
        table += &format!("{row}\n");
        let mut cells = row.trim_matches(['|', ' ']).split(" | ");
        let (who, share) = (cells.next().unwrap_or_default(), cells.last());
        let share = share.and_then(|cell| cell.trim_end_matches(" %").parse::<f64>().ok());
        let share = share.ok_or_else(|| format!("no share in `{row}`"))?;
        if who.starts_with("lafet") {
            let word = if share >= GOAL { "met" } else { "**missed**" };
            goals += &format!("| {who}: share of the line | {GOAL} % | {share} % | {word} |\n");
        }
    }
    Ok(format!("== bus\n{table}\n== bus-goals\n{goals}"))
}

fn sim() -> Result<String, String> {
    run::output(&mut program("lafet-bench-host", &["--bin", "sim"])?)
}

fn capture() -> Result<String, String> {
    let lafet = demo::optimised()?;
    let folder = run::root().join("bench/host");
    run::output(program("lafet-bench-host", &["--bin", "capture"])?.arg(lafet).arg(folder))
}

/// Flash, RAM and instructions per message, next to a program that does nothing.
fn footprint() -> Result<String, String> {
    const GOALS: [(&str, u64); 3] = [("flash", 1_500), ("RAM", 600), ("instructions", 1_200)];
    let none = chip("none", &[])?;
    let mut table =
        String::from("| | flash | RAM | instructions a message |\n|---|---:|---:|---:|\n");
    let mut goals = String::from("| goal | at most | measured | |\n|---|---:|---:|---|\n");
    let programs = ["lafet", "lafet-all", "mavlink", "postcard", "rmodbus"];
    for name in programs {
        let feature = name.trim_end_matches("-all");
        let all = chip(name, &["--features", feature])?;
        let own = [all.0.saturating_sub(none.0), all.1.saturating_sub(none.1), all.2];
        table += &format!("| {name} | {} | {} | {} |\n", own[0], own[1], own[2]);
        for ((what, goal), got) in GOALS.iter().zip(own).filter(|_| name == "lafet") {
            let word = if got <= *goal { "met" } else { "**missed**" };
            goals += &format!("| {what} | {goal} | {got} | {word} |\n");
        }
    }
    Ok(format!("== footprint\n{table}\n== footprint-goals\n{goals}"))
}

/// Flash and RAM of a program for the chip, and the instructions it counts there.
fn chip(name: &str, features: &[&str]) -> Result<(u64, u64, u64), String> {
    let target = no_std::target().join("footprint");
    let mut build = no_std::build(Some(&target))?;
    build.current_dir(run::root().join("bench/footprint"));
    build.args(["--release", "--locked", "--bin", name]).args(features);
    run::output(&mut build)?;
    let program = target.join(no_std::TARGET).join("release").join(name);
    let (flash, ram) = Elf::read(&program)?.memory();
    let mut qemu = Command::new(QEMU);
    qemu.args(["-M", "lm3s6965evb", "-nographic", "-icount", "shift=0"]);
    qemu.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(&program);
    let printed = run::output(&mut qemu)?;
    let count = printed.trim().parse().map_err(|_| format!("{name} printed `{printed}`"))?;
    Ok((flash, ram, count))
}

fn nothing() -> StepResult {
    Ok(())
}

fn modbus() -> StepResult {
    setup::program("taskset", "util-linux")?;
    if run::output(Command::new("pkg-config").args(["--exists", "libmodbus"])).is_err() {
        setup::debian(&["libmodbus-dev", "pkg-config"])?;
    }
    python("pymodbus")
}

fn mavlink() -> StepResult {
    setup::program("tshark", "tshark")?;
    python("pymavlink")
}

fn emulator() -> StepResult {
    setup::program(QEMU, QEMU)
}

fn python(package: &str) -> StepResult {
    if run::output(Command::new("python3").args(["-c", &format!("import {package}")])).is_ok() {
        return Ok(());
    }
    run::show(Command::new("python3").args(["-m", "pip", "install", "--quiet", package]))
}

/// `cargo run` of a program of bench/, which has a target folder of its own.
///
/// It is run through a link of a fixed path: cargo hashes the path of a crate outside its workspace
/// into symbol names, their order affects inlining, and instruction counts would differ between
/// clones.
fn program(package: &str, features: &[&str]) -> Result<Command, String> {
    let link = std::env::temp_dir().join("lafet-bench");
    if std::fs::read_link(&link).ok() != Some(run::root()) {
        let fresh = std::env::temp_dir().join(format!("lafet-bench-{}", std::process::id()));
        std::os::unix::fs::symlink(run::root(), &fresh)
            .and_then(|()| std::fs::rename(&fresh, &link))
            .map_err(|error| format!("{}: {error}", link.display()))?;
    }
    let mut command = run::cargo(&["run", "--quiet", "--release", "--locked", "--manifest-path"]);
    command.arg(link.join("bench/Cargo.toml"));
    command.env("CARGO_TARGET_DIR", no_std::target().join("bench"));
    command.args(["--package", package]).args(features).arg("--");
    Ok(command)
}

fn valgrind() -> StepResult {
    setup::program("valgrind", "valgrind")
}

/// Splits the text into sections: `== NAME`, followed by lines.
fn sections(printed: &str) -> Result<Vec<(&str, String)>, String> {
    let mut sections: Vec<(&str, String)> = Vec::new();
    for line in printed.lines() {
        match (line.strip_prefix("== "), sections.last_mut()) {
            (Some(name), _) => sections.push((name, String::new())),
            (None, Some((_, text))) => *text += &format!("{line}\n"),
            (None, None) => return Err(format!("a benchmark started with `{line}`")),
        }
    }
    sections.iter_mut().for_each(|(_, text)| *text = format!("{}\n", text.trim_end()));
    Ok(sections)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_find_their_places() {
        let sections = sections("== a\n| 1 |\n\n== b.svg\n<svg>\n").unwrap();
        assert_eq!(sections, [("a", "| 1 |\n".to_owned()), ("b.svg", "<svg>\n".to_owned())]);
        let page = "x\n<!-- a:begin -->\nold\n<!-- a:end -->\ny\n";
        let new = run::put(PAGE, page, "a", "| 1 |\n").unwrap();
        assert_eq!(new, page.replace("old", "| 1 |"));
        assert!(run::put(PAGE, page, "c", "").is_err());
        assert!(super::sections("no section\n").is_err());
    }
}
