//! Every request: all 2^24 combinations of (request, device, data_size), with arbitrary data, in
//! seven states, against rules written down here once more from the document's tables.

mod common;

use common::{ROOM, Rig};
use lafet_device::image::{Axis, Outputs};
use lafet_device::{Composition, Device, Source};
use lafet_proto::Answer;
use lafet_proto::flags::DeployerFlags;
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::{Status, SubsystemId};

const ALL: u8 = 0x5D;
const MOTORS: u8 = 0xAB;
const GENERAL: u8 = 0xC2;
const CLIMATICS: u8 = 0x62;
const VERTICAL: u8 = 0x0D;
const HORIZONTAL: u8 = 0x85;
const NOZZLE: u8 = 0x98;
const VALVE1: u8 = 0xA6;
const VALVE2: u8 = 0xC7;
const CONTROL: u8 = 0x45;
const DETECTOR: u8 = 0xC8;
const DEPLOYER: u8 = 0xA2;
const EXTERNAL_CONN: u8 = 0x09;
const RADIO: u8 = 0x8E;
const BUTTONS: u8 = 0xD4;
const EXT_BUTTONS: u8 = 0x52;

/// §1/1, each with the size of its status (§3.3).
const CHAIN: [(u8, usize); 14] = [
    (EXT_BUTTONS, 4),
    (BUTTONS, 4),
    (RADIO, 4),
    (EXTERNAL_CONN, 4),
    (DEPLOYER, 8),
    (DETECTOR, 4),
    (CONTROL, 4),
    (VALVE2, 4),
    (VALVE1, 4),
    (NOZZLE, 8),
    (HORIZONTAL, 8),
    (VERTICAL, 8),
    (CLIMATICS, 16),
    (GENERAL, 10),
];

const MOVE: u8 = 0x4D;
const STOP: u8 = 0x46;
const GET_STATUS: u8 = 0xD4;
const GET_PARAM: u8 = 0x9D;
const SET_PARAM: u8 = 0xF1;
const SETUP_CORRECTION_TABLE: u8 = 0x86;
const RETRIEVE_LIMITS: u8 = 0x80;
const OPEN: u8 = 0x21;
const CLOSE: u8 = 0x24;
const DEPLOY: u8 = 0x7E;
const WRAP: u8 = 0x8D;
const RESTART: u8 = 0x0A;
const START_JUSTIFY: u8 = 0x55;
const START_QUENCH: u8 = 0xC5;
const START_TRAJECTORY: u8 = 0x5C;
const START_SEEK: u8 = 0x76;
const SWITCH_LIMITS: u8 = 0xD9;
const GET_HOTBED: u8 = 0x9C;
const LOCKOUT: u8 = 0xE9;
const CLEAN_FLASH: u8 = 0x16;
const GET_CRASH_DATA: u8 = 0x06;

const KNOWN: [u8; 21] = [
    MOVE,
    STOP,
    GET_STATUS,
    GET_PARAM,
    SET_PARAM,
    SETUP_CORRECTION_TABLE,
    RETRIEVE_LIMITS,
    OPEN,
    CLOSE,
    DEPLOY,
    WRAP,
    RESTART,
    START_JUSTIFY,
    START_QUENCH,
    START_TRAJECTORY,
    START_SEEK,
    SWITCH_LIMITS,
    GET_HOTBED,
    LOCKOUT,
    CLEAN_FLASH,
    GET_CRASH_DATA,
];
const READS: [u8; 5] = [GET_STATUS, GET_PARAM, RETRIEVE_LIMITS, GET_HOTBED, GET_CRASH_DATA];

const DRIVES: &[u8] = &[DEPLOYER, NOZZLE, HORIZONTAL, VERTICAL];
const STOPPABLE: &[u8] =
    &[DEPLOYER, DETECTOR, CONTROL, VALVE2, VALVE1, NOZZLE, HORIZONTAL, VERTICAL];

/// The lines «Адресаты» of §3: one subsystem, and those that answer All and Motors.
struct Addressees {
    one: &'static [u8],
    all: &'static [u8],
    motors: &'static [u8],
}

const EVERYBODY: &[u8] = &[
    EXT_BUTTONS,
    BUTTONS,
    RADIO,
    EXTERNAL_CONN,
    DEPLOYER,
    DETECTOR,
    CONTROL,
    VALVE2,
    VALVE1,
    NOZZLE,
    HORIZONTAL,
    VERTICAL,
    CLIMATICS,
    GENERAL,
];

fn addressees(request: u8) -> Addressees {
    let to = |one, all, motors| Addressees { one, all, motors };
    match request {
        MOVE => to(DRIVES, &[], &[]),
        STOP => to(STOPPABLE, STOPPABLE, DRIVES),
        GET_STATUS => to(EVERYBODY, EVERYBODY, DRIVES),
        GET_PARAM | SET_PARAM => to(EVERYBODY, &[], &[]),
        RETRIEVE_LIMITS | SWITCH_LIMITS => to(DRIVES, DRIVES, DRIVES),
        OPEN | CLOSE => to(&[VALVE1, VALVE2], &[], &[]),
        DEPLOY | WRAP => to(&[DEPLOYER], &[], &[]),
        RESTART | LOCKOUT => to(&[], EVERYBODY, &[]),
        START_JUSTIFY | START_SEEK | GET_HOTBED => to(&[DETECTOR], &[], &[]),
        START_QUENCH | START_TRAJECTORY | SETUP_CORRECTION_TABLE => to(&[CONTROL], &[], &[]),
        CLEAN_FLASH => to(&[GENERAL], &[], &[]),
        GET_CRASH_DATA => to(&[GENERAL], &[GENERAL], &[]),
        _ => unreachable!("{request:#04x} is not a request of the document"),
    }
}

/// The parameters (§P) and the number of their values; `Err` when they can only be read, and then
/// how many bytes there are now.
fn param_of(device: u8, id: u16) -> Option<Result<fn(usize) -> bool, usize>> {
    fn one(len: usize) -> bool {
        len == 1
    }
    fn seven(len: usize) -> bool {
        len == 7
    }
    fn points(len: usize) -> bool {
        len <= 60 && len % 4 == 0
    }
    const DRIVE: &[&str] = &[
        "MinLimit",
        "MaxLimit",
        "ZeroPoint",
        "Speed",
        "Acceleration",
        "MaxCurrent",
        "SlowCurrent",
        "DriveType",
    ];
    let own: &[&str] = match device {
        GENERAL => &[
            "Address",
            "Chain",
            "MainVoltageMin",
            "MainVoltageMax",
            "PressureRange",
            "ResetValves",
            "MoveTimeout",
        ],
        CLIMATICS => &["HeatOn", "HeatOff"],
        NOZZLE => &["TrvPosition"],
        DEPLOYER => &["TravelTime"],
        VALVE1 | VALVE2 => &["TravelTime", "ValveType", "MaxCurrent"],
        CONTROL => &["Ballistics", "NozzleDiameter", "Height"],
        DETECTOR => {
            &["JustifyHorizontal", "JustifyVertical", "ScanStep", "FieldOfView", "Threshold"]
        }
        EXTERNAL_CONN | RADIO => &["Timeout"],
        _ => &[],
    };
    let of_drive = if DRIVES.contains(&device) { DRIVE } else { &[] };
    if own.iter().chain(of_drive).any(|name| hash16(name) == id) {
        return Some(Ok(one));
    }
    match device {
        GENERAL if id == 0xE8C1 => Some(Err(80)),
        DETECTOR if id == 0x23FE => Some(Err(0)),
        CONTROL if (0..8).any(|n| hash16(&format!("Program{n}")) == id) => Some(Ok(seven)),
        CONTROL if (0..8).any(|n| hash16(&format!("Trajectory{n}")) == id) => Some(Ok(points)),
        _ => None,
    }
}

/// §1 of protocol.md: FNV-1a, folded to 16 bits.
fn hash16(name: &str) -> u16 {
    let hash = name
        .bytes()
        .fold(0x811C_9DC5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    (hash >> 16) as u16 ^ hash as u16
}

/// What the state of the monitor says to everything.
#[derive(Clone, Copy, PartialEq)]
enum Gate {
    Open,
    Locked,
    Restarting,
}

/// A monitor in a state, and what the rules must know of it.
struct State {
    name: &'static str,
    rig: Rig,
    gate: Gate,
    /// There is a Deployer and it is wrapped.
    wrapped: bool,
    /// Nothing is stored.
    erased: bool,
    /// Drives have limit switches.
    switches: bool,
}

impl State {
    fn of(name: &'static str, rig: Rig) -> Self {
        Self { name, rig, gate: Gate::Open, wrapped: false, erased: false, switches: false }
    }

    fn has(&self, device: u8) -> bool {
        self.rig.device.has(SubsystemId(device))
    }
}

fn states() -> Vec<State> {
    let mut locked = Rig::deployed();
    locked.all_accept(Body::Lockout { key: 0x2FFA });
    locked.run(100);
    let mut restarting = Rig::deployed();
    restarting.all_accept(Body::Restart);
    restarting.run(50);
    let mut erased = Rig::new(Composition::FULL);
    erased.accepts(SubsystemId::GENERAL, Body::CleanFlash { key: 0xA4F6 });
    erased.run(500);
    assert!(erased.plant.memory.is_empty() && erased.plant.resets == 1);
    let wrapped = Rig::new(Composition::FULL);
    assert!(wrapped.clone().deployer().contains(DeployerFlags::WRAPPED));
    let switches = Rig::new(Composition { drives: [SWITCHES; 4], ..Composition::REMOTE });
    vec![
        State { wrapped: true, ..State::of("wrapped", wrapped) },
        State::of("deployed", Rig::deployed()),
        State { gate: Gate::Locked, ..State::of("locked out", locked) },
        State { gate: Gate::Restarting, ..State::of("restarting", restarting) },
        State { wrapped: true, erased: true, ..State::of("erased", erased) },
        State::of("without Deployer", Rig::new(Composition::REMOTE)),
        State { switches: true, ..State::of("limit switches", switches) },
    ]
}

const SWITCHES: lafet_device::composition::DriveKind =
    lafet_device::composition::DriveKind::LimitSwitches;

/// An answer that may come: from whom, with which of these statuses, with how much data.
struct Expected {
    from: u8,
    statuses: &'static [u8],
    size: usize,
}

const OK: &[u8] = &[0];
const ACCEPTED: &[u8] = &[1];
const NEED_CONFIRM: &[u8] = &[2];
const DENIED: &[u8] = &[3];
const MODULE_NOT_EXIST: &[u8] = &[4];
const MODULE_FAULT: &[u8] = &[5];
const BUSY: &[u8] = &[6];
const WRONG_REQUEST: &[u8] = &[7];
const WRONG_DATA: &[u8] = &[8];
const INVALID_ID: &[u8] = &[10];
const INVALID_VALUE: &[u8] = &[11];
const ACCESS_DENIED: &[u8] = &[12];
const INCOMPLETE: &[u8] = &[14];
const NOT_SUPPORTED: &[u8] = &[18];
/// Whether the values suit is not this test's business.
const ACCEPTED_OR_INVALID: &[u8] = &[1, 11];
const INCOMPLETE_OR_INVALID: &[u8] = &[1, 11, 14];

/// §1/11: the order of checks.
fn expected(state: &State, request: u8, device: u8, data: &[u8]) -> Vec<Expected> {
    let bare = |from, statuses| vec![Expected { from, statuses, size: 0 }];
    let passes = READS.contains(&request) || matches!(request, SET_PARAM | LOCKOUT);
    match state.gate {
        Gate::Locked if !passes => return bare(GENERAL, DENIED),
        Gate::Restarting if !READS.contains(&request) => return bare(GENERAL, BUSY),
        _ => {}
    }
    if !KNOWN.contains(&request) {
        return bare(GENERAL, WRONG_REQUEST);
    }
    let who = addressees(request);
    if device == ALL || device == MOTORS {
        let who = if device == ALL { who.all } else { who.motors };
        let answering = CHAIN.iter().filter(|(id, _)| who.contains(id) && state.has(*id));
        let answers: Vec<_> =
            answering.map(|(id, _)| execution(state, request, *id, data, true)).collect();
        return if answers.is_empty() { bare(GENERAL, WRONG_REQUEST) } else { answers };
    }
    if !state.has(device) {
        return bare(device, MODULE_NOT_EXIST);
    }
    if !who.one.contains(&device) {
        return bare(device, WRONG_REQUEST);
    }
    if state.wrapped && matches!(request, MOVE | OPEN | START_JUSTIFY) {
        return bare(DEPLOYER, DENIED);
    }
    // What would have to deploy first is refused by a Deployer that cannot (without parameters).
    if state.erased && matches!(request, START_QUENCH | START_TRAJECTORY | START_SEEK) {
        return bare(DEPLOYER, MODULE_FAULT);
    }
    vec![execution(state, request, device, data, false)]
}

/// What the addressee answers: size, key, values, then the execution.
fn execution(state: &State, request: u8, from: u8, data: &[u8], broadcast: bool) -> Expected {
    let bare = |statuses| Expected { from, statuses, size: 0 };
    let with_data = |size| Expected { from, statuses: OK, size };
    let size = data.len();
    let right = match request {
        MOVE | GET_PARAM | OPEN | CLOSE | SWITCH_LIMITS | LOCKOUT | CLEAN_FLASH => size == 2,
        SET_PARAM => size >= 2 && (size - 2) % 4 == 0,
        SETUP_CORRECTION_TABLE => size >= 2,
        START_QUENCH => size == 8 || size >= 12,
        START_TRAJECTORY => match data {
            [0, _, count, rest @ ..] => rest.len() == 6 * usize::from(*count),
            [1, _, count, rest @ ..] => rest.len() == usize::from(*count),
            _ => size >= 3,
        },
        START_SEEK => size == 10,
        _ => size == 0,
    };
    if !right {
        return bare(WRONG_DATA);
    }
    let word = || u16::from_le_bytes([data[0], data[1]]);
    match request {
        GET_STATUS => {
            with_data(CHAIN.iter().find(|(id, _)| *id == from).map(|(_, size)| *size).unwrap())
        }
        STOP if broadcast || !state.erased => bare(OK),
        // The monitor stands, but a drive or valve without parameters is faulty (§3.2/5).
        STOP if matches!(from, CONTROL | DETECTOR | DEPLOYER) => bare(&[0, 5]),
        STOP => bare(MODULE_FAULT),
        GET_CRASH_DATA => with_data(80),
        GET_HOTBED => with_data(2),
        RETRIEVE_LIMITS => with_data(8),
        GET_PARAM => get_param(state, from, word()),
        SET_PARAM => set_param(state, from, data),
        SETUP_CORRECTION_TABLE if usize::from(data[0]) + size - 1 > 256 => bare(INVALID_VALUE),
        SETUP_CORRECTION_TABLE => bare(ACCEPTED),
        OPEN if word() != 0x4C70 => bare(NEED_CONFIRM),
        CLOSE if word() != 0x7456 => bare(NEED_CONFIRM),
        CLEAN_FLASH if word() != 0xA4F6 => bare(NEED_CONFIRM),
        LOCKOUT if ![0x2FFA, 0x7353].contains(&word()) => bare(INVALID_VALUE),
        SWITCH_LIMITS if word() > 2 => bare(INVALID_VALUE),
        SWITCH_LIMITS if state.switches => bare(NOT_SUPPORTED),
        WRAP if state.wrapped => bare(if state.erased { MODULE_FAULT } else { OK }),
        WRAP => bare(ACCEPTED),
        DEPLOY if state.erased => bare(MODULE_FAULT),
        DEPLOY => bare(if state.wrapped { ACCEPTED } else { OK }),
        START_QUENCH | START_TRAJECTORY | START_SEEK => start(request, data),
        RESTART | LOCKOUT | SWITCH_LIMITS | CLEAN_FLASH => bare(OK),
        _ => bare(ACCEPTED),
    }
}

fn get_param(state: &State, from: u8, id: u16) -> Expected {
    let (statuses, size) = match param_of(from, id) {
        None => (INVALID_ID, 0),
        Some(Err(size)) => (OK, size),
        Some(Ok(fits)) if fits(7) => (OK, 28),
        Some(Ok(fits)) if fits(0) => (OK, 0),
        Some(Ok(_)) if state.erased => (INCOMPLETE, 0),
        Some(Ok(_)) => (OK, 4),
    };
    Expected { from, statuses, size: 2 + size }
}

fn set_param(state: &State, from: u8, data: &[u8]) -> Expected {
    let id = u16::from_le_bytes([data[0], data[1]]);
    let (statuses, size) = match param_of(from, id) {
        None => (INVALID_ID, 2),
        Some(Err(_)) => (ACCESS_DENIED, 2),
        Some(Ok(fits)) if !fits((data.len() - 2) / 4) => (WRONG_DATA, 0),
        Some(Ok(_)) if state.erased => (INCOMPLETE_OR_INVALID, 2),
        Some(Ok(_)) => (ACCEPTED_OR_INVALID, 2),
    };
    Expected { from, statuses, size }
}

/// §3.14–§3.16: values that cannot be right must be InvalidValue; whether the rest suits the
/// limits is not this test's business.
fn start(request: u8, data: &[u8]) -> Expected {
    let word = |at: usize| i16::from_le_bytes([data[at], data[at + 1]]);
    let (from, statuses) = match request {
        START_QUENCH if data.len() == 8 => {
            (CONTROL, if (0..8).contains(&word(0)) { ACCEPTED_OR_INVALID } else { INVALID_VALUE })
        }
        START_QUENCH => {
            let step = data[10].cast_signed();
            let distance = if data.len() == 12 { data[11].cast_signed() } else { 0 };
            let negative = word(6) < 0 || word(8) < 0 || step < 0 || distance < 0;
            (CONTROL, if negative { INVALID_VALUE } else { ACCEPTED_OR_INVALID })
        }
        START_SEEK => {
            (DETECTOR, if [0, 1].contains(&word(8)) { ACCEPTED_OR_INVALID } else { INVALID_VALUE })
        }
        _ => {
            let wrong = data[0] > 1 || data[1] > 3 || data[2] == 0;
            let numbers = data[0] == 1 && data[3..].iter().any(|number| *number > 7);
            (
                CONTROL,
                match data[0] {
                    _ if wrong || numbers => INVALID_VALUE,
                    1 => INVALID_ID,
                    _ => ACCEPTED,
                },
            )
        }
    };
    Expected { from, statuses, size: 0 }
}

/// Arbitrary but reproducible.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }
}

/// What is checked of a state, and with what.
struct Check<'a> {
    state: &'a State,
    device: Device,
    noise: Noise,
    bytes: Vec<u8>,
    executed: u64,
    refused: u64,
    sampled: u64,
    /// Outputs of the next steps when nothing has been asked.
    quiet: [Outputs; 3],
}

impl<'a> Check<'a> {
    fn of(state: &'a State, seed: u64) -> Self {
        let mut noise = Noise(seed);
        let bytes = (0..8192).flat_map(|_| noise.next().to_le_bytes()).collect();
        let device = state.rig.device.clone();
        let quiet = next_outputs(&state.rig, &device);
        Self { state, device, noise, bytes, executed: 0, refused: 0, sampled: 0, quiet }
    }

    /// Asks with arbitrary data; in a share of the cases with a key or parameter that there is.
    fn ask(&mut self, request: u8, device: u8, size: u8) {
        let random = self.noise.next();
        let at = (random >> 8) as usize % (self.bytes.len() - 256);
        let mut payload = [0; 4 + 255];
        payload[..4].copy_from_slice(&[request, device, random as u8, size]);
        let data = &mut payload[4..4 + usize::from(size)];
        data.copy_from_slice(&self.bytes[at..at + usize::from(size)]);
        if KNOWN.contains(&request) && random >> 40 & 1 == 0 {
            suit(request, device, data, random >> 41);
        }
        let len = 4 + usize::from(size);
        self.judge(&payload[..len], random >> 32 & 0xFFF == 0);
    }

    fn judge(&mut self, payload: &[u8], sample: bool) {
        let mut out = [0; ROOM];
        let now_ms = self.state.rig.now_ms;
        let len = self.device.handle(now_ms, Source::Radio, payload, &mut out);
        let answer = &out[..len];
        let (request, device) = (payload[0], payload[1]);
        if !KNOWN.contains(&request) {
            let status = match self.state.gate {
                Gate::Open => 7,
                Gate::Locked => 3,
                Gate::Restarting => 6,
            };
            assert_eq!(
                answer,
                [request, GENERAL, status, 0],
                "{}: {payload:02x?}",
                self.state.name
            );
            self.refused += 1;
        } else {
            let changed = self.compare(payload, answer);
            if changed && !READS.contains(&request) {
                self.executed += 1;
                self.device = self.state.rig.device.clone();
                return;
            }
            self.refused += u64::from(!changed);
        }
        if sample {
            self.sampled += 1;
            let outputs = next_outputs(&self.state.rig, &self.device);
            let name = self.state.name;
            assert!(outputs == self.quiet, "{name}: {request:#04x} to {device:#04x} was refused");
        }
    }

    /// Compares the answer with the rules; true when anything may have been executed.
    fn compare(&self, payload: &[u8], answer: &[u8]) -> bool {
        let name = self.state.name;
        let (request, data) = (payload[0], &payload[4..]);
        let expected = expected(self.state, request, payload[1], data);
        let records: Vec<_> = Records::new(answer).collect();
        assert_eq!(records.len(), expected.len(), "{name}: {payload:02x?} → {answer:02x?}");
        let mut changed = false;
        for (record, expected) in records.iter().zip(&expected) {
            let record = record.expect("whole records");
            let decoded = Answer::decode(&record);
            assert!(decoded.is_ok(), "{name}: {payload:02x?} → {answer:02x?}: {decoded:?}");
            let same = record.request.0 == request
                && record.device.0 == expected.from
                && (expected.statuses.contains(&record.status.0) || record.status.0 == 17)
                && record.data.len() == expected.size;
            assert!(
                same,
                "{name}: {payload:02x?} → {record:?}, not {:#04x} {:?} with {} bytes",
                expected.from, expected.statuses, expected.size
            );
            // §3.14/8, §3.16/2: a sector outside the limits shows in the flags; §3.2/5: what is
            // faulty stops all the same.
            changed |= match record.status {
                Status::OK | Status::ACCEPTED | Status::INCOMPLETE_CONFIG => true,
                Status::INVALID_VALUE => matches!(request, START_QUENCH | START_SEEK),
                Status::MODULE_FAULT => request == STOP,
                _ => false,
            };
        }
        changed
    }
}

fn next_outputs(rig: &Rig, device: &Device) -> [Outputs; 3] {
    let mut rig = Rig { device: device.clone(), ..rig.clone() };
    [(); 3].map(|()| {
        rig.step(10);
        rig.plant.outputs
    })
}

/// Makes the start of the data a key, a parameter or numbers that are likely to be right.
fn suit(request: u8, device: u8, data: &mut [u8], random: u64) {
    let put = |data: &mut [u8], at: usize, value: u16| {
        if let Some(place) = data.get_mut(at..at + 2) {
            place.copy_from_slice(&value.to_le_bytes());
        }
    };
    let keys = [0x4C70, 0x7456, 0xA4F6, 0x2FFA, 0x7353, 0, 1, 2];
    match request {
        GET_PARAM | SET_PARAM => {
            let known: Vec<u16> = names(device).map(|name| hash16(&name)).collect();
            let any = known.get(random as usize % known.len().max(1)).copied().unwrap_or(0x23FE);
            put(data, 0, any);
            // Mostly small values, which are in range more often.
            data.iter_mut()
                .skip(2)
                .for_each(|byte| *byte &= if random >> 8 & 1 == 0 { 3 } else { 0xFF });
            if random >> 9 & 1 == 0 {
                data.iter_mut()
                    .skip(2)
                    .enumerate()
                    .filter(|(at, _)| at % 4 != 0)
                    .for_each(|(_, byte)| *byte = 0);
            }
        }
        START_QUENCH => {
            put(data, 0, random as u16 & 7);
            for at in [2, 4, 6, 8] {
                put(data, at, (random >> at) as u16 & 63);
            }
            data.iter_mut().skip(10).take(2).for_each(|byte| *byte &= 0x7F);
        }
        START_TRAJECTORY if data.len() >= 4 => {
            let rest = data.len() - 3;
            let mode = u8::from(rest % 6 != 0);
            let count = if mode == 0 { rest / 6 } else { rest };
            data[..3].copy_from_slice(&[mode, random as u8 & 3, count as u8]);
            data[3..].iter_mut().for_each(|byte| *byte &= 7);
        }
        START_SEEK => {
            for at in [0, 2, 4, 6] {
                put(data, at, (random >> at) as u16 & 255);
            }
            put(data, 8, (random >> 9) as u16 & 1);
        }
        _ => put(data, 0, keys[random as usize % keys.len()]),
    }
}

/// Every parameter's name that a subsystem might have.
fn names(device: u8) -> impl Iterator<Item = String> {
    let common = ["MinLimit", "MaxLimit", "ZeroPoint", "Speed", "DriveType", "TravelTime"];
    let more = ["Timeout", "HeatOn", "Threshold", "Height", "Address", "FaultInfo", "Hotbeds"];
    let numbered = (0..8).flat_map(|n| [format!("Program{n}"), format!("Trajectory{n}")]);
    let all = common.into_iter().chain(more).map(String::from).chain(numbered);
    all.filter(move |name| param_of(device, hash16(name)).is_some())
}

fn all_combinations(state: &State, requests: std::ops::RangeInclusive<u8>) -> (u64, u64, u64) {
    let mut check = Check::of(state, u64::from(*requests.start()) + 1);
    for request in requests {
        for device in 0..=255 {
            for size in 0..=255 {
                check.ask(request, device, size);
            }
        }
        if KNOWN.contains(&request) {
            // Once more with other data, where the data matter.
            for (device, _) in CHAIN.into_iter().chain([(ALL, 0), (MOTORS, 0)]) {
                for size in (0..=255).chain([0, 2, 6, 8, 10, 12, 30].repeat(64)) {
                    check.ask(request, device, size);
                }
            }
        }
    }
    (check.executed, check.refused, check.sampled)
}

/// §1/2, §1/3, §1/4, §1/5, §1/6, §1/7, §1/10, §1/11, §1/12, §2/1, §2/3, §2/4, §3.3/2, §3.12/2,
/// §3.18/2, §3.18/3: each combination gets the one answer that the document's tables give it,
/// and what was refused changes no output.
#[test]
fn every_combination_is_answered_as_the_tables_say() {
    for state in states() {
        let state = &state;
        let halves = std::thread::scope(|scope| {
            let lower = scope.spawn(|| all_combinations(state, 0..=0x7F));
            let upper = scope.spawn(|| all_combinations(state, 0x80..=0xFF));
            [lower, upper].map(|half| half.join().expect("a combination was answered wrongly"))
        });
        let [(e1, r1, s1), (e2, r2, s2)] = halves;
        let (executed, refused, sampled) = (e1 + e2, r1 + r2, s1 + s2);
        assert!(executed + refused > (1 << 24) - 100_000, "{}: {executed} {refused}", state.name);
        assert!(sampled > 3000, "{}: only {sampled} refusals were followed", state.name);
        // Waiting for the reset nothing is executed, otherwise the rules above prove too little.
        let enough = if state.gate == Gate::Restarting { 0..1 } else { 100..u64::MAX };
        assert!(enough.contains(&executed), "{}: {executed} executed", state.name);
    }
}

/// §1/8, §1/9, §2/2, §2/5: frames of arbitrary bytes, cut anywhere, into any buffer: no panic, whole
/// records, never more than fits, and after the records that were answered nothing has changed.
#[test]
fn arbitrary_frames() {
    for state in states() {
        let mut noise = Noise(77);
        let known: Vec<u8> = EVERYBODY.iter().copied().chain([ALL, MOTORS]).collect();
        let mut device = state.rig.device.clone();
        for round in 0..60_000_u32 {
            let random = noise.next();
            let len = random as usize % 97;
            let mut payload: Vec<u8> = (0..len).map(|_| (noise.next() >> 13) as u8).collect();
            // Half of them begin like records, so that there are more than one.
            if random >> 20 & 1 == 0 {
                for start in (0..len.saturating_sub(3)).step_by(6) {
                    payload[start] = KNOWN[payload[start] as usize % KNOWN.len()];
                    payload[start + 1] = known[payload[start + 1] as usize % known.len()];
                    payload[start + 3] = 2;
                }
            }
            let room = (random >> 32) as usize % 200;
            let mut out = vec![0xEE; room];
            let written = device.handle(state.rig.now_ms, Source::Radio, &payload, &mut out);
            assert!(written <= room);
            assert!(Records::new(&out[..written]).all(|record| record.is_ok()));
            assert!(out[written..].iter().all(|byte| *byte == 0xEE), "bytes behind the answer");
            assert!(payload.is_empty() == (written == 0) || room < 4, "{payload:02x?} {room}");
            if round % 16 == 0 {
                device = state.rig.device.clone();
            }
        }
    }
}

/// §1/9, §1/10: the answer to the longest broadcast fits the usual buffer with much to spare.
#[test]
fn every_status_fits() {
    for composition in Composition::ALL {
        let mut rig = Rig::new(composition);
        let size: usize =
            rig.ask(SubsystemId::ALL, Body::GetStatus).iter().map(|r| 4 + r.data.len()).sum();
        let present = CHAIN.iter().filter(|(id, _)| rig.device.has(SubsystemId(*id)));
        assert_eq!(size, present.map(|(_, size)| 4 + size).sum::<usize>(), "{}", composition.name);
        assert!(size <= 146);
        assert!(rig.is_still() && rig.drive(Axis::Vertical).speed == 0);
    }
}
