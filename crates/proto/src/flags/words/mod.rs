//! Meaning, cause and remedy of each flag, one file for each class (ours), in English and Russian,
//! for the engineer at the monitor.

pub(super) mod buttons;
pub(super) mod climatics;
pub(super) mod common;
pub(super) mod conn;
pub(super) mod control;
pub(super) mod deployer;
pub(super) mod detector;
pub(super) mod drive;
pub(super) mod general;
pub(super) mod valve;

use crate::dictionary::Text;

/// The three texts of a flag.
pub(super) struct Words {
    pub(super) meaning: Text,
    pub(super) cause: Text,
    pub(super) remedy: Text,
}

/// Meaning, cause and remedy, each in English and Russian.
const fn words(
    [meaning_en, meaning_ru]: [&'static str; 2],
    [cause_en, cause_ru]: [&'static str; 2],
    [remedy_en, remedy_ru]: [&'static str; 2],
) -> Words {
    Words {
        meaning: Text::new(meaning_en, meaning_ru),
        cause: Text::new(cause_en, cause_ru),
        remedy: Text::new(remedy_en, remedy_ru),
    }
}
