//! The acceptance record as a page that needs nothing else, for reading and printing: first one language, then the
//! other, with the SHA-256 of the JSON, its signature and room for those of people.

use std::fmt::Write;

use lafet_texts::{Lang, Words, acceptance as text};

use crate::check::Stage;
use crate::finding::Verdict;
use crate::record::{Record, Row, sha256};
use crate::sign::Signed;

const STYLE: &str = include_str!("record.css");

/// The page; `first` is the language that comes first.
pub fn html(record: &Record, signed: Option<&Signed>, first: Lang) -> String {
    let title = text::RecordTitle.str(first);
    let mut page = format!(
        "<!doctype html>\n<html lang=\"{}\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>{title}: {}</title>\
         <style>\n{STYLE}</style></head><body>\n",
        first.code(),
        escape(&record.site),
    );
    let digest = sha256(&record.json());
    let others = Lang::ALL.into_iter().filter(|it| *it != first);
    for (number, lang) in std::iter::once(first).chain(others).enumerate() {
        let class = if number == 0 { "" } else { " class=\"lang\"" };
        let _ = writeln!(page, "<section lang=\"{}\"{class}>", lang.code());
        head(&mut page, record, lang);
        results(&mut page, record, lang);
        answers(&mut page, record, lang);
        signatures(&mut page, &digest, signed, lang);
        page.push_str("</section>\n");
    }
    page.push_str("</body></html>\n");
    page
}

fn head(page: &mut String, record: &Record, lang: Lang) {
    let (class, verdict) = match record.is_good() {
        true => ("pass", text::RecordGood.str(lang)),
        false => ("fail", text::RecordBad.str(lang)),
    };
    let counts = record.counts;
    let _ = writeln!(
        page,
        "<h1>{}: {}</h1><p class=\"verdict {class}\">{verdict}</p><p>{}: {} · {}: {} · {}: {}</p>",
        text::RecordTitle.str(lang),
        escape(&record.site),
        text::Passed.str(lang),
        counts.pass,
        text::Failed.str(lang),
        counts.fail,
        text::NotTriedWord.str(lang),
        counts.not_tried,
    );
    if record.simulation {
        let _ = writeln!(page, "<p class=\"loud\">{}</p>", text::RecordSimulation.str(lang));
    }
    let loud = record.ended.iter().chain(&record.left);
    for words in loud {
        let _ = writeln!(page, "<p class=\"loud\">{}</p>", of(words, lang));
    }
    let rows = [
        (text::RecordHub.str(lang), format!("{} ({})", record.hub, record.hub_version)),
        (text::RecordBegan.str(lang), record.began.clone()),
        (text::RecordTook.str(lang), format!("{} s", record.took_ms / 1000)),
        (text::RecordBy.str(lang), record.by.clone()),
        (text::RecordSteps.str(lang), record.stages.join(", ")),
        (text::RecordPlan.str(lang), format!("SHA-256 {}", record.plan_sha256)),
        (text::RecordTester.str(lang), format!("lafet {}", record.version)),
    ];
    page.push_str("<table>");
    for (name, value) in rows {
        let _ = write!(page, "<tr><th>{name}</th><td>{}</td></tr>", escape(&value));
    }
    let _ = writeln!(page, "</table><p>{}</p>", text::RecordNoClaim.str(lang));
}

fn results(page: &mut String, record: &Record, lang: Lang) {
    for stage in Stage::ALL {
        let rows = || record.results.iter().filter(|it| it.stage == stage.name());
        if rows().next().is_none() {
            continue;
        }
        let _ = writeln!(
            page,
            "<h2>{}</h2><table><thead><tr><th>{}</th><th>{}</th><th>{}</th><th>{}</th><th>{}</th></tr></thead><tbody>",
            stage.title().str(lang),
            text::RecordCheck.str(lang),
            text::RecordSource.str(lang),
            text::RecordLimit.str(lang),
            text::RecordMeasured.str(lang),
            text::RecordVerdict.str(lang),
        );
        // Failures come first: they are what the page is opened for.
        for verdict in [Verdict::Fail, Verdict::Pass, Verdict::NotTried] {
            rows().filter(|it| it.verdict == verdict).for_each(|it| row(page, it, lang));
        }
        page.push_str("</tbody></table>\n");
    }
}

fn row(page: &mut String, row: &Row, lang: Lang) {
    let source = match (row.requirement, row.source) {
        (Some(requirement), Some(source)) => format!("{requirement}: {source}"),
        (Some(requirement), None) => requirement.to_owned(),
        (None, Some(source)) => source.to_owned(),
        (None, None) => text::Ours.str(lang).to_owned(),
    };
    let cell = |words: Option<&Words>| words.map(|it| of(it, lang)).unwrap_or_default();
    let measured = row.measured.as_ref().or(row.why.as_ref());
    let _ = writeln!(
        page,
        "<tr class=\"{}\"><td>{} <b>{}</b><br><code>{}</code></td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
        row.verdict.name(),
        of(&row.title, lang),
        escape(&row.subject),
        row.check,
        escape(&source),
        cell(row.limit.as_ref()),
        cell(measured),
        word(row.verdict, lang),
    );
}

fn answers(page: &mut String, record: &Record, lang: Lang) {
    if record.answers.is_empty() {
        return;
    }
    let _ = writeln!(page, "<h2>{}</h2><table><tbody>", text::RecordAnswers.str(lang));
    for it in &record.answers {
        let answer = it.answer.as_deref().unwrap_or("–");
        let _ = writeln!(
            page,
            "<tr><td>{}<br><code>{}</code></td><td>{}</td></tr>",
            of(&it.text, lang),
            escape(&it.question),
            escape(answer),
        );
    }
    page.push_str("</tbody></table>\n");
}

fn signatures(page: &mut String, digest: &str, signed: Option<&Signed>, lang: Lang) {
    let _ = writeln!(
        page,
        "<h2>{}</h2><p>{}</p><p><code>SHA-256 {digest}</code></p>",
        text::RecordSignatures.str(lang),
        text::RecordDigest.str(lang),
    );
    if let Some(Signed { public, signature }) = signed {
        let said = text::RecordSigned.str(lang);
        let _ = writeln!(
            page,
            "<p>{said}</p><p><code>{public}</code></p><p><code>{signature}</code></p>"
        );
    }
    let _ = writeln!(
        page,
        "<table class=\"sign\"><thead><tr><th>{}</th><th>{}</th><th>{}</th></tr></thead><tbody>\
         <tr><td></td><td></td><td></td></tr><tr><td></td><td></td><td></td></tr>\
         <tr><td></td><td></td><td></td></tr></tbody></table>",
        text::RecordName.str(lang),
        text::RecordDate.str(lang),
        text::RecordSignature.str(lang),
    );
}

/// A verdict for people.
pub const fn word(verdict: Verdict, lang: Lang) -> &'static str {
    match verdict {
        Verdict::Pass => text::Passed.str(lang),
        Verdict::Fail => text::Failed.str(lang),
        Verdict::NotTried => text::NotTriedWord.str(lang),
    }
}

fn of(words: &Words, lang: Lang) -> String {
    escape(words.of(lang))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
