//! Counts the instructions of the firmware's steps and answers on the emulated chip, while it puts out a
//! fire of the simulated plant: `cargo xtask firmware load`.

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use lafet_device::image::Outputs;
use lafet_proto::flags::DeployerFlags;
use lafet_proto::id::key;
use lafet_proto::link::{self, Frame, WIRE_MAX};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::{
    Body, Path as Way, Points, Quench, Sector, Seek, Trajectory, TrajectoryPoint,
};
use lafet_proto::{Ints, ParamId, Request, SubsystemId};
use lafet_sim::chip::{Chip, Line, Program, Stepped};
use lafet_sim::fire::FireSpec;
use lafet_sim::sim::Config;

const ADDRESS: u8 = 1;
const PEER: u8 = 129;
/// Steps of a millisecond that each state is looked at.
const STEPS: usize = 500;
/// Steps until something must have happened.
const PATIENCE: usize = 6_000;
/// Cycles of the processor for an instruction: of ours, mostly loads and stores, and with two wait states
/// of the flash between branches (assumed; QEMU does not count cycles).
const CYCLES: f64 = 1.5;
/// What an STM32F103 runs at, and how often a step is due there.
const CLOCK_HZ: f64 = 72e6;
const STEPS_PER_SECOND: f64 = 1000.0;
/// How often a controller asks for all states.
const POLLS_PER_SECOND: f64 = 10.0;
/// What a step may take while the processor keeps up, cycles: half of its millisecond.
const STEP_MAX: f64 = 36_000.0;
/// What the one behind a write to the flash may take, which makes up for it, cycles: with one of the others behind
/// it 2 ms, in which a Stop acts.
const LATE_MAX: f64 = 2.0 * CLOCK_HZ / 1000.0 - STEP_MAX;

#[derive(Args)]
pub struct Options {
    /// The program, an ELF file
    firmware: PathBuf,
}

/// What comes over the line between two steps: more than it carries at 115,200 baud.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Traffic {
    /// GetStatus All.
    Polls,
    /// Settings that are to be stored, and change the shot; and polls.
    Settings,
}

impl Traffic {
    fn at(self, step: usize) -> (SubsystemId, Body<'static>) {
        const HEIGHTS: [&[i32]; 2] = [&[149], &[150]];
        const LAGS: [&[i32]; 2] = [&[1], &[0]];
        let turn = step / 4 % 2;
        match (self, step % 4) {
            (Self::Settings, 0) => (SubsystemId::CONTROL, set("Height", HEIGHTS[turn])),
            (Self::Settings, 2) => (SubsystemId::HORIZONTAL, set("StopLag", LAGS[turn])),
            _ => (SubsystemId::ALL, Body::GetStatus),
        }
    }
}

fn set(name: &str, values: &'static [i32]) -> Body<'static> {
    Body::SetParam { id: ParamId::of(name), values: Ints::Values(values) }
}

/// Points to and fro in front of the fire, each at another distance, so that each takes a shot of its own.
const POINTS: [TrajectoryPoint; 4] = [
    TrajectoryPoint { horizontal: 1_700, vertical: -180, distance: 25, dwell: 0 },
    TrajectoryPoint { horizontal: 1_780, vertical: -150, distance: 28, dwell: 0 },
    TrajectoryPoint { horizontal: 1_860, vertical: -180, distance: 31, dwell: 0 },
    TrajectoryPoint { horizontal: 1_780, vertical: -120, distance: 34, dwell: 1 },
];
const TRAJECTORY: Body<'static> = Body::StartTrajectory(Trajectory {
    ballistics: true,
    repeat: true,
    path: Way::Points(Points::Values(&POINTS)),
});

/// Prints the counts of each state.
pub fn run(options: &Options) -> Result<(), String> {
    let folder = std::env::temp_dir().join(format!("lafet-load-{}", std::process::id()));
    let result = Bench::start(&options.firmware, &folder).and_then(Bench::run);
    // The results are known; files that stay do no harm.
    let _ = std::fs::remove_dir_all(&folder);
    result.map_err(|error| error.to_string())
}

/// What is wrong when a step takes more cycles than it may.
fn over(what: &str, instructions: u32, most: f64) -> Option<String> {
    let cycles = f64::from(instructions) * CYCLES;
    (cycles > most).then(|| format!("{what}: a step takes {cycles:.0} cycles, {most:.0} at most"))
}

fn verdict(problems: &[String]) -> io::Result<()> {
    if problems.is_empty() { Ok(()) } else { Err(io::Error::other(problems.join("; "))) }
}

/// Instructions of many of a kind.
#[derive(Default)]
struct Count {
    sum: u64,
    most: u32,
    number: u32,
}

impl Count {
    fn add(&mut self, instructions: u32) {
        self.sum += u64::from(instructions);
        self.most = self.most.max(instructions);
        self.number += 1;
    }

    fn mean(&self) -> f64 {
        self.sum as f64 / f64::from(self.number.max(1))
    }
}

struct Bench {
    chip: Chip,
    /// Of a processor that keeps up, instructions.
    longest: u32,
    problems: Vec<String>,
}

impl Bench {
    fn start(firmware: &Path, folder: &Path) -> io::Result<Self> {
        let fire = FireSpec { azimuth_deg: 30.0, range_m: 25.0, ..FireSpec::default() };
        let config = Config { address: ADDRESS, fires: vec![fire], ..Config::default() };
        let program = Program::Fixed(firmware);
        let chip = Chip::start(program, folder, &config, &Line::Here)?;
        Ok(Self { chip, longest: 0, problems: Vec::new() })
    }

    fn run(mut self) -> io::Result<()> {
        println!("| what | step, mean | step, at most | GetStatus All, at most | load at 1 kHz |");
        println!("|---|---:|---:|---:|---:|");
        let all = SubsystemId::ALL;
        self.ask(all, Body::GetStatus)?;
        self.chip.taken()?;
        self.look("wrapped, at rest", Traffic::Polls)?;
        self.order(SubsystemId::DEPLOYER, Body::Deploy)?;
        self.look("deploying", Traffic::Polls)?;
        self.until_deployed()?;
        self.order(SubsystemId::HORIZONTAL, Body::Move { destination: 1_500 })?;
        self.order(SubsystemId::VERTICAL, Body::Move { destination: 900 })?;
        self.look("two drives moving", Traffic::Polls)?;
        self.order(all, Body::Stop)?;
        let seek = Seek { start_h: 0, end_h: 3_600, start_v: -900, end_v: 900, analyse: 1 };
        self.order(SubsystemId::DETECTOR, Body::StartSeek(seek))?;
        self.look("searching", Traffic::Polls)?;
        self.order(all, Body::Stop)?;
        self.order(SubsystemId::VALVE1, Body::Open { key: key::OPEN })?;
        self.order(SubsystemId::CONTROL, TRAJECTORY)?;
        self.until("with water", |it| Ok(it.chip.world().landing().is_some()))?;
        self.look("along a trajectory, settings to be stored", Traffic::Settings)?;
        self.look_late("the same, each step 9 ms late")?;
        let sector = Sector {
            centre_h: 1_800,
            centre_v: -180,
            nozzle: 60,
            width: 300,
            height: 120,
            step: 1,
        };
        let quench = Quench::Full { sector, distance: 25 };
        self.order(SubsystemId::CONTROL, Body::StartQuench(quench))?;
        self.look("extinguishing, with ballistics", Traffic::Polls)?;
        self.until("out", |it| Ok(!it.chip.world().fires.iter().any(|fire| fire.burns())))?;
        let longest = f64::from(self.longest) * CYCLES;
        println!("the longest step: {longest:.0} cycles of {STEP_MAX:.0}");
        verdict(&self.problems)
    }

    fn until_deployed(&mut self) -> io::Result<()> {
        self.until("deployed", |it| {
            let status = it.ask(SubsystemId::DEPLOYER, Body::GetStatus)?;
            let flags = status.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
            Ok(DeployerFlags::from_bits_retain(flags).contains(DeployerFlags::DEPLOYED))
        })
    }

    /// Steps of a state, each with a request. One in which nothing is driven may write to the flash, for which
    /// the processor waits: it counts by itself.
    fn look(&mut self, what: &str, traffic: Traffic) -> io::Result<()> {
        let (mut steps, mut storing, mut answers) =
            (Count::default(), Count::default(), Count::default());
        // The orders that led here have taken steps of their own.
        self.chip.taken()?;
        for step in 0..STEPS {
            let outputs = driven(self.chip.tick_ms()?)?;
            let (to, body) = traffic.at(step);
            let stores = outputs.is_still() && traffic == Traffic::Settings;
            self.taken(to, body)?;
            let taken = self.chip.taken()?;
            let count = if stores { &mut storing } else { &mut steps };
            count.add(taken.steps);
            answers.add(taken.answers);
        }
        let per_second = steps.mean() * STEPS_PER_SECOND + answers.mean() * POLLS_PER_SECOND;
        println!(
            "| {what} | {:.0} | {} | {} | {:.1} % |",
            steps.mean(),
            steps.most,
            answers.most,
            100.0 * per_second * CYCLES / CLOCK_HZ
        );
        if storing.number > 0 {
            println!(
                "| {what}: at rest, and stored | {:.0} | {} | | |",
                storing.mean(),
                storing.most
            );
        }
        self.longest = self.longest.max(steps.most);
        self.problems.extend(over(what, steps.most, STEP_MAX));
        Ok(())
    }

    /// Steps that come late, as behind a write to the flash.
    fn look_late(&mut self, what: &str) -> io::Result<()> {
        let mut steps = Count::default();
        self.chip.taken()?;
        for _ in 0..STEPS {
            driven(self.chip.tick()?)?;
            self.ask(SubsystemId::ALL, Body::GetStatus)?;
            steps.add(self.chip.taken()?.steps);
        }
        println!("| {what} | {:.0} | {} | | |", steps.mean(), steps.most);
        self.problems.extend(over(what, steps.most, LATE_MAX));
        Ok(())
    }

    fn until(
        &mut self,
        what: &str,
        mut holds: impl FnMut(&mut Self) -> io::Result<bool>,
    ) -> io::Result<()> {
        for _ in 0..PATIENCE {
            if holds(self)? {
                self.chip.taken()?;
                return Ok(());
            }
            self.step()?;
        }
        Err(io::Error::other(format!("not {what} in {PATIENCE} steps")))
    }

    fn step(&mut self) -> io::Result<()> {
        driven(self.chip.tick()?).map(|_| ())
    }

    /// A request that must be taken, and a step.
    fn order(&mut self, to: SubsystemId, body: Body<'_>) -> io::Result<()> {
        self.taken(to, body)?;
        self.step()
    }

    fn taken(&mut self, to: SubsystemId, body: Body<'_>) -> io::Result<()> {
        let payload = self.exchange(to, body)?;
        for record in Records::new(&payload) {
            let record = record.map_err(|error| io::Error::other(error.to_string()))?;
            if !record.status.is_success() {
                return Err(io::Error::other(format!("{body:?} to {to}: {:?}", record.status)));
            }
        }
        Ok(())
    }

    /// The data of the first answer.
    fn ask(&mut self, to: SubsystemId, body: Body<'_>) -> io::Result<Vec<u8>> {
        let payload = self.exchange(to, body)?;
        let record = Records::new(&payload).next().and_then(Result::ok);
        record
            .map(|record| record.data.to_vec())
            .ok_or_else(|| io::Error::other(format!("no answer to {body:?}")))
    }

    fn exchange(&mut self, to: SubsystemId, body: Body<'_>) -> io::Result<Vec<u8>> {
        let (mut payload, mut wire) = ([0; 64], [0; WIRE_MAX]);
        let mut writer = Writer::new(&mut payload);
        let too_long = || io::Error::other("too long a request");
        Request::new(to, body).encode(&mut writer).map_err(|_| too_long())?;
        let frame = Frame { dst: ADDRESS, src: PEER, payload: writer.written() };
        let len = link::encode(&frame, &mut wire).ok_or_else(too_long)?;
        let mut decoder: link::Decoder = link::Decoder::new();
        let mut byte = [0];
        self.chip.ask(&wire[..len], &mut byte)?;
        loop {
            if let (_, Some(frame)) = decoder.push_slice(&byte) {
                return Ok(frame.payload.to_vec());
            }
            self.chip.ask(&[], &mut byte)?;
        }
    }
}

fn driven(step: Stepped) -> io::Result<Outputs> {
    match step {
        Stepped::Driven(outputs) => Ok(outputs),
        Stepped::Reset { .. } => Err(io::Error::other("the program was reset")),
    }
}
