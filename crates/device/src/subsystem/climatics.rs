//! §3.3.3 «Флаги состояния Climatics»: temperatures, humidity, heating.

use crate::cause::{Cause, Rule};
use crate::image::{Inputs, PLACES, PlaceInput};
use crate::inputs::lasted;
use crate::params::Params;
use lafet_proto::flags::ClimaticsFlags;
use lafet_proto::param::Param;
use lafet_proto::status::ThermoStatus;

/// Heating by thresholds: on below HeatOn, off above HeatOff, between them as it was.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Climatics {
    nodes: [Node; PLACES],
    humidity_percent: Option<u8>,
}

/// A place that may be heated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Node {
    input: PlaceInput,
    /// Too cold, faults aside.
    demand: bool,
    /// A broken heater shows only while it is on, so its fault stays until no heat is asked for.
    faulty: bool,
    /// For how long it has been sensed as faulty, ms.
    fault_ms: u8,
    heating: bool,
}

impl Climatics {
    /// What the sensors say at the start: nothing is heated before the first step.
    pub(crate) fn power_up(&mut self, inputs: &Inputs) {
        self.humidity_percent = inputs.humidity_percent;
        for (node, place) in self.nodes.iter_mut().zip(&inputs.places) {
            node.input = *place;
        }
    }

    #[inline(never)]
    pub(crate) fn step(&mut self, dt_ms: u32, inputs: &Inputs, params: &Params) {
        self.humidity_percent = inputs.humidity_percent;
        let on_below = params.get(Param::ClimaticsHeatOn);
        let off_above = params.get(Param::ClimaticsHeatOff).max(on_below);
        for (node, place) in self.nodes.iter_mut().zip(&inputs.places) {
            node.input = *place;
            match place.temperature_dc.map(i32::from) {
                // §3.3.3/1: without a temperature nothing is heated.
                None => node.demand = false,
                Some(value) if value < on_below => node.demand = true,
                Some(value) if value > off_above => node.demand = false,
                Some(_) => {}
            }
            let fault = lasted(&mut node.fault_ms, dt_ms, place.heater_fault);
            node.faulty = fault || node.faulty && node.demand;
            node.heating = node.demand && !node.faulty;
        }
    }

    /// Which heaters are on.
    pub(crate) fn heaters(&self) -> impl Iterator<Item = bool> {
        self.nodes.iter().map(|node| node.heating)
    }

    /// Why each heater is on or off.
    pub(crate) fn causes(&self) -> impl Iterator<Item = Cause> {
        self.nodes.iter().map(|node| {
            Cause::Rule(match () {
                () if node.heating => Rule::Cold,
                () if node.demand => Rule::HeaterFault,
                () if node.input.temperature_dc.is_none() => Rule::NoTemperature,
                () => Rule::Warm,
            })
        })
    }

    /// §3.3 ThermoStatus; a faulty sensor reads 0.
    pub(crate) fn status(&self, common: u32) -> ThermoStatus {
        use ClimaticsFlags as F;
        const FLAGS: [[F; 3]; PLACES] = [
            [F::HORIZONTAL_HEAT, F::HORIZONTAL_FAULT, F::HORIZONTAL_SENSOR_FAULT],
            [F::VERTICAL_HEAT, F::VERTICAL_FAULT, F::VERTICAL_SENSOR_FAULT],
            [F::NOZZLE_HEAT, F::NOZZLE_FAULT, F::NOZZLE_SENSOR_FAULT],
            [F::DEPLOYER_HEAT, F::DEPLOYER_FAULT, F::DEPLOYER_SENSOR_FAULT],
            [F::BOX_HEAT, F::BOX_FAULT, F::BOX_SENSOR_FAULT],
        ];
        let mut flags = F::from_bits_retain(common);
        for (node, [heat, fault, sensor]) in self.nodes.iter().zip(&FLAGS) {
            flags.set(*heat, node.heating);
            flags.set(*fault, node.faulty);
            flags.set(*sensor, node.input.temperature_dc.is_none());
        }
        flags.set(F::HUMIDITY_SENSOR_FAULT, self.humidity_percent.is_none());
        let [horizontal, vertical, nozzle, deployer, housing] = &self.nodes;
        let of = |node: &Node| node.input.temperature_dc.unwrap_or(0);
        ThermoStatus {
            flags,
            horizontal: of(horizontal),
            vertical: of(vertical),
            nozzle: of(nozzle),
            deployer: of(deployer),
            housing: of(housing),
            humidity: self.humidity_percent.unwrap_or(0).into(),
        }
    }
}
