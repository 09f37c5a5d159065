//! The emulated board, and its power.

use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, mpsc};
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
    /// A folder with an emulator of its own.
    pub tools: Option<PathBuf>,
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

    /// How often its program has started again since its power came.
    pub fn resets(&self) -> u32 {
        self.running.lines.load(Ordering::SeqCst).saturating_sub(1)
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
    /// What it has said: where it listens, then a line for each reset.
    lines: Arc<AtomicU32>,
}

impl Running {
    fn start(with: &Start) -> Result<Self, String> {
        let mut sim = Command::new(&with.lafet);
        sim.args(["--lang", "en", "sim", "--on", "qemu", "--speed", with.speed]);
        sim.arg("--boot").arg(&with.boot).arg("--firmware").arg(&with.first);
        sim.arg("--flash").arg(&with.flash);
        sim.args(["--listen", &format!("tcp://127.0.0.1:{}", with.port)]);
        if let Some(tools) = &with.tools {
            sim.env("PATH", in_front(tools)?);
        }
        let failed = |e: std::io::Error| format!("the board: {e}");
        let mut sim = sim.stdout(Stdio::piped()).spawn().map_err(failed)?;
        let (said, listens) = mpsc::channel();
        let (output, lines) = (sim.stdout.take(), Arc::new(AtomicU32::new(0)));
        let counted = lines.clone();
        thread::spawn(move || {
            for line in output.into_iter().flat_map(|it| BufReader::new(it).lines()) {
                let Ok(line) = line else { break };
                println!("   board: {line}");
                counted.fetch_add(1, Ordering::SeqCst);
                // After the first line nothing waits.
                let _ = said.send(());
            }
        });
        let mut running = Self { sim, qemu: 0, lines };
        listens.recv_timeout(LISTENS).map_err(|_| "the board does not start".to_owned())?;
        running.qemu = child_of(running.sim.id()).ok_or("the board has no emulator")?;
        runs(running.qemu, &with.boot)?;
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

/// `PATH` with this folder in front of all others.
fn in_front(folder: &Path) -> Result<OsString, String> {
    let others = std::env::var_os("PATH").unwrap_or_default();
    let all = std::iter::once(folder.to_owned()).chain(std::env::split_paths(&others));
    std::env::join_paths(all).map_err(|e| format!("{}: {e}", folder.display()))
}

/// Fails if the emulator was started with another bootloader than this one.
fn runs(qemu: u32, boot: &Path) -> StepResult {
    let failed = |e: std::io::Error| format!("{}: {e}", boot.display());
    let boot_real = std::fs::canonicalize(boot).map_err(failed)?;
    let line = std::fs::read(format!("/proc/{qemu}/cmdline")).map_err(failed)?;
    let words: Vec<_> = line.split(|byte| *byte == 0).map(String::from_utf8_lossy).collect();
    let kernel = words.windows(2).find(|pair| pair[0] == "-kernel").map(|pair| &pair[1]);
    match kernel {
        Some(kernel) if Path::new(kernel.as_ref()) == boot_real => Ok(()),
        other => Err(format!("the board runs {other:?}, not {}", boot_real.display())),
    }
}
