//! Mutants that no test can notice, each with its reason: `xtask/mutants.toml`.

use toml::{Table, Value};

use super::list::Mutant;
use crate::run::read;

const FILE: &str = "xtask/mutants.toml";

pub struct Explained {
    entries: Vec<Entry>,
}

struct Entry {
    file: String,
    name: String,
    line: String,
}

impl Explained {
    pub fn read() -> Result<Self, String> {
        Self::parse(&read(FILE)?)
    }

    fn parse(text: &str) -> Result<Self, String> {
        let table: Table = text.parse().map_err(|e| format!("{FILE}: {e}"))?;
        let all = table.get("mutant").and_then(Value::as_array).cloned().unwrap_or_default();
        let entries = all.iter().map(|entry| {
            let field = |name: &str| {
                let text = entry.get(name).and_then(Value::as_str).map(str::trim);
                let text = text.filter(|text| !text.is_empty());
                text.map(String::from)
                    .ok_or_else(|| format!("{FILE}: {name} is missing in {entry:?}"))
            };
            field("reason")?;
            Ok(Entry { file: field("file")?, name: field("name")?, line: field("line")? })
        });
        Ok(Self { entries: entries.collect::<Result<_, String>>()? })
    }

    pub fn has(&self, mutant: &Mutant) -> bool {
        self.entries.iter().any(|entry| entry.is(mutant))
    }

    /// Entries whose mutant no longer exists.
    pub fn stale<'a>(
        &self,
        mutants: impl Iterator<Item = &'a Mutant> + Clone,
        areas: &[String],
    ) -> Vec<String> {
        let is_of =
            |entry: &Entry, area: &str| area == super::DEVICE || entry.file == format!("{area}.rs");
        let of_area = |entry: &&Entry| areas.iter().any(|area| is_of(entry, area));
        let stale = self
            .entries
            .iter()
            .filter(of_area)
            .filter(|entry| !mutants.clone().any(|mutant| entry.is(mutant)));
        stale.map(|entry| format!("{FILE}: no mutant `{}` in {}", entry.name, entry.file)).collect()
    }
}

impl Entry {
    fn is(&self, mutant: &Mutant) -> bool {
        let (file, name, line) = mutant.key();
        file == self.file && name == self.name && line == self.line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_is_needed() {
        let entry = "[[mutant]]\nfile = \"guard.rs\"\nname = \"n\"\nline = \"l\"\n";
        assert!(Explained::parse(entry).is_err());
        let read = Explained::parse(&format!("{entry}reason = \"equal\"\n")).unwrap();
        assert_eq!(read.stale(std::iter::empty(), &["guard".into()]).len(), 1);
        assert!(read.stale(std::iter::empty(), &["chain".into()]).is_empty());
    }
}
