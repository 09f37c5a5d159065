//! `cargo xtask spec`: checks that every section of the protocol document has code and a test.

use std::collections::{BTreeMap, BTreeSet};
use std::process::ExitCode;

use crate::citation::{citations, lies_within};
use crate::sections::{self, Own, Row};
use crate::source::{self, File};
use crate::{TaskResult, flag, run};

const SPEC: &str = "crates/conform/src/spec.txt";
const SCENARIOS: &str = "conformance/scenarios";
/// Crates whose product code implements the document's own sections.
const IMPLEMENTATION: [&str; 2] = ["proto", "device"];
/// Where the files are that bear the number of a section.
const IN: [&str; 2] = ["crates/proto/src/", "crates/device/src/"];
/// Columns of the printed table.
const TITLE_WIDTH: usize = 44;
const PLACE_WIDTH: usize = 44;

pub fn spec(arguments: &[String]) -> TaskResult {
    let check = flag(arguments, Some("--check"))?;
    let matrix = matrix()?;
    if !check {
        print!("{}", matrix.table());
        return Ok(ExitCode::SUCCESS);
    }
    report(&matrix).map(|()| ExitCode::SUCCESS)
}

/// The page of all sections, docs/sections.md.
pub fn page() -> Result<String, String> {
    let matrix = matrix()?;
    let files = |section: &Section, usage| {
        matrix.places(&section.id, usage).into_iter().map(file_of).collect()
    };
    let rows: Vec<Row<'_>> = matrix
        .sections
        .iter()
        .map(|section| Row {
            id: &section.id,
            title: &section.title,
            label: &section.label,
            code: files(section, Use::Code),
            tests: files(section, Use::Test),
        })
        .collect();
    Ok(sections::page(&matrix.own(), &rows))
}

/// The file of a place, relative to the root.
fn file_of(place: &str) -> String {
    let file = place.rsplit_once(':').map_or(place, |(file, _)| file);
    let folder = if file.starts_with("scenarios/") { "conformance" } else { "crates" };
    format!("{folder}/{file}")
}

/// Fails with the gaps of the matrix.
pub fn check() -> run::StepResult {
    report(&matrix()?)
}

fn report(matrix: &Matrix) -> run::StepResult {
    let mut holes = matrix.holes();
    holes.extend(matrix.without_files());
    run::verdict("holes in the matrix § × code × test", &holes)?;
    println!("   {}", matrix.totals());
    Ok(())
}

/// A line of spec.txt.
struct Section {
    id: String,
    title: String,
    label: String,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Use {
    Code,
    Test,
    /// Product code of other crates. It implements the sections with letters, which are not the
    /// document's (connections, for example), but not the document's own.
    CodeAround,
    /// A comment in a scenario: it is no test, but what it cites must exist.
    Remark,
}

/// A citation and its place.
struct Mention {
    id: String,
    place: String,
    usage: Use,
}

struct Matrix {
    sections: Vec<Section>,
    mentions: Vec<Mention>,
    /// Files of proto, device and the scenarios, relative to the root.
    files: Vec<String>,
}

fn matrix() -> Result<Matrix, String> {
    let sections = sections_of(&run::read(SPEC)?)?;
    let workspace = source::workspace()?;
    let mut mentions: Vec<Mention> = workspace.iter().flat_map(in_rust).collect();
    let own = |path: &&str| IN.iter().any(|folder| path.starts_with(folder));
    let paths = workspace.iter().map(|file| file.path.as_str());
    let mut files: Vec<String> = paths.filter(own).map(String::from).collect();
    let folder = run::root().join(SCENARIOS);
    for path in source::files_under(&folder, "txt")? {
        let path = source::relative(&path);
        mentions.extend(in_scenario(&path, &run::read(&path)?));
        files.push(path);
    }
    Ok(Matrix { sections, mentions, files })
}

fn sections_of(text: &str) -> Result<Vec<Section>, String> {
    let mut sections: Vec<Section> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let fields: Vec<&str> = line.split('\t').map(str::trim).collect();
        let [id, title, label] = fields[..] else {
            return Err(format!("{SPEC}:{}: want §<TAB>title<TAB>label: {line}", index + 1));
        };
        if citations(id) != [id] {
            return Err(format!("{SPEC}:{}: `{id}` is not a section such as §3.1/4", index + 1));
        }
        if sections.iter().any(|section| section.id == id) {
            return Err(format!("{SPEC}:{}: {id} is listed twice", index + 1));
        }
        sections.push(Section { id: id.into(), title: title.into(), label: label.into() });
    }
    if sections.is_empty() { Err(format!("{SPEC} names no section")) } else { Ok(sections) }
}

fn in_rust(file: &File) -> Vec<Mention> {
    let implements = file.path.contains("/src/")
        && file.crate_name().is_some_and(|name| IMPLEMENTATION.contains(&name));
    // Outside the crates there are only examples of this program, which cite nothing.
    if file.crate_name().is_none() {
        return Vec::new();
    }
    let mut found = Vec::new();
    for (number, line) in file.numbered() {
        let (text, usage) = match line.test {
            true => (&line.text, Use::Test),
            false if implements => (&line.comment, Use::Code),
            false => (&line.comment, Use::CodeAround),
        };
        let place = file.path.strip_prefix("crates/").unwrap_or(&file.path);
        found.extend(mentions(text, usage, &format!("{place}:{number}")));
    }
    found
}

fn in_scenario(path: &str, text: &str) -> Vec<Mention> {
    let place = path.strip_prefix("conformance/").unwrap_or(path);
    let mut found = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let usage = if line.trim_start().starts_with('#') { Use::Remark } else { Use::Test };
        found.extend(mentions(line, usage, &format!("{place}:{}", index + 1)));
    }
    found
}

fn mentions(text: &str, usage: Use, place: &str) -> Vec<Mention> {
    let found = citations(text).into_iter();
    found.map(|id| Mention { id, place: place.into(), usage }).collect()
}

impl Matrix {
    fn places(&self, id: &str, usage: Use) -> Vec<&str> {
        let lettered = id.trim_start_matches('§').starts_with(|c: char| c.is_ascii_uppercase());
        let around = usage == Use::Code && lettered;
        let fits = |m: &&Mention| m.usage == usage || (around && m.usage == Use::CodeAround);
        let mine = self.mentions.iter().filter(|m| m.id == id).filter(fits);
        mine.map(|mention| mention.place.as_str()).collect()
    }

    /// The requests, §3.1 to §3.21, and the flags, §3.3.1 to §3.3.10, with their files.
    fn own(&self) -> Vec<Own> {
        let numbered = |id: &str| id.starts_with("§3.") && !id.contains('/');
        self.sections
            .iter()
            .filter(|section| numbered(&section.id))
            .map(|it| self.own_of(it))
            .collect()
    }

    fn own_of(&self, section: &Section) -> Own {
        let id = &section.id;
        let named = |folder: &str| {
            let files = self.files.iter().filter(|file| file.starts_with(folder));
            let mine = files.filter(|file| sections::number_of(file).as_ref() == Some(id));
            mine.cloned().collect::<Vec<String>>()
        };
        let cited = |usage: Use, folders: &[&str]| {
            let statement =
                |it: &str| it.strip_prefix(id.as_str()).is_some_and(|r| r.starts_with('/'));
            let mine = self.mentions.iter().filter(|it| it.id == *id || statement(&it.id));
            let files = mine.filter(|it| it.usage == usage).map(|it| file_of(&it.place));
            files
                .filter(|file| folders.iter().any(|folder| file.starts_with(folder)))
                .collect::<BTreeSet<String>>()
        };
        let [proto, device] = IN;
        let mut executes = named(device);
        let request = id.matches('.').count() == 1;
        if !request || !executes.is_empty() {
            let mut more = cited(Use::Code, &[device]);
            more.retain(|file| !executes.contains(file));
            executes.extend(more);
        }
        Own {
            id: id.clone(),
            title: section.title.split(':').next().unwrap_or_default().into(),
            proto: named(proto).into_iter().collect(),
            device: executes,
            scenarios: named(SCENARIOS).into_iter().collect(),
            tests: cited(Use::Test, &["crates/proto/", "crates/device/"]),
        }
    }

    /// Requests and flags without a file of their own, and files of a number that there is not.
    fn without_files(&self) -> Vec<String> {
        let mut holes = Vec::new();
        for own in self.own() {
            holes.extend(own.missing().into_iter().map(|what| format!("{}: {what}", own.id)));
        }
        for file in &self.files {
            let Some(id) = sections::number_of(file) else { continue };
            if !self.sections.iter().any(|section| section.id == id) {
                holes.push(format!("{file}: {id} is not in {SPEC}"));
            }
        }
        holes
    }

    /// Sections that lack something, and citations of sections that do not exist.
    fn holes(&self) -> Vec<String> {
        let mut holes = Vec::new();
        for Section { id, title, .. } in &self.sections {
            let missing = match (self.places(id, Use::Code), self.places(id, Use::Test)) {
                (code, test) if code.is_empty() && test.is_empty() => "neither code nor test",
                (code, _) if code.is_empty() => "no code",
                (_, test) if test.is_empty() => "no test",
                _ => continue,
            };
            holes.push(format!("{id}: {missing} ({title})"));
        }
        for (id, places) in self.unknown() {
            holes.push(format!("{id}: not in {SPEC}, yet cited by {}", shorten(&places)));
        }
        holes
    }

    fn unknown(&self) -> BTreeMap<&str, Vec<&str>> {
        let mut unknown: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for Mention { id, place, .. } in &self.mentions {
            if !self.sections.iter().any(|section| lies_within(&section.id, id)) {
                unknown.entry(id).or_default().push(place);
            }
        }
        unknown
    }

    fn table(&self) -> String {
        let mut rows = vec![["§", "title", "label", "code", "tests"].map(String::from)];
        for Section { id, title, label } in &self.sections {
            let code = shorten(&self.places(id, Use::Code));
            let tests = shorten(&self.places(id, Use::Test));
            rows.push([id.clone(), clip(title, TITLE_WIDTH), label.clone(), code, tests]);
        }
        let mut text = String::new();
        for row in &rows {
            let [id, title, label, code, tests] = row;
            let line =
                format!("{id:<9} {title:<TITLE_WIDTH$}  {label:<8}  {code:<PLACE_WIDTH$}  {tests}");
            text += line.trim_end();
            text.push('\n');
        }
        text + "\n" + &self.totals() + "\n"
    }

    fn totals(&self) -> String {
        let count = |usage| {
            self.sections
                .iter()
                .filter(|section| !self.places(&section.id, usage).is_empty())
                .count()
        };
        let total = self.sections.len();
        let (code, test) = (count(Use::Code), count(Use::Test));
        format!("{total} sections and scenarios: {code} with code, {test} with tests")
    }
}

/// The first place and the number of further ones.
fn shorten(places: &[&str]) -> String {
    match places {
        [] => "-".into(),
        [only] => (*only).into(),
        [first, more @ ..] => format!("{first} +{}", more.len()),
    }
}

fn clip(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.into();
    }
    let kept: String = text.chars().take(width - 1).collect();
    kept + "…"
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECTIONS: &str = "# comment\n\n§3.1/1\tA drive moves\tread\n§3.1/2\tDenied\tread\n\
                            §3.3.4\tFlags\tours\n";

    fn matrix(rust: &[(&str, &str)], scenario: &str) -> Matrix {
        let mut mentions = Vec::new();
        for (path, text) in rust {
            let file = File { path: (*path).into(), lines: source::lines(text) };
            mentions.extend(in_rust(&file));
        }
        mentions.extend(in_scenario("conformance/scenarios/3.01-move.txt", scenario));
        let files = rust.iter().map(|(path, _)| (*path).into()).collect();
        Matrix { sections: sections_of(SECTIONS).unwrap(), mentions, files }
    }

    #[test]
    fn a_full_matrix_has_no_hole() {
        let rust = ("crates/device/src/a.rs", "// §3.1/1-2\n//! §3.3.4\n");
        let matrix = matrix(&[rust], "§3.1/1,2\n§3.3.4 and its parent §3.3\n");
        assert_eq!(matrix.holes(), [""; 0]);
        assert_eq!(matrix.totals(), "3 sections and scenarios: 3 with code, 3 with tests");
    }

    #[test]
    fn each_kind_of_hole_is_named() {
        let rust = ("crates/device/src/a.rs", "// §3.1/1\n// §3.99\n");
        let matrix = matrix(&[rust], "given §3.1/2\n");
        assert_eq!(
            matrix.holes(),
            [
                "§3.1/1: no test (A drive moves)",
                "§3.1/2: no code (Denied)",
                "§3.3.4: neither code nor test (Flags)",
                "§3.99: not in crates/conform/src/spec.txt, yet cited by device/src/a.rs:2",
            ]
        );
    }

    /// §3.3.4 has flags, which any file of the device may set; a request needs a file of its number.
    #[test]
    fn a_section_without_its_files_is_a_hole() {
        let rust = [
            ("crates/proto/src/status/s3_03_04_drives.rs", "//! §3.3.4\n"),
            ("crates/device/src/subsystem/drive.rs", "// §3.3.4/1\n"),
            ("crates/device/src/execute/s3_04_getparam.rs", "//! §3.4\n"),
            ("crates/device/tests/it/drive.rs", "//! §3.3.4/2\n"),
        ];
        let mut matrix = matrix(&rust, "");
        matrix
            .mentions
            .iter_mut()
            .filter(|it| it.id == "§3.3.4/2")
            .for_each(|it| it.usage = Use::Test);
        let unknown = "crates/device/src/execute/s3_04_getparam.rs: §3.4 is not in crates/conform/src/spec.txt";
        assert_eq!(matrix.without_files(), ["§3.3.4: no scenario of its number", unknown]);
        matrix.sections.push(Section {
            id: "§3.4".into(),
            title: "GetParam: a".into(),
            label: "read".into(),
        });
        matrix.files.push("conformance/scenarios/3.03.04-drives.txt".into());
        assert_eq!(
            matrix.without_files(),
            [
                "§3.4: no file of its number in crates/proto/src",
                "§3.4: no scenario of its number",
                "§3.4: no test in crates/proto or crates/device",
            ]
        );
        let own = matrix.own();
        assert_eq!(own[0].device, ["crates/device/src/subsystem/drive.rs"]);
        assert_eq!((own[1].id.as_str(), own[1].title.as_str()), ("§3.4", "GetParam"));
    }

    #[test]
    fn a_parent_does_not_count_for_its_scenarios() {
        let matrix = matrix(&[("crates/device/src/a.rs", "// §3.1\n")], "§3.1\n");
        assert!(matrix.holes().iter().any(|h| h.starts_with("§3.1/1: neither")));
    }

    #[test]
    fn of_the_document_only_comments_of_proto_and_device_are_code() {
        let rust = [
            ("crates/device/src/a.rs", "let a = \"§3.1/1\";\n"),
            ("crates/sim/src/a.rs", "// §3.1/1\n"),
            ("crates/proto/build.rs", "// §3.1/1\n"),
        ];
        assert!(matrix(&rust, "").places("§3.1/1", Use::Code).is_empty());
        let client = [("crates/client/src/a.rs", "// §C/1\n")];
        assert_eq!(matrix(&client, "").places("§C/1", Use::Code), ["client/src/a.rs:1"]);
        let rust = [("crates/proto/src/a.rs", "f(); // §3.1/1\n")];
        assert_eq!(matrix(&rust, "").places("§3.1/1", Use::Code), ["proto/src/a.rs:1"]);
    }

    #[test]
    fn tests_count_in_any_crate_and_not_as_code() {
        let text =
            "#[cfg(test)]\nmod tests {\n    // §3.1/1\n    const NAME: &str = \"§3.1/2\";\n}\n";
        let matrix = matrix(&[("crates/device/src/a.rs", text), ("crates/sim/src/a.rs", text)], "");
        assert_eq!(matrix.places("§3.1/1", Use::Test), ["device/src/a.rs:3", "sim/src/a.rs:3"]);
        assert_eq!(matrix.places("§3.1/2", Use::Test).len(), 2);
        assert!(matrix.places("§3.1/1", Use::Code).is_empty());
    }

    #[test]
    fn a_remark_in_a_scenario_is_no_test() {
        let matrix = matrix(&[], "# §3.1/1 and §9\n  case §3.1/2 denied\n");
        assert!(matrix.places("§3.1/1", Use::Test).is_empty());
        assert_eq!(matrix.places("§3.1/2", Use::Test), ["scenarios/3.01-move.txt:2"]);
        assert!(matrix.holes().iter().any(|hole| hole.starts_with("§9: not in")));
    }

    #[test]
    fn spec_txt_is_read_strictly() {
        assert!(sections_of("§3.1/1 no tabs\n").is_err());
        assert!(sections_of("3.1\ttitle\tread\n").is_err());
        assert!(sections_of("§3.1/1-2\ttitle\tread\n").is_err());
        assert!(sections_of("§1\ttitle\tread\n§1\ttitle\tread\n").is_err());
        assert!(sections_of("# nothing\n").is_err());
        assert_eq!(sections_of(SECTIONS).unwrap()[2].label, "ours");
    }

    #[test]
    fn places_are_shortened() {
        assert_eq!(shorten(&[]), "-");
        assert_eq!(shorten(&["a:1"]), "a:1");
        assert_eq!(shorten(&["a:1", "b:2", "c:3"]), "a:1 +2");
        assert_eq!(clip("abcdef", 4), "abc…");
    }
}
