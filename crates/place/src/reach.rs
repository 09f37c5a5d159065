//! What a monitor reaches: after the rules of 75 % and 90 %, past obstacles, clear of keep-outs.
//!
//! The rules, by their sources (docs/coverage.md): a monitor protects a radius of 90 % of its throw, here of that in the
//! wind that is looked at; and the farthest point lies within 75 % of its throw in still air.

use std::sync::Arc;

use serde::Serialize;

use crate::Place;
use crate::flown::Gun;
use crate::linear::wrapped;
use crate::obstacle::Body;
use crate::site::{Direction, Kept, Site, Wind};
use crate::throws::{Cache, Found, Throws};

/// Part of the throw that protects (rule of 90 %), and of that in still air (rule of 75 %).
pub const OF_THROW: f64 = 0.9;
/// See [`OF_THROW`].
pub const OF_STILL_THROW: f64 = 0.75;
/// A sweep is looked at in steps of this angle, rad.
const SWEEP_STEP: f64 = 0.017_5;
/// A target nearer to the nozzle than this, in plan, is the monitor itself, m.
const NEAREST_M: f64 = 0.5;
/// How far above a body a jet passes that needs no flight to prove it, m.
const ABOVE_M: f64 = 0.5;
/// And how far beside it, beyond the drift of the jet, m.
const BESIDE_M: f64 = 1.0;

/// Why a monitor does not reach a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Hindrance {
    /// No pressure that makes a jet.
    Pressure,
    /// Nearer than the lowest elevation comes down.
    TooNear,
    /// Farther than the throw.
    TooFar,
    /// Outside of its limits.
    Limits,
    /// An obstacle, by its index, is in the way.
    Obstacle(usize),
    /// A keep-out, by its index, forbids it.
    KeepOut(usize),
    /// Another monitor, by its index, is in the way.
    Monitor(usize),
}

/// How a monitor reaches a target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Aim {
    /// Where the barrel points.
    pub direction: Direction,
    /// Whether it is the high one of the two solutions.
    pub steep: bool,
    /// Distance in plan, m.
    pub distance_m: f64,
    /// Throw on this bearing in this wind, m.
    pub throw_m: f64,
    /// Throw in still air, m.
    pub still_throw_m: f64,
}

impl Aim {
    /// Whether the distance is within 90 % of the throw in this wind.
    pub fn is_within_90(&self) -> bool {
        self.distance_m <= OF_THROW * self.throw_m
    }

    /// Whether the distance is within 75 % of the throw in still air.
    pub fn is_within_75(&self) -> bool {
        self.distance_m <= OF_STILL_THROW * self.still_throw_m
    }
}

/// A monitor of a site in a wind with a pressure, for targets at one height.
pub struct Reach<'a> {
    site: &'a Site,
    index: usize,
    wind: Wind,
    fall_m: f64,
    bodies: Vec<(Body, Hindrance)>,
    table: Arc<Throws>,
    still_throw_m: f64,
}

impl<'a> Reach<'a> {
    /// Prepares it; [`Hindrance::Pressure`] without a jet.
    pub fn new(
        site: &'a Site,
        index: usize,
        (wind, pressure_mpa, plane_m): (Wind, f64, f64),
        cache: &mut Cache,
    ) -> Result<Self, Hindrance> {
        let monitor = &site.monitors[index];
        let mut table =
            |speed: f64| cache.of(monitor, pressure_mpa, speed, plane_m).ok_or(Hindrance::Pressure);
        let still_throw_m = table(0.0)?.farthest_m();
        let table = table(wind.speed_mps)?;
        let bodies = bodies(site, index).collect();
        let fall_m = monitor.height_m - plane_m;
        Ok(Self { site, index, wind, fall_m, bodies, table, still_throw_m })
    }

    /// How it reaches a place in plan, flat if that is clear, else high.
    pub fn aim(&self, place: [f64; 2]) -> Result<Aim, Hindrance> {
        let [east, north] = self.site.monitors[self.index].at;
        let (east, north) = (place[0] - east, place[1] - north);
        let distance_m = east.hypot(north);
        if distance_m < NEAREST_M {
            return Err(Hindrance::TooNear);
        }
        if distance_m > self.table.farthest_m() {
            return Err(Hindrance::TooFar);
        }
        let bearing = east.atan2(north);
        let ([flat, high], throw_m) = self.table.aims(bearing, distance_m, self.wind);
        let still_throw_m = self.still_throw_m;
        let mut why = if distance_m > throw_m { Hindrance::TooFar } else { Hindrance::TooNear };
        for (found, steep) in [(flat, false), (high, true)] {
            let Some(found) = found else { continue };
            let direction = found.direction;
            match self.allows(&found, place, bearing) {
                Ok(()) => return Ok(Aim { direction, steep, distance_m, throw_m, still_throw_m }),
                // What is in the way of the flat one says more than the limits of the high one.
                Err(new) if !steep || why == Hindrance::TooNear => why = new,
                Err(_) => {}
            }
        }
        Err(why)
    }

    /// Whether the barrel may point there, and the jet passes clear to a place.
    fn allows(&self, found: &Found, place: [f64; 2], bearing: f64) -> Result<(), Hindrance> {
        pointing(self.site, self.index, found.direction)?;
        let monitor = &self.site.monitors[self.index];
        let nozzle = [monitor.at[0], monitor.at[1], monitor.height_m];
        let mut path = None;
        for (body, what) in &self.bodies {
            if !self.may_meet(body, found.direction, place, bearing) {
                continue;
            }
            let path = path.get_or_insert_with(|| self.table.path(found, bearing, nozzle));
            if path.windows(2).any(|pair| body.is_met(pair[0], pair[1])) {
                return Err(*what);
            }
        }
        Ok(())
    }

    /// Whether a body is near enough to the jet to look at its flight. A jet curves downwards, so
    /// it passes above the straight line from its nozzle to its landing.
    fn may_meet(&self, body: &Body, direction: Direction, place: [f64; 2], bearing: f64) -> bool {
        let monitor = &self.site.monitors[self.index];
        let way = [place[0] - monitor.at[0], place[1] - monitor.at[1]];
        let length = way[0].hypot(way[1]);
        let drift = wrapped(direction.bearing - bearing).abs().min(0.5) * length;
        let (at, radius) = body.circle();
        let to = [at[0] - monitor.at[0], at[1] - monitor.at[1]];
        let along = (to[0] * way[0] + to[1] * way[1]) / length;
        let across = (to[0] * way[1] - to[1] * way[0]).abs() / length;
        if across > radius + drift + BESIDE_M || along < -radius || along - radius > length {
            return false;
        }
        let end = ((along + radius) / length).clamp(0.0, 1.0);
        body.top_m() + ABOVE_M >= monitor.height_m - end * self.fall_m
    }
}

/// Whether a monitor's barrel may point into a direction: its limits, and the keep-out sectors.
pub fn pointing(site: &Site, index: usize, direction: Direction) -> Result<(), Hindrance> {
    if !site.monitors[index].has(direction) {
        return Err(Hindrance::Limits);
    }
    let kept = site.keep_outs.iter().position(|it| it.has(index, direction));
    kept.map_or(Ok(()), |kept| Err(Hindrance::KeepOut(kept)))
}

/// Whether a jet on its path passes clear of obstacles, keep-out zones and other monitors.
pub fn passing(site: &Site, index: usize, path: &[Place]) -> Result<(), Hindrance> {
    for (body, what) in bodies(site, index) {
        if path.windows(2).any(|pair| body.is_met(pair[0], pair[1])) {
            return Err(what);
        }
    }
    Ok(())
}

/// Whether a monitor may move its jet from one direction to another without wetting a keep-out: the
/// drives start together, and each ends when it is there. Obstacles are allowed to be hit on the way.
pub fn sweeping(
    site: &Site,
    index: usize,
    gun: &Gun,
    [from, to]: [Direction; 2],
) -> Result<(), Hindrance> {
    let monitor = &site.monitors[index];
    let (Some(start), Some(end)) = (monitor.azimuth(from.bearing), monitor.azimuth(to.bearing))
    else {
        return Err(Hindrance::Limits);
    };
    let turns = [end - start, to.elevation - from.elevation];
    let times = [turns[0].abs() / monitor.speeds[0], turns[1].abs() / monitor.speeds[1]];
    let longest = times[0].max(times[1]);
    let fastest = monitor.speeds[0].max(monitor.speeds[1]);
    let steps = (longest * fastest / SWEEP_STEP).ceil().clamp(1.0, 1000.0) as usize;
    for step in 0..=steps {
        let time = longest * step as f64 / steps as f64;
        let part =
            |axis: usize| if times[axis] > 0.0 { (time / times[axis]).min(1.0) } else { 1.0 };
        let azimuth = start + part(0) * turns[0];
        let direction = Direction {
            bearing: wrapped(monitor.heading - azimuth),
            elevation: from.elevation + part(1) * turns[1],
        };
        pointing(site, index, direction)?;
        match passing(site, index, &gun.path(direction)) {
            Ok(()) | Err(Hindrance::Obstacle(_)) => {}
            Err(kept) => return Err(kept),
        }
    }
    Ok(())
}

/// Time in which a monitor turns from one direction to another, s; none outside of its limits.
pub fn turning_s(site: &Site, index: usize, [from, to]: [Direction; 2]) -> Option<f64> {
    let monitor = &site.monitors[index];
    let turn = monitor.azimuth(to.bearing)? - monitor.azimuth(from.bearing)?;
    let raise = to.elevation - from.elevation;
    Some((turn.abs() / monitor.speeds[0]).max(raise.abs() / monitor.speeds[1]))
}

/// What a jet of a monitor may not pass through. Keep-outs first: they count where both are met.
fn bodies(site: &Site, index: usize) -> impl Iterator<Item = (Body, Hindrance)> {
    let kept = site.keep_outs.iter().enumerate().filter_map(|(number, it)| match it.place {
        Kept::Zone(body) => Some((body, Hindrance::KeepOut(number))),
        Kept::Sector { .. } => None,
    });
    let others = site.monitors.iter().enumerate();
    let others = others.filter(move |(number, _)| *number != index && site.clearance_m > 0.0);
    let others =
        others.map(|(number, other)| (other.body(site.clearance_m), Hindrance::Monitor(number)));
    let obstacles = site.obstacles.iter().enumerate();
    let obstacles = obstacles.map(|(number, body)| (*body, Hindrance::Obstacle(number)));
    kept.chain(others).chain(obstacles)
}

#[cfg(test)]
#[path = "reach_tests.rs"]
mod tests;
