//! The place of a fire from one station: its line of sight cut with tank roofs, walls and the floor.

use lafet_texts::place as text;
use serde::{Deserialize, Serialize};

use crate::linear::{self, Matrix, Vector};
use crate::locate::{Fix, check};
use crate::station::{Bearing, Station};
use crate::text::{Problem, counted, within};
use crate::{FARTHEST_M, OBSTACLES_MAX, Place};

/// The line of sight meets a surface no flatter than this, as a sine, and than so many standard errors.
const FLATTEST: f64 = 0.02;
const FLATTEST_SIGMAS: f64 = 4.0;
/// Nothing nearer to the station is looked at, m.
const NEAREST_M: f64 = 0.1;
/// Scale of the 95 % ellipse, on which it is looked whether another surface is met.
const AROUND: f64 = 2.448;
const AROUND_POINTS: usize = 12;

/// A flat surface on which there can be a fire.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Surface {
    /// Without end, through a point, at right angles to a normal: a floor.
    Plane {
        /// A point of it.
        at: Place,
        /// At right angles to it, of any length.
        normal: [f64; 3],
    },
    /// A wall or a flat roof: a corner and two sides at right angles.
    Rectangle {
        /// A corner.
        corner: Place,
        /// From there along one side, m.
        side: [f64; 3],
        /// And along the other, m.
        other: [f64; 3],
    },
    /// A tank roof.
    Disc {
        /// Its centre.
        centre: Place,
        /// At right angles to it, of any length.
        normal: [f64; 3],
        /// Radius, m.
        radius_m: f64,
    },
}

/// Where the cone of a bearing meets a surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cut {
    /// The place with its covariance.
    pub fix: Fix,
    /// Index of the surface.
    pub surface: usize,
    /// Whether all of the cone (95 %) meets the same surface; if not, the fire may be on another one.
    pub whole: bool,
}

impl Surface {
    /// A level floor.
    pub const fn floor(height_m: f64) -> Self {
        Self::Plane { at: [0.0, 0.0, height_m], normal: [0.0, 0.0, 1.0] }
    }

    /// Refuses what is no number or no surface.
    pub fn check(&self) -> Result<(), Problem> {
        let (vectors, normal) = match *self {
            Self::Plane { at, normal } => ([at, normal, normal], normal),
            Self::Rectangle { corner, side, other } => {
                let product = linear::dot(side, other).abs();
                if product > 1e-3 * linear::length(side) * linear::length(other) {
                    return Err(Problem::new(text::RectangleSkew));
                }
                ([corner, side, other], linear::cross(side, other))
            }
            Self::Disc { centre, normal, radius_m } => {
                within(&text::DiscRadius, radius_m, 0.01..=1000.0)?;
                ([centre, normal, normal], normal)
            }
        };
        for value in vectors.into_iter().flatten() {
            let what = &text::SurfaceCoordinate;
            within(what, value, -FARTHEST_M..=FARTHEST_M)?;
        }
        let what = &text::NormalLength;
        within(what, linear::length(normal), 1e-6..=1e9)
    }

    fn plane(&self) -> (Place, Vector) {
        let (at, normal) = match *self {
            Self::Plane { at, normal } => (at, normal),
            Self::Rectangle { corner, side, other } => (corner, linear::cross(side, other)),
            Self::Disc { centre, normal, .. } => (centre, normal),
        };
        let length = linear::length(normal);
        (at, normal.map(|x| x / length))
    }

    /// How far along a line its plane is met.
    fn distance(&self, from: Place, line: Vector) -> Option<f64> {
        let (at, normal) = self.plane();
        let way = linear::dot(linear::minus(at, from), normal) / linear::dot(line, normal);
        (way.is_finite() && way > NEAREST_M && way < 2.0 * FARTHEST_M).then_some(way)
    }

    /// Whether a point of its plane belongs to it.
    fn has(&self, place: Place) -> bool {
        match *self {
            Self::Plane { .. } => true,
            Self::Rectangle { corner, side, other } => {
                let from = linear::minus(place, corner);
                let part = |side: Vector| linear::dot(from, side) / linear::dot(side, side);
                (0.0..=1.0).contains(&part(side)) && (0.0..=1.0).contains(&part(other))
            }
            Self::Disc { centre, radius_m, .. } => {
                linear::length(linear::minus(place, centre)) <= radius_m
            }
        }
    }
}

/// Cuts the cone of a bearing with the nearest surface that its line of sight meets.
pub fn cut(station: &Station, bearing: &Bearing, surfaces: &[Surface]) -> Result<Cut, Problem> {
    let bearing = Bearing { station: 0, ..*bearing };
    check(std::slice::from_ref(station), std::slice::from_ref(&bearing), 0.0)?;
    counted(&text::Surfaces, surfaces.len(), 1..=OBSTACLES_MAX)?;
    surfaces.iter().try_for_each(Surface::check)?;
    let Some(elevation) = bearing.elevation else {
        return Err(Problem::new(text::OneStationNeedsElevation));
    };
    let line = station.direction(bearing.azimuth, elevation);
    let (surface, way) =
        nearest(station.at, line, surfaces).ok_or_else(|| Problem::new(text::SightMeetsNothing))?;
    let (across, up) = bearing.errors(station);
    let (_, normal) = surfaces[surface].plane();
    if linear::dot(line, normal).abs() < FLATTEST.max(FLATTEST_SIGMAS * up) {
        return Err(Problem::new(text::SightTooFlat));
    }
    let at = linear::along(station.at, line, way);
    let sides = [(across, 0.0), (0.0, up)].map(|(turned, raised)| {
        let line = station.direction(bearing.azimuth + turned, elevation + raised);
        shift(&surfaces[surface], station.at, line, at)
    });
    let raised = linear::along(station.at, [0.0, 0.0, 1.0], station.height_sigma_m);
    let lifted = shift(&surfaces[surface], raised, line, at);
    let mut covariance: Matrix = [[0.0; 3]; 3];
    for side in sides.into_iter().chain([lifted]) {
        linear::add_outer(&mut covariance, side, 1.0);
    }
    let whole = (0..AROUND_POINTS).all(|index| {
        let angle = std::f64::consts::TAU * index as f64 / AROUND_POINTS as f64;
        let (sin, cos) = angle.sin_cos();
        let turned = bearing.azimuth + AROUND * across * cos;
        let line = station.direction(turned, elevation + AROUND * up * sin);
        nearest(station.at, line, surfaces).is_some_and(|(other, _)| other == surface)
    });
    let fix = Fix {
        at: [at[0], at[1]],
        height_m: Some(at[2]),
        covariance,
        used: vec![0],
        rejected: Vec::new(),
        misfit: (0.0, 0),
    };
    Ok(Cut { fix, surface, whole })
}

/// The nearest surface that a line meets, and how far away.
fn nearest(from: Place, line: Vector, surfaces: &[Surface]) -> Option<(usize, f64)> {
    let met = surfaces.iter().enumerate().filter_map(|(index, surface)| {
        let way = surface.distance(from, line)?;
        surface.has(linear::along(from, line, way)).then_some((index, way))
    });
    met.min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// By how much another line meets the plane of a surface elsewhere.
fn shift(surface: &Surface, from: Place, line: Vector, at: Place) -> Vector {
    let way = surface.distance(from, line).unwrap_or(2.0 * FARTHEST_M);
    linear::minus(linear::along(from, line, way), at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;
    use crate::station::tests::{bearing, station};

    const SIGMA: f64 = 0.2 * std::f64::consts::PI / 180.0;

    fn sight(station: &Station, place: Place) -> Bearing {
        let (azimuth, elevation) = station.sees(place);
        bearing(0, azimuth, Some(elevation), SIGMA)
    }

    #[test]
    fn floor_roof_and_wall() {
        let high = station(0.0, 0.0, 15.0);
        let surfaces = [
            Surface::floor(0.0),
            Surface::Disc { centre: [10.0, 30.0, 8.0], normal: [0.0, 0.0, 1.0], radius_m: 6.0 },
            Surface::Rectangle {
                corner: [-40.0, 50.0, 0.0],
                side: [30.0, 0.0, 0.0],
                other: [0.0, 0.0, 20.0],
            },
        ];
        for (surface, place) in
            [(0, [-3.0, 20.0, 0.0]), (1, [11.0, 31.0, 8.0]), (2, [-20.0, 50.0, 7.0])]
        {
            let cut = cut(&high, &sight(&high, place), &surfaces).unwrap();
            assert_eq!((cut.surface, cut.whole), (surface, true), "{cut:?}");
            let [x, y] = cut.fix.at;
            let miss = [x - place[0], y - place[1], cut.fix.height_m.unwrap() - place[2]];
            assert!(linear::length(miss) < 1e-9, "{cut:?}");
        }
        // At the edge of the roof, part of the cone falls on the floor behind.
        let edge = cut(&high, &sight(&high, [10.0, 35.95, 8.0]), &surfaces).unwrap();
        assert!(edge.surface == 1 && !edge.whole, "{edge:?}");
    }

    /// One station 6 m high, 0.2°: the ellipse holds the fire as often as it says.
    #[test]
    fn the_ellipse_holds_the_fire() {
        let one = station(0.0, 0.0, 6.0);
        let fire = [5.0, 25.0, 0.0];
        let mut draw = Draw::new(5);
        let mut misses = Vec::new();
        let mut inside = 0;
        for _ in 0..4000 {
            let exact = sight(&one, fire);
            let bearing = Bearing {
                azimuth: exact.azimuth + SIGMA * draw.error(),
                elevation: exact.elevation.map(|elevation| elevation + SIGMA * draw.error()),
                ..exact
            };
            let cut = cut(&one, &bearing, &[Surface::floor(0.0)]).unwrap();
            misses.push((cut.fix.at[0] - fire[0]).hypot(cut.fix.at[1] - fire[1]));
            inside += usize::from(cut.fix.holds([fire[0], fire[1]], 0.95).unwrap());
        }
        misses.sort_by(f64::total_cmp);
        assert!((0.6..0.9).contains(&misses[3800]), "{}", misses[3800]);
        assert!((3720..=3880).contains(&inside), "{inside}");
    }

    #[test]
    fn a_wrong_height_widens_it() {
        let sure = station(0.0, 0.0, 6.0);
        let unsure = Station { height_sigma_m: 0.5, ..sure };
        let place = [0.0, 25.0, 0.0];
        let width = |station: &Station| {
            let cut = cut(station, &sight(station, place), &[Surface::floor(0.0)]).unwrap();
            cut.fix.ellipse(0.95).unwrap().major_m
        };
        // Half a metre of height is two metres of distance at this angle.
        let expected = 2.448 * 0.5 * 25.0 / 6.0;
        assert!(width(&sure) < 1.2 && (width(&unsure) - expected).abs() < 0.3);
    }

    #[test]
    fn refusals() {
        let one = station(0.0, 0.0, 6.0);
        let floor = [Surface::floor(0.0)];
        let blind = bearing(0, 0.0, None, SIGMA);
        assert!(cut(&one, &blind, &floor).unwrap_err().0.en.contains("elevation"));
        let up = bearing(0, 0.0, Some(0.3), SIGMA);
        assert!(cut(&one, &up, &floor).unwrap_err().0.en.contains("no surface"));
        let flat = bearing(0, 0.0, Some(-0.01), SIGMA);
        assert!(cut(&one, &flat, &floor).unwrap_err().0.en.contains("too flat"));
        let nan =
            Surface::Disc { centre: [f64::NAN, 0.0, 0.0], normal: [0.0, 0.0, 1.0], radius_m: 1.0 };
        assert!(cut(&one, &sight(&one, [0.0, 9.0, 0.0]), &[nan]).is_err());
        let skew =
            Surface::Rectangle { corner: [0.0; 3], side: [1.0, 0.0, 0.0], other: [1.0, 1.0, 0.0] };
        assert!(skew.check().unwrap_err().0.ru.contains("перпендикулярны"));
        assert!(Surface::Plane { at: [0.0; 3], normal: [0.0; 3] }.check().is_err());
    }
}
