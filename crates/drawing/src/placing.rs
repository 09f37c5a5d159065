//! From a drawing to the site: one scale, one turn, one offset, and what checks them.

use lafet_texts::{Decimal, drawing as text};

use crate::fit::{self, Turn};
use crate::shape::Extent;
use crate::{Drawing, Format, Geodetic, Geometry, Height, Problem, Stated, Unit};

/// Known distances and points may differ from the drawing by this part, to be taken for the same.
const SAME: f64 = 0.01;
/// Known points are this part of the drawing's extent apart, or more: nearer ones turn errors into large ones.
const APART: f64 = 0.1;
/// Most known points, and most known distances.
pub const KNOWN_MAX: usize = 50;
/// A drawing is not smaller than this, m: a wrong unit would make it so.
const LEAST_M: f64 = 1.0;
/// What is placed is not larger, and not farther from the zero of the site, m: the planner computes no farther.
pub const FARTHEST_M: f64 = 10_000.0;

/// What a person states about a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    /// What its coordinates are.
    pub stated: Stated,
    /// How many times larger the site is than the paper: 500 for 1:500.
    pub scale: f64,
    /// Places of the drawing and of the site, m.
    pub points: Vec<Pair>,
    /// Places of the drawing and of the Earth; they need `zero`.
    pub on_earth: Vec<([f64; 2], Geodetic)>,
    /// Two places of the drawing and their distance, m.
    pub distances: Vec<Distance>,
    /// The place of the drawing that is the zero of the site.
    pub origin: Option<[f64; 2]>,
    /// Where north is on the drawing: degrees clockwise from its upper edge.
    pub north_deg: Option<f64>,
    /// The zero of the site.
    pub zero: Option<Geodetic>,
}

impl Known {
    /// The unit alone.
    pub const fn of(stated: Stated) -> Self {
        Self {
            stated,
            scale: 1.0,
            points: Vec::new(),
            on_earth: Vec::new(),
            distances: Vec::new(),
            origin: None,
            north_deg: None,
            zero: None,
        }
    }
}

/// A place of the drawing that is known on the site.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// On the drawing.
    pub drawn: [f64; 2],
    /// East and north, m.
    pub site: [f64; 2],
}

/// A known distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Two places of the drawing.
    pub ends: [[f64; 2]; 2],
    /// m.
    pub metres: f64,
}

/// How a drawing is placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placing {
    /// Metres for a unit of the drawing.
    pub scale: f64,
    /// To the left, rad.
    pub turn: f64,
    /// -1 where y runs downward.
    y: f64,
    /// A place as seen, and where it is on the site.
    pivot: [f64; 2],
    onto: [f64; 2],
}

impl Placing {
    /// East and north of the zero of the site, m.
    pub fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (x, y) = (x - self.pivot[0], self.y * y - self.pivot[1]);
        let (sin, cos) = self.turn.sin_cos();
        [
            self.onto[0] + self.scale * (cos * x - sin * y),
            self.onto[1] + self.scale * (sin * x + cos * y),
        ]
    }

    /// A height, m.
    pub fn height(&self, height: Height) -> f64 {
        match height {
            Height::Drawn(drawn) => drawn * self.scale,
            Height::Metres(metres) => metres,
        }
    }

    /// Where north is on the drawing: degrees clockwise from its upper edge, 0 to 360.
    pub fn north_deg(&self) -> f64 {
        let north = self.turn.to_degrees().rem_euclid(360.0);
        if north > 359.9995 { 0.0 } else { north }
    }
}

/// How well what is known agrees with the drawing as placed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Checked {
    /// How many points or distances are known.
    pub count: usize,
    /// Farthest that one of them is off, m.
    pub worst_m: f64,
    /// The same as a part of the length that is known.
    pub worst: f64,
    /// The scale of what is known, as a part of the stated one; none if it is the stated one.
    pub ratio: Option<f64>,
}

/// A drawing with its placing.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// In plane coordinates: degrees are metres from the zero by now.
    pub drawing: Drawing,
    /// How it lies on the site.
    pub placing: Placing,
    /// What checked it; none if nothing was known but the unit.
    pub checked: Option<Checked>,
    /// Width and height of all that is drawn, m, upright as drawn.
    pub size: [f64; 2],
}

/// Places a drawing.
///
/// # Errors
///
/// What is stated is not enough, does not agree, or puts the drawing where no site is.
pub fn place(drawing: Drawing, known: &Known) -> Result<Placed, Problem> {
    check(known)?;
    let pixels = drawing.pixels.is_some();
    if pixels && known.stated != Stated::Points {
        return Err(Problem::new(text::PictureUnit, text::PictureUnitRemedy));
    }
    let drawing = if known.stated == Stated::Wgs84 { on_plane(drawing, known)? } else { drawing };
    let y = if drawing.y_down { -1.0 } else { 1.0 };
    let known = seen(known, y)?;
    let extent = drawing.extent(None).ok_or_else(|| {
        Problem::new(text::Empty { format: drawing.format.name() }, text::EmptyRemedy)
    })?;
    let (scale, checked) = scale(&drawing, &known, drawing.bulk().unwrap_or(extent))?;
    let (turn, pivot, onto) = match fit::turn(&known.pairs) {
        Some(Turn { angle, .. }) => {
            let (drawn, site): (Vec<_>, Vec<_>) = known.pairs.iter().copied().unzip();
            let middle = |points: &[[f64; 2]]| fit::mean(points).unwrap_or_default();
            (angle, middle(&drawn), middle(&site))
        }
        None => (known.north_deg.to_radians(), known.origin, [0.0; 2]),
    };
    let placing = Placing { scale, turn, y, pivot, onto };
    let checked = checked.map(|it| with_residuals(it, &placing, &known)).transpose()?;
    let size = [0, 1].map(|k| (extent[1][k] - extent[0][k]) * scale);
    if size[0].max(size[1]) < LEAST_M && !pixels {
        let [width, height] = size.map(|it| Decimal(it, 3));
        return Err(Problem::new(text::TooSmall { width, height }, text::TooSmallRemedy));
    }
    Ok(Placed { drawing, placing, checked, size })
}

fn check(known: &Known) -> Result<(), Problem> {
    let Known { points, on_earth, distances, .. } = known;
    if points.len() + on_earth.len() > KNOWN_MAX || distances.len() > KNOWN_MAX {
        return Err(Problem::new(text::TooManyKnown { most: KNOWN_MAX }, text::KnownRemedy));
    }
    let count = points.len() + on_earth.len();
    if count == 1 {
        return Err(Problem::new(text::OnePoint, text::OnePointRemedy));
    }
    if count > 0 && (known.north_deg.is_some() || known.origin.is_some()) {
        return Err(Problem::new(text::PointsAndNorth, text::PointsAndNorthRemedy));
    }
    if !on_earth.is_empty() && known.zero.is_none() {
        return Err(Problem::new(text::NoZero, text::NoZeroRemedy));
    }
    if !(known.scale.is_finite() && (1e-3..=1e6).contains(&known.scale)) {
        return Err(Problem::new(text::NoScale, text::NoScaleRemedy));
    }
    let numbers = known.origin.iter().flatten().chain(&known.north_deg);
    let pairs = points.iter().flat_map(|it| it.drawn.iter().chain(&it.site));
    let earth = on_earth.iter().flat_map(|it| &it.0);
    let ends = distances.iter().flat_map(|it| it.ends.iter().flatten());
    let fine =
        numbers.chain(pairs).chain(earth).chain(ends).all(|it| it.abs() <= crate::COORDINATE_MAX);
    let long = distances.iter().all(|it| it.metres > 0.0 && it.metres <= 2.0 * FARTHEST_M);
    if fine && long {
        return Ok(());
    }
    Err(Problem::new(text::NoPlace, text::KnownRemedy))
}

/// Degrees as metres from the zero.
fn on_plane(mut drawing: Drawing, known: &Known) -> Result<Drawing, Problem> {
    if drawing.format != Format::GeoJson {
        return Err(Problem::new(text::NotDegrees, text::NotDegreesRemedy));
    }
    if let Some(name) = drawing.reference {
        return Err(Problem::new(text::OtherReference { name }, text::OtherReferenceRemedy));
    }
    let Some(zero) = known.zero else {
        return Err(Problem::new(text::NoZero, text::NoZeroRemedy));
    };
    let more = !known.points.is_empty() || !known.on_earth.is_empty() || known.scale != 1.0;
    if more || known.origin.is_some() || known.north_deg.is_some() {
        return Err(Problem::new(text::Wgs84Alone, text::Wgs84AloneRemedy));
    }
    let local = |[x, y]: [f64; 2]| Geodetic::new(y, x)?.east_north(zero);
    for shape in &mut drawing.shapes {
        match &mut shape.geometry {
            Geometry::Point(at) | Geometry::Circle { at, .. } => *at = local(*at)?,
            Geometry::Path { points, .. } => {
                for at in points {
                    *at = local(*at)?;
                }
            }
        }
    }
    Ok(drawing)
}

/// What is known, with places as they are seen: y upward.
struct Seen {
    stated: Stated,
    paper: f64,
    pairs: Vec<([f64; 2], [f64; 2])>,
    distances: Vec<([[f64; 2]; 2], f64)>,
    origin: [f64; 2],
    north_deg: f64,
}

fn seen(known: &Known, y: f64) -> Result<Seen, Problem> {
    let up = |at: [f64; 2]| [at[0], y * at[1]];
    let mut pairs: Vec<_> = known.points.iter().map(|it| (up(it.drawn), it.site)).collect();
    for (drawn, place) in &known.on_earth {
        let zero = known.zero.unwrap_or(*place);
        pairs.push((up(*drawn), place.east_north(zero)?));
    }
    let local = |ends: [[f64; 2]; 2]| match (known.stated, known.zero) {
        // The ends of a known distance are written in degrees as well.
        (Stated::Wgs84, Some(zero)) => {
            let [a, b] = ends.map(|[x, y]| Geodetic::new(y, x)?.east_north(zero));
            Ok([a?, b?])
        }
        _ => Ok(ends.map(up)),
    };
    let distances: Result<Vec<_>, Problem> =
        known.distances.iter().map(|it| Ok((local(it.ends)?, it.metres))).collect();
    Ok(Seen {
        stated: known.stated,
        paper: known.scale,
        pairs,
        distances: distances?,
        origin: up(known.origin.unwrap_or_default()),
        north_deg: known.north_deg.unwrap_or_default(),
    })
}

/// Metres for a unit of the drawing.
fn scale(
    drawing: &Drawing,
    known: &Seen,
    extent: Extent,
) -> Result<(f64, Option<Checked>), Problem> {
    let measured = measured(known, extent)?;
    let count = known.pairs.len() + known.distances.len();
    let stated = match known.stated {
        Stated::Wgs84 => 1.0,
        Stated::Unit(unit) => unit.metres() * known.paper,
        Stated::Points => {
            let scale = measured
                .ok_or_else(|| Problem::new(text::PointsMissing, text::PointsMissingRemedy))?;
            return Ok((scale, Some(Checked { count, ..Checked::default() })));
        }
    };
    let Some(measured) = measured else {
        return match (known.stated, drawing.proposed) {
            (Stated::Unit(unit), Some(proposed)) if unit != proposed => {
                let (drawn, stated) = (proposed.name(), unit.name());
                Err(Problem::new(text::UnitDiffers { drawn, stated }, text::UnitDiffersRemedy))
            }
            _ => Ok((stated, None)),
        };
    };
    let ratio = measured / stated;
    if (ratio - 1.0).abs() <= SAME {
        return Ok((stated, Some(Checked { count, ratio: Some(ratio), ..Checked::default() })));
    }
    let times = Decimal(ratio, if ratio < 10.0 { 4 } else { 1 });
    let meant = Unit::near(measured / known.paper).filter(|_| known.stated != Stated::Wgs84);
    Err(match meant {
        Some(unit) => {
            let unit = unit.name();
            Problem::new(text::ScaleDiffers { times }, text::ScaleDiffersUnit { unit })
        }
        None => Problem::new(text::ScaleDiffers { times }, text::ScaleDiffersRemedy),
    })
}

/// The scale by all that is known, if anything is; refused if it does not agree with itself.
fn measured(known: &Seen, extent: Extent) -> Result<Option<f64>, Problem> {
    let [least, most] = extent;
    let apart = APART * (most[0] - least[0]).hypot(most[1] - least[1]);
    let too_near = || {
        let percent = Decimal(100.0 * APART, 0);
        Problem::new(text::TooNear { percent }, text::TooNearRemedy)
    };
    let mut scales = Vec::new();
    if !known.pairs.is_empty() {
        let turn = fit::turn(&known.pairs).ok_or_else(too_near)?;
        // Two points are twice the mean distance to their middle apart.
        if 2.0 * turn.spread.sqrt() < apart {
            return Err(too_near());
        }
        scales.push(turn.scale);
    }
    for ([a, b], metres) in &known.distances {
        let drawn = (a[0] - b[0]).hypot(a[1] - b[1]);
        if drawn == 0.0 || drawn < apart {
            return Err(too_near());
        }
        scales.push(metres / drawn);
    }
    let Some(first) = scales.first().copied() else { return Ok(None) };
    let mean = scales.iter().sum::<f64>() / scales.len() as f64;
    if scales.iter().any(|it| (it / first - 1.0).abs() > SAME) {
        let list: Vec<f64> = scales.iter().map(|it| it / first).collect();
        let least = list.iter().copied().fold(f64::INFINITY, f64::min);
        let most = list.iter().copied().fold(0.0, f64::max);
        let times = Decimal(most / least, 4);
        return Err(Problem::new(text::KnownDiffer { times }, text::KnownRemedy));
    }
    Ok(Some(mean))
}

/// How far what is known is off, as placed. What is off by more than a hundredth is a mistake.
fn with_residuals(
    mut checked: Checked,
    placing: &Placing,
    known: &Seen,
) -> Result<Checked, Problem> {
    let seen = Placing { y: 1.0, ..*placing };
    let away = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let sites: Vec<[f64; 2]> = known.pairs.iter().map(|it| it.1).collect();
    let middle = fit::mean(&sites).unwrap_or_default();
    let radius = sites.iter().map(|it| away(*it, middle)).fold(0.0, f64::max);
    let points =
        known.pairs.iter().map(|(drawn, site)| (away(seen.place(*drawn), *site), 2.0 * radius));
    let distances = known
        .distances
        .iter()
        .map(|([a, b], metres)| ((away(*a, *b) * placing.scale - metres).abs(), *metres));
    for (off, length) in points.chain(distances) {
        checked.worst_m = checked.worst_m.max(off);
        checked.worst = checked.worst.max(off / length);
    }
    if checked.worst <= SAME {
        return Ok(checked);
    }
    let metres = Decimal(checked.worst_m, 2);
    let percent = Decimal(100.0 * checked.worst, 1);
    Err(Problem::new(text::PointsOff { metres, percent }, text::PointsOffRemedy))
}
