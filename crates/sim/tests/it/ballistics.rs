//! The monitor's ballistics and the world's jet, written apart and of different depth, agree on
//! where the water lands.

use lafet_ballistics as ballistics;
use lafet_sim::jet::Jet;
use lafet_sim::water::ATM_MPA;

/// Largest difference over elevations, m, up to a range that the monitor aims at.
fn worst(nozzle_mm: f64, pressure_datm: u16, spray_mm: i32, range_max_m: f64) -> f64 {
    let known = ballistics::Jet::new(pressure_datm, (nozzle_mm * 10.0) as i32, spray_mm)
        .expect("a pressure in range");
    let pressure_mpa = f64::from(pressure_datm) / 10.0 * ATM_MPA;
    let differences = (-600..=1500).step_by(60).filter_map(|elevation| {
        let angle = (f64::from(elevation) / 60.0).to_radians();
        let jet =
            Jet { spray_mm: f64::from(spray_mm), ..Jet::solid(pressure_mpa, nozzle_mm, angle) };
        let lands = jet.landing().range_m();
        let difference = (f64::from(known.range_of(elevation, 1.5)) - lands).abs();
        (lands < range_max_m).then_some(difference)
    });
    differences.fold(0.0, f64::max)
}

/// The solid jet, where it is aimed at 20–50 m: the bound that docs/physics.md promises.
#[test]
fn monitor_and_world_agree() {
    for nozzle_mm in [28.0, 40.0] {
        for pressure_datm in [40, 59, 79, 99] {
            let worst = worst(nozzle_mm, pressure_datm, 60, 50.0);
            assert!(worst < 0.3, "{nozzle_mm} mm {pressure_datm}: they differ by up to {worst} m");
        }
    }
}

/// Sprays, other outlets and the edges of the pressure: roughly.
#[test]
fn far_from_the_fit() {
    for nozzle_mm in [20.0, 28.0, 50.0] {
        for pressure_datm in [20, 79, 118] {
            for spray_mm in [0, 30, 60] {
                let worst = worst(nozzle_mm, pressure_datm, spray_mm, 60.0);
                assert!(worst < 1.2, "{nozzle_mm} mm {pressure_datm} {spray_mm}: {worst} m");
            }
        }
    }
}
