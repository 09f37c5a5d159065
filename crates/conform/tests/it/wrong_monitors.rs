//! The wrong monitors: each is caught by a test of the statement that it violates.
//!
//! They are listed in `docs/wrong-monitors.md`. When this test reports it as out of date, run it
//! with `UPDATE=1`.

use std::fmt::Write;

use crate::support::{BOARD, SimLine, monitor};
use crate::wrong::{self, Breaking, Wrong};
use lafet_client::Lang;
use lafet_conform::{Level, Options, Outcome, Report, report, run};

/// Items that can be observed only after the memory has been erased.
const ERASED: [&str; 5] = ["§3.19", "§3.3.1/2", "§3.4/3", "§3.5/6", "§3.6/1"];
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
const LIST: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/wrong-monitors.md");
/// Pages that give the number of wrong monitors.
const PAGES: [&str; 4] =
    ["docs/overview.md", "docs/overview.ru.md", "docs/conform.md", "docs/conform.ru.md"];

/// Tests a wrong monitor against the statement that it violates.
fn tested(wrong: &Wrong) -> Report {
    let mut line = SimLine::new(monitor(wrong.profile), Breaking::new(wrong.rule));
    let erased = ERASED.iter().any(|item| wrong.item.starts_with(item));
    let (level, only) = match erased {
        true => (Level::Erase, ERASED.map(str::to_owned).to_vec()),
        false => (Level::Full, vec![wrong.item.to_owned()]),
    };
    let board = Some(BOARD.to_owned());
    let options = Options { level, only, board, strict: true, ..Options::default() };
    let report = run(&mut line, &options, &mut |_| {});
    if !report.tests.is_empty() {
        return report;
    }
    // A monitor that falsely reports flow is not moved; reads find the reason.
    let options = Options { level: Level::ReadOnly, ..options };
    let mut line = SimLine::new(monitor(wrong.profile), Breaking::new(wrong.rule));
    run(&mut line, &options, &mut |_| {})
}

/// Names of the tests of that statement that failed.
fn caught_by(wrong: &Wrong, report: &Report) -> Vec<&'static str> {
    let of_item = report.failures().filter(|test| test.item == wrong.item);
    of_item.map(|test| test.name).collect()
}

/// Whether a text shows values as the program has them.
fn is_of_rust(text: &str) -> bool {
    ["Frame {", "Broken(", "Some(", "SubsystemId("].iter().any(|it| text.contains(it))
}

fn list(caught: &[(Wrong, Vec<&str>)]) -> String {
    let mut text = format!(
        "# Wrong monitors\n\n\
         {} of {} wrong monitors are caught by `lafet conform`, each by a test of the statement that \
         it breaks. They are the simulated monitor with one rule broken, in \
         [crates/conform/tests/it/wrong](../crates/conform/tests/it/wrong); \
         `cargo test -p lafet-conform --test it wrong_monitors::` \
         runs them on virtual time and compares this list. The right monitor passes every one of these tests \
         (`--test it profiles::`).\n\n\
         | § | what is wrong with it | caught by |\n|---|---|---|\n",
        caught.iter().filter(|(_, by)| !by.is_empty()).count(),
        caught.len(),
    );
    for (wrong, by) in caught {
        let _ = writeln!(text, "| {} | {} | {} |", wrong.item, wrong.name, by.join(", "));
    }
    text
}

#[test]
fn each_is_caught_by_its_statement() {
    let all = wrong::all();
    assert!(all.len() >= 100, "{}", all.len());
    let caught: Vec<(Wrong, Vec<&str>)> = all
        .into_iter()
        .map(|wrong| {
            let report = tested(&wrong);
            let by = caught_by(&wrong, &report);
            let odd = report.failures().find(|test| is_of_rust(&test.found.en));
            assert!(odd.is_none(), "{}: {odd:?}", wrong.name);
            assert!(by.is_empty() || matches!(report.exit_code(), 1 | 4), "{}", wrong.name);
            (wrong, by)
        })
        .collect();
    let missed: Vec<String> = caught
        .iter()
        .filter(|(_, by)| by.is_empty())
        .map(|(wrong, _)| format!("{} {}: {}", wrong.item, wrong.name, why_not(wrong)))
        .collect();
    assert!(missed.is_empty(), "{} not caught:\n{}", missed.len(), missed.join("\n"));
    let text = list(&caught);
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(LIST, &text).expect("the list can be written");
    }
    for page in PAGES {
        let [en, ru] = ["of", "из"].map(|of| format!("{0} {of} {0}", caught.len()));
        let text = std::fs::read_to_string(format!("{ROOT}/{page}")).unwrap_or_default();
        assert!(text.contains(&en) || text.contains(&ru), "{page}: {en}");
    }
    let kept = std::fs::read_to_string(LIST).unwrap_or_default();
    assert!(kept == text, "docs/wrong-monitors.md is out of date: run this test with UPDATE=1");
}

/// Results of the run, to find out why a monitor was not caught.
fn why_not(wrong: &Wrong) -> String {
    let report = tested(wrong);
    let tests = report.tests.iter().map(|test| {
        format!("{} {} {} {}", test.item, test.name, test.outcome.name(), test.found.en)
    });
    let aborted = report.aborted.as_ref().map(|note| note.en.clone());
    format!("{:?}, {aborted:?}", tests.collect::<Vec<_>>())
}

/// Names are unique within an item, and every item exists.
#[test]
fn each_has_its_own_name() {
    let all = wrong::all();
    for (index, wrong) in all.iter().enumerate() {
        assert!(
            all[..index].iter().all(|other| (other.item, other.name) != (wrong.item, wrong.name)),
            "{}",
            wrong.name
        );
        assert!(lafet_conform::spec::item(wrong.item).is_some(), "{}", wrong.item);
    }
}

/// The layer that breaks rules lets the correct monitor pass.
#[test]
fn nothing_broken_nothing_caught() {
    let right = wrong::wrong("§1/10", "nothing", wrong::Rule::Request(|_, _| {}));
    let mut line = SimLine::new(monitor(right.profile), Breaking::new(right.rule));
    let options = Options { level: Level::Erase, strict: true, ..Options::default() };
    let report = run(&mut line, &options, &mut |_| {});
    assert!(report.is_good(), "{:?}", report.failures().map(|test| test.name).collect::<Vec<_>>());
    assert!(report.count(Outcome::Pass) > 150);
}

/// Each form of the report shows the failure with its statement and its bytes, and is well formed.
#[test]
fn reports_show_the_failure() {
    let wrong = wrong::all().into_iter().find(|wrong| wrong.item == "§3.7").expect("one of §3.7");
    let found = tested(&wrong);
    assert_eq!(found.exit_code(), 1);
    let text = report::text(&found, Lang::En);
    assert!(text.contains("§3.7: RetrieveLimits 0x80") && text.contains("> FF C0 01 81"), "{text}");
    let russian = report::text(&found, Lang::Ru);
    assert!(russian.contains("ожидалось: int32 min и max"), "{russian}");
    let json = report::json(&found, Lang::En);
    assert_eq!((&json["good"], &json["failed"]), (&false.into(), &2.into()), "{json}");
    let xml = report::junit(&found, Lang::En);
    assert!(xml.contains("failures=\"2\"") && xml.contains("&gt; FF C0"), "{xml}");
    let page = report::html(&found, Lang::Ru);
    assert!(page.contains("Есть ошибки") && page.contains("&gt; FF C0"), "{page}");
    for text in [&xml, &page] {
        for tag in ["testcase", "failure", "tr", "td", "details", "pre", "table"] {
            let opened = text.matches(&format!("<{tag}>")).count()
                + text.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, text.matches(&format!("</{tag}>")).count(), "{tag}");
        }
    }
}
