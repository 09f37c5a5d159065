//! `lafet sim --on qemu`: the firmware on an emulated chip, in a simulated plant.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use lafet_sim::chip::{Chip, Line, Stepped};
use lafet_sim::sim::Config;
use lafet_sim::world::STEP_MS;
use tokio::time::{Instant, sleep_until};

use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::lang::pick;
use crate::out::Out;
use crate::serve::Listen;

/// What is to run, and where.
pub struct Running<'a> {
    /// The program, an ELF file for the board lm3s6965evb.
    pub firmware: &'a Path,
    /// Its memory; without one it is a new monitor each time.
    pub flash: Option<&'a Path>,
    /// Where QEMU listens.
    pub listen: &'a [Listen],
    /// The plant.
    pub config: Config,
    /// How fast.
    pub speed: f64,
}

/// Serves until a signal, or until the chip fails.
pub async fn serve(running: Running<'_>, out: &mut Out) -> Outcome {
    let mut interrupt = Interrupt::catch()?;
    let line = line(running.listen)?;
    let folder = Folder::new(running.flash).map_err(failed)?;
    let chip = Chip::start(running.firmware, &folder.0, &running.config, &line).map_err(failed)?;
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

/// What a busy machine has held up is made up for, so that the monitor's clock does not fall behind; after
/// a longer pause, as of the whole computer, it goes on from there.
const LATE_MAX: Duration = Duration::from_secs(3);

/// Steps as many as real time has had, and tells of resets.
async fn pace(chip: Arc<Mutex<Chip>>, speed: f64, out: &mut Out) -> Outcome {
    let period = Duration::from_secs_f64(STEP_MS as f64 / 1000.0 / speed);
    let mut due = Instant::now();
    loop {
        sleep_until(due).await;
        let now = Instant::now();
        due = due.max(now.checked_sub(LATE_MAX).unwrap_or(now)) + period;
        let chip = chip.clone();
        // The emulator is waited for, which must hold up nobody else.
        let stepped = tokio::task::spawn_blocking(move || {
            chip.lock().unwrap_or_else(PoisonError::into_inner).tick()
        });
        let stepped = stepped.await.map_err(|error| failed(io::Error::other(error)))?;
        match stepped.map_err(failed)? {
            Stepped::Driven(_) => {}
            Stepped::Reset { after_fault: false } => {
                out.say(pick("the program was reset", "программа перезапущена"))?;
            }
            Stepped::Reset { after_fault: true } => out.say(pick(
                "the program has failed and begun anew; `lafet crash` tells what it has recorded",
                "отказ программы, она запущена снова; что записано, покажет `lafet crash`",
            ))?,
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
        _ => Err(Failure::Usage(pick(
            "With --on qemu there is one place to listen at: tcp://HOST:PORT, and not port 0."
                .into(),
            "С --on qemu слушать можно в одном месте: tcp://УЗЕЛ:ПОРТ, порт не 0.".into(),
        ))),
    }
}

/// Where the emulator works; removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(flash: Option<&Path>) -> io::Result<Self> {
        let path = std::env::temp_dir().join(format!("lafet-sim-{}", std::process::id()));
        std::fs::create_dir_all(&path)?;
        let folder = Self(path);
        if let Some(flash) = flash {
            if !flash.exists() {
                lafet_sim::chip::make_flash(flash)?;
            }
            let kept = std::path::absolute(flash)?;
            std::os::unix::fs::symlink(kept, folder.0.join("flash.bin"))?;
        }
        Ok(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder that stays is a nuisance, not an error.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn failed(error: io::Error) -> Failure {
    Failure::io(pick("the emulated chip", "эмулируемый контроллер"), error)
}
