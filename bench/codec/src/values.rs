//! What all of them carry: the same values in plain structures.

/// An answer to GetStatus of a drive: header, flags, position, current, speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drive {
    pub request: u8,
    pub device: u8,
    pub status: u8,
    pub flags: u32,
    pub position: i16,
    pub current: u8,
    pub speed: u8,
}

impl Drive {
    /// An answer of Vertical.
    pub const SAMPLE: Self = Self {
        request: 0xD4,
        device: 0x0D,
        status: 0,
        flags: 0x0041_0000,
        position: 1200,
        current: 21,
        speed: 9,
    };
    /// Header and data.
    pub const SIZE: usize = 12;
}

/// The answer of a whole monitor: 14 subsystems.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Whole {
    pub general_flags: u32,
    /// Voltage, pressure, flow.
    pub general: [u16; 3],
    pub climatics_flags: u32,
    /// Temperatures and humidity.
    pub climatics: [i16; 6],
    /// Vertical, horizontal, nozzle, deployer: flags, position, current, speed.
    pub drives: [(u32, i16, u8, u8); 4],
    /// Valves, control, detector, connections, buttons.
    pub flags: [u32; 8],
}

impl Whole {
    /// A monitor at work.
    pub const SAMPLE: Self = Self {
        general_flags: 0x0001_0000,
        general: [24, 85, 19],
        climatics_flags: 0x0002_0000,
        climatics: [215, 221, 230, 219, 250, 41],
        drives: [
            (0x0041_0000, 1200, 21, 9),
            (0x0001_0000, -600, 17, 9),
            (0x0001_0000, 60, 4, 3),
            (0x0004_0000, 90, 0, 0),
        ],
        flags: [0x0001_0000, 0x0002_0000, 0x0010_0000, 0x0008_0000, 1, 2, 4, 8],
    };
    /// 14 headers and their data.
    pub const SIZE: usize = 146;
}

/// Bytes of one message.
pub const ROOM: usize = 640;
