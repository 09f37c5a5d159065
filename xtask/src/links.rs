//! Checks the relative links of the Markdown files, with their anchors.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use crate::{run, source};

/// Every broken relative link.
pub fn broken() -> Result<Vec<String>, String> {
    let root = run::root();
    let mut problems = Vec::new();
    for path in source::files_under(&root, "md")? {
        let path = source::relative(&path);
        let text = run::read(&path)?;
        for (number, target) in links(&text) {
            if let Err(why) = resolve(&path, &text, &target, &root) {
                problems.push(format!("{path}:{number}: {target}: {why}"));
            }
        }
    }
    Ok(problems)
}

fn resolve(from: &str, text: &str, target: &str, root: &Path) -> Result<(), String> {
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    if file.is_empty() {
        return has_anchor(text, anchor);
    }
    let folder = Path::new(from).parent().unwrap_or(Path::new(""));
    let inside = plain(&folder.join(file)).ok_or("leads out of the project")?;
    let path = root.join(inside);
    if !path.exists() {
        return Err("no such file".into());
    }
    if anchor.is_empty() || path.extension().is_none_or(|extension| extension != "md") {
        return Ok(());
    }
    let text = std::fs::read_to_string(&path).map_err(|e| e.to_string())?;
    has_anchor(&text, anchor)
}

fn has_anchor(text: &str, anchor: &str) -> Result<(), String> {
    let known = anchors(text);
    if known.iter().any(|known| known == anchor) { Ok(()) } else { Err("no such heading".into()) }
}

/// The path without `.` and `..`; `None` if it leaves the project.
fn plain(path: &Path) -> Option<PathBuf> {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(name) => plain.push(name),
            Component::CurDir => {}
            Component::ParentDir => plain.pop().then_some(())?,
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(plain)
}

/// Lines outside fenced code, with their numbers.
pub fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut fenced = false;
    text.lines().enumerate().filter_map(move |(index, line)| {
        let fence = is_fence(line);
        fenced ^= fence;
        (!fenced && !fence).then_some((index + 1, line))
    })
}

/// Whether a line opens or closes a fenced code block.
pub fn is_fence(line: &str) -> bool {
    line.trim_start().starts_with("```")
}

/// Relative targets of `[text](target)`, `[text]: target`, `src="target"` and `href="target"`.
fn links(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in prose(text) {
        let line = without_code(line);
        let mut targets: Vec<&str> = Vec::new();
        for (opening, closing) in [("](", ')'), ("src=\"", '"'), ("href=\"", '"')] {
            for (at, sign) in line.match_indices(opening) {
                targets.extend(line[at + sign.len()..].split(closing).next());
            }
        }
        if line.starts_with('[') {
            targets.extend(line.split_once("]: ").map(|(_, target)| target));
        }
        let relative = targets.into_iter().filter_map(|target| {
            let target = target.split_whitespace().next()?.trim_matches(['<', '>']);
            let absolute = target.contains("://") || target.starts_with("mailto:");
            (!absolute).then(|| (number, target.to_string()))
        });
        found.extend(relative);
    }
    found
}

/// The line without text in backquotes.
fn without_code(line: &str) -> String {
    let parts: Vec<&str> = line.split('`').collect();
    let last = parts.len() - 1;
    let kept = parts.iter().enumerate().filter(|(i, _)| i % 2 == 0 || (*i == last));
    kept.map(|(_, part)| *part).collect::<Vec<_>>().join("``")
}

/// The anchors of a page: its headings in GitHub's form, and explicit ones.
fn anchors(text: &str) -> Vec<String> {
    let mut anchors = Vec::new();
    let mut seen: HashMap<String, usize> = HashMap::new();
    for (_, line) in prose(text) {
        for opening in ["id=\"", "name=\""] {
            let found = line.match_indices(opening).map(|(at, sign)| &line[at + sign.len()..]);
            anchors.extend(found.filter_map(|rest| rest.split('"').next()).map(String::from));
        }
        let title = line.trim_start_matches('#');
        if title.len() == line.len() || !title.starts_with(' ') {
            continue;
        }
        let slug = slug(title.trim());
        let times = seen.entry(slug.clone()).or_default();
        anchors.push(if *times == 0 { slug } else { format!("{slug}-{times}") });
        *times += 1;
    }
    anchors
}

fn slug(title: &str) -> String {
    // Only the text of a link in a heading counts.
    let mut text = String::new();
    for (index, part) in title.split("](").enumerate() {
        let rest = if index == 0 { part } else { part.split_once(')').map_or("", |(_, r)| r) };
        text += rest;
    }
    let kept = text.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>().to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_of_every_form_are_found() {
        let text = "[a](b.md) ![p](img/x.png \"title\") <img src=\"y.png\"> `[no](no.md)`\n\
                    ```\n[no](no.md)\n```\n[ref]: c.md\n[web](https://example.org) [d](#here)\n";
        let targets: Vec<String> = links(text).into_iter().map(|(_, target)| target).collect();
        assert_eq!(targets, ["b.md", "img/x.png", "y.png", "c.md", "#here"]);
        assert_eq!(links(text)[3].0, 5);
    }

    #[test]
    fn headings_become_anchors() {
        let text = "# §3.1 Move: a drive\n## Ход\n## Ход\n```\n# no\n```\n### [Link](x.md) `code`\n\
                    <a id=\"own\"></a>\n#tag\n";
        assert_eq!(anchors(text), ["31-move-a-drive", "ход", "ход-1", "link-code", "own"]);
    }

    #[test]
    fn paths_stay_in_the_project() {
        assert_eq!(plain(Path::new("docs/../README.md")), Some(PathBuf::from("README.md")));
        assert_eq!(plain(Path::new("docs/../../x")), None);
        assert_eq!(plain(Path::new("/etc/x")), None);
    }

    #[test]
    fn what_leads_nowhere_is_said() {
        let root = run::root();
        assert_eq!(resolve("docs/a.md", "", "../xtask/Cargo.toml", &root), Ok(()));
        assert_eq!(resolve("docs/a.md", "", "none.md", &root), Err("no such file".into()));
        assert_eq!(resolve("docs/a.md", "# One\n", "#one", &root), Ok(()));
        assert_eq!(resolve("docs/a.md", "# One\n", "#two", &root), Err("no such heading".into()));
    }
}
