//! A motion as short steps that end by themselves, for monitors without MoveHold.
//!
//! Each Move leads to a position a little ahead of the last known one: far enough that the next
//! Move comes before the drive arrives, and no farther than braking requires. Without a renewal the
//! drive arrives and stops. Nothing is assumed about the drive: its speed is taken from its status
//! and its positions, so the first step is small, and steps grow while the drive gets faster with
//! them.

use std::time::Duration;

use lafet_proto::SubsystemId;
use lafet_proto::status::DriveStatus;

use super::super::Now;

/// The first step, ' (§3.1).
const FIRST_ARCMIN: f64 = 18.0;
/// The first step of the nozzle, mm.
const FIRST_MM: f64 = 1.0;
/// Factor by which a step grows while the drive gets faster with it.
const GROWTH: f64 = 1.5;
/// Factor of speed above which a drive counts as faster.
const FASTER: f64 = 1.05;
/// Time that a drive may need to brake from its speed: a step is never longer than this time plus
/// the time until the next Move.
const BRAKING: Duration = Duration::from_millis(600);
/// Margin added to the time until the next Move, in addition to a quarter of it.
const SPARE: Duration = Duration::from_millis(30);
/// Positions at most this far apart count as equal, ' or mm.
const SAME: i32 = 1;

/// The steps of a motion.
#[derive(Debug)]
pub struct Steps {
    /// 1: up, left, narrow; -1: down, right, wide.
    sign: f64,
    first: f64,
    /// Units of position per second for one unit of DriveStatus.speed.
    per_speed: f64,
    lead: f64,
    /// The highest speed seen, units per second.
    top: f64,
    seen: Option<(Now, DriveStatus)>,
    destination: Option<i32>,
    /// Time of the last Move, and the longest recent time between two.
    moved: Option<Now>,
    cycle: Duration,
    no_farther: Option<i16>,
}

impl Steps {
    /// Steps of a drive, up (left, narrow) or down, and no farther than a position; a Move is expected
    /// every `cycle`.
    pub fn new(drive: SubsystemId, up: bool, cycle: Duration, no_farther: Option<i16>) -> Self {
        let nozzle = drive == SubsystemId::NOZZLE;
        let (first, per_speed) = if nozzle { (FIRST_MM, 1.0) } else { (FIRST_ARCMIN, 60.0) };
        let sign = if up { 1.0 } else { -1.0 };
        let (lead, seen, destination, moved) = (first, None, None, None);
        Self { sign, first, per_speed, lead, top: 0.0, seen, destination, moved, cycle, no_farther }
    }

    /// Whether the drive has reached the end of the last step.
    pub fn has_arrived(&self, status: &DriveStatus) -> bool {
        self.destination.is_some_and(|to| (to - i32::from(status.position)).abs() <= SAME)
    }

    /// Takes the drive's state.
    pub fn saw(&mut self, now: Now, status: DriveStatus) {
        let mut speed = f64::from(status.speed) * self.per_speed;
        if let Some((before, last)) = self.seen.replace((now, status)) {
            let way = f64::from(status.position) - f64::from(last.position);
            let time = now.saturating_sub(before).as_secs_f64();
            if time > 0.0 {
                speed = speed.max(way * self.sign / time);
            }
        }
        if self.destination.is_some() && speed > self.top * FASTER {
            self.top = speed;
            self.lead *= GROWTH;
        }
    }

    /// The destination of the next Move, if an answer takes `rtt`.
    pub fn next(&mut self, now: Now, rtt: Duration) -> i16 {
        if let Some(before) = self.moved.replace(now) {
            let cycle = now.saturating_sub(before);
            self.cycle = cycle.max(self.cycle * 7 / 8);
        }
        // The known position is older by one answer when the Move arrives.
        let until_next = (self.cycle + rtt).mul_f64(1.25) + SPARE;
        let least = (self.top * until_next.as_secs_f64()).max(self.first);
        let most = (self.top * (until_next + BRAKING).as_secs_f64()).max(self.first);
        self.lead = self.lead.clamp(least, most);
        let from = self.seen.map_or(0.0, |(_, status)| f64::from(status.position));
        let far = f64::from(i16::MAX);
        let to = (from + self.sign * self.lead).round().clamp(-far, far);
        let to = match self.no_farther.map(f64::from) {
            Some(bound) if self.sign > 0.0 => to.min(bound),
            Some(bound) => to.max(bound),
            None => to,
        };
        // A step never leads back behind the one before: the drive would brake.
        let to = match self.destination {
            Some(before) if self.sign > 0.0 => to.max(f64::from(before)),
            Some(before) => to.min(f64::from(before)),
            None => to,
        };
        self.destination = Some(to as i32);
        to as i16
    }
}

#[cfg(test)]
mod tests {
    use lafet_proto::flags::DriveFlags;

    use super::*;

    const MS: Duration = Duration::from_millis(1);

    fn at(position: i16, speed: u8) -> DriveStatus {
        DriveStatus { flags: DriveFlags::MOVE, position, current: 0, speed }
    }

    /// Steps lead ahead by the distance until the next Move at any speed, and the first is small.
    #[test]
    fn steps_follow_the_speed_of_the_drive() {
        for (speed, sign) in [(1.0, 1.0), (5.0, -1.0), (12.0, 1.0), (20.0, -1.0)] {
            let mut steps = Steps::new(SubsystemId::HORIZONTAL, sign > 0.0, 100 * MS, None);
            let (mut position, mut now) = (100.0, Now::ZERO);
            steps.saw(now, at(100, 0));
            let mut to = f64::from(steps.next(now, 2 * MS));
            assert_eq!(to, 100.0 + sign * FIRST_ARCMIN);
            for _ in 0..40 {
                now += 100 * MS;
                position += sign * (speed * 6.0_f64).min((to - position) * sign);
                steps.saw(now, at(position as i16, speed as u8));
                to = f64::from(steps.next(now, 2 * MS));
            }
            let seconds = (to - position) * sign / (speed * 60.0);
            assert!((0.1..0.5).contains(&seconds), "{speed} °/s: {seconds} s ahead");
        }
    }

    #[test]
    fn no_step_leads_back_or_out_of_range() {
        let mut steps = Steps::new(SubsystemId::NOZZLE, true, 100 * MS, None);
        steps.saw(Now::ZERO, at(i16::MAX - 1, 0));
        assert_eq!(steps.next(Now::ZERO, MS), i16::MAX);
        steps.saw(100 * MS, at(10, 0));
        assert_eq!(steps.next(100 * MS, MS), i16::MAX);
    }

    #[test]
    fn no_step_leads_farther_than_allowed() {
        for (sign, bound) in [(1, 150), (-1, -40)] {
            let mut steps = Steps::new(SubsystemId::HORIZONTAL, sign > 0, 100 * MS, Some(bound));
            let (mut position, mut now) = (100, Now::ZERO);
            for _ in 0..20 {
                steps.saw(now, at(position, 20));
                position = steps.next(now, 2 * MS);
                now += 100 * MS;
            }
            assert_eq!(position, bound);
            steps.saw(now, at(position, 0));
            assert!(steps.has_arrived(&at(position, 0)));
        }
    }
}
