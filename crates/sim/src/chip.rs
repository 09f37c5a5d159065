//! A monitor's program on an emulated chip: QEMU runs the firmware, the world of the simulator is its
//! plant.
//!
//! The chip's line is a character device of QEMU; the plant goes through a socket of its own. The
//! plant sets the pace: one step of the monitor for each [`Chip::tick`], on virtual time.

mod program;

use std::io::{self, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::Child;
use std::time::{Duration, Instant};

use lafet_device::Composition;
use lafet_device::hal::Hal;
use lafet_device::image::{Inputs, Outputs};
use lafet_plant::{Decoder, Failure, GAUGE, Order, Report, WIRE_MAX};

pub use lafet_plant::flash::BOARD;
pub use program::Program;

use crate::sim::Config;
use crate::world::{STEP_MS, World};

/// The emulator.
pub const QEMU: &str = "qemu-system-arm";
/// The file of the flash, in the emulator's folder.
const FLASH: &str = "flash.bin";
/// What takes longer does not come any more: the watchdog needs four seconds, a bootloader that verifies what it
/// starts some more.
const PATIENCE: Duration = Duration::from_secs(30);
/// How often it is looked whether the emulator still runs.
const LOOK: Duration = Duration::from_millis(10);
/// What the emulator says, in its folder.
const LOG: &str = "qemu.log";

/// Where the chip's line ends.
#[derive(Clone, Debug)]
pub enum Line {
    /// At a TCP port on which QEMU listens.
    Tcp {
        /// Address.
        host: String,
        /// Port.
        port: u16,
    },
    /// At the other end of a socket, for who runs the chip.
    Here,
}

/// What a step has come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stepped {
    /// The monitor has driven this.
    Driven(Outputs),
    /// The program was reset, and has started again.
    Reset {
        /// By its watchdog or a fault.
        after_fault: bool,
    },
}

/// Instructions that the program has executed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Taken {
    /// In steps.
    pub steps: u32,
    /// From a request's bytes to those of its answer.
    pub answers: u32,
}

/// A running chip with its plant.
#[derive(Debug)]
pub struct Chip {
    /// Ends with this.
    _emulator: Emulator,
    plant: UnixStream,
    line: Option<UnixStream>,
    decoder: Decoder,
    world: World,
    composition: u8,
    address: u8,
    clock_ms: u32,
    booted_ms: u64,
    /// The program is so far ahead of the world.
    ahead_ms: u64,
    resets: u32,
}

/// QEMU, for as long as this lives.
#[derive(Debug)]
struct Emulator {
    child: Child,
    /// What it has said.
    log: PathBuf,
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Emulator {
    /// The line that it opens, unless it ends before, or does nothing.
    fn accept(&mut self, listener: &UnixListener) -> io::Result<UnixStream> {
        listener.set_nonblocking(true)?;
        let end = Instant::now() + PATIENCE;
        loop {
            match listener.accept() {
                Ok((stream, _)) => {
                    stream.set_nonblocking(false)?;
                    stream.set_read_timeout(Some(PATIENCE))?;
                    return Ok(stream);
                }
                Err(error) if error.kind() != io::ErrorKind::WouldBlock => return Err(error),
                Err(_) => {}
            }
            if let Some(status) = self.child.try_wait()? {
                let said = std::fs::read_to_string(&self.log).unwrap_or_default();
                return Err(io::Error::other(format!("{QEMU} ended ({status}): {}", said.trim())));
            }
            if Instant::now() > end {
                let why = format!("{QEMU} has opened no line in {} s", PATIENCE.as_secs());
                return Err(io::Error::new(io::ErrorKind::TimedOut, why));
            }
            std::thread::park_timeout(LOOK);
        }
    }
}

impl Chip {
    /// Starts the program; its flash is `flash.bin` in `folder`, which is made when it is not there.
    pub fn start(
        program: Program<'_>,
        folder: &Path,
        config: &Config,
        line: &Line,
    ) -> io::Result<Self> {
        let composition = place_of(&config.composition)?;
        std::fs::create_dir_all(folder)?;
        let flash = folder.join(FLASH);
        if !flash.exists() {
            program.make_flash(&flash)?;
        }
        let is_new = program.is_new(&flash)?;
        let (plant_path, line_path) = (folder.join("plant"), folder.join("line"));
        let plant = listen(&plant_path)?;
        let here = matches!(line, Line::Here).then(|| listen(&line_path)).transpose()?;
        let child = program
            .emulator(folder, line)?
            .spawn()
            .map_err(|error| io::Error::new(error.kind(), format!("cannot run {QEMU}: {error}")))?;
        let mut emulator = Emulator { child, log: folder.join(LOG) };
        let plant = emulator.accept(&plant)?;
        let line = here.map(|line| emulator.accept(&line)).transpose()?;
        let mut chip = Self {
            _emulator: emulator,
            plant,
            line,
            decoder: Decoder::counting(),
            world: World::new(config.world()),
            composition,
            address: config.address,
            clock_ms: config.clock_ms,
            booted_ms: 0,
            ahead_ms: 0,
            resets: 0,
        };
        chip.started()?;
        if is_new {
            let order = Order::Provision { composition, address: config.address };
            chip.order(&order)?;
            chip.done()?;
        }
        chip.begin()?;
        Ok(chip)
    }

    /// The world around it.
    pub const fn world(&self) -> &World {
        &self.world
    }

    /// The world around it: fires to light, buttons to press, faults to inject.
    pub const fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// How often the program has started again.
    pub const fn resets(&self) -> u32 {
        self.resets
    }

    /// The monitor's clock, ms.
    pub fn clock_ms(&self) -> u32 {
        let since_ms = self.world.now_ms() + self.ahead_ms - self.booted_ms;
        self.clock_ms.wrapping_add(since_ms as u32)
    }

    /// What the monitor senses now.
    pub fn inputs(&mut self) -> Inputs {
        let mut inputs = Inputs::default();
        self.world.read(&mut inputs);
        inputs
    }

    /// One step of a millisecond, as a board makes them; the world moves with each tenth.
    pub fn tick_ms(&mut self) -> io::Result<Stepped> {
        self.ahead_ms = (self.ahead_ms + 1) % STEP_MS;
        if self.ahead_ms == 0 {
            self.world.advance(STEP_MS);
        }
        self.turn()
    }

    /// One step of 10 ms.
    pub fn tick(&mut self) -> io::Result<Stepped> {
        self.world.advance(STEP_MS);
        self.turn()
    }

    fn turn(&mut self) -> io::Result<Stepped> {
        let (now_ms, inputs) = (self.clock_ms(), self.inputs());
        self.order(&Order::Step { now_ms, inputs: &inputs })?;
        let mut driven = Outputs::default();
        loop {
            match self.report()? {
                Report::Driven(outputs) => {
                    self.world.drive(outputs);
                    driven = outputs;
                }
                Report::Done => return Ok(Stepped::Driven(driven)),
                Report::Started { after_fault } => return self.begin_anew(after_fault),
                other => return Err(unexpected(&other)),
            }
        }
    }

    /// Lets the program fail, and waits until it has started again.
    pub fn fail(&mut self, failure: Failure) -> io::Result<Stepped> {
        self.order(&Order::Fail(failure))?;
        match self.report()? {
            Report::Started { after_fault } => self.begin_anew(after_fault),
            other => Err(unexpected(&other)),
        }
    }

    /// Bytes of the stack that the program has used since it began.
    pub fn stack_used(&mut self) -> io::Result<u32> {
        self.order(&Order::MeasureStack)?;
        match self.report()? {
            Report::Stack(bytes) => Ok(bytes),
            other => Err(unexpected(&other)),
        }
    }

    /// Instructions since this was asked last, without those of the board.
    pub fn taken(&mut self) -> io::Result<Taken> {
        self.order(&Order::MeasureTime)?;
        match self.report()? {
            Report::Time { steps, answers, gauge } => {
                let instructions = |ticks: u32| {
                    (u64::from(ticks) * u64::from(GAUGE) / u64::from(gauge.max(1))) as u32
                };
                Ok(Taken { steps: instructions(steps), answers: instructions(answers) })
            }
            other => Err(unexpected(&other)),
        }
    }

    /// Sends bytes over the line of [`Line::Here`], and reads until this many have come back.
    pub fn ask(&mut self, bytes: &[u8], answer: &mut [u8]) -> io::Result<()> {
        let line = self.line.as_mut().ok_or_else(|| io::Error::other("the line ends elsewhere"))?;
        line.write_all(bytes)?;
        line.read_exact(answer)
    }

    fn begin_anew(&mut self, after_fault: bool) -> io::Result<Stepped> {
        // With the reset every output has fallen to rest.
        self.world.drive(Outputs::default());
        (self.booted_ms, self.ahead_ms) = (self.world.now_ms(), 0);
        self.resets += 1;
        self.begin()?;
        Ok(Stepped::Reset { after_fault })
    }

    fn begin(&mut self) -> io::Result<()> {
        let (composition, address) = (self.composition, self.address);
        self.order(&Order::Start { now_ms: self.clock_ms, composition, address })?;
        self.done()
    }

    fn started(&mut self) -> io::Result<()> {
        match self.report()? {
            Report::Started { .. } => Ok(()),
            other => Err(unexpected(&other)),
        }
    }

    fn done(&mut self) -> io::Result<()> {
        match self.report()? {
            Report::Done => Ok(()),
            other => Err(unexpected(&other)),
        }
    }

    fn order(&mut self, order: &Order<&Inputs>) -> io::Result<()> {
        let mut wire = [0; WIRE_MAX];
        let len = order.encode(&mut wire).ok_or_else(|| io::Error::other("too long an order"))?;
        self.plant.write_all(&wire[..len])
    }

    fn report(&mut self) -> io::Result<Report> {
        let mut byte = [0];
        loop {
            self.plant.read_exact(&mut byte).map_err(|error| {
                io::Error::new(error.kind(), format!("the chip does not answer: {error}"))
            })?;
            if let (_, Some(frame)) = self.decoder.push_slice(&byte) {
                return Report::decode(frame.payload)
                    .map_err(|_| io::Error::other("the chip reports something unknown"));
            }
        }
    }
}

fn place_of(composition: &Composition) -> io::Result<u8> {
    Composition::ALL
        .iter()
        .position(|known| known == composition)
        .map(|place| place as u8)
        .ok_or_else(|| io::Error::other("the firmware has the shipped compositions only"))
}

fn listen(path: &PathBuf) -> io::Result<UnixListener> {
    if path.exists() {
        std::fs::remove_file(path)?;
    }
    UnixListener::bind(path)
}

fn unexpected(report: &Report) -> io::Error {
    io::Error::other(format!("the chip reports {report:?} out of turn"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    #[test]
    fn an_emulator_that_ends_is_told_with_what_it_has_said() {
        let folder = std::env::temp_dir().join(format!("lafet-chip-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let log = folder.join(LOG);
        let mut command = Command::new("sh");
        command.args(["-c", "echo no such kernel >&2; exit 3"]);
        command.stderr(std::fs::File::create(&log).unwrap());
        let mut emulator = Emulator { child: command.spawn().unwrap(), log };
        let listener = listen(&folder.join("plant")).unwrap();
        let said = emulator.accept(&listener).unwrap_err().to_string();
        assert!(said.contains("exit status: 3") && said.ends_with("no such kernel"), "{said}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
