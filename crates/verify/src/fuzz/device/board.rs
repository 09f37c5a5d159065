//! The hardware under the fuzzed monitor: it follows the outputs where permitted, and reports any
//! inputs and memory failures that the input of the fuzzer selects.

use std::collections::BTreeMap;

use crate::fuzz::feed::Feed;
use lafet_device::Composition;
use lafet_device::composition::DriveKind;
use lafet_device::guard::Passed;
use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::{
    AXES, Axis, Inputs, Outputs, PLACES, SPOTS, Spot, UNITS, UnitError, UnitReply, VALVES,
    ValveOutput,
};
use lafet_proto::flags::ButtonState;

/// Position of the deployed barrel, arc-minutes.
const DEPLOYED_ARCMIN: i64 = 5_400;
/// Time from closed to open, ms.
const VALVE_MS: i64 = 4_000;

#[derive(Clone, Debug, Default)]
pub struct Board {
    pub inputs: Inputs,
    /// Inputs last sampled by the device.
    pub sampled: Inputs,
    /// Outputs driven since this was last read.
    pub written: Vec<Outputs>,
    pub memory: BTreeMap<u16, Vec<u8>>,
    pub load_fails: bool,
    pub store_fails: bool,
    pub erase_fails: bool,
    pub reset: bool,
    /// Whether an erase has failed since this was last read.
    pub erase_failed: bool,
    /// Number of calls of the HAL.
    pub calls: u64,
    outputs: Outputs,
    /// Positions, thousandths of an arc-minute or mm.
    positions: [i64; AXES],
    openings_ms: [i64; VALVES],
    /// Drives that follow the outputs; the others keep the values that were set.
    follows: [bool; AXES],
    valves_follow: bool,
    units_answer: bool,
}

impl Board {
    /// At rest: stowed or deployed, valves closed, warm, the memory empty.
    pub fn new(composition: &Composition, is_deployed: bool) -> Self {
        let mut board = Self {
            follows: [true; AXES],
            valves_follow: true,
            units_answer: true,
            ..Self::default()
        };
        let deployed = if is_deployed { DEPLOYED_ARCMIN * 1_000 } else { 0 };
        board.positions = [0, 0, 60_000, deployed];
        for place in &mut board.inputs.places {
            place.temperature_dc = Some(200);
        }
        board.inputs.humidity_percent = Some(40);
        board.inputs.main_voltage_dv = 240;
        board.inputs.pressure_ua = 10_000;
        board.inputs.detector.ready = true;
        let drives = composition.drives.map(|kind| kind == DriveKind::Remote);
        let remote = drives.into_iter().chain(composition.remote_valves);
        for (unit, is_remote) in board.inputs.units.iter_mut().zip(remote) {
            unit.online = is_remote;
        }
        board.sense();
        board
    }

    /// Advances time with the present outputs.
    pub fn advance(&mut self, dt_ms: u32) {
        let dt_ms = i64::from(dt_ms);
        for (axis, output) in Axis::ALL.into_iter().zip(self.outputs.drives) {
            let per_tenth = if axis == Axis::Nozzle { 100 } else { 6_000 };
            let position = &mut self.positions[axis as usize];
            *position += i64::from(output.speed_tenths) * per_tenth * dt_ms / 1_000;
            let (low, high) = stops(axis);
            *position = (*position).clamp(low * 1_000, high * 1_000);
        }
        for (opening, output) in self.openings_ms.iter_mut().zip(self.outputs.valves) {
            let way = match output {
                ValveOutput::Off => 0,
                ValveOutput::Opening => dt_ms,
                ValveOutput::Closing => -dt_ms,
            };
            *opening = (*opening + way).clamp(0, VALVE_MS);
        }
        if self.units_answer {
            for (unit, op) in self.inputs.units.iter_mut().zip(self.outputs.units) {
                let result = |write: Option<i32>| Ok(write.unwrap_or(30));
                unit.reply = op.map(|op| UnitReply { seq: op.seq, result: result(op.write) });
            }
        }
        self.sense();
    }

    fn sense(&mut self) {
        for axis in Axis::ALL.into_iter().filter(|axis| self.follows[*axis as usize]) {
            let position = (self.positions[axis as usize] + 500).div_euclid(1_000);
            let speed = self.outputs.drives[axis as usize].speed_tenths;
            let input = &mut self.inputs.drives[axis as usize];
            (input.position, input.speed_tenths) = (position as i32, speed);
            input.current_da = if speed == 0 { 0 } else { 20 };
            let ends = if axis == Axis::Deployer { (0, DEPLOYED_ARCMIN) } else { stops(axis) };
            (input.min_switch, input.max_switch) = (position <= ends.0, position >= ends.1);
        }
        if self.valves_follow {
            for (input, opening) in self.inputs.valves.iter_mut().zip(self.openings_ms) {
                (input.open_switch, input.close_switch) = (opening >= VALVE_MS, opening == 0);
            }
        }
    }

    /// Sets inputs, possibly to absurd values, or lets a part follow the outputs again.
    pub fn disturb(&mut self, feed: &mut Feed<'_>) {
        let inputs = &mut self.inputs;
        match feed.u8() % 24 {
            0..=3 => self.disturb_drive(feed),
            4 | 5 => self.disturb_valve(feed),
            6 => inputs.places[feed.below(PLACES)].temperature_dc = number(feed).ok(),
            7 => inputs.places[feed.below(PLACES)].heater_fault = feed.chance(),
            8 => inputs.humidity_percent = Some(feed.u8()).filter(|percent| percent % 2 == 0),
            9 => inputs.main_voltage_dv = feed.u16(),
            10 => inputs.pressure_ua = feed.u16(),
            11 => inputs.flow_lps = feed.u16(),
            12 => inputs.detector.ready = feed.chance(),
            13 => inputs.detector.dirty_lens = feed.chance(),
            14 => inputs.detector.spots[feed.below(SPOTS)] = None,
            15 | 16 => inputs.detector.spots[feed.below(SPOTS)] = Some(spot(feed)),
            17 => {
                let unit = &mut inputs.units[feed.below(UNITS)];
                (unit.online, unit.protocol_fault) = (feed.chance(), feed.chance());
                unit.watchdog_reset = feed.chance();
            }
            18 => {
                self.units_answer = false;
                inputs.units[feed.below(UNITS)].reply = reply(feed);
            }
            19 => self.units_answer = true,
            20 => self.follows = [true; AXES],
            21 => self.valves_follow = true,
            _ => {
                const STATES: [ButtonState; 4] = [
                    ButtonState::Released,
                    ButtonState::Pressed,
                    ButtonState::Short,
                    ButtonState::Open,
                ];
                inputs.buttons[feed.below(2)][feed.below(8)] = STATES[feed.below(4)];
            }
        }
        self.sense();
    }

    fn disturb_drive(&mut self, feed: &mut Feed<'_>) {
        let index = feed.below(AXES);
        self.follows[index] = false;
        let drive = &mut self.inputs.drives[index];
        match feed.u8() % 10 {
            0 | 1 => drive.position = feed.number(),
            2 => drive.speed_tenths = feed.u16() as i16,
            3 => drive.current_da = feed.u16(),
            4 => drive.min_switch = feed.chance(),
            5 => drive.max_switch = feed.chance(),
            6 => drive.motor_open = feed.chance(),
            7 => drive.position_sensor_fault = feed.chance(),
            8 => drive.speed_sensor_fault = feed.chance(),
            // The drive is put at a position, and moves on from there.
            _ => {
                self.follows[index] = true;
                self.positions[index] = i64::from(feed.number()) * 1_000;
            }
        }
    }

    fn disturb_valve(&mut self, feed: &mut Feed<'_>) {
        self.valves_follow = false;
        let valve = &mut self.inputs.valves[feed.below(VALVES)];
        match feed.u8() % 6 {
            0 => valve.open_switch = feed.chance(),
            1 => valve.close_switch = feed.chance(),
            2 => valve.open_sensor_fault = feed.chance(),
            3 => valve.close_sensor_fault = feed.chance(),
            4 => valve.current_da = feed.u16(),
            _ => valve.blocked = feed.chance(),
        }
    }

    /// Changes stored contents, or makes the memory unreadable or unwritable.
    pub fn disturb_memory(&mut self, feed: &mut Feed<'_>) {
        let key = 1 + feed.u16() % 40;
        match feed.u8() % 6 {
            0 => self.load_fails = feed.chance(),
            1 => self.store_fails = feed.chance(),
            2 => self.erase_fails = feed.chance(),
            3 => _ = self.memory.remove(&key),
            4 => {
                let len = feed.below(48);
                self.memory.insert(key, feed.take(len).to_vec());
            }
            _ => {
                let (at, bit) = (feed.u8(), feed.below(8));
                if let Some(value) = self.memory.get_mut(&key)
                    && let Some(byte) = value.get_mut(usize::from(at))
                {
                    *byte ^= 1 << bit;
                }
            }
        }
    }
}

/// Mechanical stops, ' or mm.
const fn stops(axis: Axis) -> (i64, i64) {
    match axis {
        Axis::Vertical => (-5_400, 5_400),
        Axis::Horizontal => (-22_000, 22_000),
        Axis::Nozzle => (-10, 120),
        Axis::Deployer => (-20, DEPLOYED_ARCMIN + 20),
    }
}

fn number(feed: &mut Feed<'_>) -> Result<i16, core::num::TryFromIntError> {
    feed.number().try_into()
}

fn spot(feed: &mut Feed<'_>) -> Spot {
    let mut edge = || feed.u16() as i16;
    let (left, right, bottom, top) = (edge(), edge(), edge(), edge());
    Spot { left, right, bottom, top, brightness: feed.number() }
}

fn reply(feed: &mut Feed<'_>) -> Option<UnitReply> {
    let result = match feed.u8() % 8 {
        0 => Err(UnitError::Incomplete),
        1 => Err(UnitError::BadId),
        2 => Err(UnitError::BadValue),
        3 => Err(UnitError::Internal),
        4 => return None,
        _ => Ok(feed.number()),
    };
    Some(UnitReply { seq: feed.u8(), result })
}

impl Storage for Board {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        self.calls += 1;
        if self.load_fails {
            return Err(StorageError::Read);
        }
        let Some(value) = self.memory.get(&key.0) else { return Ok(None) };
        let space = buffer.get_mut(..value.len()).ok_or(StorageError::Read)?;
        space.copy_from_slice(value);
        Ok(Some(space))
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        self.calls += 1;
        if self.store_fails {
            return Err(StorageError::Write);
        }
        self.memory.insert(key.0, value.to_vec());
        Ok(())
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.calls += 1;
        if self.erase_fails {
            self.erase_failed = true;
            return Err(StorageError::Write);
        }
        self.memory.clear();
        Ok(())
    }
}

impl Hal for Board {
    fn read(&mut self, inputs: &mut Inputs) {
        self.calls += 1;
        self.sampled.clone_from(&self.inputs);
        inputs.clone_from(&self.inputs);
    }

    fn write(&mut self, outputs: &Passed) {
        self.calls += 1;
        self.written.push(**outputs);
        self.outputs = **outputs;
    }

    fn reset(&mut self) {
        self.calls += 1;
        self.reset = true;
    }
}
