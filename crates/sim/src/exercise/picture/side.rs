//! Beside the plan: what the signs mean, figures, expectations.

use lafet_texts::{Lang, Text as _, sim as text};

use super::canvas::{BAD, Canvas, DEPTHS, FAINT, GOOD, INK, MONITORS, SOFT, Type, wrapped};
use crate::exercise::report::clock;
use crate::exercise::run::Outcome;

const SIZE: f64 = 12.0;
const STEP: f64 = 17.0;

/// Draws it; the place below.
pub fn draw(canvas: &mut Canvas, outcome: &Outcome, lang: Lang, at: (f64, f64), width: f64) -> f64 {
    let mut y = heading(canvas, (at.0, at.1 + 10.0), text::HeadingExpectations.str(lang));
    y = checks(canvas, outcome, lang, (at.0, y), width);
    y = heading(canvas, (at.0, y + 10.0), text::HeadingMonitors.str(lang));
    y = monitors(canvas, outcome, lang, (at.0, y), width);
    y = heading(canvas, (at.0, y + 10.0), text::HeadingPlan.str(lang));
    legend(canvas, lang, (at.0, y), width)
}

fn heading(canvas: &mut Canvas, at: (f64, f64), text: &str) -> f64 {
    canvas.text(at, Type::new(14.0, INK).bold(), text);
    at.1 + 20.0
}

fn checks(canvas: &mut Canvas, outcome: &Outcome, lang: Lang, at: (f64, f64), width: f64) -> f64 {
    let mut y = at.1;
    let answers: Vec<_> = outcome.checks.iter().filter(|check| check.is_answer).collect();
    let (agreed, all) = (answers.iter().filter(|check| check.passed).count(), answers.len());
    if all > 0 && agreed == all {
        let text = text::AllAnsweredAsExpected { all }.of(lang);
        y = check(canvas, true, &text, (at.0, y), width);
    }
    for it in outcome.checks.iter().filter(|check| !(check.is_answer && check.passed)) {
        let text = it.text.of(lang);
        // An expectation on the whole time is decided at its end, which shows nothing.
        let told = it.at_ms > 0 && it.at_ms < outcome.exercise.duration_ms;
        let text = match (it.passed, told) {
            (true, true) => format!("{text} ({})", clock(it.at_ms).trim()),
            (true, false) => text.to_owned(),
            (false, _) => format!("{text} — {}: {}", clock(it.at_ms).trim(), it.came.of(lang)),
        };
        y = check(canvas, it.passed, &text, (at.0, y), width);
    }
    y
}

fn check(canvas: &mut Canvas, passed: bool, text: &str, at: (f64, f64), width: f64) -> f64 {
    let (colour, mark) = if passed { (GOOD, "✓") } else { (BAD, "✗") };
    canvas.text(at, Type::new(SIZE, colour).bold(), mark);
    let fill = if passed { INK } else { BAD };
    let mut y = at.1;
    for line in wrapped(text, width - 18.0, SIZE) {
        canvas.text((at.0 + 18.0, y), Type::new(SIZE, fill), &line);
        y += STEP - 1.0;
    }
    y + 3.0
}

fn monitors(canvas: &mut Canvas, outcome: &Outcome, lang: Lang, at: (f64, f64), width: f64) -> f64 {
    let mut y = at.1;
    for (index, (figures, plan)) in
        outcome.monitors.iter().zip(&outcome.exercise.monitors).enumerate()
    {
        let (colour, dash) = MONITORS[index % MONITORS.len()];
        let stroke =
            format!("stroke=\"{colour}\" stroke-width=\"2.5\" stroke-dasharray=\"{dash}\"");
        canvas.line((at.0, y - 4.0), (at.0 + 30.0, y - 4.0), &stroke);
        let (litres, seconds) = (figures.litres, figures.water_ms as f64 / 1000.0);
        let first = figures.first_water_ms.map(|ms| clock(ms).trim().to_owned());
        let text = match first {
            Some(first) => text::MonitorWater {
                monitor: &plan.name,
                litres: format_args!("{litres:.0}"),
                seconds: format_args!("{seconds:.0}"),
                first,
            }
            .of(lang),
            None => text::MonitorNoWater { monitor: &plan.name }.of(lang),
        };
        y = canvas.paragraph((at.0 + 38.0, y), width - 38.0, Type::new(SIZE, INK), &text) + 1.0;
    }
    y
}

fn legend(canvas: &mut Canvas, lang: Lang, at: (f64, f64), width: f64) -> f64 {
    let mut y = at.1;
    let swatch = 26.0;
    let text = Type::new(SIZE, SOFT);
    canvas.text((at.0, y), text, text::LegendDepth.str(lang));
    for (index, (from, fill)) in DEPTHS.iter().enumerate() {
        let x = at.0 + 140.0 + index as f64 * (swatch + 20.0);
        canvas.rect(x, y - 10.0, swatch, 12.0, &format!("fill=\"{fill}\" stroke=\"{FAINT}\""));
        let label = if *from < 1.0 { format!("{from}") } else { format!("{from:.0}") };
        canvas.text((x, y + 15.0), Type::new(10.0, SOFT), &format!("≥{label}"));
    }
    y += STEP + 16.0;
    let items = [text::LegendDotted.str(lang), text::LegendCircle.str(lang)];
    for item in items {
        y = canvas.paragraph((at.0, y), width, text, item) + 2.0;
    }
    y
}
