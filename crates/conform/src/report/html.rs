//! The report as a self-contained HTML page, for reading and printing.

use std::fmt::Write;

use lafet_texts::{Lang, conform as text};

use super::text::{escape, statement, summary, word};
use super::{Report, TestReport};
use crate::raw::{self, hex};
use crate::spec::Label;
use crate::verdict::Outcome;

const STYLE: &str = include_str!("report.css");
const OUTCOMES: [Outcome; 4] =
    [Outcome::Fail, Outcome::Differs, Outcome::NotApplicable, Outcome::Pass];

const fn class(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "pass",
        Outcome::Fail => "fail",
        Outcome::Differs => "differs",
        Outcome::NotApplicable => "na",
    }
}

/// The HTML page.
pub fn html(report: &Report, lang: Lang) -> String {
    let title = text::Title.str(lang);
    let mut page = format!(
        "<!doctype html>\n<html lang=\"{}\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>{title}</title>\
         <style>\n{STYLE}</style></head><body><h1>{title}</h1>\n",
        lang.code()
    );
    head(&mut page, report, lang);
    tests(&mut page, report, lang);
    unseen(&mut page, report, lang);
    page.push_str("</body></html>\n");
    page
}

fn head(page: &mut String, report: &Report, lang: Lang) {
    let (class, verdict) = match report.is_good() {
        true => ("pass", text::NothingFailed.str(lang)),
        false => ("fail", text::SomethingFailed.str(lang)),
    };
    let present: Vec<String> = report.present.iter().map(|id| raw::name(id.name(), id.0)).collect();
    let _ = write!(
        page,
        "<p class=\"verdict {class}\">{verdict}</p><p><code>{}</code></p><p>{}</p><p>{}: {}</p>\n<p class=\"counts\">",
        escape(&report.url),
        escape(&summary(report, lang)).replace('\n', "<br>"),
        text::Subsystems.str(lang),
        escape(&present.join(", ")),
    );
    for outcome in OUTCOMES {
        let _ = write!(
            page,
            "<span class=\"{}\">{} {}</span> ",
            self::class(outcome),
            report.count(outcome),
            word(outcome, lang)
        );
    }
    page.push_str("</p>\n");
}

fn tests(page: &mut String, report: &Report, lang: Lang) {
    let _ = writeln!(
        page,
        "<table><thead><tr><th>§</th><th>{}</th><th>{}</th><th>{}</th></tr></thead><tbody>",
        text::Test.str(lang),
        text::Statement.str(lang),
        text::Result.str(lang),
    );
    // Failures come first: they are what the page is opened for.
    for outcome in OUTCOMES {
        for test in report.tests.iter().filter(|test| test.outcome == outcome) {
            row(page, test, lang);
        }
    }
    page.push_str("</tbody></table>\n");
}

fn row(page: &mut String, test: &TestReport, lang: Lang) {
    let ours = match test.label {
        Label::Read => String::new(),
        Label::Observed => format!(" <i>{}</i>", text::Observed.str(lang)),
        Label::Ours => format!(" <i>{}</i>", text::Ours.str(lang)),
    };
    let _ = write!(
        page,
        "<tr class=\"{}\"><td>{}</td><td>{}</td><td>{}{ours}",
        class(test.outcome),
        test.item,
        test.name,
        escape(statement(test.item, lang)),
    );
    for (what, note) in
        [(text::Expected.str(lang), &test.expected), (text::Found.str(lang), &test.found)]
    {
        if !note.of(lang).is_empty() {
            let _ = write!(page, "<br><b>{what}:</b> {}", escape(note.of(lang)));
        }
    }
    if !test.log.is_empty() {
        log(page, test, lang);
    }
    let _ = writeln!(page, "</td><td>{}</td></tr>", word(test.outcome, lang));
}

fn log(page: &mut String, test: &TestReport, lang: Lang) {
    let open = if matches!(test.outcome, Outcome::Fail | Outcome::Differs) { " open" } else { "" };
    let _ = write!(
        page,
        "<details{open}><summary>{}: {}</summary><pre>",
        text::Bytes.str(lang),
        test.log.len()
    );
    for exchange in &test.log {
        let _ = writeln!(
            page,
            "{:>8} ms  {}\n   &gt; {}\n   &lt; {}",
            exchange.at_ms,
            escape(&exchange.words),
            hex(&exchange.sent),
            hex(&exchange.received)
        );
    }
    page.push_str("</pre></details>");
}

fn unseen(page: &mut String, report: &Report, lang: Lang) {
    let _ = writeln!(page, "<h2>{}</h2><table><tbody>", text::NotTestable.str(lang));
    for item in report.unseen() {
        let reason = item.reason.str(lang);
        let _ = writeln!(
            page,
            "<tr class=\"na\"><td>{}</td><td>{}</td><td>{}</td></tr>",
            item.id,
            escape(statement(item.id, lang)),
            escape(reason)
        );
    }
    page.push_str("</tbody></table>\n");
}
