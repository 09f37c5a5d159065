//! The plan view: what is on the site, where the water fell, what became of the fires.

use core::fmt::Write as _;

use lafet_texts::{Lang, Text as _, sim as text};

use super::canvas::{
    Anchor, BAD, Canvas, DEPTHS, FAINT, FIRES, GRID, GROUND, INK, MONITORS, SOFT, STEEL, Type, tick,
};
use crate::exercise::recording::CELL_M;
use crate::exercise::report::clock;
use crate::exercise::run::Outcome;
use crate::obstacle::Shape;
use crate::site::{Pose, SiteGlare};

/// A map from metres to the picture.
struct Map {
    low: (f64, f64),
    origin: (f64, f64),
    scale: f64,
}

impl Map {
    fn at(&self, place: (f64, f64)) -> (f64, f64) {
        (
            self.origin.0 + (place.0 - self.low.0) * self.scale,
            self.origin.1 - (place.1 - self.low.1) * self.scale,
        )
    }
}

fn size_m(outcome: &Outcome) -> (f64, f64) {
    let bounds = &outcome.recording.bounds;
    (bounds.high.0 - bounds.low.0, bounds.high.1 - bounds.low.1)
}

/// How high the plan is in a width.
pub fn height(outcome: &Outcome, width: f64) -> f64 {
    let (x, y) = size_m(outcome);
    libm::round((width * y / x).clamp(360.0, 620.0))
}

/// Draws it into a box.
pub fn draw(canvas: &mut Canvas, outcome: &Outcome, lang: Lang, at: (f64, f64), size: (f64, f64)) {
    let (x_m, y_m) = size_m(outcome);
    let scale = (size.0 / x_m).min(size.1 / y_m);
    let low = outcome.recording.bounds.low;
    let free = ((size.0 / scale - x_m) / 2.0, (size.1 / scale - y_m) / 2.0);
    let map = Map { low: (low.0 - free.0, low.1 - free.1), origin: (at.0, at.1 + size.1), scale };
    let clip = format!(
        "<clipPath id=\"plan\"><rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>\
         </clipPath>\n<g clip-path=\"url(#plan)\">\n",
        at.0, at.1, size.0, size.1
    );
    canvas.rect(at.0, at.1, size.0, size.1, &format!("fill=\"{GROUND}\""));
    canvas.out.push_str(&clip);
    grid(canvas, &map, at, size);
    tanks(canvas, outcome, &map);
    water(canvas, outcome, &map);
    walls(canvas, outcome, &map);
    tank_names(canvas, outcome, &map);
    glares(canvas, outcome, &map);
    sectors(canvas, outcome, &map);
    fires(canvas, outcome, lang, &map);
    monitors(canvas, outcome, &map);
    canvas.out.push_str("</g>\n");
    canvas.rect(at.0, at.1, size.0, size.1, &format!("fill=\"none\" stroke=\"{FAINT}\""));
    scale_bar(canvas, lang, &map, (at.0 + 14.0, at.1 + size.1 - 16.0), x_m);
    compass(canvas, outcome, lang, (at.0 + size.0 - 44.0, at.1 + 46.0));
}

fn grid(canvas: &mut Canvas, map: &Map, at: (f64, f64), size: (f64, f64)) {
    let step = tick(size.0 / map.scale, 9.0);
    let style = format!("stroke=\"{GRID}\"");
    let small = Type::new(10.0, SOFT);
    let high = (map.low.0 + size.0 / map.scale, map.low.1 + size.1 / map.scale);
    let mut x = libm::ceil(map.low.0 / step) * step + 0.0;
    while x < high.0 {
        let px = map.at((x, 0.0)).0;
        canvas.line((px, at.1), (px, at.1 + size.1), &style);
        if px + 24.0 < at.0 + size.0 {
            canvas.text((px + 3.0, at.1 + 12.0), small, &format!("{x:.0}"));
        }
        x += step;
    }
    // Plus nought, for ceil gives a negative one.
    let mut y = libm::ceil(map.low.1 / step) * step + 0.0;
    while y < high.1 {
        let py = map.at((0.0, y)).1;
        canvas.line((at.0, py), (at.0 + size.0, py), &style);
        if py > at.1 + 28.0 {
            canvas.text((at.0 + 4.0, py - 3.0), small, &format!("{y:.0}"));
        }
        y += step;
    }
}

/// The map of water, as runs of cells of the same shade.
fn water(canvas: &mut Canvas, outcome: &Outcome, map: &Map) {
    let recording = &outcome.recording;
    let shade = |litres: f64| DEPTHS.iter().rposition(|(from, _)| litres >= *from);
    let mut paths = [const { String::new() }; DEPTHS.len()];
    let side = CELL_M * map.scale;
    for (row, cells) in recording.water.chunks(recording.columns.max(1)).enumerate() {
        let mut column = 0;
        for run in cells.chunk_by(|a, b| shade(*a) == shade(*b)) {
            if let Some(shade) = run.first().and_then(|litres| shade(*litres)) {
                let bounds = &recording.bounds;
                let west = bounds.low.0 + column as f64 * CELL_M;
                let north = bounds.low.1 + (row + 1) as f64 * CELL_M;
                let (x, y) = map.at((west, north));
                let width = run.len() as f64 * side;
                // Writing to a String cannot fail.
                let _ = write!(paths[shade], "M{x:.1} {y:.1}h{width:.1}v{side:.1}h-{width:.1}z");
            }
            column += run.len();
        }
    }
    for (path, (_, fill)) in paths.iter().zip(DEPTHS) {
        if !path.is_empty() {
            let style = format!(
                "fill=\"{fill}\" fill-opacity=\"0.85\" stroke=\"{fill}\" stroke-width=\"0.4\""
            );
            canvas.path(path, &style);
        }
    }
}

fn tanks(canvas: &mut Canvas, outcome: &Outcome, map: &Map) {
    for obstacle in &outcome.exercise.site.obstacles {
        if let Shape::Tank(middle, diameter_m) = obstacle.shape {
            let radius = diameter_m / 2.0 * map.scale;
            let style = format!("fill=\"{STEEL}\" stroke=\"{SOFT}\" stroke-width=\"1.5\"");
            canvas.circle(map.at(middle), radius, &style);
        }
    }
}

fn tank_names(canvas: &mut Canvas, outcome: &Outcome, map: &Map) {
    let exercise = &outcome.exercise;
    for (obstacle, name) in exercise.site.obstacles.iter().zip(&exercise.obstacles) {
        if let Shape::Tank(middle, diameter_m) = obstacle.shape {
            let top = map.at((middle.0, middle.1 + diameter_m / 2.0));
            let text = Type::new(12.0, INK).at(Anchor::Middle);
            canvas.label((top.0, top.1 - 5.0), text, name);
        }
    }
}

fn walls(canvas: &mut Canvas, outcome: &Outcome, map: &Map) {
    let exercise = &outcome.exercise;
    for (obstacle, name) in exercise.site.obstacles.iter().zip(&exercise.obstacles) {
        if let Shape::Wall(a, b) = obstacle.shape {
            let (from, to) = (map.at(a), map.at(b));
            let style = format!("stroke=\"{INK}\" stroke-width=\"3\" stroke-linecap=\"round\"");
            canvas.line(from, to, &style);
            if !name.is_empty() {
                let text = Type::new(12.0, SOFT);
                let above = (from.0.min(to.0) + 4.0, from.1.min(to.1) - 6.0);
                canvas.label(above, text, name);
            }
        }
    }
}

fn glares(canvas: &mut Canvas, outcome: &Outcome, map: &Map) {
    let exercise = &outcome.exercise;
    for (glare, name) in exercise.site.glares.iter().zip(&exercise.glares) {
        if let SiteGlare::Hot { at, size_m, .. } = glare {
            let side = size_m * map.scale;
            let (x, y) = map.at(*at);
            let style = "fill=\"#f3dfa8\" stroke=\"#8a6d00\" stroke-dasharray=\"3 2\"";
            canvas.rect(x - side / 2.0, y - side / 2.0, side, side, style);
            let text = Type::new(12.0, "#6b5500").at(Anchor::Middle);
            canvas.label((x, y - side / 2.0 - 5.0), text, name);
        }
    }
}

/// How far each jet goes, within the limits of the azimuth.
fn sectors(canvas: &mut Canvas, outcome: &Outcome, map: &Map) {
    let exercise = &outcome.exercise;
    for (index, monitor) in exercise.site.monitors.iter().enumerate() {
        let (colour, _) = MONITORS[index % MONITORS.len()];
        let (right, left, reach_m) = outcome.recording.sectors[index];
        let style = format!(
            "fill=\"none\" stroke=\"{colour}\" stroke-opacity=\"0.7\" stroke-dasharray=\"1 5\" \
             stroke-width=\"1.6\" stroke-linecap=\"round\""
        );
        if left - right >= 359.0 {
            canvas.circle(map.at(monitor.pose.at), reach_m * map.scale, &style);
            continue;
        }
        let point = |azimuth_deg: f64| map.at(place(&monitor.pose, azimuth_deg, reach_m));
        let (from, to) = (point(right), point(left));
        let middle = map.at(monitor.pose.at);
        let large = u8::from(left - right > 180.0);
        let radius = reach_m * map.scale;
        let data = format!(
            "M{:.1} {:.1}L{:.1} {:.1}A{radius:.1} {radius:.1} 0 {large} 0 {:.1} {:.1}Z",
            middle.0, middle.1, from.0, from.1, to.0, to.1
        );
        canvas.path(&data, &style);
    }
}

fn place(pose: &Pose, azimuth_deg: f64, range_m: f64) -> (f64, f64) {
    let azimuth = azimuth_deg.to_radians();
    pose.site((range_m * libm::cos(azimuth), range_m * libm::sin(azimuth)))
}

fn fires(canvas: &mut Canvas, outcome: &Outcome, lang: Lang, map: &Map) {
    let exercise = &outcome.exercise;
    for (index, fire) in exercise.site.fires.iter().enumerate() {
        let figures = &outcome.fires[index];
        let (colour, dash) = FIRES[index % FIRES.len()];
        let middle = map.at(fire.at);
        let radius = |size_m: f64| (size_m / 2.0 * map.scale).max(3.0);
        let burns = figures.lit_ms.is_some() && figures.out_ms.is_none();
        let largest = figures.size_m.max(fire.spec.size_m);
        if largest > fire.spec.size_m * 1.05 {
            let style = format!("fill=\"none\" stroke=\"{colour}\" stroke-dasharray=\"3 3\"");
            canvas.circle(middle, radius(largest), &style);
        }
        let fill = match (burns, figures.lit_ms) {
            (true, _) => format!("fill=\"{BAD}\" fill-opacity=\"0.75\""),
            (false, Some(_)) => format!("fill=\"{colour}\" fill-opacity=\"0.22\""),
            (false, None) => "fill=\"none\"".to_owned(),
        };
        let style =
            format!("{fill} stroke=\"{colour}\" stroke-width=\"2.2\" stroke-dasharray=\"{dash}\"");
        canvas.circle(middle, radius(fire.spec.size_m), &style);
        let fate = match (figures.lit_ms, figures.out_ms) {
            (None, _) => text::PlanNeverBurned.str(lang).to_owned(),
            (_, Some(out_ms)) => {
                let at = clock(out_ms);
                format!("{} {}", text::PlanOut.str(lang), at.trim())
            }
            (_, None) => text::PlanBurns.str(lang).to_owned(),
        };
        let name = &exercise.fires[index].name;
        let below = middle.1 + radius(largest.min(fire.spec.size_m * 2.0)) + 14.0;
        let text = Type::new(12.0, INK).at(Anchor::Middle).bold();
        canvas.label((middle.0, below), text, name);
        canvas.label((middle.0, below + 14.0), text, &fate);
    }
}

fn monitors(canvas: &mut Canvas, outcome: &Outcome, map: &Map) {
    let exercise = &outcome.exercise;
    for (index, monitor) in exercise.site.monitors.iter().enumerate() {
        let (colour, _) = MONITORS[index % MONITORS.len()];
        let (x, y) = map.at(monitor.pose.at);
        let ahead = map.at(place(&monitor.pose, 0.0, 18.0 / map.scale));
        canvas.line(
            (x, y),
            ahead,
            &format!("stroke=\"{colour}\" stroke-width=\"4\" stroke-linecap=\"round\""),
        );
        canvas.circle(
            (x, y),
            7.5,
            &format!("fill=\"{colour}\" stroke=\"#ffffff\" stroke-width=\"2\""),
        );
        let text = Type::new(13.0, colour).bold();
        // Behind the monitor, where its barrel is not.
        let behind = map.at(place(&monitor.pose, 180.0, 20.0 / map.scale));
        canvas.label((behind.0 - 9.0, behind.1 + 5.0), text, &exercise.monitors[index].name);
    }
}

fn scale_bar(canvas: &mut Canvas, lang: Lang, map: &Map, at: (f64, f64), width_m: f64) {
    let length_m = tick(width_m, 6.0);
    let length = length_m * map.scale;
    let text = format!("{length_m:.0} {}", text::UnitM.str(lang));
    canvas.rect(
        at.0 - 6.0,
        at.1 - 20.0,
        length + 14.0,
        28.0,
        "fill=\"#ffffff\" fill-opacity=\"0.85\" rx=\"3\"",
    );
    canvas.line(at, (at.0 + length, at.1), &format!("stroke=\"{INK}\" stroke-width=\"3\""));
    let middle = Type::new(11.0, INK).at(Anchor::Middle);
    canvas.text((at.0 + length / 2.0, at.1 - 6.0), middle, &text);
}

/// North, and the wind at the beginning.
fn compass(canvas: &mut Canvas, outcome: &Outcome, lang: Lang, at: (f64, f64)) {
    let exercise = &outcome.exercise;
    let wind = exercise.site.wind;
    canvas.rect(
        at.0 - 34.0,
        at.1 - 38.0,
        70.0,
        96.0,
        "fill=\"#ffffff\" fill-opacity=\"0.88\" rx=\"4\"",
    );
    let middle = Type::new(11.0, INK).at(Anchor::Middle);
    canvas.text((at.0, at.1 - 24.0), middle.bold(), text::North.str(lang));
    let north = format!("M{:.1} {:.1}l5 10h-10z", at.0, at.1 - 21.0);
    canvas.path(&north, &format!("fill=\"{INK}\""));
    canvas.circle(at, 11.0, &format!("fill=\"none\" stroke=\"{FAINT}\""));
    let text = if exercise.indoors {
        text::Indoors.str(lang).to_owned()
    } else if wind.speed_mps < 0.05 {
        text::Calm.str(lang).to_owned()
    } else {
        let from = wind.from_deg.to_radians();
        let toward = (-libm::sin(from), libm::cos(from));
        let start = (at.0 - toward.0 * 16.0, at.1 - toward.1 * 16.0);
        let tip = (at.0 + toward.0 * 16.0, at.1 + toward.1 * 16.0);
        canvas.line(start, tip, &format!("stroke=\"{INK}\" stroke-width=\"2\""));
        for side in [-0.5_f64, 0.5] {
            let (sin, cos) = (libm::sin(side), libm::cos(side));
            let back = (
                -(toward.0 * cos - toward.1 * sin) * 8.0,
                -(toward.0 * sin + toward.1 * cos) * 8.0,
            );
            canvas.line(
                tip,
                (tip.0 + back.0, tip.1 + back.1),
                &format!("stroke=\"{INK}\" stroke-width=\"2\""),
            );
        }
        let unit = text::UnitMps.str(lang);
        format!("{:.0} {unit}", wind.speed_mps)
    };
    canvas.text((at.0, at.1 + 34.0), middle, &text);
    if wind.gusts_mps > 0.05 && !exercise.indoors {
        let most = wind.speed_mps + wind.gusts_mps;
        let gusts = text::Gusts { most: format_args!("{most:.0}") }.of(lang);
        canvas.text((at.0, at.1 + 49.0), middle, &gusts);
    }
}
