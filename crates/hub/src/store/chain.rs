//! The chain of the audit log: each entry holds the hash of the one before.

use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;

use super::audit::{Entry, Record};
use crate::access::digest;

/// What the first entry has before it.
pub const GENESIS: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// What came out of a check of the chain.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Verified {
    /// Every hash is right, and none is missing.
    pub ok: bool,
    /// Entries that were looked at.
    pub entries: u64,
    /// Hash of the last one.
    pub head: String,
    /// The first entry that is not right.
    #[schema(required)]
    pub bad: Option<u64>,
}

/// Walks along a chain of entries.
#[derive(Clone, Debug, Default)]
pub struct Chain {
    entries: u64,
    head: Option<String>,
    bad: Option<u64>,
}

impl Chain {
    /// Goes on after an entry whose number and hash are known.
    pub fn after((entries, hash): (u64, String)) -> Self {
        Self { entries, head: (entries > 0).then_some(hash), bad: None }
    }

    /// Number of the entry that comes next.
    pub const fn next(&self) -> u64 {
        self.entries + 1
    }

    /// The first entry that is not right.
    pub const fn bad(&self) -> Option<u64> {
        self.bad
    }

    /// Takes the next entry; `false`: it is not the one that was written.
    pub fn add(&mut self, entry: &Entry) -> bool {
        let prev = self.head.as_deref().unwrap_or(GENESIS);
        let right = entry.n == self.next()
            && entry.prev == prev
            && entry.hash == hash(entry.n, &entry.record, prev);
        if right {
            self.entries += 1;
            self.head = Some(entry.hash.clone());
        } else {
            self.bad = Some(self.next());
        }
        right
    }

    /// The result of the walk.
    pub fn result(self) -> Verified {
        let head = self.head.unwrap_or_else(|| GENESIS.into());
        Verified { ok: self.bad.is_none(), entries: self.entries, head, bad: self.bad }
    }
}

/// Checks an exported log: a line of JSON for each entry.
pub fn verify_lines(lines: impl Iterator<Item = std::io::Result<String>>) -> Verified {
    let mut chain = Chain::default();
    for line in lines {
        let entry = line.ok().and_then(|line| entry_of(&line));
        let right = entry.is_some_and(|entry| chain.add(&entry));
        if !right {
            chain.bad = Some(chain.next());
            break;
        }
    }
    chain.result()
}

/// An entry as it was exported. Further fields are refused: no hash would cover them.
fn entry_of(line: &str) -> Option<Entry> {
    let entry: Entry = serde_json::from_str(line).ok()?;
    let all: Value = serde_json::from_str(line).ok()?;
    (serde_json::to_value(&entry).ok()? == all).then_some(entry)
}

/// SHA-256 of the entry without its hash, as a JSON array: one text for one meaning.
pub fn hash(n: u64, it: &Record, prev: &str) -> String {
    let texts =
        [&it.user, &it.role, &it.from, &it.via, &it.seat, &it.monitor, &it.what, &it.outcome];
    let mut parts = vec![Value::from(n), it.at_ms.into()];
    parts.extend(texts.map(|text| Value::from(text.as_str())));
    parts.extend([it.details.clone(), prev.into()]);
    // Entries of earlier versions have neither.
    if it.kind.is_some() || it.act.is_some() {
        let kind = serde_json::to_value(it.kind).unwrap_or_default();
        parts.extend([kind, it.act.clone().unwrap_or_default()]);
    }
    digest(&Value::Array(parts).to_string())
}
