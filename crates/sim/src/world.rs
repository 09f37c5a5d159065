//! The world around the monitor: it owns every part, moves time, and is the monitor's HAL.
//!
//! Time goes in steps of 10 ms. In each step, in this order: outputs reach the parts (over the
//! internal bus where a unit is remote), drives, valves, water, then each 100 ms the jet, the
//! fires and the climate, each 20 ms a picture of the detector; last the inputs are sampled.

use lafet_device::composition::{Composition, DriveKind};
use lafet_device::guard::Passed;
use lafet_device::hal::{Hal, Key, Software, Storage, StorageError};
use lafet_device::image::{
    AXES, Axis, Inputs, Outputs, UNITS as UNIT_COUNT, UnitInput, VALVES, ValveNo, ValveOutput,
};
use lafet_proto::SubsystemId;
use lafet_proto::flags::{Button, ButtonState};
use lafet_update::Started;

use crate::airborne::{Airborne, Portion};
use crate::climate::Climate;
use crate::contact::{Contacts, Freshness};
use crate::detector::{Aim, Detector, PICTURE_MS};
use crate::drive::{Drive, DriveSpec, Load};
use crate::event::{Event, Events, What};
use crate::fault::{ButtonFault, DriveFault, Fault, Faults, Post, UNITS};
use crate::fire::{Fire, FireSpec};
use crate::fires::Fires;
use crate::flash::{Chip, Flash};
use crate::gust::Gusts;
use crate::jet::{Jet, Landing};
use crate::nozzle::MONITOR;
use crate::power::Power;
use crate::rng::Rng;
use crate::sensor::Sensors;
use crate::software::Programs;
use crate::unit::{POLL_MS, RemoteUnit};
use crate::valve::Valve;
use crate::water::Water;

mod rest;

/// The step of the world, ms.
pub const STEP_MS: u64 = 10;

const SLOW_MS: u64 = 100;
/// A current that flickers is missing in one reading in this time.
const FLICKER_MS: u64 = 100;

/// What the world is built from.
#[derive(Clone, Debug)]
pub struct WorldConfig {
    /// Everything random comes from this.
    pub seed: u64,
    /// The barrel folds; without a deployer it is always in its working position.
    pub deployer: bool,
    /// What is a remote unit on the internal bus (explosion-proof execution), by `Unit`.
    pub remote: [bool; UNIT_COUNT],
    /// Drives, by [`Axis`].
    pub drives: [DriveSpec; AXES],
    /// True positions at the start, by [`Axis`].
    pub start: [f64; AXES],
    /// Time of a valve from end to end, s.
    pub valve_travel_s: f64,
    /// Diameter of the nozzle's outlet, mm.
    pub nozzle_mm: f64,
    /// Pressure at 20 mA of the sensor, atm.
    pub pressure_range_atm: f64,
    /// Height of the nozzle above ground, m.
    pub height_m: f64,
    /// Mean wind 10 m above ground, m/s: forward (azimuth 0) and left.
    pub wind: (f64, f64),
    /// Gusts: standard deviation of the wind's speed over its mean.
    pub gusts: f64,
    /// Air, °C.
    pub ambient_c: f64,
    /// The fire detector and its mounting.
    pub detector: Detector,
    /// What burns from the start.
    pub fires: Vec<FireSpec>,
    /// The ground belongs to a site: water that lands is handed over by [`World::take_landed`], and
    /// `fires` only shows what burns there.
    pub shared_ground: bool,
}

impl WorldConfig {
    /// The world of a monitor of this composition.
    pub fn of(composition: &Composition) -> Self {
        let mut config =
            Self { deployer: composition.chain.contains(SubsystemId::DEPLOYER), ..Self::default() };
        let drives = composition.drives.map(|kind| kind == DriveKind::Remote);
        for (remote, is) in
            config.remote.iter_mut().zip(drives.into_iter().chain(composition.remote_valves))
        {
            *remote = is;
        }
        config
    }
}

impl Default for WorldConfig {
    fn default() -> Self {
        Self {
            seed: 1,
            deployer: true,
            remote: [false; UNIT_COUNT],
            drives: Axis::ALL.map(DriveSpec::nominal),
            start: [0.0, 0.0, 60.0, 0.0],
            valve_travel_s: 4.0,
            nozzle_mm: 28.0,
            pressure_range_atm: 16.0,
            height_m: 1.5,
            wind: (0.0, 0.0),
            gusts: 0.0,
            ambient_c: 20.0,
            detector: Detector::default(),
            fires: Vec::new(),
            shared_ground: false,
        }
    }
}

/// The world.
#[derive(Clone, Debug)]
pub struct World {
    /// Drives, by [`Axis`].
    pub drives: [Drive; AXES],
    /// Valves, by [`ValveNo`].
    pub valves: [Valve; VALVES],
    /// Pump, pipe, nozzle.
    pub water: Water,
    /// Everything that was lit, burning or out.
    pub fires: Fires,
    /// The fire detector.
    pub detector: Detector,
    /// Temperatures, humidity, supply.
    pub climate: Climate,
    /// The monitor's non-volatile memory.
    pub flash: Flash,
    /// What is broken.
    pub faults: Faults,
    /// Mean wind 10 m above ground, m/s: forward (azimuth 0) and left.
    pub wind: (f64, f64),
    /// How it varies.
    pub gusts: Gusts,
    /// Height of the nozzle above ground, m.
    pub height_m: f64,
    /// Software that can be updated, where the monitor has it.
    pub(crate) software: Option<Box<Programs>>,
    deployer: bool,
    /// In boxes: few monitors have any, and the others need not walk past them in each step.
    units: [Option<Box<RemoteUnit>>; UNIT_COUNT],
    buttons: [[bool; 8]; 2],
    rng: Rng,
    now_ms: u64,
    commanded: Outputs,
    applied: Outputs,
    sensed: Inputs,
    contacts: Contacts,
    sensors: Sensors,
    power: Power,
    airborne: Airborne,
    events: Events,
    /// Water that has landed on a site's ground; `None` where the ground is the world's own.
    landed: Option<Vec<Portion>>,
    jet_on: bool,
    flooded: bool,
    reset_requested: bool,
    /// Until then the flash is written or erased, and the program is stopped.
    busy_until_us: u64,
}

impl World {
    /// A world at rest.
    pub fn new(config: WorldConfig) -> Self {
        let mut drives = config.drives;
        let mut water = Water::new(config.nozzle_mm);
        water.range_atm = config.pressure_range_atm;
        let mut world = Self {
            drives: Axis::ALL.map(|axis| {
                let spec = core::mem::replace(&mut drives[axis as usize], DriveSpec::nominal(axis));
                Drive::new(axis, spec, config.start[axis as usize])
            }),
            valves: ValveNo::ALL.map(|number| Valve::new(number, config.valve_travel_s)),
            water,
            fires: Fires::default(),
            detector: config.detector,
            climate: Climate::new(config.ambient_c),
            flash: Flash::new(config.seed),
            faults: Faults::default(),
            wind: config.wind,
            gusts: Gusts::new(config.gusts, config.seed),
            height_m: config.height_m,
            software: None,
            deployer: config.deployer,
            units: UNITS
                .map(|unit| config.remote[unit as usize].then(|| Box::new(RemoteUnit::new(unit)))),
            buttons: [[false; 8]; 2],
            rng: Rng::new(config.seed),
            now_ms: 0,
            commanded: Outputs::default(),
            applied: Outputs::default(),
            sensed: Inputs::default(),
            contacts: Contacts::default(),
            sensors: Sensors::default(),
            power: Power::default(),
            airborne: Airborne::default(),
            events: Events::default(),
            landed: config.shared_ground.then(Vec::new),
            jet_on: false,
            flooded: false,
            reset_requested: false,
            busy_until_us: 0,
        };
        for fire in config.fires {
            world.light(fire);
        }
        world.exchange();
        world.look();
        world.sense(true);
        world
    }

    /// Virtual time since the world began, ms.
    pub const fn now_ms(&self) -> u64 {
        self.now_ms
    }

    /// What the monitor drives, as it said last.
    pub const fn outputs(&self) -> &Outputs {
        &self.commanded
    }

    /// The state of all that is random.
    pub const fn rng(&self) -> &Rng {
        &self.rng
    }

    /// What the monitor senses now.
    pub const fn inputs(&self) -> &Inputs {
        &self.sensed
    }

    /// Lights a fire, or puts a thing there that can catch fire; its number is its place in `fires`.
    pub fn light(&mut self, spec: FireSpec) -> usize {
        let index = self.fires.add(Fire::new(spec));
        if spec.lit {
            self.note(What::FireLit(index));
        }
        index
    }

    /// The water that has landed since the last call, where the ground is a site's.
    pub fn take_landed(&mut self) -> Vec<Portion> {
        self.landed.as_mut().map(core::mem::take).unwrap_or_default()
    }

    /// Clears away everything that was lit, with what is known of it.
    pub fn sweep(&mut self) {
        self.fires = Fires::default();
    }

    /// Presses or releases a button.
    pub fn press(&mut self, post: Post, button: Button, pressed: bool) {
        self.buttons[post as usize][button as usize] = pressed;
        self.sense_buttons();
    }

    /// Puts a fault in force.
    pub fn inject(&mut self, fault: Fault) {
        self.faults.inject(fault);
        self.sense(false);
    }

    /// Repairs a fault.
    pub fn clear(&mut self, fault: Fault) {
        self.faults.clear(fault);
        self.sense(false);
    }

    /// Repairs everything.
    pub fn clear_all(&mut self) {
        self.faults.clear_all();
        self.sense(false);
    }

    /// Whether the barrel is in its working position.
    pub fn deployed(&self) -> bool {
        let drive = &self.drives[Axis::Deployer as usize];
        !self.deployer || drive.position >= drive.spec.switches.1
    }

    /// Where the jet would land now; `None` without water at the nozzle.
    pub fn landing(&self) -> Option<Landing> {
        (self.water.jet_lps() > 0.1 && self.deployed()).then(|| self.jet().landing())
    }

    /// Whether water flows into a folded barrel now.
    pub const fn flooded(&self) -> bool {
        self.flooded
    }

    /// What happened since the last call, oldest first; see [`Events`].
    pub fn take_events(&mut self) -> Vec<Event> {
        self.events.take()
    }

    /// Adds an event at the present time.
    pub fn note(&mut self, what: What) {
        self.events.note(self.now_ms, what);
    }

    /// Whether the monitor has asked for a reset since the last call.
    pub fn take_reset(&mut self) -> bool {
        core::mem::take(&mut self.reset_requested)
    }

    /// The supply fails: nothing is driven any more, and what the flash was at is torn.
    pub fn cut_power(&mut self) {
        let now_us = (self.now_ms + STEP_MS) * 1000;
        if self.busy_until_us > now_us {
            let left_us = self.busy_until_us - now_us;
            let at_us = self.busy_us().saturating_sub(left_us);
            self.flash.interrupt(at_us);
            if let Some(chip) = self.software_chip_mut() {
                chip.interrupt(at_us);
            }
        }
        self.busy_until_us = 0;
        self.commanded = Outputs::default();
        self.reset_requested = false;
    }

    /// Whether the program is stopped in the step that ends now, because the flash it runs from
    /// is being written or erased.
    pub const fn is_stalled(&self) -> bool {
        self.busy_until_us > self.now_ms * 1000
    }

    /// Whether it will still stand still in the next step.
    pub const fn stays_stalled(&self) -> bool {
        self.busy_until_us >= (self.now_ms + STEP_MS) * 1000
    }

    /// What runs of the software that can be updated; `None` where there is none, or nothing runs.
    pub(crate) fn running(&self) -> Option<Started> {
        self.software.as_deref().and_then(Programs::running)
    }

    /// The flash of the software that can be updated, where the monitor has such.
    pub fn software_chip(&self) -> Option<&Chip> {
        self.software.as_deref().map(Programs::chip)
    }

    /// The flash of the software that can be updated: bits to flip.
    pub fn software_chip_mut(&mut self) -> Option<&mut Chip> {
        self.software.as_deref_mut().map(Programs::chip_mut)
    }

    /// Whether a cut has taken the power, in the memory or in the flash of the software.
    pub(crate) fn is_off(&self) -> bool {
        self.flash.chip().is_off() || self.software_chip().is_some_and(Chip::is_off)
    }

    /// Time that the flash was written and erased in this step, µs: one part of it after the other.
    fn busy_us(&self) -> u64 {
        let busy_us = self.flash.chip().busy_us();
        self.software_chip().map_or(busy_us, |chip| chip.busy_us().max(busy_us))
    }

    /// A step of the program begins.
    pub(crate) fn begin_flash(&mut self) {
        self.flash.begin();
        if let Some(chip) = self.software_chip_mut() {
            chip.begin();
        }
    }

    /// The bootloader starts the software that can be updated. Where nothing runs then: after how long
    /// the next reset comes, ms.
    pub(crate) fn start_software(&mut self) -> Option<u64> {
        self.software.as_deref_mut().and_then(Programs::start)
    }

    /// The program starts: the store is mounted, encoders begin to count.
    pub(crate) fn start_flash(&mut self) {
        for (drive, input) in self.drives.iter_mut().zip(&mut self.sensed.drives) {
            if drive.spec.relative {
                drive.start_encoder();
                *input = drive.sense(&self.faults);
            }
        }
        self.flash.begin();
        if let Some(software) = &self.software {
            self.flash.chip_mut().wait_until(software.chip().busy_us());
        }
        self.flash.start(&self.faults);
    }

    /// What the program did at this time took the flash so long.
    pub(crate) fn stall(&mut self) {
        self.busy_until_us = self.now_ms * 1000 + self.busy_us();
    }

    /// Moves time; a part of a step is left out.
    pub fn advance(&mut self, dt_ms: u64) {
        for _ in 0..dt_ms / STEP_MS {
            self.step();
        }
    }

    fn step(&mut self) {
        self.now_ms += STEP_MS;
        let dt_s = STEP_MS as f64 / 1000.0;
        let heard = self.exchange();
        let elevation = self.angle(Axis::Vertical);
        let load = Load { cos_elevation: libm::cos(elevation), flow_lps: self.water.jet_lps() };
        for (drive, output) in self.drives.iter_mut().zip(self.applied.drives) {
            drive.step(output, load, dt_s, &self.faults);
        }
        for (valve, output) in self.valves.iter_mut().zip(self.applied.valves) {
            valve.step(output, dt_s, &self.faults);
        }
        let drives = self.drives.iter().map(|drive| drive.current_a);
        let valves = self.valves.iter().map(|valve| valve.current_a);
        self.power.step(self.now_ms, drives.chain(valves));
        let areas = [self.valves[0].free_area(), self.valves[1].free_area()];
        self.water.step(areas, dt_s, &self.faults);
        if self.now_ms.is_multiple_of(SLOW_MS) {
            self.slow();
        }
        if self.now_ms.is_multiple_of(PICTURE_MS) {
            self.look();
        }
        self.sense(heard);
    }

    /// Brings the outputs to the parts; true in the steps in which remote units are polled.
    fn exchange(&mut self) -> bool {
        let poll = self.now_ms.is_multiple_of(POLL_MS);
        self.applied.heaters = self.commanded.heaters;
        for (index, unit) in self.units.iter_mut().enumerate() {
            let good = match unit {
                None => true,
                Some(unit) if poll => {
                    let op = self.commanded.units[index];
                    unit.poll(self.now_ms, op, &mut self.rng, &self.faults)
                }
                Some(_) => false,
            };
            let abandoned = unit.as_ref().is_some_and(|unit| unit.abandoned(self.now_ms));
            let valve = index.checked_sub(AXES);
            match valve {
                Some(valve) if good => self.applied.valves[valve] = self.commanded.valves[valve],
                Some(valve) if abandoned => self.applied.valves[valve] = ValveOutput::Off,
                None if good => self.applied.drives[index] = self.commanded.drives[index],
                None if abandoned => self.applied.drives[index].speed_tenths = 0,
                _ => {}
            }
        }
        poll
    }

    fn angle(&self, axis: Axis) -> f64 {
        (self.drives[axis as usize].position / 60.0).to_radians()
    }

    /// The jet as it would leave the nozzle now.
    pub fn jet(&self) -> Jet {
        Jet {
            family: MONITOR,
            pressure_mpa: self.water.pressure_mpa,
            nozzle_mm: self.water.nozzle_mm,
            spray_mm: self.drives[Axis::Nozzle as usize].position,
            azimuth: self.angle(Axis::Horizontal),
            elevation: self.angle(Axis::Vertical),
            height_m: self.height_m,
            wind: self.gusts.around(self.wind),
        }
    }

    /// Jet, fires and climate.
    fn slow(&mut self) {
        let dt_s = SLOW_MS as f64 / 1000.0;
        self.gusts.step(self.wind, dt_s);
        self.throw(dt_s);
        self.land(dt_s);
        let motors_a: f64 = self.drives.iter().map(|drive| drive.current_a).sum::<f64>()
            + self.valves.iter().map(|valve| valve.current_a).sum::<f64>();
        self.climate.step(self.applied.heaters, motors_a, dt_s, &self.faults);
    }

    /// Water reaches the ground, and fires burn, unless the ground is a site's.
    fn land(&mut self, dt_s: f64) {
        let (now_ms, events) = (self.now_ms, &mut self.events);
        let mut note = |what| events.note(now_ms, what);
        while let Some(portion) = self.airborne.land(now_ms) {
            match &mut self.landed {
                Some(landed) => landed.push(portion),
                None => self.fires.catch(&portion, &mut note),
            }
        }
        if self.landed.is_none() {
            self.fires.burn(dt_s, note);
        }
    }

    fn throw(&mut self, dt_s: f64) {
        // Behind closed valves the flow only dies away.
        let fed = self.valves.iter().any(|valve| valve.free_area() > 1e-3);
        let flows = fed && self.water.filled > 0.01 && self.water.flow_lps > 0.1;
        let flooded = flows && !self.deployed();
        if flooded && !self.flooded {
            self.note(What::FoldedBarrelFlooded);
        }
        self.flooded = flooded;
        let landing = self.landing();
        if landing.is_some() != self.jet_on {
            self.jet_on = landing.is_some();
            self.note(if self.jet_on { What::JetOn } else { What::JetOff });
        }
        let Some(landing) = landing else { return };
        let litres = self.water.jet_lps() * dt_s;
        let (foam, jet) = (self.water.foam, self.jet());
        self.airborne.throw(self.now_ms, Portion { litres, foam, jet, landing });
    }

    fn aim(&self) -> Aim {
        Aim {
            azimuth: self.drives[Axis::Horizontal as usize].position,
            elevation: self.drives[Axis::Vertical as usize].position,
            height_m: self.height_m,
            deployed: self.deployed(),
        }
    }

    fn look(&mut self) {
        let aim = self.aim();
        self.sensed.detector = self.detector.look(aim, &self.fires, &mut self.rng, &self.faults);
    }

    /// Samples the inputs; those of remote units only with a good exchange.
    fn sense(&mut self, polled: bool) {
        let faults = &self.faults;
        let mut freshness = [Freshness::Old; UNIT_COUNT];
        for (index, unit) in self.units.iter().enumerate() {
            let input = match unit {
                None => {
                    let mut present = UnitInput::default();
                    present.online = true;
                    present
                }
                Some(unit) => unit.sense(self.now_ms, faults),
            };
            let fresh = unit.is_none()
                || (polled && input.online && !input.protocol_fault && self.answered(index));
            if fresh {
                let polled = unit.is_some();
                freshness[index] = if polled { Freshness::Polled } else { Freshness::Sensed };
            }
            self.sensed.units[index] = input;
            match index.checked_sub(AXES) {
                _ if !fresh => {}
                None => self.sensed.drives[index] = self.drives[index].sense(faults),
                Some(valve) => self.sensed.valves[valve] = self.valves[valve].sense(faults),
            }
        }
        self.contacts.shake(self.now_ms, freshness, &mut self.sensed, faults);
        for (axis, input) in Axis::ALL.into_iter().zip(&mut self.sensed.drives) {
            let gap = self.now_ms.is_multiple_of(FLICKER_MS);
            if gap && faults.drive(axis, DriveFault::Flicker) {
                input.current_da = 0;
            }
        }
        self.sensed.places = self.climate.sense(self.applied.heaters, faults);
        self.sensed.humidity_percent = self.climate.humidity_percent(faults);
        let voltage_dv = self.climate.voltage_dv();
        self.sensed.main_voltage_dv = self.power.voltage_dv(self.now_ms, voltage_dv, faults);
        self.sensed.pressure_ua = self.water.loop_ua(&mut self.rng, &self.faults);
        self.sensed.flow_lps = libm::round(self.water.flow_lps) as u16;
        self.sensors.spoil(self.now_ms, freshness, &mut self.sensed, &mut self.rng, &self.faults);
        self.sense_buttons();
    }

    fn answered(&self, index: usize) -> bool {
        self.units[index].as_ref().is_none_or(|unit| unit.answered_at(self.now_ms))
    }

    fn sense_buttons(&mut self) {
        for post in Post::ALL {
            for button in Button::ALL {
                let fault = |fault| self.faults.has(Fault::Button(*post, button, fault));
                let pressed = self.buttons[*post as usize][button as usize];
                let pressed =
                    self.contacts.shake_button(self.now_ms, (*post, button), pressed, &self.faults);
                self.sensed.buttons[*post as usize][button as usize] = match () {
                    () if fault(ButtonFault::Short) => ButtonState::Short,
                    () if fault(ButtonFault::Break) => ButtonState::Open,
                    () if pressed => ButtonState::Pressed,
                    () => ButtonState::Released,
                };
            }
        }
    }
}

impl World {
    /// Drives it like this. What is left of a step in which power failed drives nothing.
    pub fn drive(&mut self, outputs: Outputs) {
        if !self.is_off() {
            self.commanded = outputs;
        }
    }
}

impl Hal for World {
    fn read(&mut self, inputs: &mut Inputs) {
        inputs.clone_from(&self.sensed);
    }

    fn write(&mut self, outputs: &Passed) {
        self.drive(**outputs);
    }

    fn reset(&mut self) {
        self.reset_requested = !self.is_off();
    }

    fn software(&mut self) -> Option<&mut dyn Software> {
        let software = self.software.as_deref_mut()?;
        software.follow(self.flash.chip());
        software.receiver()
    }
}

impl Storage for World {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        self.flash.load(key, buffer, &self.faults)
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        if self.is_off() {
            return Err(StorageError::Write);
        }
        self.flash.store(key, value, &self.faults)
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        if self.is_off() {
            return Err(StorageError::Write);
        }
        self.flash.erase(&self.faults)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::UnitFault;
    use lafet_device::image::Unit;

    fn deployed(fires: Vec<FireSpec>) -> World {
        let start = [0.0, 0.0, 60.0, 5_400.0];
        World::new(WorldConfig { start, fires, ..WorldConfig::default() })
    }

    fn drive(world: &mut World, axis: Axis, speed_tenths: i16) {
        let mut outputs = *world.outputs();
        outputs.drives[axis as usize].speed_tenths = speed_tenths;
        world.drive(outputs);
    }

    fn open(world: &mut World) {
        let mut outputs = *world.outputs();
        outputs.valves[0] = ValveOutput::Opening;
        world.drive(outputs);
    }

    /// Wrapped at the start, 24.0 V, 20 °C, no pressure; the detector is blind.
    #[test]
    fn at_rest() {
        let world = World::new(WorldConfig::default());
        let inputs = world.inputs();
        assert!(inputs.drives[Axis::Deployer as usize].min_switch && !world.deployed());
        assert!(inputs.valves.iter().all(|valve| valve.close_switch));
        assert_eq!(inputs.main_voltage_dv, 240);
        assert_eq!(inputs.places[0].temperature_dc, Some(200));
        assert!((3_990..4_010).contains(&inputs.pressure_ua));
        assert!(inputs.detector.ready && inputs.units.iter().all(|unit| unit.online));
    }

    /// Aimed by the table of the jet (6° ⇒ 31 m), 20 l/s put a fire out and the one beside it burns on.
    #[test]
    fn water_puts_out_the_fire_it_reaches() {
        let fire = |azimuth_deg| FireSpec {
            azimuth_deg,
            range_m: 31.0,
            size_m: 1.5,
            ..FireSpec::default()
        };
        let mut world = deployed(vec![fire(0.0), fire(20.0)]);
        world.drives[Axis::Vertical as usize].position = 360.0;
        open(&mut world);
        world.advance(6_000);
        assert_eq!(world.inputs().flow_lps, 20);
        assert!((world.landing().unwrap().range_m() - 31.0).abs() < 0.5);
        world.advance(24_000);
        assert!(!world.fires[0].burns() && world.fires[1].burns());
        let events = world.take_events();
        let at = |what| events.iter().find(|event| event.what == what).map(|event| event.at_ms);
        let (on, hit, out) = (
            at(What::JetOn).unwrap(),
            at(What::FireHit(0)).unwrap(),
            at(What::FireOut(0)).unwrap(),
        );
        assert!(on < hit && hit < out, "{events:?}");
        assert!((1_000..3_000).contains(&(hit - on)), "time of flight {}", hit - on);
        assert_eq!(at(What::FoldedBarrelFlooded), None);
    }

    #[test]
    fn a_folded_barrel_is_flooded() {
        let mut world = World::new(WorldConfig::default());
        open(&mut world);
        world.advance(2_000);
        assert!(world.take_events().iter().any(|e| e.what == What::FoldedBarrelFlooded));
        assert_eq!(world.landing(), None);
    }

    #[test]
    fn remote_units_stop_by_themselves() {
        let mut world =
            World::new(WorldConfig { remote: [true; UNIT_COUNT], ..WorldConfig::default() });
        drive(&mut world, Axis::Horizontal, 100);
        world.advance(1_000);
        let before = world.inputs().drives[Axis::Horizontal as usize].position;
        assert!(before > 400);
        world.inject(Fault::Unit(Unit::Horizontal, UnitFault::Offline));
        world.advance(1_000);
        let horizontal = &world.drives[Axis::Horizontal as usize];
        assert!(horizontal.speed == 0.0 && horizontal.position < f64::from(before) + 200.0);
        let input = &world.inputs().drives[Axis::Horizontal as usize];
        assert!(!world.inputs().units[1].online && (input.position - before).abs() <= 6);
        world.clear(Fault::Unit(Unit::Horizontal, UnitFault::Offline));
        world.advance(1_000);
        assert!(world.inputs().units[1].online && world.drives[1].speed > 0.0);
    }

    #[test]
    fn buttons_and_faults_show_at_once() {
        let mut world = World::new(WorldConfig::default());
        world.press(Post::ExtButtons, Button::Open, true);
        assert_eq!(world.inputs().buttons[1][6], ButtonState::Pressed);
        world.inject(Fault::Button(Post::Buttons, Button::Left, ButtonFault::Break));
        assert_eq!(world.inputs().buttons[0][0], ButtonState::Open);
        world.inject(Fault::Drive(Axis::Nozzle, DriveFault::MotorOpen));
        assert!(world.inputs().drives[Axis::Nozzle as usize].motor_open);
    }

    #[test]
    fn same_seed_same_inputs() {
        let run = |seed| {
            let fires = vec![FireSpec { range_m: 25.0, ..FireSpec::default() }];
            let start = [0.0, 0.0, 60.0, 5_400.0];
            let config = WorldConfig { seed, start, fires, ..WorldConfig::default() };
            let mut world = World::new(config);
            open(&mut world);
            world.advance(5_000);
            format!("{:?}", world.inputs())
        };
        assert_eq!(run(7), run(7));
        assert_ne!(run(7), run(8));
    }
}
