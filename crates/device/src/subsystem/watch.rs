//! §3.3.4 The faults of a drive that only show by watching: sensors connected the wrong way round or
//! dead, a drive that does not turn, and one that turns though it is not fed, or much faster than it is: a
//! shorted transistor, a welded relay; and a position that jumps.

use crate::image::DriveInput;
use lafet_proto::flags::DriveFlags;

/// A motor needs time to come up to its speed: its motion is not judged before.
const START_MS: u32 = 250;
/// Time over which motion is judged. What breaks late in one stretch shows at the end of the next,
/// so a fault is reported within a second of motion.
const WATCH_MS: u32 = 400;
/// Way over which motion is judged at least, milli-units of position: three quarters of it may be play
/// of the gear, and what is left is a whole count. A slow drive takes longer for it.
const WATCH_MILLI: i32 = 18_000;
const WATCH_MILLI_NOZZLE: i32 = 4000;
/// A fast drive is judged after this way already, milli-units of position: 4 ° or 15 mm. What breaks shows
/// at the end of the next stretch at the latest, so within 10 ° or 50 mm.
const WATCH_FAR_MILLI: i32 = 240_000;
const WATCH_FAR_MILLI_NOZZLE: i32 = 15_000;
/// The barrel may be so far behind its motor, milli-units of position.
const PLAY_MILLI: i32 = 16_000;
const PLAY_MILLI_NOZZLE: i32 = 2500;
/// A longer step says too little of what happened in it.
const WATCH_STEP_MS: u32 = 250;
/// Speed below which motion is not judged, 0.1 °/s or 0.1 mm/s.
const WATCH_SPEED_TENTHS: i16 = 5;
/// Position and speed sensor may differ by this over a stretch, besides three-fold; milli-units of position
/// for each unit of `way_per_tenth`: 1 ° or 1 mm.
const APART_MILLI: i32 = 1000;
/// In a step of this length a position that moves by [`COAST_MILLI`] has jumped.
const JUMP_STEP_MS: u32 = 30;
/// A drive that is not fed any more may run out for this long …
const COAST_MS: u32 = 300;
/// … and so far, milli-units of position for each unit of `way_per_tenth`: 5 ° or 5 mm.
const COAST_MILLI: i32 = 5000;
/// Then a stretch of this length in which it turns, and another in which it has not slowed down, are a
/// runaway: it is found within 10 °, however fast it is.
const REST_MS: u32 = 120;
/// Way in a stretch that counts as turning, as above: 3' or 0.05 mm, thus 0.4 °/s or 0.4 mm/s.
const REST_MILLI: i32 = 50;
/// One that is slower than that creeps: it is found after the way of a drive that runs out. More than this part of that
/// way in one step is a position that has jumped, and no way.
const CREEP_PART: i32 = 2;
/// A drive that is fed may be faster than commanded by a quarter and this speed, 0.1 °/s or 0.1 mm/s
/// (weight helps it down), and may be late by the time that it may run out …
const OVER_TENTHS: i32 = 10;
/// … and by this way, as above, or a count.
const OVER_MILLI: i32 = 500;
const COUNT_MILLI: i32 = 1000;
/// What a speed sensor may say of a drive that does not turn, 0.1 °/s or 0.1 mm/s.
const REST_TENTHS: i16 = 1;

/// What has been seen of a drive since the watch began: of a motion, or of a rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Watch {
    /// Direction of the commanded speed, 0 at rest.
    way: i16,
    /// The greatest commanded speed, without its sign.
    peak: u16,
    /// It turns as it is not commanded: though it is not fed, or much faster than it is.
    away: bool,
    running_ms: u32,
    elapsed_ms: u32,
    start: i32,
    /// Position in the step before.
    last: i32,
    /// Of a motion the commanded way, at rest the way in the stretch before; milli-units of position.
    expected: i32,
    /// Way by the speed sensor, milli-units of position.
    measured: i32,
    /// Way of a rest, position units.
    crept: i32,
    /// In the stretch of a rest before, its position has jumped.
    jumped: bool,
}

impl Watch {
    /// Begins the stretch again: what went before is no measure of the command now.
    #[inline(never)]
    pub const fn again(&mut self, position: i32) {
        (self.start, self.last) = (position, position);
        (self.elapsed_ms, self.expected, self.measured) = (0, 0, 0);
        self.jumped = false;
    }

    /// Its power stage does not obey: it turns though it is not fed, or both sensors say that it is much faster than
    /// commanded.
    pub const fn is_away(&self) -> bool {
        self.away
    }

    /// Judges after a while whether the drive did what it was driven to. `way_per_tenth` is the way, in
    /// tenths of a milli-unit of position, that a speed of one tenth makes in a millisecond.
    #[inline(never)]
    pub fn step(
        &mut self,
        dt_ms: u32,
        speed_tenths: i16,
        way_per_tenth: i32,
        input: &DriveInput,
    ) -> DriveFlags {
        let crawls = speed_tenths != 0 && speed_tenths.abs() < WATCH_SPEED_TENTHS;
        if crawls || dt_ms > WATCH_STEP_MS {
            // A long step says nothing; but what has come to rest, and is where it was, goes on resting.
            let settled = self.way == 0 && self.running_ms > COAST_MS && self.elapsed_ms == 0;
            if crawls || speed_tenths != 0 || !settled || input.position != self.start {
                *self = Self::default();
            }
            return DriveFlags::empty();
        }
        if speed_tenths.signum() != self.way || self.running_ms == 0 {
            let way = speed_tenths.signum();
            *self = Self { way, start: input.position, last: input.position, ..Self::default() };
        }
        if self.way == 0 {
            return self.rest(dt_ms, way_per_tenth, input);
        }
        let step =
            input.position.saturating_sub(core::mem::replace(&mut self.last, input.position));
        if dt_ms <= JUMP_STEP_MS
            && step.saturating_mul(1000).saturating_abs() >= COAST_MILLI * way_per_tenth
        {
            return DriveFlags::POS_ENCODER_FAULT;
        }
        self.running_ms = self.running_ms.saturating_add(dt_ms);
        if self.running_ms <= START_MS {
            self.start = input.position;
            return DriveFlags::empty();
        }
        // A step that is judged is short: 32,767 tenths over 250 ms have room in 32 bits.
        let way = |tenths: i16| i32::from(tenths) * way_per_tenth * dt_ms.cast_signed() / 10;
        self.elapsed_ms = self.elapsed_ms.saturating_add(dt_ms);
        self.expected = self.expected.saturating_add(way(speed_tenths));
        self.measured = self.measured.saturating_add(way(input.speed_tenths));
        let (least, far, play) = match way_per_tenth {
            1 => (WATCH_MILLI_NOZZLE, WATCH_FAR_MILLI_NOZZLE, PLAY_MILLI_NOZZLE),
            _ => (WATCH_MILLI, WATCH_FAR_MILLI, PLAY_MILLI),
        };
        if self.overruns(speed_tenths, way_per_tenth, input) {
            self.away = true;
            return DriveFlags::INTERNAL_FAULT;
        }
        let way = self.expected.abs();
        if way < least || self.elapsed_ms < WATCH_MS && way < far {
            return DriveFlags::empty();
        }
        let Self { expected, measured, start, .. } = *self;
        *self = Self { start: input.position, elapsed_ms: 0, expected: 0, measured: 0, ..*self };
        let moved = input.position.saturating_sub(start).saturating_mul(1000);
        let sign = expected.signum();
        let of = |way: i32| way.saturating_mul(sign);
        let (went, sensed, part) = (of(moved), of(measured), expected.abs() / 4);
        // What turned round within this stretch has measured next to nothing in sum.
        let now = i32::from(input.speed_tenths) * sign;
        let turned = now < -i32::from(speed_tenths.abs()) / 4;
        let slack = APART_MILLI * way_per_tenth;
        let far_more = |one: i32, other: i32| one > other.saturating_mul(3).saturating_add(slack);
        let disagree = far_more(went, sensed) || far_more(sensed, went);
        let off = |way: i32| way.abs_diff(expected.saturating_abs());
        match () {
            () if went < -part => DriveFlags::POSITION_WAY_FAULT,
            () if went < part && sensed > part && sensed <= went.saturating_add(play) => {
                DriveFlags::empty()
            }
            () if went < part && sensed > part => DriveFlags::POS_ENCODER_FAULT,
            () if went < part => DriveFlags::INTERNAL_FAULT,
            () if sensed < -part || sensed < part && turned => DriveFlags::SPEED_WAY_FAULT,
            () if sensed < part => DriveFlags::SPEED_ENCODER_FAULT,
            // One counts several times what the other does: that which is farther from the command.
            () if disagree && off(went) > off(sensed) => DriveFlags::POS_ENCODER_FAULT,
            () if disagree => DriveFlags::SPEED_ENCODER_FAULT,
            () => DriveFlags::empty(),
        }
    }

    /// In this stretch it has gone farther than any stage that obeys lets it.
    fn overruns(&mut self, speed_tenths: i16, way_per_tenth: i32, input: &DriveInput) -> bool {
        let speed = speed_tenths.unsigned_abs();
        self.peak = self.peak.max(speed);
        let slower = i32::from(self.peak - speed);
        let elapsed_ms = self.elapsed_ms.cast_signed();
        let late = slower.saturating_mul(COAST_MS.cast_signed()) + OVER_TENTHS * elapsed_ms;
        let least = (OVER_MILLI * way_per_tenth).max(COUNT_MILLI);
        let slack = late.saturating_mul(way_per_tenth) / 10 + least;
        let allowed = self.expected.saturating_abs() / 4 * 5 + slack;
        let moved = input.position.saturating_sub(self.start).saturating_mul(1000);
        let sign = i32::from(self.way);
        moved.saturating_mul(sign) > allowed && self.measured.saturating_mul(sign) > allowed
    }

    /// It is not fed: it may run out, and has to stay where it is then.
    fn rest(&mut self, dt_ms: u32, way_per_tenth: i32, input: &DriveInput) -> DriveFlags {
        let noise = input.speed_tenths.saturating_abs() <= REST_TENTHS;
        let tenths = if noise { 0 } else { i32::from(input.speed_tenths) };
        let sensed = tenths * way_per_tenth * dt_ms.cast_signed() / 10;
        self.measured = self.measured.saturating_add(sensed);
        let moved = input.position.saturating_sub(self.start).saturating_mul(1000);
        if self.running_ms <= COAST_MS {
            let gone = moved.saturating_abs().min(self.measured.saturating_abs());
            // At least a millisecond, so that the rest has started; no more than it takes, so that the
            // watch itself comes to rest.
            self.running_ms = (self.running_ms + dt_ms.max(1)).min(COAST_MS + 1);
            if self.running_ms > COAST_MS {
                (self.start, self.last, self.measured) = (input.position, input.position, 0);
            }
            self.away = gone >= COAST_MILLI * way_per_tenth;
            return if self.away { DriveFlags::INTERNAL_FAULT } else { DriveFlags::empty() };
        }
        let step =
            input.position.saturating_sub(core::mem::replace(&mut self.last, input.position));
        let far = |way: i32, part: i32| {
            way.saturating_mul(1000).saturating_abs() >= COAST_MILLI * way_per_tenth / part
        };
        self.crept = self.crept.saturating_add(if far(step, CREEP_PART) { 0 } else { step });
        if far(self.crept, 1) {
            self.away = true;
            return if sensed == 0 {
                DriveFlags::POS_ENCODER_FAULT
            } else {
                DriveFlags::INTERNAL_FAULT
            };
        }
        if self.elapsed_ms == 0 && moved == 0 && sensed == 0 && !self.jumped {
            (self.expected, self.measured) = (0, 0);
            return DriveFlags::empty();
        }
        self.elapsed_ms += dt_ms;
        if self.elapsed_ms < REST_MS {
            return DriveFlags::empty();
        }
        let (before, measured, least) = (self.expected, self.measured, REST_MILLI * way_per_tenth);
        let (far, fast) = (moved.saturating_abs(), measured.saturating_abs());
        // Sensors that differ by a count agree.
        let far = if far.abs_diff(fast) <= 1000 { fast } else { far };
        // The speed is finer than the position, whose counts come and go.
        let turned = if fast >= least { measured } else { moved };
        let expected = if far.max(fast) >= least { turned } else { 0 };
        // One that runs out slows down.
        let away = expected != 0
            && expected.signum() == before.signum()
            && expected.saturating_abs() >= before.saturating_abs() / 8 * 7;
        // So far in one stretch, and the speed does not show it. One that is back in the next was a blip.
        let jumps = fast < least && far >= COAST_MILLI * way_per_tenth;
        let (stays, jumped) = (self.jumped && !jumps, jumps && !self.jumped);
        let start = input.position;
        *self = Self { start, elapsed_ms: 0, expected, measured: 0, away, jumped, ..*self };
        match (far >= least, fast >= least) {
            _ if stays => DriveFlags::POS_ENCODER_FAULT,
            (true, false) if away => DriveFlags::POS_ENCODER_FAULT,
            _ if !away => DriveFlags::empty(),
            (true, _) => DriveFlags::INTERNAL_FAULT,
            (false, _) => DriveFlags::SPEED_ENCODER_FAULT,
        }
    }
}
