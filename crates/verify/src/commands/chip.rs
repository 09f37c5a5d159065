//! Compares a firmware on the emulated chip with the same monitor on the host: every answer byte for
//! byte, every output; and what is left of a fault: `cargo xtask firmware test`.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use lafet_device::guard::Passed;
use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::{Inputs, Outputs};
use lafet_device::port::Port;
use lafet_device::{Composition, Device, Source};
use lafet_plant::Failure;
use lafet_proto::crash::Context;
use lafet_proto::link::{self, Frame, WIRE_MAX};
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::status::{FaultArch, FaultInfo};
use lafet_proto::{Request, SubsystemId, record};
use lafet_sim::chip::{Chip, Line, Program, Stepped};
use lafet_sim::rng::Rng;
use lafet_sim::sim::Config;
use lafet_verify::swarm::frame;

const ADDRESS: u8 = 1;
const PEER: u8 = 129;
const WATCHDOG_IRQ: u16 = 18;
const FLASH: core::ops::Range<u32> = 0x400..0x4_0000;

#[derive(Args)]
pub struct Plan {
    /// The program, an ELF file
    firmware: PathBuf,
    /// Steps of each seed
    #[arg(long, default_value_t = 3_000)]
    steps: u64,
    /// How many monitors
    #[arg(long, default_value_t = 5)]
    seeds: u64,
    /// Most bytes of stack, as the page says
    #[arg(long, value_name = "BYTES", default_value_t = u64::MAX, hide_default_value = true)]
    stack: u64,
}

/// Runs the plan.
pub fn run(plan: &Plan) -> Result<(), String> {
    plan.run().map_err(|error| error.to_string())
}

impl Plan {
    fn run(&self) -> io::Result<()> {
        let folder = std::env::temp_dir().join(format!("lafet-chip-{}", std::process::id()));
        let result = self.run_in(&folder);
        // The results are known; files that stay do no harm.
        let _ = std::fs::remove_dir_all(&folder);
        result
    }

    fn run_in(&self, folder: &Path) -> io::Result<()> {
        for seed in 0..self.seeds {
            let pair = Pair::start(&self.firmware, &folder.join(seed.to_string()), seed)?;
            let Figures { frames, bytes, resets, stack } = pair.live(self.steps, seed)?;
            println!(
                "seed {seed}: {} steps, {frames} frames, {bytes} bytes of answers the same, \
                 {resets} resets, stack {stack} bytes",
                self.steps
            );
            if u64::from(stack) > self.stack {
                let most = self.stack;
                let why = format!("{stack} bytes of stack used, and docs/footprint.md says {most}");
                return Err(io::Error::other(why));
            }
        }
        for failure in [Failure::Astray, Failure::UndefinedInstruction, Failure::Hang] {
            let mut pair = Pair::start(&self.firmware, &folder.join(format!("{failure:?}")), 0)?;
            pair.fail(failure)?;
        }
        Ok(())
    }
}

#[derive(Default)]
struct Figures {
    frames: u64,
    bytes: u64,
    resets: u64,
    stack: u32,
}

/// The chip, and the same monitor on the host.
struct Pair {
    chip: Chip,
    twin: Twin,
}

impl Pair {
    fn start(firmware: &Path, folder: &Path, seed: u64) -> io::Result<Self> {
        let composition = Composition::ALL[seed as usize % Composition::ALL.len()];
        let config = Config {
            seed,
            composition,
            address: ADDRESS,
            clock_ms: u32::MAX - 5_000,
            ..Config::default()
        };
        let chip = Chip::start(Program::Fixed(firmware), folder, &config, &Line::Here)?;
        let twin = Twin::new(composition, config.clock_ms);
        Ok(Self { chip, twin })
    }

    fn live(mut self, steps: u64, seed: u64) -> io::Result<Figures> {
        let mut rng = Rng::new(seed);
        let mut figures = Figures::default();
        for step in 0..steps {
            if step % 7 == 0 {
                let payload = frame(&mut rng);
                figures.bytes += self.ask(&payload, step)?.len() as u64;
                figures.frames += 1;
            }
            if self.step(step)? {
                figures.resets += 1;
            }
        }
        figures.stack = self.chip.stack_used()?;
        Ok(figures)
    }

    /// One step of both; whether it was a reset.
    fn step(&mut self, step: u64) -> io::Result<bool> {
        let stepped = self.chip.tick()?;
        // What the chip has sensed is what the world senses until its next step.
        let inputs = self.chip.inputs();
        let now_ms = self.twin.now_ms.wrapping_add(10);
        let outputs = self.twin.step(now_ms, inputs);
        match (stepped, outputs) {
            (Stepped::Driven(chip), Some(host)) if chip == host => Ok(false),
            (Stepped::Reset { after_fault: false }, None) => Ok(true),
            (chip, host) => Err(differ(step, "drives", format!("{chip:?}"), format!("{host:?}"))),
        }
    }

    /// The answer of both.
    fn ask(&mut self, payload: &[u8], step: u64) -> io::Result<Vec<u8>> {
        let mut wire = [0; WIRE_MAX];
        let len = link::encode(&Frame { dst: ADDRESS, src: PEER, payload }, &mut wire)
            .ok_or_else(|| io::Error::other("too long a frame"))?;
        let host = self.twin.receive(&wire[..len]);
        let mut chip = vec![0; host.len()];
        self.chip.ask(&wire[..len], &mut chip)?;
        if chip == host { Ok(chip) } else { Err(differ(step, "answers", hex(&chip), hex(&host))) }
    }

    /// Lets the chip fail and looks at what it has recorded.
    fn fail(&mut self, failure: Failure) -> io::Result<()> {
        for step in 0..20 {
            self.step(step)?;
        }
        let stepped = self.chip.fail(failure)?;
        let info = self.crash_data()?;
        let [_, _, _, _, hfsr, _, _, cfsr, ..] = match info.arch {
            FaultArch::CortexM3(words) => words,
            _ => return Err(io::Error::other("not a Cortex-M3's record")),
        };
        println!("{failure:?}: {stepped:?}, pc {:#x}, hfsr {hfsr:#x}, cfsr {cfsr:#x}", info.pc);
        let caused = match failure {
            // IACCVIOL and UNDEFINSTR, forced to a HardFault both.
            Failure::Astray => cfsr == 1 && hfsr == 1 << 30 && info.pc == 0x4000_C000,
            Failure::UndefinedInstruction => cfsr == 1 << 16 && hfsr == 1 << 30,
            Failure::Hang => cfsr == 0 && hfsr == 0,
        };
        // A fault says what it interrupted; the watchdog's first call, which has no handler, itself.
        let context = match failure {
            Failure::Astray | Failure::UndefinedInstruction => Context::Program,
            Failure::Hang => Context::Interrupt(WATCHDOG_IRQ),
        };
        let in_flash = FLASH.contains(&info.lr) && info.spcr != 0;
        let again = stepped == Stepped::Reset { after_fault: true };
        if caused && info.context() == context && again && in_flash && info.signature != 0 {
            return Ok(());
        }
        Err(io::Error::other(format!("{failure:?} has left {info:?}")))
    }

    fn crash_data(&mut self) -> io::Result<FaultInfo> {
        let mut payload = [0; 8];
        let mut writer = record::Writer::new(&mut payload);
        let request = Request::new(SubsystemId::GENERAL, Body::GetCrashData);
        request.encode(&mut writer).map_err(|_| io::Error::other("too small a buffer"))?;
        let mut wire = [0; WIRE_MAX];
        let frame = Frame { dst: ADDRESS, src: PEER, payload: writer.written() };
        let len = link::encode(&frame, &mut wire).unwrap_or_default();
        let mut decoder: link::Decoder = link::Decoder::new();
        let mut byte = [0];
        self.chip.ask(&wire[..len], &mut byte)?;
        loop {
            if let (_, Some(frame)) = decoder.push_slice(&byte) {
                let record = Records::new(frame.payload).next();
                let data = record.and_then(Result::ok).map(|record| record.data);
                return data
                    .and_then(FaultInfo::decode)
                    .ok_or_else(|| io::Error::other("no crash data in the answer"));
            }
            self.chip.ask(&[], &mut byte)?;
        }
    }
}

fn differ(step: u64, what: &str, chip: String, host: String) -> io::Error {
    io::Error::other(format!("step {step}: the chip {what}\n  {chip}\nthe host\n  {host}"))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x} ")).collect()
}

/// The monitor on the host.
struct Twin {
    device: Device,
    board: Board,
    port: Port,
    composition: Composition,
    clock_ms: u32,
    now_ms: u32,
}

impl Twin {
    fn new(composition: Composition, clock_ms: u32) -> Self {
        let mut board = Board::default();
        Device::provision(&mut board, &composition, ADDRESS).expect("the memory takes all");
        let device = Device::power_up(clock_ms, &composition, ADDRESS, None, &mut board);
        let port = Port::new(Source::ExternalConn);
        Self { device, board, port, composition, clock_ms, now_ms: clock_ms }
    }

    /// What it drives; `None` after a reset.
    fn step(&mut self, now_ms: u32, inputs: Inputs) -> Option<Outputs> {
        self.now_ms = now_ms;
        self.board.inputs = inputs;
        self.device.step(now_ms, &mut self.board);
        if !core::mem::take(&mut self.board.reset) {
            return Some(self.board.outputs);
        }
        let Self { device, board, composition, clock_ms, .. } = self;
        // The emulated chip senses with its first step, not before.
        board.inputs = Inputs::default();
        *device = Device::power_up(*clock_ms, composition, ADDRESS, None, board);
        self.port = Port::new(Source::ExternalConn);
        self.now_ms = self.clock_ms;
        None
    }

    fn receive(&mut self, mut bytes: &[u8]) -> Vec<u8> {
        let mut answers = Vec::new();
        while !bytes.is_empty() {
            let mut out = [0; WIRE_MAX];
            let (taken, len) = self.port.receive(self.now_ms, &mut self.device, bytes, &mut out);
            answers.extend_from_slice(&out[..len]);
            bytes = &bytes[taken..];
        }
        answers
    }
}

#[derive(Default)]
struct Board {
    inputs: Inputs,
    outputs: Outputs,
    memory: BTreeMap<u16, Vec<u8>>,
    reset: bool,
}

impl Hal for Board {
    fn read(&mut self, inputs: &mut Inputs) {
        inputs.clone_from(&self.inputs);
    }

    fn write(&mut self, outputs: &Passed) {
        self.outputs = **outputs;
    }

    fn reset(&mut self) {
        self.reset = true;
    }
}

impl Storage for Board {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        let Some(value) = self.memory.get(&key.0) else { return Ok(None) };
        let place = buffer.get_mut(..value.len()).ok_or(StorageError::Read)?;
        place.copy_from_slice(value);
        Ok(Some(place))
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        self.memory.insert(key.0, value.to_vec());
        Ok(())
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.memory.clear();
        Ok(())
    }
}
