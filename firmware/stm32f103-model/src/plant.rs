//! What is wired to the chip, by `docs/board-stm32f103.md`: power stages, encoders, contacts, relays and
//! sensors of the simulator's world.

use std::collections::BTreeSet;

use lafet_device::image::{AXES, DriveOutput, Outputs, ValveOutput};
use lafet_sim::world::{STEP_MS, World};

use crate::chip::{Chip, Counter, pin};

/// A pin: port and bit.
pub type Pin = (usize, u32);

/// Under load a motor runs at this part of its speed without.
const DROOP: f64 = 0.85;
/// What a stage makes of shorter pulses is nothing.
pub const LEAST_DUTY: f64 = 0.02;
/// A motor that coasts faster than this part of its full speed passes for one that has voltage, where the circuit
/// that looks for it answers to the generator.
const GENERATES: f64 = 0.2;

const STOP_CHAIN: Pin = pin(b"PA 6");
const DRIVES_ENABLE: Pin = pin(b"PC10");
const VALVES_ENABLE: Pin = pin(b"PC11");
const DIRECTION: [Pin; 4] = [pin(b"PB12"), pin(b"PB13"), pin(b"PB14"), pin(b"PB15")];
/// Low while the motor of vertical, horizontal, nozzle, deployer has voltage.
pub const MOTOR_LIVE: [Pin; 4] = [pin(b"PE12"), pin(b"PE13"), pin(b"PE14"), pin(b"PE15")];
/// End switches, lower and upper, of vertical, horizontal, nozzle, deployer.
pub const ENDS: [[Pin; 2]; 4] = [
    [pin(b"PD 0"), pin(b"PD 1")],
    [pin(b"PD 2"), pin(b"PD 3")],
    [pin(b"PD 4"), pin(b"PD 5")],
    [pin(b"PD 6"), pin(b"PD 7")],
];
/// The deployer's second contacts: wrapped, deployed.
pub const DEPLOYER_AT: [Pin; 2] = [pin(b"PD 8"), pin(b"PD 9")];
const VALVE_AT: [[Pin; 2]; 2] = [[pin(b"PD10"), pin(b"PD11")], [pin(b"PD12"), pin(b"PD13")]];
const VALVE_FREE: [Pin; 2] = [pin(b"PD14"), pin(b"PD15")];
/// Relays of the two valves: open, close.
pub const RELAYS: [[Pin; 2]; 2] = [[pin(b"PE 0"), pin(b"PE 1")], [pin(b"PE 2"), pin(b"PE 3")]];
const MIRRORS: [[Pin; 2]; 2] = [[pin(b"PA 8"), pin(b"PA11")], [pin(b"PC12"), pin(b"PA15")]];
/// Heaters: horizontal, vertical, nozzle, deployer, box.
pub const HEATERS: [Pin; 5] =
    [pin(b"PE 4"), pin(b"PE 5"), pin(b"PE 6"), pin(b"PE 7"), pin(b"PE 8")];
const HEATER_LIVE: [Pin; 5] =
    [pin(b"PB 8"), pin(b"PB 9"), pin(b"PB10"), pin(b"PB11"), pin(b"PE10")];
const PARKED: Pin = pin(b"PC13");

/// The plant.
#[derive(Clone, Debug)]
pub struct Plant {
    /// Drives, valves, water, fires.
    pub world: World,
    stopped: bool,
    /// The stop chain has its own pull-up of 1 kΩ and no 10 nF at its pin.
    pub is_chain_fast: bool,
    /// The jumper "parked" is set.
    pub parked: bool,
    /// Contacts whose wire is broken.
    pub broken: BTreeSet<Pin>,
    /// Relays whose contact is welded.
    pub welded: BTreeSet<Pin>,
    /// Stages whose transistor is shorted: the motor has voltage as long as the stage is enabled.
    pub shorted: [bool; AXES],
    /// Heaters whose circuit is open.
    pub cold: [bool; 5],
    /// Which channel of the PWM, direction and enable each motor is wired to.
    pub motors: [usize; AXES],
    /// Which counter each encoder is wired to.
    pub encoders: [Counter; AXES],
    /// Encoders whose two tracks are exchanged.
    pub crossed: [bool; AXES],
    /// The circuits that look for a motor's voltage answer to one that coasts, too.
    pub generates: bool,
    /// Where each motor has turned to: the play of its gear lies between it and its barrel.
    turned: [f64; AXES],
    /// Where each encoder was before the last step of the world.
    before: [f64; AXES],
    pulses: f64,
    ms: u64,
}

impl Plant {
    /// As the wiring table says.
    pub fn new(world: World) -> Self {
        let before = world.drives.each_ref().map(|drive| drive.position);
        Self {
            world,
            stopped: false,
            is_chain_fast: true,
            parked: false,
            broken: BTreeSet::new(),
            welded: BTreeSet::new(),
            shorted: [false; AXES],
            cold: [false; 5],
            motors: [0, 1, 2, 3],
            encoders: Counter::ALL,
            crossed: [false; AXES],
            generates: false,
            turned: before,
            before,
            pulses: 0.0,
            ms: 0,
        }
    }

    /// Opens or closes the stop chain, now.
    pub fn stop(&mut self, chip: &mut Chip, stopped: bool) {
        self.stopped = stopped;
        self.stop_chain(chip);
    }

    fn stop_chain(&self, chip: &mut Chip) {
        let closed = !self.stopped && !self.broken.contains(&STOP_CHAIN);
        chip.drive(STOP_CHAIN, (closed || self.is_chain_fast).then_some(!closed));
    }

    /// Voltage of each motor as a part of the full one; negative is down or right.
    pub fn voltages(&self, chip: &Chip) -> [f64; AXES] {
        let enabled = chip.drives_high(DRIVES_ENABLE);
        self.motors.map(|channel| {
            let duty = if self.shorted[channel] { 1.0 } else { chip.pwm(channel) };
            let sign = if chip.drives_high(DIRECTION[channel]) { 1.0 } else { -1.0 };
            if enabled && duty > LEAST_DUTY { sign * duty } else { 0.0 }
        })
    }

    /// Whether a motor has voltage.
    pub fn is_live(&self, chip: &Chip) -> bool {
        self.voltages(chip).iter().any(|part| *part != 0.0)
    }

    /// Which relays are on: open, close, of each valve.
    pub fn relays(&self, chip: &Chip) -> [[bool; 2]; 2] {
        let power = chip.drives_high(VALVES_ENABLE);
        RELAYS.map(|pair| {
            pair.map(|pin| power && (chip.drives_high(pin) || self.welded.contains(&pin)))
        })
    }

    /// Whether no drive turns, no relay of a valve is on and both valves are closed.
    pub fn is_at_rest(&self, chip: &Chip) -> bool {
        let still = self.world.drives.iter().all(|drive| drive.speed == 0.0);
        let closed = self.world.valves.iter().all(|valve| valve.free_area() == 0.0);
        still && closed && self.relays(chip) == [[false; 2]; 2]
    }

    /// Which heaters have voltage.
    pub fn heaters(&self, chip: &Chip) -> [bool; 5] {
        HEATERS.map(|pin| chip.drives_high(pin))
    }

    /// A millisecond: the world moves each ten of them, what the chip senses each.
    pub fn tick(&mut self, chip: &mut Chip) {
        self.ms += 1;
        if self.ms.is_multiple_of(STEP_MS) {
            self.before = self.sensed();
            let barrels = self.world.drives.each_ref().map(|drive| drive.position);
            self.world.drive(self.outputs(chip));
            self.world.advance(STEP_MS);
            self.turn(barrels);
        }
        self.encode(chip);
        self.contacts(chip);
        self.sensors(chip);
        let litres = self.world.water.flow_lps / 1_000.0;
        // Ten pulses a litre.
        self.pulses += litres * 10.0;
        let whole = self.pulses.floor();
        self.pulses -= whole;
        chip.pulse(whole as u32);
        chip.convert();
    }

    /// Turns the motors as the world has in its last step, of whose barrels these are the positions before.
    fn turn(&mut self, barrels: [f64; AXES]) {
        let step_s = STEP_MS as f64 / 1_000.0;
        for ((turned, drive), before) in self.turned.iter_mut().zip(&self.world.drives).zip(barrels)
        {
            let half = drive.spec.stage.backlash / 2.0;
            // Where the barrel was put elsewhere, or has met its stop, the motor is there, too.
            *turned = turned.clamp(before - half, before + half) + drive.speed * step_s;
            *turned = turned.clamp(drive.position - half, drive.position + half);
        }
    }

    /// Where each encoder is: on the barrel, or on the motor.
    pub fn sensed(&self) -> [f64; AXES] {
        let mut sensed = self.turned;
        for (place, drive) in sensed.iter_mut().zip(&self.world.drives) {
            if !drive.spec.stage.sensor_on_motor {
                *place = drive.position;
            }
        }
        sensed
    }

    fn outputs(&self, chip: &Chip) -> Outputs {
        let mut outputs = Outputs::default();
        outputs.heaters = self.heaters(chip);
        let speeds = self.voltages(chip).into_iter().zip(&self.world.drives);
        for (output, (part, drive)) in outputs.drives.iter_mut().zip(speeds) {
            let full = drive.spec.max_speed / drive.spec.unit_per_tenth;
            let speed_tenths = (part * full * DROOP).round() as i16;
            *output = DriveOutput { speed_tenths, ..DriveOutput::default() };
        }
        for (output, relays) in outputs.valves.iter_mut().zip(self.relays(chip)) {
            *output = match relays {
                [true, false] => ValveOutput::Opening,
                [false, true] => ValveOutput::Closing,
                // With both on the two directions short each other: the fuse goes.
                _ => ValveOutput::Off,
            };
        }
        outputs
    }

    /// Four counts a minute of arc, forty a millimetre; between two steps of the world in a straight line.
    fn encode(&self, chip: &mut Chip) {
        let part = (self.ms % STEP_MS) as f64 / STEP_MS as f64;
        let noisy = self.is_live(chip);
        let sensed = self.sensed();
        for (axis, counter) in self.encoders.iter().enumerate() {
            let now = sensed[axis];
            let position = self.before[axis] + (now - self.before[axis]) * part;
            let counts = position * if axis == 2 { 40.0 } else { 4.0 };
            let counts = if self.crossed[axis] { -counts } else { counts };
            chip.turn(*counter, counts.round() as i64, noisy);
        }
    }

    fn contact(&self, chip: &mut Chip, pin: Pin, closed: bool) {
        let closed = closed && !self.broken.contains(&pin);
        chip.drive(pin, closed.then_some(false));
    }

    fn contacts(&self, chip: &mut Chip) {
        let inputs = self.world.inputs();
        self.stop_chain(chip);
        self.contact(chip, PARKED, self.parked);
        for (drive, [lower, upper]) in inputs.drives.iter().zip(ENDS) {
            self.contact(chip, lower, !drive.min_switch);
            self.contact(chip, upper, !drive.max_switch);
        }
        let deployer = inputs.drives[3];
        self.contact(chip, DEPLOYER_AT[0], deployer.min_switch);
        self.contact(chip, DEPLOYER_AT[1], deployer.max_switch);
        for (valve, ([open, closed], free)) in
            inputs.valves.iter().zip(VALVE_AT.iter().zip(VALVE_FREE))
        {
            self.contact(chip, *open, valve.open_switch);
            self.contact(chip, *closed, valve.close_switch);
            self.contact(chip, free, !valve.blocked);
        }
        let relays = self.relays(chip);
        for (pair, (states, driven)) in MIRRORS.iter().zip(relays.iter().zip(RELAYS)) {
            for ((pin, state), relay) in pair.iter().zip(states).zip(driven) {
                self.contact(chip, *pin, *state || self.welded.contains(&relay));
            }
        }
        let voltages = self.voltages(chip);
        for (axis, channel) in self.motors.iter().enumerate() {
            let drive = &self.world.drives[axis];
            let coasts = drive.speed.abs() > GENERATES * drive.spec.max_speed;
            let is_live = voltages[axis] != 0.0 || self.generates && coasts;
            self.contact(chip, MOTOR_LIVE[*channel], is_live);
        }
        let heaters = self.heaters(chip);
        for (place, pin) in HEATER_LIVE.iter().enumerate() {
            self.contact(chip, *pin, heaters[place] && !self.cold[place]);
        }
    }

    fn sensors(&self, chip: &mut Chip) {
        let inputs = self.world.inputs();
        let millivolts = |mv: f64| (mv / 3_300.0 * 4_096.0).round().clamp(0.0, 4_095.0) as u16;
        for (axis, channel) in self.motors.iter().enumerate() {
            let amperes = self.world.drives[axis].current_a;
            chip.analog[10 + channel] = (amperes * 100.0).round().min(4_095.0) as u16;
        }
        let amperes: f64 = self.world.valves.iter().map(|valve| valve.current_a).sum();
        chip.analog[8] = (amperes * 100.0).round().min(4_095.0) as u16;
        // 150 Ω; 1:11.
        chip.analog[14] = millivolts(f64::from(inputs.pressure_ua) * 0.150);
        chip.analog[15] = millivolts(f64::from(inputs.main_voltage_dv) * 100.0 / 11.0);
        let humidity = inputs.humidity_percent.map_or(0.0, |part| 100.0 + 29.0 * f64::from(part));
        chip.analog[9] = millivolts(humidity);
        for (place, channel) in inputs.places.iter().zip([2, 3, 4, 5, 7]) {
            let degrees = place.temperature_dc.map_or(0.0, |tenths| 500.0 + f64::from(tenths));
            chip.analog[channel] = millivolts(degrees);
        }
    }
}
