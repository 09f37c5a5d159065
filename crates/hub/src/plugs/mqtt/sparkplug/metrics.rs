//! The metrics of a monitor and of the node: names, data types, units, ranges, and where their values come from.

use super::payload::datatype::{BOOLEAN, DOUBLE, INT32, INT64, STRING};
use super::payload::{Metric, Property, PropertySet, Value};
use crate::alarms::Priority;
use crate::plugs::mqtt::desk::Reply;
use crate::plugs::mqtt::message::TARGETS;
use crate::plugs::mqtt::state::{Motion, State, Valve};
use crate::plugs::mqtt::words;
use crate::plugs::orders::Command;
use crate::plugs::sight::Holder;

/// Aliases of a device are this far from those of the next one; the first are those of the node.
pub const STRIDE: u64 = 100;
/// The write that asks for new births.
pub const REBIRTH: &str = "Node Control/Rebirth";

/// How much a value is worth, by the numbers of the format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Quality {
    /// There is none: it is not known, or its own monitor calls it faulty.
    #[default]
    Bad = 0,
    /// It is the present one.
    Good = 192,
    /// It is not the present one.
    Stale = 500,
}

/// What a metric shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// The value; `None`: there is none.
    pub value: Option<Value>,
    /// What it is worth.
    pub quality: Quality,
}

impl Cell {
    /// A value that holds; without one it is bad.
    pub fn of(value: Option<Value>) -> Self {
        let quality = if value.is_some() { Quality::Good } else { Quality::Bad };
        Self { value, quality }
    }

    /// A value that holds, or none, which is as good.
    pub fn good(value: Option<Value>) -> Self {
        Self { value, quality: Quality::Good }
    }

    /// A text.
    pub fn text(text: impl Into<String>) -> Self {
        Self::of(Some(Value::Text(text.into())))
    }

    /// A number of 64 bits.
    pub const fn long(number: u64) -> Self {
        Self { value: Some(Value::Long(number)), quality: Quality::Good }
    }

    /// True or false.
    pub const fn flag(flag: bool) -> Self {
        Self { value: Some(Value::Boolean(flag)), quality: Quality::Good }
    }
}

/// A metric as it is announced.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Its name.
    pub name: &'static str,
    /// Its data type.
    pub datatype: u32,
    unit: Option<&'static str>,
    range: Option<(f64, f64)>,
    /// Its value in a state; `None`: it comes from elsewhere.
    read: Option<fn(&State) -> Option<Value>>,
}

impl Row {
    const fn of(name: &'static str, datatype: u32) -> Self {
        Self { name, datatype, unit: None, range: None, read: None }
    }

    const fn read(name: &'static str, datatype: u32, read: fn(&State) -> Option<Value>) -> Self {
        Self { read: Some(read), ..Self::of(name, datatype) }
    }

    const fn unit(self, unit: &'static str) -> Self {
        Self { unit: Some(unit), ..self }
    }

    const fn range(self, range: (f64, f64)) -> Self {
        Self { range: Some(range), ..self }
    }

    /// What a state says; `None`: it says nothing of it. What is not the present one has no value.
    pub fn cell(&self, state: &State) -> Option<Cell> {
        let read = self.read?;
        if state.is_available() {
            return Some(Cell::of(read(state)));
        }
        Some(Cell { value: None, quality: Quality::Stale })
    }

    /// Whether what the host has missed of it is said later.
    pub const fn is_state(&self) -> bool {
        self.read.is_some()
    }

    /// The metric in a birth.
    pub fn announced(&self, alias: Option<u64>, cell: &Cell, at_ms: u64) -> Metric {
        let mut properties =
            PropertySet::default().with("Quality", Property::Int(cell.quality as u32));
        if let Some(unit) = self.unit {
            properties = properties.with("engUnit", Property::Text(unit.to_owned()));
        }
        if let Some((low, high)) = self.range {
            properties = properties.with("engLow", Property::Double(low));
            properties = properties.with("engHigh", Property::Double(high));
        }
        Metric {
            name: Some(self.name.to_owned()),
            alias,
            datatype: Some(self.datatype),
            properties: Some(properties),
            ..shown(cell, at_ms)
        }
    }
}

/// A metric between births; the quality is said where it has changed.
pub fn changed(alias: u64, cell: &Cell, at_ms: u64, quality_too: bool) -> Metric {
    let quality = || PropertySet::default().with("Quality", Property::Int(cell.quality as u32));
    let properties = quality_too.then(quality);
    Metric { alias: Some(alias), properties, ..shown(cell, at_ms) }
}

fn shown(cell: &Cell, at_ms: u64) -> Metric {
    Metric {
        timestamp: Some(at_ms),
        is_null: cell.value.is_none().then_some(true),
        value: cell.value.clone(),
        ..Metric::default()
    }
}

fn whole(number: Option<i64>) -> Option<Value> {
    let number = i32::try_from(number?).ok()?;
    Some(Value::Int(number.cast_unsigned()))
}

fn flag(flag: Option<bool>) -> Option<Value> {
    flag.map(Value::Boolean)
}

fn fraction(number: Option<f64>) -> Option<Value> {
    number.map(Value::Double)
}

fn text(text: &str) -> Option<Value> {
    Some(Value::Text(text.to_owned()))
}

fn valve(state: &State, name: &str, what: fn(&Valve) -> bool) -> Option<Value> {
    flag(state.valves.get(name).and_then(Option::as_ref).map(what))
}

fn motion(state: &State, what: fn(&Motion) -> bool) -> Option<Value> {
    flag(state.motion.as_ref().map(what))
}

const fn holder(holder: Holder) -> &'static str {
    match holder {
        Holder::Free => "free",
        Holder::Mine => "mine",
        Holder::Other => "other",
    }
}

const fn priority(priority: Option<Priority>) -> &'static str {
    match priority {
        Some(Priority::Fire) => "fire",
        Some(Priority::High) => "high",
        Some(Priority::Medium) => "medium",
        Some(Priority::Low) => "low",
        None => "",
    }
}

/// The metrics of a monitor.
pub static DEVICE: [Row; 46] = [
    Row::read("Mode", STRING, |it| it.mode.and_then(text)),
    Row::read("Holder", STRING, |it| text(holder(it.holder))),
    Row::read("Traverse", DOUBLE, |it| fraction(it.traverse)).unit("°").range(TARGETS[0]),
    Row::read("Elevation", DOUBLE, |it| fraction(it.elevation)).unit("°").range(TARGETS[1]),
    Row::read("Nozzle", INT32, |it| whole(it.nozzle)).unit("mm").range(TARGETS[2]),
    Row::read("Pressure", DOUBLE, |it| fraction(it.pressure_mpa)).unit("MPa"),
    Row::read("Flow", INT32, |it| whole(it.flow_lps)).unit("l/s"),
    Row::read("Voltage", INT32, |it| whole(it.voltage_v)).unit("V"),
    Row::read("Fire", BOOLEAN, |it| flag(it.fire)),
    Row::read("Water", BOOLEAN, |it| flag(Some(it.water))),
    Row::read("Locked Out", BOOLEAN, |it| flag(it.locked_out)),
    Row::read("Ready", BOOLEAN, |it| flag(Some(it.ready))),
    Row::read("Alarms/Count", INT32, |it| whole(Some(it.alarms.count.into()))),
    Row::read("Alarms/Waiting", INT32, |it| whole(Some(it.alarms.waiting.into()))),
    Row::read("Alarms/Worst", STRING, |it| text(priority(it.alarms.worst))),
    Row::read("Alarms/Fire", BOOLEAN, |it| flag(Some(it.alarms.fire))),
    Row::read("Motion/Traverse", BOOLEAN, |it| motion(it, |moves| moves.traverse)),
    Row::read("Motion/Elevation", BOOLEAN, |it| motion(it, |moves| moves.elevation)),
    Row::read("Motion/Nozzle", BOOLEAN, |it| motion(it, |moves| moves.nozzle)),
    Row::read("Valve 1/Open", BOOLEAN, |it| valve(it, "valve1", |it| it.open)),
    Row::read("Valve 1/Closed", BOOLEAN, |it| valve(it, "valve1", |it| it.closed)),
    Row::read("Valve 1/Opening", BOOLEAN, |it| valve(it, "valve1", |it| it.opening)),
    Row::read("Valve 1/Closing", BOOLEAN, |it| valve(it, "valve1", |it| it.closing)),
    Row::read("Valve 1/Blocked", BOOLEAN, |it| valve(it, "valve1", |it| it.blocked)),
    Row::read("Valve 1/Fault", BOOLEAN, |it| valve(it, "valve1", |it| it.fault)),
    Row::read("Valve 2/Open", BOOLEAN, |it| valve(it, "valve2", |it| it.open)),
    Row::read("Valve 2/Closed", BOOLEAN, |it| valve(it, "valve2", |it| it.closed)),
    Row::read("Valve 2/Opening", BOOLEAN, |it| valve(it, "valve2", |it| it.opening)),
    Row::read("Valve 2/Closing", BOOLEAN, |it| valve(it, "valve2", |it| it.closing)),
    Row::read("Valve 2/Blocked", BOOLEAN, |it| valve(it, "valve2", |it| it.blocked)),
    Row::read("Valve 2/Fault", BOOLEAN, |it| valve(it, "valve2", |it| it.fault)),
    Row::of("Key", STRING),
    COMMANDS[0],
    COMMANDS[1],
    COMMANDS[2],
    COMMANDS[3],
    RESULT[0],
    RESULT[1],
    RESULT[2],
    RESULT[3],
    RESULT[4],
    RESULT[5],
    RESULT[6],
    RESULT[7],
    RESULT[8],
    RESULT[9],
];

/// The place of a device's key.
pub const KEY: usize = 31;
/// The place of the first metric of its result.
pub const DEVICE_RESULT: usize = 36;
/// What a monitor without a second valve does not have.
pub const VALVE2: std::ops::Range<usize> = 25..31;

/// The metrics of the node.
pub static NODE: [Row; 23] = [
    Row::of("bdSeq", INT64),
    Row::of(REBIRTH, BOOLEAN),
    Row::of("Properties/Program", STRING),
    Row::of("Properties/Version", STRING),
    Row::of("Ticket", STRING),
    Row::of("Alive", STRING),
    Row::of("History/Waiting", INT64),
    Row::of("History/Dropped", INT64),
    COMMANDS[0],
    COMMANDS[1],
    COMMANDS[2],
    COMMANDS[3],
    Row::of("Result/Monitor", STRING),
    RESULT[0],
    RESULT[1],
    RESULT[2],
    RESULT[3],
    RESULT[4],
    RESULT[5],
    RESULT[6],
    RESULT[7],
    RESULT[8],
    RESULT[9],
];

/// The place of the number of the connection.
pub const BD_SEQ: usize = 0;
/// The place of what asks for new births. It has no alias.
pub const REBIRTH_AT: usize = 1;
/// The places of the program and its version.
pub const PROGRAM: [usize; 2] = [2, 3];
/// The place of the ticket.
pub const TICKET: usize = 4;
/// The place of the first of the values that wait and were dropped.
pub const HISTORY: [usize; 2] = [6, 7];
/// The place of the monitor to which the node's result belongs; the first metric of the result is next.
pub const NODE_MONITOR: usize = 12;

/// What is written to command.
const COMMANDS: [Row; 4] = [
    Row::of("Command/Text", STRING),
    Row::of("Command/Stop", BOOLEAN),
    Row::of("Command/Close", BOOLEAN),
    Row::of("Command/Lockout", BOOLEAN),
];

/// The result of a command. Its number shows that there is a new one.
const RESULT: [Row; 10] = [
    Row::of("Result/Id", STRING),
    Row::of("Result/Command", STRING),
    Row::of("Result/Ok", BOOLEAN),
    Row::of("Result/Refusal", INT32),
    Row::of("Result/Text", STRING),
    Row::of("Result/Text ru", STRING),
    Row::of("Result/Status", INT32),
    Row::of("Result/Retained", BOOLEAN),
    Row::of("Result/Number", INT64),
    Row::of("Result/Repeated", BOOLEAN),
];

/// What a result shows, in the order of its metrics.
pub fn result(reply: &Reply, number: u64) -> [Cell; 10] {
    let failed = reply.result.err();
    let said = failed.map(|it| words::of(it.why));
    let text = |it: Option<&str>| Cell::good(it.map(|it| Value::Text(it.to_owned())));
    let count = |it: Option<u16>| Cell::good(it.map(|it| Value::Int(it.into())));
    let status = failed.map(|it| it.status).filter(|it| *it != 0);
    [
        text(reply.id.as_deref()),
        text(reply.command.map(Command::name)),
        Cell::flag(failed.is_none()),
        count(failed.map(|it| it.why.number())),
        text(said.as_ref().map(|it| it.en.as_str())),
        text(said.as_ref().map(|it| it.ru.as_str())),
        count(status),
        Cell::flag(reply.retained),
        Cell::long(number),
        Cell::flag(reply.repeated),
    ]
}

/// What a metric of commands shows before anything is written to it.
pub fn unwritten(row: &Row) -> Cell {
    match row.datatype {
        BOOLEAN => Cell::flag(false),
        STRING => Cell::text(""),
        INT64 => Cell::long(0),
        _ => Cell::good(None),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::time::Duration;

    use super::*;
    use crate::monitor::status::Status;
    use crate::plugs::sight::fixture::status;
    use crate::plugs::sight::{Control, Known, Tally};

    fn state(status: &Status, up: bool) -> State {
        let (age, control, alarms) = (Some(Duration::ZERO), Control::default(), Tally::default());
        State::new(&Known { status, age, up, ready: true, control, alarms })
    }

    #[test]
    fn names_are_each_of_one_metric_and_places_are_those_of_the_table() {
        for rows in [&DEVICE[..], &NODE[..]] {
            let names: BTreeSet<String> = rows.iter().map(|it| it.name.to_lowercase()).collect();
            assert_eq!(names.len(), rows.len(), "hosts may not tell capital letters apart");
            assert!((rows.len() as u64) < STRIDE);
            // A folder cannot be a value as well.
            let folder = |it: &Row| {
                names.iter().any(|name| name.starts_with(&format!("{}/", it.name.to_lowercase())))
            };
            assert!(!rows.iter().any(folder));
        }
        assert_eq!((DEVICE[KEY].name, DEVICE[DEVICE_RESULT].name), ("Key", "Result/Id"));
        assert!(DEVICE[VALVE2].iter().all(|it| it.name.starts_with("Valve 2/")));
        assert!(
            DEVICE[..KEY].iter().all(Row::is_state) && !DEVICE[KEY..].iter().any(Row::is_state)
        );
        let named = [BD_SEQ, REBIRTH_AT, PROGRAM[1], TICKET, HISTORY[1], NODE_MONITOR];
        let names = ["bdSeq", REBIRTH, "Properties/Version", "Ticket", "History/Dropped"];
        assert_eq!(named.map(|at| NODE[at].name)[..5], names);
        assert_eq!(NODE[NODE_MONITOR].name, "Result/Monitor");
        assert_eq!(NODE[NODE_MONITOR + 1].name, "Result/Id");
    }

    #[test]
    fn values_have_the_type_that_is_announced() {
        let state = state(&status(), true);
        let mut seen = 0;
        for row in &DEVICE {
            let Some(Cell { value: Some(value), quality }) = row.cell(&state) else { continue };
            assert_eq!(quality, Quality::Good);
            seen += 1;
            let fits = match value {
                Value::Int(_) => row.datatype == INT32,
                Value::Long(_) => row.datatype == INT64,
                Value::Double(_) => row.datatype == DOUBLE,
                Value::Boolean(_) => row.datatype == BOOLEAN,
                Value::Text(_) => row.datatype == STRING,
                Value::Float(_) => false,
            };
            assert!(fits, "{}", row.name);
        }
        assert_eq!(seen, VALVE2.start, "all but those of the second valve");
        let of = |name: &str| {
            let row = DEVICE.iter().find(|it| it.name == name).unwrap();
            row.cell(&state).unwrap()
        };
        assert_eq!(of("Traverse"), Cell::of(Some(Value::Double(-10.083))));
        assert_eq!(of("Nozzle"), Cell::of(Some(Value::Int(60))));
        assert_eq!(of("Valve 2/Open"), Cell { value: None, quality: Quality::Bad });
    }

    #[test]
    fn what_is_not_the_present_value_is_none_and_stale() {
        for state in [state(&Status { stale: true, ..status() }, true), state(&status(), false)] {
            for row in DEVICE.iter().filter(|it| it.is_state()) {
                assert_eq!(row.cell(&state), Some(Cell { value: None, quality: Quality::Stale }));
            }
        }
    }
}
