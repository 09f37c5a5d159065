//! §3.3 «GetStatus», §3.7, §3.20, §3.21: the structures that answers carry.
//!
//! All are packed and little-endian; each has `SIZE`, `from_bytes` and `to_bytes`.

use crate::flags::{
    ButtonsFlags, ClimaticsFlags, ConnFlags, ControlFlags, DeployerFlags, DetectorFlags,
    DriveFlags, GeneralFlags, ValveFlags,
};

/// State of the monitor as a whole (§3.3, §3.3.2), 10 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GeneralStatus {
    /// Flags.
    pub flags: GeneralFlags,
    /// Supply voltage, V.
    pub main_voltage: u16,
    /// Pressure of water or foam, 0.1 atm.
    pub pressure: u16,
    /// Flow, l/s.
    pub flowrate: u16,
}

impl GeneralStatus {
    /// Bytes on the wire.
    pub const SIZE: usize = 10;

    /// The structure of these bytes.
    #[inline]
    pub const fn from_bytes([a, b, c, d, v0, v1, p0, p1, f0, f1]: [u8; Self::SIZE]) -> Self {
        Self {
            flags: GeneralFlags::from_bits_retain(u32::from_le_bytes([a, b, c, d])),
            main_voltage: u16::from_le_bytes([v0, v1]),
            pressure: u16::from_le_bytes([p0, p1]),
            flowrate: u16::from_le_bytes([f0, f1]),
        }
    }

    /// Its bytes.
    #[inline]
    pub const fn to_bytes(self) -> [u8; Self::SIZE] {
        let [a, b, c, d] = self.flags.bits().to_le_bytes();
        let [v0, v1] = self.main_voltage.to_le_bytes();
        let [p0, p1] = self.pressure.to_le_bytes();
        let [f0, f1] = self.flowrate.to_le_bytes();
        [a, b, c, d, v0, v1, p0, p1, f0, f1]
    }
}

/// Climate inside the monitor (§3.3, §3.3.3), 16 bytes. Temperatures in 0.1 °C.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ThermoStatus {
    /// Flags.
    pub flags: ClimaticsFlags,
    /// Horizontal drive.
    pub horizontal: i16,
    /// Vertical drive.
    pub vertical: i16,
    /// Nozzle drive.
    pub nozzle: i16,
    /// Deployment drive.
    pub deployer: i16,
    /// Housing or control cabinet.
    pub housing: i16,
    /// Relative humidity in it, %.
    pub humidity: u16,
}

impl ThermoStatus {
    /// Bytes on the wire.
    pub const SIZE: usize = 16;

    /// The structure of these bytes.
    #[inline]
    pub const fn from_bytes(bytes: [u8; Self::SIZE]) -> Self {
        let [a, b, c, d, h0, h1, v0, v1, n0, n1, d0, d1, b0, b1, m0, m1] = bytes;
        Self {
            flags: ClimaticsFlags::from_bits_retain(u32::from_le_bytes([a, b, c, d])),
            horizontal: i16::from_le_bytes([h0, h1]),
            vertical: i16::from_le_bytes([v0, v1]),
            nozzle: i16::from_le_bytes([n0, n1]),
            deployer: i16::from_le_bytes([d0, d1]),
            housing: i16::from_le_bytes([b0, b1]),
            humidity: u16::from_le_bytes([m0, m1]),
        }
    }

    /// Its bytes.
    #[inline]
    pub const fn to_bytes(self) -> [u8; Self::SIZE] {
        let [a, b, c, d] = self.flags.bits().to_le_bytes();
        let [h0, h1] = self.horizontal.to_le_bytes();
        let [v0, v1] = self.vertical.to_le_bytes();
        let [n0, n1] = self.nozzle.to_le_bytes();
        let [d0, d1] = self.deployer.to_le_bytes();
        let [b0, b1] = self.housing.to_le_bytes();
        let [m0, m1] = self.humidity.to_le_bytes();
        [a, b, c, d, h0, h1, v0, v1, n0, n1, d0, d1, b0, b1, m0, m1]
    }
}

/// Declares a structure of flags, position, current and speed: drives and Deployer have one shape.
macro_rules! drive_like {
    ($(#[$doc:meta])* $type:ident, $flags:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $type {
            /// Flags.
            pub flags: $flags,
            /// Position, arc-minutes; of the nozzle, mm.
            pub position: i16,
            /// Motor current, 0.1 A. The document calls the field "temperature" and comments it
            /// as the current.
            pub current: u8,
            /// Speed that is set, °/s or mm/s.
            pub speed: u8,
        }

        impl $type {
            /// Bytes on the wire.
            pub const SIZE: usize = 8;

            /// The structure of these bytes.
            #[inline]
            pub const fn from_bytes([a, b, c, d, p0, p1, current, speed]: [u8; 8]) -> Self {
                Self {
                    flags: $flags::from_bits_retain(u32::from_le_bytes([a, b, c, d])),
                    position: i16::from_le_bytes([p0, p1]),
                    current,
                    speed,
                }
            }

            /// Its bytes.
            #[inline]
            pub const fn to_bytes(self) -> [u8; 8] {
                let [a, b, c, d] = self.flags.bits().to_le_bytes();
                let [p0, p1] = self.position.to_le_bytes();
                [a, b, c, d, p0, p1, self.current, self.speed]
            }
        }
    };
}

drive_like! {
    /// State of Vertical, Horizontal or Nozzle (§3.3, §3.3.4), 8 bytes.
    DriveStatus, DriveFlags
}
drive_like! {
    /// State of Deployer (§3.3, §3.3.8), 8 bytes.
    DeployerStatus, DeployerFlags
}

/// Declares a structure that is nothing but flags.
macro_rules! flags_only {
    ($(#[$doc:meta])* $type:ident, $flags:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $type {
            /// Flags.
            pub flags: $flags,
        }

        impl $type {
            /// Bytes on the wire.
            pub const SIZE: usize = 4;

            /// The structure of these bytes.
            #[inline]
            pub const fn from_bytes(bytes: [u8; 4]) -> Self {
                Self { flags: $flags::from_bits_retain(u32::from_le_bytes(bytes)) }
            }

            /// Its bytes.
            #[inline]
            pub const fn to_bytes(self) -> [u8; 4] {
                self.flags.bits().to_le_bytes()
            }
        }
    };
}

flags_only! {
    /// State of Valve1 or Valve2 (§3.3, §3.3.5).
    ValveStatus, ValveFlags
}
flags_only! {
    /// State of Control (§3.3, §3.3.6).
    ControlStatus, ControlFlags
}
flags_only! {
    /// State of Detector (§3.3, §3.3.7).
    DetectorStatus, DetectorFlags
}
flags_only! {
    /// State of ExternalConn or Radio (§3.3, §3.3.9).
    ConnStatus, ConnFlags
}
flags_only! {
    /// State of Buttons or ExtButtons (§3.3, §3.3.10).
    ButtonsStatus, ButtonsFlags
}

/// Limits of motion (§3.7), 8 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Lower / right / wider limit, arc-minutes or mm.
    pub min: i32,
    /// Upper / left / narrower limit, arc-minutes or mm.
    pub max: i32,
}

impl Limits {
    /// Bytes on the wire.
    pub const SIZE: usize = 8;

    /// The structure of these bytes.
    pub const fn from_bytes([a, b, c, d, e, f, g, h]: [u8; Self::SIZE]) -> Self {
        Self { min: i32::from_le_bytes([a, b, c, d]), max: i32::from_le_bytes([e, f, g, h]) }
    }

    /// Its bytes.
    pub const fn to_bytes(self) -> [u8; Self::SIZE] {
        let [a, b, c, d] = self.min.to_le_bytes();
        let [e, f, g, h] = self.max.to_le_bytes();
        [a, b, c, d, e, f, g, h]
    }
}

/// A fire that the detector has found (§3.21), 20 bytes. Edges in arc-minutes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hotbed {
    /// Left edge.
    pub x1: i32,
    /// Right edge.
    pub x2: i32,
    /// Lower edge.
    pub y1: i32,
    /// Upper edge.
    pub y2: i32,
    /// Brightness.
    pub brightness: i32,
}

impl Hotbed {
    /// Bytes on the wire.
    pub const SIZE: usize = 20;
    /// Most hotbeds in an answer.
    pub const MAX: usize = 4;

    /// As the values of the parameter Hotbeds.
    pub const fn to_values(self) -> [i32; 5] {
        [self.x1, self.x2, self.y1, self.y2, self.brightness]
    }

    /// From the values of the parameter Hotbeds.
    pub const fn from_values([x1, x2, y1, y2, brightness]: [i32; 5]) -> Self {
        Self { x1, x2, y1, y2, brightness }
    }
}

/// What a hardware fault left (§3.20): 20 words, 80 bytes on Cortex-M3.
///
/// The ten common words are followed by the architecture's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultInfo {
    /// Marks the block as filled; 0 when there was no fault.
    pub signature: u32,
    /// Architecture.
    pub archtype: u32,
    /// Stack pointer in the fault exception.
    pub spcr: u32,
    /// Stacked r0.
    pub r0: u32,
    /// Stacked r1.
    pub r1: u32,
    /// Stacked r2.
    pub r2: u32,
    /// Stacked r3.
    pub r3: u32,
    /// Stacked r12.
    pub r12: u32,
    /// Stacked link register.
    pub lr: u32,
    /// Stacked program counter.
    pub pc: u32,
    /// Registers of the architecture.
    pub arch: FaultArch,
}

/// The part of [`FaultInfo`] that differs with the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultArch {
    /// Ten words: tim2 cnt, tim3 cnt, tim4 cnt, tim5 cnt, hfsr, bfar, mmfar, cfsr, tcb, psr.
    CortexM3([u32; 10]),
    /// Two words: cpsr, spsr.
    Arm7Tdmi([u32; 2]),
}

impl FaultInfo {
    /// Bytes on the wire from a Cortex-M3.
    pub const SIZE: usize = 80;
    /// Bytes on the wire from an ARM7TDMI that does not pad the union.
    pub const SIZE_ARM7TDMI: usize = 48;
    /// Names of the common words, then of the Cortex-M3 ones.
    pub const NAMES: [&'static str; 20] = [
        "signature",
        "archtype",
        "spcr",
        "r0",
        "r1",
        "r2",
        "r3",
        "r12",
        "lr",
        "pc",
        "tim2_cnt",
        "tim3_cnt",
        "tim4_cnt",
        "tim5_cnt",
        "hfsr",
        "bfar",
        "mmfar",
        "cfsr",
        "tcb",
        "psr",
    ];
    /// Names of the ARM7TDMI's words.
    pub const NAMES_ARM7TDMI: [&'static str; 2] = ["cpsr", "spsr"];

    /// No fault recorded.
    pub const NONE: Self = Self::from_words([0; 20]);

    /// The block of a Cortex-M3.
    #[inline(never)]
    pub const fn from_words(words: [u32; 20]) -> Self {
        let [signature, archtype, spcr, r0, r1, r2, r3, r12, lr, pc, a, b, c, d, e, f, g, h, i, j] =
            words;
        Self {
            signature,
            archtype,
            spcr,
            r0,
            r1,
            r2,
            r3,
            r12,
            lr,
            pc,
            arch: FaultArch::CortexM3([a, b, c, d, e, f, g, h, i, j]),
        }
    }

    /// Twenty words; those an ARM7TDMI does not have are 0.
    #[inline(never)]
    pub const fn to_words(self) -> [u32; 20] {
        let [a, b, c, d, e, f, g, h, i, j] = match self.arch {
            FaultArch::CortexM3(words) => words,
            FaultArch::Arm7Tdmi([cpsr, spsr]) => [cpsr, spsr, 0, 0, 0, 0, 0, 0, 0, 0],
        };
        let Self { signature, archtype, spcr, r0, r1, r2, r3, r12, lr, pc, .. } = self;
        [signature, archtype, spcr, r0, r1, r2, r3, r12, lr, pc, a, b, c, d, e, f, g, h, i, j]
    }

    /// Reads 80 bytes (Cortex-M3) or 48 (ARM7TDMI); `None` for any other size.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        if bytes.len() != Self::SIZE && bytes.len() != Self::SIZE_ARM7TDMI {
            return None;
        }
        let mut words = [0; 20];
        for (word, chunk) in words.iter_mut().zip(bytes.as_chunks().0) {
            *word = u32::from_le_bytes(*chunk);
        }
        let mut info = Self::from_words(words);
        if let (Self::SIZE_ARM7TDMI, FaultArch::CortexM3([cpsr, spsr, ..])) =
            (bytes.len(), info.arch)
        {
            info.arch = FaultArch::Arm7Tdmi([cpsr, spsr]);
        }
        Some(info)
    }
}
