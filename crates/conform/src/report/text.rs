//! The report as text for a terminal, as JSON for programs, and as JUnit XML.

use std::fmt::Write;

use lafet_texts::{Lang, Text as _, conform as text};
use serde_json::{Value, json};

use super::{Report, TestReport};
use crate::raw::{self, hex};
use crate::spec;
use crate::verdict::Outcome;

/// Exchanges shown with a failure: the last ones before it.
const SHOWN: usize = 4;

/// Statement of an item.
pub fn statement(id: &str, lang: Lang) -> &'static str {
    spec::item(id).map_or("", |item| item.text.str(lang))
}

/// Outcome of a test, in one word.
pub const fn word(outcome: Outcome, lang: Lang) -> &'static str {
    match outcome {
        Outcome::Pass => text::Pass.str(lang),
        Outcome::Fail => text::Fail.str(lang),
        Outcome::Differs => text::Differs.str(lang),
        Outcome::NotApplicable => text::NotApplicable.str(lang),
    }
}

/// One line for a test, followed by the details of a failure.
pub fn test_lines(test: &TestReport, lang: Lang) -> String {
    let mut text = format!("{:<11}  {:<8} {}", word(test.outcome, lang), test.item, test.name);
    match test.outcome {
        Outcome::Pass => {}
        Outcome::NotApplicable => {
            let _ = write!(text, ": {}", test.found.of(lang));
        }
        Outcome::Fail | Outcome::Differs => text.push_str(&failure_lines(test, lang)),
    }
    text
}

fn failure_lines(test: &TestReport, lang: Lang) -> String {
    let (expected, found) = (text::Expected.str(lang), text::Found.str(lang));
    let label = test.label.name();
    let mut text = format!("\n    {}: {} [{label}]", test.item, statement(test.item, lang));
    for (what, note) in [(expected, &test.expected), (found, &test.found)] {
        if !note.of(lang).is_empty() {
            let _ = write!(text, "\n    {what}: {}", note.of(lang));
        }
    }
    for exchange in test.log.iter().skip(test.log.len().saturating_sub(SHOWN)) {
        let _ = write!(text, "\n    {:>8} ms  {}", exchange.at_ms, exchange.words);
        let _ =
            write!(text, "\n      > {}\n      < {}", hex(&exchange.sent), hex(&exchange.received));
    }
    text
}

/// Summary of the run.
pub fn summary(report: &Report, lang: Lang) -> String {
    let mut text = text::Summary {
        level: report.level.name(),
        pass: report.count(Outcome::Pass),
        fail: report.count(Outcome::Fail),
        differs: report.count(Outcome::Differs),
        not: report.count(Outcome::NotApplicable),
        frames: report.frames,
        repeats: report.repeats,
        s: report.took_ms / 1000,
    }
    .of(lang);
    let (ended, left) = (text::BrokenOff.str(lang), text::NotRestored.str(lang));
    for (what, note) in [(ended, &report.aborted), (left, &report.not_restored)] {
        if let Some(note) = note {
            let _ = write!(text, "\n{what}: {}", note.of(lang));
        }
    }
    text
}

/// The whole report as text.
pub fn text(report: &Report, lang: Lang) -> String {
    let mut lines: Vec<String> = report.tests.iter().map(|test| test_lines(test, lang)).collect();
    lines.push(summary(report, lang));
    lines.join("\n") + "\n"
}

/// The whole report as JSON; keys are English, sentences in the given language.
pub fn json(report: &Report, lang: Lang) -> Value {
    let count = |outcome| report.count(outcome);
    json!({
        "url": report.url,
        "level": report.level.name(),
        "strict": report.strict,
        "good": report.is_good(),
        "passed": count(Outcome::Pass),
        "failed": count(Outcome::Fail),
        "differ": count(Outcome::Differs),
        "not_applicable": count(Outcome::NotApplicable),
        "frames": report.frames,
        "repeated": report.repeats,
        "took_ms": report.took_ms,
        "subsystems": report.present.iter().map(|id| raw::name(id.name(), id.0)).collect::<Vec<_>>(),
        "aborted": report.aborted.as_ref().map(|note| note.of(lang)),
        "not_restored": report.not_restored.as_ref().map(|note| note.of(lang)),
        "tests": report.tests.iter().map(|test| test_json(test, lang)).collect::<Vec<_>>(),
        "not_tested": report.unseen().iter().map(|unseen| json!({
            "item": unseen.id,
            "statement": statement(unseen.id, lang),
            "reason": unseen.reason.str(lang),
        })).collect::<Vec<_>>(),
    })
}

fn test_json(test: &TestReport, lang: Lang) -> Value {
    let log = test.log.iter().map(|exchange| {
        json!({
            "at_ms": exchange.at_ms,
            "sent": hex(&exchange.sent),
            "received": hex(&exchange.received),
            "words": exchange.words,
        })
    });
    json!({
        "item": test.item,
        "test": test.name,
        "statement": statement(test.item, lang),
        "label": test.label.name(),
        "level": test.level.name(),
        "outcome": test.outcome.name(),
        "expected": test.expected.of(lang),
        "found": test.found.of(lang),
        "took_ms": test.took_ms,
        "log": log.collect::<Vec<_>>(),
    })
}

/// The whole report as JUnit XML, which build servers display. A difference from a ruling of ours
/// is reported as skipped, unless it counts as a failure.
pub fn junit(report: &Report, lang: Lang) -> String {
    let failures = report.failures().count();
    let errors = usize::from(report.aborted.is_some()) + usize::from(report.not_restored.is_some());
    let skipped = report.tests.len() - report.count(Outcome::Pass) - failures;
    let tests = report.tests.len() + errors;
    let seconds = |ms: u64| format!("{}.{:03}", ms / 1000, ms % 1000);
    let mut xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n\
         <testsuite name=\"lafet conform --{} {}\" tests=\"{tests}\" failures=\"{failures}\" \
         errors=\"{errors}\" skipped=\"{skipped}\" time=\"{}\">\n",
        report.level.name(),
        escape(&report.url),
        seconds(report.took_ms),
    );
    for test in &report.tests {
        let _ = write!(
            xml,
            "<testcase classname=\"{}\" name=\"{}\" time=\"{}\">",
            test.item,
            test.name,
            seconds(test.took_ms)
        );
        let told = escape(&failure_lines(test, lang));
        let found = escape(test.found.of(lang));
        let counts = test.outcome == Outcome::Fail || report.strict;
        let _ = match test.outcome {
            Outcome::Pass => Ok(()),
            Outcome::Fail | Outcome::Differs if counts => {
                write!(xml, "<failure message=\"{found}\">{told}\n</failure>")
            }
            _ => write!(xml, "<skipped message=\"{found}\"/>"),
        };
        xml.push_str("</testcase>\n");
    }
    for (name, note) in [("run", &report.aborted), ("put-back", &report.not_restored)] {
        if let Some(note) = note {
            let told = escape(note.of(lang));
            let _ = writeln!(
                xml,
                "<testcase classname=\"lafet\" name=\"{name}\"><error \
                 message=\"{told}\"/></testcase>"
            );
        }
    }
    xml + "</testsuite>\n</testsuites>\n"
}

/// Escapes text for XML and HTML.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c if c.is_control() && c != '\n' && c != '\t' => escaped.push('\u{FFFD}'),
            c => escaped.push(c),
        }
    }
    escaped
}
