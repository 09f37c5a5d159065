//! Texts of the dictionary, which are pairs of English and Russian.

use lafet_proto::dictionary::Text;
use lafet_texts::Lang;

/// Such a text in a language.
pub const fn in_language(text: Text, lang: Lang) -> &'static str {
    match lang {
        Lang::En => text.en,
        Lang::Ru => text.ru,
    }
}
