//! What is refused when the catalogues are compiled, and what becomes of them.

use crate::catalogue::{Catalogue, Source, type_name};
use crate::rust;

fn source(language: &str, area: &str, text: &str) -> Source {
    Source { language: language.to_owned(), area: area.to_owned(), text: text.to_owned() }
}

fn read(en: &str, ru: &str) -> Result<Catalogue, Vec<String>> {
    Catalogue::read(&[source("en", "a", en), source("ru", "a", ru)])
}

/// The only problem.
fn problem(en: &str, ru: &str) -> String {
    let problems = read(en, ru).unwrap_err();
    assert_eq!(problems.len(), 1, "{problems:?}");
    problems[0].clone()
}

const EN: &str = "# Why\n## Group\nlost = no { $what } for { $n } s\n\nall = all\n";
const RU: &str = "all = все\nlost = { $n } с нет { $what }\n";

#[test]
fn what_is_right_is_read_in_the_order_of_the_first_language() {
    let catalogue = read(EN, RU).unwrap();
    assert_eq!(catalogue.languages, ["en", "ru"]);
    let messages = &catalogue.areas["a"];
    assert_eq!(messages[0].key, "lost");
    assert_eq!(messages[0].arguments, ["what", "n"]);
    assert_eq!(messages[1].key, "all");
    assert_eq!(messages.len(), 2);
}

#[test]
fn every_key_is_in_every_language() {
    let one = RU.replace("all = все\n", "");
    assert_eq!(problem(EN, &one), "ru/a.ftl: no text for all");
    let more = format!("{RU}none = ни одного\n");
    assert_eq!(problem(EN, &more), "ru/a.ftl: none: en/a.ftl has no such key");
    let twice = format!("{RU}all = все\n");
    assert_eq!(problem(EN, &twice), "ru/a.ftl: all: another key has the same name");
}

/// A folder with one file too few or too many is a folder with keys too few or too many.
#[test]
fn every_file_is_in_every_language() {
    let mut sources = vec![source("en", "a", "all = all\n"), source("ru", "a", "all = все\n")];
    sources.push(source("de", "a", "all = alle\n"));
    assert_eq!(Catalogue::read(&sources).unwrap().languages, ["en", "de", "ru"]);
    sources.push(source("ru", "b", "all = все\n"));
    let problems = Catalogue::read(&sources).unwrap_err();
    assert_eq!(problems, ["ru/b.ftl: all: en/b.ftl has no such key"]);
    let without = [source("en", "a", "all = all\n"), source("de", "b", "")];
    assert_eq!(Catalogue::read(&without).unwrap_err(), ["de/a.ftl: no text for all"]);
}

#[test]
fn every_language_has_the_same_arguments() {
    let fewer = RU.replace("{ $n } с", "Давно");
    assert!(
        problem(EN, &fewer).contains("lost has the arguments [\"what\"], in en [\"what\", \"n\"]")
    );
    let other = RU.replace("$n", "$m");
    assert!(problem(EN, &other).contains("lost has the arguments [\"m\", \"what\"]"));
    let more = RU.replace("все", "все { $n }");
    assert!(problem(EN, &more).contains("all has the arguments [\"n\"], in en []"));
    let again =
        RU.replace("все", "все, все").replace("с нет { $what }", "с нет { $what }, { $what }");
    assert!(read(EN, &again).is_ok());
}

#[test]
fn letters_of_another_language_are_refused() {
    assert!(problem(&EN.replace("all = all", "all = всё"), RU).contains("Russian letters"));
    assert!(problem(EN, &RU.replace("все", "all")).contains("is it translated"));
    // A Latin `c` that looks like the Russian one.
    assert!(problem(EN, &RU.replace("все", "вcе")).contains("“вcе” has Latin and Russian letters"));
    // Names of the protocol and of keys stay as they are; so does what has no letters.
    assert!(read(EN, &RU.replace("все", "все `zones`, Stop")).is_ok());
    assert!(read("all = { $a } °\n", "all = { $a } °\n").is_ok());
    assert!(read("unit = ×0.1 °C\n", "unit = ×0,1 °C\n").is_ok());
}

#[test]
fn what_is_not_compiled_is_refused() {
    let both = |text: &str| read(text, text).unwrap_err().concat();
    assert!(both("n = { $n ->\n    [one] 1\n   *[other] 2\n}\n").contains("selectors"));
    assert!(both("n = { NUMBER($n) }\n").contains("only { $argument }"));
    assert!(both("n = { other.part }\nother = 1\n").contains("only { $argument }"));
    assert!(both("-n = 1\n").contains("terms"));
    assert!(both("n = 1\n    .tip = 2\n").contains("attributes"));
    assert!(both("n = { $n\nm = 1\n").contains("a.ftl:"));
}

/// What two rows of a table share is written once.
#[test]
fn a_text_may_refer_to_another() {
    let text = |n: &str| format!("a = {n}\nb = {n}, {{ a }}\n");
    let catalogue = read(&text("one"), &text("один")).unwrap();
    let [a, b] = &catalogue.areas["a"][..] else { panic!("{catalogue:?}") };
    assert_eq!((a.key.as_str(), b.key.as_str()), ("a", "b"));
    let module = rust::module(&catalogue);
    assert!(module.contains("\"one, one\"") && module.contains("\"один, один\""), "{module}");
    let both = |text: &str| read(text, text).unwrap_err().concat();
    assert!(both("a = { b }\n").contains("b is no text here"));
    assert!(both("a = { b }\nb = { c }\nc = 1\n").contains("a: b is no text here"));
    assert!(both("a = { a }\n").contains("a: a is no text here"));
}

#[test]
fn names_that_are_none_in_rust_are_refused() {
    let both = |text: &str| read(text, text).unwrap_err().concat();
    assert!(both("Big = 1\n").contains("a key is of small letters"));
    assert!(both("a--b = 1\n").contains("a key is of small letters"));
    assert!(both("a = { $Big }\n").contains("an argument is of small letters"));
    assert!(both("a = { $type }\n").contains("an argument is of small letters"));
    assert!(both("self = 1\n").contains("a key is of small letters"));
    assert!(read("move = move\n", "move = двигать\n").is_ok());
    assert!(both("a-b1 = 1\na-b-1 = 2\n").contains("another key has the same name"));
    let folder = [source("pt-br", "a", "")];
    assert!(Catalogue::read(&folder).unwrap_err().concat().contains("pt-br"));
    assert_eq!(type_name("flow-at-1-mpa"), "FlowAt1Mpa");
    assert_eq!(type_name("field-Quench-centre_h"), "FieldQuenchCentreH");
    assert!(read("flag-TrajectoryCRCFault = 1\n", "flag-TrajectoryCRCFault = 1\n").is_ok());
}

/// A third language is a folder: it becomes a variant and a field.
#[test]
fn a_folder_is_a_language() {
    let sources = ["en", "ru", "de"].map(|language| {
        let text = if language == "ru" { "all = все { $n }\n" } else { "all = all { $n }\n" };
        source(language, "a", text)
    });
    let module = rust::module(&Catalogue::read(&sources).unwrap());
    for part in [
        "pub const ALL: [Self; 3] = [Self::En, Self::De, Self::Ru]",
        "pub de: String,",
        "Lang::De => &[Piece::Text(\"all \"), Piece::Argument(0)]",
        "pub struct All<A0> {",
        "pub de: &'static str,",
        "Lang::De => self.de,",
    ] {
        assert!(module.contains(part), "{part}\n{module}");
    }
}

#[test]
fn quotes_braces_and_blanks() {
    let text = "a = {\" \"}say \"a\\b\" {\"{\"}{\"}\"}\n";
    let module = rust::module(&Catalogue::read(&[source("en", "a", text)]).unwrap());
    assert!(module.contains(r#"Lang::En => " say \"a\\b\" {}","#), "{module}");
    let lines = "a =\n    one\n    two\n";
    let module = rust::module(&Catalogue::read(&[source("en", "a", lines)]).unwrap());
    assert!(module.contains(r#"Lang::En => "one\ntwo","#), "{module}");
}
