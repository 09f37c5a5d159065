//! What came of a test, in lines for the terminal.

use lafet_acceptance::html::word;
use lafet_acceptance::record::Record;
use lafet_acceptance::{Outcome, Verdict};
use lafet_texts::{Text as _, Words, cli as text};

use crate::lang::current;
use crate::out::columns;

/// The lines: failures, then what was not tried, then counts.
pub fn told(record: &Record) -> String {
    let lang = current();
    let mut lines = Vec::new();
    for verdict in [Verdict::Pass, Verdict::NotTried, Verdict::Fail] {
        let rows = record.results.iter().filter(|it| it.verdict == verdict);
        let of = |words: Option<&Words>| words.map_or("", |it| it.of(lang)).to_owned();
        let cells = |it: &lafet_acceptance::record::Row| {
            let measured = of(it.measured.as_ref().or(it.why.as_ref()));
            vec![
                word(verdict, lang).to_owned(),
                it.check.to_owned(),
                it.subject.clone(),
                of(it.limit.as_ref()),
                measured,
            ]
        };
        let rows: Vec<Vec<String>> = rows.map(cells).collect();
        if !rows.is_empty() {
            lines.push(columns(&rows));
        }
    }
    let counts = record.counts;
    let (passed, failed, not_tried) = (counts.pass, counts.fail, counts.not_tried);
    lines.push(text::SiteCounts { passed, failed, not_tried }.of(lang));
    lines.extend(record.ended.iter().chain(&record.left).map(|it| it.of(lang).to_owned()));
    lines.join("\n")
}

/// The exit code: see docs/site-test.md.
pub fn short(outcome: &Outcome) -> u8 {
    use lafet_acceptance::End;
    let failed = outcome.findings.count(Verdict::Fail) > 0;
    match &outcome.ended {
        _ if !outcome.left.is_empty() => 4,
        Some(End::Stopped) => 130,
        Some(End::Lost(_)) => 3,
        Some(End::Unsafe(_)) => 1,
        None => u8::from(failed),
    }
}
