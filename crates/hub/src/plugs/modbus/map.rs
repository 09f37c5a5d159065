//! The register map as a table: from the layout, the dictionary of the protocol and the configuration.

use lafet_proto::flags::flags_of;
use lafet_texts::{Lang, Text as _, dictionary, hub as text};
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::ServerConfig;
use super::desk::Command;
use super::layout::{
    COMMAND, DETAIL, DETAIL_LEN, DETAILED, HEADER, HEARTBEAT, JOG, JOG_RESULT, KEY_LEN, KEYS,
    NAME_LEN, NAMES, RESULT_LEN, RESULTS, RESULTS_KEPT, SESSION, SUMMARY, SUMMARY_LEN,
};
use super::refusal::Refusal;
use crate::text::Both;

/// A register or several, or a bit of one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Row {
    /// Address of the unit.
    pub unit: u8,
    /// Address of the first register, from 0.
    pub address: u16,
    /// The bit, if it is one.
    pub bit: Option<u32>,
    /// Name for programs.
    pub name: String,
    /// How many registers.
    pub words: u16,
    /// Whether it is written.
    pub written: bool,
    /// How its value is to be read: `uint16`, `int16`, `uint32`, `uint64`, `bits`, `ascii`.
    pub kind: &'static str,
    /// Unit of the value; empty: none.
    pub measure: &'static str,
    /// What it means.
    pub text: Both,
}

/// A column: name, words, kind, measure, text.
type Column = (&'static str, u16, &'static str, &'static str, Both);

/// The rows of a unit with these monitors.
pub fn rows(unit: u8, monitors: &[String]) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut block = |prefix: &str, at: u16, written: bool, columns: &[Column]| {
        let mut address = at;
        for (name, words, kind, measure, text) in columns {
            let name = format!("{prefix}{name}");
            let (words, kind, measure, text) = (*words, *kind, *measure, text.clone());
            rows.push(Row { unit, address, bit: None, name, words, written, kind, measure, text });
            address += words;
        }
    };
    block("", HEADER, false, &header());
    for (at, id) in (0..).zip(monitors) {
        block(&format!("{id}."), SUMMARY + at * SUMMARY_LEN as u16, false, &summary());
    }
    block("session.", SESSION, false, &session());
    for at in 0..RESULTS_KEPT as u16 {
        let prefix = format!("result{}.", at + 1);
        block(&prefix, RESULTS + at * RESULT_LEN as u16, false, &result());
    }
    block("jog_result.", JOG_RESULT, false, &jog_result());
    for (at, id) in (0..).zip(monitors) {
        let key = [("key", 4, "uint64", "", text::MapKey.words())];
        block(&format!("{id}."), KEYS + at * KEY_LEN as u16, false, &key);
    }
    block("", HEARTBEAT, true, &[("heartbeat", 1, "uint16", "", text::MapHeartbeat.words())]);
    block("jog.", JOG, true, &jog());
    block("command.", COMMAND, true, &command());
    for (at, id) in (0..).zip(monitors) {
        let name = [("id", NAME_LEN as u16, "ascii", "", text::MapId.words())];
        block(&format!("{id}."), NAMES + at * NAME_LEN as u16, false, &name);
    }
    for (at, id) in (0..).zip(monitors) {
        detail(&mut rows, unit, id, DETAIL + at * DETAIL_LEN as u16);
    }
    rows
}

fn header() -> [Column; 4] {
    [
        ("map_version", 2, "uint32", "", text::MapVersion.words()),
        ("hub_heartbeat", 1, "uint16", "0.1 s", text::MapLife.words()),
        ("monitors", 1, "uint16", "", text::MapMonitors.words()),
        ("site", 1, "bits", "", text::MapSite.words()),
    ]
}

fn summary() -> [Column; SUMMARY_LEN] {
    [
        ("quality", 1, "bits", "", text::MapQuality.words()),
        ("age", 1, "uint16", "ms", text::MapAge.words()),
        ("mode", 1, "uint16", "", text::MapMode.words()),
        ("authority", 1, "bits", "", text::MapAuthority.words()),
        ("horizontal", 1, "int16", "0.1°", text::MapHorizontal.words()),
        ("vertical", 1, "int16", "0.1°", text::MapVertical.words()),
        ("nozzle", 1, "int16", "mm", text::MapNozzle.words()),
        ("pressure", 1, "uint16", "0.1 atm", text::MapPressure.words()),
        ("flow", 1, "uint16", "l/s", text::MapFlow.words()),
        ("valves", 1, "bits", "", text::MapValves.words()),
        ("fire", 1, "bits", "", text::MapFire.words()),
        ("alarms", 1, "bits", "", text::MapAlarms.words()),
        ("state", 1, "bits", "", text::MapState.words()),
        ("motion", 1, "bits", "", text::MapMotion.words()),
        ("voltage", 1, "uint16", "V", text::MapVoltage.words()),
    ]
}

fn session() -> [Column; 7] {
    [
        ("number", 2, "uint32", "", text::MapSession.words()),
        ("role", 1, "uint16", "", text::MapRole.words()),
        ("live", 1, "uint16", "", text::MapLive.words()),
        ("heartbeat_limit", 1, "uint16", "ms", text::MapLimit.words()),
        ("heartbeat_losses", 1, "uint16", "", text::MapLosses.words()),
        ("heartbeat_heard", 1, "uint16", "", text::MapHeard.words()),
        ("profile", 1, "uint16", "", text::MapProfile.words()),
    ]
}

fn result() -> [Column; RESULT_LEN] {
    [
        ("sequence", 1, "uint16", "", text::MapResultSequence.words()),
        ("state", 1, "uint16", "", text::MapResultState.words()),
        ("refusal", 1, "uint16", "", text::MapResultRefusal.words()),
        ("command", 1, "uint16", "", text::MapResultCommand.words()),
        ("monitor", 1, "uint16", "", text::MapResultMonitor.words()),
        ("status", 1, "uint16", "", text::MapResultStatus.words()),
    ]
}

fn jog_result() -> [Column; 7] {
    [
        ("sequence", 1, "uint16", "", text::MapJogSequence.words()),
        ("state", 1, "uint16", "", text::MapJogState.words()),
        ("refusal", 1, "uint16", "", text::MapResultRefusal.words()),
        ("monitor", 1, "uint16", "", text::MapResultMonitor.words()),
        ("horizontal", 1, "uint16", "", text::MapJogDrive.words()),
        ("vertical", 1, "uint16", "", text::MapJogDrive.words()),
        ("nozzle", 1, "uint16", "", text::MapJogDrive.words()),
    ]
}

fn jog() -> [Column; 6] {
    [
        ("sequence", 1, "uint16", "", text::MapNewSequence.words()),
        ("session", 2, "uint32", "", text::MapOwnSession.words()),
        ("monitor", 1, "uint16", "", text::MapOfUnit.words()),
        ("horizontal", 1, "int16", "", text::MapDirection.words()),
        ("vertical", 1, "int16", "", text::MapDirection.words()),
        ("nozzle", 1, "int16", "", text::MapDirection.words()),
    ]
}

fn command() -> [Column; 9] {
    [
        ("sequence", 1, "uint16", "", text::MapNewSequence.words()),
        ("session", 2, "uint32", "", text::MapOwnSession.words()),
        ("command", 1, "uint16", "", text::MapCommand.words()),
        ("monitor", 1, "uint16", "", text::MapOfUnit.words()),
        ("argument1", 1, "uint16", "", text::MapArgument1.words()),
        ("argument2", 1, "int16", "0.1°", text::MapArgument2.words()),
        ("argument3", 1, "int16", "0.1°", text::MapArgument3.words()),
        ("argument4", 1, "int16", "mm", text::MapArgument4.words()),
        ("key", 4, "uint64", "", text::MapWrittenKey.words()),
    ]
}

/// The status words, bit by bit as the dictionary has them.
fn detail(rows: &mut Vec<Row>, unit: u8, id: &str, at: u16) {
    let row = |address, bit, name: String, words, kind, measure, text| {
        let name = format!("{id}.detail.{name}");
        Row { unit, address, bit, name, words, written: false, kind, measure, text }
    };
    let quality = text::MapQuality.words();
    rows.push(row(at, None, "quality".into(), 1, "bits", "", quality));
    rows.push(row(at + 1, None, "age".into(), 1, "uint16", "ms", text::MapAge.words()));
    for (number, subsystem) in (0..).zip(DETAILED) {
        let address = at + 2 + 2 * number;
        let name = subsystem.to_string();
        let what = text::MapStatusWord { subsystem: &name }.words();
        rows.push(row(address, None, name.clone(), 2, "bits", "", what));
        for flag in flags_of(subsystem).flags {
            // The high word comes first.
            let (address, bit) = match flag.shift {
                16.. => (address, u32::from(flag.shift) - 16),
                low => (address + 1, u32::from(low)),
            };
            let name = format!("{name}.{}", flag.name);
            let meaning = dictionary(flag.meaning).words();
            rows.push(row(address, Some(bit), name, 1, "bits", "", meaning));
        }
    }
}

/// The version of a unit's map: it changes with every address, name and meaning.
pub fn version(unit: u8, monitors: &[String]) -> u32 {
    let mut hash = Sha256::new();
    for row in rows(unit, monitors) {
        hash.update(csv_line(&row));
    }
    for (number, text) in commands().into_iter().chain(refusals()) {
        hash.update(format!("{number},{}\n", text.en));
    }
    let hash: [u8; 32] = hash.finalize().into();
    let [a, b, c, d, ..] = hash;
    // Zero is what a device has that was not read yet.
    u32::from_be_bytes([a, b, c, d]).max(1)
}

/// The commands by number.
pub fn commands() -> Vec<(u16, Both)> {
    let one = |command: Command| {
        let text = match command {
            Command::Take => text::CommandTake.words(),
            Command::Release => text::CommandRelease.words(),
            Command::Ask => text::CommandAsk.words(),
            Command::GoTo => text::CommandGoTo.words(),
            Command::Open => text::CommandOpen.words(),
            Command::Close => text::CommandClose.words(),
            Command::Stop => text::CommandStop.words(),
            Command::Lockout => text::CommandLockout.words(),
            Command::Deploy => text::CommandDeploy.words(),
            Command::Stow => text::CommandStow.words(),
        };
        (command.number(), text)
    };
    Command::ALL.into_iter().map(one).collect()
}

/// The refusals by number.
pub fn refusals() -> Vec<(u16, Both)> {
    Refusal::ALL.iter().map(|it| (it.number(), it.text())).collect()
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

fn csv_line(row: &Row) -> String {
    let bit = row.bit.map(|bit| bit.to_string()).unwrap_or_default();
    let access = if row.written { "write" } else { "read" };
    let Row { unit, address, name, words, kind, measure, text, .. } = row;
    let (en, ru) = (quoted(&text.en), quoted(&text.ru));
    format!("{unit},{address},{bit},{name},{words},{access},{kind},{measure},{en},{ru}\n")
}

/// The map of a server as CSV.
pub fn csv(server: &ServerConfig) -> String {
    let mut out = String::from("unit,address,bit,name,words,access,type,measure,en,ru\n");
    for (unit, monitors) in server.units() {
        rows(unit, monitors).iter().for_each(|row| out += &csv_line(row));
    }
    for (number, text) in commands() {
        let (en, ru) = (quoted(&text.en), quoted(&text.ru));
        out += &format!(",,,command {number},,,value,,{en},{ru}\n");
    }
    for (number, text) in refusals() {
        let (en, ru) = (quoted(&text.en), quoted(&text.ru));
        out += &format!(",,,refusal {number},,,value,,{en},{ru}\n");
    }
    out
}

/// The map of a server as Markdown, in a language. The bits of status words are left out: the dictionary
/// has them, and the CSV.
pub fn markdown(server: &ServerConfig, lang: Lang) -> String {
    let mut out = String::new();
    for (unit, monitors) in server.units() {
        let version = format!("0x{:08x}", version(unit, monitors));
        out += &format!("## {}\n\n", text::MapUnit { unit, version }.of(lang));
        out += &table(&text::MapColumns.of(lang));
        for row in rows(unit, monitors).iter().filter(|row| row.bit.is_none()) {
            let last = row.address + row.words - 1;
            let place = match row.words {
                1 => row.address.to_string(),
                _ => format!("{}–{last}", row.address),
            };
            let access = if row.written { "W" } else { "R" };
            let Row { name, kind, measure, .. } = row;
            let text = row.text.of(lang);
            out += &format!("| {place} | `{name}` | {access} | {kind} | {measure} | {text} |\n");
        }
        out.push('\n');
    }
    for (title, list) in
        [(text::MapCommands.of(lang), commands()), (text::MapRefusals.of(lang), refusals())]
    {
        out += &format!("## {title}\n\n{}", table(&text::MapNumbers.of(lang)));
        for (number, text) in list {
            out += &format!("| {number} | {} |\n", text.of(lang));
        }
        out.push('\n');
    }
    out.trim_end().to_owned() + "\n"
}

/// The head of a table with these columns.
fn table(columns: &str) -> String {
    let count = columns.matches('|').count() + 1;
    format!("| {columns} |\n|{}\n", "---|".repeat(count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plugs::modbus::layout::{END, HEADER_LEN, MONITORS};

    fn ids(count: usize) -> Vec<String> {
        (1..=count).map(|number| format!("M{number}")).collect()
    }

    #[test]
    fn every_register_has_one_name_and_blocks_are_filled() {
        let rows = rows(1, &ids(MONITORS));
        let mut next = 0;
        for row in rows.iter().filter(|row| row.bit.is_none()) {
            assert!(row.address >= next, "{row:?} overlaps");
            next = row.address + row.words;
        }
        assert_eq!(next, END);
        let upto = |end: u16| {
            let of = rows.iter().filter(|row| row.bit.is_none() && row.address < end);
            of.map(|row| usize::from(row.words)).sum::<usize>()
        };
        assert_eq!(upto(125), HEADER_LEN + MONITORS * SUMMARY_LEN, "one reading without a gap");
        let names: std::collections::BTreeSet<&str> =
            rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names.len(), rows.len());
        let bit = rows.iter().find(|it| it.name == "M1.detail.Valve1.Open").unwrap();
        assert_eq!((bit.address, bit.bit), (DETAIL + 2 + 8, Some(6)));
    }

    #[test]
    fn the_version_is_that_of_the_map() {
        let own = version(1, &ids(2));
        assert_eq!(own, version(1, &ids(2)));
        let others =
            [version(2, &ids(2)), version(1, &ids(3)), version(1, &["M1".into(), "M3".into()])];
        assert!(!others.contains(&own) && own != 0);
    }
}
