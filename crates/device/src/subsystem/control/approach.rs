//! Takes the barrel to a direction and reports when it is there: for Control and Detector.

use crate::cause::{Cause, Program};
use crate::image::{AXES, Axis};
use crate::subsystem::drive::Drive;
use crate::subsystem::{by_axis, of_axis};
use crate::time::Millis;

/// How near is there, arc-minutes: a drive stops within 1', and rolls on a little.
const TOLERANCE_ARCMIN: i32 = 3;
/// A drive that comes no nearer for this long will not arrive. An overload clears in 3 s (§3.3.4)
/// and is tried again.
pub(crate) const PATIENCE_MS: u32 = 10_000;
/// What counts as nearer, arc-minutes.
const NEARER_ARCMIN: i32 = 2;
/// A way that a target may change by as it is reached, arc-minutes.
const SHORT_ARCMIN: i32 = 30;

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
    /// Horizontal, Vertical: each by itself, or one that moves would hide one that does not.
    waits: [Wait; 2],
}

/// For how long a drive has come no nearer.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wait {
    /// How near it has come, arc-minutes.
    nearest: u16,
    /// When, ms: enough of the clock to tell some seconds.
    since: u16,
}

impl Default for Wait {
    fn default() -> Self {
        Self { nearest: u16::MAX, since: 0 }
    }
}

impl Wait {
    /// A step with this way left, to a target that is new or not; true when it takes too long. A new target is
    /// no progress: a pressure that fluctuates raises and lowers it for ever. One that is near may be passed
    /// as often as it changes.
    fn step(&mut self, now: Millis, way: i32, new: bool) -> bool {
        let (way, now) = (way.saturating_abs().min(u16::MAX.into()), now.0 as u16);
        let nearest = i32::from(self.nearest);
        if way <= TOLERANCE_ARCMIN || new && way <= SHORT_ARCMIN {
            *self = Self { since: now, ..Self::default() };
        } else if new || way <= nearest.saturating_sub(NEARER_ARCMIN) {
            *self = Self { nearest: way as u16, since: if new { self.since } else { now } };
        }
        u32::from(now.wrapping_sub(self.since)) >= PATIENCE_MS
    }
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
        let before = self.target.replace(target);
        let other = before != Some(target);
        let change = target.minus(before.unwrap_or(target));
        let rest = target.minus(direction(drives));
        let ways = [(Axis::Horizontal, rest.horizontal), (Axis::Vertical, rest.vertical)];
        let mut stuck = false;
        let changes = [change.horizontal, change.vertical];
        for ((wait, change), (_, way)) in self.waits.iter_mut().zip(changes).zip(ways) {
            stuck |= wait.step(now, way, change != 0);
        }
        let longest = ways.iter().map(|(_, way)| way.saturating_abs()).max().unwrap_or(0);
        if ways.iter().all(|(_, way)| way.saturating_abs() <= TOLERANCE_ARCMIN) {
            if other {
                // One that only passes here on the way to another goal must not go on to it.
                stop(drives, &AIM, cause);
            }
            return Progress::There;
        }
        for (axis, way) in ways {
            let drive = by_axis(drives, axis);
            let near = way.saturating_abs() <= TOLERANCE_ARCMIN;
            if (other || drive.is_idle()) && !near {
                let speed = speed_tenths.map(|speed| in_proportion(speed, way, longest));
                drive.go(drive.position().saturating_add(way), speed, cause);
            } else if other && matches!(drive.mover(), Some(Cause::Program(..))) {
                drive.stop(cause);
            }
        }
        if stuck { Progress::Stuck } else { Progress::Going }
    }
}

/// Whether these drives can be taken to a position. A direct drive does not count its way while its
/// limits are off (§3.17), so a program would run it on and on.
pub(crate) fn can_aim(drives: &[Drive; AXES], axes: &[Axis]) -> bool {
    axes.iter().all(|axis| {
        let drive = of_axis(drives, *axis);
        drive.is_absent() || drive.limits().is_some() || drive.is_remote()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subsystem::control::bench::{BY, Bench, CYCLE_MS};

    const CAUSE: Cause = Cause::Program(Program::Quench, BY);

    fn to(horizontal: i32, vertical: i32) -> Direction {
        Direction { horizontal, vertical }
    }

    /// Approaches for a time, or until it is not under way any more.
    fn run(bench: &mut Bench, approach: &mut Approach, wanted: Direction, ms: u32) -> Progress {
        let mut progress = Progress::Going;
        for _ in 0..ms / CYCLE_MS {
            bench.cycle();
            progress = approach.step(bench.now, &mut bench.drives, wanted, Some(50), CAUSE);
            if progress != Progress::Going {
                break;
            }
        }
        progress
    }

    /// §3.14/1 The jet draws a straight line, whichever way is the longer, and arrives within 3'.
    #[test]
    fn straight_lines() {
        for (h, v) in [(1200, 300), (300, 1200), (-1200, 400), (900, 0)] {
            let (mut bench, mut approach) = (Bench::new(), Approach::default());
            for _ in 0..6000 {
                let progress = run(&mut bench, &mut approach, to(h, v), CYCLE_MS);
                let (now_h, now_v) = bench.aim();
                let aside = (now_h * v - now_v * h) / h.abs().max(v.abs());
                assert!(aside.abs() <= 12, "{now_h}' {now_v}' on the way to {h}' {v}'");
                if progress == Progress::There {
                    break;
                }
            }
            let rest = to(h, v).minus(direction(&bench.drives));
            assert!(rest.horizontal.abs() <= 3 && rest.vertical.abs() <= 3, "{rest:?}");
        }
    }

    /// Another direction counts at once, also for a drive that is under way.
    #[test]
    fn turns_at_once() {
        let (mut bench, mut approach) = (Bench::new(), Approach::default());
        assert_eq!(run(&mut bench, &mut approach, to(3000, 600), 5000), Progress::Going);
        let (turned, _) = bench.aim();
        assert_eq!(run(&mut bench, &mut approach, to(-600, 600), 3000), Progress::Going);
        assert!(bench.aim().0 < turned && bench.drives[1].output().speed_tenths < 0);
        // There already: what another program has started ends.
        let (here, _) = bench.aim();
        assert_eq!(run(&mut bench, &mut approach, to(here, 5000), CYCLE_MS), Progress::Going);
        assert!(bench.drives[1].is_idle() && !bench.drives[0].is_idle());
    }

    /// A drive that is near enough stops; one that an operator moves goes on.
    #[test]
    fn near_is_enough() {
        let (mut bench, mut approach) = (Bench::new(), Approach::default());
        run(&mut bench, &mut approach, to(900, 3), 60_000);
        let (_, before) = bench.aim();
        for _ in 0..50 {
            run(&mut bench, &mut approach, to(1800, 3), CYCLE_MS);
            assert_eq!((bench.aim().1, bench.drives[0].is_idle()), (before, true));
        }
        assert_ne!(before, 3, "nothing to correct");
        bench.move_to(Axis::Vertical, 900);
        assert_eq!(run(&mut bench, &mut approach, to(1700, 0), CYCLE_MS), Progress::Going);
        assert!(!bench.drives[0].is_idle());
    }

    /// §3.3.6/1 Ten seconds without coming nearer are too many, counted from the last that was gained.
    #[test]
    fn comes_no_nearer() {
        let (mut bench, mut approach) = (Bench::new(), Approach::default());
        assert_eq!(run(&mut bench, &mut approach, to(9000, 0), 15_000), Progress::Going);
        // The end switch lets it go no further.
        bench.inputs.drives[1].max_switch = true;
        assert_eq!(run(&mut bench, &mut approach, to(9000, 0), 9_900), Progress::Going);
        bench.inputs.drives[1].max_switch = false;
        assert_eq!(run(&mut bench, &mut approach, to(9000, 0), 5000), Progress::Going);
        bench.inputs.drives[1].max_switch = true;
        assert_eq!(run(&mut bench, &mut approach, to(9000, 0), 9_900), Progress::Going);
        assert_eq!(run(&mut bench, &mut approach, to(9000, 0), 300), Progress::Stuck);
        // Moved away after it has arrived, it is given the same time again.
        bench.inputs.drives[1].max_switch = false;
        let mut approach = Approach::default();
        let here = direction(&bench.drives);
        for _ in 0..1500 {
            assert_eq!(run(&mut bench, &mut approach, here, CYCLE_MS), Progress::There);
        }
        bench.move_to(Axis::Horizontal, here.horizontal - 600);
        for _ in 0..30 {
            run(&mut bench, &mut approach, here, CYCLE_MS);
        }
        assert_eq!(run(&mut bench, &mut approach, here, 200), Progress::Going);
        assert_eq!(run(&mut bench, &mut approach, here, 15_000), Progress::There);
    }

    /// How long an approach goes on, 30 s at most, whose vertical target changes twice a second.
    fn fluctuating(bench: &mut Bench, (low, high): (i32, i32), tenths: i32) -> u32 {
        let mut approach = Approach::default();
        for ms in (0..30_000).step_by(CYCLE_MS as usize) {
            let wanted = to(9000, if ms / 500 % 2 == 0 { low } else { high });
            bench.cycle();
            let speed = Some(tenths);
            if approach.step(bench.now, &mut bench.drives, wanted, speed, CAUSE) == Progress::Stuck
            {
                return ms;
            }
        }
        30_000
    }

    /// §3.3.6/1 A target that fluctuates in one axis hides neither drive that does not come nearer, and is itself
    /// no reason: a slow drive that follows it has not stopped.
    #[test]
    fn fluctuation_hides_nothing() {
        for (end, bounds) in [(1, (0, 120)), (1, (0, 10)), (0, (3000, 3060))] {
            let mut bench = Bench::new();
            bench.inputs.drives[end].max_switch = true;
            let ms = fluctuating(&mut bench, bounds, 50);
            assert!((10_000..11_000).contains(&ms), "{end} {bounds:?}: {ms}");
        }
        for bounds in [(0, 8), (0, 300), (3000, 3100), (-3, 5)] {
            let mut bench = Bench::new();
            assert_eq!(fluctuating(&mut bench, bounds, 5), 30_000, "{bounds:?}");
        }
    }

    #[test]
    fn speeds_in_proportion() {
        assert_eq!(in_proportion(50, -300, 1200), 12);
        assert_eq!(in_proportion(50, 1200, 1200), 50);
        assert_eq!(in_proportion(50, 1, 1200), 1, "it has to get there");
        assert_eq!(in_proportion(50, 0, 0), 1);
    }
}
