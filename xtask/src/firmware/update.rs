//! `cargo xtask firmware update`: the board mps2 is updated over its own link, with everything going wrong.
//!
//! Assumed are lines that are cut and spoil bytes, power that fails at any moment, senders that are killed,
//! programs that hear nothing, and programs and bootloaders that panic; each happens here.

mod board;
mod outputs;
mod served;

use std::cell::Cell;
use std::fmt;
use std::io::{BufRead, BufReader, Read as _};
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use self::board::{Board, Start};
use self::outputs::Far;
use self::served::Hub;
use super::images::{self, Programs};
use super::panics;
use super::relay::Relay;
use crate::elf::Elf;
use crate::run::{self, StepResult, output, show};
use crate::{demo, no_std};

/// A line that has been cut is put together again after this.
const CUT: Duration = Duration::from_secs(3);
/// After its start the board has sensed everything within this time.
const SENSES: Duration = Duration::from_secs(20);
/// A program that hears nothing restarts itself after 180 s of its clock, which runs this much faster; on a machine
/// that is busy with thirty processes, no faster than that of the room.
const FAST: &str = "5";
const BACK: Duration = Duration::from_secs(600);
/// No run of the hub takes longer.
const HUB_RUN: Duration = Duration::from_secs(600);
/// `lafet update` says something within this time: it waits for a trial that goes back for 240 s, and for a dead line for
/// 60 s more.
const SAYS: Duration = Duration::from_secs(400);
/// A monitor that is sent here and there meets a panic within this time.
const DRIVES: Duration = Duration::from_secs(120);
/// How often it is looked whether it has.
const LOOK: Duration = Duration::from_millis(50);
/// What is undefined on purpose at the end of a panic, as GetCrashData has it.
const PANIC: &str = "UNDEFINSTR";
/// Fewer bytes spoiled are no noise.
const NOISE: u64 = 10;
/// A parameter that is set, and has to outlive everything, as all others.
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

/// All that can go wrong.
pub fn update() -> StepResult {
    show(&mut super::host("mps2", &["test", "--quiet"]))?;
    Bench::new("update", run::program("lafet")?, "20")?.run(Bench::all)
}

/// What CI has time for: one update, during which the cable is pulled, the power fails and its sender is killed.
pub fn quick() -> StepResult {
    Bench::new("update-quick", demo::program()?, "5")?.run(Bench::once)
}

/// Builds what the updates need, and looks where it can panic.
pub fn build() -> StepResult {
    let boot = images::boot_program(&[])?;
    let (flash, ram) = Elf::read(&boot)?.memory();
    println!("   bootloader: {flash} bytes of flash, {ram} of RAM beside the stack");
    panics::check("the bootloader", &boot)?;
    panics::check("the program", &super::build(images::FEATURE)?)?;
    super::build(&format!("{},{}", images::FEATURE, images::SLOT_B)).map(|_| ())
}

/// A moment of an update.
#[derive(Clone, Copy, Debug)]
enum At {
    /// Percent of the data are there.
    Sent(u64),
    /// The stage has started, as `lafet update --json` and the hub name it.
    Stage(&'static str),
}

impl At {
    fn is_reached(self, far: &Value) -> bool {
        match self {
            Self::Sent(percent) => {
                let share = |name: &str| far[name].as_u64();
                let sent = share("done").zip(share("size"));
                sent.is_some_and(|(done, size)| done * 100 >= percent * size)
            }
            Self::Stage(stage) => far["stage"] == stage,
        }
    }
}

/// What happens to an update on its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mishap {
    /// The cable is pulled for some seconds.
    Cable,
    /// The power of the board is cut.
    Power,
    /// `lafet update` is killed.
    Sender,
}

/// What is still to happen, in this order.
struct Course(Cell<&'static [(At, Mishap)]>);

impl Course {
    /// What happens now that the update is so far.
    fn next(&self, far: &Value) -> Option<Mishap> {
        let [(at, mishap), others @ ..] = self.0.get() else { return None };
        at.is_reached(far).then(|| {
            println!("   {mishap:?}, at {at:?}");
            self.0.set(others);
            *mishap
        })
    }

    fn is_over(&self) -> bool {
        self.0.get().is_empty()
    }
}

impl fmt::Debug for Course {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.get().fmt(f)
    }
}

/// Three cuts of the cable.
const CABLE: [&[(At, Mishap)]; 3] = [
    &[
        (At::Sent(20), Mishap::Cable),
        (At::Sent(60), Mishap::Cable),
        (At::Stage("restarting"), Mishap::Cable),
    ],
    &[
        (At::Sent(10), Mishap::Cable),
        (At::Sent(50), Mishap::Cable),
        (At::Stage("verifying"), Mishap::Cable),
    ],
    &[
        (At::Sent(15), Mishap::Cable),
        (At::Sent(70), Mishap::Cable),
        (At::Stage("on-trial"), Mishap::Cable),
    ],
];
/// What may end a run of `lafet update`.
const POWER: &[(At, Mishap)] = &[
    (At::Sent(15), Mishap::Power),
    (At::Sent(35), Mishap::Sender),
    (At::Sent(55), Mishap::Power),
    (At::Stage("verifying"), Mishap::Power),
    (At::Stage("committed"), Mishap::Power),
    (At::Stage("on-trial"), Mishap::Sender),
    (At::Stage("on-trial"), Mishap::Power),
    (At::Stage("confirming"), Mishap::Power),
];
const SHORT: &[(At, Mishap)] =
    &[(At::Sent(20), Mishap::Cable), (At::Sent(50), Mishap::Power), (At::Sent(80), Mishap::Sender)];

/// Images of all versions, and what is needed to try them.
struct Bench {
    folder: PathBuf,
    lafet: PathBuf,
    boot: PathBuf,
    programs: Programs,
    /// What a new board has in slot A.
    first: PathBuf,
    /// For how long what is on trial is watched, s.
    watch: &'static str,
    /// Where the board listens.
    place: SocketAddr,
    url: String,
}

impl Bench {
    fn new(name: &str, built: PathBuf, watch: &'static str) -> Result<Self, String> {
        super::emulator()?;
        let folder = no_std::target().join("firmware").join(name);
        // What an earlier run has left.
        let _ = std::fs::remove_dir_all(&folder);
        let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
        std::fs::create_dir_all(&folder).map_err(failed)?;
        // Another build must not exchange it meanwhile.
        let lafet = folder.join("lafet");
        std::fs::copy(built, &lafet).map_err(failed)?;
        build()?;
        let boot = bootloader(&[], &folder.join("boot.elf"))?;
        let programs = Programs::link(&folder, "program", &[])?;
        let [first, _] = programs.sign(&lafet, "1.0", &images::test_key())?;
        let place = free_place().map_err(line)?;
        let url = format!("tcp://{place}");
        Ok(Self { folder, lafet, boot, programs, first, watch, place, url })
    }

    fn run(&self, updates: impl FnOnce(&Self) -> StepResult) -> StepResult {
        let result = updates(self);
        if result.is_ok() {
            // 16 MiB of flash, and images; after a failure they are looked at.
            let _ = std::fs::remove_dir_all(&self.folder);
        }
        result
    }

    /// The board as it leaves the factory, but with a parameter set and locked out.
    fn new_board(&self, speed: &'static str) -> Result<Board, String> {
        let board = self.board(&self.boot, speed)?;
        self.wrapped()?;
        self.done(&PROGRAM)?;
        self.done(&["lockout", "on"])?;
        self.done(&["param", "backup", &self.params()])?;
        self.expect("1.0.0.0", "A")?;
        Ok(board)
    }

    fn board(&self, boot: &Path, speed: &'static str) -> Result<Board, String> {
        Board::start(self.start(boot, speed))
    }

    fn start(&self, boot: &Path, speed: &'static str) -> Start {
        Start {
            lafet: self.lafet.clone(),
            boot: boot.into(),
            first: self.first.clone(),
            flash: self.folder.join("flash"),
            port: self.place.port(),
            speed,
            tools: None,
        }
    }

    fn images(&self, version: &str) -> Result<[PathBuf; 2], String> {
        self.programs.sign(&self.lafet, version, &images::test_key())
    }

    fn once(&self) -> StepResult {
        let mut board = self.new_board(FAST)?;
        let cable = Relay::tcp(self.place).map_err(line)?;
        let runs = self.disturbed(&cable.url, "1.1", SHORT, &mut board, Some(&cable))?;
        println!("   updated in {runs} runs of `lafet update`");
        self.expect("1.1.0.0", "B")
    }

    fn all(&self) -> StepResult {
        let since = Instant::now();
        let mut board = self.new_board("1")?;
        let [tcp, serial, hub] = CABLE;

        let cable = Relay::tcp(self.place).map_err(line)?;
        let mut runs = self.disturbed(&cable.url, "1.1", tcp, &mut board, Some(&cable))?;
        self.expect("1.1.0.0", "B")?;

        let cable = Relay::serial(self.place).map_err(line)?;
        runs += self.disturbed(&cable.url, "1.2", serial, &mut board, Some(&cable))?;
        let mut spoiled = noise(cable)?;
        self.expect("1.2.0.0", "A")?;

        let cable = Relay::serial(self.place).map_err(line)?;
        self.by_hub(&cable, "1.3", hub)?;
        spoiled += noise(cable)?;
        self.expect("1.3.0.0", "B")?;

        runs += self.disturbed(&self.url, "1.4", POWER, &mut board, None)?;
        self.expect("1.4.0.0", "A")?;
        drop(board);

        self.what_is_not_kept()?;
        let all = || CABLE.into_iter().chain([POWER]).flatten();
        let times = |what| all().filter(|(_, mishap)| *mishap == what).count();
        println!(
            "   measured: 3 updates in {runs} runs of `lafet update`, 1 by a hub; {} cuts of the cable, {} losses of \
             power, {} senders killed, {spoiled} bytes spoiled; 3 trials gone back from, the sender of each killed once; \
             1 panic while something was driven; {} s",
            times(Mishap::Cable),
            times(Mishap::Power),
            times(Mishap::Sender),
            since.elapsed().as_secs()
        );
        Ok(())
    }

    /// Programs and a bootloader that fail on trial; and the same panic where the monitor drives something.
    fn what_is_not_kept(&self) -> StepResult {
        let board = self.board(&self.boot, FAST)?;
        // Two resets each: into the trial, and back.
        self.gone_back(&board, "dead-link", &self.linked("dead-link")?, "1.5")?;
        let panics = self.linked("panics")?;
        let crash = self.value(&["crash"])?;
        if !crash["fault"].is_null() {
            return Err(format!("there was a fault before the panic: {crash}"));
        }
        self.gone_back(&board, "panics", &panics, "1.6")?;
        let crash = self.value(&["crash"])?;
        let bits = crash["bits"].as_array().into_iter().flatten();
        if bits.filter(|bit| bit["name"] == PANIC).count() != 1 {
            return Err(format!("a panic has left no record of it: {crash}"));
        }
        drop(board);
        self.bootloader_panics("1.7")?;
        self.panics_while_driving(&panics, "1.0.1")
    }

    fn linked(&self, feature: &str) -> Result<Programs, String> {
        Programs::link(&self.folder, feature, &[feature])
    }

    /// An update by `lafet update`, on whose way all this happens. Cuts of the cable end none; after all else the
    /// same command goes on. Returns how often it was run.
    fn disturbed(
        &self,
        url: &str,
        version: &str,
        course: &'static [(At, Mishap)],
        board: &mut Board,
        cable: Option<&Relay>,
    ) -> Result<usize, String> {
        let images = self.images(version)?;
        let runs = match course.iter().filter(|(_, mishap)| *mishap != Mishap::Cable).count() {
            0 => 1,
            ending => ending + 2,
        };
        let left = Course(Cell::new(course));
        let mut last = Updated::default();
        for run in 1..=runs {
            last = self.update(url, &images, |far, sender| match left.next(far) {
                None => Ok(()),
                Some(Mishap::Cable) => {
                    let cable = cable.ok_or("this line cannot be cut")?;
                    cable.cut(CUT);
                    Ok(())
                }
                Some(Mishap::Power) => board.cut_power(),
                Some(Mishap::Sender) => sender.kill().map_err(|e| format!("lafet update: {e}")),
            })?;
            if left.is_over() && last.code == Some(0) {
                return Ok(run);
            }
            println!("   once more, after: {}", last.said.trim());
        }
        Err(format!("not updated to {version}; what did not happen: {left:?}; {last:?}"))
    }

    /// An update by a hub whose cable is cut.
    fn by_hub(&self, cable: &Relay, version: &str, course: &'static [(At, Mishap)]) -> StepResult {
        let hub = Hub::start(self.lafet_alone(), &self.folder.join("hub"), &cable.url)?;
        let images = self.images(version)?;
        let digests = images.iter().map(|it| hub.store(it)).collect::<Result<Vec<_>, _>>()?;
        let wanted = json!({ "images": digests, "pace": 100 }).to_string();
        hub.ask("POST", "/api/updates", wanted.as_bytes())?;
        let (left, end) = (Course(Cell::new(course)), Instant::now() + HUB_RUN);
        loop {
            let updates = hub.ask("GET", "/api/updates", &[])?;
            let run = &updates["run"];
            if left.next(&run["monitors"][0]).is_some() {
                cable.cut(CUT);
            }
            match run["state"].as_str() {
                Some("running") if Instant::now() < end => thread::park_timeout(served::LOOK),
                Some("done") if left.is_over() => break,
                _ => return Err(format!("by the hub, without {left:?}: {run}")),
            }
        }
        println!("   the hub has sent it");
        Ok(())
    }

    /// An image of these programs is tried, and gone back from.
    fn gone_back(
        &self,
        board: &Board,
        what: &str,
        programs: &Programs,
        version: &str,
    ) -> StepResult {
        let images = programs.sign(&self.lafet, version, &images::test_key())?;
        self.is_not_kept(board, &images, what, 2)
    }

    /// A bootloader that panics at an image on trial does so once.
    fn bootloader_panics(&self, version: &str) -> StepResult {
        let boot = bootloader(&["panics"], &self.folder.join("panics.elf"))?;
        if std::fs::read(&boot).ok() == std::fs::read(&self.boot).ok() {
            return Err("the bootloader that panics is the one that does not".into());
        }
        let board = self.board(&boot, FAST)?;
        // The plant sees programs start: of the trial there is none.
        self.is_not_kept(&board, &self.images(version)?, "a bootloader that panics", 1)
    }

    /// These images are tried, and the version that ran before runs again, after so many resets.
    fn is_not_kept(
        &self,
        board: &Board,
        images: &[PathBuf],
        what: &str,
        resets: u32,
    ) -> StepResult {
        let before = self.value(&["update", "--state"])?;
        let (version, slot) = (before["version"].as_str(), before["slot"].as_str());
        let (version, slot) = version.zip(slot).ok_or_else(|| format!("{what}: {before}"))?;
        // What the trial before has left must not be taken for what this one leaves: it is gone once this image is
        // being received.
        self.update(&self.url, images, |far, sender| match At::Sent(10).is_reached(far) {
            true => sender.kill().map_err(|e| format!("lafet update: {e}")),
            false => Ok(()),
        })?;
        let state = self.value(&["update", "--state"])?;
        if state["phase"] != "receiving" || state["last_trial_failed"] != false {
            return Err(format!("{what}, while it is being received: {state}"));
        }
        let (since, resets_before) = (Instant::now(), board.resets());
        let updated = self.update(&self.url, images, |_, _| Ok(()))?;
        if updated.code == Some(0) || !updated.stages.iter().any(|stage| stage == "restarting") {
            return Err(format!("{what}: {updated:?}"));
        }
        println!("   {what}: {}", updated.said.trim());
        let end = Instant::now() + BACK;
        loop {
            match self.value(&["update", "--state"]) {
                Ok(state) if state["last_trial_failed"] == true => break,
                _ if Instant::now() < end => thread::park_timeout(Duration::from_secs(1)),
                last => {
                    let limit = BACK.as_secs();
                    return Err(format!("{what}: not gone back after {limit} s: {last:?}"));
                }
            }
        }
        let was = board.resets() - resets_before;
        println!("   {what}: back after {} s, {was} resets", since.elapsed().as_secs());
        if was < resets {
            return Err(format!("{what}: {was} resets, where {resets} are needed for a trial"));
        }
        self.expect(version, slot)
    }

    /// A panic of a program that drives something: all is at rest at once, and nothing is driven after it.
    fn panics_while_driving(&self, programs: &Programs, version: &str) -> StepResult {
        let [first, _] = programs.sign(&self.lafet, version, &images::test_key())?;
        let tools = self.folder.join("tools");
        let notes = tools.join("notes");
        outputs::noting(&tools, &notes)?;
        let flash = self.folder.join("panics.flash");
        let start = self.start(&self.boot, "1");
        let _board = Board::start(Start { first, flash, tools: Some(tools), ..start })?;
        let end = Instant::now() + DRIVES;
        let mut ways = [["deploy"], ["wrap"]].into_iter().cycle();
        let mut sent: Option<Child> = None;
        let judged = loop {
            let noted = std::fs::read_to_string(&notes).unwrap_or_default();
            match outputs::judge(&noted) {
                Ok(_) if Instant::now() > end => {
                    break Err(format!("no reset after a panic: {noted}"));
                }
                Ok(Far::Rested) => break Ok(()),
                Ok(Far::Panicked) => {}
                Ok(Far::Before) => {
                    // At first it does not know yet that everything is closed; and a way is short.
                    if !sent.as_mut().is_some_and(|it| it.try_wait().is_ok_and(|it| it.is_none())) {
                        sent = Some(self.sends(ways.next().unwrap_or_default())?);
                    }
                }
                Err(why) => break Err(format!("{why}:\n{noted}")),
            }
            thread::park_timeout(LOOK);
        };
        if let Some(mut sent) = sent {
            run::end(&mut sent);
        }
        judged?;
        println!(
            "   a panic while the barrel is driven: reset at once, at rest up to the next one"
        );
        Ok(())
    }

    /// `lafet` that sends the monitor somewhere.
    fn sends(&self, words: [&str; 1]) -> Result<Child, String> {
        let mut command = self.lafet(&self.url);
        command.args(words).stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().map_err(|e| format!("lafet {words:?}: {e}"))
    }

    /// Runs `lafet update` to its end; each line of its output is looked at.
    fn update(
        &self,
        url: &str,
        images: &[PathBuf],
        mut look: impl FnMut(&Value, &mut Child) -> StepResult,
    ) -> Result<Updated, String> {
        let mut command = self.lafet(url);
        command.args(["--json", "--timeout", "0.5", "update", "--pace", "100"]);
        command.args(["--watch", self.watch]).args(images);
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
        let lines = lines_of(child.stdout.take());
        loop {
            let line = match lines.recv_timeout(SAYS) {
                Ok(line) => line,
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => {
                    run::end(&mut child);
                    let limit = SAYS.as_secs();
                    return Err(format!("lafet update says nothing for {limit} s: {updated:?}"));
                }
            };
            let line: Value = serde_json::from_str(&line).unwrap_or_default();
            updated.stages.extend(line["stage"].as_str().map(str::to_owned));
            looked = looked.and_then(|()| look(&line, &mut child));
        }
        updated.code = child.wait().map_err(failed)?.code();
        updated.said = said.and_then(|said| said.join().ok()).unwrap_or_default();
        looked.map(|()| updated)
    }

    /// The version and the slot that run, confirmed; the parameters and the lockout as they were.
    fn expect(&self, version: &str, slot: &str) -> StepResult {
        let state = self.value(&["update", "--state"])?;
        let is = (&state["version"], &state["slot"], &state["on_trial"]);
        if is != (&version.into(), &slot.into(), &false.into()) {
            return Err(format!("{version} in slot {slot}, confirmed, was awaited: {state}"));
        }
        let general = self.value(&["status", "general"])?;
        if !general.to_string().contains("LockedOut") {
            return Err(format!("the lockout is lost: {general}"));
        }
        let program = self.value(&["param", "get", "control", "Program3"])?;
        if program["values"][6] != 25 {
            return Err(format!("a parameter is lost: {program}"));
        }
        // Fails if there is a difference.
        self.value(&["param", "diff", &self.params()])?;
        println!("   {version} in slot {slot}, locked out, with its parameters");
        Ok(())
    }

    /// All parameters as they were at first.
    fn params(&self) -> String {
        self.folder.join("params.toml").display().to_string()
    }

    fn value(&self, words: &[&str]) -> Result<Value, String> {
        let printed = output(self.lafet(&self.url).arg("--json").args(words))?;
        serde_json::from_str(printed.trim()).map_err(|e| format!("{words:?}: {e}: {printed}"))
    }

    /// In standby: right after its start a monitor does not know yet that everything is closed.
    fn wrapped(&self) -> StepResult {
        let end = Instant::now() + SENSES;
        loop {
            match self.done(&["wrap"]) {
                Err(_) if Instant::now() < end => thread::park_timeout(Duration::from_secs(1)),
                result => return result,
            }
        }
    }

    fn done(&self, words: &[&str]) -> StepResult {
        output(self.lafet(&self.url).args(words)).map(|_| ())
    }

    fn lafet(&self, url: &str) -> Command {
        let mut command = self.lafet_alone();
        command.args(["-c", url]);
        command
    }

    /// `lafet` in English, apart from what the user of this task has noted.
    fn lafet_alone(&self) -> Command {
        let mut command = Command::new(&self.lafet);
        for name in ["LAFET_CONNECT", "LC_ALL", "LC_MESSAGES", "LANG"] {
            command.env_remove(name);
        }
        command.env("XDG_STATE_HOME", self.folder.join("state"));
        command.args(["--lang", "en"]);
        command
    }
}

/// The bootloader with these features, in a file of its own: all of them are built with one name.
fn bootloader(features: &[&str], file: &Path) -> Result<PathBuf, String> {
    let built = images::boot_program(features)?;
    std::fs::copy(built, file).map_err(|e| format!("{}: {e}", file.display()))?;
    Ok(file.into())
}

/// The lines of a program's output, as they come.
fn lines_of(output: Option<ChildStdout>) -> Receiver<String> {
    let (said, lines) = mpsc::channel();
    thread::spawn(move || {
        let all = output.into_iter().flat_map(|it| BufReader::new(it).lines());
        for line in all.map_while(Result::ok) {
            if said.send(line).is_err() {
                break;
            }
        }
    });
    lines
}

/// How many bytes the line has spoiled; fails if that is no noise. The port of the chip takes one connection: it is
/// given back.
fn noise(cable: Relay) -> Result<u64, String> {
    let spoiled = cable.spoiled();
    println!("   over a line that has spoiled {spoiled} bytes");
    match spoiled {
        NOISE.. => Ok(spoiled),
        _ => Err(format!("the line has spoiled {spoiled} bytes: that is no noise")),
    }
}

/// A place where nothing listens now.
fn free_place() -> std::io::Result<SocketAddr> {
    TcpListener::bind("127.0.0.1:0")?.local_addr()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mishaps_come_once_and_in_order() {
        let left = Course(Cell::new(SHORT));
        let sent = |done: u64| json!({ "stage": "sending", "done": done, "size": 1000 });
        assert_eq!(left.next(&json!({ "stage": "sending", "done": null, "size": null })), None);
        assert_eq!(left.next(&sent(199)), None);
        // One at a time, however far it is.
        assert_eq!(left.next(&sent(900)), Some(Mishap::Cable));
        assert_eq!(left.next(&sent(499)), None);
        assert_eq!(left.next(&sent(500)), Some(Mishap::Power));
        assert!(!left.is_over());
        assert_eq!(left.next(&sent(1000)), Some(Mishap::Sender));
        assert!(left.is_over());
        assert_eq!(left.next(&sent(1000)), None);
        let stages = Course(Cell::new(&[(At::Stage("verifying"), Mishap::Cable)]));
        assert_eq!(stages.next(&sent(1000)), None);
        assert_eq!(stages.next(&json!({ "stage": "verifying" })), Some(Mishap::Cable));
    }
}
