//! The table as a page: what `cargo xtask faults` prints and writes into docs/faults.md.

use core::fmt::Write;

use lafet_proto::flags::Severity;

use super::parse::title;
use super::{Block, Measured, Row, TOLD_MS, Table};

/// Times are rounded up to this, ms: a table of what a user waits for, not of the last cycle.
const ROUNDED_MS: u64 = 50;

/// The table in Markdown.
pub fn page(measured: &Measured<'_>) -> String {
    let Measured { table, rows: measured } = measured;
    let mut text = summary(table, measured);
    let mut section = "";
    for (index, block) in table.blocks.iter().enumerate() {
        if block.section != section {
            section = &block.section;
            let _ = write!(text, "\n### {section}\n\n{}", head(block));
        }
        let mut rows = measured.iter().filter(|(row, _)| row.block == index).peekable();
        let severities = severities(rows.clone().map(|(row, _)| *row));
        let many = rows.clone().count() > 1;
        let subject = rows.peek().map(|(row, _)| row.subject);
        let how = how(block, |line| match subject {
            Some(subject) if !many => super::parse::fill(table, line, subject),
            _ => line.to_owned(),
        });
        let time = rows.filter_map(|(_, time)| *time).max().map_or("never".to_owned(), shown);
        let _ = match block.status {
            Some(_) => writeln!(text, "| `{}` | {how} |", title(block)),
            None => writeln!(
                text,
                "| {} | {} | {severities} | {how} | {time} |",
                names(block),
                of(block)
            ),
        };
    }
    let _ = write!(text, "\n{}", placeholders(table));
    text
}

fn summary(table: &Table, measured: &[(&Row, Option<u64>)]) -> String {
    let is_fault = |row: &Row| row.subject.severity() >= Some(Severity::Warning);
    let reached: Vec<_> = measured.iter().filter_map(|(row, ms)| Some((*row, (*ms)?))).collect();
    let faults = || reached.iter().filter(|(row, _)| is_fault(row));
    let late = faults().filter(|(_, ms)| *ms > TOLD_MS).count();
    let slowest = faults().map(|(_, ms)| *ms).filter(|ms| *ms <= TOLD_MS).max().unwrap_or(0);
    format!(
        "{} rows, {} holes: {} reached, {} never set, by decision. {} of those reached are warnings \
         and alarms: {} of them are told within {}, {late} later, for the reason given.\n",
        measured.len(),
        table.holes().len(),
        reached.len(),
        measured.len() - reached.len(),
        faults().count(),
        faults().count() - late,
        shown(slowest)
    )
}

fn head(block: &Block) -> &'static str {
    match block.status {
        Some(_) => "| status | how |\n| --- | --- |\n",
        None => {
            "| flag | subsystem | severity | how | shows within |\n| --- | --- | --- | --- | --- |\n"
        }
    }
}

fn severities<'a>(rows: impl Iterator<Item = &'a Row>) -> String {
    let mut words: Vec<String> = Vec::new();
    for severity in rows.filter_map(|row| row.subject.severity()) {
        let word = format!("{severity:?}").to_lowercase();
        if !words.contains(&word) {
            words.push(word);
        }
    }
    words.join(", ")
}

fn names(block: &Block) -> String {
    let state = block.state.map(|state| format!("={state:?}")).unwrap_or_default();
    let names: Vec<String> = block.flags.iter().map(|name| format!("`{name}{state}`")).collect();
    names.join(", ")
}

fn of(block: &Block) -> String {
    let names: Vec<&str> = block.of.iter().filter_map(|id| id.name()).collect();
    names.join(", ")
}

fn how(block: &Block, fill: impl Fn(&str) -> String) -> String {
    if !block.never.is_empty() {
        return block.never.replace('|', "\\|");
    }
    let code = |line: &str| format!("`{}`", fill(line).replace('|', "\\|"));
    let mut parts: Vec<String> = block.lines.iter().map(|(_, line)| code(line)).collect();
    for (index, (_, line)) in block.trigger.iter().enumerate() {
        parts.push(if index == 0 { format!("**{}**", code(line)) } else { code(line) });
    }
    let why = match block.because.as_str() {
        "" => String::new(),
        because => format!(" — {because}"),
    };
    parts.join("; ") + &why
}

pub(super) fn shown(ms: u64) -> String {
    match ms.div_ceil(ROUNDED_MS) * ROUNDED_MS {
        0 => "at once".to_owned(),
        ms => format!("{}.{:02} s", ms / 1000, ms % 1000 / 10),
    }
}

/// Placeholders in rows of several subsystems, and their values.
fn placeholders(table: &Table) -> String {
    let mut text =
        "### Placeholders\n\n- `{Subsystem}` is the subsystem of the row, `{subsystem}` for its name in \
                    small letters, `{Flag}` for its flag.\n"
            .to_owned();
    for (name, values) in &table.lets {
        let values: Vec<String> =
            values.iter().map(|(key, value)| format!("{key} {value}")).collect();
        let _ = writeln!(text, "- `{{{name}}}`: {}.", values.join(", "));
    }
    text
}
