//! What came of a test, in lines for the terminal.

use std::collections::BTreeSet;

use lafet_acceptance::calendar::{Due, Kept};
use lafet_acceptance::html::word;
use lafet_acceptance::record::{Record, date};
use lafet_acceptance::sign::Signed;
use lafet_acceptance::{Outcome, Stage, Verdict};
use lafet_texts::{Lang, Text as _, Words, cli as text};
use serde_json::{Value, json};

use crate::lang::current;
use crate::out::columns;

/// The lines: failures, then what was not tried, then counts.
pub fn lines(record: &Record, signed: Option<&Signed>) -> String {
    let lang = current();
    let mut lines = Vec::new();
    for verdict in [Verdict::Pass, Verdict::NotTried, Verdict::Fail] {
        // Steps that were not asked for are in the record alone.
        let asked = record.results.iter().filter(|it| record.stages.contains(&it.stage));
        let rows = asked.filter(|it| it.verdict == verdict);
        // The end of the test is said once, below.
        let rows = rows.filter(|it| it.why.is_none() || it.why != record.ended);
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
    lines.extend(signed.map(|it| text::SiteSigned { public: &it.public }.of(lang)));
    lines.extend(record.ended.iter().chain(&record.left).map(|it| it.of(lang).to_owned()));
    lines.join("\n")
}

/// Most records that are listed.
const LISTED: usize = 31;

/// The calendar, in lines: what is due, then the latest records.
pub fn dates(due: &[Due], records: &[Kept]) -> String {
    let lang = current();
    let cells = |it: &Due| {
        let last = it.last.map_or_else(|| text::SiteNever.str(lang).to_owned(), |it| date(it.0));
        let result = it.last.map_or("", |(_, good)| verdict(good, lang)).to_owned();
        let next = match it.next_ms.filter(|_| !it.overdue) {
            Some(next) => text::SiteDue { date: date(next) }.of(lang),
            None => text::SiteDueNow.str(lang).to_owned(),
        };
        let every = text::SiteEvery { days: it.every_days }.of(lang);
        vec![it.stage.name().to_owned(), every, last, result, next]
    };
    let mut lines = vec![columns(&due.iter().map(cells).collect::<Vec<_>>())];
    let of = |it: &Kept| {
        let count = |verdict| it.count(None, verdict);
        let (passed, failed, not_tried) = (count("pass"), count("fail"), count("not_tried"));
        let counts = text::SiteCounts { passed, failed, not_tried }.of(lang);
        let good = verdict(failed == 0 && it.is_whole(), lang);
        vec![it.began.clone(), it.stages.join(","), good.to_owned(), counts]
    };
    let rows: Vec<Vec<String>> = records.iter().take(LISTED).map(of).collect();
    if !rows.is_empty() {
        lines.push(columns(&rows));
    }
    lines.join("\n\n")
}

const fn verdict(good: bool, lang: Lang) -> &'static str {
    word(if good { Verdict::Pass } else { Verdict::Fail }, lang)
}

/// The calendar for programs.
pub fn dates_json(due: &[Due], records: &[Kept]) -> Value {
    let steps = due.iter().map(|it| {
        json!({
            "stage": it.stage.name(),
            "every_days": it.every_days,
            "last": it.last.map(|it| date(it.0)),
            "good": it.last.map(|it| it.1),
            "next": it.next_ms.map(date),
            "overdue": it.overdue,
        })
    });
    let all = records.iter().map(|it| {
        json!({
            "began": it.began,
            "stages": it.stages,
            "pass": it.count(None, "pass"),
            "fail": it.count(None, "fail"),
            "not_tried": it.count(None, "not_tried"),
            "whole": it.is_whole(),
        })
    });
    json!({ "steps": steps.collect::<Value>(), "records": all.collect::<Value>() })
}

/// The exit code: see docs/site-test.md.
pub fn short(outcome: &Outcome, stages: &BTreeSet<Stage>) -> u8 {
    use lafet_acceptance::End;
    let failed = outcome.findings.count(Verdict::Fail) > 0;
    let tried = |stage: &Stage| {
        let mut of = outcome.findings.0.iter().filter(|it| it.check.stage == *stage);
        of.any(|it| it.verdict != Verdict::NotTried)
    };
    match &outcome.ended {
        _ if !outcome.left.is_empty() => 4,
        Some(End::Stopped) => 130,
        Some(End::Lost(_)) => 3,
        Some(End::Unsafe(_)) => 1,
        // Nothing tried is no success.
        None => u8::from(failed || !stages.iter().all(tried)),
    }
}
