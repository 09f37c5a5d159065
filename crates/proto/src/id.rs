//! §1 «Общие сведения», §2 «Формат заголовка»: identifiers of subsystems, requests, statuses.

use crate::hash::{conv8, fnv1a32, fold16};

/// Declares an open set of one-byte ids, each Conv8(FNV-1a(name)).
///
/// The literal and the hash are compared at compile time.
macro_rules! hashed_ids {
    ($(#[$doc:meta])* $type:ident { $($(#[$item:meta])* $konst:ident = $value:literal $name:literal,)+ }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(transparent)]
        pub struct $type(pub u8);

        impl $type {
            $($(#[$item])* pub const $konst: Self = Self($value);)+

            /// Every identifier the document names, in the document's order.
            pub const KNOWN: &'static [(Self, &'static str)] = &[$((Self::$konst, $name),)+];

            /// The document's name; `None` for an id that is not in the document.
            pub const fn name(self) -> Option<&'static str> {
                match self.0 {
                    $($value => Some($name),)+
                    _ => None,
                }
            }

            /// The identifier of a name; the match is exact.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::KNOWN.iter().find(|(_, known)| *known == name).map(|(id, _)| *id)
            }
        }

        $(const _: () = assert!(conv8(fnv1a32($name)) == $value);)+

        impl_id_fmt!($type, "{:#04x}");
    };
}

/// Prints the name of a known id, otherwise the number.
macro_rules! impl_id_fmt {
    ($type:ident, $format:literal) => {
        impl core::fmt::Display for $type {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                match self.name() {
                    Some(name) => f.pad(name),
                    None => write!(f, $format, self.0),
                }
            }
        }

        impl core::fmt::Debug for $type {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                core::fmt::Display::fmt(self, f)
            }
        }
    };
}

hashed_ids! {
    /// A subsystem of the monitor (§1), one byte; unknown values are kept.
    SubsystemId {
        /// Every subsystem that can handle the request.
        ALL = 0x5D "All",
        /// Every drive that can handle the request.
        MOTORS = 0xAB "Motors",
        /// Configuration, supply voltage, pressure; answers requests that no other subsystem takes.
        GENERAL = 0xC2 "General",
        /// Temperatures, humidity, heating.
        CLIMATICS = 0x62 "Climatics",
        /// Drive of elevation.
        VERTICAL = 0x0D "Vertical",
        /// Drive of traverse.
        HORIZONTAL = 0x85 "Horizontal",
        /// Drive of the nozzle.
        NOZZLE = 0x98 "Nozzle",
        /// Valve 1, water.
        VALVE1 = 0xA6 "Valve1",
        /// Valve 2, foam.
        VALVE2 = 0xC7 "Valve2",
        /// Coordinated control: programs of extinguishing.
        CONTROL = 0x45 "Control",
        /// Fire detector on the barrel.
        DETECTOR = 0xC8 "Detector",
        /// Deployment from standby to working position and back.
        DEPLOYER = 0xA2 "Deployer",
        /// Wired interface.
        EXTERNAL_CONN = 0x09 "ExternalConn",
        /// Radio interface.
        RADIO = 0x8E "Radio",
        /// Button post.
        BUTTONS = 0xD4 "Buttons",
        /// Remote button post.
        EXT_BUTTONS = 0x52 "ExtButtons",
    }
}

impl SubsystemId {
    /// All and Motors are only addressees; no answer comes from them (§1).
    pub const fn is_group(self) -> bool {
        matches!(self, Self::ALL | Self::MOTORS)
    }

    /// The 14 real subsystems in the table's order (§1): bit n of the parameter Chain is entry n.
    pub const TABLE: [Self; 14] = [
        Self::GENERAL,
        Self::CLIMATICS,
        Self::VERTICAL,
        Self::HORIZONTAL,
        Self::NOZZLE,
        Self::VALVE1,
        Self::VALVE2,
        Self::CONTROL,
        Self::DETECTOR,
        Self::DEPLOYER,
        Self::EXTERNAL_CONN,
        Self::RADIO,
        Self::BUTTONS,
        Self::EXT_BUTTONS,
    ];

    /// The chain of handlers (§1): each subsystem of the table is inserted in front of the one
    /// before, so that General is always last.
    pub const CHAIN: [Self; 14] = reversed(Self::TABLE);

    /// Vertical, Horizontal, Nozzle, Deployer: the drives that Motors addresses.
    pub const fn is_drive(self) -> bool {
        matches!(self, Self::VERTICAL | Self::HORIZONTAL | Self::NOZZLE | Self::DEPLOYER)
    }

    /// Valve1 or Valve2.
    pub const fn is_valve(self) -> bool {
        matches!(self, Self::VALVE1 | Self::VALVE2)
    }
}

impl RequestId {
    /// §3.3.1/4 What must not begin on a bad supply: motion, water, erasing.
    pub const fn needs_supply(self) -> bool {
        matches!(
            self,
            Self::MOVE
                | Self::OPEN
                | Self::DEPLOY
                | Self::WRAP
                | Self::START_JUSTIFY
                | Self::START_QUENCH
                | Self::START_TRAJECTORY
                | Self::START_SEEK
                | Self::CLEAN_FLASH
        )
    }
}

const fn reversed(table: [SubsystemId; 14]) -> [SubsystemId; 14] {
    let [a, b, c, d, e, f, g, h, i, j, k, l, m, n] = table;
    [n, m, l, k, j, i, h, g, f, e, d, c, b, a]
}

hashed_ids! {
    /// A request (§3), one byte; unknown values are kept.
    RequestId {
        /// §3.1 Move a drive to a position.
        MOVE = 0x4D "Move",
        /// §3.2 Stop what a subsystem does.
        STOP = 0x46 "Stop",
        /// §3.3 State of a subsystem.
        GET_STATUS = 0xD4 "GetStatus",
        /// §3.4 Read a parameter.
        GET_PARAM = 0x9D "GetParam",
        /// §3.5 Set a parameter.
        SET_PARAM = 0xF1 "SetParam",
        /// §3.6 Store the table of elevation corrections by pressure.
        SETUP_CORRECTION_TABLE = 0x86 "SetupCorrectionTable",
        /// §3.7 Limits of motion.
        RETRIEVE_LIMITS = 0x80 "RetrieveLimits",
        /// §3.8 Open a valve.
        OPEN = 0x21 "Open",
        /// §3.9 Close a valve.
        CLOSE = 0x24 "Close",
        /// §3.10 Deploy to the working position.
        DEPLOY = 0x7E "Deploy",
        /// §3.11 Wrap to the standby position.
        WRAP = 0x8D "Wrap",
        /// §3.12 Restart the program.
        RESTART = 0x0A "Restart",
        /// §3.13 Align the detector with the barrel.
        START_JUSTIFY = 0x55 "StartJustify",
        /// §3.14 Start extinguishing.
        START_QUENCH = 0xC5 "StartQuench",
        /// §3.15 Start extinguishing along trajectories.
        START_TRAJECTORY = 0x5C "StartTrajectory",
        /// §3.16 Start the search for fire.
        START_SEEK = 0x76 "StartSeek",
        /// §3.17 Switch the limits of motion off, on, or reject their change.
        SWITCH_LIMITS = 0xD9 "SwitchLimits",
        /// §3 The hotbeds found, as GetParam Hotbeds of §3.21.
        GET_HOTBED = 0x9C "GetHotbed",
        /// §3.18 Lock the monitor out, or release it.
        LOCKOUT = 0xE9 "Lockout",
        /// §3.19 Erase the non-volatile memory.
        CLEAN_FLASH = 0x16 "CleanFlash",
        /// §3.20 Registers saved at the last hardware fault.
        GET_CRASH_DATA = 0x06 "GetCrashData",
    }
}

/// Result of a request (§2), one byte; unknown values are kept.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct Status(pub u8);

macro_rules! statuses {
    ($($(#[$item:meta])* $konst:ident = $value:literal $name:literal,)+) => {
        impl Status {
            $($(#[$item])* pub const $konst: Self = Self($value);)+

            /// Every status of §2 in its order.
            pub const KNOWN: &'static [(Self, &'static str)] = &[$((Self::$konst, $name),)+];

            /// The document's name; `None` for a value that is not in the document.
            pub const fn name(self) -> Option<&'static str> {
                match self.0 {
                    $($value => Some($name),)+
                    _ => None,
                }
            }

            /// The status of a name; the match is exact.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::KNOWN.iter().find(|(_, known)| *known == name).map(|(id, _)| *id)
            }
        }
    };
}

statuses! {
    /// Carried out completely.
    OK = 0 "Ok",
    /// Accepted; only a fault can prevent it now.
    ACCEPTED = 1 "Accepted",
    /// The key that confirms the request is missing or wrong.
    NEED_CONFIRM = 2 "NeedConfirm",
    /// The state of a subsystem forbids it.
    DENIED = 3 "Denied",
    /// The addressee is not part of this monitor.
    MODULE_NOT_EXIST = 4 "ModuleNotExist",
    /// The addressee is faulty.
    MODULE_FAULT = 5 "ModuleFault",
    /// The addressee is busy: repeat later.
    BUSY = 6 "Busy",
    /// Unknown request, or not one for this addressee.
    WRONG_REQUEST = 7 "WrongRequest",
    /// Wrong size of the data.
    WRONG_DATA = 8 "WrongData",
    /// The answer does not fit the output buffer.
    NO_ROOM = 9 "NoRoom",
    /// No parameter of this identifier.
    INVALID_ID = 10 "InvalidId",
    /// Value out of range.
    INVALID_VALUE = 11 "InvalidValue",
    /// The parameter may not be accessed this way.
    ACCESS_DENIED = 12 "AccessDenied",
    /// Error inside the program.
    SYSTEM_FAULT = 13 "SystemFault",
    /// Other parameters of the subsystem are still unset: nothing is stored yet.
    INCOMPLETE_CONFIG = 14 "IncompleteConfig",
    /// Reading needs a remote unit: repeat later.
    NOT_CACHED = 15 "NotCached",
    /// Writing needs a remote unit: repeat later.
    CACHED = 16 "Cached",
    /// Not implemented in this subsystem.
    UNIMPLEMENTED = 17 "Unimplemented",
    /// Not supported by this kind of subsystem.
    NOT_SUPPORTED = 18 "NotSupported",
}

impl_id_fmt!(Status, "{:#04x}");

impl Status {
    /// Ok or Accepted: the request is or will be carried out (§2: Accepted is in most cases
    /// equivalent to Ok).
    pub const fn is_success(self) -> bool {
        matches!(self, Self::OK | Self::ACCEPTED)
    }
}

/// Identifier of a parameter: the 16-bit fold of its name (§3.4, §3.21).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct ParamId(pub u16);

impl ParamId {
    /// §3.21 The hotbeds found.
    pub const HOTBEDS: Self = Self(0x23FE);
    /// §3.20 Crash data, readable as a parameter of General.
    pub const FAULT_INFO: Self = Self(0xE8C1);

    /// The identifier of a name: its 16-bit hash.
    pub const fn of(name: &str) -> Self {
        Self(fold16(fnv1a32(name)))
    }
}

const _: () = assert!(ParamId::of("Hotbeds").0 == ParamId::HOTBEDS.0);
const _: () = assert!(ParamId::of("FaultInfo").0 == ParamId::FAULT_INFO.0);

impl core::fmt::Display for ParamId {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:#06x}", self.0)
    }
}

impl core::fmt::Debug for ParamId {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        core::fmt::Display::fmt(self, f)
    }
}

/// Keys that confirm a request (§3.8, §3.9, §3.18, §3.19).
pub mod key {
    use super::{fnv1a32, fold16};

    /// §3.8 Open.
    pub const OPEN: u16 = 0x4C70;
    /// §3.9 Close.
    pub const CLOSE: u16 = 0x7456;
    /// §3.19 CleanFlash.
    pub const CLEAN_FLASH: u16 = 0xA4F6;
    /// §3.18 Lockout on: the hash of "Enable".
    pub const ENABLE: u16 = 0x2FFA;
    /// §3.18 Lockout off: the hash of "Disable".
    pub const DISABLE: u16 = 0x7353;

    const _: () = assert!(fold16(fnv1a32("Enable")) == ENABLE);
    const _: () = assert!(fold16(fnv1a32("Disable")) == DISABLE);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// §1: the chain is a constant; General is last, the button posts first.
    #[test]
    fn chain_order() {
        let names: std::vec::Vec<_> =
            SubsystemId::CHAIN.iter().map(|id| id.name().unwrap()).collect();
        assert_eq!(
            names,
            [
                "ExtButtons",
                "Buttons",
                "Radio",
                "ExternalConn",
                "Deployer",
                "Detector",
                "Control",
                "Valve2",
                "Valve1",
                "Nozzle",
                "Horizontal",
                "Vertical",
                "Climatics",
                "General",
            ]
        );
    }

    /// §1, §2, §3: the sets are complete, without doubles, and unknown values survive.
    #[test]
    fn sets() {
        assert_eq!(SubsystemId::KNOWN.len(), 16);
        assert_eq!(RequestId::KNOWN.len(), 21);
        assert_eq!(Status::KNOWN.len(), 19);
        for (index, (status, _)) in Status::KNOWN.iter().enumerate() {
            assert_eq!(usize::from(status.0), index);
        }
        assert_eq!(std::format!("{}", SubsystemId(0x77)), "0x77");
        assert_eq!(RequestId::from_name("Wrap"), Some(RequestId::WRAP));
    }
}
