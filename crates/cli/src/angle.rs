//! Angles and positions in the forms people write them: `1200`, `20deg`, `12°30'`, `30mm`.

use lafet_proto::SubsystemId;
use lafet_texts::{Text as _, cli as text};

use crate::lang::{current, decimal};

/// An angle or position in wire units: arc-minutes, or millimetres for the nozzle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Angle(pub i16);

impl std::str::FromStr for Angle {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        arcmin(text).map(Self)
    }
}

/// An azimuth or elevation in arc-minutes, parsed as `--fire` writes it: a plain number is degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bearing(pub i16);

impl std::str::FromStr for Bearing {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let plain = text.trim().parse::<f64>().is_ok();
        arcmin(&if plain { format!("{}deg", text.trim()) } else { text.to_owned() }).map(Self)
    }
}

/// Two angles separated by a comma, in arc-minutes: `-20deg,3deg`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair(pub i16, pub i16);

impl std::str::FromStr for Pair {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (first, second) =
            text.split_once(',').ok_or_else(|| text::TwoAnglesExpected.str(current()))?;
        Ok(Self(arcmin(first)?, arcmin(second)?))
    }
}

/// Parses a position of a drive; a plain number is in wire units (arc-minutes, mm of the nozzle).
pub fn position(drive: SubsystemId, text: &str) -> Result<i16, String> {
    if drive != SubsystemId::NOZZLE {
        return arcmin(text);
    }
    let number = ["mm", "мм"].iter().find_map(|unit| text.trim().strip_suffix(unit));
    number.unwrap_or(text).trim().parse().map_err(|_| text::NozzleNotMm { text }.of(current()))
}

/// A position with its unit: `1200' (20.0°)`, `30 mm`.
pub fn show(drive: SubsystemId, position: i32) -> String {
    if drive == SubsystemId::NOZZLE {
        format!("{position} {}", text::UnitMm.str(current()))
    } else {
        format!("{position}' ({})", degrees(position))
    }
}

/// Arc-minutes as degrees with one decimal: `20.0°`.
pub fn degrees(arcmin: i32) -> String {
    let tenths = (f64::from(arcmin) / 6.0).round() / 10.0;
    // Adding 0.0 turns -0.0 into 0.0: no "-0.0°".
    format!("{}°", decimal(tenths + 0.0, 1))
}

fn arcmin(text: &str) -> Result<i16, String> {
    let trimmed = text.trim();
    let parsed = ["deg", "град"]
        .iter()
        .find_map(|unit| trimmed.strip_suffix(unit))
        .map(|number| number.trim().parse::<f64>().ok().map(|degrees| degrees * 60.0))
        .or_else(|| trimmed.split_once('°').map(|parts| degrees_minutes(parts.0, parts.1)))
        .unwrap_or_else(|| minutes(trimmed));
    let limits = f64::from(i16::MIN)..=f64::from(i16::MAX);
    match parsed.map(f64::round) {
        Some(value) if limits.contains(&value) => Ok(value as i16),
        _ => Err(text::NotAnAngle { text }.of(current())),
    }
}

fn minutes(text: &str) -> Option<f64> {
    let number = text.strip_suffix(['\'', '′']).unwrap_or(text).trim();
    number.parse().ok().filter(|value: &f64| value.is_finite())
}

fn degrees_minutes(degrees: &str, rest: &str) -> Option<f64> {
    let whole: f64 = degrees.trim().parse().ok()?;
    let rest = if rest.trim().is_empty() { 0.0 } else { minutes(rest.trim())? };
    let sign = if degrees.trim().starts_with('-') { -1.0 } else { 1.0 };
    (rest >= 0.0).then_some(whole * 60.0 + sign * rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bearings_are_degrees_unless_they_say_otherwise() {
        for (text, arcmin) in
            [("-60", -3600), ("5.5", 330), ("20deg", 1200), ("1800'", 1800), ("12°30'", 750)]
        {
            assert_eq!(text.parse(), Ok(Bearing(arcmin)), "{text}");
        }
        assert!("600".parse::<Bearing>().is_err(), "beyond what an int16 can say");
        assert!("north".parse::<Bearing>().is_err());
    }

    #[test]
    fn angles() {
        for (text, expected) in [
            ("1200", 1200),
            ("-900", -900),
            ("1200'", 1200),
            ("20deg", 1200),
            ("-12.5deg", -750),
            ("12.5°", 750),
            ("12°30'", 750),
            ("-0°30'", -30),
            ("-32768", i16::MIN),
        ] {
            assert_eq!(text.parse(), Ok(Angle(expected)), "{text}");
        }
        for text in ["", "deg", "up", "600deg", "nan", "infdeg", "12°-3'", "1e9"] {
            assert!(text.parse::<Angle>().is_err(), "{text}");
        }
        assert_eq!("-20deg,180".parse(), Ok(Pair(-1200, 180)));
        assert!("20deg".parse::<Pair>().is_err());
    }

    #[test]
    fn positions() {
        assert_eq!(position(SubsystemId::NOZZLE, "30mm"), Ok(30));
        assert_eq!(position(SubsystemId::NOZZLE, "-5"), Ok(-5));
        assert!(position(SubsystemId::NOZZLE, "30deg").is_err());
        assert_eq!(position(SubsystemId::VERTICAL, "2deg"), Ok(120));
        assert_eq!(show(SubsystemId::VERTICAL, -745), "-745' (-12.4°)");
        assert_eq!(show(SubsystemId::HORIZONTAL, -1), "-1' (0.0°)");
    }
}
