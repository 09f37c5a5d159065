//! A text for people, in both languages.

use lafet_client::Lang;
use lafet_proto::dictionary::Text;
use lafet_texts::{Fixed, Words};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A text in English and Russian.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
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

impl Both {
    /// The text in a language.
    pub fn of(&self, lang: Lang) -> &str {
        match lang {
            Lang::En => &self.en,
            Lang::Ru => &self.ru,
        }
    }

    /// What an error of the client says.
    pub fn of_error(error: &lafet_client::Error) -> Self {
        both(error.localized(Lang::En), error.localized(Lang::Ru))
    }
}

impl From<Words> for Both {
    fn from(Words { en, ru }: Words) -> Self {
        Self { en, ru }
    }
}

impl From<Fixed> for Both {
    fn from(text: Fixed) -> Self {
        both(text.en, text.ru)
    }
}

impl From<Text> for Both {
    fn from(text: Text) -> Self {
        both(text.en, text.ru)
    }
}
