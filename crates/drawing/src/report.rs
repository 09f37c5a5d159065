//! What a person sees of a drawing: sizes in metres, so that a wrong unit is seen at once.

use std::collections::BTreeSet;

use lafet_texts::{Decimal, Lang, Text as _, drawing as text};

use crate::placing::{Known, Placed};
use crate::shape::Extent;
use crate::site::{Chosen, PLANNED_MAX, Plan};
use crate::{Drawing, Geodetic, Geometry, Stated, Unit};

/// Most names in a line.
const SHOWN: usize = 20;

/// Kinds of shapes of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Circles, and closed lines that go around one.
    pub circles: usize,
    /// Other lines.
    pub lines: usize,
    /// Points, those of inserted blocks included.
    pub points: usize,
}

/// What each layer has.
pub fn counts(drawing: &Drawing) -> Vec<Counts> {
    let mut all = vec![Counts::default(); drawing.layers.len()];
    for shape in &drawing.shapes {
        let Some(counts) = all.get_mut(shape.layer) else { continue };
        match &shape.geometry {
            Geometry::Circle { .. } => counts.circles += 1,
            Geometry::Point(_) => counts.points += 1,
            Geometry::Path { points, closed: true } if crate::curve::round(points).is_some() => {
                counts.circles += 1;
            }
            Geometry::Path { .. } => counts.lines += 1,
        }
    }
    all
}

/// How large a drawing would be in each unit: its symbol, width and height in metres.
pub fn sizes(drawing: &Drawing) -> Vec<(&'static str, [f64; 2])> {
    let Some([least, most]) = drawing.extent(None) else { return Vec::new() };
    let size = |scale: f64| [0, 1].map(|k| (most[k] - least[k]) * scale);
    let mut sizes: Vec<_> =
        Unit::ALL.into_iter().map(|unit| (unit.name(), size(unit.metres()))).collect();
    if drawing.format == crate::Format::GeoJson
        && let Some(on_earth) = on_earth([least, most])
    {
        sizes.insert(0, ("wgs84", on_earth));
    }
    sizes
}

/// Width and height of degrees, if they are a place on the Earth of the size of a site.
fn on_earth([least, most]: Extent) -> Option<[f64; 2]> {
    let corner = Geodetic::new(least[1], least[0]).ok()?;
    let at = |x: f64, y: f64| Geodetic::new(y, x).ok()?.east_north(corner).ok();
    Some([at(most[0], least[1])?[0], at(least[0], most[1])?[1]])
}

/// That the unit of a drawing has to be stated, and what it would be in each.
pub fn unit_missing(drawing: &Drawing, lang: Lang) -> String {
    let what = text::UnitMissing { names: Stated::names() }.of(lang);
    format!("{what}\n\n{}", overview(drawing, lang))
}

/// A drawing as it was read, line by line: what there is to be stated about it.
pub fn overview(drawing: &Drawing, lang: Lang) -> String {
    let format = drawing.format.name();
    let mut lines = Vec::new();
    if let Some([width, height]) = drawing.pixels {
        lines.push(text::ShowPicture { format, width, height }.of(lang));
        return lines.join("\n");
    }
    lines.push(match (drawing.proposed, &drawing.reference) {
        (Some(unit), _) => text::ShowProposed { format, unit: unit.name() }.of(lang),
        (None, Some(name)) => text::ShowReference { format, name }.of(lang),
        (None, None) => text::ShowNoUnit { format }.of(lang),
    });
    if let Some([width, height]) = &drawing.paper {
        lines.push(text::ShowPaper { width, height }.of(lang));
    }
    if let Some([least, most]) = drawing.extent(None) {
        let [x, y] = least.map(|it| Decimal(it, 5));
        let [to_x, to_y] = most.map(|it| Decimal(it, 5));
        lines.push(text::ShowExtent { x, y, to_x, to_y }.of(lang));
        lines.push(text::ShowSizes.of(lang));
        for (unit, size) in sizes(drawing) {
            let [width, height] = size.map(metres);
            lines.push(format!("  {unit:>6}  {}", text::Size { width, height }.of(lang)));
        }
    }
    lines.push(text::ShowLayers.of(lang));
    for (layer, counts) in drawing.layers.iter().zip(counts(drawing)) {
        let Counts { circles, lines: paths, points } = counts;
        let name = &layer.name;
        let counted = text::ShowLayer { name, circles, paths, points }.of(lang);
        let hidden = if layer.hidden { text::ShowHidden.of(lang) } else { String::new() };
        lines.push(format!("  {counted}{hidden}"));
    }
    lines.extend(skipped(drawing, lang));
    lines.join("\n")
}

fn skipped(drawing: &Drawing, lang: Lang) -> Option<String> {
    let kinds: Vec<String> =
        drawing.skipped.iter().map(|(kind, count)| format!("{kind} {count}")).collect();
    (!kinds.is_empty()).then(|| text::ShowSkipped { kinds: kinds.join(", ") }.of(lang))
}

/// A placed drawing and what came of it, line by line.
pub fn summary(
    placed: &Placed,
    known: &Known,
    chosen: &[Chosen],
    plan: &Plan,
    lang: Lang,
) -> Vec<String> {
    let format = placed.drawing.format.name();
    let [width, height] = placed.size.map(metres);
    let unit = match known.stated {
        Stated::Unit(unit) => unit.name(),
        Stated::Wgs84 => "wgs84",
        Stated::Points => "points",
    };
    let north = Decimal(placed.placing.north_deg(), 2);
    let mut lines = vec![text::SummarySize { format, unit, width, height }.of(lang)];
    lines.push(match known.stated {
        Stated::Wgs84 => text::SummaryTrueNorth.of(lang),
        _ => text::SummaryNorth { north }.of(lang),
    });
    lines.push(match placed.checked {
        Some(it) if it.count > 0 => {
            let (count, worst) = (it.count, Decimal(it.worst_m, 3));
            let percent = Decimal(100.0 * it.worst, 3);
            match it.ratio {
                Some(ratio) => {
                    let off = Decimal(100.0 * (ratio - 1.0), 3);
                    text::SummaryChecked { count, worst, percent, off }.of(lang)
                }
                None => text::SummaryScaled { count, worst, percent }.of(lang),
            }
        }
        _ => text::SummaryUnchecked.of(lang),
    });
    let (tanks, walls) = (plan.tanks.len(), plan.walls.len());
    let (monitors, detectors) = (plan.monitors.len(), plan.detectors.len());
    lines.push(text::SummaryFound { tanks, walls, monitors, detectors }.of(lang));
    if let Some([least, most]) = plan.extent {
        let [west, south] = least.map(|it| Decimal(it, 1));
        let [east, north] = most.map(|it| Decimal(it, 1));
        lines.push(text::SummaryExtent { west, east, south, north }.of(lang));
    }
    if tanks + walls > PLANNED_MAX {
        lines.push(text::SummaryMany { most: PLANNED_MAX }.of(lang));
    }
    lines.extend(plan.left_out.iter().map(|it| it.words().of(lang).to_owned()));
    lines.extend(unused(&placed.drawing, chosen, lang));
    lines.extend(skipped(&placed.drawing, lang));
    lines
}

/// Layers that have something and are not used.
fn unused(drawing: &Drawing, chosen: &[Chosen], lang: Lang) -> Option<String> {
    let is_used =
        |name: &str| chosen.iter().any(|it| it.layer.to_lowercase() == name.to_lowercase());
    let full: BTreeSet<usize> = drawing.shapes.iter().map(|it| it.layer).collect();
    let named = full.into_iter().filter_map(|index| drawing.layers.get(index));
    let names: Vec<&str> = named.map(|it| it.name.as_str()).filter(|name| !is_used(name)).collect();
    let shown = names.iter().take(SHOWN).copied().collect::<Vec<_>>().join(", ");
    let more = if names.len() > SHOWN { ", …" } else { "" };
    (!names.is_empty()).then(|| text::SummaryUnused { names: format!("{shown}{more}") }.of(lang))
}

/// Metres as a person reads them: fewer digits for more.
fn metres(metres: f64) -> Decimal {
    let digits = match metres.abs() {
        it if it < 10.0 => 3,
        it if it < 1000.0 => 1,
        _ => 0,
    };
    Decimal(metres, digits)
}
