//! The normative items of the protocol: `spec.txt`, in Russian `spec.ru.txt`.

use std::sync::OnceLock;

use lafet_texts::Fixed;

const ENGLISH: &str = include_str!("spec.txt");
const RUSSIAN: &str = include_str!("spec.ru.txt");
const UNSEEN: &str = include_str!("unseen.txt");

/// Source of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Label {
    /// Follows from the document.
    Read,
    /// Seen on a public bus adapter.
    Observed,
    /// A ruling of ours where the document is silent.
    Ours,
}

impl Label {
    /// Name in spec.txt.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Observed => "observed",
            Self::Ours => "ours",
        }
    }
}

/// An item.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// Identifier, for example `§3.1/4`.
    pub id: &'static str,
    /// Statement.
    pub text: Fixed,
    /// Source of the statement.
    pub label: Label,
}

/// An item that cannot be observed from outside, and why.
#[derive(Clone, Copy, Debug)]
pub struct Unseen {
    /// Identifier of the item.
    pub id: &'static str,
    /// Reason.
    pub reason: Fixed,
}

fn rows(text: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    let lines = text.lines().filter(|line| line.starts_with('§'));
    lines.map(|line| line.split('\t').map(str::trim).collect())
}

/// Every item, in the order of the document.
pub fn items() -> &'static [Item] {
    static ITEMS: OnceLock<Vec<Item>> = OnceLock::new();
    ITEMS.get_or_init(|| {
        let russian: Vec<Vec<&str>> = rows(RUSSIAN).collect();
        let item = |row: Vec<&'static str>| {
            let id = row.first().copied().unwrap_or_default();
            let en = row.get(1).copied().unwrap_or_default();
            let translated = russian.iter().find(|other| other.first() == Some(&id));
            let ru = translated.and_then(|row| row.get(1)).copied().unwrap_or(en);
            Item {
                id,
                text: Fixed { en, ru },
                label: match row.get(2) {
                    Some(&"read") => Label::Read,
                    Some(&"observed") => Label::Observed,
                    _ => Label::Ours,
                },
            }
        };
        rows(ENGLISH).map(item).collect()
    })
}

/// The item with an id.
pub fn item(id: &str) -> Option<&'static Item> {
    items().iter().find(|item| item.id == id)
}

/// Items that no test can observe, and why.
pub fn unseen() -> &'static [Unseen] {
    static ROWS: OnceLock<Vec<Unseen>> = OnceLock::new();
    ROWS.get_or_init(|| {
        rows(UNSEEN)
            .map(|row| Unseen {
                id: row.first().copied().unwrap_or_default(),
                reason: Fixed {
                    en: row.get(1).copied().unwrap_or_default(),
                    ru: row.get(2).copied().unwrap_or_default(),
                },
            })
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::TESTS;

    #[test]
    fn every_item_is_tested_or_has_its_reason() {
        for item in items() {
            let tested = TESTS.iter().any(|test| test.item == item.id);
            let reason = unseen().iter().find(|unseen| unseen.id == item.id);
            assert!(tested != reason.is_some(), "{}: tested {tested}, {reason:?}", item.id);
        }
        for unseen in unseen() {
            assert!(item(unseen.id).is_some(), "{}", unseen.id);
            assert!(!unseen.reason.en.is_empty() && !unseen.reason.ru.is_empty(), "{}", unseen.id);
        }
        for test in TESTS {
            assert!(item(test.item).is_some(), "{}: {}", test.name, test.item);
        }
    }

    #[test]
    fn every_item_is_translated() {
        for item in items() {
            let cyrillic = item.text.ru.chars().any(|c| ('а'..='я').contains(&c));
            assert!(cyrillic, "{}: {}", item.id, item.text.ru);
        }
        assert_eq!(rows(RUSSIAN).count(), items().len());
    }
}
