//! What is made of a detector's values over time: what may be reported, and whether it may be trusted.
//!
//! A value counts for [`Rules::counts_for`]. After that the last one is reported with a fault: an alarm
//! stays shown and has no vote, and a silent line is never "no fire". After a break (a read that failed,
//! a new connection) values count again from the second whole read on: the first one may be an answer to
//! an earlier request, or the memory of a gateway that has not read its devices yet.
//!
//! A panel that has just started has its old alarms still, or fills its registers one by one. For
//! [`Rules::settles_for`] after the first values, and after each loss, a detector counts as starting up, and an
//! alarm that comes within that time does until it is gone: it is shown, and has no vote. One that was there
//! before the loss is no news, and votes as before.

use std::time::Duration;

use lafet_site::{Condition, Signal};
use serde::Serialize;
use utoipa::ToSchema;

use super::maps::Seen;
use crate::control::authority::Now;

/// Whole reads in a row from which values count.
const SETTLED: u8 = 2;

/// Times of a detector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rules {
    /// A value counts for this time.
    pub counts_for: Duration,
    /// What has not changed is reported this often.
    pub repeat: Duration,
    /// The heartbeat may stand still for this time.
    pub beats_within: Option<Duration>,
    /// It counts as starting up for so long after it was not read.
    pub settles_for: Duration,
}

/// How a detector is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ModbusReading)]
pub enum Reading {
    /// Not read yet.
    Waiting,
    /// Its values count.
    Good,
    /// Its heartbeat was not seen to change yet: it counts as starting up.
    Unproven,
    /// Its heartbeat does not change: a fault.
    Frozen,
    /// Nothing valid was read for too long: a fault.
    Lost,
}

/// What is known of a detector.
#[derive(Clone, Debug)]
pub struct Watch {
    rules: Rules,
    /// Whole reads in a row.
    whole: u8,
    /// The latest values that count.
    read: Option<(Now, Seen)>,
    /// The heartbeat, and since when it is so.
    beat: Option<(bool, Now)>,
    /// It was seen to change.
    beats: bool,
    /// It counts as starting up until then.
    settles: Now,
    /// The alarm came while it did.
    stale: bool,
    told: Option<(Now, Signal, Condition)>,
    /// It was said that nothing was ever read.
    missed: bool,
}

impl Watch {
    /// Nothing is known.
    pub const fn new(rules: Rules) -> Self {
        Self {
            rules,
            whole: 0,
            read: None,
            beat: None,
            beats: false,
            settles: Now::ZERO,
            stale: false,
            told: None,
            missed: false,
        }
    }

    /// A read failed, or the connection is new.
    pub fn breaks(&mut self) {
        self.whole = 0;
    }

    /// All values were read.
    pub fn reads(&mut self, now: Now, seen: Seen) {
        self.whole = self.whole.saturating_add(1);
        if self.whole < SETTLED {
            return;
        }
        let alarm = seen.signal == Signal::Alarm;
        let before = self.read.is_some_and(|(_, seen)| seen.signal == Signal::Alarm);
        if (self.read.is_none() || self.is_lost(now)) && !(before && alarm) {
            self.settles = now + self.rules.settles_for;
        }
        self.stale = alarm && (self.stale || (!before && now < self.settles));
        if self.is_lost(now) {
            // It may have changed twice meanwhile, or not at all.
            (self.beat, self.beats) = (None, false);
        }
        self.read = Some((now, seen));
        if let Some(beat) = seen.beat {
            match self.beat {
                Some((known, _)) if known == beat => {}
                before => {
                    self.beats |= before.is_some();
                    self.beat = Some((beat, now));
                }
            }
        }
    }

    /// Age of what counts.
    pub fn age(&self, now: Now) -> Option<Duration> {
        self.read.map(|(at, _)| now.saturating_sub(at))
    }

    /// How it is read.
    pub fn reading(&self, now: Now) -> Reading {
        if self.read.is_none() {
            return Reading::Waiting;
        }
        if self.is_lost(now) {
            return Reading::Lost;
        }
        let still = self.beat.map(|(_, since)| now.saturating_sub(since));
        match (self.rules.beats_within, still) {
            (Some(within), Some(still)) if still >= within => Reading::Frozen,
            (Some(_), _) if !self.beats => Reading::Unproven,
            _ => Reading::Good,
        }
    }

    /// What has to be reported now.
    pub fn due(&mut self, now: Now) -> Option<Seen> {
        let (_, mut seen) = self.read?;
        seen.condition = match (self.reading(now), seen.condition) {
            (Reading::Lost | Reading::Frozen, _) => Condition::Fault,
            (Reading::Unproven, Condition::Ready | Condition::Dirty) => Condition::Starting,
            (_, Condition::Ready | Condition::Dirty) if self.stale || now < self.settles => {
                Condition::Starting
            }
            (_, condition) => condition,
        };
        let told = (seen.signal, seen.condition);
        let news = self.told.is_none_or(|(at, signal, condition)| {
            (signal, condition) != told || now.saturating_sub(at) >= self.rules.repeat
        });
        news.then(|| self.told = Some((now, told.0, told.1))).map(|()| seen)
    }

    /// Whether nothing was ever read, though there was time: once.
    pub fn misses(&mut self, now: Now) -> bool {
        let news = !self.missed && self.read.is_none() && now >= self.rules.counts_for;
        self.missed |= news;
        news
    }

    fn is_lost(&self, now: Now) -> bool {
        self.age(now).is_some_and(|age| age >= self.rules.counts_for)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUIET: Seen = Seen {
        signal: Signal::Quiet,
        condition: Condition::Ready,
        beat: None,
        bearing_deg: None,
        elevation_deg: None,
    };
    const ALARM: Seen = Seen { signal: Signal::Alarm, ..QUIET };

    fn watch(beats_within_s: Option<u64>) -> Watch {
        Watch::new(Rules {
            counts_for: Duration::from_secs(2),
            repeat: Duration::from_secs(1),
            beats_within: beats_within_s.map(Duration::from_secs),
            settles_for: Duration::ZERO,
        })
    }

    fn at(ms: u64) -> Now {
        Duration::from_millis(ms)
    }

    fn told(watch: &mut Watch, ms: u64) -> Option<(Signal, Condition)> {
        watch.due(at(ms)).map(|seen| (seen.signal, seen.condition))
    }

    #[test]
    fn nothing_is_reported_before_it_was_read_twice() {
        let mut watch = watch(None);
        assert_eq!((told(&mut watch, 0), watch.reading(at(0))), (None, Reading::Waiting));
        watch.reads(at(100), ALARM);
        assert_eq!(told(&mut watch, 100), None);
        watch.reads(at(300), ALARM);
        assert_eq!(told(&mut watch, 300), Some((Signal::Alarm, Condition::Ready)));
        assert_eq!(watch.reading(at(300)), Reading::Good);
    }

    #[test]
    fn what_was_never_read_is_missed_once() {
        let mut unread = watch(None);
        let missed: Vec<bool> = [1999, 2000, 2001].map(|ms| unread.misses(at(ms))).to_vec();
        assert_eq!(missed, [false, true, false]);
        let mut read = watch(None);
        read.reads(at(0), QUIET);
        read.reads(at(100), QUIET);
        assert!(!read.misses(at(9000)));
    }

    #[test]
    fn changes_are_reported_at_once_and_the_rest_every_second() {
        let mut watch = watch(None);
        watch.reads(at(0), QUIET);
        let mut reports = Vec::new();
        for ms in (200..2400).step_by(200) {
            watch.reads(at(ms), if ms >= 1600 { ALARM } else { QUIET });
            if told(&mut watch, ms).is_some() {
                reports.push(ms);
            }
        }
        assert_eq!(reports, [200, 1200, 1600]);
    }

    #[test]
    fn what_is_not_read_any_more_is_a_fault_and_its_alarm_stays() {
        let mut watch = watch(None);
        watch.reads(at(0), ALARM);
        watch.reads(at(100), ALARM);
        told(&mut watch, 100);
        watch.breaks();
        assert_eq!(told(&mut watch, 2099), Some((Signal::Alarm, Condition::Ready)));
        assert_eq!(told(&mut watch, 2100), Some((Signal::Alarm, Condition::Fault)));
        assert_eq!(watch.reading(at(2100)), Reading::Lost);
        // As long as it lasts, and until it was read twice.
        assert_eq!(told(&mut watch, 3100), Some((Signal::Alarm, Condition::Fault)));
        watch.reads(at(3200), QUIET);
        assert_eq!((told(&mut watch, 3200), watch.reading(at(3200))), (None, Reading::Lost));
        watch.reads(at(3400), QUIET);
        assert_eq!(told(&mut watch, 3400), Some((Signal::Quiet, Condition::Ready)));
    }

    #[test]
    fn reads_that_fail_by_turns_never_count() {
        let mut watch = watch(None);
        for ms in (0..10_000).step_by(400) {
            watch.reads(at(ms), QUIET);
            watch.breaks();
            assert_eq!(told(&mut watch, ms), None);
        }
    }

    #[test]
    fn a_heartbeat_has_to_be_seen_and_may_not_stand_still() {
        let mut watch = watch(Some(32));
        let seen = |watch: &mut Watch, s: u64, beat| {
            watch.reads(at(s * 1000), Seen { beat: Some(beat), ..ALARM });
            watch.due(at(s * 1000)).map(|seen| seen.condition)
        };
        seen(&mut watch, 0, false);
        for s in 1..16 {
            assert_eq!(seen(&mut watch, s, false), Some(Condition::Starting), "{s}");
        }
        for s in 16..48 {
            assert_eq!(seen(&mut watch, s, true), Some(Condition::Ready), "{s}");
        }
        assert_eq!(seen(&mut watch, 48, true), Some(Condition::Fault));
        assert_eq!(watch.reading(at(48_000)), Reading::Frozen);
        assert_eq!(seen(&mut watch, 49, false), Some(Condition::Ready));
        // Lost meanwhile: what it was before says nothing.
        watch.breaks();
        seen(&mut watch, 80, false);
        assert_eq!(seen(&mut watch, 81, false), Some(Condition::Starting));
    }

    #[test]
    fn a_heartbeat_that_was_never_seen_to_change_is_frozen_in_the_end() {
        let mut watch = watch(Some(4));
        let mut last = None;
        for s in 0..7 {
            watch.reads(at(s * 1000), Seen { beat: Some(true), ..QUIET });
            last = watch.due(at(s * 1000)).map(|seen| seen.condition);
        }
        assert_eq!(last, Some(Condition::Fault));
    }

    #[test]
    fn what_a_detector_says_of_itself_is_not_improved() {
        let mut watch = watch(Some(4));
        for s in 0..3 {
            let masked = Seen { beat: Some(false), condition: Condition::Masked, ..QUIET };
            watch.reads(at(s * 1000), masked);
        }
        assert_eq!(told(&mut watch, 2000), Some((Signal::Quiet, Condition::Masked)));
    }

    /// A panel that starts has its old alarms, and those that it writes one by one.
    #[test]
    fn what_a_panel_alarms_of_as_it_starts_has_no_vote_until_it_is_gone() {
        let settling =
            || Watch::new(Rules { settles_for: Duration::from_secs(30), ..watch(None).rules });
        let condition = |watch: &mut Watch, s: u64, seen| {
            watch.reads(at(s * 1000), seen);
            watch.due(at(s * 1000)).map(|seen| (seen.signal, seen.condition))
        };
        let mut latched = settling();
        condition(&mut latched, 0, ALARM);
        for s in [1, 20, 31, 600] {
            latched.reads(at(s * 1000 - 1), ALARM);
            let told = condition(&mut latched, s, ALARM);
            assert_eq!(told, Some((Signal::Alarm, Condition::Starting)), "{s}");
        }
        assert_eq!(
            condition(&mut latched, 601, QUIET),
            Some((Signal::Quiet, Condition::Ready)),
            "it was gone"
        );
        assert_eq!(condition(&mut latched, 602, ALARM), Some((Signal::Alarm, Condition::Ready)));

        let mut late = settling();
        condition(&mut late, 0, QUIET);
        assert_eq!(condition(&mut late, 1, QUIET), Some((Signal::Quiet, Condition::Starting)));
        assert_eq!(condition(&mut late, 2, ALARM), Some((Signal::Alarm, Condition::Starting)));
        // Each loss begins again, but an alarm of before it is none that has come with the start.
        let mut lost = settling();
        for s in 0..40 {
            condition(&mut lost, s, QUIET);
        }
        assert_eq!(condition(&mut lost, 40, ALARM), Some((Signal::Alarm, Condition::Ready)));
        lost.breaks();
        assert_eq!(lost.due(at(50_000)).map(|it| it.condition), Some(Condition::Fault));
        condition(&mut lost, 51, ALARM);
        assert_eq!(condition(&mut lost, 52, ALARM), Some((Signal::Alarm, Condition::Ready)));
        condition(&mut lost, 53, QUIET);
        lost.breaks();
        condition(&mut lost, 60, ALARM);
        assert_eq!(condition(&mut lost, 61, ALARM), Some((Signal::Alarm, Condition::Starting)));
    }
}
