//! `cargo xtask firmware`: the monitor's program on a Cortex-M3, built for each board, tested on the
//! emulated one and in the model of a chip, or run there.

mod images;
mod panics;
mod relay;
pub mod update;

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::Duration;

use crate::run::{StepResult, cargo, output, root, show};
use crate::{TaskResult, demo, no_std, setup, size, verify};

pub const BOARDS: [&str; 2] = [EMULATED, "stm32f103"];
/// The board that QEMU emulates.
pub const EMULATED: &str = "lm3s6965";
const KNOWN: &str =
    "build, test, load, run, images, update, board, iron, wrong, fire, serve or provision";
const FIRE_PORT: u16 = 10_492;
/// The fire must be out after so many seconds.
const FIRE_LIMIT_S: u32 = 180;
/// The board says where it listens within this time.
const LISTENS_MAX: Duration = Duration::from_secs(10);
/// What an operator types, without the end: the board closes its port when the fire is out.
const FIRE: [&[&str]; 3] = [
    &["deploy"],
    &["open"],
    &[
        "quench",
        "--centre",
        "30deg,-3deg",
        "--distance",
        "25",
        "--sector",
        "5deg,2deg",
        "--step",
        "1",
    ],
];
const QEMU: &str = "qemu-system-arm";

pub fn firmware(arguments: &[String]) -> TaskResult {
    let Some((what, rest)) = arguments.split_first() else {
        return Err(format!("firmware {KNOWN}?"));
    };
    match (what.as_str(), rest) {
        ("build", []) => {
            images::boot_program(&[])?;
            let all = BOARDS.into_iter().chain([images::FEATURE]);
            all.into_iter().try_for_each(|board| build(board).map(|_| ()))?;
        }
        ("test", rest) => test(rest)?,
        ("load", []) => load()?,
        ("run", rest) => run(rest)?,
        ("images", rest) => images::images(rest)?,
        ("update", []) => update::update()?,
        ("update", [quick]) if quick == "--quick" => update::quick()?,
        ("board", []) => board()?,
        ("iron", []) => iron()?,
        ("wrong", []) => wrong()?,
        ("fire", []) => fire()?,
        ("serve", rest) => show(&mut example("serve", rest))?,
        // What it prints may be a record's file, so nothing else is printed.
        ("provision", rest) => print!("{}", output(&mut example("provision", rest))?),
        _ => return Err(format!("firmware {}: {KNOWN}", arguments.join(" "))),
    }
    Ok(ExitCode::SUCCESS)
}

/// Links the program for every board, which fails if a panic can be reached; checks its size; tests
/// the board stm32f103 in the model of its chip; compares the emulated chip with the host, and lets
/// both extinguish a fire. What the step `update` runs is built.
pub fn check() -> StepResult {
    size::check()?;
    update::build()?;
    board()?;
    fire()?;
    test(&["--seeds".into(), "2".into(), "--steps".into(), "1000".into()])?;
    load()
}

/// Tests the program of the board stm32f103 in the model of its chip.
fn board() -> StepResult {
    show(&mut model(&["test", "--quiet"]))
}

/// Sends that board's barrels to and fro behind every combination of lag, stiction and play.
fn iron() -> StepResult {
    show(&mut model(&["test", "--quiet", "--test", "iron", "--", "--ignored", "--nocapture"]))
}

/// Looks which check is the first that notices each wrong board, and prints the list where it is another one.
fn wrong() -> StepResult {
    show(&mut model(&["test", "--quiet", "--test", "wrong", "--", "--ignored"]))
}

/// The board in the model of its chip, at a port, and `lafet` that puts out the fire in front of it.
fn fire() -> StepResult {
    let url = format!("tcp://127.0.0.1:{FIRE_PORT}?addr=7");
    show(&mut model(&["build", "--quiet", "--examples"]))?;
    let program = demo::program()?;
    let mut serve = model(&["run", "--quiet", "--example", "serve"]);
    serve.args(["--", &FIRE_PORT.to_string(), &FIRE_LIMIT_S.to_string()]);
    let mut board =
        serve.stdout(Stdio::piped()).spawn().map_err(|error| format!("the board: {error}"))?;
    let (listens, said) = listen(&mut board);
    let late = |_| format!("the board does not listen after {} s", LISTENS_MAX.as_secs());
    let asked = listens.recv_timeout(LISTENS_MAX).map_err(late).and_then(|()| {
        FIRE.iter().try_for_each(|words| {
            let mut lafet = Command::new(&program);
            show(lafet.args(["-c", &url, "--timeout", "20"]).args(*words))
        })
    });
    if asked.is_err() {
        // It may have ended by itself.
        let _ = board.kill();
    }
    let ended = board.wait().map_err(|error| format!("the board: {error}"))?;
    // A panic of it has been shown.
    let _ = said.join();
    asked?;
    if ended.success() { Ok(()) } else { Err("the fire burns on".into()) }
}

/// Shows what the board says; it listens once it has said where. A connection to find that out would
/// take its only place.
fn listen(board: &mut Child) -> (mpsc::Receiver<()>, JoinHandle<()>) {
    let (said, listens) = mpsc::channel();
    let output = board.stdout.take();
    let shown = std::thread::spawn(move || {
        let lines = output.into_iter().flat_map(|it| BufReader::new(it).lines());
        for line in lines.map_while(Result::ok) {
            println!("{line}");
            // After the first line nothing waits.
            let _ = said.send(());
        }
    });
    (listens, shown)
}

fn example(name: &str, arguments: &[String]) -> Command {
    let mut command = model(&["run", "--quiet", "--example", name]);
    command.arg("--").args(arguments);
    command
}

/// The format of the firmware's workspace.
pub fn format() -> StepResult {
    show(cargo(&["fmt", "--all", "--check"]).current_dir(root().join("firmware")))
}

/// The lints of the firmware's workspace: of what runs on the host too, and of each board's program.
pub fn lints() -> StepResult {
    const DENY: [&str; 3] = ["--", "-D", "warnings"];
    let host = ["clippy", "--workspace", "--all-targets", "--exclude", "lafet-firmware"];
    show(model(&host).args(["--exclude", "lafet-boot"]).args(DENY))?;
    let programs = BOARDS.into_iter().chain([images::FEATURE]);
    let programs = programs.map(|board| (board, program_of(board).to_vec()));
    programs.chain([("boot", images::BOOT.to_vec())]).try_for_each(|(name, chosen)| {
        let folder = no_std::target().join("firmware").join(name);
        let Some(mut clippy) = no_std::clippy(&folder) else { return Ok(()) };
        clippy.current_dir(root().join("firmware")).args(chosen);
        show(clippy.args(DENY))
    })
}

/// What selects the program of a board, whose name may have further features behind it.
fn program_of(features: &str) -> [&str; 5] {
    ["--release", "--locked", "--no-default-features", "--features", features]
}

/// The model is of the firmware's workspace, built for the host.
fn model(arguments: &[&str]) -> Command {
    host("stm32f103-model", arguments)
}

/// A package of the firmware's workspace, built for the host.
fn host(package: &str, arguments: &[&str]) -> Command {
    let mut command = cargo(arguments);
    command.args(["--locked", "--profile", "model", "--manifest-path"]);
    command.arg(root().join("firmware").join(package).join("Cargo.toml"));
    command.env("CARGO_TARGET_DIR", no_std::target().join("firmware/model"));
    command
}

/// Builds the program for a board, whose name may have further features behind it, with commas; returns the
/// path of the ELF file.
pub fn build(features: &str) -> Result<PathBuf, String> {
    let board = features.split(',').next().unwrap_or(features);
    let folder = no_std::target().join("firmware").join(board);
    let mut build = no_std::build(Some(&folder))?;
    build.current_dir(root().join("firmware"));
    build.args(program_of(features));
    show(&mut build)?;
    Ok(folder.join(no_std::TARGET).join("release/lafet-firmware"))
}

fn test(arguments: &[String]) -> StepResult {
    emulator()?;
    let program = build(EMULATED)?;
    let stack = size::stack_as_published(&program)?.to_string();
    let mut test = verify::tested("chip");
    show(test.arg(&program).args(["--stack", &stack]).args(arguments))
}

/// Counts the instructions of steps and answers on the emulated chip; fails when a step takes too many.
fn load() -> StepResult {
    emulator()?;
    let program = build(EMULATED)?;
    show(verify::tested("load").arg(&program))
}

fn run(arguments: &[String]) -> StepResult {
    emulator()?;
    let program = build(EMULATED)?;
    let mut sim = cargo(&["run", "--quiet", "--release", "--package", "lafet", "--"]);
    sim.args(["sim", "--on", "qemu", "--firmware"]).arg(&program);
    show(sim.args(arguments))
}

fn emulator() -> StepResult {
    if output(Command::new(QEMU).arg("--version")).is_ok() {
        return Ok(());
    }
    setup::debian(&[QEMU])
}
