//! States of subsystems as text and as JSON.

use lafet_client::AnswerBuf;
use lafet_proto::answer::Reply;
use lafet_proto::flags::{FlagInfo, SetFlag, Severity, flags_of};
use lafet_proto::status::{GeneralStatus, Hotbed, ThermoStatus};
use lafet_proto::{Answer, SubsystemId, dictionary};
use lafet_texts::cli as text;
use serde_json::{Map, Value, json};

use crate::angle;
use crate::lang::{current, decimal, of};

/// Names of the flags that are set, and bits without a name in hexadecimal.
pub fn flag_names(subsystem: SubsystemId, bits: u32) -> Vec<String> {
    let class = flags_of(subsystem);
    let unnamed = class.unnamed(bits);
    let unnamed = (unnamed != 0).then(|| format!("{unnamed:#x}"));
    class.set(bits).map(|flag| flag.to_string()).chain(unnamed).collect()
}

/// The values of a state in one line, without the flags. Values that a flag marks as invalid are
/// labelled.
pub fn values(answer: &Answer<'_>) -> String {
    let bits = answer.data.flags_bits().unwrap_or(0);
    let marked = |field: &str, text: String| {
        let bad = dictionary::invalid(answer.from, bits).any(|(bad, _)| bad == field);
        if bad { format!("{text} ({})", text::ValueInvalid.str(current())) } else { text }
    };
    match answer.data {
        Reply::General(GeneralStatus { main_voltage, pressure, flowrate, .. }) => {
            let pressure = tenths(i32::from(pressure));
            let texts = [
                marked("main_voltage", format!("{main_voltage} {}", text::UnitV.str(current()))),
                marked("pressure", format!("{pressure} {}", text::UnitAtm.str(current()))),
                marked("flowrate", format!("{flowrate} {}", text::UnitLps.str(current()))),
            ];
            texts.join(", ")
        }
        Reply::Thermo(status) => thermo(&status, marked),
        Reply::Drive(s) => drive(answer.from, (s.position, s.current, s.speed), marked),
        Reply::Deployer(s) => drive(answer.from, (s.position, s.current, s.speed), marked),
        _ => String::new(),
    }
}

fn drive(
    subsystem: SubsystemId,
    (position, amperes, speed): (i16, u8, u8),
    marked: impl Fn(&str, String) -> String,
) -> String {
    let position = marked("position", angle::show(subsystem, i32::from(position)));
    let amperes = format!("{} {}", tenths(i32::from(amperes)), text::UnitA.str(current()));
    let unit = match subsystem {
        SubsystemId::NOZZLE => text::UnitMmps.str(current()),
        _ => text::UnitDegps.str(current()),
    };
    format!("{position}, {}, {speed} {unit}", marked("current", amperes))
}

fn thermo(status: &ThermoStatus, marked: impl Fn(&str, String) -> String) -> String {
    let places = [
        ("horizontal", text::PlaceHorizontal.str(current()), status.horizontal),
        ("vertical", text::PlaceVertical.str(current()), status.vertical),
        ("nozzle", text::PlaceNozzle.str(current()), status.nozzle),
        ("deployer", text::PlaceDeployer.str(current()), status.deployer),
        ("housing", text::PlaceHousing.str(current()), status.housing),
    ];
    let temperatures = places.map(|(field, name, value)| {
        marked(field, format!("{name} {} °C", tenths(i32::from(value))))
    });
    format!("{}; {}", temperatures.join(", "), marked("humidity", format!("{} %", status.humidity)))
}

/// A number of tenths as a decimal: `12.5`.
pub fn tenths(value: i32) -> String {
    decimal(f64::from(value) / 10.0, 1)
}

/// The state of a subsystem as JSON: values with their units, and the flags.
pub fn state_json(answer: &AnswerBuf) -> Value {
    let mut object = Map::new();
    object.insert("status".into(), json!(answer.status().to_string()));
    let Ok(answer) = answer.decode() else {
        object.insert("raw".into(), json!(hex(answer.data())));
        return Value::Object(object);
    };
    let mut put = |name: &str, value: Value| object.insert(name.into(), value);
    let in_tenths = |value: i32| json!(f64::from(value) / 10.0);
    match answer.data {
        Reply::General(status) => {
            put("main_voltage_v", json!(status.main_voltage));
            put("pressure_atm", in_tenths(i32::from(status.pressure)));
            put("flow_lps", json!(status.flowrate));
        }
        Reply::Thermo(status) => {
            put("horizontal_c", in_tenths(i32::from(status.horizontal)));
            put("vertical_c", in_tenths(i32::from(status.vertical)));
            put("nozzle_c", in_tenths(i32::from(status.nozzle)));
            put("deployer_c", in_tenths(i32::from(status.deployer)));
            put("housing_c", in_tenths(i32::from(status.housing)));
            put("humidity_percent", json!(status.humidity));
        }
        Reply::Drive(s) if answer.from == SubsystemId::NOZZLE => {
            put("position_mm", json!(s.position));
            put("current_a", in_tenths(i32::from(s.current)));
            put("speed_mmps", json!(s.speed));
        }
        Reply::Drive(s) => {
            put("position_arcmin", json!(s.position));
            put("current_a", in_tenths(i32::from(s.current)));
            put("speed_degps", json!(s.speed));
        }
        Reply::Deployer(s) => {
            put("position_arcmin", json!(s.position));
            put("current_a", in_tenths(i32::from(s.current)));
            put("speed_degps", json!(s.speed));
        }
        _ => {}
    }
    if let Some(bits) = answer.data.flags_bits() {
        put("flags", json!(flag_names(answer.from, bits)));
        put("flags_raw", json!(bits));
        let severity = flags_of(answer.from).severity(bits);
        put("severity", json!(lafet_texts::dictionary(severity.text()).en));
    }
    Value::Object(object)
}

/// Lines that explain the flags of a state whose severity is at least `least`.
pub fn flag_lines(subsystem: SubsystemId, bits: u32, least: Severity) -> Vec<String> {
    let set = flags_of(subsystem).set(bits).filter(|flag| flag.severity() >= least);
    set.map(flag_line).collect()
}

/// The meaning of a flag, and what to do about it.
pub fn flag_line(flag: SetFlag) -> String {
    let SetFlag { info, bits, .. } = flag;
    let meaning = button_meaning(info, bits).unwrap_or_else(|| of(&info.meaning).into());
    let advice = match flag.severity() {
        Severity::Info => String::new(),
        _ => format!(" {}", of(&info.remedy)),
    };
    format!("{} [{}]: {meaning}{advice}", flag, of(&flag.severity().text()))
}

fn button_meaning(info: &FlagInfo, bits: u32) -> Option<String> {
    let state = info.button_state(bits)?;
    Some(format!("{} {}.", of(&info.meaning).trim_end_matches('.'), of(&state.text())))
}

/// The fire spots as rows of a table, the brightest first.
pub fn hotbed_rows(hotbeds: &[Hotbed]) -> Vec<Vec<String>> {
    let middle = |a: i32, b: i32| angle::degrees(i32::midpoint(a, b));
    let size = |a: i32, b: i32| angle::degrees((a - b).abs());
    let mut rows = vec![vec![
        text::Spot.str(current()).to_owned(),
        text::SpotAzimuth.str(current()).to_owned(),
        text::ThrowElevation.str(current()).to_owned(),
        text::SpotWidth.str(current()).to_owned(),
        text::SpotHeight.str(current()).to_owned(),
        text::SpotBrightness.str(current()).to_owned(),
    ]];
    rows.extend(hotbeds.iter().enumerate().map(|(index, hotbed)| {
        let Hotbed { x1, x2, y1, y2, brightness } = *hotbed;
        vec![
            (index + 1).to_string(),
            middle(x1, x2),
            middle(y1, y2),
            size(x1, x2),
            size(y1, y2),
            brightness.to_string(),
        ]
    }));
    rows
}

/// The fire spots as JSON.
pub fn hotbeds_json(hotbeds: &[Hotbed]) -> Value {
    let one = |hotbed: &Hotbed| {
        json!({
            "left_arcmin": hotbed.x1,
            "right_arcmin": hotbed.x2,
            "low_arcmin": hotbed.y1,
            "high_arcmin": hotbed.y2,
            "brightness": hotbed.brightness,
        })
    };
    json!({ "hotbeds": hotbeds.iter().map(one).collect::<Vec<_>>() })
}

/// Bytes as hexadecimal: `de ad be`.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_proto::flags::GeneralFlags;
    use lafet_proto::{RequestId, Status};

    #[test]
    fn an_invalid_value_is_marked_and_only_that_one() {
        let of = |flag: &str| {
            let bits =
                flags_of(SubsystemId::GENERAL).by_name(flag).map_or(0, |info| 1 << info.shift);
            let flags = GeneralFlags::from_bits_retain(bits);
            let state = GeneralStatus { flags, main_voltage: 24, pressure: 0, flowrate: 12 };
            values(&Answer {
                from: SubsystemId::GENERAL,
                request: RequestId::GET_STATUS,
                status: Status::OK,
                data: Reply::General(state),
            })
        };
        assert_eq!(of("PressureSensorBreak"), "24 V, 0.0 atm (invalid), 12 l/s");
        assert_eq!(of("ConnLost"), "24 V (invalid), 0.0 atm (invalid), 12 l/s (invalid)");
        assert_eq!(of("LockedOut"), "24 V, 0.0 atm, 12 l/s");
    }
}
