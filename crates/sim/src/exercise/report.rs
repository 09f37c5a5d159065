//! A run as text for people and as JSON for programs.

use lafet_texts::{Lang, Text as _, Words, sim as text};
use serde_json::{Value, json};

use super::log::{Kind, Line};
use super::run::{FireFigures, MonitorFigures, Outcome};

/// Width of the names of monitors in the time line at least.
const NAME_WIDTH: usize = 4;

/// The report for people.
pub fn text(outcome: &Outcome, lang: Lang) -> String {
    let exercise = &outcome.exercise;
    let mut out = vec![
        exercise.title.of(lang).to_owned(),
        exercise.about.of(lang).trim().to_owned(),
        format!(
            "{}: {}, seed {}",
            text::HeadingTime.str(lang),
            clock(exercise.duration_ms),
            outcome.seed
        ),
        String::new(),
        text::HeadingEvents.str(lang).to_owned(),
    ];
    let names = exercise.monitors.iter().map(|monitor| monitor.name.chars().count());
    let width = names.max().unwrap_or(0).max(NAME_WIDTH);
    out.extend(outcome.lines.iter().map(|line| line_text(outcome, line, width, lang)));
    out.push(String::new());
    out.push(text::HeadingMonitors.str(lang).to_owned());
    out.extend(monitors(outcome, lang));
    out.push(String::new());
    out.push(text::HeadingFires.str(lang).to_owned());
    out.extend(fires(outcome, lang));
    out.push(String::new());
    out.push(text::HeadingExpectations.str(lang).to_owned());
    out.extend(checks(outcome, lang));
    let failed = outcome.checks.iter().filter(|check| !check.passed).count();
    let (held, all) = (outcome.checks.len() - failed, outcome.checks.len());
    out.push(String::new());
    out.push(match failed {
        0 => text::VerdictPassed { held, all }.of(lang),
        _ => text::VerdictFailed { failed, all }.of(lang),
    });
    out.join("\n")
}

fn line_text(outcome: &Outcome, line: &Line, width: usize, lang: Lang) -> String {
    let name = line.monitor.map_or("", |index| &outcome.exercise.monitors[index].name);
    let (mark, text) = (line.kind.mark(), line.text.of(lang));
    let severity = match line.kind {
        Kind::Flag(severity) => format!("[{}] ", severity.text().of(lang)),
        _ => String::new(),
    };
    format!("  {} {name:<width$} {mark} {severity}{text}", clock(line.at_ms))
}

fn monitors(outcome: &Outcome, lang: Lang) -> Vec<String> {
    let rows = outcome.monitors.iter().zip(&outcome.exercise.monitors);
    let rows = rows.map(|(figures, plan)| {
        let MonitorFigures { counts, litres, first_water_ms, water_ms, most_atm, way_deg, .. } =
            figures;
        let first = first_water_ms.map_or_else(|| "—".to_owned(), clock);
        let seconds = *water_ms as f64 / 1000.0;
        let (turned, raised) = *way_deg;
        let counts = format!(
            "{}/{}/{}/{}",
            counts.requests, counts.accepted, counts.refused, counts.unanswered
        );
        text::MonitorFigures {
            monitor: &plan.name,
            litres: format_args!("{litres:.0}"),
            seconds: format_args!("{seconds:.0}"),
            first,
            most_atm: format_args!("{most_atm:.1}"),
            turned: format_args!("{turned:.0}"),
            raised: format_args!("{raised:.0}"),
            counts,
            warnings: figures.warnings,
            restarts: figures.restarts,
        }
        .of(lang)
    });
    rows.collect()
}

fn fires(outcome: &Outcome, lang: Lang) -> Vec<String> {
    let rows = outcome.fires.iter().zip(&outcome.exercise.fires);
    let rows = rows.map(|(figures, plan)| {
        let name = &plan.name;
        let Some(lit_ms) = figures.lit_ms else {
            return text::FireNeverBurned { fire: name }.of(lang);
        };
        let FireFigures { hit_ms, out_ms, reignited, size_m, .. } = figures;
        let time = |at_ms: &Option<u64>| at_ms.as_ref().map_or_else(|| "—".to_owned(), clock);
        let (lit, hit, out) = (clock(lit_ms), time(hit_ms), time(out_ms));
        text::FireFigures {
            fire: name,
            lit,
            hit,
            out,
            reignited,
            size_m: format_args!("{size_m:.1}"),
        }
        .of(lang)
    });
    rows.collect()
}

fn checks(outcome: &Outcome, lang: Lang) -> Vec<String> {
    let file = &outcome.exercise.file;
    let rows = outcome.checks.iter().map(|check| {
        let (mark, text) = (if check.passed { "✓" } else { "✗" }, check.text.of(lang));
        let at = clock(check.at_ms);
        let came = check.came.of(lang);
        match (check.passed, came.is_empty()) {
            (true, _) => format!("  {mark} {at}  {text}"),
            (false, true) => format!("  {mark} {at}  {text} ({file}:{})", check.line),
            (false, false) => format!("  {mark} {at}  {text}: {came} ({file}:{})", check.line),
        }
    });
    rows.collect()
}

/// Minutes and seconds: ` 1:05.3`.
pub fn clock(ms: impl core::borrow::Borrow<u64>) -> String {
    let tenths = ms.borrow() / 100;
    format!("{:>2}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10)
}

/// The report for programs; texts in both languages.
pub fn json(outcome: &Outcome) -> Value {
    let exercise = &outcome.exercise;
    let name = |index: usize| &exercise.monitors[index].name;
    let both = |Words { en, ru }: &Words| json!({ "en": en, "ru": ru });
    let seconds = |ms: u64| ms as f64 / 1000.0;
    let lines = outcome.lines.iter().map(|line| {
        json!({
            "at_s": seconds(line.at_ms),
            "monitor": line.monitor.map(name),
            "kind": line.kind.name(),
            "text": both(&line.text),
        })
    });
    let checks = outcome.checks.iter().map(|check| {
        json!({
            "line": check.line,
            "answer": check.is_answer,
            "text": both(&check.text),
            "passed": check.passed,
            "at_s": seconds(check.at_ms),
            "came": both(&check.came),
        })
    });
    let monitors = outcome.monitors.iter().zip(&exercise.monitors).map(|(figures, plan)| {
        json!({
            "name": plan.name,
            "water_l": libm::round(figures.litres),
            "water_s": seconds(figures.water_ms),
            "first_water_s": figures.first_water_ms.map(seconds),
            "most_atm": tenth(figures.most_atm),
            "turned_deg": tenth(figures.way_deg.0),
            "raised_deg": tenth(figures.way_deg.1),
            "requests": figures.counts.requests,
            "agreed": figures.counts.accepted,
            "refused": figures.counts.refused,
            "unanswered": figures.counts.unanswered,
            "warnings": figures.warnings,
            "restarts": figures.restarts,
        })
    });
    let fires = outcome.fires.iter().zip(&exercise.fires).map(|(figures, plan)| {
        json!({
            "name": plan.name,
            "lit_s": figures.lit_ms.map(seconds),
            "reached_s": figures.hit_ms.map(seconds),
            "out_s": figures.out_ms.map(seconds),
            "reignited": figures.reignited,
            "largest_m": tenth(figures.size_m),
        })
    });
    json!({
        "file": exercise.file,
        "title": both(&exercise.title),
        "seed": outcome.seed,
        "duration_s": seconds(exercise.duration_ms),
        "passed": outcome.passed(),
        "checks": checks.collect::<Vec<_>>(),
        "monitors": monitors.collect::<Vec<_>>(),
        "fires": fires.collect::<Vec<_>>(),
        "log": lines.collect::<Vec<_>>(),
    })
}

fn tenth(value: f64) -> f64 {
    libm::round(value * 10.0) / 10.0
}
