//! The water between nozzle and ground.
//!
//! The jet is cut into portions of 100 ms; each lands after its time of flight, where the jet aimed
//! when it left. Portions land in the order in which they left: a later one is not overtaken by
//! more than its own landing time. At most 256 are in the air, 25 s of water.

use std::collections::VecDeque;

use crate::jet::{Jet, Landing};

const PORTIONS_MAX: usize = 256;

/// A portion of water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Portion {
    /// Litres.
    pub litres: f64,
    /// Part of it that is foam, 0 … 1.
    pub foam: f64,
    /// The jet that it left in.
    pub jet: Jet,
    /// Where it lands.
    pub landing: Landing,
}

/// All the water in the air, with the time at which each portion lands.
#[derive(Clone, Debug, Default)]
pub struct Airborne(VecDeque<(u64, Portion)>);

impl Airborne {
    /// A portion leaves the nozzle.
    pub fn throw(&mut self, now_ms: u64, portion: Portion) {
        let flight_ms = libm::round(portion.landing.flight_s * 1000.0) as u64;
        let last_ms = self.0.back().map_or(0, |(lands_ms, _)| *lands_ms);
        if self.0.len() < PORTIONS_MAX {
            self.0.push_back(((now_ms + flight_ms).max(last_ms), portion));
        }
    }

    /// Nothing is in the air.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The next portion that has reached the ground.
    pub fn land(&mut self, now_ms: u64) -> Option<Portion> {
        self.0.front().filter(|(lands_ms, _)| *lands_ms <= now_ms)?;
        self.0.pop_front().map(|(_, portion)| portion)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lands_after_its_flight() {
        let landing = Landing {
            at: (20.0, 0.0),
            flight_s: 1.5,
            along_m: 1.0,
            across_m: 1.0,
            heading: 0.0,
            slope: 1.0,
        };
        let portion = Portion { litres: 2.0, foam: 0.0, jet: Jet::solid(0.8, 28.0, 0.3), landing };
        let mut airborne = Airborne::default();
        airborne.throw(100, portion);
        assert_eq!(airborne.land(1_590), None);
        assert_eq!(airborne.land(1_600), Some(portion));
        assert_eq!(airborne.land(9_999), None);
    }
}
