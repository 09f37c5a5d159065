//! `cargo xtask words`: fails on words of xtask/words.txt in the areas that are free of them.
//!
//! [`LIST`] has the areas and the words. Checked are prose of Markdown, catalogues of texts, comments, and
//! quoted texts of more than one word; code, names and the generated parts of a page are not. A text of
//! the catalogues that no code uses fails too.

use std::process::ExitCode;

use crate::{TaskResult, flag, links, run, source, texts};

/// The areas that are checked and the words, each with what to write instead.
const LIST: &str = "xtask/words.txt";
const EXTENSIONS: [&str; 9] = ["md", "rs", "ts", "mjs", "css", "ftl", "c", "h", "txt"];
/// What a generated file says in its first lines.
const GENERATED: &str = "auto-generated";
const HEADER: usize = 3;

#[derive(Debug, Default, PartialEq)]
struct List {
    areas: Vec<String>,
    words: Vec<Word>,
}

/// A word, or several in a row, that must not appear.
#[derive(Debug, PartialEq)]
struct Word {
    /// In lower case.
    text: String,
    /// Whether any ending belongs to it: it ends with `*` in the list.
    any_ending: bool,
    instead: String,
}

pub fn words(arguments: &[String]) -> TaskResult {
    flag(arguments, None)?;
    check().map(|()| ExitCode::SUCCESS)
}

/// Fails on a word of the list in one of its areas, with file and line.
pub fn check() -> run::StepResult {
    let list = parse(&run::read(LIST)?)?;
    run::verdict("texts without a use", &texts::unused()?)?;
    let mut problems = Vec::new();
    let mut files = 0;
    for area in &list.areas {
        for path in files_of(area)? {
            files += 1;
            let text = run::read(&path)?;
            if text.lines().take(HEADER).any(|line| line.contains(GENERATED)) {
                continue;
            }
            for (number, checked) in checked_parts(&path, &text) {
                let found = found_in(&checked, &list.words);
                problems.extend(found.map(|word| {
                    format!("{path}:{number}: `{}`; write: {}", word.text, word.instead)
                }));
            }
        }
    }
    run::verdict("words to replace", &problems)?;
    println!("   {files} files have none of the {} words of {LIST}", list.words.len());
    Ok(())
}

fn parse(text: &str) -> Result<List, String> {
    let mut list = List::default();
    let mut section = "";
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        match (line, section) {
            ("[areas]" | "[words]", _) => section = line,
            (area, "[areas]") => list.areas.push(area.to_owned()),
            (entry, "[words]") => {
                let (word, instead) = entry
                    .split_once(" = ")
                    .ok_or_else(|| format!("{LIST}:{}: expected `word = instead`", index + 1))?;
                let stem = word.strip_suffix('*');
                list.words.push(Word {
                    text: stem.unwrap_or(word).to_lowercase(),
                    any_ending: stem.is_some(),
                    instead: instead.to_owned(),
                });
            }
            _ => return Err(format!("{LIST}:{}: expected `[areas]` or `[words]`", index + 1)),
        }
    }
    Ok(list)
}

/// Paths of the files of an area, from the root.
fn files_of(area: &str) -> Result<Vec<String>, String> {
    let path = run::root().join(area);
    if path.is_file() {
        return Ok(vec![area.to_owned()]);
    }
    let mut files = Vec::new();
    for extension in EXTENSIONS {
        files.extend(source::files_under(&path, extension)?.iter().map(|it| source::relative(it)));
    }
    if files.is_empty() { Err(format!("{LIST}: nothing to check in {area}")) } else { Ok(files) }
}

/// The parts of a file that are text for people, with the numbers of their lines.
fn checked_parts(path: &str, text: &str) -> Vec<(usize, String)> {
    match path.rsplit_once('.').map(|(_, extension)| extension) {
        Some("md") => prose(text),
        Some("rs" | "c" | "h") => numbered(text, &['"']),
        Some("txt") => whole(text),
        Some("ftl") => catalogue(text),
        _ => numbered(text, &['"', '\'', '`']),
    }
}

/// Lines of a page without code and without the parts that are generated.
fn prose(text: &str) -> Vec<(usize, String)> {
    let mut generated = false;
    let mut parts = Vec::new();
    for (number, line) in links::prose(text) {
        generated = !line.contains(":end -->") && (generated || line.contains(":begin -->"));
        if !generated {
            let outside = line.split('`').step_by(2).collect::<Vec<_>>();
            parts.push((number, outside.join(" ")));
        }
    }
    parts
}

/// Lines of a catalogue without keys and arguments.
fn catalogue(text: &str) -> Vec<(usize, String)> {
    let of_text = |line: &str| {
        let key = |start: &str| start.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
        let text = line.split_once(" =").filter(|(start, _)| key(start)).map(|(_, text)| text);
        without_markup(text.unwrap_or(line))
    };
    text.lines().enumerate().map(|(index, line)| (index + 1, of_text(line))).collect()
}

/// Every line: scenarios and tables are names of the wire and prose, and no name is a word of the list.
fn whole(text: &str) -> Vec<(usize, String)> {
    text.lines().enumerate().map(|(index, line)| (index + 1, line.to_owned())).collect()
}

fn numbered(text: &str, quotes: &[char]) -> Vec<(usize, String)> {
    text.lines().enumerate().map(|(index, line)| (index + 1, of_source(line, quotes))).collect()
}

/// The comment of a line of code, and its quoted texts that have a blank: others are names.
fn of_source(line: &str, quotes: &[char]) -> String {
    let trimmed = line.trim_start();
    if ["//", "/*", "* "].iter().any(|start| trimmed.starts_with(start)) {
        return trimmed.to_owned();
    }
    let mut parts = String::new();
    let mut rest = line;
    while let Some(start) = rest.find(|c| quotes.contains(&c) || c == '/') {
        if rest[start..].starts_with("//") {
            parts += &rest[start..];
            break;
        }
        let quote = rest[start..].chars().next().unwrap_or('/');
        rest = &rest[start + 1..];
        let Some(end) = rest.find(quote).filter(|_| quote != '/') else { continue };
        let text = without_markup(&rest[..end]);
        if text.contains(' ') {
            parts += &text;
            parts.push('\n');
        }
        rest = &rest[end + 1..];
    }
    parts
}

/// A quoted text without tags and without the code that is filled in (`${…}`, `{…}`).
fn without_markup(text: &str) -> String {
    let mut depth = 0_u32;
    let mut plain = String::new();
    for c in text.chars() {
        match c {
            '{' | '<' => depth += 1,
            '}' | '>' => depth = depth.saturating_sub(1),
            _ if depth == 0 => plain.push(c),
            _ => {}
        }
    }
    plain
}

/// The words of the list that a text has, whole and in any case.
fn found_in<'a>(text: &str, words: &'a [Word]) -> impl Iterator<Item = &'a Word> {
    let text = text.to_lowercase();
    words.iter().filter(move |word| {
        text.match_indices(&word.text).any(|(start, found)| {
            let inside = |c: char| c.is_alphanumeric() || c == '_';
            let end = start + found.len();
            !text[..start].ends_with(inside)
                && (word.any_ending || !text[end..].starts_with(inside))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list() -> List {
        parse("# why\n[areas]\nREADME.md\n\n[words]\nOld = new\nslow* = fast\nтак себе = хорошо\n")
            .unwrap()
    }

    fn hits(text: &str) -> Vec<&'static str> {
        let words = list().words;
        let found = found_in(text, &words).map(|word| word.instead.clone());
        found
            .map(|it| ["new", "fast", "хорошо"].into_iter().find(|one| *one == it).unwrap())
            .collect()
    }

    #[test]
    fn the_list_is_read_and_its_mistakes_have_a_line() {
        assert_eq!(list().areas, ["README.md"]);
        assert_eq!(list().words.len(), 3);
        assert!(parse("[words]\nold\n").unwrap_err().contains("words.txt:2"));
        assert!(parse("README.md\n").unwrap_err().contains("words.txt:1"));
    }

    #[test]
    fn words_are_whole_and_in_any_case() {
        assert_eq!(hits("An OLD page."), ["new"]);
        assert_eq!(hits("bold, older, old_name"), [""; 0]);
        assert_eq!(hits("slower"), ["fast"]);
        assert_eq!(hits("Вышло так себе."), ["хорошо"]);
    }

    #[test]
    fn code_and_generated_parts_of_a_page_are_left_out() {
        let page = "old\n```sh\nold\n```\na `old` b\n<!-- t:begin -->\nold\n<!-- t:end -->\nold\n";
        let with: Vec<usize> = prose(page)
            .into_iter()
            .filter(|(_, text)| !hits(text).is_empty())
            .map(|(number, _)| number)
            .collect();
        assert_eq!(with, [1, 9]);
    }

    #[test]
    fn comments_and_texts_of_code_are_checked() {
        let quotes = ['"', '\'', '`'];
        for checked in
            ["// old", " * old", "let a = 1; // old", "t('the old one')", "a('x', \"old b\")"]
        {
            assert_eq!(hits(&of_source(checked, &quotes)), ["new"], "{checked}");
        }
        for left in [
            "let old = 1;",
            "t('page.old')",
            "old / 2",
            "'http://a' + old",
            "`<p class=\"old\"> ${old(1)}`",
        ] {
            assert_eq!(hits(&of_source(left, &quotes)), [""; 0], "{left}");
        }
    }

    #[test]
    fn texts_and_comments_of_a_catalogue_are_checked() {
        let lines =
            ["# old", "a = an old one", "a = вышло так себе", "    old = 1", "a = { $a } old"];
        for checked in lines {
            assert_eq!(hits(&catalogue(checked)[0].1).len(), 1, "{checked}");
        }
        for left in ["old = 1", "a = { $old }", "a = bold"] {
            assert_eq!(hits(&catalogue(left)[0].1), [""; 0], "{left}");
        }
    }

    #[test]
    fn the_areas_of_the_project_are_clean() {
        assert_eq!(check(), Ok(()));
    }
}
