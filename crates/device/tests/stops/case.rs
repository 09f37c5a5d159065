//! One Stop or Lockout, and the time it takes.

use crate::common::{ADDRESS, Plant, Rig, payload};
use crate::flood::{Random, frames, noise, set, wire};
use crate::interlock::Moment;
use crate::lives::{ACTIVITIES, Life, lives};
use lafet_device::Source;
use lafet_device::cause::{Cause, Rule};
use lafet_device::guard::Passed;
use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::{Axis, Inputs, Outputs, VALVES, ValveInput, ValveNo, ValveOutput};
use lafet_device::port::Port;
use lafet_proto::Request;
use lafet_proto::flags::{ButtonState, GeneralFlags};
use lafet_proto::link::WIRE_MAX;
use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{RequestId, SubsystemId};
use std::collections::BTreeMap;
use std::fmt;

/// Cases for which the monitors are made once.
pub const CASES_OF_A_SEED: u64 = 2000;
/// Bytes that wait in a receive buffer when it is full: two frames of the longest kind.
const BUFFER: usize = 2 * WIRE_MAX;
/// Erasing a page of flash takes this long, µs; a word much less.
const ERASE_US: u64 = 25_000;
const WORD_US: u64 = 60;
/// After a reset the monitor has settled, and what was held or stored would show.
const SETTLED_US: u64 = 150_000;
/// The button that opens a valve.
const OPEN: usize = 6;

/// What was seen.
#[derive(Default)]
pub struct Tally {
    pub cases: u64,
    /// Something ran when the last byte came.
    pub running: u64,
    stops: u64,
    lockouts: u64,
    restarts: u64,
    /// Followed through the reset, or cut off without one.
    resets: u64,
    valves_left: u64,
    move_timeouts: u64,
    behind_full_answers: u64,
    behind_full_buffer: u64,
    during_flash: u64,
    flash_after: u64,
    radio: u64,
    pub longest_us: u64,
    /// Until a valve that stood open is driven to close: a flash that is erased may delay it.
    longest_closing_us: u64,
    /// Cases by whole milliseconds from the last byte to the outputs, where something ran.
    histogram: [u64; 11],
    /// By activity: how often something ran.
    pub ran: BTreeMap<&'static str, u64>,
}

impl Tally {
    /// A case of this kind has been tried.
    fn count(&mut self, what: Kind) {
        self.cases += 1;
        self.stops += u64::from(what == Kind::Stop);
        self.lockouts += u64::from(what == Kind::Lockout);
        self.restarts += u64::from(what == Kind::Restart);
    }

    pub fn add(&mut self, other: &Self) {
        self.cases += other.cases;
        self.running += other.running;
        self.stops += other.stops;
        self.lockouts += other.lockouts;
        self.restarts += other.restarts;
        self.resets += other.resets;
        self.valves_left += other.valves_left;
        self.move_timeouts += other.move_timeouts;
        self.behind_full_answers += other.behind_full_answers;
        self.behind_full_buffer += other.behind_full_buffer;
        self.during_flash += other.during_flash;
        self.flash_after += other.flash_after;
        self.radio += other.radio;
        self.longest_us = self.longest_us.max(other.longest_us);
        self.longest_closing_us = self.longest_closing_us.max(other.longest_closing_us);
        for (sum, more) in self.histogram.iter_mut().zip(other.histogram) {
            *sum += more;
        }
        for (name, count) in &other.ran {
            *self.ran.entry(name).or_default() += count;
        }
    }

    /// Situations that must have occurred.
    pub fn witnesses(&self) -> [(&'static str, u64); 11] {
        [
            ("Stop All", self.stops),
            ("Lockout", self.lockouts),
            ("Restart", self.restarts),
            ("MoveTimeout", self.move_timeouts),
            ("followed through a reset", self.resets),
            ("with ResetValves, a valve not closed", self.valves_left),
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
        writeln!(f, "a valve at rest is driven to close after {} µs", self.longest_closing_us)?;
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

    fn write(&mut self, outputs: &Passed) {
        self.driven.push((self.now_us, **outputs));
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
        let (stored, written) = (board.stored > 0, board.driven.last().map(|last| last.1));
        self.now_us = board.now_us;
        self.driven.append(&mut board.driven);
        self.stored = board.stored;
        // §3.5/10 Under lockout a valve that closes is all that runs, and nothing may stop it.
        let may = |outputs: &Outputs, rig: &mut Rig| {
            let locked = rig.general().flags.contains(GeneralFlags::LOCKED_OUT);
            outputs.is_still() || locked && is_quiet(true, outputs)
        };
        let idle = !stored || written.is_some_and(|outputs| may(&outputs, &mut self.rig));
        assert!(idle, "stored while something runs: {written:?}");
    }

    /// To the reset that has been asked for, or without one as if the supply had failed, and until
    /// the monitor has settled again; returns whether its valves stay as they are.
    fn through_reset(&mut self, asked: bool, random: &mut Random, name: &str) -> bool {
        let mut at_us = self.now_us;
        while asked && !self.rig.plant.reset_requested {
            at_us = self.next_step_us(at_us);
            self.step(at_us, random);
        }
        self.rig.now_ms = self.now_ms();
        self.rig.plant.reset_requested = false;
        let between = |valve: &ValveInput| !valve.open_switch && !valve.close_switch;
        // What was on its way closes.
        let closes = self.rig.plant.inputs.valves.iter().any(between);
        self.rig.power_cycle();
        let keep = self.rig.get(Param::GeneralResetValves) == Ok(vec![1]);
        let reset_us = at_us;
        while at_us < reset_us + SETTLED_US {
            at_us = self.next_step_us(at_us);
            self.step(at_us, random);
            let (_, outputs) = self.driven.last().unwrap();
            assert!(is_quiet(!keep || closes, outputs), "{name}: after a reset: {outputs:?}");
        }
        keep
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
        let name = format!("seed {seed}, case {case}");
        match random.clone().below(40) {
            0 => move_timeout(life, &mut random.clone(), &mut tally, &name),
            1 => power_cut(life, &mut random.clone(), &mut tally, &name),
            _ => one(life, &frames, &mut random.clone(), &mut tally, &name),
        }
        random.next();
    }
    tally
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    Stop,
    Lockout,
    Restart,
}

impl Kind {
    /// Whether the valves close; `keep`: a restart closes none, and what closes already goes on.
    const fn closes(self, keep: bool) -> Option<bool> {
        match self {
            Self::Stop => Some(false),
            Self::Lockout => Some(true),
            Self::Restart if keep => None,
            Self::Restart => Some(true),
        }
    }
}

/// The frame of a case.
struct Command {
    kind: Kind,
    bytes: Vec<u8>,
    full_answers: bool,
}

fn command(random: &mut Random, locked: bool) -> Command {
    // Under lockout the others have nothing left to do; they are answered Denied (§3.18/2).
    let kind = match random.below(16) {
        _ if locked => Kind::Lockout,
        0..7 => Kind::Stop,
        7..14 => Kind::Lockout,
        _ => Kind::Restart,
    };
    let request = match kind {
        Kind::Stop => Request::new(SubsystemId::ALL, Body::Stop),
        Kind::Lockout => Request::lockout(true),
        Kind::Restart => Request::new(SubsystemId::ALL, Body::Restart),
    };
    // A Restart without room for its answer is not executed (§1/9).
    let full_answers = kind != Kind::Restart && random.one_in(4);
    let mut records = Vec::new();
    if full_answers {
        // Answers to these fill the buffer: the command is behind a NoRoom (§1/9).
        let status = Request::new(SubsystemId::ALL, Body::GetStatus);
        records.extend(std::iter::repeat_n(status, 12));
    }
    records.push(request);
    Command { kind, bytes: wire(ADDRESS, &payload(&records)), full_answers }
}

/// Whether the outputs are off; `closing`: and valves that are not closed are driven there, once
/// the monitor has settled.
fn is_off(rig: &Rig, closing: Option<bool>, outputs: &Outputs) -> bool {
    let Some(closing) = closing else {
        let mut valves = outputs.valves.iter().zip(&rig.device.causes().valves);
        let closed = valves.any(|(output, cause)| {
            let by_restart =
                matches!(cause, Cause::Request(by) if by.request == RequestId::RESTART);
            *output == ValveOutput::Closing && by_restart
        });
        return is_quiet(true, outputs) && !closed;
    };
    let valves = (0..VALVES).all(|valve| {
        let input = &rig.device.inputs().valves[valve];
        let inert = rig.device.causes().valves[valve] == Cause::Rule(Rule::Inert);
        let nothing = inert || input.close_switch || !rig.device.has(ValveNo::ALL[valve].id());
        closing != (outputs.valves[valve] == ValveOutput::Off) || nothing
    });
    valves && is_quiet(closing, outputs)
}

/// Nothing moves, but for a valve that may close.
fn is_quiet(closing: bool, outputs: &Outputs) -> bool {
    let stopped = Moment { stopped: true, ..Moment::new(outputs) };
    stopped.judge().is_empty() && (closing || !outputs.valves.contains(&ValveOutput::Closing))
}

fn is_running(outputs: &Outputs) -> bool {
    !outputs.is_still()
}

fn one(life: &Life, frames: &[Vec<u8>], random: &mut Random, tally: &mut Tally, name: &str) {
    let activity = &ACTIVITIES[life.activity];
    let locked = activity.name == "locked out";
    let (mut firmware, keep) = provided(life, locked, random);
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
    let full_buffer = random.one_in(2);
    let waiting = waiting(frames, full_buffer, random);
    let other: &[u8] = if random.one_in(2) { random.of::<Vec<u8>>(frames) } else { &[] };
    let ran = firmware.driven.last().is_some_and(|(_, outputs)| is_running(outputs));
    let before = firmware.driven.last().map(|(_, outputs)| *outputs).unwrap_or_default();
    let closing_before = is_off(&firmware.rig, Some(true), &before);
    firmware.receive(1 - port, other);
    firmware.receive(port, &waiting);
    firmware.receive(port, &command.bytes);
    if random.one_in(4) {
        press(&mut firmware, random);
    }
    firmware.step(next_us, random);
    let stored_after = firmware.stored;
    let (off_us, outputs) = *firmware.driven.last().unwrap();
    assert_eq!(off_us, next_us, "{name}");
    let what = command.kind;
    let closing = what.closes(keep);
    let rig = &firmware.rig;
    assert!(
        is_off(rig, closing, &outputs),
        "{name}: {what:?} while {} on {}: {outputs:?}",
        activity.name,
        rig.composition.name
    );
    let since_us = off_us - arrival_us;
    // Nothing was on while the flash was busy.
    let latency_us = if is_quiet(closing != Some(false), &before) { 0 } else { since_us };
    assert!(latency_us <= 10_000, "{name}: {what:?} while {}: {latency_us} µs", activity.name);
    let closing_us = if closing == Some(true) && !closing_before { since_us } else { 0 };
    let flash_us = if in_flash { 2 * ERASE_US } else { 0 };
    assert!(closing_us <= 10_000 + flash_us, "{name}: closes after {closing_us} µs");
    stays_off(&mut firmware, next_us, closing, random, name);
    if what == Kind::Restart && random.one_in(4) {
        let open = firmware.rig.device.inputs().valves[0].close_switch;
        let left = firmware.through_reset(true, random, name);
        tally.resets += 1;
        tally.valves_left += u64::from(left && !open);
    }

    tally.count(what);
    tally.behind_full_answers += u64::from(command.full_answers);
    tally.behind_full_buffer += u64::from(full_buffer);
    tally.during_flash += u64::from(in_flash);
    tally.flash_after += u64::from(stored_after > 0);
    tally.radio += u64::from(port == 1);
    tally.longest_us = tally.longest_us.max(latency_us);
    tally.longest_closing_us = tally.longest_closing_us.max(closing_us);
    *tally.ran.entry(activity.name).or_default() += u64::from(ran);
    if ran {
        tally.running += 1;
        if let Some(count) = tally.histogram.get_mut(latency_us.div_ceil(1000) as usize) {
            *count += 1;
        }
    }
}

/// A monitor in the middle of its life, with parameters that wait for a rest to be stored; and
/// whether its valves stay as they are over a reset.
fn provided(life: &Life, locked: bool, random: &mut Random) -> (Firmware, bool) {
    let period_us = 1000 * (1 + random.below(10));
    let mut firmware = Firmware::new(life, period_us);
    let keep = random.one_in(2) && !locked;
    firmware.rig.set(Param::GeneralResetValves, keep.into());
    for _ in 0..random.below(4) {
        let request = set(random);
        firmware.rig.handle(&payload(&[request]));
    }
    (firmware, keep)
}

/// Bytes that wait on the line before the command: frames, a buffer full of them or none, and noise.
fn waiting(frames: &[Vec<u8>], full: bool, random: &mut Random) -> Vec<u8> {
    let mut waiting = Vec::new();
    while full && waiting.len() < BUFFER {
        waiting.extend(random.of(frames));
        if random.one_in(3) {
            noise(random, &mut waiting);
        }
    }
    noise(random, &mut waiting);
    waiting
}

/// Another button pressed meanwhile is part of the same moment: it does not act.
fn press(firmware: &mut Firmware, random: &mut Random) {
    let post = random.below(2) as usize;
    let button = random.below(OPEN as u64) as usize;
    firmware.rig.plant.inputs.buttons[post][button] = ButtonState::Pressed;
}

/// What is off stays off in the steps that follow.
fn stays_off(
    firmware: &mut Firmware,
    since_us: u64,
    closing: Option<bool>,
    random: &mut Random,
    name: &str,
) {
    let mut at_us = since_us;
    for _ in 0..3 {
        at_us = firmware.next_step_us(at_us);
        firmware.step(at_us, random);
        let (_, outputs) = *firmware.driven.last().unwrap();
        let off = is_off(&firmware.rig, closing, &outputs);
        assert!(off, "{name}: on again: {outputs:?}");
    }
}

/// The supply fails in the middle of it; nothing goes on afterwards.
fn power_cut(life: &Life, random: &mut Random, tally: &mut Tally, name: &str) {
    let mut firmware = Firmware::new(life, 1000 * (1 + random.below(10)));
    firmware.step(random.below(1000), random);
    let ran = firmware.driven.last().is_some_and(|(_, outputs)| is_running(outputs));
    firmware.through_reset(false, random, name);
    tally.cases += 1;
    tally.resets += 1;
    *tally.ran.entry(ACTIVITIES[life.activity].name).or_default() += u64::from(ran);
}

/// §D/4 A Move that is not repeated, whatever the monitor was doing.
fn move_timeout(life: &Life, random: &mut Random, tally: &mut Tally, name: &str) {
    let period_us = 1000 * (1 + random.below(10));
    let mut firmware = Firmware::new(life, period_us);
    let timeout_ms = 20 + random.below(200);
    firmware.rig.set(Param::GeneralMoveTimeout, timeout_ms as i32);
    let mut at_us = random.below(1000);
    firmware.step(at_us, random);
    firmware.rig.now_ms = firmware.now_ms();
    // The moment of the last byte; the clock that the device gets counts milliseconds.
    let arrival_us = firmware.now_us;
    let destination = if random.one_in(2) { 30_000 } else { -30_000 };
    let aiming = [Axis::Vertical, Axis::Horizontal, Axis::Nozzle];
    let mut moved = aiming.to_vec();
    moved.retain(|axis| firmware.rig.one(axis.id(), Body::Move { destination }).1.is_success());
    let mut ran = false;
    let deadline_us = arrival_us + 1000 * timeout_ms;
    let mut off_us = None;
    while off_us.is_none() || at_us < deadline_us {
        at_us = firmware.next_step_us(at_us);
        firmware.step(at_us, random);
        let (written_us, outputs) = *firmware.driven.last().unwrap();
        let running = moved.iter().any(|axis| outputs.drives[*axis as usize].speed_tenths != 0);
        ran |= running;
        assert!(!running || written_us <= deadline_us + 10_000, "{name}: MoveTimeout: {outputs:?}");
        off_us = if running { None } else { off_us.or(Some(written_us)) };
    }
    tally.cases += 1;
    tally.move_timeouts += u64::from(ran);
    *tally.ran.entry(ACTIVITIES[life.activity].name).or_default() += u64::from(ran);
    if ran {
        let latency_us = off_us.unwrap_or_default().saturating_sub(deadline_us);
        tally.running += 1;
        tally.longest_us = tally.longest_us.max(latency_us);
        if let Some(count) = tally.histogram.get_mut(latency_us.div_ceil(1000) as usize) {
            *count += 1;
        }
    }
}
