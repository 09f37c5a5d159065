//! The faults of the table as a page of the safety manual: by kind of fault, what reports it and how soon.

use core::fmt::Write;
use std::collections::BTreeMap;

use lafet_proto::flags::Severity;
use lafet_sim::fault::Fault;
use lafet_texts::{Lang, Text as _, verify as text};

use super::page::shown;
use super::{Measured, Row};

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
/// rows; then the kinds that no row of a flag injects.
pub fn detected(measured: &Measured<'_>, lang: Lang) -> String {
    let mut kinds: BTreeMap<String, Kind> = BTreeMap::new();
    for (row, ms) in &measured.rows {
        let (Some(ms), Some(_)) = (*ms, row.subject.severity()) else { continue };
        for fault in &row.faults {
            kinds.entry(kind_of(*fault)).or_default().add(row, ms);
        }
    }
    let mut page = format!("{}\n", text::DetectedHead.str(lang));
    for (name, kind) in &kinds {
        let flags: Vec<String> = kind.flags.iter().map(|flag| format!("`{flag}`")).collect();
        let _ = writeln!(
            page,
            "| `{name}` | {} | {} | {} | {} |",
            flags.join(", "),
            kind.severity.map_or("", |severity| lafet_texts::dictionary(severity.text()).str(lang)),
            time(kind.ms, lang),
            kind.rows
        );
    }
    let mut silent: Vec<String> =
        Fault::all().map(kind_of).filter(|kind| !kinds.contains_key(kind)).collect();
    silent.sort();
    silent.dedup();
    if !silent.is_empty() {
        let silent: Vec<String> = silent.iter().map(|name| format!("`{name}`")).collect();
        let _ = writeln!(page, "\n{} {}.", text::DetectedWithoutRow.str(lang), silent.join(", "));
    }
    page
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

fn time(ms: u64, lang: Lang) -> String {
    let (point, unit) = (lafet_texts::decimal_mark(lang), text::SecondsBehindBlank.str(lang));
    match ms {
        0 => text::AtOnce.of(lang),
        ms => shown(ms).replace('.', point).replace(" s", unit),
    }
}
