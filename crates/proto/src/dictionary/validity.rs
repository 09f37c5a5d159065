//! §3.3 Values of GetStatus that are invalid while a flag is set (ours; the flags are the
//! document's). Consoles, hubs and tools show such a value as bad and do not use it.

use crate::flags::{self, FlagInfo};
use crate::id::SubsystemId;

/// A flag, and the fields of its subsystem that are invalid while it is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Invalidates {
    /// The subsystem of the flag and the fields.
    pub subsystem: SubsystemId,
    /// Name of the flag.
    pub flag: &'static str,
    /// Names of the fields, as in [`super::layouts`].
    pub fields: &'static [&'static str],
}

const fn row(
    subsystem: SubsystemId,
    flag: &'static str,
    fields: &'static [&'static str],
) -> Invalidates {
    Invalidates { subsystem, flag, fields }
}

const MEASURED: &[&str] = &["position", "current"];
const POSITION: &[&str] = &["position"];
const CLIMATE: &[&str] = &["horizontal", "vertical", "nozzle", "deployer", "housing", "humidity"];

/// Every flag that makes values invalid. The speed of a drive is the speed that is set, not a
/// measured one; valves report only flags.
pub const INVALIDATES: [Invalidates; 18] = [
    row(SubsystemId::GENERAL, "PressureSensorBreak", &["pressure"]),
    row(SubsystemId::GENERAL, "PressureSensorShort", &["pressure"]),
    row(SubsystemId::GENERAL, "ConnLost", &["main_voltage", "pressure", "flowrate"]),
    row(SubsystemId::VERTICAL, "PosEncoderFault", POSITION),
    row(SubsystemId::VERTICAL, "ConnLost", MEASURED),
    row(SubsystemId::HORIZONTAL, "PosEncoderFault", POSITION),
    row(SubsystemId::HORIZONTAL, "ConnLost", MEASURED),
    row(SubsystemId::NOZZLE, "PosEncoderFault", POSITION),
    row(SubsystemId::NOZZLE, "ConnLost", MEASURED),
    row(SubsystemId::DEPLOYER, "PosEncoderFault", POSITION),
    row(SubsystemId::DEPLOYER, "ConnLost", MEASURED),
    row(SubsystemId::CLIMATICS, "HorizontalSensorFault", &["horizontal"]),
    row(SubsystemId::CLIMATICS, "VerticalSensorFault", &["vertical"]),
    row(SubsystemId::CLIMATICS, "NozzleSensorFault", &["nozzle"]),
    row(SubsystemId::CLIMATICS, "DeployerSensorFault", &["deployer"]),
    row(SubsystemId::CLIMATICS, "BoxSensorFault", &["housing"]),
    row(SubsystemId::CLIMATICS, "HumiditySensorFault", &["humidity"]),
    row(SubsystemId::CLIMATICS, "ConnLost", CLIMATE),
];

/// The fields that are invalid with this status word, each with the flag that makes it so.
pub fn invalid(
    subsystem: SubsystemId,
    bits: u32,
) -> impl Iterator<Item = (&'static str, &'static FlagInfo)> {
    let rows = INVALIDATES.iter().filter(move |row| row.subsystem == subsystem);
    let set = rows.filter_map(move |row| {
        let info = flags::flags_of(subsystem).by_name(row.flag)?;
        (info.value(bits) != 0).then_some((row.fields, info))
    });
    set.flat_map(|(fields, info)| fields.iter().map(move |field| (*field, info)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dictionary::layouts::{self, Kind};
    use crate::id::RequestId;

    /// Every flag and field of the table is one of the dictionary.
    #[test]
    fn the_table_names_what_there_is() {
        for Invalidates { subsystem, flag, fields } in INVALIDATES {
            assert!(flags::flags_of(subsystem).by_name(flag).is_some(), "{subsystem} {flag}");
            let layouts = layouts::of_answer(RequestId::GET_STATUS, subsystem);
            for field in fields {
                let known = layouts.iter().flat_map(|layout| layout.fields);
                assert!(known.clone().any(|it| it.name == *field), "{subsystem} {field}");
            }
        }
    }

    /// Every flag whose name says that a sensor, an encoder or the connection of a measuring
    /// subsystem is faulty has its row.
    #[test]
    fn no_faulty_sensor_is_forgotten() {
        for info in crate::dictionary::SUBSYSTEMS {
            let layouts = layouts::of_answer(RequestId::GET_STATUS, info.id);
            let measures = layouts
                .iter()
                .flat_map(|layout| layout.fields)
                .any(|field| field.kind != Kind::Flags);
            for flag in flags::flags_of(info.id).flags {
                let sensor =
                    ["SensorFault", "SensorBreak", "SensorShort", "PosEncoderFault", "ConnLost"];
                let faulty = sensor.iter().any(|end| flag.name.ends_with(end));
                let has = invalid(info.id, flag.mask()).next().is_some();
                assert_eq!(has, faulty && measures, "{} {}", info.id, flag.name);
            }
        }
    }

    #[test]
    fn the_flag_comes_with_the_field() {
        let bits = flags::GeneralFlags::PRESSURE_SENSOR_SHORT.bits();
        let all: [_; 1] = core::array::from_fn(|n| invalid(SubsystemId::GENERAL, bits).nth(n));
        let (field, flag) = all[0].expect("one");
        assert_eq!((field, flag.name), ("pressure", "PressureSensorShort"));
        assert!(invalid(SubsystemId::GENERAL, bits).nth(1).is_none());
        assert!(invalid(SubsystemId::VERTICAL, bits).next().is_none());
    }
}
