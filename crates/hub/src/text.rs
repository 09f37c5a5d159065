//! What the hub says to people: the texts are in `catalogues/LANGUAGE/hub.ftl` of `lafet-texts`.

pub use lafet_texts::Words as Both;

/// Words that are in no catalogue.
pub fn both(en: impl Into<String>, ru: impl Into<String>) -> Both {
    Both { en: en.into(), ru: ru.into() }
}
