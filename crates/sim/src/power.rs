//! A supply too weak for its motors: it gives way when one starts, or as long as one runs.
//!
//! - `supply-dip`: for 200 ms from the moment at which a motor begins to draw current;
//! - `supply-sag`: as long as any motor draws current.
//!
//! Meanwhile three fifths of the voltage are left: 14.4 of 24 V. Figures ours.

use lafet_device::image::{AXES, VALVES};

use crate::fault::{Faults, SingleFault};

/// From this current on a motor runs, A.
const RUNS_A: f64 = 0.3;
/// How long the supply gives way when a motor starts, ms.
const DIP_MS: u64 = 200;

/// What the motors do to the supply.
#[derive(Clone, Debug, Default)]
pub struct Power {
    /// Drives, then valves.
    runs: [bool; AXES + VALVES],
    dips_until_ms: u64,
}

impl Power {
    /// The currents of the motors in this step, A: drives, then valves.
    pub fn step(&mut self, now_ms: u64, currents_a: impl Iterator<Item = f64>) {
        for (runs, current_a) in self.runs.iter_mut().zip(currents_a) {
            let ran = core::mem::replace(runs, current_a > RUNS_A);
            if *runs && !ran {
                self.dips_until_ms = now_ms + DIP_MS;
            }
        }
    }

    /// What is left of a voltage, 0.1 V.
    pub fn voltage_dv(&self, now_ms: u64, whole_dv: u16, faults: &Faults) -> u16 {
        let dips = faults.single(SingleFault::SupplyDip) && now_ms < self.dips_until_ms;
        let sags = faults.single(SingleFault::SupplySag) && self.runs.contains(&true);
        if dips || sags { whole_dv / 5 * 3 } else { whole_dv }
    }
}

/// Whether the supply gives way: the voltage changes by itself then.
pub fn any(faults: &Faults) -> bool {
    [SingleFault::SupplyDip, SingleFault::SupplySag].into_iter().any(|fault| faults.single(fault))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;

    /// The times at which it is too low, while a motor runs from 100 to 600 ms and another from 250 ms on.
    fn low(fault: SingleFault) -> Vec<u64> {
        let mut faults = Faults::default();
        faults.inject(Fault::Single(fault));
        let mut power = Power::default();
        let mut low = Vec::new();
        for now_ms in (0..1_000).step_by(10) {
            let first = if (100..600).contains(&now_ms) { 1.0 } else { 0.0 };
            let second = if (250..600).contains(&now_ms) { 9.0 } else { 0.1 };
            power.step(now_ms, [first, 0.0, 0.0, 0.0, second].into_iter());
            match power.voltage_dv(now_ms, 240, &faults) {
                144 => low.push(now_ms),
                whole => assert_eq!(whole, 240, "{now_ms}"),
            }
        }
        low
    }

    #[test]
    fn it_gives_way() {
        let steps = |from: u64, to: u64| (from..to).step_by(10).collect::<Vec<u64>>();
        assert_eq!(low(SingleFault::SupplyDip), steps(100, 450));
        assert_eq!(low(SingleFault::SupplySag), steps(100, 600));
        assert_eq!(low(SingleFault::Humidity), steps(0, 0));
        assert!(!any(&Faults::default()));
    }
}
