//! Sensors that lie without saying so: a noisy encoder, a reading that does not change, one that drifts.
//!
//! - `encoder-noise`: each reading is off by −2 … 2 arc-minutes or −1 … 1 mm, at random;
//! - `…-frozen`: from the moment of the fault on, what was read then;
//! - `…-drift`: from that moment on ever farther off, up to the end of the range.
//!
//! A loop that is broken or shorted, and a sensor that does not answer, shows as such all the same.
//! Figures ours.

use lafet_device::image::{Axis, Inputs, Place, UNITS};

use crate::contact::Freshness;
use crate::fault::{DriveFault, Fault, Faults, SingleFault, noise_counts};
use crate::rng::Rng;

/// How a reading drifts.
struct Drift {
    /// So much …
    by: i32,
    /// … in this time, ms.
    each_ms: u64,
    /// Ends of the range.
    range: (i32, i32),
}

/// l/s.
const FLOW: Drift = Drift { by: 1, each_ms: 5_000, range: (0, 999) };
/// µA.
const PRESSURE: Drift = Drift { by: -1, each_ms: 50, range: (0, 28_000) };
/// 0.1 °C.
const TEMPERATURE: Drift = Drift { by: 1, each_ms: 1_000, range: (-1_000, 1_000) };

/// What the faulty sensors read when their faults came.
#[derive(Clone, Debug, Default)]
pub struct Sensors {
    begun: Vec<(Fault, u64, i32)>,
}

impl Sensors {
    /// Spoils what has been sensed; of the drives what has just been sensed, by [`Unit`].
    ///
    /// [`Unit`]: lafet_device::image::Unit
    pub fn spoil(
        &mut self,
        now_ms: u64,
        fresh: [Freshness; UNITS],
        inputs: &mut Inputs,
        rng: &mut Rng,
        faults: &Faults,
    ) {
        self.begun.retain(|(fault, ..)| faults.has(*fault));
        if !any(faults) {
            return;
        }
        for axis in Axis::ALL {
            let is_sensed = fresh[axis.unit() as usize] != Freshness::Old;
            if is_sensed && faults.drive(axis, DriveFault::EncoderNoise) {
                let most = noise_counts(axis);
                let off = rng.below(u64::from(2 * most.unsigned_abs() + 1)) as i32 - most;
                let position = &mut inputs.drives[axis as usize].position;
                *position = position.saturating_add(off);
            }
        }
        let flow = [SingleFault::FlowDrift, SingleFault::FlowFrozen].map(Fault::Single);
        let says = self.reading(now_ms, inputs.flow_lps.into(), &FLOW, flow, faults);
        inputs.flow_lps = says as u16;
        let no_loop = [SingleFault::PressureBreak, SingleFault::PressureShort];
        if !no_loop.into_iter().any(|fault| faults.single(fault)) {
            let loop_of = [SingleFault::PressureDrift, SingleFault::PressureFrozen];
            let loop_of = loop_of.map(Fault::Single);
            let is = inputs.pressure_ua.into();
            inputs.pressure_ua = self.reading(now_ms, is, &PRESSURE, loop_of, faults) as u16;
        }
        for place in Place::ALL {
            let heat = [Fault::TemperatureDrift(place), Fault::TemperatureFrozen(place)];
            if let Some(tenths) = &mut inputs.places[place as usize].temperature_dc {
                let is = i32::from(*tenths);
                *tenths = self.reading(now_ms, is, &TEMPERATURE, heat, faults) as i16;
            }
        }
    }

    /// What a sensor says instead of what is.
    fn reading(
        &mut self,
        now_ms: u64,
        is: i32,
        drift: &Drift,
        [drifts, frozen]: [Fault; 2],
        faults: &Faults,
    ) -> i32 {
        let mut says = is;
        if faults.has(drifts) {
            let (since_ms, _) = self.since(now_ms, drifts, is);
            let times = ((now_ms - since_ms) / drift.each_ms).min(100_000) as i32;
            let (min, max) = drift.range;
            says = (is + times * drift.by).clamp(min, max);
        }
        if faults.has(frozen) {
            (_, says) = self.since(now_ms, frozen, says);
        }
        says
    }

    /// When a fault came, and what was read then.
    fn since(&mut self, now_ms: u64, fault: Fault, says: i32) -> (u64, i32) {
        match self.begun.iter().find(|(known, ..)| *known == fault) {
            Some((_, since_ms, said)) => (*since_ms, *said),
            None => {
                self.begun.push((fault, now_ms, says));
                (now_ms, says)
            }
        }
    }
}

/// Whether any sensor is faulty: what is sensed changes by itself then.
pub fn any(faults: &Faults) -> bool {
    faults.active().iter().any(|fault| match fault {
        Fault::Drive(_, fault) => *fault == DriveFault::EncoderNoise,
        Fault::TemperatureFrozen(_) | Fault::TemperatureDrift(_) => true,
        Fault::Single(fault) => matches!(
            fault,
            SingleFault::FlowFrozen
                | SingleFault::FlowDrift
                | SingleFault::PressureFrozen
                | SingleFault::PressureDrift
        ),
        _ => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSED: [Freshness; UNITS] = [Freshness::Sensed; UNITS];

    /// 21 l/s, 12 mA, 5 °C everywhere.
    fn inputs() -> Inputs {
        let mut inputs = Inputs::default();
        inputs.flow_lps = 21;
        inputs.pressure_ua = 12_000;
        inputs.places.iter_mut().for_each(|place| place.temperature_dc = Some(50));
        inputs
    }

    fn spoilt(sensors: &mut Sensors, now_ms: u64, mut inputs: Inputs, faults: &Faults) -> Inputs {
        sensors.spoil(now_ms, SENSED, &mut inputs, &mut Rng::new(now_ms), faults);
        inputs
    }

    fn one(fault: Fault) -> (Sensors, Faults) {
        let mut faults = Faults::default();
        faults.inject(fault);
        assert!(any(&faults), "{}", fault.name());
        (Sensors::default(), faults)
    }

    /// All of its range, nothing beyond, nothing else; what has not been sensed again stays as it is.
    #[test]
    fn noise() {
        for axis in Axis::ALL {
            let (mut sensors, faults) = one(Fault::Drive(axis, DriveFault::EncoderNoise));
            let mut seen: Vec<i32> = Vec::new();
            for now_ms in (0..2_000).step_by(10) {
                let mut noisy = spoilt(&mut sensors, now_ms, inputs(), &faults);
                seen.push(core::mem::take(&mut noisy.drives[axis as usize].position));
                assert_eq!(noisy, inputs());
            }
            let ends = (seen.iter().min().copied(), seen.iter().max().copied());
            assert_eq!(ends, (Some(-noise_counts(axis)), Some(noise_counts(axis))), "{axis:?}");
            let mut old = inputs();
            let mut rng = Rng::new(1);
            sensors.spoil(0, [Freshness::Old; UNITS], &mut old, &mut rng, &faults);
            assert_eq!((old, rng), (inputs(), Rng::new(1)));
        }
        assert!(!any(&Faults::default()));
    }

    #[test]
    fn what_is_frozen_stays_until_it_is_repaired() {
        let places = Place::ALL.map(Fault::TemperatureFrozen);
        let singles = [SingleFault::FlowFrozen, SingleFault::PressureFrozen].map(Fault::Single);
        for fault in places.into_iter().chain(singles) {
            let (mut sensors, mut faults) = one(fault);
            assert_eq!(spoilt(&mut sensors, 10, inputs(), &faults), inputs());
            let later = spoilt(&mut sensors, 60_000, Inputs::default(), &faults);
            let says = |inputs: &Inputs| match fault {
                Fault::TemperatureFrozen(place) => {
                    inputs.places[place as usize].temperature_dc.map(i32::from)
                }
                Fault::Single(SingleFault::FlowFrozen) => Some(inputs.flow_lps.into()),
                _ => Some(inputs.pressure_ua.into()),
            };
            // A sensor that answers nothing cannot be heard at all.
            if !matches!(fault, Fault::TemperatureFrozen(_)) {
                assert_eq!(says(&later), says(&inputs()), "{}", fault.name());
            }
            let mut other = inputs();
            (other.flow_lps, other.pressure_ua) = (0, 4_000);
            other.places.iter_mut().for_each(|place| place.temperature_dc = Some(-300));
            let held = spoilt(&mut sensors, 60_010, other.clone(), &faults);
            assert_eq!(says(&held), says(&inputs()), "{}", fault.name());
            faults.clear(fault);
            assert_eq!(spoilt(&mut sensors, 60_020, other.clone(), &faults), other);
            faults.inject(fault);
            assert_eq!(spoilt(&mut sensors, 60_030, other.clone(), &faults), other, "anew");
        }
    }

    #[test]
    fn what_drifts() {
        let (mut sensors, faults) = one(Fault::Single(SingleFault::FlowDrift));
        for (at_ms, lps) in [(1_000, 21), (5_990, 21), (6_000, 22), (61_000, 33)] {
            assert_eq!(spoilt(&mut sensors, at_ms, inputs(), &faults).flow_lps, lps, "{at_ms}");
        }
        let (mut sensors, mut faults) = one(Fault::Single(SingleFault::PressureDrift));
        for (at_ms, ua) in [(0, 12_000), (1_000, 11_980), (60_000, 10_800), (3_600_000, 0)] {
            assert_eq!(spoilt(&mut sensors, at_ms, inputs(), &faults).pressure_ua, ua, "{at_ms}");
        }
        faults.inject(Fault::Single(SingleFault::PressureShort));
        assert_eq!(spoilt(&mut sensors, 60_000, inputs(), &faults).pressure_ua, 12_000);
        for place in Place::ALL {
            let (mut sensors, faults) = one(Fault::TemperatureDrift(place));
            for (at_ms, tenths) in [(0, 50), (10_000, 60), (7_200_000, 1_000)] {
                let says = spoilt(&mut sensors, at_ms, inputs(), &faults);
                assert_eq!(says.places[place as usize].temperature_dc, Some(tenths), "{at_ms}");
            }
        }
    }
}
