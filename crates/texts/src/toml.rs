//! What the parser of TOML says of a text that is none, in every language.

use crate::{Lang, Words};

/// Descriptions, as the parser has them.
const SAID: [(&str, &str); 45] = [
    ("`_` may only go between digits", "`_` может стоять только между цифрами"),
    ("cannot extend value of type array with a dotted key", "список не дополняют ключом с точкой"),
    (
        "cannot extend value of type inline table with a dotted key",
        "таблицу в фигурных скобках не дополняют ключом с точкой",
    ),
    ("cannot recurse further; max recursion depth met", "слишком много вложений"),
    ("carriage return must be followed by newline", "после CR нет LF"),
    ("duplicate key", "ключ указан дважды"),
    ("extra `=`", "лишний `=`"),
    ("extra assignment between key-value pairs", "лишний `=`"),
    ("extra comma in array", "лишняя запятая в списке"),
    ("extra comma in inline table", "лишняя запятая в фигурных скобках"),
    ("integers with a radix cannot be signed", "у числа с 0x, 0o или 0b не бывает знака"),
    ("invalid comment character", "недопустимый знак в примечании"),
    ("invalid inline table element", "неверная запись в фигурных скобках"),
    ("invalid key-value pair", "неверная запись: нужно ключ = значение"),
    ("invalid unquoted key", "недопустимый знак в ключе без кавычек"),
    ("invalid value", "неверное значение"),
    ("key with no value", "ключ без значения"),
    ("keys cannot be multi-line basic strings", "ключ не может занимать несколько строк"),
    ("keys cannot be multi-line literal strings", "ключ не может занимать несколько строк"),
    ("missing array opening", "нет начала списка"),
    ("missing assignment between key-value pairs", "нет `=` между ключом и значением"),
    ("missing comma between array elements", "нет запятой в списке"),
    ("missing comma between key-value pairs", "нет запятой в фигурных скобках"),
    ("missing comment start", "нет начала примечания"),
    ("missing escaped value", "после `\\` ничего нет"),
    ("missing inline table opening", "нет открывающей фигурной скобки"),
    ("missing key for inline table element", "нет ключа в фигурных скобках"),
    ("missing opening quote", "нет открывающей кавычки"),
    ("missing value", "нет значения"),
    ("missing value for key", "нет значения ключа"),
    ("radix must be lowercase", "0x, 0o и 0b пишут строчными"),
    ("recursion limit", "слишком много вложений"),
    ("redundant integer number prefix", "лишнее начало числа"),
    ("redundant numeric sign", "лишний знак числа"),
    ("string values must be quoted", "текст пишут в кавычках"),
    ("too few unicode value digits", "мало цифр в коде знака"),
    ("unclosed array", "список не закрыт"),
    ("unclosed array table", "заголовок не закрыт"),
    ("unclosed inline table", "фигурная скобка не закрыта"),
    ("unclosed table", "заголовок не закрыт"),
    ("unexpected `=` in array", "`=` в списке"),
    ("unexpected content", "лишнее после конца записи"),
    ("unexpected key or value", "лишнее в строке"),
    ("unexpected leading zero", "лишний нуль в начале числа"),
    ("unquoted keys cannot be empty", "ключ без кавычек не может быть пустым"),
];
/// What the parser would have taken; anything in quotes is itself.
const EXPECTED: [(&str, &str); 6] = [
    ("key", "ключ"),
    ("value", "значение"),
    ("numbers", "цифры"),
    ("letters", "буквы"),
    ("digits", "цифры"),
    ("newline", "конец строки"),
];

/// The message in every language; one that is not known is quoted.
pub fn said(message: &str) -> Words {
    Words::each(|lang| match lang {
        Lang::En => message.to_owned(),
        Lang::Ru => russian(message),
    })
}

fn russian(message: &str) -> String {
    let (what, expected) =
        message.split_once(", expected ").map_or((message, None), |(what, it)| (what, Some(it)));
    let Some((_, what)) = SAID.iter().find(|(said, _)| *said == what) else {
        return format!("ошибка разбора: {message}");
    };
    let word = |said: &str| match EXPECTED.iter().find(|(name, _)| *name == said) {
        Some((_, word)) => Some((*word).to_owned()),
        None => said.contains(['`', '\'', '"']).then(|| said.to_owned()),
    };
    // Without all of them a list would be wrong.
    let list = expected.and_then(|it| it.split(", ").map(word).collect::<Option<Vec<_>>>());
    list.map_or_else(|| (*what).to_owned(), |list| format!("{what}; нужно: {}", list.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_messages_are_translated_and_others_quoted() {
        for (message, ru) in [
            ("unclosed table, expected `]`", "заголовок не закрыт; нужно: `]`"),
            (
                "invalid unquoted key, expected letters, numbers, `-`, `_`",
                "недопустимый знак в ключе без кавычек; нужно: буквы, цифры, `-`, `_`",
            ),
            ("unexpected content, expected nothing", "лишнее после конца записи"),
            ("duplicate key", "ключ указан дважды"),
            ("a new one", "ошибка разбора: a new one"),
        ] {
            let words = said(message);
            assert_eq!((words.en.as_str(), words.ru.as_str()), (message, ru));
        }
        assert!(SAID.windows(2).all(|pair| pair[0].0 < pair[1].0), "in order, each once");
    }
}
