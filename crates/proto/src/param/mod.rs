//! §3.4 «GetParam», §3.5 «SetParam»: the parameters of the subsystems.
//!
//! The vendor's list (АБМИ.00098) is not public, so this dictionary is ours. The table in
//! `table.rs` is its only source: firmware, client, console and the reference documentation all
//! read it. Names and keys of texts are read through separate functions, so that firmware that does
//! not use them does not link them.

mod kinds;
mod table;

pub use table::Param;

use crate::dictionary::{Key, key};
use crate::id::{ParamId, Status, SubsystemId};

/// The most values one parameter can have: 255 bytes of data hold the id and 63 int32.
pub const MAX_VALUES: usize = 63;

/// The unit of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
#[non_exhaustive]
pub enum Unit {
    /// A number without unit, or values of different units (see [`ParamSpec::elements`]).
    None,
    /// A bit mask or a register, shown in hexadecimal.
    Bits,
    /// One of the choices that the parameter's text lists.
    Choice,
    /// Angular minutes.
    Arcmin,
    /// Degrees.
    Degree,
    /// Millimetres.
    Millimetre,
    /// Tenths of a millimetre.
    DeciMillimetre,
    /// Centimetres.
    Centimetre,
    /// Metres.
    Metre,
    /// Degrees per second.
    DegreePerSecond,
    /// Millimetres per second.
    MillimetrePerSecond,
    /// Tenths of a degree per second.
    DeciDegreePerSecond,
    /// Tenths of a millimetre per second.
    DeciMillimetrePerSecond,
    /// Degrees per second squared.
    DegreePerSecond2,
    /// Millimetres per second squared.
    MillimetrePerSecond2,
    /// Tenths of an ampere.
    DeciAmpere,
    /// Volts.
    Volt,
    /// Milliseconds.
    Millisecond,
    /// Seconds.
    Second,
    /// Tenths of a second.
    DeciSecond,
    /// Tenths of a degree Celsius.
    DeciCelsius,
    /// Tenths of an atmosphere.
    DeciAtmosphere,
    /// Litres per second.
    LitrePerSecond,
    /// Percent.
    Percent,
}

impl Unit {
    /// The unit behind a value in the text form of answers and in files; empty for a plain number.
    pub const fn symbol(self) -> &'static str {
        match self {
            Unit::None | Unit::Bits | Unit::Choice => "",
            Unit::Arcmin => "'",
            Unit::Degree => "°",
            Unit::Millimetre => "mm",
            Unit::DeciMillimetre => "×0.1 mm",
            Unit::Centimetre => "cm",
            Unit::Metre => "m",
            Unit::DegreePerSecond => "°/s",
            Unit::MillimetrePerSecond => "mm/s",
            Unit::DeciDegreePerSecond => "×0.1 °/s",
            Unit::DeciMillimetrePerSecond => "×0.1 mm/s",
            Unit::DegreePerSecond2 => "°/s²",
            Unit::MillimetrePerSecond2 => "mm/s²",
            Unit::DeciAmpere => "×0.1 A",
            Unit::Volt => "V",
            Unit::Millisecond => "ms",
            Unit::Second => "s",
            Unit::DeciSecond => "×0.1 s",
            Unit::DeciCelsius => "×0.1 °C",
            Unit::DeciAtmosphere => "×0.1 atm",
            Unit::LitrePerSecond => "l/s",
            Unit::Percent => "%",
        }
    }

    /// The unit behind a value in a text for people; `None` for a plain number.
    pub const fn name(self) -> Option<Key> {
        Some(match self {
            Unit::None | Unit::Bits | Unit::Choice => return None,
            Unit::Arcmin => key!("unit-Arcmin"),
            Unit::Degree => key!("unit-Degree"),
            Unit::Millimetre => key!("unit-Millimetre"),
            Unit::DeciMillimetre => key!("unit-DeciMillimetre"),
            Unit::Centimetre => key!("unit-Centimetre"),
            Unit::Metre => key!("unit-Metre"),
            Unit::DegreePerSecond => key!("unit-DegreePerSecond"),
            Unit::MillimetrePerSecond => key!("unit-MillimetrePerSecond"),
            Unit::DeciDegreePerSecond => key!("unit-DeciDegreePerSecond"),
            Unit::DeciMillimetrePerSecond => key!("unit-DeciMillimetrePerSecond"),
            Unit::DegreePerSecond2 => key!("unit-DegreePerSecond2"),
            Unit::MillimetrePerSecond2 => key!("unit-MillimetrePerSecond2"),
            Unit::DeciAmpere => key!("unit-DeciAmpere"),
            Unit::Volt => key!("unit-Volt"),
            Unit::Millisecond => key!("unit-Millisecond"),
            Unit::Second => key!("unit-Second"),
            Unit::DeciSecond => key!("unit-DeciSecond"),
            Unit::DeciCelsius => key!("unit-DeciCelsius"),
            Unit::DeciAtmosphere => key!("unit-DeciAtmosphere"),
            Unit::LitrePerSecond => key!("unit-LitrePerSecond"),
            Unit::Percent => key!("unit-Percent"),
        })
    }
}

/// Who may write a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Access {
    /// SetParam answers AccessDenied.
    ReadOnly,
    /// SetParam changes it.
    ReadWrite,
}

/// When a written value takes effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Effect {
    /// As soon as it is accepted.
    AtOnce,
    /// After the next Restart (§3.12).
    Restart,
}

/// Whether a value is kept without power.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Storage {
    /// Made at run time, never stored.
    Volatile,
    /// Kept in non-volatile memory.
    Stored,
}

/// Where a value is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Placement {
    /// In the control system of the monitor.
    Local,
    /// On the remote unit if DriveType or ValveType selects one: NotCached and Cached while the
    /// unit is busy.
    Unit,
}

/// Range and unit of one element of a parameter whose elements differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Element {
    /// Unit of the element.
    pub unit: Unit,
    /// The smallest allowed value.
    pub min: i32,
    /// The greatest allowed value.
    pub max: i32,
}

/// The specification of a parameter, without name and text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ParamSpec {
    /// The subsystem it belongs to.
    pub subsystem: SubsystemId,
    /// The 16-bit hash of its name.
    pub id: ParamId,
    /// The fewest values it has.
    pub min_len: u8,
    /// The most values it has.
    pub max_len: u8,
    /// The number of values is a multiple of this.
    pub step_len: u8,
    /// Unit of its values.
    pub unit: Unit,
    /// The smallest allowed value.
    pub min: i32,
    /// The greatest allowed value.
    pub max: i32,
    /// The value of every element until it is set.
    pub default: i32,
    /// Ranges and units of the elements where they differ, repeated as often as there are values;
    /// otherwise empty.
    pub elements: &'static [Element],
    /// Whether SetParam may write it.
    pub access: Access,
    /// When a new value takes effect.
    pub effect: Effect,
    /// Whether the value is kept without power.
    pub storage: Storage,
    /// Where the value is stored.
    pub placement: Placement,
    /// Whether it belongs to the set of parameters that must be complete before anything is stored:
    /// until then SetParam answers IncompleteConfig (§2).
    pub required: bool,
}

impl ParamSpec {
    /// Range and unit of the value at `index`.
    pub fn element(&self, index: usize) -> Element {
        let all = Element { unit: self.unit, min: self.min, max: self.max };
        let period = self.elements.len().max(1);
        self.elements.get(index % period).copied().unwrap_or(all)
    }

    /// Whether the parameter can have this number of values.
    pub fn allows_len(&self, len: usize) -> bool {
        let step = usize::from(self.step_len.max(1));
        (usize::from(self.min_len)..=usize::from(self.max_len)).contains(&len)
            && len.is_multiple_of(step)
    }

    /// Checks the values of SetParam (§3.5).
    ///
    /// # Errors
    ///
    /// `Status::WRONG_DATA` for a wrong number of values, `Status::INVALID_VALUE` for one out of
    /// range (§3.5/3, §3.5/4).
    pub fn check(&self, values: impl Iterator<Item = i32>) -> Result<(), Status> {
        let mut len = 0usize;
        let mut in_range = true;
        for (index, value) in values.enumerate() {
            let element = self.element(index);
            in_range &= (element.min..=element.max).contains(&value);
            len = len.saturating_add(1);
        }
        match (self.allows_len(len), in_range) {
            (false, _) => Err(Status::WRONG_DATA),
            (true, false) => Err(Status::INVALID_VALUE),
            (true, true) => Ok(()),
        }
    }
}

/// The parameters that every drive has, in the order of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum DriveParam {
    /// MinLimit: the lower or right limit.
    MinLimit,
    /// MaxLimit: the upper or left limit.
    MaxLimit,
    /// ZeroPoint: the position that the sensor shows as zero.
    ZeroPoint,
    /// Speed: the speed of a move.
    Speed,
    /// Acceleration: rate at which the drive gains and loses speed.
    Acceleration,
    /// MaxCurrent: the current that stops the drive.
    MaxCurrent,
    /// SlowCurrent: the current that slows the drive.
    SlowCurrent,
    /// DriveType: encoder, remote or limit switches.
    DriveType,
    /// MoveHold: time limit of the Move in the same frame.
    MoveHold,
    /// StopLag: how late the speed follows the command.
    StopLag,
    /// MinSpeed: below it the motor does not turn.
    MinSpeed,
    /// StopLagSeen: what StopLag should be by the last stop from a motion.
    StopLagSeen,
    /// MinSpeedSeen: what MinSpeed should be by the last motion.
    MinSpeedSeen,
}

/// The parameters that every valve has, in the order of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum ValveParam {
    /// TravelTime: longest time of an opening or closing.
    TravelTime,
    /// ValveType: local or remote.
    ValveType,
    /// MaxCurrent: the current that stops the valve.
    MaxCurrent,
}

impl Param {
    /// The parameter of a subsystem with this id.
    pub fn find(subsystem: SubsystemId, id: ParamId) -> Option<Param> {
        Self::of(subsystem).find(|param| param.id() == id)
    }

    /// The parameters of a subsystem in the order of the table.
    pub fn of(subsystem: SubsystemId) -> impl Iterator<Item = Param> {
        Self::ALL.iter().copied().filter(move |param| param.subsystem() == subsystem)
    }

    /// The parameter of a subsystem with this name, in any case.
    pub fn by_name(subsystem: SubsystemId, name: &str) -> Option<Param> {
        Self::of(subsystem).find(|param| param.name().eq_ignore_ascii_case(name))
    }

    /// A parameter of one of the four drives.
    pub fn of_drive(subsystem: SubsystemId, param: DriveParam) -> Option<Param> {
        let first = match subsystem {
            SubsystemId::VERTICAL => Param::VerticalMinLimit,
            SubsystemId::HORIZONTAL => Param::HorizontalMinLimit,
            SubsystemId::NOZZLE => Param::NozzleMinLimit,
            SubsystemId::DEPLOYER => Param::DeployerMinLimit,
            _ => return None,
        };
        Self::ALL.get(first as usize + param as usize).copied()
    }

    /// A parameter of one of the two valves.
    pub fn of_valve(subsystem: SubsystemId, param: ValveParam) -> Option<Param> {
        let first = match subsystem {
            SubsystemId::VALVE1 => Param::Valve1TravelTime,
            SubsystemId::VALVE2 => Param::Valve2TravelTime,
            _ => return None,
        };
        Self::ALL.get(first as usize + param as usize).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVES: [SubsystemId; 4] = [
        SubsystemId::VERTICAL,
        SubsystemId::HORIZONTAL,
        SubsystemId::NOZZLE,
        SubsystemId::DEPLOYER,
    ];

    #[test]
    fn ids_are_unique_inside_a_subsystem() {
        for param in Param::ALL {
            let spec = param.spec();
            assert_eq!(Param::find(spec.subsystem, spec.id), Some(param), "{param:?}");
            assert_eq!(Param::by_name(spec.subsystem, param.name()), Some(param));
        }
    }

    #[test]
    fn kind_and_own_are_the_specification() {
        for param in Param::ALL {
            let (subsystem, id, default) = (param.subsystem(), param.id(), param.default());
            let whole = ParamSpec { subsystem, id, default, ..*param.kind() };
            assert_eq!(whole, *param.spec(), "{param:?}");
        }
    }

    #[test]
    fn ids_are_hashes_of_the_names() {
        // §3.21 gives the id of Hotbeds; FaultInfo follows by the same rule (§3.20).
        assert_eq!(Param::DetectorHotbeds.spec().id, ParamId(0x23FE));
        assert_eq!(Param::GeneralFaultInfo.spec().id, ParamId(0xE8C1));
        for param in Param::ALL {
            assert_eq!(param.spec().id, ParamId::of(param.name()), "{param:?}");
        }
    }

    #[test]
    fn defaults_obey_their_own_ranges() {
        for param in Param::ALL {
            let spec = param.spec();
            assert!(spec.min_len <= spec.max_len && usize::from(spec.max_len) <= MAX_VALUES);
            let default = core::iter::repeat_n(spec.default, usize::from(spec.min_len));
            assert_eq!(spec.check(default), Ok(()), "{param:?}");
            for index in 0..usize::from(spec.max_len) {
                let element = spec.element(index);
                assert!(spec.min <= element.min && element.max <= spec.max, "{param:?} {index}");
            }
        }
    }

    #[test]
    fn drive_and_valve_parameters_are_where_the_names_say() {
        use DriveParam::*;
        let all = [
            MinLimit,
            MaxLimit,
            ZeroPoint,
            Speed,
            Acceleration,
            MaxCurrent,
            SlowCurrent,
            DriveType,
            MoveHold,
            StopLag,
            MinSpeed,
            StopLagSeen,
            MinSpeedSeen,
        ];
        for subsystem in DRIVES {
            for which in all {
                let param = Param::of_drive(subsystem, which).expect("every drive has it");
                assert_eq!(param.spec().subsystem, subsystem);
                assert_eq!(param.name(), std::format!("{which:?}"));
            }
        }
        for subsystem in [SubsystemId::VALVE1, SubsystemId::VALVE2] {
            for which in [ValveParam::TravelTime, ValveParam::ValveType, ValveParam::MaxCurrent] {
                let param = Param::of_valve(subsystem, which).expect("every valve has it");
                assert_eq!(param.spec().subsystem, subsystem);
                assert_eq!(param.name(), std::format!("{which:?}"));
            }
        }
        assert_eq!(Param::of_drive(SubsystemId::VALVE1, MinLimit), None);
        assert_eq!(Param::of_valve(SubsystemId::VERTICAL, ValveParam::TravelTime), None);
    }

    #[test]
    fn check_tells_a_wrong_number_from_a_wrong_value() {
        let limit = Param::VerticalMinLimit.spec();
        assert_eq!(limit.check([-900].into_iter()), Ok(()));
        assert_eq!(limit.check([32_768].into_iter()), Err(Status::INVALID_VALUE));
        assert_eq!(limit.check([].into_iter()), Err(Status::WRONG_DATA));
        assert_eq!(limit.check([0, 99_999].into_iter()), Err(Status::WRONG_DATA));

        let trajectory = Param::ControlTrajectory7.spec();
        assert_eq!(trajectory.check([].into_iter()), Ok(()));
        assert_eq!(trajectory.check([-1200, 300, 25, 10].into_iter()), Ok(()));
        assert_eq!(trajectory.check([0; 3].into_iter()), Err(Status::WRONG_DATA));
        assert_eq!(trajectory.check([0; 64].into_iter()), Err(Status::WRONG_DATA));
        // The third value of a point is metres in one byte, the first is a signed angle.
        assert_eq!(trajectory.check([0, 0, -1, 0].into_iter()), Err(Status::INVALID_VALUE));

        let program = Param::ControlProgram0.spec();
        assert_eq!(program.check([-1200, 300, 60, 600, 300, 2, 25].into_iter()), Ok(()));
        assert_eq!(program.check([0, 0, 0, -1, 0, 0, 0].into_iter()), Err(Status::INVALID_VALUE));
        assert_eq!(program.element(5).unit, Unit::Degree);
    }
}
