//! The flight in wind (ours), for planning: the monitor itself does not measure wind.
//!
//! The same law, with the speed through the air instead of that over the ground in the drag:
//! dv/dt = g − c(s)·|v − u|·(v − u). So the wind does not move the part of the jet that holds together. The
//! wind u at the height z is u₁₀·(z/10 m)^(1/7), as in the simulator (docs/physics.md).
//!
//! A jet can be blown back, so this flight goes by time, in steps of the midpoint rule.

use crate::{GRAVITY, Jet, math};

/// Longest step, s.
const STEP_S: f32 = 0.02;
/// The drag takes no more than this part of the speed in a step.
const STEP_DRAG: f32 = 0.25;
/// Height for which winds are given, least height that is looked at, m; exponent of the profile.
const WIND_M: f32 = 10.0;
const WIND_LEAST_M: f32 = 0.1;
const WIND_EXPONENT: f32 = 1.0 / 7.0;
/// Least speed that is computed with, m/s, so that nothing is divided by zero.
const SPEED_LEAST: f32 = 0.01;

/// A wind as the monitor meets it, 10 m above the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wind {
    /// Along the barrel, m/s: from behind is positive.
    pub along_mps: f32,
    /// Across the barrel, m/s: to the left is positive.
    pub left_mps: f32,
}

/// A point of a flight in wind, from the nozzle, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Level distance along the barrel.
    pub along_m: f32,
    /// Level distance to the left of the barrel.
    pub left_m: f32,
    /// Height; below the nozzle negative.
    pub height_m: f32,
}

/// The flight of a jet in wind, in steps of 0.02 s at most; the last point is the landing. See
/// [`Jet::drift`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    jet: Jet,
    wind: Wind,
    above_ground_m: f32,
    at: [f32; 3],
    speed: [f32; 3],
    path: f32,
    /// Length of `speed`, and of the speed through the air, at the last step.
    over_ground: f32,
    through_air: f32,
    steps: u16,
    landed: bool,
}

impl Jet {
    /// The flight with an elevation in a wind, to ground that is so far below the nozzle.
    pub fn drift(&self, elevation_arcmin: i32, above_ground_m: f32, wind: Wind) -> Drift {
        let (sin, cos) = math::sin_cos(elevation_arcmin);
        let exit = math::sqrt(self.speed2);
        Drift {
            jet: *self,
            wind,
            above_ground_m,
            at: [0.0; 3],
            speed: [exit * cos, 0.0, exit * sin],
            path: 0.0,
            over_ground: exit,
            through_air: exit,
            steps: 0,
            landed: false,
        }
    }
}

impl Drift {
    /// Most points of a flight: over a minute of it.
    pub const POINTS_MAX: u16 = 4000;

    /// The landing, or where the flight is no longer followed.
    pub fn landing(self) -> Option<Spot> {
        self.last()
    }

    fn advance(&mut self) {
        let dt = math::at_most(STEP_S, 2.0 * STEP_DRAG / (self.jet.drag_twice * self.through_air));
        let half = 0.5 * dt;
        let [_, _, up] = self.speed;
        let [_, _, height] = self.at;
        let air = self.air(height + half * up);
        let drag = 0.5 * self.jet.drag_twice_after(self.path + half * self.over_ground);
        let mid = after(self.speed, self.acceleration(self.speed, air, drag), half);
        self.speed = after(self.speed, self.acceleration(mid, air, drag), dt);
        self.at = after(self.at, mid, dt);
        self.over_ground = length(mid, self.over_ground);
        self.path += self.over_ground * dt;
    }

    fn acceleration(&mut self, speed: [f32; 3], air: [f32; 3], drag: f32) -> [f32; 3] {
        let [x, y, z] = after(speed, air, -1.0);
        self.through_air = length([x, y, z], self.through_air);
        let slowing = -drag * self.through_air;
        [slowing * x, slowing * y, slowing * z - GRAVITY]
    }

    /// The wind at a height above the nozzle.
    fn air(&self, height: f32) -> [f32; 3] {
        let above = math::at_least(height + self.above_ground_m, WIND_LEAST_M);
        let profile = math::pow(above / WIND_M, WIND_EXPONENT);
        [self.wind.along_mps * profile, self.wind.left_mps * profile, 0.0]
    }
}

impl Iterator for Drift {
    type Item = Spot;

    fn next(&mut self) -> Option<Spot> {
        if self.landed || self.steps >= Self::POINTS_MAX {
            return None;
        }
        let [x, y, z] = self.at;
        self.advance();
        self.steps += 1;
        let [nx, ny, nz] = self.at;
        self.landed = nz <= -self.above_ground_m && nz < z;
        let part = if self.landed { (z + self.above_ground_m) / (z - nz) } else { 1.0 };
        let part = part.clamp(0.0, 1.0);
        let height_m = if self.landed { -self.above_ground_m } else { nz };
        Some(Spot { along_m: x + part * (nx - x), left_m: y + part * (ny - y), height_m })
    }
}

fn length([x, y, z]: [f32; 3], near: f32) -> f32 {
    math::at_least(math::sqrt_near(x * x + y * y + z * z, near), SPEED_LEAST)
}

/// A vector after some time of its change.
fn after([x, y, z]: [f32; 3], [u, v, w]: [f32; 3], time: f32) -> [f32; 3] {
    [x + u * time, y + v * time, z + w * time]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{landing, radians};
    use crate::{Solver, Target};

    fn solved(jet: Jet, way_m: f32) -> i32 {
        let mut solver = Solver::new(jet, Target::at(way_m, -1.5, 150));
        (0..100).find_map(|_| solver.step()).expect("bounded").expect("in reach")
    }

    fn lands(jet: Jet, elevation: i32, height: f32, along_mps: f32, left_mps: f32) -> Spot {
        jet.drift(elevation, height, Wind { along_mps, left_mps }).landing().expect("a flight")
    }

    /// Without wind it is the law, to two centimetres.
    #[test]
    fn still_air_is_the_same_flight() {
        for (pressure, outlet, nozzle) in
            [(40, 280, 60), (79, 280, 60), (99, 400, 60), (79, 280, 30)]
        {
            let jet = Jet::new(pressure, outlet, nozzle).unwrap();
            let (mm, wide) = (f64::from(outlet) / 10.0, 1.0 - f64::from(nozzle) / 60.0);
            for height in [0.5_f32, 1.5, 12.0] {
                for elevation in (-900..=4500).step_by(150) {
                    let spot = lands(jet, elevation, height, 0.0, 0.0);
                    let exact = landing(pressure, mm, wide, radians(elevation), height.into());
                    let miss = f64::from(spot.along_m) - exact;
                    assert!(miss.abs() < 0.02, "{pressure} {outlet} {elevation}': {miss}");
                    assert_eq!((spot.left_m, spot.height_m), (0.0, -height));
                }
            }
        }
    }

    /// The simulator's table "Wind" of docs/physics.md: 28 mm, 0.8 MPa, aimed for still air.
    #[test]
    fn wind_carries_the_jet_as_in_the_simulator() {
        let jet = Jet::new(79, 280, 60).unwrap();
        for (way, head, cross) in [(20.0, 0.3, 0.2), (30.0, 1.7, 1.2), (40.0, 5.5, 4.0)] {
            let elevation = solved(jet, way);
            let [against, with, across] = [(-5.0, 0.0), (5.0, 0.0), (0.0, 5.0)]
                .map(|(along, left)| lands(jet, elevation, 1.5, along, left));
            let bound = 0.15 + 0.2 * head;
            assert!((way - against.along_m - head).abs() < bound, "{way}: {against:?}");
            assert!((with.along_m - way - head).abs() < bound, "{way}: {with:?}");
            assert!((across.left_m - cross).abs() < 0.15 + 0.2 * cross, "{way}: {across:?}");
            assert!((across.along_m - way).abs() < 0.3, "{way}: {across:?}");
        }
    }

    /// Wind from the left and from the right differ by the sign alone, and a fog is blown back.
    #[test]
    fn sides_and_a_jet_that_is_blown_back() {
        let jet = Jet::new(79, 280, 60).unwrap();
        let (left, right) = (lands(jet, 1500, 3.0, -4.0, 6.0), lands(jet, 1500, 3.0, -4.0, -6.0));
        assert_eq!((left.along_m, left.left_m), (right.along_m, -right.left_m));
        let fog = Jet::new(40, 120, 0).unwrap();
        let back = lands(fog, 4500, 20.0, -25.0, 0.0);
        assert!(back.along_m < 0.0, "{back:?}");
        let points = fog.drift(4500, 20.0, Wind { along_mps: -25.0, left_mps: 0.0 }).count();
        assert!(points < usize::from(Drift::POINTS_MAX), "{points}");
    }

    /// Finer than the smallest outlet that is taken: it ends, and nowhere absurd.
    #[test]
    fn the_finest_mist_ends() {
        let mist = Jet::new(10, 10, 0).unwrap();
        let spot = lands(mist, 1800, 1.5, 10.0, 0.0);
        assert!(spot.along_m.is_finite() && (0.0..100.0).contains(&spot.along_m), "{spot:?}");
        assert_eq!(spot.height_m, -1.5);
    }
}
