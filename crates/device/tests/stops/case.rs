//! One Stop or Lockout, and the time it takes.

use crate::common::{ADDRESS, Plant, Rig, payload};
use crate::flood::{Random, frames, noise, set, wire};
use crate::lives::{ACTIVITIES, Life, lives};
use lafet_device::Source;
use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::{Inputs, Outputs, VALVES, ValveNo, ValveOutput};
use lafet_device::port::Port;
use lafet_proto::Request;
use lafet_proto::SubsystemId;
use lafet_proto::flags::ButtonState;
use lafet_proto::link::WIRE_MAX;
use lafet_proto::request::Body;
use std::collections::BTreeMap;
use std::fmt;

/// Cases for which the monitors are made once.
pub const CASES_OF_A_SEED: u64 = 2000;
/// Bytes that wait in a receive buffer when it is full: two frames of the longest kind.
const BUFFER: usize = 2 * WIRE_MAX;
/// Erasing a page of flash takes this long, µs; a word much less.
const ERASE_US: u64 = 25_000;
const WORD_US: u64 = 60;
/// The button that opens a valve.
const OPEN: usize = 6;

/// What was seen.
#[derive(Default)]
pub struct Tally {
    pub cases: u64,
    /// Something ran when the last byte came.
    pub running: u64,
    lockouts: u64,
    behind_full_answers: u64,
    behind_full_buffer: u64,
    during_flash: u64,
    flash_after: u64,
    radio: u64,
    pub longest_us: u64,
    /// Cases by whole milliseconds from the last byte to the outputs, where something ran.
    histogram: [u64; 11],
    /// By activity: how often something ran.
    pub ran: BTreeMap<&'static str, u64>,
}

impl Tally {
    pub fn add(&mut self, other: &Self) {
        self.cases += other.cases;
        self.running += other.running;
        self.lockouts += other.lockouts;
        self.behind_full_answers += other.behind_full_answers;
        self.behind_full_buffer += other.behind_full_buffer;
        self.during_flash += other.during_flash;
        self.flash_after += other.flash_after;
        self.radio += other.radio;
        self.longest_us = self.longest_us.max(other.longest_us);
        for (sum, more) in self.histogram.iter_mut().zip(other.histogram) {
            *sum += more;
        }
        for (name, count) in &other.ran {
            *self.ran.entry(name).or_default() += count;
        }
    }

    /// Situations that must have occurred.
    pub fn witnesses(&self) -> [(&'static str, u64); 7] {
        [
            ("Stop All", self.cases - self.lockouts),
            ("Lockout", self.lockouts),
            ("behind answers that filled the buffer", self.behind_full_answers),
            ("behind a full receive buffer", self.behind_full_buffer),
            ("while the flash was written", self.during_flash),
            ("stored right after it", self.flash_after),
            ("by radio", self.radio),
        ]
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} cases, something ran in {}; longest {} µs from the last byte to the outputs",
            self.cases, self.running, self.longest_us
        )?;
        for (what, count) in self.witnesses() {
            writeln!(f, "  {count:>8} {what}")?;
        }
        let mut sum = 0;
        for (ms, count) in self.histogram.iter().enumerate() {
            sum += count;
            let percent = 100.0 * sum as f64 / self.running.max(1) as f64;
            writeln!(f, "  {ms:>2} ms  {count:>8}  {percent:>6.2} %")?;
        }
        for (name, count) in &self.ran {
            writeln!(f, "  {count:>8} {name}")?;
        }
        Ok(())
    }
}

/// The plant with a clock and a flash that takes its time.
struct Board<'a> {
    plant: &'a mut Plant,
    random: &'a mut Random,
    now_us: u64,
    /// Moments at which the outputs were driven, and how.
    driven: Vec<(u64, Outputs)>,
    stored: u32,
}

impl Storage for Board<'_> {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        self.plant.load(key, buffer)
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        let words = value.len() as u64 / 4 + 2;
        self.now_us += words * WORD_US + if self.random.one_in(3) { ERASE_US } else { 0 };
        self.stored += 1;
        self.plant.store(key, value)
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.plant.erase()
    }
}

impl Hal for Board<'_> {
    fn read(&mut self, inputs: &mut Inputs) {
        self.plant.read(inputs);
    }

    fn write(&mut self, outputs: &Outputs) {
        self.driven.push((self.now_us, *outputs));
        self.plant.write(outputs);
    }

    fn reset(&mut self) {
        self.plant.reset();
    }
}

/// A monitor on its board, in the loop of a firmware: what was received is handled, then a step.
struct Firmware {
    rig: Rig,
    ports: [Port; 2],
    now_us: u64,
    plant_us: u64,
    offset_ms: u32,
    period_us: u64,
    driven: Vec<(u64, Outputs)>,
    stored: u32,
}

impl Firmware {
    fn new(life: &Life, period_us: u64) -> Self {
        let rig = life.rig.clone();
        let ports = [Port::new(Source::ExternalConn), Port::new(Source::Radio)];
        let offset_ms = rig.now_ms;
        Self {
            rig,
            ports,
            now_us: 0,
            plant_us: 0,
            offset_ms,
            period_us,
            driven: Vec::new(),
            stored: 0,
        }
    }

    fn now_ms(&self) -> u32 {
        self.offset_ms.wrapping_add((self.now_us / 1000) as u32)
    }

    fn receive(&mut self, port: usize, bytes: &[u8]) {
        let now_ms = self.now_ms();
        let mut out = [0; WIRE_MAX];
        let mut rest = bytes;
        while !rest.is_empty() {
            let device = &mut self.rig.device;
            let (taken, _) = self.ports[port].receive(now_ms, device, rest, &mut out);
            rest = &rest[taken..];
        }
    }

    /// A step at this moment; returns when it is over.
    fn step(&mut self, at_us: u64, random: &mut Random) {
        // The plant knows whole milliseconds.
        self.now_us = at_us;
        let elapsed_ms = at_us / 1000 - self.plant_us / 1000;
        self.plant_us = at_us;
        self.rig.plant.advance(elapsed_ms as u32);
        let now_ms = self.now_ms();
        let plant = &mut self.rig.plant;
        let mut board = Board { plant, random, now_us: at_us, driven: Vec::new(), stored: 0 };
        self.rig.device.step(now_ms, &mut board);
        self.now_us = board.now_us;
        self.driven.append(&mut board.driven);
        self.stored = board.stored;
    }

    fn next_step_us(&self, last_us: u64) -> u64 {
        (last_us + self.period_us).max(self.now_us)
    }
}

/// All cases of a seed.
pub fn run(seed: u64) -> Tally {
    let mut random = Random(seed.wrapping_mul(0xD6E8_FEB8_6659_FD93));
    let (lives, frames) = (lives(&mut random), frames(&mut random));
    let mut tally = Tally::default();
    for case in 0..CASES_OF_A_SEED {
        let life = random.of(&lives);
        one(life, &frames, &mut random.clone(), &mut tally, &format!("seed {seed}, case {case}"));
        random.next();
    }
    tally
}

/// The frame of a case.
struct Command {
    lockout: bool,
    bytes: Vec<u8>,
    full_answers: bool,
}

fn command(random: &mut Random, locked: bool) -> Command {
    // Under lockout there is nothing left for Stop; it is answered Denied (§3.18/2).
    let lockout = locked || random.one_in(2);
    let request =
        if lockout { Request::lockout(true) } else { Request::new(SubsystemId::ALL, Body::Stop) };
    let full_answers = random.one_in(4);
    let mut records = Vec::new();
    if full_answers {
        // Answers to these fill the buffer: the command stands behind a NoRoom (§1/9).
        let status = Request::new(SubsystemId::ALL, Body::GetStatus);
        records.extend(std::iter::repeat_n(status, 12));
    }
    records.push(request);
    Command { lockout, bytes: wire(ADDRESS, &payload(&records)), full_answers }
}

/// Whether the outputs are what the command asks for.
fn is_off(rig: &Rig, lockout: bool, outputs: &Outputs) -> bool {
    let drives = outputs.drives.iter().all(|drive| drive.speed_tenths == 0);
    drives
        && (0..VALVES).all(|valve| match outputs.valves[valve] {
            ValveOutput::Off => {
                let input = &rig.device.inputs().valves[valve];
                !lockout || input.close_switch || !rig.device.has(ValveNo::ALL[valve].id())
            }
            ValveOutput::Closing => lockout,
            ValveOutput::Opening => false,
        })
}

fn is_running(outputs: &Outputs) -> bool {
    !outputs.is_still()
}

fn one(life: &Life, frames: &[Vec<u8>], random: &mut Random, tally: &mut Tally, name: &str) {
    let activity = &ACTIVITIES[life.activity];
    let locked = activity.name == "locked out";
    let period_us = 1000 * (1 + random.below(10));
    let mut firmware = Firmware::new(life, period_us);
    // Dirty groups wait for a rest to be stored.
    for _ in 0..random.below(4) {
        let request = set(random);
        firmware.rig.handle(&payload(&[request]));
    }
    let mut last_us = random.below(1000);
    for _ in 0..random.below(6) {
        firmware.step(last_us, random);
        last_us = firmware.next_step_us(last_us);
    }
    firmware.step(last_us, random);
    let during = firmware.now_us > last_us && firmware.stored > 0;
    let next_us = firmware.next_step_us(last_us);
    let arrival_us = last_us + random.below(next_us - last_us);
    let in_flash = during && arrival_us < firmware.now_us;

    let port = random.below(2) as usize;
    let command = command(random, locked);
    let (full_buffer, mut waiting) = (random.one_in(2), Vec::new());
    while full_buffer && waiting.len() < BUFFER {
        waiting.extend(random.of(frames));
        if random.one_in(3) {
            noise(random, &mut waiting);
        }
    }
    noise(random, &mut waiting);
    let other: &[u8] = if random.one_in(2) { random.of::<Vec<u8>>(frames) } else { &[] };
    let ran = firmware.driven.last().is_some_and(|(_, outputs)| is_running(outputs));
    let before = firmware.driven.last().map(|(_, outputs)| *outputs).unwrap_or_default();
    firmware.receive(1 - port, other);
    firmware.receive(port, &waiting);
    firmware.receive(port, &command.bytes);
    // Another button pressed meanwhile is part of the same moment: it does not act.
    if random.one_in(4) {
        let post = random.below(2) as usize;
        let button = random.below(OPEN as u64) as usize;
        firmware.rig.plant.inputs.buttons[post][button] = ButtonState::Pressed;
    }
    firmware.step(next_us, random);
    let stored_after = firmware.stored;
    let (off_us, outputs) = *firmware.driven.last().unwrap();
    assert_eq!(off_us, next_us, "{name}");
    let what = if command.lockout { "Lockout" } else { "Stop All" };
    let rig = &firmware.rig;
    assert!(
        is_off(rig, command.lockout, &outputs),
        "{name}: {what} while {} on {}: {outputs:?}",
        activity.name,
        rig.composition.name
    );
    let already_off = is_off(rig, command.lockout, &before);
    let latency_us = if already_off { 0 } else { off_us - arrival_us };
    assert!(latency_us <= 10_000, "{name}: {what} while {}: {latency_us} µs", activity.name);
    // It stays so.
    let mut at_us = next_us;
    for _ in 0..3 {
        at_us = firmware.next_step_us(at_us);
        firmware.step(at_us, random);
        let (_, outputs) = *firmware.driven.last().unwrap();
        let off = is_off(&firmware.rig, command.lockout, &outputs);
        assert!(off, "{name}: {what} while {}, later: {outputs:?}", activity.name);
    }

    tally.cases += 1;
    tally.lockouts += u64::from(command.lockout);
    tally.behind_full_answers += u64::from(command.full_answers);
    tally.behind_full_buffer += u64::from(full_buffer);
    tally.during_flash += u64::from(in_flash);
    tally.flash_after += u64::from(stored_after > 0);
    tally.radio += u64::from(port == 1);
    tally.longest_us = tally.longest_us.max(latency_us);
    *tally.ran.entry(activity.name).or_default() += u64::from(ran);
    if ran {
        tally.running += 1;
        if let Some(count) = tally.histogram.get_mut(latency_us.div_ceil(1000) as usize) {
            *count += 1;
        }
    }
}
