//! A coverage as a picture: the plan, with the fewest jets in any wind on each cell.

use lafet_place::coverage::{COVERED, Coverage, Rule};
use lafet_place::obstacle::Body;
use lafet_place::site::Kept;
use lafet_sim::exercise::canvas::{Anchor, BAD, Canvas, FAINT, INK, SOFT, STEEL, Type, tick};
use lafet_texts::cli as text;

use super::file::Plan;
use super::report;
use crate::lang::current;

const WIDTH: f64 = 900.0;
const MARGIN: f64 = 30.0;
const TOP: f64 = 64.0;
const LEGEND: f64 = 54.0;
/// By the number of jets; the last for more. Light and dark differ too, for those who do not see colours.
const JETS: [&str; 4] = ["#d55e00", "#f0c987", "#9fd3c7", "#3f8fc6"];
/// Corners of a body that is drawn.
const CORNERS: [[f64; 2]; 4] = [[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]];

struct Scale {
    per_m: f64,
    corner: [f64; 2],
    top_m: f64,
}

impl Scale {
    fn at(&self, [east, north]: [f64; 2]) -> (f64, f64) {
        (MARGIN + (east - self.corner[0]) * self.per_m, TOP + (self.top_m - north) * self.per_m)
    }
}

/// The picture as SVG.
pub fn svg(plan: &Plan, coverage: &Coverage) -> String {
    let [columns, rows] = coverage.cells.map(|cells| cells as f64 * plan.area.cell_m);
    let per_m = (WIDTH - 2.0 * MARGIN) / columns;
    let corner = plan.area.corner;
    let scale = Scale { per_m, corner, top_m: corner[1] + rows };
    let height = TOP + rows * per_m + LEGEND;
    let mut canvas = Canvas::default();
    let title = report::head(plan, coverage);
    canvas.text((MARGIN, 26.0), Type::new(16.0, INK).bold(), &plan.name);
    canvas.text((MARGIN, 48.0), Type::new(11.0, SOFT), &title);
    cells(&mut canvas, plan, coverage, &scale);
    grid(&mut canvas, &scale, [columns, rows]);
    bodies(&mut canvas, plan, &scale);
    for monitor in &plan.site.monitors {
        let (x, y) = scale.at(monitor.at);
        let (sin, cos) = monitor.heading.sin_cos();
        canvas.circle((x, y), 5.0, &format!("fill=\"{INK}\""));
        let end = (x + 14.0 * sin, y - 14.0 * cos);
        canvas.line((x, y), end, &format!("stroke=\"{INK}\" stroke-width=\"3\""));
        let kind = Type::new(12.0, INK).bold();
        canvas.label((x + 8.0, y - 8.0), kind, &monitor.name);
    }
    for weak in &coverage.summary.weakest {
        canvas.circle(
            scale.at(weak.at),
            6.0,
            &format!("fill=\"none\" stroke=\"{BAD}\" stroke-width=\"2\""),
        );
    }
    legend(&mut canvas, height - LEGEND + 30.0);
    canvas.document(WIDTH, height.round())
}

/// Cells of the same count side by side are one rectangle.
fn cells(canvas: &mut Canvas, plan: &Plan, coverage: &Coverage, scale: &Scale) {
    let columns = coverage.cells[0];
    let fewest = fewest(coverage);
    let cell_m = plan.area.cell_m;
    for (row, jets) in fewest.chunks(columns).enumerate() {
        let mut column = 0;
        for run in jets.chunk_by(|a, b| a == b) {
            let place = [
                scale.corner[0] + column as f64 * cell_m,
                scale.corner[1] + (row + 1) as f64 * cell_m,
            ];
            column += run.len();
            let Some(fill) = run.first().filter(|jets| **jets != COVERED) else { continue };
            let fill = JETS[usize::from(*fill).min(JETS.len() - 1)];
            let (x, y) = scale.at(place);
            let side = cell_m * scale.per_m;
            canvas.rect(x, y, run.len() as f64 * side, side, &format!("fill=\"{fill}\""));
        }
    }
}

/// Fewest jets within 90 % of their throw, of still air and all winds.
fn fewest(coverage: &Coverage) -> Vec<u8> {
    let mut fewest = coverage.counts(0, Rule::Within90).to_vec();
    for wind in 1..coverage.summary.winds.len() {
        for (least, jets) in fewest.iter_mut().zip(coverage.counts(wind, Rule::Within90)) {
            *least = (*least).min(*jets);
        }
    }
    fewest
}

fn grid(canvas: &mut Canvas, scale: &Scale, [columns, rows]: [f64; 2]) {
    let step = tick(columns.max(rows), 10.0);
    let style = format!("stroke=\"{FAINT}\" stroke-width=\"0.6\"");
    let south = scale.corner[1];
    for (axis, extent) in [columns, rows].into_iter().enumerate() {
        let first = (scale.corner[axis] / step).ceil() * step;
        let mut at = first;
        while at <= scale.corner[axis] + extent {
            let east = scale.corner[0];
            let (from, to) = match axis {
                0 => ([at, south], [at, scale.top_m]),
                _ => ([east, at], [east + columns, at]),
            };
            canvas.line(scale.at(from), scale.at(to), &style);
            let (x, y) = scale.at(from);
            let (place, anchor) = if axis == 0 {
                ((x, y + 14.0), Anchor::Middle)
            } else {
                ((x - 4.0, y + 4.0), Anchor::End)
            };
            canvas.text(place, Type::new(10.0, SOFT).at(anchor), &format!("{at}"));
            at += step;
        }
    }
}

fn bodies(canvas: &mut Canvas, plan: &Plan, scale: &Scale) {
    let obstacle = format!("fill=\"{STEEL}\" stroke=\"{SOFT}\"");
    for body in &plan.site.obstacles {
        draw(canvas, body, scale, &obstacle);
    }
    let kept =
        format!("fill=\"none\" stroke=\"{BAD}\" stroke-width=\"2\" stroke-dasharray=\"6 3\"");
    for keep_out in &plan.site.keep_outs {
        if let Kept::Zone(body) = &keep_out.place {
            draw(canvas, body, scale, &kept);
        }
    }
}

fn draw(canvas: &mut Canvas, body: &Body, scale: &Scale, style: &str) {
    match *body {
        Body::Cylinder { at, radius_m, .. } => {
            canvas.circle(scale.at(at), radius_m * scale.per_m, style);
        }
        Body::Box { at, size, heading, .. } => {
            let (sin, cos) = heading.sin_cos();
            let corner = |[length, width]: [f64; 2]| {
                let (length, width) = (0.5 * length * size[0], 0.5 * width * size[1]);
                let east = at[0] + length * sin + width * cos;
                let (x, y) = scale.at([east, at[1] + length * cos - width * sin]);
                format!("{x:.1} {y:.1}")
            };
            canvas.path(&format!("M{}Z", CORNERS.map(corner).join("L")), style);
        }
    }
}

fn legend(canvas: &mut Canvas, y: f64) {
    let text = Type::new(12.0, INK);
    let words = [
        text::JetsNone.fixed(),
        text::JetsOne.fixed(),
        text::JetsTwo.fixed(),
        text::JetsThree.fixed(),
    ];
    let mut x = MARGIN;
    for (fill, word) in JETS.into_iter().zip(words) {
        canvas.rect(x, y - 11.0, 14.0, 14.0, &format!("fill=\"{fill}\""));
        canvas.text((x + 20.0, y), text, word.str(current()));
        x += 130.0;
    }
    let note = text::PictureLegend.str(current());
    canvas.text((MARGIN, y + 18.0), Type::new(11.0, SOFT), note);
}
