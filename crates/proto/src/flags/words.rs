//! Meaning, cause and remedy of a flag (ours), in English and Russian, for the engineer at the
//! monitor.

use crate::dictionary::Text;

/// The three texts of a flag.
pub(crate) struct Words {
    pub(crate) meaning: Text,
    pub(crate) cause: Text,
    pub(crate) remedy: Text,
}

/// Meaning, cause and remedy, each in English and Russian.
pub(crate) const fn words(
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
