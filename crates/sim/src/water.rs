//! The water: pump, pipe, valves, nozzle, and the sensors of pressure and flow.
//!
//! A column of water between tank and nozzle, P in MPa, Q in l/s:
//! I·dQ/dt = P₀ − (a + b + c/f² + m²/K²)·Q²
//! - pump: P = P₀ − a·Q² (P₀ = 1.0 MPa, 0.08 MPa less at the nominal flow);
//! - pipe: b·Q² (0.09 MPa at the nominal flow), by Darcy and Weisbach λ·(l/D)·ρv²/2: for 20 l/s
//!   110 m of 100 mm at λ = 0.025;
//! - valves, side by side: c·Q²/f² (0.03 MPa at the nominal flow, f = free areas added);
//! - nozzle: Q = K·√P (see `nozzle`): 20.0 l/s at 0.8 MPa for d = 28 mm;
//! - inertia of the column I = ρ·l/A: 0.28 MPa·s over the nominal flow, for the same pipe. Rigid, so
//!   valid for valves slower than a few 2l/a = 0.2 s (a = 1200 m/s); faster ones hammer harder.
//!   The step is implicit and takes any valve.
//!
//! Every plant is sized for its nozzle: the nominal flow is K·√0.8. The barrel behind the valves is
//! dry: V = 60 l at 20 l/s (in proportion for others) fill before the nozzle has pressure, and run
//! out again with a time constant of 10 s. The air leaves through the nozzle almost without
//! resistance; with the last 15 % of it comes water, a share m of the flow that grows from 0 to 1.
//! So the jet sputters up instead of slamming.
//!
//! Pressure sensor: at the nozzle, I = 4 mA + 16 mA·p/range, range 16.0 atm, noise ±3 µA. Flow
//! meter: in front of the barrel, so it shows the filling. Figures ours; water at 10 °C, no
//! elevation head.

use crate::fault::{Faults, SingleFault};
use crate::nozzle::MONITOR;
use crate::rng::Rng;

/// Pressure at the nozzle for which the plant is sized, MPa.
pub const NOMINAL_MPA: f64 = 0.8;
/// One physical atmosphere, MPa.
pub const ATM_MPA: f64 = 0.101_325;

const PUMP_MPA: f64 = 1.0;
const PUMP_DROP_MPA: f64 = 0.08;
const PIPE_DROP_MPA: f64 = 0.09;
const VALVE_DROP_MPA: f64 = 0.03;
const INERTIA_MPA_S: f64 = 0.28;
const SPUTTER: f64 = 0.85;
/// A valve open by less is closed.
const LEAST_AREA: f64 = 1e-4;
const FILL_S: f64 = 3.0;
const DRAIN_S: f64 = 10.0;

/// The water from the pump to the nozzle.
#[derive(Clone, Debug, PartialEq)]
pub struct Water {
    /// Diameter of the nozzle's outlet, mm.
    pub nozzle_mm: f64,
    /// Pressure at 20 mA of the sensor, atm.
    pub range_atm: f64,
    /// Flow into the barrel, l/s.
    pub flow_lps: f64,
    /// Pressure at the nozzle, MPa.
    pub pressure_mpa: f64,
    /// Pressure in front of the valves, MPa: here a valve that closes makes itself felt.
    pub upstream_mpa: f64,
    /// How full the barrel is, 0 … 1.
    pub filled: f64,
    /// Part of the flow that comes through the foam valve, 0 … 1.
    pub foam: f64,
    /// Pressure of the pump without flow, MPa; of a main that several monitors share, what is left
    /// of it for this one.
    pub head_mpa: f64,
    /// What the pump loses at the nominal flow, MPa.
    pub pump_drop_mpa: f64,
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
            upstream_mpa: PUMP_MPA,
            filled: zero,
            foam: zero,
            head_mpa: PUMP_MPA,
            pump_drop_mpa: PUMP_DROP_MPA,
        }
    }

    /// Nozzle constant K, l/s per √MPa.
    pub fn nozzle_k(&self) -> f64 {
        MONITOR.k(self.nozzle_mm)
    }

    /// Flow for which the plant is sized, l/s.
    pub fn nominal_lps(&self) -> f64 {
        self.nozzle_k() * libm::sqrt(NOMINAL_MPA)
    }

    /// Flow out of the nozzle, l/s: nothing before the water has pushed most of the air out.
    pub fn jet_lps(&self) -> f64 {
        self.share() * self.flow_lps
    }

    /// Water in what leaves the nozzle, 0 … 1.
    fn share(&self) -> f64 {
        ((self.filled - SPUTTER) / (1.0 - SPUTTER)).clamp(0.0, 1.0)
    }

    /// Runs for `dt_s` with the free areas of the water and the foam valve.
    pub fn step(&mut self, areas: [f64; 2], dt_s: f64, faults: &Faults) {
        let area = areas[0] + areas[1];
        let (nominal, k, share) = (self.nominal_lps(), self.nozzle_k(), self.share());
        let pump_mpa = match () {
            () if faults.single(SingleFault::PumpOff) => 0.0,
            () if faults.single(SingleFault::PumpWeak) => self.head_mpa / 4.0,
            () => self.head_mpa,
        };
        let inertia = INERTIA_MPA_S / nominal;
        let before_lps = self.flow_lps;
        self.flow_lps = if area > LEAST_AREA {
            let drop = self.pump_drop_mpa + PIPE_DROP_MPA + VALVE_DROP_MPA / (area * area);
            let resistance = drop / (nominal * nominal) + share * share / (k * k);
            self.foam = areas[1] / area;
            // The flow at the end of the step is the positive root of
            // (R·dt/I)·Q² + Q − (Q_before + P₀·dt/I) = 0.
            let (square, rest) = (resistance * dt_s / inertia, pump_mpa * dt_s / inertia);
            let known = before_lps + rest;
            2.0 * known / (1.0 + libm::sqrt(1.0 + 4.0 * square * known))
        } else {
            0.0
        };
        self.hammer(pump_mpa, (self.flow_lps - before_lps) / dt_s);
        let volume = FILL_S * nominal;
        if area > LEAST_AREA && pump_mpa > 0.0 {
            let stays = self.flow_lps * (1.0 - share) * dt_s / volume;
            // The last of the air would take for ever.
            let next = self.filled + stays;
            self.filled = if next > 0.998 { 1.0 } else { next };
        } else {
            let next = self.filled - self.filled * dt_s / DRAIN_S;
            // So would the last of the water.
            self.filled = if next < 1e-4 { 0.0 } else { next };
        }
        let through = self.jet_lps() / k;
        self.pressure_mpa = through * through;
    }

    /// A column that slows down presses on the valve that slows it.
    fn hammer(&mut self, pump_mpa: f64, change_lps2: f64) {
        let nominal = self.nominal_lps();
        let drop = (self.pump_drop_mpa + PIPE_DROP_MPA) / (nominal * nominal);
        let steady = pump_mpa - drop * self.flow_lps * self.flow_lps;
        self.upstream_mpa = (steady - INERTIA_MPA_S / nominal * change_lps2).max(0.0);
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

    /// The jet comes up through the air that it pushes out: no jump, and no slam beyond the
    /// pressure of the pump by more than a tenth.
    #[test]
    fn sputters_up() {
        let mut water = Water::new(28.0);
        let (mut peak, mut before) = (0.0_f64, 0.0_f64);
        for step in 0..1000 {
            let open = core::f64::consts::FRAC_PI_2 * (f64::from(step) / 400.0).min(1.0);
            water.step([libm::pow(libm::sin(open), 2.0), 0.0], 0.01, &Faults::default());
            peak = peak.max(water.pressure_mpa);
            assert!((water.pressure_mpa - before).abs() < 0.1, "a jump to {}", water.pressure_mpa);
            before = water.pressure_mpa;
        }
        assert!((0.8..1.1).contains(&peak), "{peak}");
        assert!((before - 0.8).abs() < 0.002, "{before}");
    }

    /// A valve that takes its 4 s does not hammer; one that snaps shut does.
    #[test]
    fn hammer() {
        let peak = |closing_s: f64| {
            let mut water = Water::new(28.0);
            run(&mut water, [1.0, 0.0], 1000, &Faults::default());
            let steps = (closing_s * 100.0) as u32;
            (0..=steps).fold(0.0_f64, |peak, step| {
                let open =
                    core::f64::consts::FRAC_PI_2 * (1.0 - f64::from(step) / f64::from(steps));
                water.step([libm::pow(libm::sin(open), 2.0), 0.0], 0.01, &Faults::default());
                peak.max(water.upstream_mpa)
            })
        };
        let (slow, fast) = (peak(4.0), peak(0.3));
        assert!((1.0..1.3).contains(&slow) && fast > 2.0 * slow, "{slow} {fast}");
    }
}
