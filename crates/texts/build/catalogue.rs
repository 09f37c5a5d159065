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
        for language in all.iter().filter(|it| !is_name(it, '_')) {
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

/// The name of the structure that a text becomes.
pub fn type_name(key: &str) -> String {
    let word = |word: &str| {
        let mut letters = word.chars();
        let first = letters.next().map(|it| it.to_ascii_uppercase());
        first.into_iter().chain(letters).collect::<String>()
    };
    key.split('-').map(word).collect()
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
    let mut file = File::new();
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
        if !is_name(key, '-') {
            problems.push(format!("{path}: {key}: a key is of small letters, digits and -"));
        }
        if !names.insert(type_name(key)) {
            problems.push(format!("{path}: {key}: another key has the same name"));
        }
        match message.value.as_ref().map_or_else(|| Ok(Vec::new()), pieces) {
            Ok(pieces) => {
                if let Err(problem) = letters(&source.language, &pieces) {
                    problems.push(format!("{path}: {key}: {problem}"));
                }
                file.push((key.to_owned(), pieces));
            }
            Err(problem) => problems.push(format!("{path}: {key}: {problem}")),
        }
    }
    file
}

fn pieces(pattern: &Pattern<&str>) -> Result<Vec<Piece>, String> {
    let mut pieces: Vec<Piece> = Vec::new();
    for element in &pattern.elements {
        let text = match element {
            PatternElement::TextElement { value } => (*value).to_owned(),
            PatternElement::Placeable { expression: Expression::Inline(inline) } => match inline {
                InlineExpression::StringLiteral { value } => {
                    fluent_syntax::unicode::unescape_unicode_to_string(value).into_owned()
                }
                InlineExpression::VariableReference { id } => {
                    if !is_name(id.name, '_') {
                        let name = id.name;
                        return Err(format!(
                            "${name}: an argument is of small letters, digits and _"
                        ));
                    }
                    pieces.push(Piece::Argument(id.name.to_owned()));
                    continue;
                }
                _ => {
                    return Err("only { $argument } and { \"text\" } are compiled: \
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
        match pieces.last_mut() {
            Some(Piece::Text(before)) => before.push_str(&text),
            _ => pieces.push(Piece::Text(text)),
        }
    }
    Ok(pieces)
}

/// A name that may stand in Rust as it is: letters, digits and one sign between them.
fn is_name(name: &str, between: char) -> bool {
    name.split(between).all(|word| {
        !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
    }) && name.starts_with(|c: char| c.is_ascii_lowercase())
        && !KEYWORDS.contains(&name)
}

/// Words that would be no argument in Rust.
const KEYWORDS: [&str; 10] =
    ["as", "for", "if", "in", "match", "move", "ref", "self", "type", "where"];

/// Refuses a text in the letters of another language, and words of two alphabets, in which one letter
/// only looks right.
fn letters(language: &str, pieces: &[Piece]) -> Result<(), String> {
    let texts = pieces.iter().filter_map(|piece| match piece {
        Piece::Text(text) => Some(text.as_str()),
        Piece::Argument(_) => None,
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
        "ru" if !russian && text.chars().any(char::is_alphabetic) => {
            Err("no Russian letter: is it translated?".to_owned())
        }
        "ru" => Ok(()),
        _ if russian => Err(format!("Russian letters in a text of `{language}`")),
        _ => Ok(()),
    }
}

fn is_russian(c: char) -> bool {
    matches!(c, 'а'..='я' | 'А'..='Я' | 'ё' | 'Ё')
}
