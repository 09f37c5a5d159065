//! §3.14 «Расстояние до очага в метрах, используется для учета баллистики»: how high to aim so
//! that the jet comes down on the fire (ours).
//!
//! The jet is a point mass under gravity and a drag that grows with the square of its speed,
//! dv/dt = g − c(s)·|v|·v. It holds together over a path C, where c = 0, then breaks up over a path
//! B, where c rises in proportion, to c = 1 / L. With the outlet d, the pressure p and the spray
//! w = 1 − n/60 mm:
//! - v₀ = 0.97·√(2p/ρ);
//! - C = 0.113 m/mm · d·e, B = 0.601 m/mm · d·e (at least 0.2 m), e = (d/28 mm · p/0.8 MPa)^0.32·(1 − w)²,
//!   as the break-up length of a jet grows with its Weber number;
//! - L = 21.2 m · (d/28 mm)^1.19 · (p/0.8 MPa)^−0.31 / (1 + 9·w²).
//!
//! The constants are fitted to the simulator's jet, whose water breaks into lumps of several sizes:
//! docs/physics.md has the figures. Another monitor is met by NozzleDiameter (`lafet calibrate`).
//!
//! Over the way x instead of the time the law needs no division: with the slope p = tan θ and
//! w = 1 / vₓ² it reads dz/dx = p, dp/dx = −g·w, dw/dx = 2·c·w·√(1 + p²), ds/dx = √(1 + p²).
//!
//! Cost: a shot is 64 midpoint steps of about 2000 instructions on a Cortex-M3 without FPU, a solution
//! 3 to 25 shots. [`Solver::step`] does 16 of those steps, so that a solution takes 12 to 100 calls;
//! [`Solver::steps`] as many as a cycle of the device has time for. The high solution, for planning,
//! takes up to 2000 calls.

#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::unreachable,
        clippy::todo
    )
)]

#[cfg(test)]
extern crate std;

#[cfg(feature = "lumps")]
pub mod lumps;
mod math;
#[cfg(feature = "lumps")]
pub mod nozzle;
#[cfg(feature = "lumps")]
pub mod throw;
mod wind;

pub use wind::{Drift, Spot, Wind};

/// Acceleration of gravity, m/s².
const GRAVITY: f32 = 9.806_65;
/// Square of the exit speed at a pressure of 0.1 atm, m²/s²: 0.97² · 2 · 10 132.5 Pa / 1000 kg/m³.
const SPEED2_PER_DATM: f32 = 19.067_3;
/// Path over which the jet holds together, and over which it then breaks up, per outlet, m/mm, and
/// how both depend on outlet and pressure.
const CORE_M_PER_MM: f32 = 0.113_0;
const BREAKUP_M_PER_MM: f32 = 0.601_0;
const CORE_EXPONENT: f32 = 0.32;
const BREAKUP_LEAST_M: f32 = 0.2;
/// Drag length of the broken solid jet of an outlet of 28 mm at 0.8 MPa, and how it depends on them.
const DRAG_M: f32 = 21.21;
const REFERENCE_MM: f32 = 28.0;
const REFERENCE_DATM: f32 = 78.954;
const DIAMETER_EXPONENT: f32 = 1.192;
const PRESSURE_EXPONENT: f32 = -0.315;
/// How much shorter the drag length is with the widest spray, less one.
const SPRAY_DRAG: f32 = 9.0;
/// Position of the nozzle at which the jet is narrowest, mm.
pub const NARROWEST_MM: i32 = 60;
/// Pressures that the law was calibrated for, with some margin, 0.1 atm. Below there is no jet to
/// speak of, above is no fire pump.
pub const PRESSURE_DATM: core::ops::RangeInclusive<u16> = 10..=250;
/// The unit of pressure, 0.1 atm, in MPa.
pub const DATM_MPA: f64 = 0.010_132_5;

/// Steps of a shot, of a steep one, which needs more, and how many of them one call makes.
const STEPS: u8 = 64;
const STEPS_STEEP: u8 = 240;
const STEPS_PER_CALL: u8 = 16;
/// Steepest slope that is tried: 80°.
const SLOPE_MAX: f32 = 5.67;
/// A slope below which a shot has fallen short, whatever the rest of it.
const SLOPE_FALLEN: f32 = -8.0;
/// The same where water that falls almost straight down still counts.
const SLOPE_STEEP: f32 = -80.0;
/// Least advance from shot to shot: the best range is missed by a centimetre at most.
const SLOPE_ADVANCE: f32 = 0.05;
/// Height by which a shot may miss, m.
const TOLERANCE_M: f32 = 0.005;
/// Halvings of an advance: well below a minute of arc.
const HALVINGS: u8 = 10;
/// The best elevation lies higher above the line of sight than this.
const SLOPE_FLATTEST: f32 = 0.1;
/// From shot to shot of the high solution: 4 % less steep.
const SLOPE_LOWERED: f32 = 0.96;
/// No solution takes more shots: the steepest downward look needs most.
const SHOTS_MAX: u8 = 150;

/// Why ballistics have no answer (§3.3.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// TrajectoryPressureFault.
    Pressure,
    /// TrajectoryRangeFault.
    Range,
    /// TrajectoryAngleFault.
    Angle,
}

/// A jet as it leaves the nozzle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// Square of the exit speed, m²/s².
    speed2: f32,
    /// 2 / drag length when broken up, 1/m.
    drag_twice: f32,
    /// Path over which it holds together, m.
    core: f32,
    /// 1 / path over which it breaks up, 1/m.
    breakup: f32,
}

/// A point of the flight, by the way from the nozzle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Flight {
    height: f32,
    slope: f32,
    /// 1 / vₓ².
    slowness: f32,
    /// Path flown, m.
    path: f32,
}

/// A point of a jet's [`Path`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Level distance from the nozzle, m.
    pub way_m: f32,
    /// Height above the nozzle, m; below it negative.
    pub height_m: f32,
    /// 1 / square of the level speed, s²/m².
    pub slowness: f32,
}

/// The flight of a jet from the nozzle to the ground, in points every [`Path::PIECE_M`]; the last
/// one is the landing. See [`Jet::path`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    jet: Jet,
    flight: Flight,
    above_ground_m: f32,
    pieces: u16,
    landed: bool,
}

/// What is to be hit, as seen from the nozzle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Level way, m.
    way: f32,
    /// Height above the nozzle, m.
    height: f32,
}

/// Looks for the elevation, a bounded piece at a time.
///
/// The slope is raised from the line of sight, at first by what the last shot fell short: less
/// than that cannot do, because the jet hangs ever more than its aim is raised. So the first
/// elevation that reaches the target is the low one; halving then narrows it down. The high one is
/// found from the steepest slope downwards; it drops the water on what is behind a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solver {
    jet: Jet,
    target: Target,
    flight: Flight,
    made: u8,
    steps_of_shot: u8,
    fallen: f32,
    shots: u8,
    slope: f32,
    steepest: f32,
    phase: Phase,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Lowering from the steepest slope, at which every shot falls short.
    Lowering { short: f32 },
    /// Raising; the slope and height of the last shot that did not fall short altogether.
    Raising { last: Option<(f32, f32)>, short: f32 },
    /// The elevation lies between these two slopes.
    Halving { short: f32, over: f32, left: u8 },
}

impl Jet {
    /// The jet of an outlet at a position of the nozzle.
    pub fn new(pressure_datm: u16, diameter_dmm: i32, nozzle_mm: i32) -> Result<Self, Fault> {
        if !PRESSURE_DATM.contains(&pressure_datm) {
            return Err(Fault::Pressure);
        }
        let diameter_mm = diameter_dmm.clamp(10, 2000) as f32 / 10.0;
        let wide = 1.0 - nozzle_mm.clamp(0, NARROWEST_MM) as f32 / NARROWEST_MM as f32;
        let bore = diameter_mm / REFERENCE_MM;
        let pressure = f32::from(pressure_datm) / REFERENCE_DATM;
        let together =
            diameter_mm * math::pow(bore * pressure, CORE_EXPONENT) * (1.0 - wide) * (1.0 - wide);
        let length =
            DRAG_M * math::pow(bore, DIAMETER_EXPONENT) * math::pow(pressure, PRESSURE_EXPONENT);
        Ok(Self {
            speed2: SPEED2_PER_DATM * f32::from(pressure_datm),
            drag_twice: (2.0 + 2.0 * SPRAY_DRAG * wide * wide) / length,
            core: CORE_M_PER_MM * together,
            breakup: 1.0 / math::at_least(BREAKUP_M_PER_MM * together, BREAKUP_LEAST_M),
        })
    }

    /// The flight with an elevation, to ground that is so far below the nozzle.
    pub fn path(&self, elevation_arcmin: i32, above_ground_m: f32) -> Path {
        let (sin, cos) = math::sin_cos(elevation_arcmin);
        let flight = self.leave(sin / cos);
        Path { jet: *self, flight, above_ground_m, pieces: 0, landed: false }
    }

    /// Level range with an elevation, to ground that lies below the nozzle, m.
    pub fn range_of(&self, elevation_arcmin: i32, above_ground_m: f32) -> f32 {
        self.path(elevation_arcmin, above_ground_m).last().map_or(0.0, |point| point.way_m)
    }

    /// Path after which the jet has broken up altogether, m.
    pub fn broken_up_after_m(&self) -> f32 {
        self.core + 1.0 / self.breakup
    }

    /// Speed at the nozzle, m/s.
    pub fn exit_speed_mps(&self) -> f32 {
        math::sqrt(self.speed2)
    }

    fn leave(&self, slope: f32) -> Flight {
        Flight { height: 0.0, slope, slowness: (1.0 + slope * slope) / self.speed2, path: 0.0 }
    }

    /// 2·c(s): twice the drag after a path, 1/m.
    #[inline(always)]
    fn drag_twice_after(&self, path: f32) -> f32 {
        let broken = (path - self.core) * self.breakup;
        self.drag_twice * math::at_least(math::at_most(broken, 1.0), 0.0)
    }

    /// One step of the midpoint rule over a piece of the way.
    fn advance(&self, flight: &mut Flight, way: f32) {
        let Flight { slope, slowness, .. } = *flight;
        let half = 0.5 * way;
        let path = math::sqrt(1.0 + slope * slope);
        let drag_twice = self.drag_twice_after(flight.path + half * path);
        let mid = slowness * (1.0 + drag_twice * half * path);
        let mid_slope = slope - GRAVITY * slowness * half;
        let mid_path = math::sqrt(1.0 + mid_slope * mid_slope);
        flight.height += mid_slope * way;
        flight.slope -= GRAVITY * mid * way;
        flight.slowness += drag_twice * mid * mid_path * way;
        flight.path += mid_path * way;
    }
}

impl Path {
    /// Level distance between two points, m.
    pub const PIECE_M: f32 = 0.25;
    /// Most points: a jet is not followed farther than 250 m.
    pub const POINTS_MAX: u16 = 1000;
}

impl Iterator for Path {
    type Item = Point;

    fn next(&mut self) -> Option<Point> {
        if self.landed || self.pieces >= Self::POINTS_MAX {
            return None;
        }
        let before = self.flight.height;
        self.jet.advance(&mut self.flight, Self::PIECE_M);
        let Flight { height, slope, slowness, .. } = self.flight;
        // What falls almost straight down comes no farther.
        self.landed = slope <= SLOPE_STEEP || height <= -self.above_ground_m;
        let part =
            if self.landed { (before + self.above_ground_m) / (before - height) } else { 1.0 };
        let way_m = Self::PIECE_M * (f32::from(self.pieces) + part.clamp(0.0, 1.0));
        self.pieces += 1;
        let height_m = if self.landed { -self.above_ground_m } else { height };
        Some(Point { way_m, height_m, slowness })
    }
}

impl Target {
    /// A target on a line of sight at a distance. It does not lie below the ground, which is
    /// `above_ground_cm` below the nozzle: a line of sight that is a little low must not bring the
    /// water down before the fire.
    pub fn new(sight_arcmin: i32, distance_m: u8, above_ground_cm: i32) -> Self {
        let (sin, cos) = math::sin_cos(sight_arcmin);
        let distance = f32::from(distance_m);
        Self::at(distance * cos, distance * sin, above_ground_cm)
    }

    /// A target at a level distance and a height above the nozzle, m. It is not below the ground.
    pub fn at(way_m: f32, height_m: f32, above_ground_cm: i32) -> Self {
        Self {
            way: math::at_least(way_m, 0.1),
            height: math::at_least(height_m, -(above_ground_cm as f32) / 100.0),
        }
    }
}

impl Solver {
    /// Begins.
    pub fn new(jet: Jet, target: Target) -> Self {
        let slope = math::at_most(target.height / target.way, SLOPE_MAX);
        let slope = math::at_least(slope, -SLOPE_MAX);
        // Without drag a jet goes farthest along a slope when it halves the angle between that and
        // the vertical; with drag it must be aimed lower.
        let steepest = math::at_most(slope + math::sqrt(1.0 + slope * slope), SLOPE_MAX);
        Self {
            jet,
            target,
            flight: jet.leave(slope),
            made: 0,
            steps_of_shot: STEPS,
            fallen: SLOPE_FALLEN,
            shots: 0,
            slope,
            steepest,
            phase: Phase::Raising { last: None, short: slope },
        }
    }

    /// Begins to look for the high one of the two solutions.
    pub fn high(jet: Jet, target: Target) -> Self {
        Self {
            flight: jet.leave(SLOPE_MAX),
            slope: SLOPE_MAX,
            steps_of_shot: STEPS_STEEP,
            fallen: SLOPE_STEEP,
            phase: Phase::Lowering { short: SLOPE_MAX },
            ..Self::new(jet, target)
        }
    }

    /// Goes on a little; the elevation in arc-minutes when it is found, or why there is none.
    pub fn step(&mut self) -> Option<Result<i32, Fault>> {
        self.steps(STEPS_PER_CALL)
    }

    /// Goes on by so many steps of a flight at most; what [`Solver::step`] says.
    pub fn steps(&mut self, most: u8) -> Option<Result<i32, Fault>> {
        let piece = self.target.way / f32::from(self.steps_of_shot);
        for _ in 0..most {
            self.jet.advance(&mut self.flight, piece);
            self.made += 1;
            let fallen = self.flight.slope <= self.fallen;
            if fallen || self.made >= self.steps_of_shot {
                let miss = (!fallen).then_some(self.target.height - self.flight.height);
                return self.judge(miss);
            }
        }
        None
    }

    /// A shot is over: how far it passed below the target, `None` when it never came there.
    fn judge(&mut self, miss: Option<f32>) -> Option<Result<i32, Fault>> {
        self.shots += 1;
        if miss.is_some_and(|miss| miss.abs() <= TOLERANCE_M) {
            return Some(Ok(self.elevation()));
        }
        if self.shots >= SHOTS_MAX {
            return Some(Err(Fault::Range));
        }
        let over = miss.is_some_and(|miss| miss < 0.0);
        let next = match &mut self.phase {
            // Nearer than the steepest shot goes.
            Phase::Lowering { .. } if over && self.slope >= SLOPE_MAX => {
                return Some(Err(Fault::Angle));
            }
            Phase::Raising { short, .. } | Phase::Lowering { short } if over => {
                let (short, over) = (*short, self.slope);
                self.phase = Phase::Halving { short, over, left: HALVINGS };
                0.5 * (short + over)
            }
            Phase::Lowering { short } => {
                // Flatter than this no jet goes farther.
                let sight = math::at_least(self.target.height, 0.0) / self.target.way;
                if self.slope <= sight + SLOPE_FLATTEST {
                    return Some(Err(Fault::Range));
                }
                *short = self.slope;
                self.slope * SLOPE_LOWERED
            }
            Phase::Raising { last, short } => {
                let height = miss.map(|miss| self.target.height - miss);
                // Aimed higher and come down lower: the best elevation is behind.
                if let (Some((_, before)), Some(height)) = (*last, height)
                    && height < before
                {
                    return Some(Err(Fault::Range));
                }
                if self.slope >= self.steepest {
                    let angle = self.steepest >= SLOPE_MAX;
                    return Some(Err(if angle { Fault::Angle } else { Fault::Range }));
                }
                *last = height.map(|height| (self.slope, height)).or(*last);
                *short = self.slope;
                let raise = miss.map_or(0.0, |miss| miss / self.target.way);
                math::at_most(self.slope + math::at_least(raise, SLOPE_ADVANCE), self.steepest)
            }
            Phase::Halving { left: 0, .. } => return Some(Ok(self.elevation())),
            Phase::Halving { short, over: high, left } => {
                *(if over { &mut *high } else { &mut *short }) = self.slope;
                *left -= 1;
                0.5 * (*short + *high)
            }
        };
        self.slope = next;
        self.flight = self.jet.leave(next);
        self.made = 0;
        None
    }

    fn elevation(&self) -> i32 {
        math::atan_arcmin(self.slope)
    }
}

/// The examples of the README are compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

#[cfg(test)]
mod tests {
    use super::*;

    /// Calls of `step` that a solution may take, as the header promises.
    const CALLS_MAX: u32 = 100;

    fn elevation_for(jet: Jet, target: Target) -> Result<i32, Fault> {
        let mut solver = Solver::new(jet, target);
        (0..CALLS_MAX).find_map(|_| solver.step()).expect("bounded")
    }

    /// The same law over time, in f64, in steps of half a millisecond: the level range.
    pub(crate) fn landing(
        pressure_datm: u16,
        diameter_mm: f64,
        wide: f64,
        elevation: f64,
        h: f64,
    ) -> f64 {
        let pressure_mpa = f64::from(pressure_datm) * 0.010_132_5;
        let speed = 0.97 * (2000.0 * pressure_mpa).sqrt();
        let (bore, pressure) = (diameter_mm / 28.0, pressure_mpa / 0.8);
        let together = diameter_mm * (bore * pressure).powf(0.32) * (1.0 - wide) * (1.0 - wide);
        let (core, breakup) = (0.113 * together, (0.601 * together).max(0.2));
        let length = 21.21 * bore.powf(1.192) * pressure.powf(-0.315);
        let full = (1.0 + 9.0 * wide * wide) / length;
        let (mut x, mut z, mut s) = (0.0, h, 0.0);
        let (mut vx, mut vz) = (speed * elevation.cos(), speed * elevation.sin());
        let dt = 0.0005;
        for _ in 0..40_000 {
            let v = f64::hypot(vx, vz);
            let k = full * ((s + v * dt / 2.0 - core) / breakup).clamp(0.0, 1.0);
            let (mx, mz) = (vx - k * v * vx * dt / 2.0, vz - (9.806_65 + k * v * vz) * dt / 2.0);
            let m = f64::hypot(mx, mz);
            if z + mz * dt <= 0.0 {
                return x + mx * dt * z / (-mz * dt);
            }
            (x, z, s) = (x + mx * dt, z + mz * dt, s + m * dt);
            (vx, vz) = (vx - k * m * mx * dt, vz - (9.806_65 + k * m * mz) * dt);
        }
        x
    }

    pub(crate) fn radians(arcmin: i32) -> f64 {
        f64::from(arcmin) / 60.0 * std::f64::consts::PI / 180.0
    }

    /// §3.14/3 Where the elevation says the jet comes down, it comes down: within 0.1 m.
    #[test]
    fn hits_the_distance() {
        let mut solved = 0;
        for (pressure, diameter) in [(40, 280), (59, 280), (79, 280), (99, 280), (79, 400)] {
            for distance in 3..=60_u8 {
                let sight = -((1.5 / f64::from(distance)).asin().to_degrees() * 60.0) as i32;
                let jet = Jet::new(pressure, diameter, 60).unwrap();
                let target = Target::new(sight, distance, 150);
                let Ok(elevation) = elevation_for(jet, target) else { continue };
                solved += 1;
                let mm = f64::from(diameter) / 10.0;
                let range = landing(pressure, mm, 0.0, radians(elevation), 1.5);
                let wanted = f64::from(distance) * radians(sight).cos();
                assert!((range - wanted).abs() < 0.1, "{pressure} {distance} m: {range}");
            }
        }
        assert!(solved > 180, "{solved}");
    }

    /// The low one of the two solutions, and none beyond the best range.
    #[test]
    fn low_solution_and_best_range() {
        for (pressure, diameter, best) in [(40, 280, 37.0), (79, 280, 44.5), (79, 400, 60.7)] {
            let jet = Jet::new(pressure, diameter, 60).unwrap();
            let inside = best as u8 - 1;
            let elevation = elevation_for(jet, Target::new(0, inside, 150)).unwrap();
            assert!((600..2200).contains(&elevation), "{elevation}");
            let beyond = Target::new(-120, best as u8 + 2, 150);
            assert_eq!(elevation_for(jet, beyond), Err(Fault::Range));
        }
    }

    /// The high solution hits the same place as the low one, and there is none beyond the reach.
    #[test]
    fn high_solution() {
        let jet = Jet::new(79, 280, 60).unwrap();
        let high = |target| {
            let mut solver = Solver::high(jet, target);
            (0..20 * CALLS_MAX).find_map(|_| solver.step()).expect("bounded")
        };
        assert_eq!(high(Target::new(-500, 10, 150)), Err(Fault::Angle));
        for distance in [15, 20, 30, 40, 43] {
            let sight = -((1.5 / f64::from(distance)).asin().to_degrees() * 60.0) as i32;
            let target = Target::new(sight, distance, 150);
            let (low, high) = (elevation_for(jet, target).unwrap(), high(target).unwrap());
            assert!(low < 1800 && high > 1800 && high <= 4800, "{distance} m: {low} {high}");
            let range = landing(79, 28.0, 0.0, radians(high), 1.5);
            let wanted = f64::from(distance) * radians(sight).cos();
            assert!((range - wanted).abs() < 0.02, "{distance} m: {high}' {range}");
        }
        // Over a wall, to something above the nozzle: flown again in finer steps.
        for (sight, distance) in [(600, 25), (1200, 25), (2000, 20)] {
            let target = Target::new(sight, distance, 150);
            let elevation = high(target).unwrap();
            assert!(elevation > 4000, "{elevation}");
            let mut flight = jet.leave((radians(elevation) as f32).tan());
            for _ in 0..2000 {
                jet.advance(&mut flight, target.way / 2000.0);
            }
            assert!((flight.height - target.height).abs() < 0.1, "{elevation}' {flight:?}");
        }
        assert_eq!(high(Target::new(-120, 46, 150)), Err(Fault::Range));
        assert_eq!(high(Target::new(-120, 200, 150)), Err(Fault::Range));
    }

    /// A jet that would never come to the distance at the line of sight still finds its elevation.
    #[test]
    fn far_and_wide() {
        let jet = Jet::new(79, 280, 30).unwrap();
        let elevation = elevation_for(jet, Target::new(-320, 16, 150)).unwrap();
        let range = landing(79, 28.0, 0.5, radians(elevation), 1.5);
        assert!((range - 16.0).abs() < 0.3, "{range}");
        assert_eq!(elevation_for(jet, Target::new(-100, 40, 150)), Err(Fault::Range));
        let dust = Jet::new(10, 10, 0).unwrap();
        assert_eq!(elevation_for(dust, Target::new(0, 255, 150)), Err(Fault::Range));
    }

    /// It ends when the best elevation is behind, when an interval has been halved often enough, and
    /// after so many shots in any case.
    #[test]
    fn ends_in_time() {
        let jet = Jet::new(79, 280, 60).unwrap();
        let end = |mut solver: Solver| {
            let result = (0..20 * CALLS_MAX).find_map(|_| solver.step()).expect("bounded");
            (result, solver.shots)
        };
        let (result, shots) = end(Solver::new(jet, Target::new(-120, 46, 150)));
        assert!(result == Err(Fault::Range) && shots <= 6, "{result:?} after {shots}");
        let far = Solver::new(jet, Target::new(-120, 200, 150));
        let phase = Phase::Halving { short: 0.1, over: 0.2, left: HALVINGS };
        let (result, shots) = end(Solver { phase, ..far });
        assert!(result.is_ok() && shots == 1 + HALVINGS, "{result:?} after {shots}");
        let last = Solver { shots: SHOTS_MAX - 1, ..far };
        assert_eq!(end(last), (Err(Fault::Range), SHOTS_MAX));
    }

    /// §3.3.6 Too high for any elevation, and pressures that suit no jet.
    #[test]
    fn faults() {
        let jet = Jet::new(79, 280, 60).unwrap();
        assert_eq!(elevation_for(jet, Target::new(5100, 5, 150)), Err(Fault::Angle));
        assert_eq!(Jet::new(9, 280, 60), Err(Fault::Pressure));
        assert_eq!(Jet::new(251, 280, 60), Err(Fault::Pressure));
    }

    /// Upwards, downwards from a height, and a line of sight below the ground.
    #[test]
    fn other_heights() {
        let jet = Jet::new(79, 280, 60).unwrap();
        let up = elevation_for(jet, Target::new(1200, 25, 150)).unwrap();
        assert!((1300..1900).contains(&up), "{up}");
        let level = elevation_for(jet, Target::new(-206, 25, 150)).unwrap();
        let low = elevation_for(jet, Target::new(-400, 25, 150)).unwrap();
        assert!((level - low).abs() <= 8, "{level} {low}");
        let tower = elevation_for(jet, Target::new(-1800, 30, 2000)).unwrap();
        let range = landing(79, 28.0, 0.0, radians(tower), 15.0);
        assert!((range - 30.0 * radians(1800).cos()).abs() < 0.3, "{tower}' {range}");
    }

    /// The range of an elevation is that of the law, not that of a piece of the way.
    #[test]
    fn ranges_are_exact() {
        let jet = Jet::new(79, 280, 60).unwrap();
        for height in [0.5_f32, 1.5, 12.0] {
            for elevation in (-600..=4500).step_by(170) {
                let range = jet.range_of(elevation, height);
                let exact = landing(79, 28.0, 0.0, radians(elevation), height.into());
                assert!((f64::from(range) - exact).abs() < 0.05, "{elevation}': {range} {exact}");
            }
        }
        // What falls almost straight down comes no farther; the farthest that is looked at.
        let from_high = jet.range_of(1800, 400.0);
        assert!((from_high - 52.0).abs() < 0.5, "{from_high}");
        assert_eq!(Jet::new(250, 2000, 60).unwrap().range_of(1800, 3000.0), 250.0);
    }

    /// The simulator's table of ranges.
    #[test]
    fn ranges() {
        let jet = Jet::new(79, 280, 60).unwrap();
        for (degrees, metres) in
            [(-15, 5.24), (0, 20.35), (10, 36.32), (20, 42.75), (30, 44.44), (45, 41.26)]
        {
            let range = jet.range_of(degrees * 60, 1.5);
            assert!((range - metres).abs() < 0.3, "{degrees}°: {range}");
        }
        let spray = Jet::new(79, 280, 0).unwrap().range_of(1800, 1.5);
        assert!((spray - 6.04).abs() < 0.4, "{spray}");
    }
}
