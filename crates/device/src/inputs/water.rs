//! Water against the valves: what flows says more than a switch.

use super::Lasting;

/// From this flow on water flows, l/s; less may be the rounding of a meter.
pub(crate) const FLOWING_LPS: u16 = 2;
/// Water that flows through closed valves for this long, ms, contradicts their switches: what was on its
/// way has passed, and a meter has followed.
const UNASKED_MS: u16 = 3000;
/// An open valve has filled the barrel by then, ms.
const DRY_MS: u16 = 10_000;
/// Below this the barrel has no pressure, 0.1 atm.
const DRY_DATM: u16 = 5;

/// What has been seen of the water.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Water {
    unasked: Lasting,
    dry: Lasting,
}

impl Water {
    /// `closed`: there are valves, and the switches of all say closed. `open`: that of one says open.
    /// Pressure is in 0.1 atm, `None` when its sensor is faulty.
    pub fn step(
        &mut self,
        dt_ms: u32,
        (closed, open): (bool, bool),
        flow_lps: u16,
        pressure_datm: Option<u16>,
    ) {
        self.unasked.step(dt_ms, closed && flow_lps >= FLOWING_LPS, UNASKED_MS);
        let dry = flow_lps == 0 && pressure_datm.is_some_and(|datm| datm < DRY_DATM);
        self.dry.step(dt_ms, open && dry, DRY_MS);
    }

    /// It flows though every valve is reported as closed: their switches are not believed.
    pub const fn is_unasked(self) -> bool {
        self.unasked.holds
    }

    /// A valve is open, and there is neither flow nor pressure.
    pub const fn is_missing(self) -> bool {
        self.dry.holds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lasts() {
        let mut water = Water::default();
        for ms in (0..3000).step_by(10) {
            assert!(!water.is_unasked(), "{ms}");
            water.step(10, (true, false), 2, None);
        }
        assert!(water.is_unasked());
        // Less than that, an open valve, and a moment of either are nothing.
        for (valves, flow_lps) in [((true, false), 1), ((false, true), 40), ((false, false), 40)] {
            let mut water = Water::default();
            water.step(60_000, valves, flow_lps, None);
            assert!(!water.is_unasked() && !water.is_missing());
        }
        for _ in 0..299 {
            water.step(10, (true, false), 0, None);
            assert!(water.is_unasked());
        }
        water.step(10, (true, false), 0, None);
        assert!(!water.is_unasked());
    }

    #[test]
    fn what_is_missing() {
        for (flow_lps, pressure_datm, missing) in [
            (0, Some(0), true),
            (0, Some(4), true),
            (0, Some(5), false),
            (1, Some(0), false),
            (0, None, false),
        ] {
            let mut water = Water::default();
            for _ in 0..999 {
                water.step(10, (false, true), flow_lps, pressure_datm);
                assert!(!water.is_missing());
            }
            water.step(10, (false, true), flow_lps, pressure_datm);
            assert_eq!(water.is_missing(), missing, "{flow_lps} {pressure_datm:?}");
        }
    }
}
