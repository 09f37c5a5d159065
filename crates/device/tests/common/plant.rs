//! Drives follow the commanded speed, valves travel, switches close at the ends, memory is a map.

use lafet_device::Composition;
use lafet_device::composition::DriveKind;
use lafet_device::guard::Passed;
use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::{
    AXES, Axis, DriveOutput, Inputs, Outputs, UNITS, UnitError, UnitReply, VALVES, ValveOutput,
};
use std::collections::BTreeMap;

/// A drive.
#[derive(Clone, Debug)]
pub struct DrivePlant {
    /// True position, thousandths of ' or mm.
    pub position_milli: i64,
    /// Mechanical stops, ' or mm.
    pub stops: (i64, i64),
    /// End switches close at and beyond these.
    pub switches: (i64, i64),
    /// The motor is fed, nothing turns, no current shows.
    pub jammed: bool,
    /// It turns at this speed, fed or not, until its supply is cut; 0.1 °/s or 0.1 mm/s.
    pub runaway_tenths: i16,
    /// The position sensor has not changed since this reading.
    pub encoder_stuck: Option<i32>,
    pub encoder_reversed: bool,
    pub speed_dead: bool,
    pub speed_reversed: bool,
    /// Current while it turns, 0.1 A.
    pub current_da: u16,
    /// Current while it is not fed, 0.1 A: its stage is shorted, and it is at an end stop.
    pub stall_da: u16,
    /// How far the sensor's zero lies above the true zero.
    pub encoder_offset: i32,
}

/// A valve.
#[derive(Clone, Debug, Default)]
pub struct ValvePlant {
    /// 0 closed … 4000 open: it takes 4 s.
    pub opening_ms: i64,
    pub jammed: bool,
    pub open_switch_dead: bool,
    pub open_switch_stuck: bool,
    pub close_switch_dead: bool,
    pub current_da: u16,
}

/// A remote unit.
#[derive(Clone, Debug, Default)]
pub struct UnitPlant {
    pub remote: bool,
    pub offline: bool,
    /// Refuses accesses to parameters.
    pub error: Option<UnitError>,
    /// Does not answer accesses to parameters.
    pub silent: bool,
    pub params: BTreeMap<u16, i32>,
    /// How long the present operation has waited.
    waited_ms: u32,
    reply: Option<UnitReply>,
    /// Every write that has arrived.
    pub writes: Vec<(u16, i32)>,
}

/// A remote unit answers an access to a parameter after this time.
pub const UNIT_ANSWERS_MS: u32 = 50;

const OPEN_MS: i64 = 4000;

/// Everything the monitor senses, drives and remembers.
#[derive(Clone, Debug)]
pub struct Plant {
    pub drives: [DrivePlant; AXES],
    pub valves: [ValvePlant; VALVES],
    pub units: [UnitPlant; UNITS],
    /// What is sensed; fields that no part of the plant makes may be set by hand.
    pub inputs: Inputs,
    /// What was driven last.
    pub outputs: Outputs,
    pub memory: BTreeMap<u16, Vec<u8>>,
    /// Keys in the order in which they were written.
    pub written: Vec<u16>,
    pub load_fails: bool,
    pub store_fails: bool,
    pub erase_fails: bool,
    pub reset_requested: bool,
    pub resets: u32,
}

impl Plant {
    /// A plant at rest: wrapped, dry, warm, its memory empty.
    pub fn of(composition: &Composition) -> Self {
        let far = i64::from(i32::MAX);
        let drive = |stops, switches| DrivePlant {
            position_milli: 0,
            stops,
            switches,
            jammed: false,
            runaway_tenths: 0,
            encoder_stuck: None,
            encoder_reversed: false,
            speed_dead: false,
            speed_reversed: false,
            current_da: 20,
            stall_da: 0,
            encoder_offset: 0,
        };
        let free = drive((-far, far), (-far, far));
        let mut plant = Self {
            drives: [free.clone(), free.clone(), free, drive((-20, 5420), (0, 5400))],
            valves: Default::default(),
            units: Default::default(),
            inputs: Inputs::default(),
            outputs: Outputs::default(),
            memory: BTreeMap::new(),
            written: Vec::new(),
            load_fails: false,
            store_fails: false,
            erase_fails: false,
            reset_requested: false,
            resets: 0,
        };
        let remote_drives = composition.drives.map(|kind| kind == DriveKind::Remote);
        let remote = remote_drives.into_iter().chain(composition.remote_valves);
        for (unit, remote) in plant.units.iter_mut().zip(remote) {
            unit.remote = remote;
        }
        plant.inputs.places.iter_mut().for_each(|place| place.temperature_dc = Some(200));
        plant.inputs.humidity_percent = Some(40);
        plant.inputs.main_voltage_dv = 240;
        plant.inputs.pressure_ua = 4000;
        plant.inputs.detector.ready = true;
        plant.sense();
        plant
    }

    pub fn drive(&mut self, axis: Axis) -> &mut DrivePlant {
        &mut self.drives[axis as usize]
    }

    /// True position, ' or mm, rounded.
    pub fn position(&self, axis: Axis) -> i64 {
        (self.drives[axis as usize].position_milli + 500).div_euclid(1000)
    }

    /// Puts a drive somewhere.
    pub fn place(&mut self, axis: Axis, position: i64) {
        self.drive(axis).position_milli = position * 1000;
        self.sense();
    }

    /// Time passes with the outputs as they are.
    pub fn advance(&mut self, dt_ms: u32) {
        let dt_ms = i64::from(dt_ms);
        for ((drive, output), axis) in
            self.drives.iter_mut().zip(self.outputs.drives).zip(Axis::ALL)
        {
            if !drive.jammed {
                let per_tenth = if axis == Axis::Nozzle { 100 } else { 6000 };
                let speed_tenths = i64::from(drive.turns_tenths(output));
                drive.position_milli += speed_tenths * per_tenth * dt_ms / 1000;
                let (low, high) = drive.stops;
                drive.position_milli = drive.position_milli.clamp(low * 1000, high * 1000);
            }
        }
        for (valve, output) in self.valves.iter_mut().zip(self.outputs.valves) {
            let way = match output {
                ValveOutput::Off => 0,
                ValveOutput::Opening => dt_ms,
                ValveOutput::Closing => -dt_ms,
            };
            if !valve.jammed {
                valve.opening_ms = (valve.opening_ms + way).clamp(0, OPEN_MS);
            }
        }
        for (unit, op) in self.units.iter_mut().zip(self.outputs.units) {
            unit.advance(dt_ms as u32, op);
        }
        self.sense();
    }

    fn sense(&mut self) {
        let drives = self.drives.iter().zip(&mut self.inputs.drives).zip(self.outputs.drives);
        for ((drive, input), output) in drives {
            let position = (drive.position_milli + 500).div_euclid(1000);
            let reading = position as i32 + drive.encoder_offset;
            let reading = if drive.encoder_reversed { -reading } else { reading };
            input.position = drive.encoder_stuck.unwrap_or(reading);
            let speed = if drive.jammed { 0 } else { drive.turns_tenths(output) };
            input.speed_tenths = match (drive.speed_dead, drive.speed_reversed) {
                (true, _) => 0,
                (false, true) => -speed,
                (false, false) => speed,
            };
            let fed = output.speed_tenths != 0;
            let stalls = if output.cut { 0 } else { drive.stall_da };
            input.current_da = if fed { drive.current_da } else { stalls };
            input.min_switch = position <= drive.switches.0;
            input.max_switch = position >= drive.switches.1;
        }
        let valves = self.valves.iter().zip(&mut self.inputs.valves).zip(self.outputs.valves);
        for ((valve, input), output) in valves {
            let open = valve.opening_ms >= OPEN_MS || valve.open_switch_stuck;
            input.open_switch = open && !valve.open_switch_dead;
            input.close_switch = valve.opening_ms <= 0 && !valve.close_switch_dead;
            let fed = output != ValveOutput::Off;
            input.current_da = if fed { valve.current_da } else { 0 };
        }
        for (unit, input) in self.units.iter().zip(&mut self.inputs.units) {
            (input.online, input.reply) = (unit.remote && !unit.offline, unit.reply);
        }
    }

    /// Flips a bit of a stored value.
    pub fn damage(&mut self, key: u16) {
        self.memory
            .get_mut(&key)
            .and_then(|value| value.first_mut())
            .map(|byte| *byte ^= 1)
            .unwrap();
    }
}

impl DrivePlant {
    /// How fast it turns, 0.1 °/s or 0.1 mm/s.
    fn turns_tenths(&self, output: DriveOutput) -> i16 {
        match self.runaway_tenths {
            _ if output.cut => 0,
            0 => output.speed_tenths,
            runaway_tenths => runaway_tenths,
        }
    }
}

impl UnitPlant {
    fn advance(&mut self, dt_ms: u32, op: Option<lafet_device::image::UnitOp>) {
        let Some(op) = op.filter(|_| self.remote && !self.offline && !self.silent) else {
            self.waited_ms = 0;
            return;
        };
        if self.reply.is_some_and(|reply| reply.seq == op.seq) {
            return;
        }
        self.waited_ms += dt_ms;
        if self.waited_ms < UNIT_ANSWERS_MS {
            return;
        }
        self.waited_ms = 0;
        let result = match (self.error, op.write) {
            (Some(error), _) => Err(error),
            (None, Some(value)) => {
                self.writes.push((op.param, value));
                self.params.insert(op.param, value);
                Ok(value)
            }
            (None, None) => self.params.get(&op.param).copied().ok_or(UnitError::BadId),
        };
        self.reply = Some(UnitReply { seq: op.seq, result });
    }
}

impl Storage for Plant {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        if self.load_fails {
            return Err(StorageError::Read);
        }
        let Some(value) = self.memory.get(&key.0) else { return Ok(None) };
        let space = buffer.get_mut(..value.len()).ok_or(StorageError::Read)?;
        space.copy_from_slice(value);
        Ok(Some(space))
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        if self.store_fails {
            return Err(StorageError::Write);
        }
        self.memory.insert(key.0, value.to_vec());
        self.written.push(key.0);
        Ok(())
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        if self.erase_fails {
            return Err(StorageError::Write);
        }
        self.memory.clear();
        Ok(())
    }
}

impl Hal for Plant {
    fn read(&mut self, inputs: &mut Inputs) {
        inputs.clone_from(&self.inputs);
    }

    fn write(&mut self, outputs: &Passed) {
        self.outputs = **outputs;
    }

    fn reset(&mut self) {
        self.reset_requested = true;
        self.resets += 1;
    }
}
