//! The board's record as a text file: `key = value` a line, `#` begins a comment.

use std::fmt::Write as _;

use lafet_stm32f103::record::{DriveRecord, Record};

const DRIVES: [&str; 4] = ["vertical", "horizontal", "nozzle", "deployer"];

/// The file of a record, with what each figure means.
pub fn write(record: &Record) -> String {
    let mut text = String::from(
        "# The record of a board: docs/board-stm32f103.md says how to find the figures.\n",
    );
    for (key, value, meaning) in [
        ("baud", record.baud, "of the line, 9600 to 115200"),
        ("counts_per_ampere", record.counts_per_ampere, "of the ADC, motors and valves"),
        ("supply_full_dv", record.supply_full_dv, "0.1 V at full scale of the ADC"),
        ("loop_full_ua", record.loop_full_ua, "µA at full scale: pressure sensor"),
        ("pulses_per_10_l", record.pulses_per_10_l, "of the flow meter; 0: there is none"),
    ] {
        let _ = writeln!(text, "{key} = {value}  # {meaning}");
    }
    for (name, drive) in DRIVES.iter().zip(&record.drives) {
        let unit = if *name == "nozzle" { "mm" } else { "'" };
        for (key, value, meaning) in [
            ("counts_per_100", drive.counts_per_100, format!("of the encoder in 100 {unit}")),
            ("full_tenths", drive.full_tenths.into(), "0.1 °/s or mm/s with full voltage".into()),
            ("reversed", drive.is_reversed.into(), "1: a high direction pin turns it down".into()),
            ("min_end", drive.ends.0, format!("where the lower end switch opens, {unit}")),
            ("max_end", drive.ends.1, format!("where the upper end switch opens, {unit}")),
            ("parked", drive.parked, format!("where it is parked, {unit}")),
        ] {
            let _ = writeln!(text, "{name}.{key} = {value}  # {meaning}");
        }
    }
    text
}

/// The record of a file. Every figure must be there, and be one the board takes.
pub fn read(text: &str) -> Result<Record, String> {
    let mut record = Record::NOMINAL;
    let mut odd = Vec::new();
    let mut missing: Vec<String> =
        write(&record).lines().filter_map(|line| Some(entry(line)?.0.to_owned())).collect();
    for (number, line) in (1..).zip(text.lines()) {
        let (line, _) = line.split_once('#').unwrap_or((line, ""));
        if line.trim().is_empty() {
            continue;
        }
        let (key, value) =
            entry(line).ok_or_else(|| format!("line {number}: `{}` is no figure", line.trim()))?;
        let place = missing.iter().position(|it| it == key);
        let place =
            place.ok_or_else(|| format!("line {number}: {key} is unknown, or there twice"))?;
        missing.swap_remove(place);
        let value: i32 =
            value.parse().map_err(|_| format!("line {number}: {value} is no number"))?;
        set(&mut record, key, value)
            .ok_or_else(|| format!("out of range: line {number}: {key} = {value}"))?;
        let mut alone = Record::NOMINAL;
        if set(&mut alone, key, value).is_none() || !alone.is_sensible() {
            odd.push(format!("line {number}: {key} = {value}"));
        }
    }
    missing.sort();
    match (missing.is_empty(), record.is_sensible()) {
        (false, _) => Err(format!("missing: {}", missing.join(", "))),
        (true, false) if odd.is_empty() => Err("a min_end is not below its max_end".into()),
        (true, false) => Err(format!("out of range: {}", odd.join(", "))),
        (true, true) => Ok(record),
    }
}

fn entry(line: &str) -> Option<(&str, &str)> {
    let (key, value) = line.split('#').next()?.split_once('=')?;
    Some((key.trim(), value.trim()))
}

fn set(record: &mut Record, key: &str, value: i32) -> Option<()> {
    if let Some((name, key)) = key.split_once('.') {
        let index = DRIVES.iter().position(|drive| *drive == name)?;
        return set_drive(record.drives.get_mut(index)?, key, value);
    }
    let place = match key {
        "baud" => &mut record.baud,
        "counts_per_ampere" => &mut record.counts_per_ampere,
        "supply_full_dv" => &mut record.supply_full_dv,
        "loop_full_ua" => &mut record.loop_full_ua,
        "pulses_per_10_l" => &mut record.pulses_per_10_l,
        _ => return None,
    };
    *place = value.try_into().ok()?;
    Some(())
}

fn set_drive(drive: &mut DriveRecord, key: &str, value: i32) -> Option<()> {
    match key {
        "counts_per_100" => drive.counts_per_100 = value,
        "full_tenths" => drive.full_tenths = value.try_into().ok()?,
        "reversed" => drive.is_reversed = (0..=1).contains(&value).then_some(value == 1)?,
        "min_end" => drive.ends.0 = value,
        "max_end" => drive.ends.1 = value,
        "parked" => drive.parked = value,
        _ => return None,
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_comes_back() {
        let mut record = Record::NOMINAL;
        record.baud = 57_600;
        record.drives[2] = DriveRecord {
            counts_per_100: -1_234,
            full_tenths: 77,
            is_reversed: true,
            ends: (-3, 88),
            parked: 5,
        };
        assert_eq!(read(&write(&record)), Ok(record));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let nominal = write(&Record::NOMINAL);
        let without = nominal.replace("baud", "bauds");
        assert!(read(&without).unwrap_err().contains("bauds is unknown"));
        let lines: Vec<_> =
            nominal.lines().filter(|line| !line.starts_with("vertical.p")).collect();
        assert_eq!(read(&lines.join("\n")), Err("missing: vertical.parked".into()));
        let fast = nominal.replace("baud = 115200", "baud = 1");
        assert_eq!(read(&fast), Err("out of range: line 2: baud = 1".into()));
        let full = nominal.replace("nozzle.full_tenths = ", "nozzle.full_tenths = 5");
        assert!(read(&full).unwrap_err().contains("nozzle.full_tenths = 5"), "{full}");
        let ends = nominal.replace("nozzle.min_end = ", "nozzle.min_end = 9");
        assert!(read(&ends).unwrap_err().contains("nozzle.min_end = 9"), "{ends}");
        let word = nominal.replace("= 115200", "= fast");
        assert_eq!(read(&word), Err("line 2: fast is no number".into()));
        let turned = nominal.replace("vertical.reversed = 0", "vertical.reversed = 2");
        assert_eq!(read(&turned), Err("out of range: line 9: vertical.reversed = 2".into()));
        let stray = format!("   cargo run\n{nominal}");
        assert_eq!(read(&stray), Err("line 1: `cargo run` is no figure".into()));
    }
}
