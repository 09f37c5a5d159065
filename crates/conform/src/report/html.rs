//! The report as a self-contained HTML page, for reading and printing.

use std::fmt::Write;

use lafet_client::Lang;

use super::text::{escape, said, statement, summary, word};
use super::{Report, TestReport};
use crate::raw::{self, hex};
use crate::spec::Label;
use crate::verdict::Outcome;

const STYLE: &str = include_str!("report.css");
const OUTCOMES: [Outcome; 4] =
    [Outcome::Fail, Outcome::Differs, Outcome::NotApplicable, Outcome::Pass];

fn pick(lang: Lang, en: &'static str, ru: &'static str) -> &'static str {
    match lang {
        Lang::En => en,
        Lang::Ru => ru,
    }
}

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
    let title = pick(lang, "Conformance of a fire monitor", "Проверка лафетного ствола");
    let mut page = format!(
        "<!doctype html>\n<html lang=\"{}\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>{title}</title>\
         <style>\n{STYLE}</style></head><body><h1>{title}</h1>\n",
        pick(lang, "en", "ru")
    );
    head(&mut page, report, lang);
    tests(&mut page, report, lang);
    unseen(&mut page, report, lang);
    page.push_str("</body></html>\n");
    page
}

fn head(page: &mut String, report: &Report, lang: Lang) {
    let (class, verdict) = match report.is_good() {
        true => ("pass", pick(lang, "Nothing failed", "Ошибок нет")),
        false => ("fail", pick(lang, "Failed", "Есть ошибки")),
    };
    let present: Vec<String> = report.present.iter().map(|id| raw::name(id.name(), id.0)).collect();
    let _ = write!(
        page,
        "<p class=\"verdict {class}\">{verdict}</p><p><code>{}</code></p><p>{}</p><p>{}: {}</p>\n<p class=\"counts\">",
        escape(&report.url),
        escape(&summary(report, lang)).replace('\n', "<br>"),
        pick(lang, "Subsystems", "Подсистемы"),
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
        pick(lang, "Test", "Проверка"),
        pick(lang, "Statement", "Утверждение"),
        pick(lang, "Result", "Итог"),
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
        Label::Read => "",
        Label::Observed => pick(lang, " <i>observed</i>", " <i>наблюдалось</i>"),
        Label::Ours => pick(lang, " <i>ours</i>", " <i>наше</i>"),
    };
    let _ = write!(
        page,
        "<tr class=\"{}\"><td>{}</td><td>{}</td><td>{}{ours}",
        class(test.outcome),
        test.item,
        test.name,
        escape(statement(test.item, lang)),
    );
    for (what, note) in [
        (pick(lang, "expected", "ожидалось"), &test.expected),
        (pick(lang, "found", "получено"), &test.found),
    ] {
        if !said(note, lang).is_empty() {
            let _ = write!(page, "<br><b>{what}:</b> {}", escape(said(note, lang)));
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
        pick(lang, "Bytes", "Байты"),
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
    let _ = writeln!(
        page,
        "<h2>{}</h2><table><tbody>",
        pick(lang, "What cannot be tested over the wire", "Что по линии проверить нельзя")
    );
    for item in report.unseen() {
        let reason = pick(lang, item.reason, item.reason_ru);
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
