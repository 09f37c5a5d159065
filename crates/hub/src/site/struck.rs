//! What a jet strikes before it reaches the ground: tanks and walls stand upright and are as high
//! everywhere. Water that does not pass the near edge of one strikes its wall there; what passes that of a tank
//! and not the far one falls into it or on its roof. The simulator has the same rule for the water that it throws.

use serde::Serialize;
use utoipa::ToSchema;

use super::{Site, Tank, Wall};

/// Sine of the angle below which a jet runs along a wall.
const PARALLEL: f64 = 1e-9;
/// Steps in which the place on a tank is found: to a millimetre.
const HALVINGS: usize = 24;

/// A tank or a wall that ends the way of the water.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Struck {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: Structure,
    /// On its top, not at its side.
    pub on_top: bool,
    /// Level distance from the nozzle, m.
    pub way_m: f32,
    /// Height above the ground, m.
    pub height_m: f32,
    /// All of the water strikes it, as far as is known; else a part of it may pass.
    pub whole: bool,
}

/// A structure of the site.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Structure {
    /// A tank.
    Tank,
    /// A wall.
    Wall,
}

/// The height of the water over its way, from the nozzle to the ground.
#[derive(Clone, Debug)]
pub struct Profile {
    /// Parts of the way, 0 … 1, and heights above the ground, m.
    points: Vec<(f64, f64)>,
}

/// Where water comes from and where it goes: plan places in m, bearings clockwise from north.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// The nozzle.
    pub from: [f64; 2],
    /// Direction, radians.
    pub bearing: f64,
    /// Level distance of the landing on the ground, m.
    pub way_m: f64,
}

impl Profile {
    /// Of a flight: level distances and heights above the nozzle, m, from the nozzle to the landing.
    pub fn of(flight: impl Iterator<Item = [f32; 2]>, nozzle_m: f32) -> Self {
        let mut points: Vec<(f64, f64)> =
            flight.map(|[way, rise]| (f64::from(way), f64::from(rise + nozzle_m))).collect();
        let whole = points.last().map_or(1.0, |last| last.0).max(1e-6);
        points.iter_mut().for_each(|it| it.0 /= whole);
        Self { points }
    }

    /// Height at a part of the way, m.
    pub fn height_m(&self, part: f64) -> f64 {
        let beyond = self.points.partition_point(|it| it.0 < part);
        let at = |index: usize| self.points.get(index).copied().unwrap_or_default();
        let (from, to) = (at(beyond.saturating_sub(1)), at(beyond.min(self.points.len() - 1)));
        let share = (part - from.0) / (to.0 - from.0).max(1e-9);
        from.1 + (to.1 - from.1) * share.clamp(0.0, 1.0)
    }

    /// Where the water falls to a height, between a part of the way where it is above and one where
    /// it is below.
    fn falls_to(&self, height_m: f64, above: f64, below: f64) -> f64 {
        let (mut above, mut below) = (above, below);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(above, below);
            if self.height_m(middle) < height_m {
                below = middle;
            } else {
                above = middle;
            }
        }
        below
    }
}

impl Site {
    /// The first tank or wall in the way of water.
    pub fn strikes(&self, line: Line, profile: &Profile) -> Option<Struck> {
        if profile.points.len() < 2 || line.way_m <= 0.0 {
            return None;
        }
        let tanks = self.tanks.iter().filter_map(|it| {
            let [near, far] = it.crossings(line);
            let (near, far) = (near?, far.unwrap_or(1.0));
            let low = profile.height_m(near) < it.height;
            let into = !low && profile.height_m(far) < it.height;
            let part = if into { profile.falls_to(it.height, near, far) } else { near };
            (low || into).then_some((part, &it.name, Structure::Tank, into))
        });
        let walls = self.walls.iter().filter_map(|it| {
            let part = it.crossing(line)?;
            let low = profile.height_m(part) < it.height;
            low.then_some((part, &it.name, Structure::Wall, false))
        });
        let (part, name, kind, on_top) =
            tanks.chain(walls).min_by(|one, other| one.0.total_cmp(&other.0))?;
        let cm = |metres: f64| ((metres * 100.0).round() / 100.0) as f32;
        let (way_m, height_m) = (cm(part * line.way_m), cm(profile.height_m(part)));
        Some(Struck { name: name.clone(), kind, on_top, way_m, height_m, whole: true })
    }
}

impl Struck {
    /// Whether another one is of the same structure.
    pub fn is_of(&self, other: &Self) -> bool {
        (&self.name, self.kind) == (&other.name, other.kind)
    }
}

impl Line {
    /// East and north of the way, m.
    fn way(&self) -> [f64; 2] {
        [self.bearing.sin() * self.way_m, self.bearing.cos() * self.way_m]
    }
}

impl Tank {
    /// Parts of the way at which its edge is passed, nearest first; none where the nozzle is within it.
    fn crossings(&self, line: Line) -> [Option<f64>; 2] {
        let way = line.way();
        let off = [0, 1].map(|axis| line.from[axis] - self.at[axis]);
        let square = way[0] * way[0] + way[1] * way[1];
        let half = (off[0] * way[0] + off[1] * way[1]) / square;
        let radius = self.diameter / 2.0;
        let rest = (off[0] * off[0] + off[1] * off[1] - radius * radius) / square;
        // NaN, where the line misses it, lies in no range.
        let root = (half * half - rest).sqrt();
        [-half - root, -half + root].map(|part| (0.0..1.0).contains(&part).then_some(part))
    }
}

impl Wall {
    /// The part of the way at which it is passed.
    fn crossing(&self, line: Line) -> Option<f64> {
        let way = line.way();
        let wall = [0, 1].map(|axis| self.to[axis] - self.from[axis]);
        let off = [0, 1].map(|axis| self.from[axis] - line.from[axis]);
        let cross = way[0] * wall[1] - way[1] * wall[0];
        // Seen along its length it has no width.
        if cross.abs() <= PARALLEL * line.way_m * wall[0].hypot(wall[1]) {
            return None;
        }
        let part = (off[0] * wall[1] - off[1] * wall[0]) / cross;
        let along = (off[0] * way[1] - off[1] * way[0]) / cross;
        ((0.0..1.0).contains(&part) && (0.0..=1.0).contains(&along)).then_some(part)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn site(tanks: &[([f64; 2], f64, f64)], walls: &[([f64; 2], [f64; 2], f64)]) -> Site {
        let tank = |&(at, diameter, height)| Tank { name: "T".into(), at, diameter, height };
        let wall = |&(from, to, height)| Wall { name: "W".into(), from, to, height };
        let (tanks, walls) = (tanks.iter().map(tank), walls.iter().map(wall));
        Site { tanks: tanks.collect(), walls: walls.collect(), ..Site::default() }
    }

    /// From the origin to the east, 40 m far, up to 10 m high in the middle, from 2 m.
    fn struck(site: &Site) -> Option<Struck> {
        let points = [[0.0, 0.0], [10.0, 6.0], [20.0, 8.0], [30.0, 4.0], [40.0, -2.0]];
        let profile = Profile::of(points.into_iter(), 2.0);
        let line = Line { from: [0.0, 0.0], bearing: FRAC_PI_2, way_m: 40.0 };
        site.strikes(line, &profile)
    }

    #[test]
    fn the_body_of_a_tank_holds_the_water_back() {
        let tank = |x: f64, height: f64| struck(&site(&[([x, 0.0], 8.0, height)], &[]));
        // 7.2 m high at its near edge, 12 m away.
        let side = tank(16.0, 12.0).expect("the tank");
        assert_eq!((side.way_m, side.on_top, side.kind), (12.0, false, Structure::Tank));
        assert!((side.height_m - 8.4).abs() < 0.01, "{side:?}");
        // It passes the near edge at 26 m, and is below the far one at 34 m.
        let top = tank(30.0, 6.0).expect("the tank");
        assert!(top.on_top && (26.0..34.0).contains(&top.way_m) && top.height_m == 6.0, "{top:?}");
        assert_eq!(tank(16.0, 6.0), None, "over it");
        assert_eq!(struck(&site(&[([16.0, 9.0], 8.0, 12.0)], &[])), None, "beside it");
        assert_eq!(struck(&site(&[([-16.0, 0.0], 8.0, 12.0)], &[])), None, "behind the nozzle");
        // Where the ground would be reached within a tank, it is its side or its top.
        assert!(tank(40.0, 1.0).is_some_and(|it| it.way_m < 40.0));
    }

    #[test]
    fn the_first_of_several_counts() {
        let wall = ([5.0, -5.0], [5.0, 5.0], 6.0);
        let both = site(&[([16.0, 0.0], 8.0, 12.0)], &[wall]);
        let first = struck(&both).expect("the wall");
        assert_eq!((first.name.as_str(), first.kind, first.way_m), ("W", Structure::Wall, 5.0));
        let low = site(&[([16.0, 0.0], 8.0, 12.0)], &[(wall.0, wall.1, 1.0)]);
        assert_eq!(struck(&low).map(|it| it.kind), Some(Structure::Tank), "it passes the wall");
        assert_eq!(struck(&site(&[], &[([5.0, 1.0], [5.0, 5.0], 6.0)])), None, "beside the wall");
        assert_eq!(struck(&site(&[], &[([0.0, 0.0], [40.0, 0.0], 6.0)])), None, "along the wall");
    }
}
