//! Takes the barrel to a direction and tells when it is there: for Control and Detector.

use crate::cause::{Cause, Program};
use crate::image::{AXES, Axis};
use crate::subsystem::drive::Drive;
use crate::subsystem::{by_axis, of_axis};
use crate::time::{Millis, Timer};

/// How near is there, arc-minutes: a drive stops within 1', and rolls on a little.
const TOLERANCE_ARCMIN: i32 = 3;
/// A drive that comes no nearer for this long will not arrive. An overload clears in 3 s (§3.3.4)
/// and is tried again.
const PATIENCE_MS: u32 = 10_000;
/// What counts as nearer, arc-minutes.
const NEARER_ARCMIN: i32 = 2;

/// The drives that aim.
pub(crate) const AIMING: [Axis; 3] = [Axis::Vertical, Axis::Horizontal, Axis::Nozzle];

/// Those that point the barrel.
pub(crate) const POINTING: [Axis; 2] = [Axis::Vertical, Axis::Horizontal];

/// The programs that aim; one at most runs.
const AIM: [Program; 4] = [Program::Quench, Program::Trajectory, Program::Seek, Program::Justify];

/// A direction of the barrel, arc-minutes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Direction {
    pub horizontal: i32,
    pub vertical: i32,
}

impl Direction {
    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            horizontal: self.horizontal.saturating_add(other.horizontal),
            vertical: self.vertical.saturating_add(other.vertical),
        }
    }

    pub(crate) fn minus(self, other: Self) -> Self {
        Self {
            horizontal: self.horizontal.saturating_sub(other.horizontal),
            vertical: self.vertical.saturating_sub(other.vertical),
        }
    }
}

/// How far an approach has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    Going,
    There,
    /// It does not arrive, and no drive says why.
    Stuck,
}

/// The way to a direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Approach {
    target: Option<Direction>,
    nearest: i32,
    patience: Timer,
}

impl Approach {
    /// Goes on towards a direction, brought inside the limits; the drive with the longer way runs
    /// at the given speed and the other in proportion, so that the jet draws a straight line.
    pub(crate) fn step(
        &mut self,
        now: Millis,
        drives: &mut [Drive; AXES],
        wanted: Direction,
        speed_tenths: Option<i32>,
        cause: Cause,
    ) -> Progress {
        let target = clamp(drives, wanted);
        let anew = self.target != Some(target);
        if anew {
            *self = Self { target: Some(target), nearest: i32::MAX, patience: Timer::default() };
            self.patience.start(now, PATIENCE_MS);
        }
        let rest = target.minus(direction(drives));
        let ways = [(Axis::Horizontal, rest.horizontal), (Axis::Vertical, rest.vertical)];
        let longest = ways.iter().map(|(_, way)| way.saturating_abs()).max().unwrap_or(0);
        if ways.iter().all(|(_, way)| way.saturating_abs() <= TOLERANCE_ARCMIN) {
            self.patience.stop();
            if anew {
                // One that only passes here on the way to another goal must not go on to it.
                stop(drives, &AIM, cause);
            }
            return Progress::There;
        }
        for (axis, way) in ways {
            let drive = by_axis(drives, axis);
            let near = way.saturating_abs() <= TOLERANCE_ARCMIN;
            if (anew || drive.is_idle()) && !near && !drive.refuses(way > 0) {
                let speed = speed_tenths.map(|speed| in_proportion(speed, way, longest));
                drive.go(drive.position().saturating_add(way), speed, cause);
            } else if anew && matches!(drive.mover(), Some(Cause::Program(..))) {
                drive.stop(cause);
            }
        }
        self.watch(now, rest)
    }

    fn watch(&mut self, now: Millis, rest: Direction) -> Progress {
        let far = rest.horizontal.saturating_abs().saturating_add(rest.vertical.saturating_abs());
        if far <= self.nearest.saturating_sub(NEARER_ARCMIN) || !self.patience.is_running() {
            self.nearest = far;
            self.patience.start(now, PATIENCE_MS);
        }
        if self.patience.poll(now) { Progress::Stuck } else { Progress::Going }
    }
}

/// Whether these drives can be taken to a position. A direct drive does not count its way while its
/// limits are off (§3.17), so a program would run it on and on.
pub(crate) fn can_aim(drives: &[Drive; AXES], axes: &[Axis]) -> bool {
    axes.iter().all(|axis| {
        let drive = of_axis(drives, *axis);
        drive.limits().is_some() || drive.is_remote()
    })
}

/// Whether one of these drives is faulty.
pub(crate) fn is_faulty(drives: &[Drive; AXES], axes: &[Axis]) -> bool {
    axes.iter().any(|axis| of_axis(drives, *axis).is_faulty())
}

/// Stops what these programs move; what an operator moves goes on.
pub(crate) fn stop(drives: &mut [Drive; AXES], programs: &[Program], why: Cause) {
    for drive in drives {
        if drive.mover().is_some_and(|cause| cause.is_of(programs)) {
            drive.stop(why);
        }
    }
}

/// Where the barrel points.
pub(crate) fn direction(drives: &[Drive; AXES]) -> Direction {
    Direction {
        horizontal: of_axis(drives, Axis::Horizontal).position(),
        vertical: of_axis(drives, Axis::Vertical).position(),
    }
}

/// A direction brought inside the limits.
pub(crate) fn clamp(drives: &[Drive; AXES], wanted: Direction) -> Direction {
    Direction {
        horizontal: of_axis(drives, Axis::Horizontal).clamp(wanted.horizontal),
        vertical: of_axis(drives, Axis::Vertical).clamp(wanted.vertical),
    }
}

fn in_proportion(speed: i32, way: i32, longest: i32) -> i32 {
    /// Beyond 24 turns, and 400 °/s, proportions need not be kept: the product has room in 32 bits.
    const WAY_MAX: i32 = (1 << 19) - 1;
    let part = speed.min(4096) * way.saturating_abs().min(WAY_MAX) / longest.clamp(1, WAY_MAX);
    part.min(speed).max(1)
}
