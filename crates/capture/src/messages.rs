//! Contents of frames as JSON with JSON schemas: states in plain units, and a log.

use lafet_proto::bus::MONITORS;
use lafet_proto::dictionary::STATUSES;
use lafet_proto::dictionary::layouts::{Field, Kind, Layout, of_answer};
use lafet_proto::flags::flags_of;
use lafet_proto::link::Frame;
use lafet_proto::param::Unit;
use lafet_proto::record::Records;
use lafet_proto::text::{AnswerText, RequestText};
use lafet_proto::{Record, RequestId, SubsystemId};
use serde_json::{Map, Value, json};

/// A message and its topic.
pub struct Message {
    /// Last part of the topic.
    pub topic: String,
    /// Schema of the JSON.
    pub schema: Schema,
    /// The message.
    pub json: Value,
}

/// A named JSON schema.
pub struct Schema {
    /// Name of the schema.
    pub name: &'static str,
    /// The schema itself.
    pub json: Value,
}

/// Levels of Foxglove's log.
const INFO: u8 = 2;
const WARNING: u8 = 3;

/// The messages for a frame to or from a monitor.
pub fn of_frame(frame: &Frame<'_>, at_ns: u64) -> Vec<Message> {
    let answers = MONITORS.contains(&frame.src);
    let mut messages = Vec::new();
    for record in Records::new(frame.payload).map_while(Result::ok) {
        match state(&record).filter(|_| answers) {
            Some(state) => messages.push(state),
            // Polls come many times a second and carry no information.
            None if !answers && record.request == RequestId::GET_STATUS => {}
            None => messages.push(log(&record, answers, at_ns)),
        }
    }
    messages
}

fn state(record: &Record<'_>) -> Option<Message> {
    if record.request != RequestId::GET_STATUS || !record.status.is_success() {
        return None;
    }
    let layout =
        of_answer(record.request, record.device).iter().find(|layout| layout.fits(record.data))?;
    let mut json = Map::new();
    for (_, field, value) in layout.values(record.data) {
        if field.kind == Kind::Flags {
            let bits = value as u32;
            json.insert("flags".into(), flags(record.device, bits));
        } else {
            let (suffix, factor, _) = plain(field.unit);
            json.insert(name(field, suffix), json!(rounded(value as f64 * factor)));
        }
    }
    Some(Message {
        topic: record.device.to_string(),
        schema: schema(record.device, layout),
        json: Value::Object(json),
    })
}

fn flags(from: SubsystemId, bits: u32) -> Value {
    let all = flags_of(from).flags.iter().map(|flag| {
        let value = flag.value(bits);
        let value = if flag.width == 1 { json!(value != 0) } else { json!(value) };
        (flag.name.to_owned(), value)
    });
    Value::Object(all.collect())
}

fn schema(from: SubsystemId, layout: &Layout) -> Schema {
    let mut properties = Map::new();
    for field in layout.fields {
        if field.kind == Kind::Flags {
            let one = |flag: &lafet_proto::flags::FlagInfo| {
                let kind = if flag.width == 1 { "boolean" } else { "integer" };
                let text = lafet_texts::dictionary(flag.meaning).en;
                (flag.name.to_owned(), json!({ "type": kind, "description": text }))
            };
            let flags: Map<_, _> = flags_of(from).flags.iter().map(one).collect();
            properties.insert("flags".into(), json!({ "type": "object", "properties": flags }));
        } else {
            let (suffix, _, unit) = plain(field.unit);
            let text = lafet_texts::dictionary(field.text).en;
            let text = match unit {
                "" => text.to_owned(),
                unit => format!("{text}, {unit}"),
            };
            let property = json!({ "type": "number", "description": text });
            properties.insert(name(field, suffix), property);
        }
    }
    Schema { name: layout.name, json: json!({ "type": "object", "properties": properties }) }
}

fn name(field: &Field, suffix: &str) -> String {
    if suffix.is_empty() { field.name.into() } else { format!("{}_{suffix}", field.name) }
}

/// The unit for plots: suffix of the name, factor, symbol.
const fn plain(unit: Unit) -> (&'static str, f64, &'static str) {
    match unit {
        Unit::Arcmin => ("deg", 1.0 / 60.0, "°"),
        Unit::Millimetre => ("mm", 1.0, "mm"),
        Unit::DeciAmpere => ("a", 0.1, "A"),
        Unit::Volt => ("v", 1.0, "V"),
        Unit::DeciCelsius => ("c", 0.1, "°C"),
        Unit::DeciAtmosphere => ("atm", 0.1, "atm"),
        Unit::LitrePerSecond => ("lps", 1.0, "l/s"),
        Unit::Percent => ("percent", 1.0, "%"),
        Unit::DegreePerSecond => ("deg_s", 1.0, "°/s"),
        Unit::MillimetrePerSecond => ("mm_s", 1.0, "mm/s"),
        _ => ("", 1.0, ""),
    }
}

/// Removes the digits that come from the conversion of units alone.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

fn log(record: &Record<'_>, answer: bool, at_ns: u64) -> Message {
    let text =
        if answer { AnswerText(*record).to_string() } else { RequestText(*record).to_string() };
    let refused = answer
        && STATUSES.iter().any(|info| info.status == record.status && !info.status.is_success());
    let json = json!({
        "timestamp": { "sec": at_ns / 1_000_000_000, "nsec": at_ns % 1_000_000_000 },
        "level": if refused { WARNING } else { INFO },
        "message": text,
        "name": record.device.to_string(),
        "file": "",
        "line": 0,
    });
    Message { topic: "log".into(), schema: log_schema(), json }
}

/// Schema of the log, as Foxglove's panels expect it.
fn log_schema() -> Schema {
    let integer = json!({ "type": "integer" });
    let string = json!({ "type": "string" });
    let time = json!({ "type": "object", "properties": { "sec": integer, "nsec": integer } });
    let properties = json!({
        "timestamp": time,
        "level": integer,
        "message": string,
        "name": string,
        "file": string,
        "line": integer,
    });
    let json = json!({ "title": "foxglove.Log", "type": "object", "properties": properties });
    Schema { name: "foxglove.Log", json }
}
