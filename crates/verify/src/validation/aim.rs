//! Where the water lands when the monitor's ballistics aim.

use lafet_sim::calibration::{
    Shot, elevation_for, elevation_with, fit, high_elevation_for, shoot, sight_arcmin, table,
};
use lafet_sim::jet::{Jet, Landing};
use lafet_sim::sim::Config;
use lafet_sim::water::ATM_MPA;

use super::Table;
use super::bench::Bench;

pub(super) const HEIGHT_CM: i32 = 150;
const HEIGHT_M: f64 = 1.5;
const DISTANCES_M: [u8; 7] = [20, 25, 30, 35, 40, 45, 50];

/// A jet in the world at an elevation.
pub(super) fn lands(
    nozzle_mm: f64,
    pressure_datm: u16,
    elevation_arcmin: i32,
    wind: (f64, f64),
) -> Landing {
    let pressure_mpa = f64::from(pressure_datm) / 10.0 * ATM_MPA;
    let elevation = (f64::from(elevation_arcmin) / 60.0).to_radians();
    Jet { wind, ..Jet::solid(pressure_mpa, nozzle_mm, elevation) }.landing()
}

/// Level way to a place on the ground at a distance from the nozzle, m.
pub(super) fn way_m(distance_m: u8) -> f64 {
    let distance = f64::from(distance_m);
    libm::sqrt(distance * distance - HEIGHT_M * HEIGHT_M)
}

/// Miss of the monitor's own elevation in still air, m: positive beyond the target. `None` beyond
/// its reach.
fn miss_m(nozzle_mm: f64, diameter_dmm: i32, pressure_datm: u16, distance_m: u8) -> Option<f64> {
    let elevation = elevation_for(pressure_datm, diameter_dmm, HEIGHT_CM, distance_m).ok()?;
    Some(lands(nozzle_mm, pressure_datm, elevation, (0.0, 0.0)).range_m() - way_m(distance_m))
}

pub(super) fn calibrated(nozzle_mm: f64) -> i32 {
    fit(&shoot(nozzle_mm, HEIGHT_M), HEIGHT_M).map_or(280, |fit| fit.diameter_dmm)
}

/// Titles of a table over the distances.
fn over_distances(first: &str) -> Table {
    let titles: Vec<String> = DISTANCES_M.iter().map(|metres| format!("{metres} m")).collect();
    let titles: Vec<&str> =
        core::iter::once(first).chain(titles.iter().map(String::as_str)).collect();
    Table::new(&titles)
}

fn cell(miss: Option<f64>) -> String {
    miss.map_or_else(|| "out of reach".to_owned(), |miss| format!("{miss:+.2}"))
}

/// Landing error in still air, m, of a calibrated monitor.
pub fn still() -> String {
    let mut table = over_distances("outlet, pressure");
    for nozzle_mm in [28.0, 40.0] {
        let diameter = calibrated(nozzle_mm);
        for pressure in [39_u16, 59, 79, 99] {
            let misses =
                DISTANCES_M.map(|distance| cell(miss_m(nozzle_mm, diameter, pressure, distance)));
            let title = format!(
                "{nozzle_mm:.0} mm, {:.2} MPa (NozzleDiameter {diameter})",
                f64::from(pressure) / 10.0 * ATM_MPA
            );
            table.row(&core::iter::once(title).chain(misses).collect::<Vec<_>>());
        }
    }
    table.0
}

/// Landing error of sprays, m, at 0.8 MPa with 28 mm.
pub fn sprays() -> String {
    let distances = [8_u8, 10, 12, 15, 20, 25, 30];
    let titles: Vec<String> = distances.iter().map(|metres| format!("{metres} m")).collect();
    let titles: Vec<&str> =
        core::iter::once("nozzle, mm").chain(titles.iter().map(String::as_str)).collect();
    let mut table = Table::new(&titles);
    for nozzle_mm in [60, 55, 50, 40, 30, 20] {
        let cells = distances.map(|metres| cell(spray_miss_m(nozzle_mm, metres)));
        table.row(&core::iter::once(format!("{nozzle_mm}")).chain(cells).collect::<Vec<_>>());
    }
    table.0
}

fn spray_miss_m(nozzle_mm: i32, distance_m: u8) -> Option<f64> {
    let elevation = elevation_with(79, calibrated(28.0), nozzle_mm, HEIGHT_CM, distance_m).ok()?;
    let solid = Jet::solid(7.9 * ATM_MPA, 28.0, (f64::from(elevation) / 60.0).to_radians());
    let jet = Jet { spray_mm: f64::from(nozzle_mm), ..solid };
    Some(jet.landing().range_m() - way_m(distance_m))
}

/// Landing error of a whole monitor that runs StartQuench with a distance: pump, sensors, drives.
fn running_miss_m(nozzle_mm: f64, distance_m: u8) -> Option<f64> {
    let mut bench = Bench::deployed(Config { nozzle_mm, ..Config::default() });
    bench.send(&format!("SetParam Control NozzleDiameter {}", calibrated(nozzle_mm)));
    bench.send("Open Valve1");
    bench.until("General pressure >= 77", 30_000)?;
    bench.0.advance_ms(4_000);
    bench.send(&format!(
        "StartQuench Control centre=0,{} nozzle=60 sector=0,0 step=0 distance={distance_m}",
        sight_arcmin(distance_m, HEIGHT_CM)
    ));
    bench.0.advance_ms(20_000);
    bench.until("Control flags lacks TrajectoryRangeFault", 0)?;
    bench.0.world().landing().map(|landing| landing.range_m() - way_m(distance_m))
}

/// The same for a monitor that runs.
pub fn running() -> String {
    let mut table = over_distances("outlet");
    for nozzle_mm in [28.0, 40.0] {
        let misses = DISTANCES_M.map(|distance| cell(running_miss_m(nozzle_mm, distance)));
        let title = format!("{nozzle_mm:.0} mm");
        table.row(&core::iter::once(title).chain(misses).collect::<Vec<_>>());
    }
    table.0
}

/// Landing error of the correction table alone, whose entries are whole degrees.
pub fn correction() -> String {
    let mut rows = over_distances("28 mm, pressure");
    let diameter = calibrated(28.0);
    for pressure in [39_u16, 59, 79, 99] {
        let miss = |distance: u8| {
            let degrees = table(diameter, HEIGHT_CM, distance)?[usize::from(pressure)];
            elevation_for(pressure, diameter, HEIGHT_CM, distance).ok()?;
            let elevation = sight_arcmin(distance, HEIGHT_CM) + 60 * i32::from(degrees);
            let landing = lands(28.0, pressure, elevation, (0.0, 0.0));
            Some(landing.range_m() - way_m(distance))
        };
        let title = format!("{:.2} MPa", f64::from(pressure) / 10.0 * ATM_MPA);
        let cells = DISTANCES_M.map(|distance| cell(miss(distance)));
        rows.row(&core::iter::once(title).chain(cells).collect::<Vec<_>>());
    }
    rows.0
}

/// A jet that is not the simulator's: it falls short by a share of its range, as a worn nozzle
/// makes it.
struct Other {
    name: &'static str,
    nozzle_mm: f64,
    share: f64,
}

const OTHERS: [Other; 3] = [
    Other { name: "outlet of 25 mm", nozzle_mm: 25.0, share: 1.0 },
    Other { name: "outlet of 33 mm", nozzle_mm: 33.0, share: 1.0 },
    Other { name: "28 mm, worn: every range 8 % short", nozzle_mm: 28.0, share: 0.92 },
];

impl Other {
    /// The NozzleDiameter that `lafet calibrate` makes of its shots, 0.1 mm.
    fn fitted(&self) -> Option<i32> {
        let shots: Vec<Shot> = shoot(self.nozzle_mm, HEIGHT_M)
            .into_iter()
            .map(|shot| Shot { range_m: self.share * shot.range_m, ..shot })
            .collect();
        fit(&shots, HEIGHT_M).map(|fit| fit.diameter_dmm)
    }

    fn miss_m(&self, diameter_dmm: i32, distance_m: u8) -> Option<f64> {
        let elevation = elevation_for(79, diameter_dmm, HEIGHT_CM, distance_m).ok()?;
        let range_m = lands(self.nozzle_mm, 79, elevation, (0.0, 0.0)).range_m();
        Some(self.share * range_m - way_m(distance_m))
    }
}

/// Misses at 0.8 MPa before and after a calibration, of a monitor that believes in 28 mm.
pub fn calibration() -> String {
    let mut table =
        Table::new(&["jet", "NozzleDiameter, mm", "20 m", "25 m", "30 m", "35 m", "40 m"]);
    for other in OTHERS {
        for (when, diameter) in [("before", Some(280)), ("after", other.fitted())] {
            let Some(diameter) = diameter else { continue };
            let head =
                [format!("{}, {when}", other.name), format!("{:.1}", f64::from(diameter) / 10.0)];
            let cells = [20, 25, 30, 35, 40].map(|metres| cell(other.miss_m(diameter, metres)));
            table.row(&head.into_iter().chain(cells).collect::<Vec<_>>());
        }
    }
    table.0
}

/// The two elevations that hit a distance with 28 mm at 0.8 MPa, and what each misses by.
pub fn solutions() -> String {
    let mut table = Table::new(&["distance, m", "low", "misses by, m", "high", "misses by, m"]);
    for distance in [15_u8, 20, 25, 30, 35, 40, 43] {
        let cells = |found: Option<i32>| match found {
            Some(elevation) => {
                let range = lands(28.0, 79, elevation, (0.0, 0.0)).range_m();
                let degrees = f64::from(elevation) / 60.0;
                [format!("{degrees:.1}°"), format!("{:+.2}", range - way_m(distance))]
            }
            None => ["—".to_owned(), "—".to_owned()],
        };
        let low = cells(elevation_for(79, 280, HEIGHT_CM, distance).ok());
        let high = cells(high_elevation_for(79, 280, HEIGHT_CM, distance).ok());
        let head = core::iter::once(format!("{distance}"));
        table.row(&head.chain(low).chain(high).collect::<Vec<_>>());
    }
    table.0
}

/// What a wind does to the aim at 0.8 MPa: along the jet, and across it.
pub fn wind() -> String {
    let titles = ["wind", "m/s", "20 m", "30 m", "40 m"];
    let mut table = Table::new(&titles);
    let diameter = calibrated(28.0);
    for (name, (forward, left)) in
        [("head", (-1.0, 0.0)), ("tail", (1.0, 0.0)), ("cross", (0.0, 1.0))]
    {
        for speed in [2.0, 5.0, 10.0] {
            let wind = (forward * speed, left * speed);
            let drift = |distance: u8| {
                let Ok(elevation) = elevation_for(79, diameter, HEIGHT_CM, distance) else {
                    return "out of reach".to_owned();
                };
                let at = lands(28.0, 79, elevation, wind).at;
                format!("{:+.1} along, {:+.1} across", at.0 - way_m(distance), at.1)
            };
            let cells = [20, 30, 40].map(drift);
            let head = [name.to_owned(), format!("{speed:.0}")];
            table.row(&head.into_iter().chain(cells).collect::<Vec<_>>());
        }
    }
    table.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In still air a calibrated monitor lands within 0.3 m at 20–50 m, wherever it reaches.
    #[test]
    fn lands_within_0_3_m() {
        let mut reached = 0;
        for nozzle_mm in [28.0, 34.0, 40.0] {
            let diameter = calibrated(nozzle_mm);
            for pressure in (39..=99).step_by(5) {
                for distance in 20..=50 {
                    let Some(miss) = miss_m(nozzle_mm, diameter, pressure, distance) else {
                        continue;
                    };
                    reached += 1;
                    assert!(miss.abs() < 0.3, "{nozzle_mm} {pressure} {distance}: {miss:+.3}");
                }
            }
        }
        assert!(reached > 900, "{reached}");
    }

    /// So do sprays.
    #[test]
    fn sprays_land_within_0_3_m() {
        let mut reached = 0;
        for (nozzle_mm, distance) in
            (20..60).step_by(5).flat_map(|mm| (8..=30).map(move |m| (mm, m)))
        {
            let Some(miss) = spray_miss_m(nozzle_mm, distance) else { continue };
            reached += 1;
            assert!(miss.abs() < 0.3, "{nozzle_mm} mm, {distance} m: {miss:+.3}");
        }
        assert!(reached > 60, "{reached}");
    }

    /// A calibration brings jets of other outlets within 0.3 m; one of another shape nearer by far.
    #[test]
    fn calibration_mends_the_aim() {
        for other in OTHERS {
            let after = other.fitted().unwrap();
            for distance in [20, 25, 30, 35] {
                let (Some(before), Some(after)) =
                    (other.miss_m(280, distance), other.miss_m(after, distance))
                else {
                    continue;
                };
                let bound = if other.share == 1.0 { 0.3 } else { 1.2 };
                assert!(after.abs() < bound && before.abs() > after.abs(), "{}", other.name);
            }
        }
    }

    /// So does the whole monitor while it runs, with the noise of its pressure sensor.
    #[test]
    fn the_running_monitor_too() {
        for (nozzle_mm, distance) in [(28.0, 20), (28.0, 35), (40.0, 50)] {
            let miss = running_miss_m(nozzle_mm, distance).unwrap();
            assert!(miss.abs() < 0.5, "{nozzle_mm} {distance}: {miss:+.3}");
        }
    }
}
