//! §3.3.1–§3.3.10 «Флаги состояния»: the status bits of every class of subsystem.
//!
//! Each class has a file with the number of its section in `status`, where one table makes the bit
//! set and the dictionary. Names and bits follow the document; severities, causes and remedies are
//! ours. Bits that the document does not name are kept.

pub use crate::status::s3_03_01_common_flags::CommonFlags;
pub use crate::status::s3_03_02_general::GeneralFlags;
pub use crate::status::s3_03_03_climatics::ClimaticsFlags;
pub use crate::status::s3_03_04_drives::DriveFlags;
pub use crate::status::s3_03_05_valves::ValveFlags;
pub use crate::status::s3_03_06_control::ControlFlags;
pub use crate::status::s3_03_07_detector::DetectorFlags;
pub use crate::status::s3_03_08_deployer::DeployerFlags;
pub use crate::status::s3_03_09_connections::ConnFlags;
pub use crate::status::s3_03_10_buttons::{Button, ButtonState, ButtonsFlags};

use crate::dictionary::Key;
use crate::id::SubsystemId;

/// Severity of a flag (ours).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Severity {
    /// Normal operation.
    Info,
    /// Nothing is broken, but the operator should know it.
    Notice,
    /// A function is degraded or not prepared: correct it.
    Warning,
    /// Act now: a function is lost, or there is a fire.
    Alarm,
}

/// One flag (or two-bit field) of a status word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct FlagInfo {
    /// The document's name.
    pub name: &'static str,
    /// Number of the lowest bit.
    pub shift: u8,
    /// Number of bits: 2 for the state of a button, else 1.
    pub width: u8,
    /// Severity of the set flag; of a button, when its circuit is faulty.
    pub severity: Severity,
    /// What the flag means.
    pub meaning: Key,
    /// Usual causes.
    pub cause: Key,
    /// What to do.
    pub remedy: Key,
}

impl FlagInfo {
    /// The field's bits in the status word.
    pub const fn mask(&self) -> u32 {
        let ones = if self.width == 2 { 0b11 } else { 0b1 };
        u32::unbounded_shl(ones, self.shift as u32)
    }

    /// The value of the field in a status word.
    pub const fn value(&self, bits: u32) -> u32 {
        u32::unbounded_shr(bits & self.mask(), self.shift as u32)
    }

    /// The state of the button; `None` if the field is not a button.
    pub const fn button_state(&self, bits: u32) -> Option<ButtonState> {
        if self.width == 2 { Some(ButtonState::of(self.value(bits))) } else { None }
    }

    /// Severity of the field's value in this status word.
    pub fn severity_in(&self, bits: u32) -> Severity {
        match self.button_state(bits) {
            Some(ButtonState::Short | ButtonState::Open) => self.severity,
            None if self.value(bits) != 0 => self.severity,
            _ => Severity::Info,
        }
    }
}

/// The flags of one class of subsystems.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct FlagClass {
    /// Name of the class, that of its bit set.
    pub name: &'static str,
    /// Section of the document that lists its own flags.
    pub section: &'static str,
    /// The common flags (§3.3.1), then those of the class, by bit.
    pub flags: &'static [FlagInfo],
}

impl FlagClass {
    /// The fields of a status word that are not zero.
    pub fn set(&self, bits: u32) -> impl Iterator<Item = SetFlag> + Clone + use<> {
        let flags = self.flags;
        flags
            .iter()
            .filter(move |info| info.value(bits) != 0)
            .map(move |info| SetFlag { info, bits })
    }

    /// The bits of a status word that the document does not name.
    pub fn unnamed(&self, bits: u32) -> u32 {
        self.flags.iter().fold(bits, |rest, info| rest & !info.mask())
    }

    /// The highest severity of the fields that are set.
    pub fn severity(&self, bits: u32) -> Severity {
        self.set(bits).map(|flag| flag.severity()).max().unwrap_or(Severity::Info)
    }

    /// The flag with this name, in any case.
    pub fn by_name(&self, name: &str) -> Option<&'static FlagInfo> {
        self.flags.iter().find(|info| info.name.eq_ignore_ascii_case(name))
    }
}

/// A field that is not zero; printed as its name: `Move`, `LeftButtonState=Pressed`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SetFlag {
    /// The field.
    pub info: &'static FlagInfo,
    /// The whole status word.
    pub bits: u32,
}

impl SetFlag {
    /// Severity of the field's value.
    pub fn severity(&self) -> Severity {
        self.info.severity_in(self.bits)
    }
}

impl core::fmt::Display for SetFlag {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.info.button_state(self.bits) {
            Some(state) => write!(f, "{}={state:?}", self.info.name),
            None => f.write_str(self.info.name),
        }
    }
}

/// The flags of a subsystem; for All, Motors and unknown ones the common flags only.
pub const fn flags_of(subsystem: SubsystemId) -> &'static FlagClass {
    match subsystem {
        SubsystemId::GENERAL => &GeneralFlags::CLASS,
        SubsystemId::CLIMATICS => &ClimaticsFlags::CLASS,
        SubsystemId::VERTICAL | SubsystemId::HORIZONTAL | SubsystemId::NOZZLE => &DriveFlags::CLASS,
        SubsystemId::VALVE1 | SubsystemId::VALVE2 => &ValveFlags::CLASS,
        SubsystemId::CONTROL => &ControlFlags::CLASS,
        SubsystemId::DETECTOR => &DetectorFlags::CLASS,
        SubsystemId::DEPLOYER => &DeployerFlags::CLASS,
        SubsystemId::EXTERNAL_CONN | SubsystemId::RADIO => &ConnFlags::CLASS,
        SubsystemId::BUTTONS | SubsystemId::EXT_BUTTONS => &ButtonsFlags::CLASS,
        _ => &CommonFlags::CLASS,
    }
}

/// The fields that are not zero in a subsystem's status word.
pub fn set_flags(subsystem: SubsystemId, bits: u32) -> impl Iterator<Item = SetFlag> + Clone {
    flags_of(subsystem).set(bits)
}

/// Rows of `FLAG = bit width "Name" Severity Group;` become a bit set and its dictionary. The texts
/// are those of the group: `flag-Group-Name-meaning`, `-cause` and `-remedy`.
macro_rules! flag_rows {
    ($(#[$doc:meta])* $type:ident $section:literal
     $($flag:ident = $shift:literal $width:literal $name:literal $severity:ident $group:ident;)+) =>
         {
        bitflags::bitflags! {
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
            pub struct $type: u32 {
                $(
                    #[doc = concat!("`", $name, "`, bit ", stringify!($shift))]
                    const $flag = ((1 << $width) - 1) << $shift;
                )+
                const _ = !0;
            }
        }

        impl $type {
            /// The dictionary of these flags.
            pub const CLASS: $crate::flags::FlagClass = $crate::flags::FlagClass {
                name: stringify!($type),
                section: $section,
                flags: &[$($crate::flags::FlagInfo {
                    name: $name,
                    shift: $shift,
                    width: $width,
                    severity: $crate::flags::Severity::$severity,
                    meaning: $crate::dictionary::key!(
                        "flag-", stringify!($group), "-", $name, "-meaning"
                    ),
                    cause: $crate::dictionary::key!(
                        "flag-", stringify!($group), "-", $name, "-cause"
                    ),
                    remedy: $crate::dictionary::key!(
                        "flag-", stringify!($group), "-", $name, "-remedy"
                    ),
                }),+],
            };
        }

        #[cfg(test)]
        impl $crate::flags::Constants for $type {
            const CONSTANTS: &'static [(&'static str, u32)] =
                &[$((stringify!($flag), $type::$flag.bits())),+];
        }
    };
}

/// Puts the common flags (§3.3.1) before the class's own ones, which all have the same width.
macro_rules! flag_class {
    ($(#[$doc:meta])* $type:ident $section:literal, ConnLost $conn_lost:ident $conn_group:ident,
        width $width:literal;
     $($flag:ident = $shift:literal $name:literal $severity:ident $group:ident;)*) => {
        $crate::flags::flag_rows! {
            $(#[$doc])* $type $section
            CONFIG_FAULT = 0 1 "ConfigFault" Alarm Common;
            CONFIG_INVALID = 1 1 "ConfigInvalid" Warning Common;
            CONFIG_WRITE_FAULT = 2 1 "ConfigWriteFault" Warning Common;
            CONN_LOST = 3 1 "ConnLost" $conn_lost $conn_group;
            BAD_POWER = 4 1 "BadPower" Alarm Common;
            REMOTE_PA_INCOMPLETE = 5 1 "RemotePaIncomplete" Warning Common;
            REMOTE_PA_BAD_ID = 6 1 "RemotePaBadId" Warning Common;
            REMOTE_PA_BAD_VAL = 7 1 "RemotePaBadVal" Warning Common;
            REMOTE_PA_ERROR = 8 1 "RemotePaError" Warning Common;
            RESTARTING = 9 1 "Restarting" Notice Common;
            INTERNAL_FAULT = 10 1 "InternalFault" Alarm Common;
            WDT_FAULT = 11 1 "WdtFault" Warning Common;
            PROTOCOL_FAULT = 12 1 "ProtocolFault" Warning Common;
            DISABLED = 13 1 "Disabled" Notice Common;
            TERMINATED = 14 1 "Terminated" Notice Common;
            RESERVED = 15 1 "Reserved" Info Common;
            $($flag = $shift $width $name $severity $group;)*
        }
    };
    ($(#[$doc:meta])* $type:ident $section:literal; $($rows:tt)*) => {
        $crate::flags::flag_class! {
            $(#[$doc])* $type $section, ConnLost Alarm Common, width 1;
            $($rows)*
        }
    };
}

pub(crate) use {flag_class, flag_rows};

/// The constants of a bit set beside its dictionary.
#[cfg(test)]
pub(crate) trait Constants {
    const CONSTANTS: &'static [(&'static str, u32)];
}

#[cfg(test)]
mod tests;
