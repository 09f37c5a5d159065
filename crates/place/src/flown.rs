//! Aims and throws by flying jets, one after the other: for single targets, and to check the tables.

use std::f64::consts::PI;

use lafet_ballistics as ballistics;
use lafet_ballistics::Jet;

use crate::Place;
use crate::linear::wrapped;
use crate::site::{Direction, Monitor, Wind};

/// Sections of the interval in which the best elevation lies; a jet near it hardly changes its range.
const SECTIONS: usize = 9;
const GOLDEN: f64 = 0.618_033_988_75;
/// An elevation that throws far in every wind, rad, and how much farther than it any other one throws,
/// with a margin.
const USUAL: f64 = 0.45;
const MORE: f64 = 1.4;
/// Shots for an aim, and the miss with which it is done, m.
const SHOTS_MAX: usize = 24;
const CLOSE_M: f64 = 0.02;
/// Shots in which a bearing settles, and how exactly, rad.
const TURNS_MAX: usize = 12;
const STRAIGHT: f64 = 2e-4;

/// A monitor with water in a wind, and the height that its jet is to come down to.
#[derive(Clone, Copy, Debug)]
pub struct Gun {
    jet: Jet,
    at: [f64; 2],
    /// Of the nozzle and of the plane to come down on, m.
    heights: [f64; 2],
    elevations: [f64; 2],
    wind: Wind,
}

/// Where a jet comes down when the barrel is turned so that it does on a bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Where the barrel points.
    pub direction: Direction,
    /// How far it throws, m.
    pub range_m: f64,
}

impl Gun {
    /// The jet of a monitor at a pressure; none where there is no jet to speak of.
    pub fn new(monitor: &Monitor, pressure_mpa: f64, wind: Wind, plane_m: f64) -> Option<Self> {
        let Monitor { at, height_m, elevations, .. } = *monitor;
        let jet = monitor.jet(pressure_mpa)?;
        Some(Self { jet, at, heights: [height_m, plane_m], elevations, wind })
    }

    /// The places that the jet passes, from the nozzle to where it comes down on the plane.
    pub fn path(&self, direction: Direction) -> Vec<Place> {
        let (sin, cos) = direction.bearing.sin_cos();
        let mut path = vec![[self.at[0], self.at[1], self.heights[0]]];
        let flight = Flight::new(&self.jet, arcmin(direction), self.heights, self.wind(direction));
        path.extend(flight.map(|[along, left, up]| {
            let east = self.at[0] + along * sin - left * cos;
            [east, self.at[1] + along * cos + left * sin, self.heights[0] + up]
        }));
        path
    }

    fn wind(&self, direction: Direction) -> ballistics::Wind {
        let across = self.wind.to() - direction.bearing;
        ballistics::Wind {
            along_mps: (self.wind.speed_mps * across.cos()) as f32,
            left_mps: (-self.wind.speed_mps * across.sin()) as f32,
        }
    }

    /// Where the jet comes down: range, m, and bearing, rad; none if it never rises to the plane.
    pub fn lands(&self, direction: Direction) -> Option<(f64, f64)> {
        let wind = self.wind(direction);
        let [along, left] = landing(&self.jet, arcmin(direction), self.heights, wind)?;
        Some((along.hypot(left), direction.bearing - left.atan2(along)))
    }

    /// The shot with an elevation that comes down on a bearing; none where the wind does not let it.
    pub fn on(&self, bearing: f64, elevation: f64) -> Option<Shot> {
        self.from(bearing, bearing, elevation)
    }

    /// The same, beginning with a bearing of the barrel that is nearly right.
    fn from(&self, barrel: f64, bearing: f64, elevation: f64) -> Option<Shot> {
        let mut direction = Direction { bearing: barrel, elevation };
        let mut before: Option<(f64, f64)> = None;
        for _ in 0..TURNS_MAX {
            let (range_m, to) = self.lands(direction)?;
            let off = wrapped(to - bearing);
            if off.abs() < STRAIGHT {
                return Some(Shot { direction, range_m });
            }
            if off.abs() > 0.5 * PI {
                return None;
            }
            // How the landing turns with the barrel, from the last two shots.
            let rate =
                before.map_or(1.0, |(turned, last)| (off - last) / (direction.bearing - turned));
            before = Some((direction.bearing, off));
            direction.bearing -= off / rate.clamp(0.2, 5.0);
        }
        None
    }

    /// A shot on a bearing that comes down at a distance or farther: one that is usually far enough, else
    /// the farthest.
    pub fn beyond(&self, bearing: f64, distance_m: f64) -> Option<Shot> {
        let [lower, upper] = self.elevations;
        let usual = self.on(bearing, USUAL.clamp(lower, upper));
        let range = usual.map_or(0.0, |shot| shot.range_m);
        if range >= distance_m {
            return usual;
        }
        if range > 0.0 && distance_m > MORE * range {
            return None;
        }
        self.throw(bearing).filter(|shot| shot.range_m >= distance_m)
    }

    /// The farthest shot on a bearing.
    pub fn throw(&self, bearing: f64) -> Option<Shot> {
        let [mut lower, mut upper] = self.elevations;
        let range = |elevation: f64| self.on(bearing, elevation).map_or(0.0, |shot| shot.range_m);
        let mut inner = [upper - GOLDEN * (upper - lower), lower + GOLDEN * (upper - lower)];
        let mut ranges = inner.map(range);
        for _ in 0..SECTIONS {
            // Both zero: too flat to rise to the plane.
            if ranges[0] <= ranges[1] {
                lower = inner[0];
                inner = [inner[1], lower + GOLDEN * (upper - lower)];
                ranges = [ranges[1], range(inner[1])];
            } else {
                upper = inner[1];
                inner = [upper - GOLDEN * (upper - lower), inner[0]];
                ranges = [range(inner[0]), ranges[0]];
            }
        }
        let best = if ranges[0] < ranges[1] { inner[1] } else { inner[0] };
        self.on(bearing, best)
    }

    /// The flat or, if `steep`, the high one of the two shots that come down at a distance on a bearing, not
    /// farther than `farthest` throws.
    pub fn aim(&self, bearing: f64, range_m: f64, farthest: &Shot, steep: bool) -> Option<Shot> {
        let best = farthest.direction.elevation;
        let [lower, upper] = self.elevations;
        let end = if steep { upper } else { lower };
        // A jet that never rises to the plane comes down short.
        let miss = |shot: Option<Shot>| shot.map_or(0.0, |shot| shot.range_m) - range_m;
        let mut barrel = farthest.direction.bearing;
        let mut short = (end, miss(self.from(barrel, bearing, end)));
        let mut over = (best, farthest.range_m - range_m);
        if short.1 > 0.0 || over.1 < 0.0 {
            return None;
        }
        for _ in 0..SHOTS_MAX {
            let elevation = short.0 + (over.0 - short.0) * -short.1 / (over.1 - short.1).max(1e-9);
            let shot = self.from(barrel, bearing, elevation);
            barrel = shot.map_or(barrel, |shot| shot.direction.bearing);
            let miss = miss(shot);
            if miss.abs() < CLOSE_M {
                return shot;
            }
            // Illinois: the end that stays counts half.
            if miss < 0.0 {
                short = (elevation, miss);
                over.1 *= 0.5;
            } else {
                over = (elevation, miss);
                short.1 *= 0.5;
            }
        }
        None
    }
}

fn arcmin(direction: Direction) -> i32 {
    (direction.elevation.to_degrees() * 60.0).round() as i32
}

/// Where a jet comes down on a plane, from above: along the barrel and to its left, m. `heights` are those of the
/// nozzle and of the plane above the ground.
pub(crate) fn landing(
    jet: &Jet,
    arcmin: i32,
    heights: [f64; 2],
    wind: ballistics::Wind,
) -> Option<[f64; 2]> {
    let mut flight = Flight::new(jet, arcmin, heights, wind);
    let [along, left, _] = flight.by_ref().last()?;
    flight.down.then_some([along, left])
}

/// Points at equal times of a flight that comes down on a plane, the landing being the last: along the
/// barrel, to its left, above the nozzle, m.
pub(crate) fn sampled<const N: usize>(
    jet: &Jet,
    arcmin: i32,
    heights: [f64; 2],
    wind: ballistics::Wind,
) -> Option<[[f64; 3]; N]> {
    let mut flight = Flight::new(jet, arcmin, heights, wind);
    let all: Vec<[f64; 3]> = flight.by_ref().collect();
    let last = all.len().checked_sub(1).filter(|_| flight.down)?;
    Some(std::array::from_fn(|index| all[(last * (index + 1)).div_ceil(N)]))
}

/// A flight that ends on a plane: along the barrel, to its left, above the nozzle, m.
struct Flight {
    drift: ballistics::Drift,
    level_m: f64,
    before: [f64; 3],
    down: bool,
}

impl Flight {
    fn new(jet: &Jet, arcmin: i32, [height_m, plane_m]: [f64; 2], wind: ballistics::Wind) -> Self {
        // Rounded in the same way, so that a plane on the ground is met where the flight ends.
        let level_m = -f64::from((height_m - plane_m) as f32);
        let drift = jet.drift(arcmin, (height_m - plane_m.min(0.0)) as f32, wind);
        Self { drift, level_m, before: [0.0; 3], down: false }
    }
}

impl Iterator for Flight {
    type Item = [f64; 3];

    fn next(&mut self) -> Option<[f64; 3]> {
        if self.down {
            return None;
        }
        let spot = self.drift.next()?;
        let mut here = [spot.along_m, spot.left_m, spot.height_m].map(f64::from);
        let above = self.before[2] - self.level_m;
        if above > 0.0 && here[2] <= self.level_m {
            self.down = true;
            let part = above / (self.before[2] - here[2]);
            here = [0, 1, 2].map(|it: usize| self.before[it] + part * (here[it] - self.before[it]));
        }
        self.before = here;
        Some(here)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::tests::monitor;

    fn gun(speed_mps: f64) -> Gun {
        Gun::new(&monitor(0.0, 0.0), 0.8, Wind { from: 0.0, speed_mps }, 0.0).unwrap()
    }

    #[test]
    fn throws_with_and_against_the_wind() {
        let still = gun(0.0).throw(1.0).unwrap();
        assert!((44.0..46.0).contains(&still.range_m), "{still:?}");
        let [against, with] = [0.0, PI].map(|bearing| gun(6.0).throw(bearing).unwrap().range_m);
        assert!(against < still.range_m - 4.0 && with > still.range_m + 4.0, "{against} {with}");
    }

    #[test]
    fn aims_come_down_where_they_should() {
        let gun = gun(7.0);
        for bearing in [0.0, 0.8, 1.6, 2.5, 4.0] {
            let farthest = gun.throw(bearing).unwrap();
            for range in [20.0, 28.0, 0.97 * farthest.range_m] {
                for steep in [false, true] {
                    let Some(shot) = gun.aim(bearing, range, &farthest, steep) else {
                        assert!(steep, "{bearing} {range}");
                        continue;
                    };
                    let (there, to) = gun.lands(shot.direction).unwrap();
                    assert!((there - range).abs() < 0.1, "{bearing} {range}: {there}");
                    assert!(wrapped(to - bearing).abs() < 1e-3);
                    let best = farthest.direction.elevation;
                    assert_eq!(shot.direction.elevation > best, steep);
                }
            }
            assert!(gun.aim(bearing, farthest.range_m + 1.0, &farthest, false).is_none());
        }
    }

    #[test]
    fn both_aims_in_still_air() {
        let gun = gun(0.0);
        let farthest = gun.throw(2.0).unwrap();
        for range in [24.0, 35.0, 42.0] {
            let [flat, high] = [false, true].map(|it| gun.aim(2.0, range, &farthest, it).unwrap());
            assert!(flat.direction.elevation < 0.5 && high.direction.elevation > 0.7);
            assert!(flat.direction.bearing == 2.0 && high.direction.bearing == 2.0);
        }
        assert!(gun.aim(2.0, 12.0, &farthest, true).is_none(), "nearer than the steepest");
    }

    #[test]
    fn a_path_leads_from_the_nozzle_to_the_landing() {
        let gun = gun(5.0);
        let direction = Direction { bearing: 1.2, elevation: 0.4 };
        let path = gun.path(direction);
        let (range, to) = gun.lands(direction).unwrap();
        let last = path[path.len() - 1];
        assert!((last[0] - range * to.sin()).abs() < 1e-3 && last[2].abs() < 1e-3, "{last:?}");
        assert!((last[1] - range * to.cos()).abs() < 1e-3);
        assert_eq!(path[0], [0.0, 0.0, 2.0]);
    }

    /// On a roof above the nozzle the jet comes down from above, or not at all.
    #[test]
    fn roofs() {
        let own = monitor(0.0, 0.0);
        let roof = Gun::new(&own, 0.8, Wind::default(), 9.0).unwrap();
        let flat = Direction { bearing: 0.0, elevation: 0.1 };
        assert_eq!(roof.lands(flat), None);
        let farthest = roof.throw(0.0).unwrap();
        assert!((30.0..gun(0.0).throw(0.0).unwrap().range_m).contains(&farthest.range_m));
        let shot = roof.aim(0.0, 25.0, &farthest, true).unwrap();
        let path = roof.path(shot.direction);
        let last = path[path.len() - 1];
        assert!((last[1] - 25.0).abs() < 0.1 && (last[2] - 9.0).abs() < 1e-3, "{last:?}");
    }
}
