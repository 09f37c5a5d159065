//! The climate: temperatures of five places, humidity, supply voltage.
//!
//! - each place: dT/dt = (T_ambient + 30 K·heater − T)/600 s: a heater alone lifts it by 30 K;
//! - humidity, %: follows (ambient humidity − (T_box − T_ambient)) with τ = 300 s: warming dries;
//! - supply: U = U₀ − 0.02 Ω·I, with I = all motors and 4 A per heater; 24.0 V by default.
//!
//! Figures ours. Valid for −60…+60 °C; waste heat of the motors and the sun are left out.

use lafet_device::image::{PLACES, Place, PlaceInput};

use crate::fault::{Fault, Faults, SingleFault};

const HEATER_K: f64 = 30.0;
const PLACE_S: f64 = 600.0;
const HUMIDITY_S: f64 = 300.0;
const SUPPLY_OHM: f64 = 0.02;
const HEATER_A: f64 = 4.0;

/// The climate.
#[derive(Clone, Debug, PartialEq)]
pub struct Climate {
    /// Air around the monitor, °C.
    pub ambient_c: f64,
    /// Humidity of the air, %.
    pub ambient_humidity: f64,
    /// Supply without load, V.
    pub supply_v: f64,
    /// Temperatures, by [`Place`].
    pub places_c: [f64; PLACES],
    /// Humidity in the housing, %.
    pub humidity: f64,
    /// Supply at the monitor, V.
    pub voltage_v: f64,
}

impl Climate {
    /// Everything at the temperature of the air.
    pub const fn new(ambient_c: f64) -> Self {
        Self {
            ambient_c,
            ambient_humidity: 45.0,
            supply_v: 24.0,
            places_c: [ambient_c; PLACES],
            humidity: 45.0,
            voltage_v: 24.0,
        }
    }

    /// Runs for `dt_s`, with the current of all motors.
    pub fn step(&mut self, heaters: [bool; PLACES], motors_a: f64, dt_s: f64, faults: &Faults) {
        self.drift(self.aims(heaters, faults), dt_s);
        self.load(heaters, motors_a, faults);
    }

    /// The same so many times in a row, as long as the humidity rounds to the same; whether it did.
    pub(crate) fn steps(
        &mut self,
        heaters: [bool; PLACES],
        dt_s: f64,
        count: u64,
        faults: &Faults,
    ) -> bool {
        let aims = self.aims(heaters, faults);
        let percent = libm::round(self.humidity);
        for _ in 0..count {
            self.drift(aims, dt_s);
            if libm::fabs(self.humidity - percent) >= 0.5 {
                return false;
            }
        }
        self.load(heaters, 0.0, faults);
        true
    }

    fn heats(place: Place, heaters: [bool; PLACES], faults: &Faults) -> bool {
        heaters[place as usize] && !faults.has(Fault::Heater(place))
    }

    /// Where each place's temperature goes to.
    fn aims(&self, heaters: [bool; PLACES], faults: &Faults) -> [f64; PLACES] {
        Place::ALL.map(|place| {
            self.ambient_c + if Self::heats(place, heaters, faults) { HEATER_K } else { 0.0 }
        })
    }

    #[inline]
    fn drift(&mut self, aims: [f64; PLACES], dt_s: f64) {
        for (celsius, aim) in self.places_c.iter_mut().zip(aims) {
            *celsius += (aim - *celsius) * dt_s / PLACE_S;
        }
        let warmer = self.places_c[Place::Box as usize] - self.ambient_c;
        let dry = (self.ambient_humidity - warmer).clamp(5.0, 100.0);
        self.humidity += (dry - self.humidity) * dt_s / HUMIDITY_S;
    }

    fn load(&mut self, heaters: [bool; PLACES], motors_a: f64, faults: &Faults) {
        let mut current = motors_a;
        for place in Place::ALL {
            current += if Self::heats(place, heaters, faults) { HEATER_A } else { 0.0 };
        }
        let supply = match () {
            () if faults.single(SingleFault::VoltageLow) => self.supply_v * 2.0 / 3.0,
            () if faults.single(SingleFault::VoltageHigh) => self.supply_v * 4.0 / 3.0,
            () => self.supply_v,
        };
        self.voltage_v = supply - SUPPLY_OHM * current;
    }

    /// What the sensors of the places say.
    pub fn sense(&self, heaters: [bool; PLACES], faults: &Faults) -> [PlaceInput; PLACES] {
        core::array::from_fn(|index| {
            let place = Place::ALL[index];
            let broken = faults.has(Fault::Temperature(place));
            let tenths = libm::round(self.places_c[index] * 10.0) as i16;
            let mut input = PlaceInput::default();
            input.temperature_dc = (!broken).then_some(tenths);
            input.heater_fault = heaters[index] && faults.has(Fault::Heater(place));
            input
        })
    }

    /// What the humidity sensor says, %.
    pub fn humidity_percent(&self, faults: &Faults) -> Option<u8> {
        let broken = faults.single(SingleFault::Humidity);
        (!broken).then_some(libm::round(self.humidity) as u8)
    }

    /// Supply at the monitor, 0.1 V.
    pub fn voltage_dv(&self) -> u16 {
        libm::round(self.voltage_v * 10.0) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(climate: &mut Climate, heaters: [bool; PLACES], seconds: u32, faults: &Faults) {
        for _ in 0..seconds {
            climate.step(heaters, 0.0, 1.0, faults);
        }
    }

    /// −20 °C with all heaters: 63 % of 30 K in ten minutes, dryer air.
    #[test]
    fn heaters_warm_and_dry() {
        let mut climate = Climate::new(-20.0);
        let faults = Faults::default();
        run(&mut climate, [true; PLACES], 600, &faults);
        let place = climate.sense([true; PLACES], &faults)[0];
        assert!((-15..-5).contains(&place.temperature_dc.unwrap()), "{place:?}");
        assert!(climate.humidity_percent(&faults).unwrap() < 40);
        assert_eq!(climate.voltage_dv(), 236);
        run(&mut climate, [false; PLACES], 6000, &faults);
        assert_eq!(climate.sense([false; PLACES], &faults)[4].temperature_dc, Some(-200));
    }

    #[test]
    fn faults() {
        let mut climate = Climate::new(20.0);
        let mut faults = Faults::default();
        faults.inject(Fault::Temperature(Place::Vertical));
        faults.inject(Fault::Heater(Place::Box));
        faults.inject(Fault::Single(SingleFault::Humidity));
        faults.inject(Fault::Single(SingleFault::VoltageLow));
        climate.step([true; PLACES], 10.0, 1.0, &faults);
        let places = climate.sense([true; PLACES], &faults);
        assert_eq!(places[Place::Vertical as usize].temperature_dc, None);
        assert!(places[Place::Box as usize].heater_fault && !places[0].heater_fault);
        assert_eq!(climate.humidity_percent(&faults), None);
        assert_eq!(climate.voltage_dv(), 155);
    }
}
