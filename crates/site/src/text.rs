//! A text for people, in both languages.

use serde::{Deserialize, Serialize};

/// A text in English and Russian.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Both {
    /// English.
    pub en: String,
    /// Russian.
    pub ru: String,
}

/// A text in both languages.
pub fn both(en: impl Into<String>, ru: impl Into<String>) -> Both {
    Both { en: en.into(), ru: ru.into() }
}
