//! The alignment of a station: heading and tilt from reference fires at known places.

use lafet_texts::place as text;
use serde::Serialize;

use crate::linear::{self, Matrix, Vector, wrapped};
use crate::station::{Bearing, Station};
use crate::text::{Problem, counted, within};
use crate::{BEARINGS_MAX, FARTHEST_M, Place};

/// Fewest reference fires.
pub const REFERENCES_MIN: usize = 5;
/// References are no nearer than this: their own error would turn the station, m.
pub const NEAREST_M: f64 = 3.0;
/// Azimuths of the references lie apart at least so much, rad (40°).
pub const SPREAD_MIN: f64 = 0.698;
/// Greatest standard error of a result, rad (0.5°): more is no alignment.
pub const SIGMA_MAX: f64 = 0.008_73;
/// A residual of more standard errors than this is a wrong reference.
const GROSS: f64 = 4.0;
const ITERATIONS: usize = 20;
const SETTLED: f64 = 1e-10;
const DIFFERENCE: f64 = 1e-6;

/// A fire at a known place, and how the station saw it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// The surveyed place.
    pub at: Place,
    /// What the station reported: an elevation is needed.
    pub bearing: Bearing,
}

/// Heading and tilt of a station.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Alignment {
    /// The station with its new heading, pitch, roll and their errors.
    pub station: Station,
    /// Of each reference: how far azimuth and elevation are from the station so aligned, rad.
    pub residuals: Vec<[f64; 2]>,
    /// Root of the mean square of all residuals, rad.
    pub rms: f64,
}

/// Aligns a station whose place is known. Its heading may be unknown altogether; its tilt is within
/// 45°.
pub fn align(station: &Station, references: &[Reference]) -> Result<Alignment, Problem> {
    let what = &text::ReferenceFires;
    counted(what, references.len(), REFERENCES_MIN..=BEARINGS_MAX)?;
    station.check()?;
    let seen = references
        .iter()
        .map(|reference| seen(station, reference))
        .collect::<Result<Vec<Seen>, Problem>>()?;
    spread(&seen)?;
    let start = Station { heading: heading(&seen), pitch: 0.0, roll: 0.0, ..*station };
    let (aligned, covariance) = fit(&start, &seen)?;
    let sigmas = [0, 1, 2].map(|axis: usize| covariance[axis][axis].sqrt());
    if sigmas.iter().any(|sigma| sigma.is_nan() || *sigma > SIGMA_MAX) {
        return Err(weak());
    }
    let residuals: Vec<[f64; 2]> = seen.iter().map(|seen| seen.residual(&aligned)).collect();
    wrong(&seen, &residuals)?;
    let squares: f64 = residuals.iter().flatten().map(|x| x * x).sum();
    let station = Station {
        heading: aligned.heading.rem_euclid(std::f64::consts::TAU),
        heading_sigma: sigmas[0],
        tilt_sigma: sigmas[1].max(sigmas[2]),
        ..aligned
    };
    Ok(Alignment { station, rms: (squares / (2 * residuals.len()) as f64).sqrt(), residuals })
}

/// A reference as it counts.
struct Seen {
    at: Place,
    azimuth: f64,
    elevation: f64,
    sigma: f64,
    /// Bearing from the station, rad.
    bearing: f64,
}

fn seen(station: &Station, reference: &Reference) -> Result<Seen, Problem> {
    let bearing = Bearing { station: 0, ..reference.bearing };
    bearing.check(1)?;
    for value in reference.at {
        let what = &text::ReferencePlace;
        within(what, value, -FARTHEST_M..=FARTHEST_M)?;
    }
    let [east, north, _] = linear::minus(reference.at, station.at);
    let what = &text::ReferenceDistance;
    within(what, east.hypot(north), NEAREST_M..=FARTHEST_M)?;
    let elevation =
        bearing.elevation.ok_or_else(|| Problem::new(text::ReferenceWithoutElevation))?;
    let mounted = Station { heading_sigma: 0.0, tilt_sigma: 0.0, ..*station };
    let (sigma, _) = bearing.errors(&mounted);
    let to = east.atan2(north);
    Ok(Seen { at: reference.at, azimuth: bearing.azimuth, elevation, sigma, bearing: to })
}

impl Seen {
    fn residual(&self, station: &Station) -> [f64; 2] {
        let (azimuth, elevation) = station.sees(self.at);
        [wrapped(self.azimuth - azimuth), self.elevation - elevation]
    }
}

/// References all in one direction leave the tilt across it open.
fn spread(seen: &[Seen]) -> Result<(), Problem> {
    let mut bearings: Vec<f64> =
        seen.iter().map(|seen| seen.bearing.rem_euclid(std::f64::consts::TAU)).collect();
    bearings.sort_by(f64::total_cmp);
    let last = bearings[bearings.len() - 1] - std::f64::consts::TAU;
    let before = std::iter::once(last).chain(bearings.iter().copied());
    // The widest gap without a reference; what is left of the turn holds all of them.
    let gap = before.zip(&bearings).map(|(a, b)| b - a).fold(0.0, f64::max);
    if std::f64::consts::TAU - gap >= SPREAD_MIN { Ok(()) } else { Err(weak()) }
}

fn weak() -> Problem {
    Problem::new(text::ReferencesWeak)
}

/// The heading that fits the azimuths best without tilt: their mean on the circle.
fn heading(seen: &[Seen]) -> f64 {
    let headings = seen.iter().map(|seen| seen.bearing + seen.azimuth);
    let (sin, cos) = headings.fold((0.0, 0.0), |(sin, cos), x| (sin + x.sin(), cos + x.cos()));
    sin.atan2(cos)
}

fn turned(station: &Station, by: Vector) -> Station {
    Station {
        heading: station.heading + by[0],
        pitch: station.pitch + by[1],
        roll: station.roll + by[2],
        ..*station
    }
}

fn fit(start: &Station, seen: &[Seen]) -> Result<(Station, Matrix), Problem> {
    let mut station = *start;
    for _ in 0..ITERATIONS {
        let mut normal = [[0.0; 3]; 3];
        let mut right = [0.0; 3];
        for seen in seen {
            let residual = seen.residual(&station);
            let slopes = [0, 1, 2].map(|axis| {
                let mut by = [0.0; 3];
                by[axis] = DIFFERENCE;
                let more = seen.residual(&turned(&station, by));
                [0, 1].map(|part: usize| wrapped(residual[part] - more[part]) / DIFFERENCE)
            });
            let weight = 1.0 / (seen.sigma * seen.sigma);
            for part in 0..2 {
                let slope = slopes.map(|slope| slope[part]);
                linear::add_outer(&mut normal, slope, weight);
                right = linear::along(right, slope, weight * residual[part]);
            }
        }
        let covariance = linear::inverse(normal).ok_or_else(weak)?;
        let step = linear::times(&covariance, right);
        station = turned(&station, step);
        if station.pitch.abs().max(station.roll.abs()) > std::f64::consts::FRAC_PI_4 {
            return Err(weak());
        }
        if linear::length(step) < SETTLED {
            return Ok((station, covariance));
        }
    }
    Err(Problem::new(text::AlignmentUnsettled))
}

/// Names the reference that fits worst, if it fits badly.
fn wrong(seen: &[Seen], residuals: &[[f64; 2]]) -> Result<(), Problem> {
    let over = seen.iter().zip(residuals).map(|(seen, [a, b])| a.abs().max(b.abs()) / seen.sigma);
    let worst = over.enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
    let Some((index, _)) = worst.filter(|(_, over)| *over > GROSS) else { return Ok(()) };
    let [azimuth, elevation] = residuals[index].map(f64::to_degrees);
    let number = index + 1;
    Err(Problem::new(text::ReferenceWrong {
        number,
        azimuth: format_args!("{azimuth:.2}"),
        elevation: format_args!("{elevation:.2}"),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;
    use crate::station::tests::{bearing, station};

    const SIGMA: f64 = 0.001_75;

    fn mounted() -> Station {
        Station { heading: 2.1, pitch: -0.12, roll: 0.05, ..station(3.0, 4.0, 7.0) }
    }

    fn references(places: &[Place], noise: f64, seed: u64) -> Vec<Reference> {
        let mut draw = Draw::new(seed);
        let see = |place: &Place| {
            let (azimuth, elevation) = mounted().sees(*place);
            let azimuth = azimuth + noise * draw.error();
            let elevation = elevation + noise * draw.error();
            Reference { at: *place, bearing: bearing(0, azimuth, Some(elevation), SIGMA) }
        };
        places.iter().map(see).collect()
    }

    const FIVE: [Place; 5] = [
        [23.0, 4.0, 0.0],
        [18.0, -12.0, 0.0],
        [9.0, -25.0, 1.0],
        [30.0, -30.0, 0.0],
        [40.0, 10.0, 0.0],
    ];

    #[test]
    fn exact_references_give_the_mounting() {
        let unknown = station(3.0, 4.0, 7.0);
        let found = align(&unknown, &references(&FIVE, 0.0, 1)).unwrap();
        let (is, was) = (found.station, mounted());
        let errors = [is.heading - was.heading, is.pitch - was.pitch, is.roll - was.roll];
        assert!(linear::length(errors) < 1e-9, "{errors:?}");
        assert!(found.rms < 1e-9 && found.residuals.len() == 5);
    }

    /// The errors it states are those it makes.
    #[test]
    fn stated_errors_are_right() {
        let mut inside = 0;
        for seed in 0..500 {
            let Ok(found) = align(&station(3.0, 4.0, 7.0), &references(&FIVE, SIGMA, seed)) else {
                continue;
            };
            let error = (found.station.heading - mounted().heading).abs();
            inside += usize::from(error <= 1.96 * found.station.heading_sigma);
            assert!(found.station.tilt_sigma < 0.005, "{:?}", found.station);
        }
        assert!((460..=490).contains(&inside), "{inside}");
    }

    #[test]
    fn bad_references_are_refused_in_words() {
        let unknown = station(3.0, 4.0, 7.0);
        let good = references(&FIVE, 0.0, 1);
        let refused = |references: &[Reference], words: &str| {
            let problem = align(&unknown, references).unwrap_err();
            assert!(problem.0.en.contains(words), "{problem}");
            assert!(!problem.0.ru.is_empty());
        };
        refused(&good[..4], "4 reference fires");
        let row: Vec<Place> =
            (1..=5).map(|n| [3.0 + 10.0 * f64::from(n), 4.0 + 0.3 * f64::from(n), 0.0]).collect();
        refused(&references(&row, 0.0, 1), "do not determine");
        let mut swapped = good.clone();
        (swapped[1].at, swapped[2].at) = (swapped[2].at, swapped[1].at);
        refused(&swapped, "does not fit");
        let mut near = good.clone();
        near[0].at = [4.0, 4.0, 0.0];
        refused(&near, "distance of a reference");
        let mut blind = good.clone();
        blind[0].bearing.elevation = None;
        refused(&blind, "without elevation");
        let mut nan = good;
        nan[0].at[0] = f64::NAN;
        refused(&nan, "place of a reference");
    }
}
