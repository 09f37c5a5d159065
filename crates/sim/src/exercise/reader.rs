//! Reading a scenario file: every error says file, line, key, and what is allowed.

use core::cell::RefCell;
use core::fmt;

use lafet_texts::{Argument, Lang, Text as _, Words, sim as text};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Why a scenario file cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The file.
    pub file: String,
    /// The line.
    pub line: usize,
    /// The key, with the tables that lead to it: `monitor.profile`.
    pub key: String,
    /// What is wrong, and what is allowed.
    pub what: Words,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.told(Lang::En))
    }
}

impl core::error::Error for Problem {}

impl Problem {
    /// The problem in a language.
    pub fn told(&self, lang: Lang) -> String {
        let Self { file, line, key, what } = self;
        let key = if key.is_empty() { String::new() } else { format!("{key}: ") };
        format!("{file}:{line}: {key}{}", what.of(lang))
    }
}

/// The text of a file, for the numbers of its lines.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// Its name.
    pub file: &'a str,
    /// Its text.
    pub text: &'a str,
}

impl Source<'_> {
    /// A problem at a place of the text.
    pub fn problem(&self, offset: usize, key: String, what: Words) -> Problem {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line = 1 + before.matches('\n').count();
        Problem { file: self.file.to_owned(), line, key, what }
    }
}

/// A file that has been read as TOML.
pub struct Document<'a> {
    source: Source<'a>,
    table: Spanned<DeTable<'a>>,
}

impl<'a> Document<'a> {
    /// Reads the text of a file.
    pub fn parse(file: &'a str, text: &'a str) -> Result<Self, Problem> {
        let source = Source { file, text };
        let table = DeTable::parse(text).map_err(|error| {
            let offset = error.span().map_or(0, |span| span.start);
            let message = lafet_texts::toml::said(error.message());
            source.problem(offset, String::new(), text::NoToml { message }.words())
        })?;
        Ok(Self { source, table })
    }

    /// Its outermost table.
    pub fn root(&self) -> Table<'_> {
        Table::root(self.source, &self.table)
    }
}

/// A table of the file. It remembers which keys it was asked for, so that others are errors.
pub struct Table<'a> {
    source: Source<'a>,
    path: String,
    offset: usize,
    table: &'a DeTable<'a>,
    known: RefCell<Vec<&'static str>>,
}

/// A value and its place in the file.
#[derive(Clone, Copy)]
pub struct Item<'a> {
    /// The value.
    pub value: &'a DeValue<'a>,
    /// Where it begins in the text, bytes.
    pub offset: usize,
}

type Read<T> = Result<T, Problem>;

impl<'a> Table<'a> {
    /// The outermost table.
    pub fn root(source: Source<'a>, table: &'a Spanned<DeTable<'a>>) -> Self {
        Self::new(source, String::new(), table.span().start, table.get_ref())
    }

    fn new(source: Source<'a>, path: String, offset: usize, table: &'a DeTable<'a>) -> Self {
        Self { source, path, offset, table, known: RefCell::default() }
    }

    /// A problem with one of the keys.
    pub fn wrong(&self, key: &str, what: Words) -> Problem {
        let offset = self.table.get(key).map_or(self.offset, |value| value.span().start);
        self.source.problem(offset, self.path_of(key), what)
    }

    fn path_of(&self, key: &str) -> String {
        match (self.path.as_str(), key) {
            ("", key) | (key, "") => key.to_owned(),
            (path, key) => format!("{path}.{key}"),
        }
    }

    /// The line on which the table begins.
    pub fn line(&self) -> usize {
        self.source.problem(self.offset, String::new(), Words::default()).line
    }

    /// A value that may be missing.
    pub fn item(&self, key: &'static str) -> Option<Item<'a>> {
        self.known.borrow_mut().push(key);
        let value = self.table.get(key)?;
        Some(Item { value: value.get_ref(), offset: value.span().start })
    }

    /// Whether there is such a key.
    pub fn has(&self, key: &'static str) -> bool {
        self.item(key).is_some()
    }

    fn missing(&self, key: &str, what: impl Argument) -> Problem {
        self.wrong(key, text::Missing { what }.words())
    }

    /// A number within bounds, or nothing.
    pub fn number(&self, key: &'static str, least: f64, most: f64) -> Read<Option<f64>> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let number = number(item.value).filter(|number| (least..=most).contains(number));
        number.map(Some).ok_or_else(|| {
            let what = format!("{least} … {most}");
            self.wrong(key, text::ANumber { what }.words())
        })
    }

    /// A number that has to be there.
    pub fn needed(&self, key: &'static str, least: f64, most: f64) -> Read<f64> {
        let what = format!("{least} … {most}");
        self.number(key, least, most)?.ok_or_else(|| self.missing(key, text::ANumber { what }))
    }

    /// A whole number within bounds, or nothing.
    pub fn whole(&self, key: &'static str, least: f64, most: f64) -> Read<Option<u64>> {
        let Some(number) = self.number(key, least, most)? else { return Ok(None) };
        let is_whole = number.to_bits() == libm::trunc(number).to_bits();
        let what = format!("{least} … {most}");
        let wrong = || self.wrong(key, text::AWholeNumber { what }.words());
        is_whole.then_some(Some(number as u64)).ok_or_else(wrong)
    }

    /// Yes or no.
    pub fn truth(&self, key: &'static str) -> Read<Option<bool>> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let truth = item.value.as_bool();
        truth.map(Some).ok_or_else(|| self.wrong(key, text::TrueOrFalse.words()))
    }

    /// Text, or nothing.
    pub fn text(&self, key: &'static str) -> Read<Option<&'a str>> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let text = item.value.as_str();
        text.map(Some).ok_or_else(|| self.wrong(key, text::TextInQuotes.words()))
    }

    /// Text that has to be there.
    pub fn needed_text(&self, key: &'static str) -> Read<&'a str> {
        self.text(key)?.ok_or_else(|| self.missing(key, text::TextInQuotes))
    }

    /// Text in both languages: `{ en = "…", ru = "…" }`.
    pub fn both(&self, key: &'static str) -> Read<Option<Words>> {
        let Some(table) = self.table_of(key)? else { return Ok(None) };
        let [en, ru] = [table.needed_text("en")?, table.needed_text("ru")?].map(String::from);
        let texts = Words { en, ru };
        table.finish().map(|()| Some(texts))
    }

    /// Text in both languages that has to be there.
    pub fn needed_both(&self, key: &'static str) -> Read<Words> {
        let form = "{ en = \"…\", ru = \"…\" }";
        self.both(key)?.ok_or_else(|| self.missing(key, form))
    }

    /// One of a list of texts; without it the first.
    pub fn choice<T: Copy>(&self, key: &'static str, known: &[(&str, T)]) -> Read<Option<T>> {
        let Some(text) = self.text(key)? else { return Ok(None) };
        let found = known.iter().find(|(name, _)| *name == text);
        found.map(|(_, value)| Some(*value)).ok_or_else(|| {
            let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
            self.wrong(key, one_of(text, &names))
        })
    }

    /// The place of a name in a list of names.
    pub fn one_of_names(&self, key: &'static str, names: &[String]) -> Read<Option<usize>> {
        let Some(text) = self.text(key)? else { return Ok(None) };
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let found = names.iter().position(|name| *name == text);
        found.map(Some).ok_or_else(|| self.wrong(key, one_of(text, &names)))
    }

    /// A time: `90s`, `1.5min`, `500ms`; in ms.
    pub fn time(&self, key: &'static str) -> Read<Option<u64>> {
        let Some(text) = self.text(key)? else { return Ok(None) };
        time_ms(text).map(Some).ok_or_else(|| self.wrong(key, a_time(text)))
    }

    /// Keys that say nothing beside another one, or without it.
    pub fn none_of(&self, keys: &[&'static str], what: impl Fn() -> Words) -> Read<()> {
        let given = keys.iter().copied().find(|&key| self.has(key));
        given.map_or(Ok(()), |key| Err(self.wrong(key, what())))
    }

    /// Several numbers: `[1.5, -20]`.
    pub fn numbers<const N: usize>(&self, key: &'static str) -> Read<Option<[f64; N]>> {
        let Some(item) = self.item(key) else { return Ok(None) };
        self.array(key, item.value).map(Some)
    }

    /// Several numbers that have to be there.
    pub fn needed_numbers<const N: usize>(&self, key: &'static str) -> Read<[f64; N]> {
        let what = format!("[{}]", ["…"; N].join(", "));
        self.numbers(key)?.ok_or_else(|| self.missing(key, what))
    }

    fn array<const N: usize>(&self, key: &str, value: &DeValue<'_>) -> Read<[f64; N]> {
        let wrong = || self.wrong(key, text::Numbers { count: N }.words());
        let array = value.as_array().filter(|array| array.len() == N).ok_or_else(wrong)?;
        let mut numbers = [0.0; N];
        for (slot, value) in numbers.iter_mut().zip(array.iter()) {
            *slot = number(value.get_ref())
                .filter(|number| number.abs() <= 10_000.0)
                .ok_or_else(wrong)?;
        }
        Ok(numbers)
    }

    /// A list of places: `[[0, 0], [10, 5]]`.
    pub fn places(&self, key: &'static str) -> Read<Vec<(f64, f64)>> {
        let wrong = || self.missing(key, "[[x, y], [x, y], …]");
        let item = self.item(key).ok_or_else(wrong)?;
        let array = item.value.as_array().ok_or_else(wrong)?;
        let place = |value: &Spanned<DeValue<'_>>| {
            self.array::<2>(key, value.get_ref()).map(|[x, y]| (x, y))
        };
        array.iter().map(place).collect()
    }

    /// One text or several; none without the key, and one at least with it.
    pub fn texts_of(&self, key: &'static str) -> Read<Vec<&'a str>> {
        let texts = self.texts(key)?;
        match texts.is_empty() && self.has(key) {
            true => Err(self.wrong(key, text::EmptyList.words())),
            false => Ok(texts),
        }
    }

    /// One text or several; none without the key.
    pub fn texts(&self, key: &'static str) -> Read<Vec<&'a str>> {
        let Some(item) = self.item(key) else { return Ok(Vec::new()) };
        let wrong = || self.wrong(key, text::TextOrTexts.words());
        if let Some(text) = item.value.as_str() {
            return Ok(vec![text]);
        }
        let array = item.value.as_array().ok_or_else(wrong)?;
        array.iter().map(|value| value.get_ref().as_str().ok_or_else(wrong)).collect()
    }

    /// A table that may be missing: `[key]`, or `key = { … }`.
    pub fn table_of(&self, key: &'static str) -> Read<Option<Self>> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let table = item.value.as_table().ok_or_else(|| self.wrong(key, text::ATable.words()))?;
        Ok(Some(Self::new(self.source, self.path_of(key), item.offset, table)))
    }

    /// All tables of a list: `[[key]]`.
    pub fn tables(&self, key: &'static str) -> Read<Vec<Self>> {
        let Some(item) = self.item(key) else { return Ok(Vec::new()) };
        let wrong = || {
            let form = format!("[[{key}]]");
            self.wrong(key, text::Tables { form }.words())
        };
        let array = item.value.as_array().ok_or_else(wrong)?;
        let table = |value: &'a Spanned<DeValue<'a>>| {
            let table = value.get_ref().as_table().ok_or_else(wrong)?;
            Ok(Self::new(self.source, self.path_of(key), value.span().start, table))
        };
        array.iter().map(table).collect()
    }

    /// Nothing else may stand there.
    pub fn finish(self) -> Read<()> {
        let known = self.known.borrow();
        let strange = self.table.iter().find(|(key, _)| !known.contains(&key.get_ref().as_ref()));
        let Some((key, _)) = strange else { return Ok(()) };
        let what = one_of(key.get_ref(), &known);
        Err(self.source.problem(key.span().start, self.path_of(key.get_ref()), what))
    }
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    let text = match value {
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str(),
        DeValue::Float(float) => float.as_str(),
        _ => return None,
    };
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// What to say of a word that is none of those known.
pub fn one_of(word: &str, known: &[&str]) -> Words {
    let names = known.join(", ");
    text::WordUnknown { word, known: names }.words()
}

/// What to say of a text that is no time.
pub fn a_time(text: &str) -> Words {
    text::NoTime { text }.words()
}

/// Reads `500ms`, `20s`, `1.5min`; at most two hours, in steps of 100 ms.
pub fn time_ms(text: &str) -> Option<u64> {
    let units = [("ms", 1.0), ("min", 60_000.0), ("s", 1000.0)];
    let (number, factor) =
        units.iter().find_map(|(unit, factor)| Some((text.trim().strip_suffix(unit)?, factor)))?;
    let ms = number.trim().parse::<f64>().ok()? * factor;
    (0.0..=7_200_000.0).contains(&ms).then(|| (libm::round(ms / 100.0) as u64) * 100)
}
