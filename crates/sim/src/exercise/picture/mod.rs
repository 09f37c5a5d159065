//! A run as a picture: plan view, verdict, aligned time lines.

pub mod canvas;
mod chart;
mod plan;
mod side;

use lafet_texts::{Lang, Text as _, sim as text};

use super::report::clock;
use super::run::Outcome;
use canvas::{Anchor, BAD, Canvas, FAINT, GOOD, INK, SOFT, Type};

const WIDTH: f64 = 1200.0;
const MARGIN: f64 = 24.0;
const PLAN_WIDTH: f64 = 690.0;
const GAP: f64 = 24.0;

/// The picture as SVG.
pub fn svg(outcome: &Outcome, lang: Lang) -> String {
    let mut canvas = Canvas::default();
    let top = header(&mut canvas, outcome, lang);
    let plan_height = plan::height(outcome, PLAN_WIDTH);
    let side_x = MARGIN + PLAN_WIDTH + GAP;
    plan::draw(&mut canvas, outcome, lang, (MARGIN, top), (PLAN_WIDTH, plan_height));
    let side_width = WIDTH - MARGIN - side_x;
    let side_end = side::draw(&mut canvas, outcome, lang, (side_x, top), side_width);
    let below = (top + plan_height).max(side_end) + 30.0;
    let width = WIDTH - 2.0 * MARGIN;
    let end = chart::draw(&mut canvas, outcome, lang, (MARGIN, below), width);
    let height = libm::ceil(end + MARGIN);
    canvas.document(WIDTH, height)
}

/// Title, what it is about, verdict; the place below.
fn header(canvas: &mut Canvas, outcome: &Outcome, lang: Lang) -> f64 {
    let exercise = &outcome.exercise;
    let failed = outcome.checks.iter().filter(|check| !check.passed).count();
    let all = outcome.checks.len();
    let (colour, verdict) = match failed {
        0 => (GOOD, text::PicturePassed { all }.of(lang)),
        _ => (BAD, text::PictureFailed { failed, all }.of(lang)),
    };
    let badge = canvas::width_of(&verdict, 14.0) + 24.0;
    let x = WIDTH - MARGIN - badge;
    canvas.rect(x, 20.0, badge, 28.0, &format!("rx=\"5\" fill=\"{colour}\""));
    let white = Type::new(14.0, "#ffffff").bold().at(Anchor::Middle);
    canvas.text((x + badge / 2.0, 39.0), white, &verdict);
    let seed = outcome.seed;
    let duration = clock(exercise.duration_ms);
    let run = text::PictureRun { duration, seed }.of(lang);
    canvas.text((x - 14.0, 39.0), Type::new(12.0, SOFT).at(Anchor::End), run.trim());
    // Letters of a title are wider than those of text.
    let title = exercise.title.of(lang);
    let room = x - 40.0 - canvas::width_of(run.trim(), 12.0) - MARGIN;
    let size = libm::floor((22.0 * room / canvas::width_of(title, 25.0)).min(22.0));
    canvas.text((MARGIN, 40.0), Type::new(size, INK).bold(), title);
    let y = canvas.paragraph(
        (MARGIN, 64.0),
        WIDTH - 2.0 * MARGIN,
        Type::new(13.0, SOFT),
        exercise.about.of(lang),
    );
    canvas.line((MARGIN, y - 4.0), (WIDTH - MARGIN, y - 4.0), &format!("stroke=\"{FAINT}\""));
    y + 12.0
}
