//! The document's tables once more: who, what, how long.

pub const ALL: u8 = 0x5D;
pub const MOTORS: u8 = 0xAB;
pub const GENERAL: u8 = 0xC2;
pub const CLIMATICS: u8 = 0x62;
pub const VERTICAL: u8 = 0x0D;
pub const HORIZONTAL: u8 = 0x85;
pub const NOZZLE: u8 = 0x98;
pub const VALVE1: u8 = 0xA6;
pub const VALVE2: u8 = 0xC7;
pub const CONTROL: u8 = 0x45;
pub const DETECTOR: u8 = 0xC8;
pub const DEPLOYER: u8 = 0xA2;
pub const EXTERNAL_CONN: u8 = 0x09;
pub const RADIO: u8 = 0x8E;
pub const BUTTONS: u8 = 0xD4;
pub const EXT_BUTTONS: u8 = 0x52;

/// §1/1, each with the size of its status (§3.3).
pub const CHAIN: [(u8, usize); 14] = [
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

pub const MOVE: u8 = 0x4D;
pub const STOP: u8 = 0x46;
pub const GET_STATUS: u8 = 0xD4;
pub const GET_PARAM: u8 = 0x9D;
pub const SET_PARAM: u8 = 0xF1;
pub const SETUP_CORRECTION_TABLE: u8 = 0x86;
pub const RETRIEVE_LIMITS: u8 = 0x80;
pub const OPEN: u8 = 0x21;
pub const CLOSE: u8 = 0x24;
pub const DEPLOY: u8 = 0x7E;
pub const WRAP: u8 = 0x8D;
pub const RESTART: u8 = 0x0A;
pub const START_JUSTIFY: u8 = 0x55;
pub const START_QUENCH: u8 = 0xC5;
pub const START_TRAJECTORY: u8 = 0x5C;
pub const START_SEEK: u8 = 0x76;
pub const SWITCH_LIMITS: u8 = 0xD9;
pub const GET_HOTBED: u8 = 0x9C;
pub const LOCKOUT: u8 = 0xE9;
pub const CLEAN_FLASH: u8 = 0x16;
pub const GET_CRASH_DATA: u8 = 0x06;

pub const KNOWN: [u8; 21] = [
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
pub const READS: [u8; 5] = [GET_STATUS, GET_PARAM, RETRIEVE_LIMITS, GET_HOTBED, GET_CRASH_DATA];

pub const DRIVES: &[u8] = &[DEPLOYER, NOZZLE, HORIZONTAL, VERTICAL];
pub const STOPPABLE: &[u8] =
    &[DEPLOYER, DETECTOR, CONTROL, VALVE2, VALVE1, NOZZLE, HORIZONTAL, VERTICAL];

/// The lines «Адресаты» of §3: one subsystem, and those that answer All and Motors.
pub struct Addressees {
    pub one: &'static [u8],
    pub all: &'static [u8],
    pub motors: &'static [u8],
}

pub const EVERYBODY: &[u8] = &[
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

pub fn addressees(request: u8) -> Addressees {
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

/// A parameter (§P).
pub enum Known {
    /// Whether it can have this number of values.
    Settable(fn(usize) -> bool),
    /// It can only be read, and has this many bytes now.
    ReadOnly(usize),
}

/// The parameters of a subsystem.
pub fn param_of(device: u8, id: u16) -> Option<Known> {
    fn one(len: usize) -> bool {
        len == 1
    }
    fn seven(len: usize) -> bool {
        len == 7
    }
    fn points(len: usize) -> bool {
        len <= 60 && len.is_multiple_of(4)
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
        return Some(Known::Settable(one));
    }
    match device {
        GENERAL if id == 0xE8C1 => Some(Known::ReadOnly(80)),
        GENERAL if id == hash16("InputFaults") => Some(Known::ReadOnly(4)),
        DETECTOR if id == 0x23FE => Some(Known::ReadOnly(0)),
        CONTROL if (0..8).any(|n| hash16(&format!("Program{n}")) == id) => {
            Some(Known::Settable(seven))
        }
        CONTROL if (0..8).any(|n| hash16(&format!("Trajectory{n}")) == id) => {
            Some(Known::Settable(points))
        }
        _ => None,
    }
}

/// §1 of protocol.md: FNV-1a, folded to 16 bits.
pub fn hash16(name: &str) -> u16 {
    let hash = name
        .bytes()
        .fold(0x811C_9DC5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    (hash >> 16) as u16 ^ hash as u16
}

/// Every parameter's name that a subsystem might have.
pub fn names(device: u8) -> impl Iterator<Item = String> {
    let common = ["MinLimit", "MaxLimit", "ZeroPoint", "Speed", "DriveType", "TravelTime"];
    let more = ["Timeout", "HeatOn", "Threshold", "Height", "Address", "FaultInfo", "Hotbeds"];
    let numbered = (0..8).flat_map(|n| [format!("Program{n}"), format!("Trajectory{n}")]);
    let all = common.into_iter().chain(more).map(String::from).chain(numbered);
    all.filter(move |name| param_of(device, hash16(name)).is_some())
}
