//! Texts in English and Russian.

/// A language.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lang {
    /// English.
    #[default]
    En,
    /// Russian.
    Ru,
}

/// A text in both languages.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Both {
    /// English.
    pub en: String,
    /// Russian.
    pub ru: String,
}

impl Both {
    /// The text in a language.
    pub fn of(&self, lang: Lang) -> &str {
        lang.pick(&self.en, &self.ru)
    }

    /// The same text in both, as names and requests are.
    pub fn same(text: impl Into<String>) -> Self {
        let text = text.into();
        Self { en: text.clone(), ru: text }
    }
}

impl Lang {
    /// One of two.
    pub fn pick<T>(self, en: T, ru: T) -> T {
        match self {
            Self::En => en,
            Self::Ru => ru,
        }
    }
}

/// A text from its two forms.
pub fn both(en: impl Into<String>, ru: impl Into<String>) -> Both {
    Both { en: en.into(), ru: ru.into() }
}
