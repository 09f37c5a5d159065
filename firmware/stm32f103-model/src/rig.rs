//! The program of the board in the model: it is started, runs, is reset, and is asked over its line.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use lafet_device::port::Port;
use lafet_device::{Composition, Device, Source};
use lafet_proto::link::{self, Frame, WIRE_MAX};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::{Request, Status, SubsystemId};
use lafet_sim::fire::FireSpec;
use lafet_sim::world::{World, WorldConfig};
use lafet_stm32f103::record::Record;
use lafet_stm32f103::{Bus, Memory, Stm32f103, line};
use lafet_turn::fault::{self, NMI, Words};
use lafet_turn::{Board, once};

use crate::chip::{Byte, Chip, FLASH_START, RAM_START, Reset};
use crate::image;
use crate::plant::Plant;

/// Time of an access to a register, with the instructions around it.
const ACCESS_NS: u64 = 100;
/// The loop is gone round so often while nothing is due: seldom, on a chip it takes some µs.
const ROUND_NS: u64 = 50_000;
const MS_NS: u64 = 1_000_000;
/// The flags of the DMA: a step looks at them once, at its beginning.
const STEP_BEGINS: u32 = 0x4002_0000;
/// The status that an exception stacks in the midst of the program: the bit of Thumb alone.
const IN_PROGRAM: u32 = 1 << 24;
const ADDRESS: u8 = 7;
const PEER: u8 = 129;

/// A board that differs from what it should be.
#[derive(Clone, Copy)]
pub struct Wrong {
    /// To which register an access goes.
    pub route: fn(u32) -> u32,
    /// What becomes of a value that is written (or else read); `None` when the write gets lost.
    pub alter: fn(bool, u32, u32) -> Option<u32>,
    /// What is wrong with the record.
    pub record: fn(&mut Record),
    /// What is wrong with the wires.
    pub wires: fn(&mut Plant),
    /// The loop, once round.
    pub turn: Turn,
}

/// What a program does over and over.
pub type Turn = fn(&mut Stm32f103<Wires>, &mut Device, &mut Port<()>);

impl Wrong {
    /// Nothing.
    pub const NOTHING: Self = Self {
        route: |address| address,
        alter: |_, _, value| Some(value),
        record: |_| {},
        wires: |_| {},
        turn: |board, device, port| _ = once(board, device, port),
    };
}

/// Chip and plant.
#[derive(Clone)]
pub struct Parts {
    /// The chip.
    pub chip: Chip,
    /// What is wired to it.
    pub plant: Plant,
    /// Since when no motor has had voltage and no valve was opening, ns; `None` while one has or is.
    pub off_ns: Option<u64>,
    wrong: Wrong,
    step_ns: u64,
}

impl Parts {
    /// Moves time to this moment at most, the plant with it; true when an interrupt ended it.
    fn advance(&mut self, until_ns: u64) -> bool {
        loop {
            let tick = (self.chip.now_ns / MS_NS + 1) * MS_NS;
            self.chip.advance(until_ns.min(tick));
            if self.chip.has_interrupt() {
                return true;
            }
            if self.chip.now_ns >= tick {
                self.plant.tick(&mut self.chip);
            }
            if self.chip.now_ns >= until_ns {
                return false;
            }
        }
    }

    /// Whether a motor has voltage or a valve opens.
    pub fn is_energised(&self) -> bool {
        let opening = self.plant.relays(&self.chip).iter().any(|[open, _]| *open);
        opening || self.plant.is_live(&self.chip)
    }

    fn stand_still(&mut self, ns: u64) {
        if ns > 0 && self.is_energised() {
            self.chip.violations.insert("the flash was busy while something was driven".into());
        }
    }
}

/// What the program has of them.
#[derive(Clone)]
pub struct Wires {
    parts: Rc<RefCell<Parts>>,
    serving: Rc<Cell<bool>>,
}

impl Wires {
    /// Lets time pass, interrupts included.
    pub fn pass(&self, ns: u64) {
        let until_ns = self.parts.borrow().chip.now_ns + ns;
        while self.parts.borrow_mut().advance(until_ns) {
            if self.serving.replace(true) {
                break;
            }
            line::on_interrupt(self);
            self.serving.set(false);
            self.parts.borrow_mut().chip.served();
        }
    }

    /// Lets time pass while the flash is busy: interrupts are served behind it.
    fn stall(&self, ns: u64) {
        let mut parts = self.parts.borrow_mut();
        parts.stand_still(ns);
        let until_ns = parts.chip.now_ns + ns;
        parts.chip.is_stalled = true;
        parts.advance(until_ns);
        parts.chip.is_stalled = false;
        drop(parts);
        self.pass(0);
    }

    fn is_serving(&self) -> bool {
        self.serving.get()
    }

    fn access(&self) {
        if !self.is_serving() {
            self.pass(ACCESS_NS);
        }
    }
}

impl Bus for Wires {
    fn read(&self, address: u32) -> u32 {
        self.access();
        let mut parts = self.parts.borrow_mut();
        let wrong = parts.wrong;
        let value = parts.chip.read((wrong.route)(address));
        let step_ns = parts.step_ns;
        drop(parts);
        if address == STEP_BEGINS && step_ns > 0 {
            self.pass(step_ns);
        }
        (wrong.alter)(false, address, value).unwrap_or_default()
    }

    fn write(&self, address: u32, value: u32) {
        self.access();
        let mut parts = self.parts.borrow_mut();
        let wrong = parts.wrong;
        let Some(value) = (wrong.alter)(true, address, value) else { return };
        let busy_ns = parts.chip.write((wrong.route)(address), value);
        parts.off_ns = match parts.is_energised() {
            true => None,
            false => parts.off_ns.or(Some(parts.chip.now_ns)),
        };
        drop(parts);
        self.stall(busy_ns);
    }

    fn read8(&self, address: u32) -> u8 {
        self.parts.borrow().chip.read8(address)
    }

    fn write8(&self, address: u32, value: u8) {
        self.parts.borrow_mut().chip.write8(address, value);
    }

    fn write16(&self, address: u32, value: u16) {
        let busy_ns = self.parts.borrow_mut().chip.write16(address, value);
        self.stall(busy_ns);
    }

    fn reset(&self) {
        self.parts.borrow_mut().chip.reset.get_or_insert(Reset::Software);
    }
}

/// An answer: who, status, data.
pub type Answer = (SubsystemId, Status, Vec<u8>);

/// A board with its plant at one moment, as [`Rig::save`] has kept it.
pub struct Saved {
    parts: Parts,
    board: Stm32f103<Wires>,
    device: Device,
    port: Port<()>,
    resets: Vec<Reset>,
    crash: Words,
    address: u8,
}

/// A board with its plant, in operation.
pub struct Rig {
    wires: Wires,
    board: Stm32f103<Wires>,
    /// The monitor's program.
    pub device: Device,
    port: Port<()>,
    /// What has ended runs so far.
    pub resets: Vec<Reset>,
    /// Memory that no reset clears.
    crash: Words,
    address: u8,
}

impl Rig {
    /// Switches a board on whose barrel is parked, the jumper in its place; the jumper is taken away a
    /// tenth of a second later.
    pub fn new(wrong: Wrong, fires: Vec<FireSpec>) -> Self {
        let mut rig = Self::before_steps(wrong, fires);
        rig.run(100);
        rig.parts(|parts| parts.plant.parked = false);
        rig
    }

    /// The same before its first step, the jumper in its place.
    pub fn before_steps(wrong: Wrong, fires: Vec<FireSpec>) -> Self {
        let mut record = Record::NOMINAL;
        (wrong.record)(&mut record);
        let image = image::provision(&record, &Composition::FULL, ADDRESS).expect("it fits");
        Self::with_flash(wrong, fires, image::flash(Some(&image)))
    }

    /// The same with this flash.
    pub fn with_flash(wrong: Wrong, fires: Vec<FireSpec>, flash: Vec<u8>) -> Self {
        let world = World::new(WorldConfig { fires, ..WorldConfig::default() });
        let mut plant = Plant::new(world);
        plant.parked = true;
        (wrong.wires)(&mut plant);
        let mut chip = Chip::new(flash);
        plant.tick(&mut chip);
        let parts = Parts { chip, plant, off_ns: None, wrong, step_ns: 0 };
        let parts = Rc::new(RefCell::new(parts));
        let wires = Wires { parts, serving: Rc::new(Cell::new(false)) };
        let mut crash = Words::default();
        let (board, device) = start(&wires, &mut crash);
        let port = Port::counting(Source::ExternalConn);
        Self { wires, board, device, port, resets: Vec::new(), crash, address: ADDRESS }
    }

    /// Everything as it is now: program, chip and plant.
    pub fn save(&self) -> Saved {
        Saved {
            parts: self.parts(|parts| parts.clone()),
            board: self.board.clone(),
            device: self.device.clone(),
            port: self.port.clone(),
            resets: self.resets.clone(),
            crash: self.crash,
            address: self.address,
        }
    }

    /// Goes back to a moment of this rig; a moment of another is not for it.
    pub fn restore(&mut self, saved: &Saved) {
        self.parts(|parts| *parts = saved.parts.clone());
        // What the program has of chip and plant are handles to this rig's.
        self.board = saved.board.clone();
        self.device = saved.device.clone();
        self.port = saved.port.clone();
        self.resets = saved.resets.clone();
        self.crash = saved.crash;
        self.address = saved.address;
    }

    /// Chip and plant, to look at or to change.
    pub fn parts<T>(&self, act: impl FnOnce(&mut Parts) -> T) -> T {
        act(&mut self.wires.parts.borrow_mut())
    }

    /// The address that it is asked at from now on.
    pub fn set_address(&mut self, address: u8) {
        self.address = address;
    }

    /// Sets the processor's time for each step, ns.
    pub fn set_step_ns(&mut self, ns: u64) {
        self.parts(|parts| parts.step_ns = ns);
    }

    /// Time, ns.
    pub fn now_ns(&self) -> u64 {
        self.parts(|parts| parts.chip.now_ns)
    }

    /// Lets time pass while the program hangs.
    pub fn hang(&mut self, ns: u64) {
        self.wires.pass(ns);
    }

    /// Once round the loop, and a reset where one is due.
    pub fn round(&mut self) {
        let (is_reset, turn) = self.parts(|parts| (parts.chip.reset, parts.wrong.turn));
        if let Some(cause) = is_reset {
            return self.start(cause);
        }
        turn(&mut self.board, &mut self.device, &mut self.port);
        self.wires.pass(ROUND_NS);
    }

    /// Runs for so many ms.
    pub fn run(&mut self, ms: u64) {
        let until = self.now_ns() + ms * MS_NS;
        while self.now_ns() < until {
            self.round();
        }
    }

    /// Runs until something is so, for so many ms at most; whether it came.
    pub fn run_until(&mut self, ms: u64, mut is_so: impl FnMut(&mut Self) -> bool) -> bool {
        for _ in 0..ms / 10 {
            if is_so(self) {
                return true;
            }
            self.run(10);
        }
        is_so(self)
    }

    /// Takes the supply away and gives it back; battery, flash and plant stay.
    pub fn cut_power(&mut self) {
        self.start(Reset::Power);
    }

    fn start(&mut self, cause: Reset) {
        self.resets.push(cause);
        self.parts(|parts| parts.chip.start(cause));
        match cause {
            // As `firmware/src/crash.rs` records an exception without a handler of its own.
            Reset::Clock => {
                let stacked = [0, 0, 0, 0, 0, 0, FLASH_START, fault::status(IN_PROGRAM, NMI)];
                self.crash = fault::words(RAM_START, stacked, [0; 4]);
            }
            Reset::Power => self.crash = Words::default(),
            Reset::Software | Reset::Watchdog => {}
        }
        (self.board, self.device) = start(&self.wires, &mut self.crash);
        self.port = Port::counting(Source::ExternalConn);
    }

    /// Puts a frame of these records on the line; when its last byte has come, ns.
    pub fn send(&mut self, payload: &[u8]) -> u64 {
        self.send_from(0, payload)
    }

    /// The same from this moment on, ns, or behind what is on the line then.
    pub fn send_from(&mut self, from_ns: u64, payload: &[u8]) -> u64 {
        let mut wire = [0; WIRE_MAX];
        let frame = Frame { dst: self.address, src: PEER, payload };
        let len = link::encode(&frame, &mut wire).expect("it fits");
        self.parts(|parts| {
            let chip = &mut parts.chip;
            let byte_ns = 10_000_000_000 / chip.line_baud;
            let last = chip.incoming.back().map_or(chip.now_ns, |byte| byte.at_ns).max(from_ns);
            for (n, value) in (1..).zip(&wire[..len]) {
                chip.incoming.push_back(Byte { at_ns: last + n * byte_ns, value: *value });
            }
            last + len as u64 * byte_ns
        })
    }

    /// The frames that have come back since this was asked last.
    pub fn frames(&mut self) -> Vec<Vec<u8>> {
        let bytes = self.parts(|parts| std::mem::take(&mut parts.chip.outgoing));
        let mut decoder: link::Decoder = link::Decoder::new();
        let mut frames = Vec::new();
        for byte in bytes {
            if let (_, Some(frame)) = decoder.push_slice(&[byte.value]) {
                frames.push(frame.payload.to_vec());
            }
        }
        frames
    }

    /// Asks, and waits for the answer for half a second.
    pub fn ask(&mut self, to: SubsystemId, body: Body<'_>) -> Result<Vec<Answer>, String> {
        let mut payload = [0; 260];
        let mut writer = Writer::new(&mut payload);
        Request::new(to, body).encode(&mut writer).map_err(|_| "too long a request")?;
        self.parts(|parts| parts.chip.outgoing.clear());
        self.send(writer.written());
        let mut answer = None;
        for _ in 0..50 {
            self.run(10);
            let bytes = self.parts(|parts| parts.chip.outgoing.clone());
            let mut decoder: link::Decoder = link::Decoder::new();
            for byte in bytes {
                if let (_, Some(frame)) = decoder.push_slice(&[byte.value]) {
                    answer = Some(frame.payload.to_vec());
                }
            }
            if answer.is_some() {
                break;
            }
        }
        let answer = answer.ok_or_else(|| format!("no answer to {body:?}"))?;
        let records = Records::new(&answer).flatten();
        Ok(records.map(|it| (it.device, it.status, it.data.to_vec())).collect())
    }

    /// A request that must be taken.
    pub fn order(&mut self, to: SubsystemId, body: Body<'_>) -> Result<(), String> {
        let answers = self.ask(to, body)?;
        match answers.iter().find(|(_, status, _)| !status.is_success()) {
            None if !answers.is_empty() => Ok(()),
            refused => Err(format!("{body:?}: {refused:?}")),
        }
    }

    /// Whether the board has found its record.
    pub fn has_record(&self) -> bool {
        self.board.has_record()
    }
}

fn start(wires: &Wires, crash: &mut Words) -> (Stm32f103<Wires>, Device) {
    let memory =
        Memory { received: RAM_START, sent: RAM_START + 0x400, samples: RAM_START + 0xC00 };
    let mut board = Stm32f103::start(wires.clone(), memory);
    let fault = fault::take(crash, board.reset_by_watchdog(), board.lacks_crystal());
    let start = board.start(fault.is_some());
    let mut device = Device::at_rest(start.composition, start.address);
    device.wake(start.now_ms, fault, &mut board);
    board.started();
    (board, device)
}
