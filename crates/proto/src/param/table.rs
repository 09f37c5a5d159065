//! §P/1 The table of the parameters — ours (§3.4, §3.5): the vendor's list is not public.

use super::kinds;
use super::{Access, Effect, Element, ParamSpec, Placement, Storage, Unit};
use crate::dictionary::{Key, key};
use crate::id::{ParamId, SubsystemId};

/// The key of a text: that of the parameter, or the shared one.
macro_rules! text_key {
    ($variant:ident) => {
        key!("param-", stringify!($variant))
    };
    ($variant:ident $shared:ident) => {
        key!("param-", stringify!($shared))
    };
}

/// Rows of `Variant: SUBSYSTEM "Name", spec;` become the enum and its tables. The text is
/// `param-Variant`, or one that several share: `Variant: SUBSYSTEM "Name", spec, as Shared;`. A row
/// behind `#[cfg(…)]` is there with that feature alone.
macro_rules! params {
    ($(
        $(#[$cfg:meta])?
        $variant:ident: $subsystem:ident $name:literal, $spec:expr $(, as $shared:ident)?;
    )+) => {
        /// A parameter of a subsystem.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u8)]
        #[non_exhaustive]
        pub enum Param {
            $(
                $(#[$cfg])?
                #[doc = concat!("`", stringify!($subsystem), "` `", $name, "`")]
                $variant,
            )+
        }

        impl Param {
            /// Every parameter in the order of the table.
            pub const ALL: [Param; Param::COUNT] = [$($(#[$cfg])? Param::$variant),+];
            /// How many parameters there are.
            pub const COUNT: usize = [$($(#[$cfg])? $name),+].len();

            /// Length, range, unit and handling.
            pub const fn spec(self) -> &'static ParamSpec {
                match self {
                    $($(#[$cfg])? Param::$variant => &const {
                        ParamSpec {
                            subsystem: SubsystemId::$subsystem,
                            id: ParamId::of($name),
                            ..$spec
                        }
                    },)+
                }
            }

            /// What belongs to this parameter alone; the rest is shared by its kind.
            const fn own(self) -> &'static Own {
                const ALL: [Own; Param::COUNT] = [$($(#[$cfg])? Own {
                    default: $spec.default,
                    id: ParamId::of($name),
                    subsystem: SubsystemId::$subsystem,
                    kind: kinds::place(&$spec, &SPECS),
                }),+];
                match ALL.split_at_checked(self as usize) {
                    Some((_, [own, ..])) => own,
                    _ => &OWN,
                }
            }

            /// The name whose hash is the id.
            pub const fn name(self) -> &'static str {
                match self {
                    $($(#[$cfg])? Param::$variant => $name,)+
                }
            }

            /// What the parameter is and does.
            pub const fn text(self) -> Key {
                match self {
                    $($(#[$cfg])? Param::$variant => text_key!($variant $($shared)?),)+
                }
            }
        }

        /// The specification of each row, from which the kinds are made.
        const SPECS: [ParamSpec; Param::COUNT] = [$($(#[$cfg])? $spec),+];
    };
}

/// What distinguishes a parameter from others of its kind.
struct Own {
    default: i32,
    id: ParamId,
    subsystem: SubsystemId,
    kind: u8,
}

/// Placeholder of a specification.
pub(super) const ANY: ParamSpec = one(Unit::None, 0, 0, 0);

/// Placeholder.
const OWN: Own = Own { default: 0, id: ParamId(0), subsystem: SubsystemId::GENERAL, kind: 0 };

impl Param {
    /// The specification shared by all parameters of this kind, which saves memory. Subsystem, id
    /// and default are not those of this parameter.
    pub const fn kind(self) -> &'static ParamSpec {
        const KINDS: [ParamSpec; kinds::count(&SPECS)] = kinds::all(&SPECS);
        match KINDS.split_at_checked(self.own().kind as usize) {
            Some((_, [kind, ..])) => kind,
            _ => &kinds::BLANK,
        }
    }

    /// The subsystem it belongs to.
    pub const fn subsystem(self) -> SubsystemId {
        self.own().subsystem
    }

    /// The 16-bit hash of its name.
    pub const fn id(self) -> ParamId {
        self.own().id
    }

    /// The value of every element until it is set.
    pub const fn default(self) -> i32 {
        self.own().default
    }
}

/// One stored value that takes effect at once; the methods below change single properties.
const fn one(unit: Unit, min: i32, max: i32, default: i32) -> ParamSpec {
    ParamSpec {
        subsystem: SubsystemId::GENERAL,
        id: ParamId(0),
        min_len: 1,
        max_len: 1,
        step_len: 1,
        unit,
        min,
        max,
        default,
        elements: &[],
        access: Access::ReadWrite,
        effect: Effect::AtOnce,
        storage: Storage::Stored,
        placement: Placement::Local,
        required: true,
    }
}

impl ParamSpec {
    const fn len(self, min_len: u8, max_len: u8, step_len: u8) -> Self {
        Self { min_len, max_len, step_len, ..self }
    }

    const fn after_restart(self) -> Self {
        Self { effect: Effect::Restart, ..self }
    }

    const fn optional(self) -> Self {
        Self { required: false, ..self }
    }

    const fn on_unit(self) -> Self {
        Self { placement: Placement::Unit, ..self }
    }

    const fn passing(self) -> Self {
        Self { storage: Storage::Volatile, required: false, ..self }
    }

    const fn measured(self) -> Self {
        Self { access: Access::ReadOnly, storage: Storage::Volatile, required: false, ..self }
    }
}

/// A position of a drive: what the int16 of Move and DriveStatus can say (§3.1, §3.3).
const fn position(unit: Unit, default: i32) -> ParamSpec {
    one(unit, -32_767, 32_767, default).on_unit()
}

/// §D/7 Where an end switch is.
const fn home(unit: Unit) -> ParamSpec {
    one(unit, -32_767, 32_767, 0).optional()
}

/// A speed or a current: one byte in DriveStatus (§3.3).
const fn byte(unit: Unit, min: i32, default: i32) -> ParamSpec {
    one(unit, min, 255, default).on_unit()
}

const fn acceleration(unit: Unit, default: i32) -> ParamSpec {
    one(unit, 1, 1000, default).on_unit()
}

const fn min_speed(unit: Unit) -> ParamSpec {
    one(unit, 0, 30, 0).optional()
}

const fn choice(max: i32, default: i32) -> ParamSpec {
    one(Unit::Choice, 0, max, default)
}

const fn element(unit: Unit, min: i32, max: i32) -> Element {
    Element { unit, min, max }
}

/// §3.14: the seven numbers of StartQuench full, in its order.
const PROGRAM: ParamSpec = ParamSpec {
    elements: &[
        element(Unit::Arcmin, -32_767, 32_767),
        element(Unit::Arcmin, -32_767, 32_767),
        element(Unit::Millimetre, -32_767, 32_767),
        element(Unit::Arcmin, 0, 32_767),
        element(Unit::Arcmin, 0, 32_767),
        element(Unit::Degree, 0, 127),
        element(Unit::Metre, 0, 127),
    ],
    ..one(Unit::None, -32_767, 32_767, 0).len(7, 7, 1).optional()
};

/// §3.15: up to fifteen points of four numbers.
const TRAJECTORY: ParamSpec = ParamSpec {
    elements: &[
        element(Unit::Arcmin, -32_767, 32_767),
        element(Unit::Arcmin, -32_767, 32_767),
        element(Unit::Metre, 0, 255),
        element(Unit::DeciSecond, 0, 255),
    ],
    ..one(Unit::None, -32_767, 32_767, 0).len(0, 60, 4).optional()
};

const DRIVE_TYPE: ParamSpec = choice(2, 0).after_restart();
const MOVE_HOLD: ParamSpec = one(Unit::Millisecond, 0, 10_000, 0).passing();
const STOP_LAG: ParamSpec = one(Unit::Millisecond, 0, 500, 0).optional();
const HOMING: ParamSpec = choice(2, 0).after_restart().optional();
const VALVE_TYPE: ParamSpec = choice(1, 0).after_restart();
const VALVE_TRAVEL: ParamSpec = one(Unit::Millisecond, 500, 120_000, 12_000).on_unit();
const TIMEOUT: ParamSpec = one(Unit::Millisecond, 500, 60_000, 3000);
const JUSTIFY: ParamSpec = one(Unit::Arcmin, -600, 600, 0);

const fn heat(default: i32) -> ParamSpec {
    one(Unit::DeciCelsius, -400, 600, default)
}

use Unit::{
    Arcmin, Bits, Centimetre, DeciAmpere, DeciAtmosphere, DeciDegreePerSecond, DeciMillimetre,
    DeciMillimetrePerSecond, DegreePerSecond, DegreePerSecond2, Millimetre, MillimetrePerSecond,
    MillimetrePerSecond2, Millisecond, Second, Volt,
};

params! {
    GeneralAddress: GENERAL "Address", one(Unit::None, 1, 127, 1).after_restart();
    GeneralChain: GENERAL "Chain", one(Bits, 0, 0x3FFF, 0x3FFF).after_restart();
    GeneralFaultInfo: GENERAL "FaultInfo",
        one(Bits, i32::MIN, i32::MAX, 0).len(20, 20, 1).measured();
    GeneralInputFaults: GENERAL "InputFaults", one(Bits, 0, i32::MAX, 0).measured();
    GeneralMainVoltageMin: GENERAL "MainVoltageMin", one(Volt, 0, 1000, 18);
    GeneralMainVoltageMax: GENERAL "MainVoltageMax", one(Volt, 0, 1000, 32);
    GeneralPressureRange: GENERAL "PressureRange", one(DeciAtmosphere, 1, 1000, 160);
    GeneralResetValves: GENERAL "ResetValves", choice(1, 0);
    GeneralWaterTimeout: GENERAL "WaterTimeout", one(Second, 0, 86_400, 0).optional();
    GeneralMoveTimeout: GENERAL "MoveTimeout", one(Millisecond, 0, 60_000, 0);
    // §U/9
    #[cfg(feature = "update")]
    GeneralSoftwareVersion: GENERAL "SoftwareVersion",
        one(Unit::None, 0, 65_535, 0).len(4, 4, 1).measured();
    #[cfg(feature = "update")]
    GeneralSoftwareSlot: GENERAL "SoftwareSlot", choice(2, 0).measured();
    #[cfg(feature = "update")]
    GeneralSoftwareHash: GENERAL "SoftwareHash",
        one(Bits, i32::MIN, i32::MAX, 0).len(8, 8, 1).measured();

    ClimaticsHeatOn: CLIMATICS "HeatOn", heat(50);
    ClimaticsHeatOff: CLIMATICS "HeatOff", heat(80);

    VerticalMinLimit: VERTICAL "MinLimit", position(Arcmin, -900), as DriveMinLimit;
    VerticalMaxLimit: VERTICAL "MaxLimit", position(Arcmin, 4500), as DriveMaxLimit;
    VerticalZeroPoint: VERTICAL "ZeroPoint", position(Arcmin, 0), as DriveZeroPoint;
    VerticalSpeed: VERTICAL "Speed", byte(DegreePerSecond, 1, 12), as DriveSpeed;
    VerticalAcceleration: VERTICAL "Acceleration", acceleration(DegreePerSecond2, 24),
        as DriveAcceleration;
    VerticalMaxCurrent: VERTICAL "MaxCurrent", byte(DeciAmpere, 1, 80), as DriveMaxCurrent;
    VerticalSlowCurrent: VERTICAL "SlowCurrent", byte(DeciAmpere, 0, 60), as DriveSlowCurrent;
    VerticalDriveType: VERTICAL "DriveType", DRIVE_TYPE, as DriveType;
    VerticalMoveHold: VERTICAL "MoveHold", MOVE_HOLD, as DriveMoveHold;
    VerticalStopLag: VERTICAL "StopLag", STOP_LAG, as DriveStopLag;
    VerticalMinSpeed: VERTICAL "MinSpeed", min_speed(DeciDegreePerSecond), as DriveMinSpeed;
    VerticalStopLagSeen: VERTICAL "StopLagSeen", STOP_LAG.measured(), as DriveStopLagSeen;
    VerticalMinSpeedSeen: VERTICAL "MinSpeedSeen", min_speed(DeciDegreePerSecond).measured(),
        as DriveMinSpeedSeen;
    VerticalHoming: VERTICAL "Homing", HOMING, as DriveHoming;
    VerticalHomePosition: VERTICAL "HomePosition", home(Arcmin), as DriveHomePosition;

    HorizontalMinLimit: HORIZONTAL "MinLimit", position(Arcmin, -10_800), as DriveMinLimit;
    HorizontalMaxLimit: HORIZONTAL "MaxLimit", position(Arcmin, 10_800), as DriveMaxLimit;
    HorizontalZeroPoint: HORIZONTAL "ZeroPoint", position(Arcmin, 0), as DriveZeroPoint;
    HorizontalSpeed: HORIZONTAL "Speed", byte(DegreePerSecond, 1, 20), as DriveSpeed;
    HorizontalAcceleration: HORIZONTAL "Acceleration", acceleration(DegreePerSecond2, 30),
        as DriveAcceleration;
    HorizontalMaxCurrent: HORIZONTAL "MaxCurrent", byte(DeciAmpere, 1, 80), as DriveMaxCurrent;
    HorizontalSlowCurrent: HORIZONTAL "SlowCurrent", byte(DeciAmpere, 0, 60), as DriveSlowCurrent;
    HorizontalDriveType: HORIZONTAL "DriveType", DRIVE_TYPE, as DriveType;
    HorizontalMoveHold: HORIZONTAL "MoveHold", MOVE_HOLD, as DriveMoveHold;
    HorizontalStopLag: HORIZONTAL "StopLag", STOP_LAG, as DriveStopLag;
    HorizontalMinSpeed: HORIZONTAL "MinSpeed", min_speed(DeciDegreePerSecond), as DriveMinSpeed;
    HorizontalStopLagSeen: HORIZONTAL "StopLagSeen", STOP_LAG.measured(), as DriveStopLagSeen;
    HorizontalMinSpeedSeen: HORIZONTAL "MinSpeedSeen", min_speed(DeciDegreePerSecond).measured(),
        as DriveMinSpeedSeen;
    HorizontalHoming: HORIZONTAL "Homing", HOMING, as DriveHoming;
    HorizontalHomePosition: HORIZONTAL "HomePosition", home(Arcmin), as DriveHomePosition;

    NozzleMinLimit: NOZZLE "MinLimit", position(Millimetre, 0), as DriveMinLimit;
    NozzleMaxLimit: NOZZLE "MaxLimit", position(Millimetre, 60), as DriveMaxLimit;
    NozzleZeroPoint: NOZZLE "ZeroPoint", position(Millimetre, 0), as DriveZeroPoint;
    NozzleSpeed: NOZZLE "Speed", byte(MillimetrePerSecond, 1, 10), as DriveSpeed;
    NozzleAcceleration: NOZZLE "Acceleration", acceleration(MillimetrePerSecond2, 40),
        as DriveAcceleration;
    NozzleMaxCurrent: NOZZLE "MaxCurrent", byte(DeciAmpere, 1, 80), as DriveMaxCurrent;
    NozzleSlowCurrent: NOZZLE "SlowCurrent", byte(DeciAmpere, 0, 60), as DriveSlowCurrent;
    NozzleDriveType: NOZZLE "DriveType", DRIVE_TYPE, as DriveType;
    NozzleMoveHold: NOZZLE "MoveHold", MOVE_HOLD, as DriveMoveHold;
    NozzleStopLag: NOZZLE "StopLag", STOP_LAG, as DriveStopLag;
    NozzleMinSpeed: NOZZLE "MinSpeed", min_speed(DeciMillimetrePerSecond), as DriveMinSpeed;
    NozzleStopLagSeen: NOZZLE "StopLagSeen", STOP_LAG.measured(), as DriveStopLagSeen;
    NozzleMinSpeedSeen: NOZZLE "MinSpeedSeen", min_speed(DeciMillimetrePerSecond).measured(),
        as DriveMinSpeedSeen;
    NozzleHoming: NOZZLE "Homing", HOMING, as DriveHoming;
    NozzleHomePosition: NOZZLE "HomePosition", home(Millimetre), as DriveHomePosition;
    NozzleTrvPosition: NOZZLE "TrvPosition", one(Millimetre, -1, 100, -1).on_unit();

    DeployerMinLimit: DEPLOYER "MinLimit", position(Arcmin, 0), as DriveMinLimit;
    DeployerMaxLimit: DEPLOYER "MaxLimit", position(Arcmin, 5400), as DriveMaxLimit;
    DeployerZeroPoint: DEPLOYER "ZeroPoint", position(Arcmin, 0), as DriveZeroPoint;
    DeployerSpeed: DEPLOYER "Speed", byte(DegreePerSecond, 1, 15), as DriveSpeed;
    DeployerAcceleration: DEPLOYER "Acceleration", acceleration(DegreePerSecond2, 30),
        as DriveAcceleration;
    DeployerMaxCurrent: DEPLOYER "MaxCurrent", byte(DeciAmpere, 1, 80), as DriveMaxCurrent;
    DeployerSlowCurrent: DEPLOYER "SlowCurrent", byte(DeciAmpere, 0, 60), as DriveSlowCurrent;
    DeployerDriveType: DEPLOYER "DriveType", DRIVE_TYPE, as DriveType;
    DeployerMoveHold: DEPLOYER "MoveHold", MOVE_HOLD, as DriveMoveHold;
    DeployerStopLag: DEPLOYER "StopLag", STOP_LAG, as DriveStopLag;
    DeployerMinSpeed: DEPLOYER "MinSpeed", min_speed(DeciDegreePerSecond), as DriveMinSpeed;
    DeployerStopLagSeen: DEPLOYER "StopLagSeen", STOP_LAG.measured(), as DriveStopLagSeen;
    DeployerMinSpeedSeen: DEPLOYER "MinSpeedSeen", min_speed(DeciDegreePerSecond).measured(),
        as DriveMinSpeedSeen;
    DeployerTravelTime: DEPLOYER "TravelTime",
        one(Millisecond, 1000, 120_000, 20_000).on_unit();

    Valve1TravelTime: VALVE1 "TravelTime", VALVE_TRAVEL, as ValveTravelTime;
    Valve1ValveType: VALVE1 "ValveType", VALVE_TYPE, as ValveType;
    Valve1MaxCurrent: VALVE1 "MaxCurrent", byte(DeciAmpere, 1, 60), as ValveMaxCurrent;
    Valve2TravelTime: VALVE2 "TravelTime", VALVE_TRAVEL, as ValveTravelTime;
    Valve2ValveType: VALVE2 "ValveType", VALVE_TYPE, as ValveType;
    Valve2MaxCurrent: VALVE2 "MaxCurrent", byte(DeciAmpere, 1, 60), as ValveMaxCurrent;

    ControlProgram0: CONTROL "Program0", PROGRAM, as ControlProgram;
    ControlProgram1: CONTROL "Program1", PROGRAM, as ControlProgram;
    ControlProgram2: CONTROL "Program2", PROGRAM, as ControlProgram;
    ControlProgram3: CONTROL "Program3", PROGRAM, as ControlProgram;
    ControlProgram4: CONTROL "Program4", PROGRAM, as ControlProgram;
    ControlProgram5: CONTROL "Program5", PROGRAM, as ControlProgram;
    ControlProgram6: CONTROL "Program6", PROGRAM, as ControlProgram;
    ControlProgram7: CONTROL "Program7", PROGRAM, as ControlProgram;
    ControlTrajectory0: CONTROL "Trajectory0", TRAJECTORY, as ControlTrajectory;
    ControlTrajectory1: CONTROL "Trajectory1", TRAJECTORY, as ControlTrajectory;
    ControlTrajectory2: CONTROL "Trajectory2", TRAJECTORY, as ControlTrajectory;
    ControlTrajectory3: CONTROL "Trajectory3", TRAJECTORY, as ControlTrajectory;
    ControlTrajectory4: CONTROL "Trajectory4", TRAJECTORY, as ControlTrajectory;
    ControlTrajectory5: CONTROL "Trajectory5", TRAJECTORY, as ControlTrajectory;
    ControlTrajectory6: CONTROL "Trajectory6", TRAJECTORY, as ControlTrajectory;
    ControlTrajectory7: CONTROL "Trajectory7", TRAJECTORY, as ControlTrajectory;
    ControlBallistics: CONTROL "Ballistics", choice(1, 1);
    ControlNozzleDiameter: CONTROL "NozzleDiameter", one(DeciMillimetre, 10, 2000, 280);
    ControlHeight: CONTROL "Height", one(Centimetre, -10_000, 10_000, 150);

    DetectorHotbeds: DETECTOR "Hotbeds",
        one(Unit::None, i32::MIN, i32::MAX, 0).len(0, 20, 5).measured();
    DetectorJustifyHorizontal: DETECTOR "JustifyHorizontal", JUSTIFY;
    DetectorJustifyVertical: DETECTOR "JustifyVertical", JUSTIFY;
    DetectorScanStep: DETECTOR "ScanStep", one(Arcmin, 30, 3600, 600);
    DetectorFieldOfView: DETECTOR "FieldOfView", one(Arcmin, 60, 5400, 900);
    DetectorThreshold: DETECTOR "Threshold", one(Unit::None, 1, 100_000, 50);

    ExternalConnTimeout: EXTERNAL_CONN "Timeout", TIMEOUT, as InterfaceTimeout;
    ExternalConnCheck: EXTERNAL_CONN "Check", choice(1, 0).optional(), as InterfaceCheck;
    RadioTimeout: RADIO "Timeout", TIMEOUT, as InterfaceTimeout;
    RadioCheck: RADIO "Check", choice(1, 0).optional(), as InterfaceCheck;
}
