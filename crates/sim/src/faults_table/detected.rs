//! The faults of the table as a page of the safety manual: by kind of fault, what reports it and how soon.

use core::fmt::Write;
use std::collections::BTreeMap;

use lafet_proto::dictionary::Text;
use lafet_proto::flags::Severity;

use super::page::shown;
use super::{Measured, Row};
use crate::fault::Fault;

const HEAD: Text = Text::new(
    "| fault | reported by | severity | longest time | rows |\n| --- | --- | --- | --- | --- |\n",
    "| неисправность | чем сообщается | важность | наибольшее время | строк |\n\
     | --- | --- | --- | --- | --- |\n",
);
const WITHOUT_ROW: Text = Text::new(
    "Faults of the simulator that no row of a flag injects:",
    "Неисправности имитатора, которых нет ни в одной строке с флагом:",
);
const AT_ONCE: Text = Text::new("at once", "сразу");
const SECONDS: [Text; 2] = [Text::new(".", ","), Text::new(" s", " с")];

/// What is known of a kind of fault.
#[derive(Default)]
struct Kind {
    flags: Vec<String>,
    severity: Option<Severity>,
    /// The longest time until a flag of it shows, ms.
    ms: u64,
    rows: usize,
}

/// Kinds of faults in Markdown, with the flags that report each, the greatest severity, and the longest time of all
/// rows; then the kinds that no row of a flag injects. `pick` chooses the language.
pub fn detected(measured: &Measured<'_>, pick: fn(Text) -> &'static str) -> String {
    let mut kinds: BTreeMap<String, Kind> = BTreeMap::new();
    for (row, ms) in &measured.rows {
        let (Some(ms), Some(_)) = (*ms, row.subject.severity()) else { continue };
        for fault in &row.faults {
            kinds.entry(kind_of(*fault)).or_default().add(row, ms);
        }
    }
    let mut text = pick(HEAD).to_owned();
    for (name, kind) in &kinds {
        let flags: Vec<String> = kind.flags.iter().map(|flag| format!("`{flag}`")).collect();
        let _ = writeln!(
            text,
            "| `{name}` | {} | {} | {} | {} |",
            flags.join(", "),
            kind.severity.map_or("", |severity| pick(severity.text())),
            time(kind.ms, pick),
            kind.rows
        );
    }
    let mut silent: Vec<String> =
        Fault::all().map(kind_of).filter(|kind| !kinds.contains_key(kind)).collect();
    silent.sort();
    silent.dedup();
    if !silent.is_empty() {
        let silent: Vec<String> = silent.iter().map(|name| format!("`{name}`")).collect();
        let _ = writeln!(text, "\n{} {}.", pick(WITHOUT_ROW), silent.join(", "));
    }
    text
}

impl Kind {
    fn add(&mut self, row: &Row, ms: u64) {
        let flag = row.subject.flag_name();
        if !self.flags.contains(&flag) {
            self.flags.push(flag);
        }
        self.severity = self.severity.max(row.subject.severity());
        self.ms = self.ms.max(ms);
        self.rows += 1;
    }
}

/// The name of a fault without which of several parts it is.
fn kind_of(fault: Fault) -> String {
    match fault {
        Fault::Drive(_, fault) => format!("DRIVE-{}", fault.name()),
        Fault::Valve(_, fault) => format!("VALVE-{}", fault.name()),
        Fault::Temperature(_) => "PLACE-temperature".to_owned(),
        Fault::TemperatureFrozen(_) => "PLACE-temperature-frozen".to_owned(),
        Fault::TemperatureDrift(_) => "PLACE-temperature-drift".to_owned(),
        Fault::Heater(_) => "PLACE-heater".to_owned(),
        Fault::Unit(_, fault) => format!("PART-unit-{}", fault.name()),
        Fault::Button(_, _, fault) => format!("POST-BUTTON-{}", fault.name()),
        Fault::Single(fault) => fault.name().to_owned(),
    }
}

fn time(ms: u64, pick: fn(Text) -> &'static str) -> String {
    let [point, unit] = SECONDS.map(pick);
    match ms {
        0 => pick(AT_ONCE).to_owned(),
        ms => shown(ms).replace('.', point).replace(" s", unit),
    }
}
