//! §3.3.1–§3.3.10 «Флаги состояния»: the status bits of every class of subsystem.
//!
//! One table makes the bit sets and the dictionary. Names and bits follow the document; severities,
//! causes and remedies are ours. Bits that the document does not name are kept.

mod words;

use crate::dictionary::Text;
use crate::id::SubsystemId;
use words::{buttons, climatics, common, conn, control, deployer, detector, drive, general, valve};

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
    pub meaning: Text,
    /// Usual causes.
    pub cause: Text,
    /// What to do.
    pub remedy: Text,
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

/// State of a button's circuit (§3.3.10).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[repr(u8)]
pub enum ButtonState {
    /// Not pressed.
    #[default]
    Released,
    /// Pressed.
    Pressed,
    /// Short circuit.
    Short,
    /// Open circuit.
    Open,
}

impl ButtonState {
    /// The state that the two lowest bits encode.
    pub const fn of(bits: u32) -> Self {
        match bits & 0b11 {
            0 => Self::Released,
            1 => Self::Pressed,
            2 => Self::Short,
            _ => Self::Open,
        }
    }
}

/// A button of a post, in the order of the bits (§3.3.10).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Button {
    /// Turn left.
    Left,
    /// Turn right.
    Right,
    /// Raise.
    Up,
    /// Lower.
    Down,
    /// Wider spray.
    Wide,
    /// Narrower jet.
    Narrow,
    /// Open the valve.
    Open,
    /// Close the valve.
    Close,
}

impl Button {
    /// Every button in the order of the bits.
    pub const ALL: [Self; 8] = [
        Self::Left,
        Self::Right,
        Self::Up,
        Self::Down,
        Self::Wide,
        Self::Narrow,
        Self::Open,
        Self::Close,
    ];

    /// Number of the button's lower bit.
    pub const fn shift(self) -> u32 {
        16 + 2 * self as u32
    }
}

impl ButtonsFlags {
    /// The state of a button.
    pub const fn button(self, button: Button) -> ButtonState {
        ButtonState::of(self.bits() >> button.shift())
    }

    /// The same word with another state of a button.
    pub const fn with_button(self, button: Button, state: ButtonState) -> Self {
        let others = self.bits() & !(0b11 << button.shift());
        Self::from_bits_retain(others | (state as u32) << button.shift())
    }
}

/// Rows of `FLAG = bit width "Name" Severity words;` become a bit set and its dictionary.
macro_rules! flag_rows {
    ($(#[$doc:meta])* $type:ident $section:literal
     $($flag:ident = $shift:literal $width:literal $name:literal $severity:ident $words:expr;)+) =>
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
            pub const CLASS: FlagClass = FlagClass {
                name: stringify!($type),
                section: $section,
                flags: &[$(FlagInfo {
                    name: $name,
                    shift: $shift,
                    width: $width,
                    severity: Severity::$severity,
                    meaning: $words.meaning,
                    cause: $words.cause,
                    remedy: $words.remedy,
                }),+],
            };
        }

        #[cfg(test)]
        impl tests::Constants for $type {
            const CONSTANTS: &'static [(&'static str, u32)] =
                &[$((stringify!($flag), $type::$flag.bits())),+];
        }
    };
}

/// Puts the common flags (§3.3.1) before the class's own ones, which all have the same width.
macro_rules! flag_class {
    ($(#[$doc:meta])* $type:ident $section:literal, ConnLost $conn_lost:ident $conn_words:expr,
        width $width:literal;
     $($flag:ident = $shift:literal $name:literal $severity:ident $words:expr;)*) => {
        flag_rows! {
            $(#[$doc])* $type $section
            CONFIG_FAULT = 0 1 "ConfigFault" Alarm common::CONFIG_FAULT;
            CONFIG_INVALID = 1 1 "ConfigInvalid" Warning common::CONFIG_INVALID;
            CONFIG_WRITE_FAULT = 2 1 "ConfigWriteFault" Warning common::CONFIG_WRITE_FAULT;
            CONN_LOST = 3 1 "ConnLost" $conn_lost $conn_words;
            BAD_POWER = 4 1 "BadPower" Alarm common::BAD_POWER;
            REMOTE_PA_INCOMPLETE = 5 1 "RemotePaIncomplete" Warning common::REMOTE_PA_INCOMPLETE;
            REMOTE_PA_BAD_ID = 6 1 "RemotePaBadId" Warning common::REMOTE_PA_BAD_ID;
            REMOTE_PA_BAD_VAL = 7 1 "RemotePaBadVal" Warning common::REMOTE_PA_BAD_VAL;
            REMOTE_PA_ERROR = 8 1 "RemotePaError" Warning common::REMOTE_PA_ERROR;
            RESTARTING = 9 1 "Restarting" Notice common::RESTARTING;
            INTERNAL_FAULT = 10 1 "InternalFault" Alarm common::INTERNAL_FAULT;
            WDT_FAULT = 11 1 "WdtFault" Warning common::WDT_FAULT;
            PROTOCOL_FAULT = 12 1 "ProtocolFault" Warning common::PROTOCOL_FAULT;
            DISABLED = 13 1 "Disabled" Notice common::DISABLED;
            TERMINATED = 14 1 "Terminated" Notice common::TERMINATED;
            RESERVED = 15 1 "Reserved" Info common::RESERVED;
            $($flag = $shift $width $name $severity $words;)*
        }
    };
    ($(#[$doc:meta])* $type:ident $section:literal; $($rows:tt)*) => {
        flag_class! {
            $(#[$doc])* $type $section, ConnLost Alarm common::CONN_LOST, width 1; $($rows)*
        }
    };
}

flag_class! {
    /// §3.3.1 What the status words of all subsystems have in common.
    CommonFlags "3.3.1";
}

flag_class! {
    /// §3.3.2 General.
    GeneralFlags "3.3.2";
    PRESSURE_SENSOR_BREAK = 16 "PressureSensorBreak" Warning general::PRESSURE_SENSOR_BREAK;
    PRESSURE_SENSOR_SHORT = 17 "PressureSensorShort" Warning general::PRESSURE_SENSOR_SHORT;
    LOCKED_OUT = 18 "LockedOut" Warning general::LOCKED_OUT;
}

flag_class! {
    /// §3.3.3 Climatics.
    ClimaticsFlags "3.3.3";
    HORIZONTAL_HEAT = 16 "HorizontalHeat" Info climatics::HORIZONTAL_HEAT;
    VERTICAL_HEAT = 17 "VerticalHeat" Info climatics::VERTICAL_HEAT;
    NOZZLE_HEAT = 18 "NozzleHeat" Info climatics::NOZZLE_HEAT;
    DEPLOYER_HEAT = 19 "DeployerHeat" Info climatics::DEPLOYER_HEAT;
    BOX_HEAT = 20 "BoxHeat" Info climatics::BOX_HEAT;
    HORIZONTAL_FAULT = 21 "HorizontalFault" Warning climatics::HORIZONTAL_FAULT;
    VERTICAL_FAULT = 22 "VerticalFault" Warning climatics::VERTICAL_FAULT;
    NOZZLE_FAULT = 23 "NozzleFault" Warning climatics::NOZZLE_FAULT;
    DEPLOYER_FAULT = 24 "DeployerFault" Warning climatics::DEPLOYER_FAULT;
    BOX_FAULT = 25 "BoxFault" Warning climatics::BOX_FAULT;
    HORIZONTAL_SENSOR_FAULT = 26 "HorizontalSensorFault" Warning climatics::HORIZONTAL_SENSOR_FAULT;
    VERTICAL_SENSOR_FAULT = 27 "VerticalSensorFault" Warning climatics::VERTICAL_SENSOR_FAULT;
    NOZZLE_SENSOR_FAULT = 28 "NozzleSensorFault" Warning climatics::NOZZLE_SENSOR_FAULT;
    DEPLOYER_SENSOR_FAULT = 29 "DeployerSensorFault" Warning climatics::DEPLOYER_SENSOR_FAULT;
    BOX_SENSOR_FAULT = 30 "BoxSensorFault" Warning climatics::BOX_SENSOR_FAULT;
    HUMIDITY_SENSOR_FAULT = 31 "HumiditySensorFault" Warning climatics::HUMIDITY_SENSOR_FAULT;
}

flag_class! {
    /// §3.3.4 Vertical, Horizontal, Nozzle.
    DriveFlags "3.3.4";
    MOVE = 16 "Move" Info drive::MOVE;
    POSITION_WAY_FAULT = 17 "PositionWayFault" Alarm drive::POSITION_WAY_FAULT;
    AMPERAGE_OVERLOAD = 18 "AmperageOverload" Warning drive::AMPERAGE_OVERLOAD;
    POS_ENCODER_FAULT = 19 "PosEncoderFault" Alarm drive::POS_ENCODER_FAULT;
    SPEED_ENCODER_FAULT = 20 "SpeedEncoderFault" Alarm drive::SPEED_ENCODER_FAULT;
    MOTOR_BROKEN = 21 "MotorBroken" Alarm drive::MOTOR_BROKEN;
    SPEED_WAY_FAULT = 22 "SpeedWayFault" Alarm drive::SPEED_WAY_FAULT;
    LIMITLESS = 23 "Limitless" Warning drive::LIMITLESS;
    MIN_LIMIT_REACHED = 24 "MinLimitReached" Info drive::MIN_LIMIT_REACHED;
    MAX_LIMIT_REACHED = 25 "MaxLimitReached" Info drive::MAX_LIMIT_REACHED;
    ABSOLUTE_MIN_LIMIT_REACHED = 26 "AbsoluteMinLimitReached" Notice
        drive::ABSOLUTE_MIN_LIMIT_REACHED;
    ABSOLUTE_MAX_LIMIT_REACHED = 27 "AbsoluteMaxLimitReached" Notice
        drive::ABSOLUTE_MAX_LIMIT_REACHED;
    SPEED_SLOW_AMP = 28 "SpeedSlowAmp" Notice drive::SPEED_SLOW_AMP;
    TRV_ENGAGE = 29 "TRVEngage" Info drive::TRV_ENGAGE;
}

flag_class! {
    /// §3.3.5 Valve1, Valve2.
    ValveFlags "3.3.5";
    OPENING = 16 "Opening" Info valve::OPENING;
    CLOSING = 17 "Closing" Info valve::CLOSING;
    AMPERAGE_OVERLOAD = 18 "AmperageOverload" Alarm valve::AMPERAGE_OVERLOAD;
    BLOCKED = 19 "Blocked" Warning valve::BLOCKED;
    OPEN_SENSOR_FAULT = 20 "OpenSensorFault" Warning valve::OPEN_SENSOR_FAULT;
    CLOSE_SENSOR_FAULT = 21 "CloseSensorFault" Warning valve::CLOSE_SENSOR_FAULT;
    OPEN = 22 "Open" Info valve::OPEN;
    CLOSED = 23 "Closed" Info valve::CLOSED;
}

flag_class! {
    /// §3.3.6 Control.
    ControlFlags "3.3.6";
    QUENCH = 16 "Quench" Info control::QUENCH;
    OUTSIDE_LIMITS = 17 "OutsideLimits" Warning control::OUTSIDE_LIMITS;
    MODE_FAULT = 18 "ModeFault" Warning control::MODE_FAULT;
    PAUSED = 19 "Paused" Notice control::PAUSED;
    TRAJECTORY_PRESSURE_FAULT = 20 "TrajectoryPressureFault" Warning
        control::TRAJECTORY_PRESSURE_FAULT;
    TRAJECTORY_RANGE_FAULT = 21 "TrajectoryRangeFault" Warning control::TRAJECTORY_RANGE_FAULT;
    TRAJECTORY_ANGLE_FAULT = 22 "TrajectoryAngleFault" Warning control::TRAJECTORY_ANGLE_FAULT;
    TRAJECTORY_CRC_FAULT = 23 "TrajectoryCRCFault" Warning control::TRAJECTORY_CRC_FAULT;
    TRAJECTORY = 24 "Trajectory" Info control::TRAJECTORY;
}

flag_class! {
    /// §3.3.7 Detector.
    DetectorFlags "3.3.7";
    SEARCHING = 16 "Searching" Info detector::SEARCHING;
    FOUND = 17 "Found" Alarm detector::FOUND;
    DEVICE_FAULT = 18 "DeviceFault" Alarm detector::DEVICE_FAULT;
    CANCELED = 19 "Canceled" Notice detector::CANCELED;
    BAD_SECTOR = 20 "BadSector" Warning detector::BAD_SECTOR;
    JUSTIFYING = 21 "Justifying" Info detector::JUSTIFYING;
    JUSTIFIED = 22 "Justified" Info detector::JUSTIFIED;
    DIRTY_LENS = 23 "DirtyLens" Warning detector::DIRTY_LENS;
}

flag_class! {
    /// §3.3.8 Deployer: bits 16–27 are those of the drives.
    DeployerFlags "3.3.8";
    MOVE = 16 "Move" Info drive::MOVE;
    POSITION_WAY_FAULT = 17 "PositionWayFault" Alarm drive::POSITION_WAY_FAULT;
    AMPERAGE_OVERLOAD = 18 "AmperageOverload" Warning drive::AMPERAGE_OVERLOAD;
    POS_ENCODER_FAULT = 19 "PosEncoderFault" Alarm drive::POS_ENCODER_FAULT;
    SPEED_ENCODER_FAULT = 20 "SpeedEncoderFault" Alarm drive::SPEED_ENCODER_FAULT;
    MOTOR_BROKEN = 21 "MotorBroken" Alarm drive::MOTOR_BROKEN;
    SPEED_WAY_FAULT = 22 "SpeedWayFault" Alarm drive::SPEED_WAY_FAULT;
    LIMITLESS = 23 "Limitless" Warning drive::LIMITLESS;
    MIN_LIMIT_REACHED = 24 "MinLimitReached" Info drive::MIN_LIMIT_REACHED;
    MAX_LIMIT_REACHED = 25 "MaxLimitReached" Info drive::MAX_LIMIT_REACHED;
    ABSOLUTE_MIN_LIMIT_REACHED = 26 "AbsoluteMinLimitReached" Notice
        drive::ABSOLUTE_MIN_LIMIT_REACHED;
    ABSOLUTE_MAX_LIMIT_REACHED = 27 "AbsoluteMaxLimitReached" Notice
        drive::ABSOLUTE_MAX_LIMIT_REACHED;
    DEPLOYED = 28 "Deployed" Info deployer::DEPLOYED;
    DEPLOYING = 29 "Deploying" Info deployer::DEPLOYING;
    WRAPPED = 30 "Wrapped" Info deployer::WRAPPED;
    WRAPPING = 31 "Wrapping" Info deployer::WRAPPING;
}

flag_class! {
    /// §3.3.9 ExternalConn, Radio: no flags of their own; ConnLost means that no client controls.
    ConnFlags "3.3.9", ConnLost Notice conn::CONN_LOST, width 1;
}

flag_class! {
    /// §3.3.10 Buttons, ExtButtons: a [`ButtonState`] of two bits for each button.
    ButtonsFlags "3.3.10", ConnLost Alarm common::CONN_LOST, width 2;
    LEFT_BUTTON_STATE = 16 "LeftButtonState" Warning buttons::LEFT;
    RIGHT_BUTTON_STATE = 18 "RightButtonState" Warning buttons::RIGHT;
    UP_BUTTON_STATE = 20 "UpButtonState" Warning buttons::UP;
    DOWN_BUTTON_STATE = 22 "DownButtonState" Warning buttons::DOWN;
    WIDE_BUTTON_STATE = 24 "WideButtonState" Warning buttons::WIDE;
    NARROW_BUTTON_STATE = 26 "NarrowButtonState" Warning buttons::NARROW;
    OPEN_BUTTON_STATE = 28 "OpenButtonState" Warning buttons::OPEN;
    CLOSE_BUTTON_STATE = 30 "CloseButtonState" Warning buttons::CLOSE;
}

#[cfg(test)]
mod tests;
