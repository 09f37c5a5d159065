//! The catalogues as they are read, and what must hold of them.

use std::collections::{BTreeMap, BTreeSet};

use fluent_syntax::ast::{Entry, Expression, InlineExpression, Pattern, PatternElement};
use fluent_syntax::parser;

/// The language that has every text first: its files, keys and arguments are what the others need.
pub const FIRST: &str = "en";

/// A file of a language.
#[derive(Clone, Debug)]
pub struct Source {
    /// Name of the folder.
    pub language: String,
    /// Name of the file, which is that of the crate.
    pub area: String,
    /// What it has.
    pub text: String,
}

/// The texts of all languages.
#[derive(Debug, PartialEq)]
pub struct Catalogue {
    /// The names of the folders; the first language first.
    pub languages: Vec<String>,
    /// By the name of the file.
    pub areas: BTreeMap<String, Vec<Message>>,
}

/// A text in all languages.
#[derive(Debug, PartialEq)]
pub struct Message {
    /// As in the catalogue.
    pub key: String,
    /// In the order in which the first language has them.
    pub arguments: Vec<String>,
    /// In the order of [`Catalogue::languages`].
    pub forms: Vec<Vec<Piece>>,
}

/// A part of a text.
#[derive(Clone, Debug, PartialEq)]
pub enum Piece {
    /// As it is.
    Text(String),
    /// The argument of this name.
    Argument(String),
}

/// A part of a text as it is written.
enum Part {
    Piece(Piece),
    /// The text of this key, in the same file.
    Reference(String),
}

/// The texts of a file, by key, in its order.
type File = Vec<(String, Vec<Piece>)>;

impl Catalogue {
    /// Reads the files of all languages.
    ///
    /// # Errors
    ///
    /// Everything that is wrong with them: what is not understood, is missing or differs between languages.
    pub fn read(sources: &[Source]) -> Result<Self, Vec<String>> {
        let mut problems = Vec::new();
        let mut files: BTreeMap<(&str, &str), File> = BTreeMap::new();
        for source in sources {
            let file = file(source, &mut problems);
            files.insert((&source.language, &source.area), file);
        }
        let all: BTreeSet<&str> = sources.iter().map(|it| it.language.as_str()).collect();
        for language in all.iter().filter(|it| !is_field(it)) {
            problems.push(format!("{language}: a folder is of small letters, as `en`"));
        }
        let others = all.iter().copied().filter(|it| *it != FIRST);
        let languages: Vec<&str> = std::iter::once(FIRST).chain(others).collect();
        let mut areas = BTreeMap::new();
        for area in sources.iter().map(|it| it.area.as_str()).collect::<BTreeSet<_>>() {
            let none = File::new();
            let of = |language| files.get(&(language, area)).unwrap_or(&none);
            let forms: Vec<(&str, &File)> = languages.iter().map(|it| (*it, of(it))).collect();
            areas.insert(area.to_owned(), united(area, &forms, &mut problems));
        }
        let languages = languages.into_iter().map(String::from).collect();
        if problems.is_empty() { Ok(Self { languages, areas }) } else { Err(problems) }
    }
}

/// Puts the languages of a file together.
fn united(area: &str, languages: &[(&str, &File)], problems: &mut Vec<String>) -> Vec<Message> {
    let Some(((_, first), others)) = languages.split_first() else { return Vec::new() };
    for (language, file) in others {
        for (key, _) in file.iter().filter(|(key, _)| find(first, key).is_none()) {
            problems
                .push(format!("{language}/{area}.ftl: {key}: {FIRST}/{area}.ftl has no such key"));
        }
    }
    let mut messages = Vec::new();
    for (key, pieces) in *first {
        let arguments = arguments(pieces);
        let mut forms = vec![pieces.clone()];
        for (language, file) in others {
            let Some(pieces) = find(file, key) else {
                problems.push(format!("{language}/{area}.ftl: no text for {key}"));
                continue;
            };
            let wanted: BTreeSet<&String> = arguments.iter().collect();
            let given = self::arguments(pieces);
            if wanted != given.iter().collect() {
                problems.push(format!(
                    "{language}/{area}.ftl: {key} has the arguments {given:?}, in {FIRST} {arguments:?}"
                ));
            }
            forms.push(pieces.clone());
        }
        messages.push(Message { key: key.clone(), arguments, forms });
    }
    messages
}

fn find<'a>(file: &'a File, key: &str) -> Option<&'a Vec<Piece>> {
    file.iter().find(|(known, _)| known == key).map(|(_, pieces)| pieces)
}

/// The names of the arguments, each once.
fn arguments(pieces: &[Piece]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for piece in pieces {
        if let Piece::Argument(name) = piece
            && !names.contains(name)
        {
            names.push(name.clone());
        }
    }
    names
}

/// The name of the structure that a text becomes: `status-Busy-remedy` is `StatusBusyRemedy`.
pub fn type_name(key: &str) -> String {
    let word = |word: &str| {
        let mut letters = word.chars();
        let first = letters.next().map(|it| it.to_ascii_uppercase());
        first.into_iter().chain(letters).collect::<String>()
    };
    key.split(['-', '_']).map(word).collect()
}

/// Reads a file of a language.
fn file(source: &Source, problems: &mut Vec<String>) -> File {
    let path = format!("{}/{}.ftl", source.language, source.area);
    let resource = parser::parse(source.text.as_str()).unwrap_or_else(|(resource, errors)| {
        for error in errors {
            let before = source.text.get(..error.pos.start).unwrap_or_default();
            let line = before.matches('\n').count() + 1;
            problems.push(format!("{path}:{line}: {}", error.kind));
        }
        resource
    });
    let mut file: Vec<(&str, Vec<Part>)> = Vec::new();
    let mut names = BTreeSet::new();
    for entry in &resource.body {
        let message = match entry {
            Entry::Message(message) => message,
            Entry::Term(term) => {
                let name = term.id.name;
                problems.push(format!("{path}: -{name}: terms are not compiled; write it out"));
                continue;
            }
            // An error of the parser has been reported for it.
            Entry::Junk { .. }
            | Entry::Comment(_)
            | Entry::GroupComment(_)
            | Entry::ResourceComment(_) => continue,
        };
        let key = message.id.name;
        if !message.attributes.is_empty() {
            problems.push(format!("{path}: {key}: attributes are not compiled; use a key each"));
        }
        if !is_key(key) {
            problems.push(format!(
                "{path}: {key}: a key is of small letters, digits, - and names of the protocol"
            ));
        }
        if !names.insert(type_name(key)) {
            problems.push(format!("{path}: {key}: another key has the same name"));
        }
        match message.value.as_ref().map_or_else(|| Ok(Vec::new()), parts) {
            Ok(parts) => {
                if let Err(problem) = letters(&source.language, &parts) {
                    problems.push(format!("{path}: {key}: {problem}"));
                }
                file.push((key, parts));
            }
            Err(problem) => problems.push(format!("{path}: {key}: {problem}")),
        }
    }
    resolved(&path, &file, problems)
}

/// The same with the texts that others refer to in the place of the references.
fn resolved(path: &str, file: &[(&str, Vec<Part>)], problems: &mut Vec<String>) -> File {
    let mut whole = File::new();
    for (key, parts) in file {
        let mut pieces = Vec::new();
        for part in parts {
            match part {
                Part::Piece(piece) => pieces.push(piece.clone()),
                Part::Reference(other) => match plain(file, other) {
                    Some(text) => pieces.extend(text),
                    None => problems.push(format!(
                        "{path}: {key}: {other} is no text here, or refers to another itself"
                    )),
                },
            }
        }
        whole.push(((*key).to_owned(), pieces));
    }
    whole
}

/// The text of a key, unless it has references.
fn plain(file: &[(&str, Vec<Part>)], key: &str) -> Option<Vec<Piece>> {
    let (_, parts) = file.iter().find(|(known, _)| *known == key)?;
    let piece = |part: &Part| match part {
        Part::Piece(piece) => Some(piece.clone()),
        Part::Reference(_) => None,
    };
    parts.iter().map(piece).collect()
}

fn parts(pattern: &Pattern<&str>) -> Result<Vec<Part>, String> {
    let mut parts: Vec<Part> = Vec::new();
    for element in &pattern.elements {
        let text = match element {
            PatternElement::TextElement { value } => (*value).to_owned(),
            PatternElement::Placeable { expression: Expression::Inline(inline) } => match inline {
                InlineExpression::StringLiteral { value } => {
                    fluent_syntax::unicode::unescape_unicode_to_string(value).into_owned()
                }
                InlineExpression::VariableReference { id } => {
                    if !is_field(id.name) {
                        let name = id.name;
                        return Err(format!(
                            "${name}: an argument is of small letters, digits and _"
                        ));
                    }
                    parts.push(Part::Piece(Piece::Argument(id.name.to_owned())));
                    continue;
                }
                InlineExpression::MessageReference { id, attribute: None } => {
                    parts.push(Part::Reference(id.name.to_owned()));
                    continue;
                }
                _ => {
                    return Err("only { $argument }, { key } and { \"text\" } are compiled: \
                                prepare numbers and choices in the code"
                        .to_owned());
                }
            },
            PatternElement::Placeable { .. } => {
                return Err("selectors are not compiled: use a key each, or words that need no \
                            choice (`votes: 3`)"
                    .to_owned());
            }
        };
        match parts.last_mut() {
            Some(Part::Piece(Piece::Text(before))) => before.push_str(&text),
            _ => parts.push(Part::Piece(Piece::Text(text))),
        }
    }
    Ok(parts)
}

/// Words of letters and digits, as the names of the protocol have them, with - or _ between; it
/// becomes the name of a type.
fn is_key(key: &str) -> bool {
    let word = |word: &str| word.starts_with(|c: char| c.is_ascii_alphanumeric());
    key.starts_with(|c: char| c.is_ascii_lowercase())
        && key.split(['-', '_']).all(word)
        && key != "self"
}

/// A name of a field: letters and digits, `_` between them, no keyword. That of a key becomes the name of a type, so it may
/// be a keyword: `move`.
fn is_field(name: &str) -> bool {
    name.split('_').all(|word| {
        !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
    }) && name.starts_with(|c: char| c.is_ascii_lowercase())
        && !KEYWORDS.contains(&name)
}

/// Words that would be no argument in Rust.
const KEYWORDS: [&str; 10] =
    ["as", "for", "if", "in", "match", "move", "ref", "self", "type", "where"];

/// Refuses a text in the letters of another language, and words of two alphabets, in which one letter
/// only looks right.
fn letters(language: &str, parts: &[Part]) -> Result<(), String> {
    let texts = parts.iter().filter_map(|part| match part {
        Part::Piece(Piece::Text(text)) => Some(text.as_str()),
        Part::Piece(Piece::Argument(_)) | Part::Reference(_) => None,
    });
    let text: String = texts.collect::<Vec<_>>().join(" ");
    if let Some(word) = text
        .split(|c: char| !c.is_alphabetic())
        .find(|word| word.chars().any(is_russian) && word.chars().any(|c| c.is_ascii_alphabetic()))
    {
        return Err(format!("“{word}” has Latin and Russian letters"));
    }
    let russian = text.chars().any(is_russian);
    match language {
        // Units are single letters, some of them the same in all languages.
        "ru" if !russian && has_words(&text) => {
            Err("no Russian letter: is it translated?".to_owned())
        }
        "ru" => Ok(()),
        _ if russian => Err(format!("Russian letters in a text of `{language}`")),
        _ => Ok(()),
    }
}

fn has_words(text: &str) -> bool {
    text.split(|c: char| !c.is_alphabetic()).any(|word| word.chars().nth(1).is_some())
}

fn is_russian(c: char) -> bool {
    matches!(c, 'а'..='я' | 'А'..='Я' | 'ё' | 'Ё')
}
