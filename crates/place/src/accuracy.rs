//! How good places are, by seeded draws: what the tests assert and `examples/accuracy.rs` prints.

use crate::draw::Draw;
use crate::locate::locate;
use crate::station::{Bearing, Kind, Station};
use crate::text::Problem;

/// What a number of draws came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Median of the distance between place and fire, m.
    pub median_m: f64,
    /// Its 95th percentile, m.
    pub p95_m: f64,
    /// Share of the draws with the fire inside the 95 % ellipse.
    pub inside: f64,
}

/// A fire at a distance from the middle of a base of two stations 6 m high, anywhere within 30° of its
/// perpendicular; bearings with a standard error, with or without elevation.
pub fn two_stations(
    (base_m, distance_m, sigma): (f64, f64, f64),
    elevations: bool,
    draws: usize,
    seed: u64,
) -> Result<Accuracy, Problem> {
    let station = |east: f64| Station::level([east, 0.0, 6.0]);
    let stations = [station(-0.5 * base_m), station(0.5 * base_m)];
    let mut draw = Draw::new(seed);
    let mut misses = Vec::with_capacity(draws);
    let mut inside = 0;
    for _ in 0..draws {
        let (sin, cos) = draw.between(-30.0, 30.0).to_radians().sin_cos();
        let fire = [distance_m * sin, distance_m * cos];
        let bearings = [0, 1].map(|index| {
            let (azimuth, elevation) = stations[index].sees([fire[0], fire[1], 0.0]);
            let (azimuth, elevation) =
                (azimuth + sigma * draw.error(), elevation + sigma * draw.error());
            let elevation = elevations.then_some(elevation);
            Bearing {
                station: index,
                azimuth,
                elevation,
                sigma,
                quality: 1.0,
                kind: Kind::Flame,
                age_ms: 0,
            }
        });
        // A draw that is refused as a gross error (1 in 1000) is no place, and is not counted.
        let Ok(fix) = locate(&stations, &bearings, 0.0) else { continue };
        misses.push((fix.at[0] - fire[0]).hypot(fix.at[1] - fire[1]));
        inside += usize::from(fix.holds(fire, 0.95)?);
    }
    misses.sort_by(f64::total_cmp);
    let share = inside as f64 / misses.len().max(1) as f64;
    let at = |part: usize| misses.get(misses.len() * part / 100).copied().unwrap_or(f64::NAN);
    Ok(Accuracy { median_m: at(50), p95_m: at(95), inside: share })
}
