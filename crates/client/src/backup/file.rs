//! The backup file: TOML with a table for each subsystem, units in comments.

use std::fmt::{self, Write};

use lafet_proto::param::{MAX_VALUES, Param, ParamSpec};
use lafet_proto::{Status, SubsystemId};
use lafet_texts::{Argument, Lang, Text, Words, client as text};
use toml::de::DeTable;
use toml::{Table, Value};

use super::{About, Backup, is_kept, title};

/// Version of the file format.
const FORMAT: i64 = 2;
/// The version without [`END`].
const ENDLESS: i64 = 1;
/// The last line. A file that lacks it was cut, which its values do not show: `4500` is cut to `45`.
const END: &str = "# end";
/// The table that describes the monitor and the origin of the file.
const ABOUT: &str = "monitor";

/// Error in a backup file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileError {
    /// Not valid TOML.
    Syntax {
        /// Line of the error, from 1.
        line: usize,
        /// What is wrong there.
        what: Words,
    },
    /// Another kind of TOML file, or a later version of the format.
    Format,
    /// Its last line is missing: only a part of it is there.
    Cut,
    /// A table or a name that the dictionary does not have.
    Unknown {
        /// Its line, from 1.
        line: usize,
        /// The name in the file.
        name: String,
    },
    /// Values that are not whole numbers, too many or too few of them, or out of range.
    Value {
        /// Its line, from 1.
        line: usize,
        /// The parameter.
        param: Param,
        /// The status that a monitor would answer to these values.
        status: Status,
    },
    /// The parameter cannot be set.
    ReadOnly {
        /// Its line, from 1.
        line: usize,
        /// The parameter.
        param: Param,
    },
}

impl FileError {
    /// The message in a language.
    pub fn localized(&self, lang: Lang) -> String {
        self.of(lang)
    }
}

impl Argument for FileError {
    fn write(&self, lang: Lang, out: &mut dyn Write) -> fmt::Result {
        match self {
            Self::Syntax { line, what } => text::FileNoToml { line: *line, what }.write(lang, out),
            Self::Format => text::FileFormat { format: FORMAT }.write(lang, out),
            Self::Cut => text::FileCut { end: END }.write(lang, out),
            Self::Unknown { line, name } => {
                text::FileUnknown { line: *line, name }.write(lang, out)
            }
            Self::Value { line, param, status: Status::WRONG_DATA } => {
                let ParamSpec { min_len: min, max_len: max, .. } = param.spec();
                text::FileCount { line: *line, title: title(*param), min, max }.write(lang, out)
            }
            Self::Value { line, param, .. } => {
                let (title, allowed) = (title(*param), allowed(param.spec()));
                text::FileRange { line: *line, title, allowed }.write(lang, out)
            }
            Self::ReadOnly { line, param } => {
                text::FileReadOnly { line: *line, title: title(*param) }.write(lang, out)
            }
        }
    }
}

impl Text for FileError {}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Argument::write(self, Lang::En, f)
    }
}

impl std::error::Error for FileError {}

impl Backup {
    /// The text of the file.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) -> fmt::Result {
        let About { url, subsystems, profile, firmware, made_by } = &self.about;
        writeln!(
            text,
            "# Parameters of a fire monitor: `lafet param restore FILE` writes them back."
        )?;
        writeln!(
            text,
            "# Units and ranges follow the values; parameters that are left out are not changed."
        )?;
        writeln!(text, "format = {FORMAT}\n\n[{ABOUT}]")?;
        writeln!(text, "url = {}", quoted(url))?;
        let names: Vec<String> = subsystems.iter().map(|name| quoted(name)).collect();
        writeln!(text, "subsystems = [{}]", names.join(", "))?;
        if let Some(profile) = profile {
            writeln!(text, "profile = {}", quoted(profile))?;
        }
        if let Some(firmware) = firmware {
            writeln!(text, "firmware = {}", quoted(firmware))?;
        }
        writeln!(text, "made_by = {}", quoted(made_by))?;
        for who in SubsystemId::TABLE {
            let of = |param: &Param| param.spec().subsystem == who;
            let values: Vec<_> = self.values.iter().filter(|(param, _)| of(param)).collect();
            let unread: Vec<_> = self.unread.iter().filter(|(param, _)| of(param)).collect();
            if values.is_empty() && unread.is_empty() {
                continue;
            }
            writeln!(text, "\n[{who}]")?;
            for (param, values) in values {
                let numbers: Vec<String> = values.iter().map(i32::to_string).collect();
                let spec = param.spec();
                let numbers = match (numbers.as_slice(), spec.max_len) {
                    ([one], 1) => one.clone(),
                    (all, _) => format!("[{}]", all.join(", ")),
                };
                writeln!(text, "{} = {numbers}  # {}", param.name(), allowed(spec))?;
            }
            for (param, why) in unread {
                writeln!(text, "# {}: not set ({why})", param.name())?;
            }
        }
        writeln!(text, "\n{END}")
    }

    /// Whether a file has the line that ends it. One of the first version has none: whether it is whole,
    /// nothing shows.
    pub fn has_end(text: &str) -> bool {
        text.trim_end().lines().next_back() == Some(END)
    }

    /// Reads a file. Each of its parameters must be in the dictionary, with values in range.
    /// Parameters that are left out are not changed by a restore. See [`Backup::has_end`].
    ///
    /// # Errors
    ///
    /// [`FileError`] for the first error in the text.
    pub fn from_toml(text: &str) -> Result<Self, FileError> {
        let file: Table = text.parse().map_err(|error: toml::de::Error| {
            let line = line_at(text, error.span().map_or(0, |span| span.start));
            FileError::Syntax { line, what: lafet_texts::toml::said(error.message()) }
        })?;
        match file.get("format").and_then(Value::as_integer) {
            Some(ENDLESS) => {}
            Some(FORMAT) if Self::has_end(text) => {}
            Some(FORMAT) => return Err(FileError::Cut),
            _ => return Err(FileError::Format),
        }
        let mut backup = Self { about: about(file.get(ABOUT)), ..Self::default() };
        for (name, table) in &file {
            if matches!(name.as_str(), "format" | ABOUT) {
                continue;
            }
            let line = |key: Option<&str>| line_of(text, name, key);
            let unknown = |line, name: String| FileError::Unknown { line, name };
            let who = SubsystemId::TABLE.into_iter().find(|who| who.name() == Some(name.as_str()));
            let (Some(who), Some(table)) = (who, table.as_table()) else {
                return Err(unknown(line(None), name.clone()));
            };
            for (key, value) in table {
                let param = Param::by_name(who, key);
                let line = || line(Some(key));
                let param = param.ok_or_else(|| unknown(line(), format!("{name}.{key}")))?;
                backup.values.push((param, values(param, value, &line)?));
            }
        }
        backup.values.sort_by_key(|(param, _)| *param);
        Ok(backup)
    }
}

fn about(table: Option<&Value>) -> About {
    let word = |key: &str| Some(table?.get(key)?.as_str()?.to_owned());
    let list = || Some(table?.get("subsystems")?.as_array()?.clone());
    let names = list().unwrap_or_default();
    About {
        url: word("url").unwrap_or_default(),
        subsystems: names.iter().filter_map(|name| Some(name.as_str()?.to_owned())).collect(),
        profile: word("profile"),
        firmware: word("firmware"),
        made_by: word("made_by").unwrap_or_default(),
    }
}

fn line_at(text: &str, at: usize) -> usize {
    1 + text.get(..at).unwrap_or_default().matches('\n').count()
}

/// Line of a table, or of a key in it.
fn line_of(text: &str, table: &str, key: Option<&str>) -> usize {
    let Ok(file) = DeTable::parse(text) else { return 1 };
    let Some((name, value)) = file.get_ref().get_key_value(table) else { return 1 };
    let within = key.and_then(|key| value.get_ref().as_table()?.get_key_value(key));
    line_at(text, within.map_or(name, |(key, _)| key).span().start)
}

fn values(param: Param, value: &Value, line: &dyn Fn() -> usize) -> Result<Vec<i32>, FileError> {
    if !is_kept(param) {
        return Err(FileError::ReadOnly { line: line(), param });
    }
    let wrong = |status| FileError::Value { line: line(), param, status };
    let one = |value: &Value| {
        let number = value.as_integer().ok_or_else(|| wrong(Status::WRONG_DATA))?;
        i32::try_from(number).map_err(|_| wrong(Status::INVALID_VALUE))
    };
    let values = match value {
        Value::Array(all) if all.len() <= MAX_VALUES => all.iter().map(one).collect(),
        one_value => one(one_value).map(|value| vec![value]),
    }?;
    param.spec().check(values.iter().copied()).map_err(wrong)?;
    Ok(values)
}

/// Range and unit as text: `-900…4500 '`.
fn allowed(spec: &ParamSpec) -> String {
    let one = |min: i32, max: i32, unit: &str| format!("{min}…{max} {unit}").trim_end().to_owned();
    match spec.elements {
        [] => one(spec.min, spec.max, spec.unit.symbol()),
        elements => {
            let all = elements.iter().map(|e| one(e.min, e.max, e.unit.symbol()));
            all.collect::<Vec<_>>().join(", ")
        }
    }
}

fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            c if c.is_control() => quoted.push(' '),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_and_read_again_it_is_the_same() {
        let backup = Backup {
            about: About {
                url: r#"serial:C:\"x""#.into(),
                subsystems: vec!["General".into(), "Vertical".into()],
                profile: Some("full".into()),
                firmware: None,
                made_by: "lafet".into(),
            },
            values: vec![
                (Param::GeneralAddress, vec![5]),
                (Param::VerticalMinLimit, vec![-900]),
                (Param::ControlProgram3, vec![1800, -120, 60, 360, 120, 1, 25]),
                (Param::ControlTrajectory0, vec![]),
            ],
            unread: vec![],
            missed: vec![],
        };
        let text = backup.to_toml();
        assert_eq!(Backup::from_toml(&text).as_ref(), Ok(&backup), "{text}");
        assert!(text.contains("MinLimit = -900  # -32767…32767 '"), "{text}");
    }

    /// A file that was cut while it was copied is refused, wherever that was.
    #[test]
    fn a_part_of_a_file_is_none() {
        let values = vec![(Param::GeneralAddress, vec![5]), (Param::VerticalMaxLimit, vec![4500])];
        let backup = Backup { values, ..Backup::default() };
        let text = backup.to_toml();
        let whole = text.trim_end().len();
        for end in (0..whole).filter(|end| text.is_char_boundary(*end)) {
            assert!(Backup::from_toml(&text[..end]).is_err(), "{}", &text[..end]);
        }
        let value = text.find("4500").unwrap() + 2;
        assert_eq!(Backup::from_toml(&text[..value]), Err(FileError::Cut));
        for whole in [&text[..whole], &text, &text.replace('\n', "\r\n")] {
            assert_eq!(Backup::from_toml(whole).as_ref(), Ok(&backup));
        }
        let first = "format = 1\n[Vertical]\nMaxLimit = 45\n";
        assert!(Backup::from_toml(first).is_ok() && !Backup::has_end(first));
    }

    #[test]
    fn mistakes_are_named() {
        let read = |text: &str| Backup::from_toml(&format!("format = 1\n{text}"));
        assert!(matches!(Backup::from_toml("x"), Err(FileError::Syntax { .. })));
        assert_eq!(Backup::from_toml("format = 3"), Err(FileError::Format));
        for (text, word) in [
            ("[Vertical]\nSped = 1", "Vertical.Sped"),
            ("[Up]\nSpeed = 1", "Up"),
            ("Speed = 1", "Speed"),
            ("[Vertical]\nSpeed = 1000", "Vertical.Speed: allowed are"),
            ("[Vertical]\nSpeed = [1, 2]", "1 to 1 whole numbers"),
            ("[Vertical]\nSpeed = \"fast\"", "whole numbers"),
            ("[General]\nFaultInfo = 1", "cannot be set"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.to_string().contains(word), "{text}: {error}");
            // A table that is not known is wrong itself, else the last line is.
            let lines = if word == "Up" { 1 } else { text.lines().count() };
            let line = format!("line {}: ", 1 + lines);
            assert!(error.to_string().contains(&line), "{text}: {error}");
            let russian = error.localized(Lang::Ru);
            assert!(russian.chars().any(|c| ('а'..='я').contains(&c)), "{russian}");
        }
    }
}
