//! The monitor's ballistics and the world's jet, written apart, agree on where the water lands.

use lafet_device::ballistics;
use lafet_sim::jet::Jet;
use lafet_sim::water::ATM_MPA;

#[test]
fn monitor_and_world_agree() {
    let mut worst: f64 = 0.0;
    for nozzle_mm in [20.0_f64, 28.0, 40.0, 50.0] {
        for pressure_datm in [20_u16, 40, 79, 118] {
            for spray_mm in [0, 30, 60] {
                for elevation in (-600..=3600).step_by(300) {
                    let known =
                        ballistics::Jet::new(pressure_datm, (nozzle_mm * 10.0) as i32, spray_mm)
                            .expect("a pressure in range")
                            .range_of(elevation, 1.5);
                    let landing = Jet {
                        pressure_mpa: f64::from(pressure_datm) / 10.0 * ATM_MPA,
                        nozzle_mm,
                        spray_mm: f64::from(spray_mm),
                        azimuth: 0.0,
                        elevation: (f64::from(elevation) / 60.0).to_radians(),
                        height_m: 1.5,
                        wind: (0.0, 0.0),
                    }
                    .landing();
                    worst = worst.max((f64::from(known) - landing.range_m()).abs());
                }
            }
        }
    }
    // Half the width of the narrowest footprint.
    assert!(worst < 0.3, "they differ by up to {worst} m");
}
