//! §3.3.4 The faults of a drive that only show by watching: sensors connected the wrong way round or
//! dead, a drive that does not turn.

use crate::image::DriveInput;
use lafet_proto::flags::DriveFlags;

/// A motor needs time to come up to its speed: its motion is not judged before.
const START_MS: u32 = 250;
/// Time over which motion is judged. What breaks late in one stretch shows at the end of the next,
/// so a fault is told within a second of motion.
const WATCH_MS: u32 = 400;
/// Way over which motion is judged at least: a quarter of it is a whole count of the position. A
/// slow drive takes longer for it.
const WATCH_MILLI: i32 = 4000;
/// A longer step says too little of what happened in it.
const WATCH_STEP_MS: u32 = 250;
/// Speed below which motion is not judged, 0.1 °/s or 0.1 mm/s.
const WATCH_SPEED_TENTHS: i16 = 5;

/// What has been seen of a motion since the watch began.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Watch {
    /// Direction of the commanded speed, 0 while there is nothing to judge.
    way: i16,
    running_ms: u32,
    elapsed_ms: u32,
    start: i32,
    /// Commanded way, milli-units of position.
    expected: i32,
    /// Way by the speed sensor, milli-units of position.
    measured: i32,
}

impl Watch {
    /// Judges after a while whether the drive did what it was told. `way_per_tenth` is the way, in
    /// tenths of a milli-unit of position, that a speed of one tenth makes in a millisecond.
    #[inline(never)]
    pub fn step(
        &mut self,
        dt_ms: u32,
        speed_tenths: i16,
        way_per_tenth: i32,
        input: &DriveInput,
    ) -> DriveFlags {
        let judged = speed_tenths.abs() >= WATCH_SPEED_TENTHS && dt_ms <= WATCH_STEP_MS;
        let direction = if judged { speed_tenths.signum() } else { 0 };
        if direction != self.way {
            *self = Self { way: direction, ..Self::default() };
        }
        self.running_ms = self.running_ms.saturating_add(dt_ms);
        if self.way == 0 || self.running_ms <= START_MS {
            self.start = input.position;
            return DriveFlags::empty();
        }
        // A step that is judged is short: 32,767 tenths over 250 ms have room in 32 bits.
        let way = |tenths: i16| i32::from(tenths) * way_per_tenth * dt_ms.cast_signed() / 10;
        self.elapsed_ms = self.elapsed_ms.saturating_add(dt_ms);
        self.expected = self.expected.saturating_add(way(speed_tenths));
        self.measured = self.measured.saturating_add(way(input.speed_tenths));
        if self.elapsed_ms < WATCH_MS || self.expected.abs() < WATCH_MILLI {
            return DriveFlags::empty();
        }
        let Self { expected, measured, start, .. } = *self;
        *self = Self { start: input.position, elapsed_ms: 0, expected: 0, measured: 0, ..*self };
        if input.min_switch || input.max_switch {
            return DriveFlags::empty();
        }
        let moved = input.position.saturating_sub(start).saturating_mul(1000);
        let sign = expected.signum();
        let of = |way: i32| way.saturating_mul(sign);
        let (went, sensed, part) = (of(moved), of(measured), expected.abs() / 4);
        // What turned round within this stretch has measured next to nothing in sum.
        let now = i32::from(input.speed_tenths) * sign;
        let turned = now < -i32::from(speed_tenths.abs()) / 4;
        match () {
            () if went < -part => DriveFlags::POSITION_WAY_FAULT,
            () if went < part && sensed > part => DriveFlags::POS_ENCODER_FAULT,
            () if went < part => DriveFlags::INTERNAL_FAULT,
            () if sensed < -part || sensed < part && turned => DriveFlags::SPEED_WAY_FAULT,
            () if sensed < part => DriveFlags::SPEED_ENCODER_FAULT,
            () => DriveFlags::empty(),
        }
    }
}
