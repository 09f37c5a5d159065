//! A world of few discrete positions: inputs, outputs and memory of the monitor.

use lafet_device::composition::DriveKind;
use lafet_device::guard::Passed;
use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::{
    AXES, Axis, DriveInput, Inputs, Outputs, Spot, UNITS, Unit, UnitInput, VALVES, ValveInput,
    ValveNo, ValveOutput,
};
use lafet_device::{Composition, Device};
use lafet_proto::SubsystemId;
use lafet_proto::flags::{Button, ButtonState};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Address of the monitor.
pub const ADDRESS: u8 = 1;
/// Distance between positions, arc-minutes; mm at the nozzle.
const STEP: [i32; AXES] = [300, 300, 60, 600];
/// Outermost positions of each drive, where its end switches close.
const ENDS: [(i8, i8); AXES] = [(-1, 2), (-2, 2), (-1, 2), (0, 2)];
/// Initial positions: level, straight ahead, narrow jet, stowed.
const FIRST: [i8; AXES] = [0, 0, 1, 0];
/// Position of an open valve; closed is 0.
const OPEN: i8 = 2;
/// Current of a jammed motor, 0.1 A: above MaxCurrent, below the guard's immediate cut-off.
const JAMMED_DA: u16 = 100;
/// Pressure of 8 atm on the sensor's loop, µA.
const PRESSURE_UA: u16 = 12_000;
/// Field of view of the detector, arc-minutes from its axis.
const SEEN_ARCMIN: i32 = 600;

/// Faults, one at a time. Switches never report falsely: the interlock depends on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// The position sensor reports a fault and its reading does not change.
    Encoder(Axis),
    /// The drive does not turn and draws too much current.
    Jam(Axis),
    /// The motor's circuit is open.
    Motor(Axis),
    /// The valve does not turn.
    ValveStuck(ValveNo),
    /// The valve's hardware block is on.
    ValveBlocked(ValveNo),
    /// Remote units neither answer nor act.
    Offline(Unit),
    /// The memory cannot be written.
    Flash,
    /// The detector does not answer.
    Detector,
}

/// The world around the monitor.
#[derive(Clone, Debug)]
pub struct Plant {
    /// Position of each drive, by [`Axis`].
    places: [i8; AXES],
    /// Position of each valve, by [`ValveNo`].
    valves: [i8; VALVES],
    frozen: Option<i32>,
    /// Present outputs of the monitor.
    pub outputs: Outputs,
    /// Whether there is a fire.
    pub fire: bool,
    /// Direction of the fire, arc-minutes to the left of the barrel's rest.
    fire_at: i32,
    /// Whether the pressure sensor answers.
    pub pressure: bool,
    /// The button held on the post.
    pub held: Option<Button>,
    /// The present fault.
    pub fault: Option<Fault>,
    memory: Arc<BTreeMap<u16, Vec<u8>>>,
    /// Number of values stored since this was last read.
    pub stored: u32,
    /// Whether the program asks for its reset.
    pub reset: bool,
    remote: [bool; UNITS],
    folds: bool,
}

impl Plant {
    /// Stowed or at rest, dry, without faults, the memory as delivered.
    pub fn new(composition: &Composition, fire_at: i32) -> Self {
        let drive = |axis: Axis| composition.drives.get(axis as usize) == Some(&DriveKind::Remote);
        let [vertical, horizontal, nozzle, deployer] = Axis::ALL.map(drive);
        let [valve1, valve2] = composition.remote_valves;
        let mut plant = Self {
            places: FIRST,
            valves: [0; VALVES],
            frozen: None,
            outputs: Outputs::default(),
            fire: true,
            fire_at,
            pressure: true,
            held: None,
            fault: None,
            memory: Arc::default(),
            stored: 0,
            reset: false,
            folds: composition.chain.contains(SubsystemId::DEPLOYER),
            remote: [vertical, horizontal, nozzle, deployer, valve1, valve2],
        };
        Device::provision(&mut plant, composition, ADDRESS).expect("an empty memory takes it all");
        plant.stored = 0;
        plant
    }

    /// Everything that can matter later, except what is on its way to the monitor.
    pub fn key(&self) -> impl std::hash::Hash + use<> {
        let bits = [self.fire, self.pressure, self.reset];
        let held = self.held.map(|button| button as u8);
        let outputs = self.outputs.drives.map(|drive| drive.speed_tenths.signum());
        let valves = self.outputs.valves.map(|valve| valve as u8);
        let memory = Arc::clone(&self.memory);
        (self.places, self.valves, self.frozen, bits, held, self.fault, outputs, valves, memory)
    }

    /// What an observer sees.
    pub fn sight(&self) -> ([i8; AXES], [i8; VALVES], [i16; AXES], [ValveOutput; VALVES]) {
        let ways = self.outputs.drives.map(|drive| drive.speed_tenths.signum());
        (self.places, self.valves, ways, self.outputs.valves)
    }

    /// Sets the outputs.
    pub fn drive(&mut self, outputs: Outputs) {
        self.outputs = outputs;
    }

    /// Whether the barrel is in working position.
    pub fn is_deployed(&self) -> bool {
        self.places[Axis::Deployer as usize] == ENDS[Axis::Deployer as usize].1
    }

    /// Whether the barrel is in standby.
    pub fn is_wrapped(&self) -> bool {
        self.places[Axis::Deployer as usize] == ENDS[Axis::Deployer as usize].0
    }

    /// Whether water or foam flows.
    pub fn is_wet(&self) -> bool {
        self.valves.iter().any(|place| *place > 0)
    }

    /// Whether a valve is closed.
    pub fn is_closed(&self, valve: ValveNo) -> bool {
        self.valves[valve as usize] == 0
    }

    /// True position of a drive in its encoder's coordinates.
    pub fn position(&self, axis: Axis) -> i32 {
        i32::from(self.places[axis as usize]) * STEP[axis as usize]
    }

    /// Commanded direction of a drive: up/left 1, down/right -1, none 0.
    pub fn way(&self, axis: Axis) -> i16 {
        self.outputs.drives[axis as usize].speed_tenths.signum()
    }

    /// Introduces a fault.
    pub fn break_down(&mut self, fault: Fault) {
        self.frozen = match fault {
            Fault::Encoder(axis) => Some(self.position(axis)),
            Fault::Offline(unit) => {
                Axis::ALL.into_iter().find(|axis| axis.unit() == unit).map(|a| self.position(a))
            }
            _ => None,
        };
        self.fault = Some(fault);
    }

    /// Removes the fault.
    pub fn mend(&mut self) {
        self.fault = None;
        self.frozen = None;
    }

    /// Advances one tick with the present outputs: each drive and each valve by one position.
    pub fn advance(&mut self) {
        for axis in Axis::ALL {
            let turns = match self.fault {
                Some(Fault::Jam(broken) | Fault::Motor(broken)) => broken != axis,
                Some(Fault::Offline(unit)) => unit != axis.unit(),
                _ => true,
            };
            let (low, high) = ENDS[axis as usize];
            if turns {
                let place = &mut self.places[axis as usize];
                let way = self.outputs.drives[axis as usize].speed_tenths.signum();
                *place = (*place + way as i8).clamp(low, high);
            }
        }
        for valve in ValveNo::ALL {
            let turns = !self.keeps(valve);
            let way = match self.outputs.valves[valve as usize] {
                ValveOutput::Opening if turns => 1,
                ValveOutput::Closing if turns => -1,
                _ => 0,
            };
            let place = &mut self.valves[valve as usize];
            *place = (*place + way).clamp(0, OPEN);
        }
    }

    /// Whether a fault keeps the valve where it is, however it is driven.
    pub fn keeps(&self, valve: ValveNo) -> bool {
        match self.fault {
            Some(Fault::ValveStuck(broken)) => broken == valve,
            Some(Fault::Offline(unit)) => unit == valve.unit(),
            _ => false,
        }
    }

    fn drive_input(&self, axis: Axis) -> DriveInput {
        let (low, high) = ENDS[axis as usize];
        let place = self.places[axis as usize];
        let fed = self.outputs.drives[axis as usize].speed_tenths;
        let jammed = self.fault == Some(Fault::Jam(axis));
        let broken = self.fault == Some(Fault::Encoder(axis));
        let still = jammed || self.fault == Some(Fault::Motor(axis));
        let mut input = DriveInput::default();
        input.position = self.frozen.filter(|_| broken).unwrap_or(self.position(axis));
        input.speed_tenths = if still { 0 } else { fed };
        input.current_da = if jammed && fed != 0 { JAMMED_DA } else { 0 };
        input.min_switch = place <= low;
        input.max_switch = place >= high;
        input.motor_open = self.fault == Some(Fault::Motor(axis));
        input.position_sensor_fault = broken;
        input.speed_sensor_fault = false;
        input
    }

    fn valve_input(&self, valve: ValveNo) -> ValveInput {
        let place = self.valves[valve as usize];
        let mut input = ValveInput::default();
        input.open_switch = place >= OPEN;
        input.close_switch = place <= 0;
        input.blocked = self.fault == Some(Fault::ValveBlocked(valve));
        input
    }

    fn spot(&self) -> Option<Spot> {
        let right = self.fire_at - self.position(Axis::Horizontal);
        let above = -self.position(Axis::Vertical);
        let up = !self.folds || self.is_deployed();
        let seen = self.fire && up && right.abs().max(above.abs()) <= SEEN_ARCMIN;
        let (left, right) = (right as i16 + 30, right as i16 - 30);
        let (bottom, top) = (above as i16 - 30, above as i16 + 30);
        seen.then_some(Spot { left, right, bottom, top, brightness: 500 })
    }
}

impl Storage for Plant {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        let Some(value) = self.memory.get(&key.0) else { return Ok(None) };
        let space = buffer.get_mut(..value.len()).ok_or(StorageError::Read)?;
        space.copy_from_slice(value);
        Ok(Some(space))
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        if self.fault == Some(Fault::Flash) {
            return Err(StorageError::Write);
        }
        Arc::make_mut(&mut self.memory).insert(key.0, value.to_vec());
        self.stored += 1;
        Ok(())
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        if self.fault == Some(Fault::Flash) {
            return Err(StorageError::Write);
        }
        Arc::make_mut(&mut self.memory).clear();
        Ok(())
    }
}

impl Hal for Plant {
    fn read(&mut self, inputs: &mut Inputs) {
        let online = |unit: Unit| {
            let remote = self.remote[unit as usize];
            let online = remote && self.fault != Some(Fault::Offline(unit));
            let mut input = UnitInput::default();
            input.online = online;
            input
        };
        let mut buttons = [[ButtonState::Released; 8]; 2];
        if let Some(button) = self.held {
            buttons[0][button as usize] = ButtonState::Pressed;
        }
        let mut spots = [None; 4];
        spots[0] = self.spot();
        inputs.drives = Axis::ALL.map(|axis| self.drive_input(axis));
        inputs.valves = ValveNo::ALL.map(|valve| self.valve_input(valve));
        inputs.places.iter_mut().for_each(|place| place.temperature_dc = Some(200));
        inputs.humidity_percent = Some(40);
        inputs.main_voltage_dv = 240;
        inputs.pressure_ua = if self.pressure { PRESSURE_UA } else { 0 };
        inputs.buttons = buttons;
        inputs.units = [
            online(Unit::Vertical),
            online(Unit::Horizontal),
            online(Unit::Nozzle),
            online(Unit::Deployer),
            online(Unit::Valve1),
            online(Unit::Valve2),
        ];
        inputs.detector.ready = self.fault != Some(Fault::Detector);
        inputs.detector.spots = spots;
    }

    fn write(&mut self, outputs: &Passed) {
        self.drive(**outputs);
    }

    fn reset(&mut self) {
        self.reset = true;
    }
}
