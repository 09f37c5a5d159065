//! The fire for a given seed.

use lafet_sim::fire::FireSpec;
use lafet_sim::rng::Rng;

/// A fire in front of the monitor and well within reach of its jet.
pub fn of_seed(seed: u64) -> FireSpec {
    let mut rng = Rng::new(seed);
    let azimuth_deg = (-50.0 + 100.0 * rng.unit()).round();
    let range_m = (22.0 + 12.0 * rng.unit()).round();
    FireSpec { azimuth_deg, range_m, size_m: 1.5, ..FireSpec::default() }
}
