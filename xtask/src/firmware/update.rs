//! `cargo xtask firmware update`: the board mps2 is updated over its own link, with everything going wrong.
//!
//! Assumed are lines that are cut and spoil bytes, power that fails at any moment, and programs that hear
//! nothing; each happens here.

use std::io::{BufRead, BufReader, Read as _};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::images::{self, Programs};
use super::relay::Relay;
use crate::elf::Elf;
use crate::no_std;
use crate::run::{self, StepResult, output, show};

const PORT: u16 = 10_493;
/// A line that has been cut is put together again after this.
const CUT: Duration = Duration::from_secs(3);
/// The board listens within this time: its bootloader verifies two images at most.
const LISTENS: Duration = Duration::from_secs(60);
/// After its start it has sensed everything within this time.
const SENSES: Duration = Duration::from_secs(20);
/// A program that hears nothing restarts itself after 180 s of its clock, which runs this much faster.
const SPEED: &str = "5";
const BACK: Duration = Duration::from_secs(240);
/// Runs of `lafet update` until an update must have come to its end: each cut of power may cost one.
const RUNS: usize = 8;
/// A parameter that is set, and has to outlive everything.
const PROGRAM: [&str; 11] = [
    "program",
    "set",
    "3",
    "--centre",
    "30deg,-2deg",
    "--sector",
    "6deg,2deg",
    "--step",
    "1",
    "--distance",
    "25",
];

pub fn update() -> StepResult {
    super::emulator()?;
    show(&mut super::host("mps2", &["test", "--quiet"]))?;
    let folder = no_std::target().join("firmware/update");
    // What an earlier run has left.
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let boot = images::boot_program()?;
    tell_size(&boot)?;
    let bench = Bench::new(folder, boot)?;
    let result = bench.run();
    if result.is_ok() {
        // 16 MiB of flash, and images; after a failure they are looked at.
        let _ = std::fs::remove_dir_all(&bench.folder);
    }
    result
}

/// What the bootloader takes of the chip, for docs/update.md.
fn tell_size(boot: &Path) -> StepResult {
    let (flash, ram) = Elf::read(boot)?.memory();
    println!("   bootloader: {flash} bytes of flash, {ram} of RAM beside the stack");
    Ok(())
}

/// A moment of an update.
#[derive(Clone, Copy, Debug)]
enum At {
    /// Percent of the data are there.
    Sent(u64),
    /// The stage has started, as `lafet update --json` names it.
    Stage(&'static str),
}

impl At {
    fn is_reached(self, line: &Value) -> bool {
        match self {
            Self::Sent(percent) => {
                let share = |name: &str| line[name].as_u64();
                let sent = share("done").zip(share("size"));
                sent.is_some_and(|(done, size)| done * 100 >= percent * size)
            }
            Self::Stage(stage) => line["stage"] == stage,
        }
    }
}

/// Images of all versions, and what is needed to try them.
struct Bench {
    folder: PathBuf,
    lafet: PathBuf,
    boot: PathBuf,
    programs: Programs,
}

impl Bench {
    fn new(folder: PathBuf, boot: PathBuf) -> Result<Self, String> {
        let lafet = run::program("lafet")?;
        let programs = Programs::link(&folder, "program", &[])?;
        Ok(Self { folder, lafet, boot, programs })
    }

    fn images(&self, version: &str) -> Result<[PathBuf; 2], String> {
        self.programs.sign(&self.lafet, version, &images::test_key())
    }

    fn run(&self) -> StepResult {
        let [first, _] = self.images("1.0")?;
        let place = SocketAddr::from(([127, 0, 0, 1], PORT));
        let board = Board::start(self, &first, "1")?;
        let url = format!("tcp://{place}");
        self.wrapped(&url)?;
        self.done(&url, &PROGRAM)?;
        self.done(&url, &["lockout", "on"])?;
        self.expect(&url, "1.0.0.0", "A")?;

        self.over(
            &Relay::tcp(place).map_err(line)?,
            "1.1",
            [At::Sent(20), At::Sent(60), At::Stage("restarting")],
        )?;
        self.expect(&url, "1.1.0.0", "B")?;

        let noisy = Relay::serial(place).map_err(line)?;
        self.over(&noisy, "1.2", [At::Sent(10), At::Sent(50), At::Stage("verifying")])?;
        let spoiled = noisy.spoiled();
        if spoiled < 10 {
            return Err(format!("the line has spoiled {spoiled} bytes: that is no noise"));
        }
        println!("   over a line that has spoiled {spoiled} bytes");
        // The port of the chip takes one connection.
        drop(noisy);
        self.expect(&url, "1.2.0.0", "A")?;

        let board = self.without_power(board, &url, &first)?;
        self.expect(&url, "1.3.0.0", "B")?;

        board.cut_power()?;
        let _board = Board::start(self, &first, SPEED)?;
        self.dead_link(&url)?;
        self.expect(&url, "1.3.0.0", "B")
    }

    /// An update in one go, over a line that is cut at these moments.
    fn over<const N: usize>(&self, relay: &Relay, version: &str, cuts: [At; N]) -> StepResult {
        let images = self.images(version)?;
        let mut left = cuts.as_slice();
        let updated = self.update(&relay.url, &images, |line| {
            if let [at, others @ ..] = left
                && at.is_reached(line)
            {
                println!("   the line is cut: {at:?}");
                relay.cut(CUT);
                left = others;
            }
            Ok(())
        })?;
        updated.succeeded()?;
        if left.is_empty() { Ok(()) } else { Err(format!("never reached: {left:?}")) }
    }

    /// An update during which the power is cut at one moment after the other.
    fn without_power(&self, board: Board, url: &str, first: &Path) -> Result<Board, String> {
        let images = self.images("1.3")?;
        let cuts = [
            At::Sent(15),
            At::Sent(55),
            At::Stage("verifying"),
            At::Stage("committed"),
            At::Stage("on-trial"),
            At::Stage("confirming"),
        ];
        let (mut left, mut board) = (cuts.as_slice(), Some(board));
        for _ in 0..RUNS {
            let updated = self.update(url, &images, |line| {
                let [at, others @ ..] = left else { return Ok(()) };
                if at.is_reached(line) {
                    println!("   the power is cut: {at:?}");
                    left = others;
                    if let Some(running) = board.take() {
                        running.cut_power()?;
                    }
                    board = Some(Board::start(self, first, "1")?);
                }
                Ok(())
            })?;
            if left.is_empty() && updated.code == Some(0) {
                return board.ok_or_else(|| "the board does not run".to_owned());
            }
            println!("   once more, after: {}", updated.said.trim());
        }
        Err(format!("not updated in {RUNS} runs; left: {left:?}"))
    }

    /// An image that hears nothing is tried, and gone back from.
    fn dead_link(&self, url: &str) -> StepResult {
        let dead = Programs::link(&self.folder, "dead-link", &["dead-link"])?;
        let images = dead.sign(&self.lafet, "1.4", &images::test_key())?;
        let updated = self.update(url, &images, |_| Ok(()))?;
        if updated.code == Some(0) || !updated.stages.iter().any(|stage| stage == "restarting") {
            return Err(format!("a dead link: {updated:?}"));
        }
        println!("   {}", updated.said.trim());
        let end = Instant::now() + BACK;
        while Instant::now() < end {
            match self.state(url) {
                Ok(state) if state["last_trial_failed"] == true => return Ok(()),
                _ => thread::park_timeout(Duration::from_secs(1)),
            }
        }
        Err(format!("the old image does not answer after {} s", BACK.as_secs()))
    }

    /// Runs `lafet update` to its end; each line of its output is looked at.
    fn update(
        &self,
        url: &str,
        images: &[PathBuf],
        mut look: impl FnMut(&Value) -> StepResult,
    ) -> Result<Updated, String> {
        let mut command = self.lafet(url);
        command.args(["--json", "--timeout", "0.5", "update", "--pace", "100"]).args(images);
        let failed = |e: std::io::Error| format!("lafet update: {e}");
        let mut child =
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().map_err(failed)?;
        let mut updated = Updated::default();
        let said = child.stderr.take().map(|mut stderr| {
            thread::spawn(move || {
                let mut said = String::new();
                // What it has said until its end.
                let _ = stderr.read_to_string(&mut said);
                said
            })
        });
        let mut looked = Ok(());
        for line in child.stdout.take().into_iter().flat_map(|it| BufReader::new(it).lines()) {
            let line: Value = serde_json::from_str(&line.map_err(failed)?).unwrap_or_default();
            updated.stages.extend(line["stage"].as_str().map(str::to_owned));
            looked = looked.and_then(|()| look(&line));
        }
        updated.code = child.wait().map_err(failed)?.code();
        updated.said = said.and_then(|said| said.join().ok()).unwrap_or_default();
        looked.map(|()| updated)
    }

    /// The version and the slot that run, confirmed; the parameter and the lockout as they were.
    fn expect(&self, url: &str, version: &str, slot: &str) -> StepResult {
        let state = self.state(url)?;
        let is = (&state["version"], &state["slot"], &state["on_trial"]);
        if is != (&version.into(), &slot.into(), &false.into()) {
            return Err(format!("{version} in slot {slot}, confirmed, was awaited: {state}"));
        }
        let general = self.value(url, &["status", "general"])?;
        if !general.to_string().contains("LockedOut") {
            return Err(format!("the lockout is lost: {general}"));
        }
        let program = self.value(url, &["param", "get", "control", "Program3"])?;
        if program["values"][6] != 25 {
            return Err(format!("a parameter is lost: {program}"));
        }
        println!("   {version} in slot {slot}, locked out, with its parameters");
        Ok(())
    }

    fn state(&self, url: &str) -> Result<Value, String> {
        self.value(url, &["update", "--state"])
    }

    fn value(&self, url: &str, words: &[&str]) -> Result<Value, String> {
        let printed = output(self.lafet(url).arg("--json").args(words))?;
        serde_json::from_str(printed.trim()).map_err(|e| format!("{words:?}: {e}: {printed}"))
    }

    /// In standby: right after its start a monitor does not know yet that everything is closed.
    fn wrapped(&self, url: &str) -> StepResult {
        let end = Instant::now() + SENSES;
        loop {
            match self.done(url, &["wrap"]) {
                Err(_) if Instant::now() < end => thread::park_timeout(Duration::from_secs(1)),
                result => return result,
            }
        }
    }

    fn done(&self, url: &str, words: &[&str]) -> StepResult {
        output(self.lafet(url).args(words)).map(|_| ())
    }

    fn lafet(&self, url: &str) -> Command {
        let mut command = Command::new(&self.lafet);
        for name in ["LAFET_CONNECT", "LC_ALL", "LC_MESSAGES", "LANG"] {
            command.env_remove(name);
        }
        command.env("XDG_STATE_HOME", self.folder.join("state"));
        command.args(["--lang", "en", "-c", url]);
        command
    }
}

fn line(error: std::io::Error) -> String {
    format!("the line: {error}")
}

/// How a run of `lafet update` has ended.
#[derive(Debug, Default)]
struct Updated {
    code: Option<i32>,
    stages: Vec<String>,
    said: String,
}

impl Updated {
    fn succeeded(&self) -> StepResult {
        if self.code == Some(0) { Ok(()) } else { Err(format!("not updated: {self:?}")) }
    }
}

/// The emulated board, for as long as this lives.
struct Board {
    sim: Child,
    qemu: u32,
}

impl Board {
    /// Starts it with the flash of the bench, which has the first image when it is new.
    fn start(bench: &Bench, first: &Path, speed: &str) -> Result<Self, String> {
        let mut sim = Command::new(&bench.lafet);
        sim.args(["--lang", "en", "sim", "--on", "qemu", "--speed", speed]);
        sim.arg("--boot").arg(&bench.boot).arg("--firmware").arg(first);
        sim.arg("--flash").arg(bench.folder.join("flash"));
        sim.args(["--listen", &format!("tcp://127.0.0.1:{PORT}")]);
        let failed = |e: std::io::Error| format!("the board: {e}");
        let mut sim = sim.stdout(Stdio::piped()).spawn().map_err(failed)?;
        let (said, listens) = mpsc::channel();
        let lines = sim.stdout.take();
        thread::spawn(move || {
            for line in lines.into_iter().flat_map(|it| BufReader::new(it).lines()) {
                let Ok(line) = line else { break };
                println!("   board: {line}");
                // After the first line nothing waits.
                let _ = said.send(());
            }
        });
        let mut board = Self { sim, qemu: 0 };
        listens.recv_timeout(LISTENS).map_err(|_| "the board does not start".to_owned())?;
        board.qemu = child_of(board.sim.id()).ok_or("the board has no emulator")?;
        Ok(board)
    }

    /// Its power is gone at once, whatever it is at.
    fn cut_power(mut self) -> StepResult {
        output(Command::new("kill").args(["-KILL", &self.qemu.to_string()]))?;
        // It has lost its chip.
        self.sim.wait().map(|_| ()).map_err(|e| format!("the board: {e}"))
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        if self.sim.try_wait().is_ok_and(|ended| ended.is_some()) {
            return;
        }
        // SIGTERM, so that the emulator ends too.
        let _ = output(Command::new("kill").args(["-TERM", &self.sim.id().to_string()]));
        let _ = self.sim.wait();
    }
}

/// The process that this one has started.
fn child_of(parent: u32) -> Option<u32> {
    let processes = std::fs::read_dir("/proc").ok()?.flatten();
    let mut ids = processes.filter_map(|it| it.file_name().to_str()?.parse::<u32>().ok());
    ids.find(|id| {
        let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
        let fields = stat.rsplit_once(')').map_or("", |(_, fields)| fields);
        fields.split_whitespace().nth(1).and_then(|it| it.parse().ok()) == Some(parent)
    })
}
