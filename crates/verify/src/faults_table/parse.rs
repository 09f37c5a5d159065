//! Reads `conformance/faults.txt`.

use lafet_proto::flags::{ButtonState, FlagInfo, flags_of};
use lafet_proto::{Status, SubsystemId};
use lafet_sim::fault::Fault;
use lafet_sim::scenario::{Failure, Scenario, duration};
use lafet_texts::{Lang, Words};

use super::{Block, Row, Subject, TOLD_MS, Table};

pub(super) fn table(file: &str, text: &str) -> Result<Table, Failure> {
    let mut table = Table { blocks: Vec::new(), lets: Vec::new(), rows: Vec::new() };
    let mut section = String::new();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        let failed = |expected: String| failure(file, number, expected, line);
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match (word, table.blocks.last_mut()) {
            ("section", _) => rest.clone_into(&mut section),
            ("let", _) => table.lets.push(variable(rest).map_err(failed)?),
            ("flag" | "status", _) => {
                let block = if word == "flag" { flags(rest) } else { status(rest) };
                let block = block.map_err(failed)?;
                table.blocks.push(Block { line: number, section: section.clone(), ..block });
            }
            (_, None) => return Err(failed("let, section, flag or status".to_owned())),
            (_, Some(block)) => body(block, number, line, word, rest).map_err(failed)?,
        }
    }
    for (index, block) in table.blocks.iter().enumerate() {
        check(block).map_err(|expected| failure(file, block.line, expected, &title(block)))?;
        for subject in subjects(block).map_err(|e| failure(file, block.line, e, &title(block)))? {
            let case = match block.never.is_empty() {
                false => None,
                true => Some(case(file, &table, block, subject)?),
            };
            let faults = faults(file, &table, block, subject)?;
            table.rows.push(Row { subject, block: index, case, faults });
        }
    }
    Ok(table)
}

/// The flags of a block, or its status.
pub(super) fn title(block: &Block) -> String {
    match block.status {
        Some(status) => status.name().unwrap_or("?").to_owned(),
        None => block.flags.join(" "),
    }
}

fn failure(file: &str, line: usize, expected: String, came: &str) -> Failure {
    let (expected, came) = (Words::same(expected), Words::same(format!("`{came}`")));
    Failure {
        file: file.to_owned(),
        line,
        expected: expected.into(),
        came: came.into(),
        tail: Vec::new(),
    }
}

fn variable(rest: &str) -> Result<(String, Vec<(String, String)>), String> {
    let (name, values) = rest.split_once(' ').ok_or("`let NAME KEY=VALUE …`")?;
    let pair = |word: &str| {
        let (key, value) = word.split_once('=').ok_or("KEY=VALUE")?;
        Ok((key.to_owned(), value.to_owned()))
    };
    let values: Result<Vec<_>, String> = values.split_whitespace().map(pair).collect();
    Ok((name.to_owned(), values?))
}

fn flags(rest: &str) -> Result<Block, String> {
    let (flags, of) = rest.split_once(" of ").ok_or("`flag NAME … of SUBSYSTEM …`")?;
    let (flags, state) = match flags.split_once('=') {
        Some((flags, state)) => (flags, Some(button_state(state.trim())?)),
        None => (flags, None),
    };
    let subsystem = |name: &str| {
        SubsystemId::from_name(name)
            .filter(|id| SubsystemId::TABLE.contains(id))
            .ok_or(format!("a subsystem, not `{name}`"))
    };
    let of: Vec<SubsystemId> = of.split_whitespace().map(subsystem).collect::<Result<_, _>>()?;
    let first = *of.first().ok_or("a subsystem")?;
    let name = |name: &str| flag(first, name).map(|flag| flag.name);
    let flags = flags.split_whitespace().map(name).collect::<Result<_, _>>()?;
    Ok(Block { flags, state, of, ..Block::default() })
}

fn button_state(name: &str) -> Result<ButtonState, String> {
    Ok(match name {
        "Released" => ButtonState::Released,
        "Pressed" => ButtonState::Pressed,
        "Short" => ButtonState::Short,
        "Open" => ButtonState::Open,
        _ => return Err("Released, Pressed, Short or Open".to_owned()),
    })
}

fn flag(id: SubsystemId, name: &str) -> Result<&'static FlagInfo, String> {
    let found = flags_of(id).flags.iter().find(|flag| flag.name == name);
    found.ok_or(format!("a flag of {}, not `{name}`", id.name().unwrap_or("?")))
}

fn status(rest: &str) -> Result<Block, String> {
    let known = Status::KNOWN.iter().find(|(_, name)| *name == rest);
    let (status, _) = known.ok_or("the name of a status")?;
    Ok(Block { status: Some(*status), ..Block::default() })
}

fn body(
    block: &mut Block,
    number: usize,
    line: &str,
    word: &str,
    rest: &str,
) -> Result<(), String> {
    let join = |text: &mut String| {
        if !text.is_empty() {
            text.push(' ');
        }
        text.push_str(rest);
    };
    match word {
        "because" => join(&mut block.because),
        "never" if block.lines.is_empty() && block.trigger.is_empty() => join(&mut block.never),
        "then" if block.trigger.is_empty() => block.trigger.push((number, rest.to_owned())),
        "<" if !block.trigger.is_empty() => block.trigger.push((number, line.to_owned())),
        "within" if block.within.is_none() => {
            let ms = duration(rest).map_err(|error| error.of(Lang::En).to_owned())?;
            block.within = Some((number, ms));
        }
        "never" => return Err("`never` alone".to_owned()),
        "then" | "within" => return Err(format!("one `{word}` in a block")),
        _ if block.trigger.is_empty() => block.lines.push((number, line.to_owned())),
        _ => return Err("`within` after `then`".to_owned()),
    }
    Ok(())
}

/// A block is either complete, with the way to reach it, or `never`, with a reason.
fn check(block: &Block) -> Result<(), String> {
    if !block.never.is_empty() {
        let empty = block.lines.is_empty() && block.trigger.is_empty() && block.within.is_none();
        return if empty { Ok(()) } else { Err("`never` alone".to_owned()) };
    }
    if block.trigger.is_empty() {
        return Err("a `then` line, or `never REASON`".to_owned());
    }
    match (block.status, block.within) {
        (Some(status), None) => {
            let answer = format!("→ {}", status.name().unwrap_or("?"));
            let names = |line: &str| {
                line.starts_with('<')
                    && line.split_once(&answer).is_some_and(|(_, rest)| {
                        !rest.starts_with(|next: char| next.is_ascii_alphabetic())
                    })
            };
            let answered = block.trigger.iter().any(|(_, line)| names(line));
            if answered { Ok(()) } else { Err(format!("`then > REQUEST` and `< … {answer}`")) }
        }
        (Some(_), Some(_)) => Err("no `within`: a status comes with its answer".to_owned()),
        (None, None) => Err("a `within` line".to_owned()),
        (None, Some((_, ms))) if ms > TOLD_MS && block.because.is_empty() => {
            Err("`because REASON`: it takes longer than a second".to_owned())
        }
        (None, Some(_)) => Ok(()),
    }
}

fn subjects(block: &Block) -> Result<Vec<Subject>, String> {
    if let Some(status) = block.status {
        return Ok(vec![Subject::Status(status)]);
    }
    let mut subjects = Vec::new();
    for id in &block.of {
        for name in &block.flags {
            let flag = flag(*id, name)?;
            subjects.push(match (block.state, flag.width) {
                (Some(state), 2) => Subject::Button(*id, flag, state),
                (None, 1) => Subject::Flag(*id, flag),
                _ => return Err("`= STATE` for a button, and for it alone".to_owned()),
            });
        }
    }
    Ok(subjects)
}

/// The scenario of a row: not set, then brought about, then set in time; and what this subsystem
/// never sets is not set either.
/// What a row injects, in its preparation or at its end.
fn faults(
    file: &str,
    table: &Table,
    block: &Block,
    subject: Subject,
) -> Result<Vec<Fault>, Failure> {
    let mut faults = Vec::new();
    for (number, line) in block.lines.iter().chain(&block.trigger) {
        let line = fill(table, line, subject);
        let Some(name) = line.strip_prefix("inject ") else { continue };
        let fault = Fault::from_name(name.trim());
        let unknown = || failure(file, *number, "the name of a fault".to_owned(), name);
        faults.push(fault.ok_or_else(unknown)?);
    }
    Ok(faults)
}

fn case(file: &str, table: &Table, block: &Block, subject: Subject) -> Result<Scenario, Failure> {
    let filled = |line: &str| fill(table, line, subject);
    let mut lines = vec![(block.line, format!("case {subject}"))];
    lines.extend(block.lines.iter().map(|(number, line)| (*number, filled(line))));
    let trigger = block.trigger.iter().map(|(number, line)| (*number, filled(line)));
    if let Some((id, flag)) = flag_of(subject) {
        let id = id.name().unwrap_or("?");
        // Released is what is left when none of the others is reported.
        let (before, after, name) = match subject {
            Subject::Button(_, _, ButtonState::Released) => ("has", "lacks", flag.name.to_owned()),
            Subject::Button(_, _, state) => ("lacks", "has", format!("{}={state:?}", flag.name)),
            _ => ("lacks", "has", flag.name.to_owned()),
        };
        let at = block.trigger.first().map_or(block.line, |(number, _)| *number);
        lines.push((at, format!("expect {id} flags {before} {name}")));
        lines.extend(trigger);
        let (number, ms) = block.within.unwrap_or((block.line, TOLD_MS));
        lines.push((number, format!("until {id} flags {after} {name} within {ms}ms")));
        let never = never_set(table, subject);
        if !never.is_empty() {
            lines.push((number, format!("expect {id} flags lacks {never}")));
        }
    } else {
        lines.extend(trigger);
    }
    Scenario::from_lines(file, lines.iter().map(|(number, line)| (*number, line.as_str())))
}

const fn flag_of(subject: Subject) -> Option<(SubsystemId, &'static FlagInfo)> {
    match subject {
        Subject::Flag(id, flag) | Subject::Button(id, flag, _) => Some((id, flag)),
        Subject::Status(_) => None,
    }
}

/// The flags that no block reaches for this subsystem.
fn never_set(table: &Table, subject: Subject) -> String {
    let Some((id, _)) = flag_of(subject) else { return String::new() };
    let never =
        table.blocks.iter().filter(|block| !block.never.is_empty() && block.of.contains(&id));
    never.flat_map(|block| block.flags.clone()).collect::<Vec<_>>().join(" ")
}

pub(super) fn fill(table: &Table, line: &str, subject: Subject) -> String {
    let mut line = line.to_owned();
    let Some((id, flag)) = flag_of(subject) else { return line };
    let name = id.name().unwrap_or("?");
    for (variable, values) in &table.lets {
        let value = values.iter().find(|(key, _)| key == name || key == flag.name);
        if let Some((_, value)) = value {
            line = line.replace(&format!("{{{variable}}}"), value);
        }
    }
    line.replace("{Subsystem}", name)
        .replace("{subsystem}", &name.to_lowercase())
        .replace("{Flag}", flag.name)
}
