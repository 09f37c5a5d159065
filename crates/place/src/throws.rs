//! Tables of throws: how to aim for a distance on any bearing, without a flight for each.
//!
//! A table belongs to a jet, its height and a speed of the wind. It is flown for barrels at every 5° to the
//! wind, half of the turn as the other half mirrors it, and for elevations of 1.5° steps; then turned round to what
//! is asked for: the bearing on which the water comes down. Between its rows it is linear;
//! `tests/as_flown.rs` compares it with flights.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

use lafet_ballistics::{Jet, Wind};

use crate::Place;
use crate::flown::sampled;
use crate::linear::wrapped;
use crate::site::{self, Direction, Monitor};

/// Rows of a table from with the wind to against it.
const ROWS: usize = 37;
/// Step of elevation, arc-minutes.
const STEP_ARCMIN: i32 = 90;
/// Points of a flight that are kept, at equal times.
const POINTS: usize = 16;
/// Most tables that are kept; more are flown again.
const TABLES_MAX: usize = 256;
/// No wind worth a table of its own, m/s.
const STILL_MPS: f64 = 0.005;

/// Throws of a jet in a wind.
#[derive(Clone, Debug)]
pub struct Throws {
    /// Elevations, rad.
    elevations: Vec<f64>,
    /// For each bearing of the landing, and each elevation: how much farther from the wind's direction the
    /// barrel points, rad, and the range, m; NaN where there is none.
    rows: Vec<Vec<[f64; 2]>>,
    /// The flight of each, seen along the bearing of its landing.
    paths: Vec<Vec<Path>>,
    /// The farthest of all, m.
    farthest_m: f64,
    /// Whether one row serves all bearings.
    still: bool,
}

/// Points of a flight: towards the landing, to its side, above the nozzle, m.
type Path = [[f32; 3]; POINTS];

/// An aim that a table gives.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Where the barrel points.
    pub direction: Direction,
    between: Between,
    /// Between this elevation and the next.
    index: usize,
    part: f64,
}

/// Bearing of a target to the wind, ready to look up.
#[derive(Clone, Copy, Debug)]
struct Between {
    row: usize,
    part: f64,
    side: f64,
}

/// Tables by what they are of.
#[derive(Debug, Default)]
pub struct Cache {
    known: HashMap<[i64; 8], Option<Arc<Throws>>>,
}

impl Cache {
    /// The table of a monitor at a pressure in a wind for a height of the target; none without a jet.
    pub fn of(
        &mut self,
        monitor: &Monitor,
        pressure_mpa: f64,
        speed_mps: f64,
        plane_m: f64,
    ) -> Option<Arc<Throws>> {
        let [lower, upper] = monitor.elevations.map(|it| (it.to_degrees() * 60.0).round() as i32);
        let heights = [monitor.height_m, plane_m];
        let exact = [
            pressure_mpa / lafet_ballistics::DATM_MPA,
            monitor.outlet_mm * 10.0,
            monitor.nozzle_mm,
        ];
        let [pressure, outlet, nozzle] = exact.map(|it| it.round() as i64);
        let [height, plane, wind] =
            [monitor.height_m, plane_m, speed_mps].map(|it| (it * 100.0).round() as i64);
        let limits = [i64::from(lower), i64::from(upper)];
        let key = [pressure, outlet, nozzle, height, plane, wind, limits[0], limits[1]];
        let make = || {
            let jet = monitor.jet(pressure_mpa)?;
            Some(Arc::new(Throws::new(jet, heights, speed_mps, [lower, upper])))
        };
        if self.known.len() >= TABLES_MAX && !self.known.contains_key(&key) {
            self.known.clear();
        }
        self.known.entry(key).or_insert_with(make).clone()
    }
}

impl Throws {
    /// Flies the table: heights of nozzle and target above the ground, m; elevations in arc-minutes.
    pub fn new(jet: Jet, heights: [f64; 2], speed_mps: f64, [lower, upper]: [i32; 2]) -> Self {
        let still = speed_mps < STILL_MPS;
        let rows = if still { 1 } else { ROWS };
        let mut table = Self {
            elevations: Vec::new(),
            rows: vec![Vec::new(); rows],
            paths: vec![Vec::new(); rows],
            farthest_m: 0.0,
            still,
        };
        let steps = ((upper - lower) / STEP_ARCMIN).max(1);
        for step in 0..=steps {
            let arcmin = lower + (upper - lower) * step / steps;
            table.elevations.push(f64::from(arcmin).to_radians() / 60.0);
            let shots: Vec<Option<Shot>> = (0..rows)
                .map(|row| Shot::new(&jet, arcmin, heights, (speed_mps, angle_of(row))))
                .collect();
            for row in 0..rows {
                let (found, path) = turned_round(&shots, angle_of(row));
                table.farthest_m = table.farthest_m.max(found[1]);
                table.rows[row].push(found);
                table.paths[row].push(path);
            }
        }
        table
    }

    /// The farthest throw in any direction, m.
    pub const fn farthest_m(&self) -> f64 {
        self.farthest_m
    }

    /// The farthest throw on a bearing in a wind, m.
    pub fn throw_m(&self, bearing: f64, wind: site::Wind) -> f64 {
        let between = self.between(bearing, wind);
        (0..self.elevations.len()).map(|index| self.at(between, index)[1]).fold(0.0, f64::max)
    }

    /// The flat and the high aim for a distance on a bearing in a wind, and the farthest throw there, m.
    pub fn aims(&self, bearing: f64, range_m: f64, wind: site::Wind) -> ([Option<Found>; 2], f64) {
        let between = self.between(bearing, wind);
        let (mut flat, mut high, mut throw) = (None, None, 0.0_f64);
        let mut before = self.at(between, 0);
        for index in 1..self.elevations.len() {
            let here = self.at(between, index);
            throw = throw.max(before[1]).max(here[1]);
            let (a, b) = (before[1] - range_m, here[1] - range_m);
            if a <= 0.0 && b > 0.0 && flat.is_none() || a > 0.0 && b <= 0.0 {
                let part = a / (a - b);
                let turned = before[0] + part * (here[0] - before[0]);
                let [e0, e1] = [self.elevations[index - 1], self.elevations[index]];
                let direction = Direction {
                    bearing: wrapped(bearing + between.side * turned),
                    elevation: e0 + part * (e1 - e0),
                };
                let found = Found { direction, between, index: index - 1, part };
                *(if b > 0.0 { &mut flat } else { &mut high }) = Some(found);
            }
            before = here;
        }
        ([flat, high], throw)
    }

    /// The flight of an aim that comes down on a bearing, from a nozzle.
    pub fn path(&self, found: &Found, bearing: f64, nozzle: Place) -> [Place; POINTS + 1] {
        let Found { between, index, part, .. } = *found;
        let next = (between.row + 1).min(self.paths.len() - 1);
        let of = |row: usize, step: usize| &self.paths[row][index + step];
        let corners = [of(between.row, 0), of(between.row, 1), of(next, 0), of(next, 1)];
        let rest = [1.0 - between.part, 1.0 - part];
        let weights =
            [rest[0] * rest[1], rest[0] * part, between.part * rest[1], between.part * part];
        let (sin, cos) = bearing.sin_cos();
        let mut places = [nozzle; POINTS + 1];
        for (point, place) in places.iter_mut().skip(1).enumerate() {
            let at = |axis: usize| -> f64 {
                let parts = corners.iter().zip(weights);
                parts.map(|(path, weight)| weight * f64::from(path[point][axis])).sum()
            };
            let (ahead, side) = (at(0), between.side * at(1));
            place[0] += ahead * sin + side * cos;
            place[1] += ahead * cos - side * sin;
            place[2] += at(2);
        }
        places
    }

    fn between(&self, bearing: f64, wind: site::Wind) -> Between {
        if self.still {
            return Between { row: 0, part: 0.0, side: 1.0 };
        }
        let angle = wrapped(bearing - wind.to());
        let row = angle.abs() / PI * (ROWS - 1) as f64;
        let whole = (row as usize).min(ROWS - 2);
        Between { row: whole, part: row - whole as f64, side: angle.signum() }
    }

    fn at(&self, between: Between, index: usize) -> [f64; 2] {
        let Between { row, part, .. } = between;
        let here = self.rows[row][index];
        if part == 0.0 {
            return here;
        }
        let next = self.rows[row + 1][index];
        [0, 1].map(|it: usize| here[it] + part * (next[it] - here[it]))
    }
}

fn angle_of(row: usize) -> f64 {
    PI * row as f64 / (ROWS - 1) as f64
}

/// A flight at an angle to the wind.
struct Shot {
    /// Of the barrel and of the landing to the wind, rad; both grow to the same side.
    turned: f64,
    lands: f64,
    range_m: f64,
    path: Path,
}

impl Shot {
    fn new(jet: &Jet, arcmin: i32, heights: [f64; 2], (speed, turned): (f64, f64)) -> Option<Self> {
        let wind = Wind {
            along_mps: (speed * turned.cos()) as f32,
            left_mps: (-speed * turned.sin()) as f32,
        };
        let points = sampled::<POINTS>(jet, arcmin, heights, wind)?;
        let [along, left, _] = points[POINTS - 1];
        let range_m = along.hypot(left);
        let (sin, cos) = if range_m > 0.0 { (left / range_m, along / range_m) } else { (0.0, 1.0) };
        // The side that grows with the angle to the wind, which is counted to the left here.
        let path = points.map(|[along, left, up]| {
            [(along * cos + left * sin) as f32, (left * cos - along * sin) as f32, up as f32]
        });
        Some(Self { turned, lands: turned + left.atan2(along), range_m, path })
    }
}

/// From barrel and landing to what is asked for: barrel less landing and range, and the flight, for
/// a landing.
fn turned_round(shots: &[Option<Shot>], lands: f64) -> ([f64; 2], Path) {
    if let [Some(only)] = shots {
        return ([0.0, only.range_m], only.path);
    }
    for pair in shots.windows(2) {
        let [Some(a), Some(b)] = pair else { continue };
        let wide = b.lands - a.lands;
        if wide > 0.0 && wide < 0.5 * PI && (a.lands - 1e-9..=b.lands + 1e-9).contains(&lands) {
            let part = (lands - a.lands) / wide;
            let turned = a.turned + part * (b.turned - a.turned) - lands;
            let path = std::array::from_fn(|point| {
                [0, 1, 2].map(|axis: usize| {
                    a.path[point][axis] + part as f32 * (b.path[point][axis] - a.path[point][axis])
                })
            });
            return ([turned, a.range_m + part * (b.range_m - a.range_m)], path);
        }
    }
    ([f64::NAN; 2], [[f32::NAN; 3]; POINTS])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flown::Gun;
    use crate::linear::{length, minus};
    use crate::site::tests::monitor;

    /// Against flights: throws and aims, in all directions.
    #[test]
    fn tables_are_as_flown() {
        let own = monitor(0.0, 0.0);
        let mut cache = Cache::default();
        for speed_mps in [0.0, 3.0, 8.0, 14.0] {
            let wind = site::Wind { from: 1.0, speed_mps };
            let table = cache.of(&own, 0.8, speed_mps, 0.0).unwrap();
            let gun = Gun::new(&own, 0.8, wind, 0.0).unwrap();
            for step in 0..24 {
                let bearing = f64::from(step) * 0.27;
                let farthest = gun.throw(bearing).unwrap();
                let throw = table.throw_m(bearing, wind);
                assert!((throw - farthest.range_m).abs() < 0.15, "{speed_mps} {bearing}: {throw}");
                for range in [12.0, 20.0, 0.95 * throw] {
                    let ([flat, high], _) = table.aims(bearing, range, wind);
                    for found in flat.into_iter().chain(high) {
                        let Found { direction, .. } = found;
                        let path = table.path(&found, bearing, [0.0, 0.0, own.height_m]);
                        let flight = gun.path(direction);
                        for place in path {
                            let near = |it: &[f64; 3]| length(minus(*it, place));
                            let miss = flight.iter().map(near).fold(f64::INFINITY, f64::min);
                            // Half of a step of the flight, and some.
                            assert!(miss < 0.6, "{speed_mps} {bearing} {range}: {miss}");
                        }
                        let (there, to) = gun.lands(direction).unwrap();
                        let off = wrapped(to - bearing) * range;
                        assert!((there - range).abs() < 0.3, "{speed_mps} {bearing}: {there}");
                        assert!(off.abs() < 0.15, "{speed_mps} {bearing}: {off}");
                    }
                    assert!(flat.is_some(), "{speed_mps} {bearing} {range}");
                }
            }
        }
    }

    #[test]
    fn one_table_for_every_direction_of_a_wind() {
        let mut cache = Cache::default();
        let own = monitor(0.0, 0.0);
        let first = cache.of(&own, 0.8, 5.0, 0.0).unwrap();
        let other = Monitor { heading: 2.0, ..monitor(9.0, 3.0) };
        assert!(Arc::ptr_eq(&first, &cache.of(&other, 0.8, 5.0, 0.0).unwrap()));
        assert!(!Arc::ptr_eq(&first, &cache.of(&own, 0.7, 5.0, 0.0).unwrap()));
        assert!(cache.of(&own, 0.05, 5.0, 0.0).is_none(), "no jet");
        assert!(!Arc::ptr_eq(&first, &cache.of(&own, 0.8, 5.0, 3.0).unwrap()));
    }
}
