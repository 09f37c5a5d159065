//! The emulated board, and its power.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use crate::run::{self, StepResult, output};

/// The board listens within this time: its bootloader verifies two images at most.
const LISTENS: Duration = Duration::from_secs(60);

/// What a board is started with.
#[derive(Clone)]
pub struct Start {
    pub lafet: PathBuf,
    pub boot: PathBuf,
    /// What is in slot A while the flash is new.
    pub first: PathBuf,
    pub flash: PathBuf,
    pub port: u16,
    /// Seconds of the plant in one of real time.
    pub speed: &'static str,
}

/// The board, for as long as this lives.
pub struct Board {
    with: Start,
    running: Running,
}

impl Board {
    /// Starts it, and waits until it listens.
    pub fn start(with: Start) -> Result<Self, String> {
        let running = Running::start(&with)?;
        Ok(Self { with, running })
    }

    /// Its power is gone at once, whatever it is at, and comes back.
    pub fn cut_power(&mut self) -> StepResult {
        self.running.kill()?;
        self.running = Running::start(&self.with)?;
        Ok(())
    }
}

struct Running {
    sim: Child,
    qemu: u32,
}

impl Running {
    fn start(with: &Start) -> Result<Self, String> {
        let mut sim = Command::new(&with.lafet);
        sim.args(["--lang", "en", "sim", "--on", "qemu", "--speed", with.speed]);
        sim.arg("--boot").arg(&with.boot).arg("--firmware").arg(&with.first);
        sim.arg("--flash").arg(&with.flash);
        sim.args(["--listen", &format!("tcp://127.0.0.1:{}", with.port)]);
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
        let mut running = Self { sim, qemu: 0 };
        listens.recv_timeout(LISTENS).map_err(|_| "the board does not start".to_owned())?;
        running.qemu = child_of(running.sim.id()).ok_or("the board has no emulator")?;
        Ok(running)
    }

    fn kill(&mut self) -> StepResult {
        output(Command::new("kill").args(["-KILL", &self.qemu.to_string()]))?;
        // It has lost its chip.
        self.sim.wait().map(|_| ()).map_err(|e| format!("the board: {e}"))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if self.sim.try_wait().is_ok_and(|ended| ended.is_some()) {
            return;
        }
        run::end(&mut self.sim);
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
