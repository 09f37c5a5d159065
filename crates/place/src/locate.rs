//! The place of one fire from bearings of several stations, by weighted least squares.
//!
//! Gauss and Newton's method from the crossing of the two lines of sight that cross best; the residuals are azimuths
//! and, where measured, elevations over their standard errors. The covariance is the inverse of the
//! normal matrix. A bearing that does not belong to the others is left out if the rest still proves
//! itself (one observation to spare); if it cannot be determined which one is wrong, there is no place.

use std::f64::consts::PI;

use lafet_texts::place as text;
use serde::Serialize;

use crate::linear::{self, Matrix, Vector};
use crate::station::{Bearing, Station};
use crate::text::{Problem, counted, within};
use crate::{BEARINGS_MAX, FARTHEST_M, Place, STATIONS_MAX};

/// Iterations; it converges in three to six.
const ITERATIONS: usize = 20;
/// A step shorter than this ends it, m.
const SETTLED_M: f64 = 1e-7;
/// Width of the differences that stand for derivatives, m.
const DIFFERENCE_M: f64 = 1e-4;
/// Lines of sight cross at no less than so many standard errors, and no less than this, rad.
const CROSSING_SIGMAS: f64 = 6.0;
const CROSSING_MIN: f64 = 0.02;
/// How unlikely residuals are that are refused: 1 in 1000, as a quantile of the normal distribution.
const GROSS_QUANTILE: f64 = 3.09;
/// A nearer place than this to a station says nothing about its direction, m.
const NEAREST_M: f64 = 0.1;

/// The place of a fire.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fix {
    /// East and north, m.
    pub at: [f64; 2],
    /// Height, m, if it was measured or follows from a surface.
    pub height_m: Option<f64>,
    /// Covariance of east, north, up, m²; that of up is 0 without a height.
    pub covariance: Matrix,
    /// Indices of the bearings that it follows from.
    pub used: Vec<usize>,
    /// Indices of the bearings that were left out as gross errors.
    pub rejected: Vec<usize>,
    /// Sum of squares of the residuals over their standard errors, and how many are to spare.
    pub misfit: (f64, usize),
}

/// Where a fire is with a probability, in plan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ellipse {
    /// Half of the long axis, m.
    pub major_m: f64,
    /// Half of the short axis, m.
    pub minor_m: f64,
    /// Bearing of the long axis, 0…π rad.
    pub direction: f64,
    /// With what probability the fire is inside.
    pub probability: f64,
}

impl Fix {
    /// The ellipse in plan for a probability, 0.01…0.9999.
    pub fn ellipse(&self, probability: f64) -> Result<Ellipse, Problem> {
        within(&text::Probability, probability, 0.01..=0.9999)?;
        let [[xx, xy, _], [_, yy, _], _] = self.covariance;
        let half = 0.5 * (xx + yy);
        let spread = (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt();
        // The sum of two squares of normal errors is distributed exponentially.
        let scale = (-2.0 * (1.0 - probability).ln()).sqrt();
        let axis = |variance: f64| scale * variance.max(0.0).sqrt();
        // From the east axis to the long one, counter-clockwise; a bearing goes the other way round.
        let turned = 0.5 * (2.0 * xy).atan2(xx - yy);
        Ok(Ellipse {
            major_m: axis(half + spread),
            minor_m: axis(half - spread),
            direction: (0.5 * PI - turned).rem_euclid(PI),
            probability,
        })
    }

    /// Whether a place lies inside the ellipse of a probability.
    pub fn holds(&self, place: [f64; 2], probability: f64) -> Result<bool, Problem> {
        let Ellipse { major_m, minor_m, direction, .. } = self.ellipse(probability)?;
        let (sin, cos) = direction.sin_cos();
        let (east, north) = (place[0] - self.at[0], place[1] - self.at[1]);
        let (along, across) = (east * sin + north * cos, east * cos - north * sin);
        Ok((along / major_m).powi(2) + (across / minor_m).powi(2) <= 1.0)
    }
}

/// The place of one fire of which bearings of two stations or more were taken. `level_m` is the
/// height of the floor, which counts where no elevation is measured and a station is tilted.
pub fn locate(stations: &[Station], bearings: &[Bearing], level_m: f64) -> Result<Fix, Problem> {
    check(stations, bearings, level_m)?;
    let mut used: Vec<usize> = (0..bearings.len()).collect();
    let mut rejected = Vec::new();
    loop {
        let solved = solve(stations, bearings, &used, level_m).ok_or_else(parallel)?;
        if solved.is_likely() {
            return Ok(solved.fix(used, rejected));
        }
        let without = |left: usize| -> Vec<usize> {
            used.iter().copied().filter(|index| *index != left).collect()
        };
        let best = used
            .iter()
            .filter_map(|index| {
                Some((*index, solve(stations, bearings, &without(*index), level_m)?))
            })
            .filter(|(_, rest)| rest.spare > 0)
            .min_by(|(_, a), (_, b)| a.misfit.total_cmp(&b.misfit));
        let Some((left, _)) = best else { return Err(apart()) };
        used = without(left);
        rejected.push(left);
        // The majority has to agree.
        if rejected.len() * 2 >= bearings.len() {
            return Err(apart());
        }
    }
}

pub(crate) fn check(
    stations: &[Station],
    bearings: &[Bearing],
    level_m: f64,
) -> Result<(), Problem> {
    counted(&text::Stations, stations.len(), 1..=STATIONS_MAX)?;
    counted(&text::Bearings, bearings.len(), 1..=BEARINGS_MAX)?;
    let what = &text::FloorHeight;
    within(what, level_m, -FARTHEST_M..=FARTHEST_M)?;
    stations.iter().try_for_each(Station::check)?;
    bearings.iter().try_for_each(|bearing| bearing.check(stations.len()))
}

fn parallel() -> Problem {
    Problem::new(text::SightsParallel)
}

fn apart() -> Problem {
    Problem::new(text::BearingsApart)
}

/// A place that was solved for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solved {
    pub at: Place,
    pub covariance: Matrix,
    pub misfit: f64,
    pub spare: usize,
    pub has_height: bool,
}

impl Solved {
    /// Whether residuals as large as these come more often than once in 1000.
    pub fn is_likely(&self) -> bool {
        self.misfit <= greatest_misfit(self.spare)
    }

    pub fn fix(&self, used: Vec<usize>, rejected: Vec<usize>) -> Fix {
        Fix {
            at: [self.at[0], self.at[1]],
            height_m: self.has_height.then_some(self.at[2]),
            covariance: self.covariance,
            used,
            rejected,
            misfit: (self.misfit, self.spare),
        }
    }
}

/// The 0.999 quantile of χ²: exact for the first two, then by Wilson and Hilferty. Without an
/// observation to spare nothing is left.
pub(crate) fn greatest_misfit(spare: usize) -> f64 {
    match spare {
        0 => return 1e-3,
        1 => return 10.828,
        2 => return 13.816,
        _ => {}
    }
    let n = spare as f64;
    let part = 2.0 / (9.0 * n);
    n * (1.0 - part + GROSS_QUANTILE * part.sqrt()).powi(3)
}

/// Solves for the place with some of the bearings; none if their lines of sight do not cross.
pub(crate) fn solve(
    stations: &[Station],
    bearings: &[Bearing],
    used: &[usize],
    level_m: f64,
) -> Option<Solved> {
    let has_height = used.iter().any(|index| bearings[*index].elevation.is_some());
    let mut at = crossing(stations, bearings, used, level_m)?;
    let mut last = None;
    for _ in 0..ITERATIONS {
        let (normal, right, misfit, count) = normal(stations, bearings, used, at, has_height);
        let covariance = linear::inverse(normal)?;
        let step = linear::times(&covariance, right);
        last = Some((covariance, misfit, count));
        if linear::length(step) < SETTLED_M {
            break;
        }
        at = linear::along(at, step, 1.0);
        if at.iter().any(|x| !x.is_finite() || x.abs() > 2.0 * FARTHEST_M) {
            return None;
        }
    }
    let (mut covariance, misfit, count) = last?;
    if !has_height {
        covariance[2] = [0.0; 3];
        covariance[0][2] = 0.0;
        covariance[1][2] = 0.0;
    }
    let spare = count - if has_height { 3 } else { 2 };
    Some(Solved { at, covariance, misfit, spare, has_height })
}

/// Where the two lines of sight cross that cross best: in plan, in front of both stations.
fn crossing(
    stations: &[Station],
    bearings: &[Bearing],
    used: &[usize],
    level_m: f64,
) -> Option<Place> {
    let mut best: Option<(f64, Place)> = None;
    for (position, first) in used.iter().enumerate() {
        for second in &used[position + 1..] {
            let (a, b) = (&bearings[*first], &bearings[*second]);
            if a.station == b.station {
                continue;
            }
            let (from, to) = (&stations[a.station], &stations[b.station]);
            let Some((sine, place)) = meet(from, a, to, b, level_m) else { continue };
            let sigma = a.errors(from).0.hypot(b.errors(to).0);
            let enough = sine > CROSSING_MIN.max(CROSSING_SIGMAS * sigma);
            if enough && best.is_none_or(|(before, _)| sine > before) {
                best = Some((sine, place));
            }
        }
    }
    best.map(|(_, place)| place)
}

/// The sine of the angle between two lines of sight in plan, and where they cross.
fn meet(
    from: &Station,
    a: &Bearing,
    to: &Station,
    b: &Bearing,
    level_m: f64,
) -> Option<(f64, Place)> {
    let (u, v) = (a.line(from), b.line(to));
    let (lu, lv) = (u[0].hypot(u[1]), v[0].hypot(v[1]));
    if lu < 1e-6 || lv < 1e-6 {
        return None;
    }
    let across = u[0] * v[1] - u[1] * v[0];
    let base = [to.at[0] - from.at[0], to.at[1] - from.at[1]];
    let t = (base[0] * v[1] - base[1] * v[0]) / across;
    let s = (base[0] * u[1] - base[1] * u[0]) / across;
    if !(t.is_finite() && s.is_finite() && t * lu > NEAREST_M && s * lv > NEAREST_M) {
        return None;
    }
    let heights = [(from, a, t * lu), (to, b, s * lv)].map(|(station, bearing, way)| {
        let slope = bearing.line(station);
        bearing.elevation.map(|_| station.at[2] + way * slope[2] / slope[0].hypot(slope[1]))
    });
    let height = match heights {
        [Some(one), Some(other)] => 0.5 * (one + other),
        [Some(one), None] | [None, Some(one)] => one,
        [None, None] => level_m,
    };
    let place = [from.at[0] + t * u[0], from.at[1] + t * u[1], height];
    let inside = place.iter().all(|x| x.abs() <= FARTHEST_M);
    inside.then_some(((across / (lu * lv)).abs(), place))
}

/// Normal matrix, right side, sum of squares and number of observations at a place.
fn normal(
    stations: &[Station],
    bearings: &[Bearing],
    used: &[usize],
    at: Place,
    has_height: bool,
) -> (Matrix, Vector, f64, usize) {
    let mut matrix = [[0.0; 3]; 3];
    let mut right = [0.0; 3];
    let (mut misfit, mut count) = (0.0, 0);
    let mut observe = |miss: f64, slope: Vector, sigma: f64| {
        let slope = if has_height { slope } else { [slope[0], slope[1], 0.0] };
        let weight = 1.0 / (sigma * sigma);
        linear::add_outer(&mut matrix, slope, weight);
        right = linear::along(right, slope, weight * miss);
        misfit += weight * miss * miss;
        count += 1;
    };
    for index in used {
        let bearing = &bearings[*index];
        let station = &stations[bearing.station];
        let (azimuth_sigma, elevation_sigma) = bearing.errors(station);
        let slopes = slopes(station, at);
        let (azimuth, elevation) = bearing.miss(station, at);
        observe(azimuth, slopes.map(|(azimuth, _)| azimuth), azimuth_sigma);
        if let Some(elevation) = elevation {
            let to = linear::minus(at, station.at);
            let way = to[0].hypot(to[1]).max(NEAREST_M);
            // A wrong height of the station looks like a wrong elevation.
            let raised = station.height_sigma_m * way / linear::dot(to, to).max(NEAREST_M);
            observe(elevation, slopes.map(|(_, up)| up), elevation_sigma.hypot(raised));
        }
    }
    if !has_height {
        matrix[2][2] = 1.0;
    }
    (matrix, right, misfit, count)
}

/// How azimuth and elevation of a place change with its three coordinates, rad/m.
fn slopes(station: &Station, at: Place) -> [(f64, f64); 3] {
    [0, 1, 2].map(|axis| {
        let (mut less, mut more) = (at, at);
        less[axis] -= DIFFERENCE_M;
        more[axis] += DIFFERENCE_M;
        let (less, more) = (station.sees(less), station.sees(more));
        let width = 2.0 * DIFFERENCE_M;
        (linear::wrapped(more.0 - less.0) / width, (more.1 - less.1) / width)
    })
}

#[cfg(test)]
#[path = "locate_tests.rs"]
mod tests;
