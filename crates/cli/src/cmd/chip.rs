//! `lafet sim --on qemu`: the firmware on an emulated chip, connected to a simulated plant.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use lafet_client::update::Image;
use lafet_sim::chip::{Chip, Line, Program, Stepped};
use lafet_sim::sim::Config;
use lafet_sim::world::STEP_MS;
use lafet_texts::{Shown, Text as _, cli as text};
use tokio::time::{Instant, sleep_until};

use crate::cmd::image;
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::lang::current;
use crate::out::Out;
use crate::serve::Listen;

/// Settings of an emulated monitor.
pub struct Running<'a> {
    /// The firmware: an ELF file for the board lm3s6965evb, or, with a bootloader, an image for slot A of
    /// the board mps2.
    pub firmware: &'a Path,
    /// The bootloader of the board mps2, an ELF file.
    pub boot: Option<&'a Path>,
    /// File that keeps its flash memory; without one, each run starts with a new monitor.
    pub flash: Option<&'a Path>,
    /// Where QEMU listens; exactly one TCP address.
    pub listen: &'a [Listen],
    /// The simulated plant.
    pub config: Config,
    /// Simulated seconds per second of real time.
    pub speed: f64,
}

/// Runs until a signal arrives or the chip fails.
pub async fn serve(running: Running<'_>, out: &mut Out) -> Outcome {
    let mut interrupt = Interrupt::catch()?;
    let line = line(running.listen)?;
    let first = running.boot.map(|_| first_image(running.firmware)).transpose()?;
    let program = match (running.boot, &first) {
        (Some(boot), Some(first)) => Program::InSlots { boot, first },
        _ => Program::Fixed(running.firmware),
    };
    let folder = Folder::new(running.flash, program).map_err(failed)?;
    let chip = Chip::start(program, &folder.0, &running.config, &line).map_err(failed)?;
    let Line::Tcp { host, port } = &line else { return Ok(()) };
    out.show(
        format!("listening tcp://{host}:{port}"),
        || serde_json::json!({ "listening": format!("tcp://{host}:{port}") }),
    )?;
    let chip = Arc::new(Mutex::new(chip));
    tokio::select! {
        () = interrupt.wait() => Ok(()),
        ended = pace(chip, running.speed, out) => ended,
    }
}

/// The image that a programmer would put into slot A of a new board.
fn first_image(file: &Path) -> Result<Vec<u8>, Failure> {
    let bytes = image::read(file)?;
    let shown = || Shown(file.display());
    let image = Image::read(&bytes).map_err(|error| {
        Failure::Usage(format!("{}: {}", file.display(), error.localized(current())))
    })?;
    let board = lafet_sim::chip::BOARD;
    if image.board() != board || image.slot() == Some(2) {
        return Err(Failure::Usage(text::ChipFirstImage { file: shown(), board }.of(current())));
    }
    Ok(bytes)
}

/// Lag that is caught up after a busy moment, so that the monitor's clock does not fall behind; a
/// longer pause, such as suspending the computer, is skipped.
const LATE_MAX: Duration = Duration::from_secs(3);

/// Steps the chip in pace with real time, and reports its resets.
async fn pace(chip: Arc<Mutex<Chip>>, speed: f64, out: &mut Out) -> Outcome {
    let period = Duration::from_secs_f64(STEP_MS as f64 / 1000.0 / speed);
    let mut due = Instant::now();
    loop {
        sleep_until(due).await;
        let now = Instant::now();
        due = due.max(now.checked_sub(LATE_MAX).unwrap_or(now)) + period;
        let chip = chip.clone();
        // Waiting for the emulator blocks, so it must not hold up the other tasks.
        let stepped = tokio::task::spawn_blocking(move || {
            chip.lock().unwrap_or_else(PoisonError::into_inner).tick()
        });
        let stepped = stepped.await.map_err(|error| failed(io::Error::other(error)))?;
        match stepped.map_err(failed)? {
            Stepped::Driven(_) => {}
            Stepped::Reset { after_fault: false } => {
                out.say(text::ChipReset.str(current()))?;
            }
            Stepped::Reset { after_fault: true } => out.say(text::ChipCrashed.str(current()))?,
        }
    }
}

fn line(listen: &[Listen]) -> Result<Line, Failure> {
    let default = format!("127.0.0.1:{}", lafet_proto::bus::PORT_EXTERNAL_CONN);
    let place = match listen {
        [] => Some(default.as_str()),
        [one] => one.tcp_place(),
        _ => None,
    };
    let parts = place.and_then(|place| place.rsplit_once(':'));
    let port = parts.and_then(|(_, port)| port.parse().ok()).filter(|port| *port != 0);
    match (parts, port) {
        (Some((host, _)), Some(port)) => Ok(Line::Tcp { host: host.into(), port }),
        _ => Err(Failure::Usage(text::ChipOneAddress.of(current()))),
    }
}

/// Working folder of the emulator; removed on drop.
struct Folder(PathBuf);

impl Folder {
    fn new(flash: Option<&Path>, program: Program<'_>) -> io::Result<Self> {
        let path = std::env::temp_dir().join(format!("lafet-sim-{}", std::process::id()));
        std::fs::create_dir_all(&path)?;
        let folder = Self(path);
        if let Some(flash) = flash {
            if !flash.exists() {
                program.make_flash(flash)?;
            }
            let kept = std::path::absolute(flash)?;
            std::os::unix::fs::symlink(kept, folder.0.join("flash.bin"))?;
        }
        Ok(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder that cannot be removed is a nuisance, not an error.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn failed(error: io::Error) -> Failure {
    Failure::io(text::EmulatedChip.str(current()), error)
}
