//! Messages of clients: what they ask for. A message is JSON of one level, with no field that is not known.

use std::time::Duration;

use serde::Deserialize;
use serde_json::Value;

use crate::plugs::orders::{Command, What};
use crate::plugs::refusal::Refusal;

/// Longest message, bytes.
pub const PAYLOAD_MAX: usize = 4096;
/// Longest id, characters.
pub const ID_MAX: usize = 64;
/// A result comes within this time, unless the command says another one, ms.
const TIMEOUT_USUAL_MS: u64 = 1000;
/// Allowed times for a result, ms.
const TIMEOUT_MS: std::ops::RangeInclusive<u64> = 100..=60_000;
/// Least and greatest target of a drive: degrees, of the nozzle mm.
pub const TARGETS: [(f64, f64); 3] = [(-360.0, 360.0), (-90.0, 180.0), (0.0, 1000.0)];

/// A command as written.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Written {
    id: Option<String>,
    command: String,
    ticket: Option<String>,
    key: Option<String>,
    traverse: Option<f64>,
    elevation: Option<f64>,
    nozzle: Option<f64>,
    valve: Option<u16>,
    timeout_ms: Option<u64>,
}

/// A sign of life as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Alive {
    ticket: String,
}

/// What a message asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// Its id, if that can be read.
    pub id: Option<String>,
    /// The command, if there is one of this name.
    pub command: Option<Command>,
    /// What it asks for, or what is wrong with it.
    pub what: Result<What, Refusal>,
    /// The proof that it is new.
    pub ticket: Option<u64>,
    /// The proof that this opening is meant.
    pub key: Option<u64>,
    /// Time for its result.
    pub timeout: Duration,
}

impl Asked {
    /// What cannot be done, and why.
    pub fn wrong(id: Option<String>, command: Option<Command>, why: Refusal) -> Self {
        let timeout = Duration::from_millis(TIMEOUT_USUAL_MS);
        Self { id, command, what: Err(why), ticket: None, key: None, timeout }
    }

    /// Stop, Lockout or the closing of all valves, without an id.
    pub fn urgent(command: Command) -> Self {
        let what = match command {
            Command::Stop => Ok(What::Stop),
            Command::Lockout => Ok(What::Lockout),
            Command::Close => Ok(What::Close(0)),
            _ => Err(Refusal::Form),
        };
        Self { what, ..Self::wrong(None, Some(command), Refusal::Form) }
    }
}

/// Reads a command. Of one that cannot be read as a whole, Stop, Close and Lockout are taken all the same.
pub fn read(payload: &[u8]) -> Asked {
    if !is_object(payload) {
        return Asked::wrong(None, None, Refusal::Form);
    }
    match serde_json::from_slice::<Written>(payload) {
        Ok(written) => of(written),
        Err(_) => salvaged(&serde_json::from_slice(payload).unwrap_or_default()),
    }
}

/// Reads the ticket of a sign of life.
pub fn read_alive(payload: &[u8]) -> Option<u64> {
    if !is_object(payload) {
        return None;
    }
    number(&serde_json::from_slice::<Alive>(payload).ok()?.ticket)
}

/// Whether it can be one: a list would be read as fields without names.
pub fn is_object(payload: &[u8]) -> bool {
    payload.len() <= PAYLOAD_MAX && payload.trim_ascii_start().starts_with(b"{")
}

/// A ticket or key as it is written.
pub fn shown(number: u64) -> String {
    format!("{number:016x}")
}

/// The number of 16 hexadecimal digits.
pub fn number(text: &str) -> Option<u64> {
    let is_hex = text.len() == 16 && text.bytes().all(|it| it.is_ascii_hexdigit());
    is_hex.then(|| u64::from_str_radix(text, 16).ok())?
}

fn is_id(text: &str) -> bool {
    let fine = |it: u8| it == b' ' || it.is_ascii_graphic();
    (1..=ID_MAX).contains(&text.len()) && text.bytes().all(fine)
}

fn of(written: Written) -> Asked {
    let command = Command::by_name(&written.command);
    let id = written.id.clone().filter(|id| is_id(id));
    let urgent = command.is_some_and(Command::is_urgent);
    let timeout_ms = written.timeout_ms.unwrap_or(TIMEOUT_USUAL_MS);
    let Some(command) = command else { return Asked::wrong(id, None, Refusal::Command) };
    if id.is_none() && !urgent {
        return Asked::wrong(None, Some(command), Refusal::Form);
    }
    let in_range = TIMEOUT_MS.contains(&timeout_ms);
    let what = what(command, &written).filter(|_| urgent || in_range);
    Asked {
        id,
        command: Some(command),
        what: what.ok_or(Refusal::Argument),
        ticket: written.ticket.as_deref().and_then(number),
        key: written.key.as_deref().and_then(number),
        timeout: Duration::from_millis(if in_range { timeout_ms } else { TIMEOUT_USUAL_MS }),
    }
}

fn what(command: Command, written: &Written) -> Option<What> {
    let targets = [written.traverse, written.elevation, written.nozzle];
    let (moves, valve) = (targets.iter().any(Option::is_some), written.valve);
    // Stop and Lockout do not fail for what else is written.
    match command {
        Command::Stop => return Some(What::Stop),
        Command::Lockout => return Some(What::Lockout),
        Command::Close => {
            return Some(What::Close(valve.unwrap_or(0))).filter(|_| valve.is_none_or(is_valve));
        }
        Command::GoTo if valve.is_none() && moves => return targets_of(targets).map(What::GoTo),
        Command::Open if !moves => return valve.filter(|it| is_valve(*it)).map(What::Open),
        _ => {}
    }
    if moves || valve.is_some() {
        return None;
    }
    match command {
        Command::Take | Command::Release | Command::Ask => Some(What::Authority(command)),
        Command::Deploy => Some(What::Deploy),
        Command::Stow => Some(What::Stow),
        _ => None,
    }
}

/// Whether it is the number of a valve.
pub const fn is_valve(number: u16) -> bool {
    matches!(number, 1 | 2)
}

/// Targets in their range: degrees to arc-minutes; the nozzle is in mm.
pub fn targets_of(written: [Option<f64>; 3]) -> Option<[Option<i16>; 3]> {
    let mut targets = [None; 3];
    for (axis, (value, (least, most))) in written.into_iter().zip(TARGETS).enumerate() {
        let Some(value) = value else { continue };
        if !(least..=most).contains(&value) {
            return None;
        }
        let scale = if axis == 2 { 1.0 } else { 60.0 };
        targets[axis] = Some((value * scale).round() as i16);
    }
    Some(targets)
}

/// What can be made out of a message that is not as it should be.
fn salvaged(value: &Value) -> Asked {
    let text = |key: &str| value.get(key).and_then(Value::as_str);
    let id = text("id").filter(|id| is_id(id)).map(str::to_owned);
    let command = text("command").and_then(Command::by_name);
    let what = match (command, value.get("valve")) {
        (Some(Command::Stop), _) => Ok(What::Stop),
        (Some(Command::Lockout), _) => Ok(What::Lockout),
        (Some(Command::Close), None | Some(Value::Null)) => Ok(What::Close(0)),
        (Some(Command::Close), Some(valve)) => {
            let valve = valve.as_u64().and_then(|it| u16::try_from(it).ok());
            valve.filter(|it| is_valve(*it)).map(What::Close).ok_or(Refusal::Argument)
        }
        _ => Err(Refusal::Form),
    };
    match what {
        Ok(what) => Asked { what: Ok(what), ..Asked::wrong(id, command, Refusal::Form) },
        Err(why) => Asked::wrong(id, command, why),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Asked {
        read(text.as_bytes())
    }

    #[test]
    fn commands_are_read_in_degrees_and_millimetres() {
        let asked = read_text(
            r#"{"id":"a 1","command":"goto","ticket":"00000000000000ff","traverse":-10.01,"nozzle":60,
                "timeout_ms":60000}"#,
        );
        assert_eq!(asked.id.as_deref(), Some("a 1"));
        assert_eq!(asked.what, Ok(What::GoTo([Some(-601), None, Some(60)])));
        assert_eq!((asked.ticket, asked.timeout.as_secs()), (Some(255), 60));
        let open = read_text(r#"{"id":"2","command":"open","valve":2,"key":"00000000000000Fe"}"#);
        assert_eq!((open.what, open.key), (Ok(What::Open(2)), Some(254)));
        for command in Command::ALL {
            let name = command.name();
            assert_eq!(Command::by_name(name), Some(command));
            let bare = read_text(&format!(r#"{{"id":"1","command":"{name}"}}"#));
            let needs = matches!(command, Command::GoTo | Command::Open);
            assert_eq!(bare.what.is_err(), needs, "{name}");
        }
        assert_eq!(read_text(r#"{"command":"close"}"#).what, Ok(What::Close(0)));
    }

    #[test]
    fn what_is_out_of_range_or_unknown_is_refused_with_its_id() {
        for (text, why) in [
            (r#"{"id":"1","command":"goto","traverse":361}"#, Refusal::Argument),
            (r#"{"id":"1","command":"goto","elevation":-91}"#, Refusal::Argument),
            (r#"{"id":"1","command":"goto","traverse":1,"valve":1}"#, Refusal::Argument),
            (r#"{"id":"1","command":"goto"}"#, Refusal::Argument),
            (r#"{"id":"1","command":"open","valve":3}"#, Refusal::Argument),
            (r#"{"id":"1","command":"open"}"#, Refusal::Argument),
            (r#"{"id":"1","command":"take","valve":1}"#, Refusal::Argument),
            (r#"{"id":"1","command":"take","timeout_ms":60001}"#, Refusal::Argument),
            (r#"{"id":"1","command":"close","valve":3}"#, Refusal::Argument),
            (r#"{"id":"1","command":"close","valve":"1"}"#, Refusal::Argument),
            (r#"{"id":"1","command":"jog"}"#, Refusal::Command),
            (r#"{"id":"1"}"#, Refusal::Command),
            (r#"{"id":"1","command":"open","valve":1,"force":true}"#, Refusal::Form),
            (r#"{"id":"1","command":"open","valve":[1]}"#, Refusal::Form),
            (r#"{"id":"1","command":"take","command":"open","valve":1}"#, Refusal::Form),
            (r#"{"id":"1","command":"goto","traverse":1e999}"#, Refusal::Form),
        ] {
            let asked = read_text(text);
            assert_eq!(asked.what, Err(why), "{text}");
            // Nothing can be read of a number beyond all bounds.
            let id = (!text.contains("1e999")).then_some("1");
            assert_eq!(asked.id.as_deref(), id, "{text}");
        }
    }

    #[test]
    fn what_cannot_be_read_has_no_id_and_asks_for_nothing() {
        let deep = format!(r#"{{"id":{}1{}}}"#, "[".repeat(1000), "]".repeat(1000));
        let long =
            format!(r#"{{"id":"1","command":"take","ticket":"{}"}}"#, "a".repeat(PAYLOAD_MAX));
        let id = "i".repeat(ID_MAX + 1);
        for text in [
            "",
            "stop",
            "null",
            "[]",
            r#"["1","open","0000000000000010","0000000000000010",null,null,null,1]"#,
            "\u{0}",
            r#"{"command":"take"}"#,
            r#"{"id":7,"command":"take"}"#,
            r#"{"id":"ж","command":"take"}"#,
            "{\"id\":\"a\\nb\",\"command\":\"take\"}",
            &format!(r#"{{"id":"{id}","command":"take"}}"#),
            &deep,
            &long,
        ] {
            let asked = read_text(text);
            assert_eq!((asked.id, asked.what), (None, Err(Refusal::Form)), "{text:.80}");
        }
        assert_eq!(read(&[0xFF, 0xFE]).what, Err(Refusal::Form));
    }

    #[test]
    fn stop_close_and_lockout_are_taken_from_messages_that_are_not_as_they_should_be() {
        for (text, what) in [
            (r#"{"command":"stop"}"#, What::Stop),
            (r#"{"command":"stop","id":7}"#, What::Stop),
            (r#"{"command":"stop","id":"1","valve":9,"timeout_ms":0}"#, What::Stop),
            (r#"{"command":"stop","id":"1","reason":{"a":[1]}}"#, What::Stop),
            (r#"{"command":"lockout","x":1}"#, What::Lockout),
            (r#"{"command":"close","x":1}"#, What::Close(0)),
            (r#"{"command":"close","x":1,"valve":2}"#, What::Close(2)),
        ] {
            assert_eq!(read_text(text).what, Ok(what), "{text}");
        }
    }

    #[test]
    fn signs_of_life_have_a_ticket_and_nothing_else() {
        assert_eq!(read_alive(br#"{"ticket":"0000000000000010"}"#), Some(16));
        for wrong in [
            "{}",
            r#"{"ticket":"10"}"#,
            r#"{"ticket":16}"#,
            r#"{"ticket":"+000000000000010"}"#,
            r#"{"ticket":"0000000000000010","x":1}"#,
        ] {
            assert_eq!(read_alive(wrong.as_bytes()), None, "{wrong}");
        }
        assert_eq!(number(&shown(0xABCD)), Some(0xABCD));
    }
}
