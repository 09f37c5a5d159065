//! §3.3.3 «Флаги состояния Climatics»: temperatures, humidity, heating.

use crate::cause::{Cause, Rule};
use crate::image::{Inputs, PLACES, PlaceInput};
use crate::params::Params;
use lafet_proto::flags::ClimaticsFlags;
use lafet_proto::param::Param;
use lafet_proto::status::ThermoStatus;

/// Heating by thresholds: on below HeatOn, off above HeatOff, between them as it was.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Climatics {
    places: [PlaceInput; PLACES],
    humidity_percent: Option<u8>,
    /// Too cold, faults aside.
    demand: [bool; PLACES],
    /// A broken heater shows only while it is on, so its fault stays until no heat is asked for.
    faulty: [bool; PLACES],
    heating: [bool; PLACES],
}

impl Climatics {
    #[inline(never)]
    pub(crate) fn step(&mut self, inputs: &Inputs, params: &Params) {
        self.places = inputs.places;
        self.humidity_percent = inputs.humidity_percent;
        let on_below = params.get(Param::ClimaticsHeatOn);
        let off_above = params.get(Param::ClimaticsHeatOff).max(on_below);
        let nodes = self.demand.iter_mut().zip(&mut self.faulty).zip(&mut self.heating);
        for (((demand, faulty), heating), place) in nodes.zip(&self.places) {
            *demand = match place.temperature_dc.map(i32::from) {
                // §3.3.3/1: without a temperature nothing is heated.
                None => false,
                Some(value) if value < on_below => true,
                Some(value) if value > off_above => false,
                Some(_) => *demand,
            };
            *faulty = place.heater_fault || *faulty && *demand;
            *heating = *demand && !*faulty;
        }
    }

    pub(crate) const fn heaters(&self) -> [bool; PLACES] {
        self.heating
    }

    /// Why each heater is on or off.
    pub(crate) fn causes(&self) -> [Cause; PLACES] {
        let mut causes = [Cause::Rule(Rule::Warm); PLACES];
        let nodes = self.places.iter().zip(self.demand).zip(self.heating);
        for (cause, ((place, demand), heating)) in causes.iter_mut().zip(nodes) {
            *cause = Cause::Rule(match () {
                () if heating => Rule::Cold,
                () if demand => Rule::HeaterFault,
                () if place.temperature_dc.is_none() => Rule::NoTemperature,
                () => Rule::Warm,
            });
        }
        causes
    }

    /// §3.3 ThermoStatus; a faulty sensor reads 0.
    pub(crate) fn status(&self, common: u32) -> ThermoStatus {
        use ClimaticsFlags as F;
        const HEAT: [F; PLACES] =
            [F::HORIZONTAL_HEAT, F::VERTICAL_HEAT, F::NOZZLE_HEAT, F::DEPLOYER_HEAT, F::BOX_HEAT];
        const FAULT: [F; PLACES] = [
            F::HORIZONTAL_FAULT,
            F::VERTICAL_FAULT,
            F::NOZZLE_FAULT,
            F::DEPLOYER_FAULT,
            F::BOX_FAULT,
        ];
        const SENSOR: [F; PLACES] = [
            F::HORIZONTAL_SENSOR_FAULT,
            F::VERTICAL_SENSOR_FAULT,
            F::NOZZLE_SENSOR_FAULT,
            F::DEPLOYER_SENSOR_FAULT,
            F::BOX_SENSOR_FAULT,
        ];
        let mut flags = F::from_bits_retain(common);
        let bits = HEAT.iter().zip(FAULT).zip(SENSOR);
        let nodes = self.places.iter().zip(self.heating).zip(self.faulty);
        for (((heat, fault), sensor), ((place, heating), faulty)) in bits.zip(nodes) {
            flags.set(*heat, heating);
            flags.set(fault, faulty);
            flags.set(sensor, place.temperature_dc.is_none());
        }
        flags.set(F::HUMIDITY_SENSOR_FAULT, self.humidity_percent.is_none());
        let [horizontal, vertical, nozzle, deployer, housing] =
            self.places.map(|place| place.temperature_dc.unwrap_or(0));
        let humidity = self.humidity_percent.unwrap_or(0).into();
        ThermoStatus { flags, horizontal, vertical, nozzle, deployer, housing, humidity }
    }
}
