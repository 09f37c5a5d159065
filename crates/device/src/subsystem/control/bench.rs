//! A bench for the tests of Control and Detector: real drives on motors that obey.

use crate::cause::Asked;
use crate::composition::Composition;
use crate::hal::{Key, Storage, StorageError};
use crate::image::{AXES, Axis, DetectorInput, Inputs, Spot, UnitInput};
use crate::params::Params;
use crate::subsystem::conn::Source;
use crate::subsystem::drive::Drive;
use crate::subsystem::{Env, by_axis, of_axis};
use crate::time::Millis;
use lafet_proto::{RequestId, SubsystemId};
use std::collections::BTreeMap;
use std::vec::Vec;

/// A cycle, ms.
pub(crate) const CYCLE_MS: u32 = 10;

/// Who asks.
pub(crate) const BY: Asked =
    Asked { request: RequestId::START_QUENCH, to: SubsystemId::CONTROL, source: Source::Radio };

#[derive(Default)]
struct Memory(BTreeMap<Key, Vec<u8>>);

impl Storage for Memory {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        Ok(self.0.get(&key).map(|value| {
            buffer[..value.len()].copy_from_slice(value);
            &buffer[..value.len()]
        }))
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        self.0.insert(key, value.to_vec());
        Ok(())
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.0.clear();
        Ok(())
    }
}

/// The parameters of a new monitor.
pub(crate) fn params() -> Params {
    let mut memory = Memory::default();
    Params::provision(&mut memory, &Composition::FULL, 1).unwrap();
    Params::load(&mut memory)
}

/// The parameters of a monitor whose stored correction table has been damaged.
pub(crate) fn damaged_params() -> Params {
    let mut memory = Memory::default();
    Params::provision(&mut memory, &Composition::FULL, 1).unwrap();
    let before: Vec<Key> = memory.0.keys().copied().collect();
    let mut params = Params::load(&mut memory);
    params.set_corrections(0, lafet_proto::Bytes(&[1, 2]));
    params.flush(crate::time::Millis(0), &mut memory);
    for (key, value) in &mut memory.0 {
        if !before.contains(key) {
            value[0] ^= 1;
        }
    }
    Params::load(&mut memory)
}

/// Drives, motors, water and fires.
pub(crate) struct Bench {
    pub now: Millis,
    pub params: Params,
    pub drives: [Drive; AXES],
    pub inputs: Inputs,
    pub deployed: bool,
    pub deploy_failed: bool,
    pub pressure_datm: Option<u16>,
    /// Motors that do not turn.
    pub jammed: [bool; AXES],
    /// Fires: horizontal and vertical middle, half size, brightness.
    pub fires: Vec<(i32, i32, i32, i32)>,
    /// Axis of the detector minus that of the barrel: left, up.
    pub misalignment: (i32, i32),
    milli: [i64; AXES],
}

impl Bench {
    /// A monitor at work, its nozzle narrow, near the wrap of the clock.
    pub(crate) fn new() -> Self {
        let mut params = params();
        params.write(lafet_proto::param::Param::ControlBallistics, one(&1));
        let mut inputs = Inputs::default();
        inputs.detector.ready = true;
        let mut bench = Self {
            now: Millis(u32::MAX - 5000),
            drives: Axis::ALL.map(|axis| {
                let mut drive = Drive::new(axis);
                drive.power_up(
                    &params,
                    *of_axis(&inputs.drives, axis),
                    &UnitInput::default(),
                    true,
                );
                drive
            }),
            params,
            inputs,
            deployed: true,
            deploy_failed: false,
            pressure_datm: Some(79),
            jammed: [false; AXES],
            fires: Vec::new(),
            misalignment: (0, 0),
            milli: [0, 0, 60_000, 5_400_000],
        };
        bench.turn(0);
        bench
    }

    pub(crate) fn env(&mut self) -> Env<'_> {
        Env {
            inputs: &self.inputs,
            params: &mut self.params,
            drives: &mut self.drives,
            deployed: self.deployed,
            deploy_failed: self.deploy_failed,
            dt_ms: 10,
            pressure_datm: self.pressure_datm,
        }
    }

    /// Position of a drive.
    pub(crate) fn at(&self, axis: Axis) -> i32 {
        of_axis(&self.drives, axis).position()
    }

    /// Horizontal and vertical position.
    pub(crate) fn aim(&self) -> (i32, i32) {
        (self.at(Axis::Horizontal), self.at(Axis::Vertical))
    }

    /// A request moves a drive.
    pub(crate) fn move_to(&mut self, axis: Axis, destination: i32) {
        let status = by_axis(&mut self.drives, axis).move_to(self.now, destination, 0, BY);
        assert!(status.is_success(), "{status:?}");
    }

    /// One cycle of everything but the subsystem under test.
    pub(crate) fn cycle(&mut self) {
        self.now = Millis(self.now.0.wrapping_add(CYCLE_MS));
        self.turn(CYCLE_MS);
        self.look();
    }

    fn turn(&mut self, dt_ms: u32) {
        let motors = self.milli.iter_mut().zip(Axis::ALL).zip(self.jammed);
        for ((milli, axis), jammed) in motors {
            let drive = by_axis(&mut self.drives, axis);
            let tenths = i64::from(drive.output().speed_tenths) * i64::from(!jammed);
            // 0.1 °/s is 6 thousandths of an arc-minute in a millisecond, 0.1 mm/s a tenth of one.
            let per_ten_ms = if axis == Axis::Nozzle { 1 } else { 60 };
            *milli += tenths * per_ten_ms * i64::from(dt_ms) / 10;
            let input = by_axis(&mut self.inputs.drives, axis);
            input.position = milli.div_euclid(1000) as i32;
            input.speed_tenths = tenths as i16;
            drive.step(self.now, dt_ms, input, &UnitInput::default(), &self.params);
        }
    }

    fn look(&mut self) {
        let (horizontal, vertical) = self.aim();
        let DetectorInput { ready, dirty_lens, .. } = self.inputs.detector;
        let mut seen: Vec<Spot> = self
            .fires
            .iter()
            .filter_map(|(h, v, half, brightness)| {
                let left = h - horizontal - self.misalignment.0;
                let up = v - vertical - self.misalignment.1;
                let visible = self.deployed && left.abs() <= 450 && up.abs() <= 450;
                visible.then_some(Spot {
                    left: (left + half) as i16,
                    right: (left - half) as i16,
                    bottom: (up - half) as i16,
                    top: (up + half) as i16,
                    brightness: *brightness,
                })
            })
            .collect();
        seen.sort_by_key(|spot| core::cmp::Reverse(spot.brightness));
        let mut spots = [None; crate::image::SPOTS];
        for (place, spot) in spots.iter_mut().zip(seen) {
            *place = Some(spot);
        }
        self.inputs.detector = DetectorInput { ready, dirty_lens, spots };
    }
}

/// One value of a parameter.
pub(crate) fn one(value: &i32) -> lafet_proto::Ints<'_> {
    lafet_proto::Ints::Values(core::slice::from_ref(value))
}
