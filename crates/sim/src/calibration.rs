//! Calibration: how the monitor's own ballistics are fitted to the jet that it really throws.
//!
//! The monitor's law (`lafet_ballistics`) has one constant that belongs to the installation:
//! the outlet, parameter NozzleDiameter. It is fitted to shots, elevations and the ranges that came
//! of them. The correction table of §3.6 then holds, for every pressure, the degrees by which the
//! barrel must look higher than a fire at one distance: it serves programs without a distance. Its
//! whole degrees are coarse: half of one is 0.3–0.9 m on the ground.

use lafet_ballistics::{Fault, Jet, PRESSURE_DATM, Solver, Target};

use crate::jet;
use crate::water::ATM_MPA;

/// Outlets that the parameter NozzleDiameter can name and a monitor can have, 0.1 mm.
pub const DIAMETER_DMM: core::ops::RangeInclusive<i32> = 100..=800;
/// Entries of the correction table.
pub const TABLE_LEN: usize = 256;

/// More calls of the solver than any solution takes.
const CALLS_MAX: u32 = 5000;

/// A shot with the narrowest jet on level ground, and where it came down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Pressure at the nozzle as the monitor reports it, 0.1 atm.
    pub pressure_datm: u16,
    /// Elevation, degrees.
    pub elevation_deg: f64,
    /// Distance from the monitor to the middle of the wetted ground, m.
    pub range_m: f64,
}

/// How well the law fits the shots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Outlet that the monitor is to believe in, 0.1 mm.
    pub diameter_dmm: i32,
    /// Root of the mean square of the misses, m.
    pub rms_m: f64,
    /// Largest miss, m.
    pub worst_m: f64,
}

/// Shoots the simulated jet of an outlet at 0.4–1.0 MPa, 3–25° up.
pub fn shoot(nozzle_mm: f64, height_m: f64) -> Vec<Shot> {
    let pressures = [39_u16, 49, 59, 69, 79, 89, 99];
    let elevations = [3.0, 6.0, 10.0, 15.0, 20.0, 25.0_f64];
    let shot = |pressure_datm: u16, elevation_deg: f64| {
        let pressure_mpa = f64::from(pressure_datm) / 10.0 * ATM_MPA;
        let solid = jet::Jet::solid(pressure_mpa, nozzle_mm, elevation_deg.to_radians());
        let range_m = jet::Jet { height_m, ..solid }.landing().range_m();
        Shot { pressure_datm, elevation_deg, range_m }
    };
    pressures.iter().flat_map(|p| elevations.map(|elevation| shot(*p, elevation))).collect()
}

/// How far the law misses a shot, m: positive when it believes in a longer one. `None` for a
/// pressure that suits no jet.
pub fn miss_m(shot: &Shot, diameter_dmm: i32, height_m: f64) -> Option<f64> {
    let arcmin = libm::round(shot.elevation_deg * 60.0) as i32;
    let jet = Jet::new(shot.pressure_datm, diameter_dmm, 60).ok()?;
    Some(f64::from(jet.range_of(arcmin, height_m as f32)) - shot.range_m)
}

/// Fits the outlet to the shots; `None` when no shot can be used.
pub fn fit(shots: &[Shot], height_m: f64) -> Option<Fit> {
    let judge = |diameter_dmm: i32| {
        let misses: Vec<f64> =
            shots.iter().filter_map(|shot| miss_m(shot, diameter_dmm, height_m)).collect();
        let squares: f64 = misses.iter().map(|miss| miss * miss).sum();
        let worst_m = misses.iter().fold(0.0, |worst: f64, miss| worst.max(miss.abs()));
        let rms_m = libm::sqrt(squares / misses.len() as f64);
        (!misses.is_empty()).then_some(Fit { diameter_dmm, rms_m, worst_m })
    };
    // The range grows with the outlet, so the misses have one least: coarse, then fine.
    let better = |a: Fit, b: Fit| if b.rms_m < a.rms_m { b } else { a };
    let coarse = DIAMETER_DMM.step_by(20).filter_map(judge).reduce(better)?;
    let near = coarse.diameter_dmm - 20..=coarse.diameter_dmm + 20;
    near.filter(|diameter| DIAMETER_DMM.contains(diameter)).filter_map(judge).reduce(better)
}

/// The elevation at which the law hits a target on the ground, arc-minutes: the low one.
pub fn elevation_for(
    pressure_datm: u16,
    diameter_dmm: i32,
    height_cm: i32,
    distance_m: u8,
) -> Result<i32, Fault> {
    elevation_with(pressure_datm, diameter_dmm, 60, height_cm, distance_m)
}

/// The same with the nozzle at a position, mm: a spray.
pub fn elevation_with(
    pressure_datm: u16,
    diameter_dmm: i32,
    nozzle_mm: i32,
    height_cm: i32,
    distance_m: u8,
) -> Result<i32, Fault> {
    let jet = Jet::new(pressure_datm, diameter_dmm, nozzle_mm)?;
    solved(Solver::new(jet, ground(height_cm, distance_m)))
}

/// The high one.
pub fn high_elevation_for(
    pressure_datm: u16,
    diameter_dmm: i32,
    height_cm: i32,
    distance_m: u8,
) -> Result<i32, Fault> {
    let jet = Jet::new(pressure_datm, diameter_dmm, 60)?;
    solved(Solver::high(jet, ground(height_cm, distance_m)))
}

fn ground(height_cm: i32, distance_m: u8) -> Target {
    Target::new(sight_arcmin(distance_m, height_cm), distance_m, height_cm)
}

fn solved(mut solver: Solver) -> Result<i32, Fault> {
    (0..CALLS_MAX).find_map(|_| solver.step()).unwrap_or(Err(Fault::Range))
}

/// Direction of a place on the ground at a distance from the nozzle, arc-minutes.
pub fn sight_arcmin(distance_m: u8, height_cm: i32) -> i32 {
    let sine = -f64::from(height_cm) / 100.0 / f64::from(distance_m.max(1));
    libm::round(libm::asin(sine.clamp(-1.0, 1.0)).to_degrees() * 60.0) as i32
}

/// The correction table for fires at a distance (§3.6): degrees by pressure in 0.1 atm; where the
/// jet does not reach, those of the lowest pressure at which it does.
pub fn table(diameter_dmm: i32, height_cm: i32, distance_m: u8) -> Option<[i8; TABLE_LEN]> {
    let mut table = [0; TABLE_LEN];
    let sight = sight_arcmin(distance_m, height_cm);
    let mut reached = None;
    for (pressure, entry) in (0_u16..).zip(&mut table) {
        let raised = elevation_for(pressure, diameter_dmm, height_cm, distance_m)
            .map(|elevation| libm::round(f64::from(elevation - sight) / 60.0) as i8);
        match raised {
            Ok(degrees) => {
                reached = reached.or(Some((pressure, degrees)));
                *entry = degrees;
            }
            // Above the pressures that the law knows, what it said last.
            Err(_) if pressure > *PRESSURE_DATM.end() => {
                let last = elevation_for(*PRESSURE_DATM.end(), diameter_dmm, height_cm, distance_m);
                let degrees = |last: i32| libm::round(f64::from(last - sight) / 60.0) as i8;
                *entry = last.map_or(0, degrees);
            }
            Err(_) => {}
        }
    }
    let (first, degrees) = reached?;
    table.iter_mut().take(usize::from(first)).for_each(|entry| *entry = degrees);
    Some(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The shots of an outlet lead back to it.
    #[test]
    fn finds_the_outlet() {
        for (nozzle_mm, diameter_dmm) in [(28.0, 280), (33.0, 330), (40.0, 400)] {
            let fit = fit(&shoot(nozzle_mm, 1.5), 1.5).unwrap();
            assert!((fit.diameter_dmm - diameter_dmm).abs() <= 3, "{nozzle_mm}: {fit:?}");
            assert!(fit.worst_m < 0.4, "{fit:?}");
        }
        assert_eq!(fit(&[], 1.5), None);
        assert_eq!(fit(&[Shot { pressure_datm: 3, elevation_deg: 10.0, range_m: 9.0 }], 1.5), None);
    }

    /// A jet that goes 8 % short is met by a smaller outlet.
    #[test]
    fn meets_another_jet() {
        let mut shots = shoot(28.0, 1.5);
        shots.iter_mut().for_each(|shot| shot.range_m *= 0.92);
        let uncalibrated = shots.iter().filter_map(|shot| miss_m(shot, 280, 1.5));
        assert!(uncalibrated.fold(0.0, f64::max) > 2.5);
        let fit = fit(&shots, 1.5).unwrap();
        assert!(fit.diameter_dmm < 260 && fit.rms_m < 1.0, "{fit:?}");
    }

    /// §3.6: more pressure, less elevation; the reach bounds it below.
    #[test]
    fn fills_the_table() {
        let table = table(280, 150, 30).unwrap();
        assert!(table.windows(2).all(|pair| pair[0] >= pair[1]), "{table:?}");
        assert!(
            (7..=10).contains(&table[79]) && table[0] == table[20] && table[20] > 20,
            "{table:?}"
        );
        assert_eq!(table[255], table[250]);
        assert_eq!(super::table(280, 150, 250), None);
    }
}
