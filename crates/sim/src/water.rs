//! The water: pump, pipe, valves, nozzle, and the sensors of pressure and flow.
//!
//! Steady flow from the energy balance, P in MPa, Q in l/s:
//! - pump: P = P₀ − a·Q² (P₀ = 1.0 MPa, 0.08 MPa less at the nominal flow);
//! - pipe loss: b·Q² (0.09 MPa at the nominal flow);
//! - valves, side by side: c·Q²/f² (0.03 MPa at the nominal flow, f = free areas added);
//! - nozzle: Q = K·√P, with K = 0.812·(π/4·d²)·√(2/ρ): 20.0 l/s at 0.8 MPa for d = 28 mm;
//! - hence Q = √(P₀ / (a + b + c/f² + 1/K²)), P_nozzle = (Q/K)².
//!
//! Every plant is sized for its nozzle: the nominal flow is K·√0.8. The flow follows with a time
//! constant of 0.3 s (inertia of the water). The barrel behind the valves is dry: V = 60 l at 20
//! l/s (in proportion for others) fill before the nozzle has pressure, and run out again with a
//! time constant of 10 s. While filling, Q = √(P₀ / (a + b + c/f²)), at most twice the nominal
//! flow.
//!
//! Pressure sensor: at the nozzle, I = 4 mA + 16 mA·p/range, range 16.0 atm, noise ±3 µA. Flow
//! meter: in front of the barrel, so it shows the filling. Figures ours; water at 10 °C, no
//! elevation head.

use crate::fault::{Faults, SingleFault};
use crate::rng::Rng;

/// Pressure at the nozzle for which the plant is sized, MPa.
pub const NOMINAL_MPA: f64 = 0.8;
/// One physical atmosphere, MPa.
pub const ATM_MPA: f64 = 0.101_325;
/// Density of water, kg/m³.
pub const DENSITY: f64 = 1000.0;

const DISCHARGE: f64 = 0.812;
const PUMP_MPA: f64 = 1.0;
const PUMP_DROP_MPA: f64 = 0.08;
const PIPE_DROP_MPA: f64 = 0.09;
const VALVE_DROP_MPA: f64 = 0.03;
const INERTIA_S: f64 = 0.3;
const FILL_S: f64 = 3.0;
const DRAIN_S: f64 = 10.0;

/// The water from the pump to the nozzle.
#[derive(Clone, Debug)]
pub struct Water {
    /// Diameter of the nozzle's outlet, mm.
    pub nozzle_mm: f64,
    /// Pressure at 20 mA of the sensor, atm.
    pub range_atm: f64,
    /// Flow into the barrel, l/s.
    pub flow_lps: f64,
    /// Pressure at the nozzle, MPa.
    pub pressure_mpa: f64,
    /// How full the barrel is, 0 … 1.
    pub filled: f64,
    /// Part of the flow that comes through the foam valve, 0 … 1.
    pub foam: f64,
}

impl Water {
    /// A dry barrel behind a plant sized for the nozzle.
    pub const fn new(nozzle_mm: f64) -> Self {
        let zero = 0.0;
        Self {
            nozzle_mm,
            range_atm: 16.0,
            flow_lps: zero,
            pressure_mpa: zero,
            filled: zero,
            foam: zero,
        }
    }

    /// Nozzle constant K, l/s per √MPa.
    pub fn nozzle_k(&self) -> f64 {
        let diameter_m = self.nozzle_mm / 1000.0;
        let area = core::f64::consts::FRAC_PI_4 * diameter_m * diameter_m;
        DISCHARGE * area * libm::sqrt(2.0 * 1e6 / DENSITY) * 1000.0
    }

    /// Flow for which the plant is sized, l/s.
    pub fn nominal_lps(&self) -> f64 {
        self.nozzle_k() * libm::sqrt(NOMINAL_MPA)
    }

    /// Flow out of the nozzle, l/s: nothing before the barrel is full.
    pub fn jet_lps(&self) -> f64 {
        if self.filled >= 1.0 { self.flow_lps } else { 0.0 }
    }

    /// Runs for `dt_s` with the free areas of the water and the foam valve.
    pub fn step(&mut self, areas: [f64; 2], dt_s: f64, faults: &Faults) {
        let area = areas[0] + areas[1];
        let nominal = self.nominal_lps();
        let pump = match () {
            () if faults.single(SingleFault::PumpOff) => 0.0,
            () if faults.single(SingleFault::PumpWeak) => PUMP_MPA / 4.0,
            () => PUMP_MPA,
        };
        let mut steady = 0.0;
        if area > 1e-4 {
            let drop = PUMP_DROP_MPA + PIPE_DROP_MPA + VALVE_DROP_MPA / (area * area);
            let k = self.nozzle_k();
            let full = self.filled >= 1.0;
            let resistance = drop / (nominal * nominal) + if full { 1.0 / (k * k) } else { 0.0 };
            steady = libm::sqrt(pump / resistance).min(2.0 * nominal);
            self.foam = areas[1] / area;
        }
        self.flow_lps += (steady - self.flow_lps) * dt_s / INERTIA_S;
        if steady == 0.0 && self.flow_lps < 0.01 {
            self.flow_lps = 0.0;
        }
        let volume = FILL_S * nominal;
        if steady > 0.0 {
            self.filled = (self.filled + self.flow_lps * dt_s / volume).min(1.0);
        } else {
            self.filled -= self.filled * dt_s / DRAIN_S;
        }
        let through = self.jet_lps() / self.nozzle_k();
        self.pressure_mpa = through * through;
    }

    /// Pressure at the nozzle, atm.
    pub fn pressure_atm(&self) -> f64 {
        self.pressure_mpa / ATM_MPA
    }

    /// Current of the pressure sensor's loop, µA.
    pub fn loop_ua(&self, rng: &mut Rng, faults: &Faults) -> u16 {
        let noise = rng.noise();
        if faults.single(SingleFault::PressureBreak) {
            return 0;
        }
        if faults.single(SingleFault::PressureShort) {
            return 28_000;
        }
        let current = 4000.0 + 16_000.0 * self.pressure_atm() / self.range_atm + noise;
        libm::round(current) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;

    fn run(water: &mut Water, areas: [f64; 2], steps: u32, faults: &Faults) {
        for _ in 0..steps {
            water.step(areas, 0.01, faults);
        }
    }

    /// Nominal: 20 l/s at 0.8 MPa from 28 mm; 40.8 l/s from 40 mm.
    #[test]
    fn nominal_point() {
        for (nozzle_mm, expected) in [(28.0, 20.0), (40.0, 40.8)] {
            let mut water = Water::new(nozzle_mm);
            run(&mut water, [1.0, 0.0], 1000, &Faults::default());
            assert!((water.flow_lps - expected).abs() < 0.05, "{}", water.flow_lps);
            assert!((water.pressure_mpa - 0.8).abs() < 0.002, "{}", water.pressure_mpa);
            let ua = water.loop_ua(&mut Rng::new(1), &Faults::default());
            assert!((11_880..11_920).contains(&ua), "{ua}");
        }
    }

    #[test]
    fn a_dry_barrel_fills_first() {
        let mut water = Water::new(28.0);
        run(&mut water, [1.0, 0.0], 100, &Faults::default());
        assert!(water.flow_lps > 20.0 && water.pressure_mpa == 0.0 && water.jet_lps() == 0.0);
        run(&mut water, [1.0, 0.0], 100, &Faults::default());
        assert!(water.jet_lps() > 15.0 && water.pressure_mpa > 0.5);
        run(&mut water, [0.0, 0.0], 200, &Faults::default());
        assert!(water.jet_lps() == 0.0 && water.pressure_mpa == 0.0);
        assert!(water.loop_ua(&mut Rng::new(1), &Faults::default()) < 4010);
    }

    #[test]
    fn half_open_and_both_open() {
        let flow = |areas| {
            let mut water = Water::new(28.0);
            run(&mut water, areas, 3000, &Faults::default());
            (water.flow_lps, water.foam)
        };
        let (full, water_only) = flow([1.0, 0.0]);
        let (half, _) = flow([0.3, 0.0]);
        let (both, foam) = flow([1.0, 1.0]);
        assert!(half < full && half > 0.7 * full && both > full && both < 1.05 * full);
        assert!(water_only == 0.0 && (foam - 0.5).abs() < 1e-9);
    }

    #[test]
    fn faults() {
        let mut faults = Faults::default();
        let mut water = Water::new(28.0);
        faults.inject(Fault::Single(SingleFault::PumpWeak));
        run(&mut water, [1.0, 0.0], 2000, &faults);
        assert!((water.pressure_mpa - 0.2).abs() < 0.002);
        faults.inject(Fault::Single(SingleFault::PumpOff));
        run(&mut water, [1.0, 0.0], 2000, &faults);
        assert!(water.jet_lps() < 0.01);
        faults.inject(Fault::Single(SingleFault::PressureBreak));
        assert_eq!(water.loop_ua(&mut Rng::new(1), &faults), 0);
        faults.clear_all();
        faults.inject(Fault::Single(SingleFault::PressureShort));
        assert_eq!(water.loop_ua(&mut Rng::new(1), &faults), 28_000);
    }
}
