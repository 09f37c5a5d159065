//! Parses Rust files just far enough to tell code, comments and tests apart.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::run;

/// A Rust file of the workspace.
pub struct File {
    /// Path from the root, with `/`.
    pub path: String,
    pub lines: Vec<Line>,
}

/// A line of a Rust file.
#[derive(Default)]
pub struct Line {
    /// Its code; string and character literals are emptied.
    pub code: String,
    /// Text of its comments.
    pub comment: String,
    /// The whole text.
    pub text: String,
    /// Whether it belongs to a test.
    pub test: bool,
}

impl File {
    /// Folder of its crate, such as `proto`; `None` outside `crates/`.
    pub fn crate_name(&self) -> Option<&str> {
        self.path.strip_prefix("crates/")?.split('/').next()
    }

    /// Lines of the product with their numbers.
    pub fn product(&self) -> impl Iterator<Item = (usize, &Line)> {
        self.numbered().filter(|(_, line)| !line.test)
    }

    /// All lines with their numbers.
    pub fn numbered(&self) -> impl Iterator<Item = (usize, &Line)> {
        self.lines.iter().enumerate().map(|(index, line)| (index + 1, line))
    }
}

/// All Rust files of the workspace, with the tests marked.
pub fn workspace() -> Result<Vec<File>, String> {
    let mut files = Vec::new();
    for folder in ["crates", "xtask"] {
        for path in files_under(&run::root().join(folder), "rs")? {
            let path = relative(&path);
            let lines = lines(&run::read(&path)?);
            files.push(File { path, lines });
        }
    }
    mark_test_files(&mut files);
    Ok(files)
}

/// Files with this extension in a folder, sorted, without build output and hidden folders.
pub fn files_under(folder: &Path, extension: &str) -> Result<Vec<PathBuf>, String> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        let entries = std::fs::read_dir(&folder)
            .map_err(|e| format!("cannot read {}: {e}", relative(&folder)))?;
        for entry in entries {
            let path = entry.map_err(|e| format!("cannot read {}: {e}", relative(&folder)))?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() {
                if !name.starts_with('.') && !name.starts_with("target") && name != "node_modules" {
                    open.push(path);
                }
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// A path from the workspace root, with `/`.
pub fn relative(path: &Path) -> String {
    path.strip_prefix(run::root()).unwrap_or(path).to_string_lossy().replace('\\', "/")
}

/// Splits a Rust text into lines and marks those under `#[cfg(test)]` or `#[test]`.
pub fn lines(text: &str) -> Vec<Line> {
    let mut lines = split(text);
    mark_test_items(&mut lines);
    lines
}

#[derive(Clone, Copy)]
enum Mode {
    Code,
    LineComment,
    BlockComment(usize),
    /// In a string; a raw string ends at a quote and this many `#`.
    Text(Option<usize>),
}

fn split(text: &str) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut mode = Mode::Code;
    for raw in text.lines() {
        let mut line = Line { text: raw.into(), ..Line::default() };
        let chars: Vec<char> = raw.chars().collect();
        let mut at = 0;
        while at < chars.len() {
            let taken;
            (mode, taken) = step(mode, &chars, at, &mut line);
            at += taken;
        }
        if matches!(mode, Mode::LineComment) {
            mode = Mode::Code;
        }
        lines.push(line);
    }
    lines
}

/// Continues from `at`; returns the new mode and the number of characters consumed.
fn step(mode: Mode, chars: &[char], at: usize, line: &mut Line) -> (Mode, usize) {
    let rest = &chars[at..];
    match mode {
        Mode::LineComment => {
            line.comment.extend(rest);
            (Mode::LineComment, rest.len())
        }
        Mode::BlockComment(depth) => match rest {
            ['*', '/', ..] if depth == 1 => (Mode::Code, 2),
            ['*', '/', ..] => (Mode::BlockComment(depth - 1), 2),
            ['/', '*', ..] => (Mode::BlockComment(depth + 1), 2),
            _ => {
                line.comment.push(rest[0]);
                (mode, 1)
            }
        },
        Mode::Text(None) => match rest {
            ['\\', _, ..] => (mode, 2),
            ['"', ..] => (Mode::Code, 1),
            _ => (mode, 1),
        },
        Mode::Text(Some(hashes)) => {
            let closes =
                rest[0] == '"' && rest.len() > hashes && rest[1..=hashes].iter().all(|&c| c == '#');
            if closes { (Mode::Code, 1 + hashes) } else { (mode, 1) }
        }
        Mode::Code => code_step(chars, at, line),
    }
}

fn code_step(chars: &[char], at: usize, line: &mut Line) -> (Mode, usize) {
    let rest = &chars[at..];
    match rest {
        ['/', '/', ..] => (Mode::LineComment, 2),
        ['/', '*', ..] => (Mode::BlockComment(1), 2),
        ['"', ..] => {
            line.code += "\"\"";
            (Mode::Text(None), 1)
        }
        ['r', '"' | '#', ..] if !is_word_before(chars, at) => {
            let hashes = rest[1..].iter().take_while(|&&c| c == '#').count();
            if rest.get(1 + hashes) == Some(&'"') {
                line.code += "\"\"";
                (Mode::Text(Some(hashes)), 2 + hashes)
            } else {
                line.code.push('r');
                (Mode::Code, 1)
            }
        }
        // A character, not a lifetime.
        ['\'', '\\', _, tail @ ..] => {
            line.code += "' '";
            let to_quote = tail.iter().position(|&c| c == '\'').unwrap_or(tail.len());
            (Mode::Code, (3 + to_quote + 1).min(rest.len()))
        }
        ['\'', _, '\'', ..] => {
            line.code += "' '";
            (Mode::Code, 3)
        }
        _ => {
            line.code.push(rest[0]);
            (Mode::Code, 1)
        }
    }
}

/// Whether the `r` at `at` ends a word, so that it starts no raw string; `br` and `cr` do.
fn is_word_before(chars: &[char], at: usize) -> bool {
    let word = |c: &char| c.is_alphanumeric() || *c == '_';
    let before: Vec<&char> = chars[..at].iter().rev().take_while(|c| word(c)).collect();
    !matches!(before.as_slice(), [] | ['b'] | ['c'])
}

/// Marks every item under `#[cfg(test)]` or `#[test]`, or the whole file under `#![cfg(test)]`.
fn mark_test_items(lines: &mut [Line]) {
    let mut at = 0;
    while at < lines.len() {
        let code = &lines[at].code;
        if code.contains("#![cfg(test)]") {
            lines.iter_mut().for_each(|line| line.test = true);
            return;
        }
        let attribute = ["#[cfg(test)]", "#[cfg(any(test", "#[cfg(all(test", "#[test]"];
        match attribute.iter().filter_map(|a| code.find(a)).min() {
            Some(column) => {
                let end = item_end(lines, at, column);
                lines[at..=end].iter_mut().for_each(|line| line.test = true);
                at = end + 1;
            }
            None => at += 1,
        }
    }
}

/// Index of the last line of the item that starts, with its attributes, at this line and column.
pub fn item_end(lines: &[Line], first: usize, column: usize) -> usize {
    let mut depth = 0_usize;
    for (index, line) in lines.iter().enumerate().skip(first) {
        let skip = if index == first { column } else { 0 };
        for c in line.code.get(skip..).unwrap_or_default().chars() {
            match c {
                '(' | '[' | '{' => depth += 1,
                ')' | ']' => depth = depth.saturating_sub(1),
                '}' => {
                    depth = depth.saturating_sub(1);
                    if depth == 0 {
                        return index;
                    }
                }
                ';' if depth == 0 => return index,
                _ => {}
            }
        }
    }
    lines.len() - 1
}

/// Marks files that are tests as a whole: under `tests/`, or modules declared in test code.
fn mark_test_files(files: &mut [File]) {
    let mut modules: HashSet<String> = HashSet::new();
    for file in files.iter() {
        modules.extend(test_modules(file));
    }
    for file in files {
        let in_tests = file.path.split('/').nth(2) == Some("tests");
        let declared = modules.iter().any(|module| {
            let rest = file.path.strip_prefix(module.as_str());
            rest.is_some_and(|rest| rest == ".rs" || rest.starts_with('/'))
        });
        if in_tests || declared {
            file.lines.iter_mut().for_each(|line| line.test = true);
        }
    }
}

/// Paths, without `.rs`, of the modules that a file declares in its test code.
fn test_modules(file: &File) -> Vec<String> {
    let stem = file.path.trim_end_matches(".rs");
    let (folder, name) = stem.rsplit_once('/').unwrap_or(("", stem));
    let base = if matches!(name, "lib" | "main" | "mod") { folder } else { stem };
    let declared = file.lines.iter().filter(|line| line.test).filter_map(|line| {
        let words: Vec<&str> = line.code.split_whitespace().collect();
        let at = words.iter().position(|&word| word == "mod")?;
        words.get(at + 1)?.strip_suffix(';')
    });
    declared.map(|module| format!("{base}/{module}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test_lines(text: &str) -> Vec<usize> {
        lines(text).iter().enumerate().filter(|(_, l)| l.test).map(|(i, _)| i + 1).collect()
    }

    #[test]
    fn code_and_comments_come_apart() {
        let lines = lines("let a = \"// §1\"; // §2 \"x\"\n/* §3 /* in */ still\nover */ let b;\n");
        assert_eq!(lines[0].code, "let a = \"\"; ");
        assert_eq!(lines[0].comment, " §2 \"x\"");
        assert_eq!(lines[1].comment, " §3  in  still");
        assert_eq!(lines[2].code, " let b;");
    }

    #[test]
    fn quotes_of_every_kind_end_where_they_end() {
        let text = r####"a(r#"x " // y"#); b('"', '\'', '\u{7f}'); f::<'a>(br"\"); g() // end"####;
        let lines = lines(text);
        assert_eq!(lines[0].code, "a(\"\"); b(' ', ' ', ' '); f::<'a>(b\"\"); g() ");
        assert_eq!(lines[0].comment, " end");
    }

    #[test]
    fn a_string_goes_on_over_lines() {
        let lines = lines("let a = \"one \\\n  // two\"; b();\n");
        assert_eq!(lines[1].code, "; b();");
        assert_eq!(lines[1].comment, "");
    }

    #[test]
    fn test_items_are_marked_to_their_end() {
        let text = "fn a() {}\n#[cfg(test)]\nmod tests {\n    fn b() { \"}\"; }\n}\nfn c() {}\n";
        assert_eq!(test_lines(text), [2, 3, 4, 5]);
        assert_eq!(test_lines("#[cfg(test)]\nextern crate std;\nfn c() {}\n"), [1, 2]);
        assert_eq!(test_lines("#[cfg(test)]\nconst A: [u8; 2] = [0; 2];\nfn c() {}\n"), [1, 2]);
        assert_eq!(test_lines("a();\n#[test]\n#[ignore]\nfn c() {\n}\nfn d() {}\n"), [2, 3, 4, 5]);
        assert_eq!(test_lines("#![cfg(test)]\nfn c() {}\n"), [1, 2]);
        assert_eq!(test_lines("#![cfg_attr(not(test), deny(x))]\nfn c() {}\n"), [0; 0]);
    }

    #[test]
    fn modules_declared_in_tests_are_tests() {
        let file = |path: &str, text: &str| File { path: path.into(), lines: lines(text) };
        let mut files = [
            file("crates/a/src/lib.rs", "mod b;\n#[cfg(test)]\nmod scenarios;\n"),
            file("crates/a/src/b.rs", "fn b() {}\n#[cfg(test)]\nmod cases;\n"),
            file("crates/a/src/b/cases.rs", "fn c() {}\n"),
            file("crates/a/src/scenarios/one.rs", "fn c() {}\n"),
            file("crates/a/tests/all.rs", "fn c() {}\n"),
            file("crates/a/src/scenarios_of_use.rs", "fn c() {}\n"),
        ];
        mark_test_files(&mut files);
        let marked: Vec<bool> = files.iter().map(|f| f.lines.iter().all(|l| l.test)).collect();
        assert_eq!(marked, [false, false, true, true, true, false]);
    }
}
