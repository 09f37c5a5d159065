//! The dead-man switch, as the hub hears it: beats that must not stop. No clock.
//!
//! ```text
//!           beat          second beat within 300 ms
//!  Idle ─────────▶ Armed ──────────────────────────▶ Moving ─── beat: renewed
//!   ▲               │ 300 ms, end                     │ end, 300 ms
//!   ├───────────────┴─────────────────────────────────┤
//!   └── 300 ms without a beat, or end ── Blocked ◀────┘ ended otherwise: release first
//! ```

use std::time::Duration;

use lafet_client::Toward;

use crate::clock::Sleep;

/// A moment: time since any fixed one.
pub type Now = Duration;

/// A motion goes on for this time after a beat.
pub const WATCHDOG: Duration = Duration::from_millis(300);
/// How often a client should send beats, ms.
pub const BEAT_MS: u64 = 60;

/// Two clocks run apart by less than this part of the time: crystals by 0.0001, and time servers correct
/// them.
const DRIFT: f64 = 0.0002;

/// How long messages are under way, by the sender's clock.
#[derive(Clone, Copy, Debug, Default)]
pub struct Delay {
    /// Our time minus the sender's, ms, of the quickest message so far; and when that was so.
    least: Option<(f64, Now)>,
}

impl Delay {
    /// Whether a beat was sent recently: not [`WATCHDOG`] later than the quickest one, nor before the last sleep of the
    /// machine.
    pub fn is_fresh(&mut self, now: Now, sent_ms: f64, sleep: Sleep) -> bool {
        self.longer(now, sent_ms).is_some_and(|it| sleep.age(now, it) < WATCHDOG)
    }

    /// For how much longer a message was under way than the quickest one, by clocks that stand still while their machines
    /// sleep; `None`: the sender has no clock.
    pub fn longer(&mut self, now: Now, sent_ms: f64) -> Option<Duration> {
        let offset_ms = millis(now) - sent_ms;
        if !offset_ms.is_finite() {
            return None;
        }
        // What was the least is less certain the longer ago it was.
        let least = |(least_ms, at)| least_ms + millis(now.saturating_sub(at)) * DRIFT;
        let least_ms = self.least.map_or(offset_ms, |it| least(it).min(offset_ms));
        self.least = Some((least_ms, now));
        // More than a duration has room for was under way for ever.
        Some(Duration::try_from_secs_f64((offset_ms - least_ms) / 1000.0).unwrap_or(Duration::MAX))
    }
}

fn millis(time: Duration) -> f64 {
    time.as_secs_f64() * 1000.0
}

/// The beats for one drive.
#[derive(Clone, Copy, Debug, Default)]
pub struct Beats {
    phase: Phase,
}

#[derive(Clone, Copy, Debug, Default)]
enum Phase {
    #[default]
    Idle,
    Armed(Toward, Now),
    Moving(Toward, Now),
    Blocked(Now),
}

/// What follows from a beat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// The first one: nothing moves yet.
    Arm,
    /// The motion begins.
    Start,
    /// The motion continues.
    Renew,
    /// The other direction: the motion ends, and this was the first beat of another.
    Turn,
    /// The motion has ended; the hand has not released it yet.
    Ended,
}

impl Beats {
    /// Takes a beat.
    pub fn beat(&mut self, now: Now, toward: Toward) -> Act {
        let fresh = |at: Now| now.saturating_sub(at) < WATCHDOG;
        let (phase, act) = match self.phase {
            Phase::Armed(before, at) if fresh(at) && before == toward => {
                (Phase::Moving(toward, now), Act::Start)
            }
            Phase::Moving(before, at) if fresh(at) && before == toward => {
                (Phase::Moving(toward, now), Act::Renew)
            }
            Phase::Moving(before, at) if fresh(at) && before != toward => {
                (Phase::Armed(toward, now), Act::Turn)
            }
            Phase::Blocked(at) if fresh(at) => (Phase::Blocked(now), Act::Ended),
            _ => (Phase::Armed(toward, now), Act::Arm),
        };
        self.phase = phase;
        act
    }

    /// The next beat begins the motion, if it is in time.
    pub const fn is_armed(&self) -> bool {
        matches!(self.phase, Phase::Armed(..))
    }

    /// A beat has come that was long under way. It moves nothing; and the hand has not been released
    /// meanwhile, so that the beats which follow it move nothing either.
    pub fn late(&mut self, now: Now) {
        let goes_on =
            matches!(self.phase, Phase::Moving(_, at) if now.saturating_sub(at) < WATCHDOG);
        if !goes_on {
            self.phase = Phase::Blocked(now);
        }
    }

    /// The hand is released.
    pub fn end(&mut self) {
        self.phase = Phase::Idle;
    }

    /// The motion has ended by itself or was taken away.
    pub fn ended(&mut self, now: Now) {
        if let Phase::Moving(_, at) | Phase::Armed(_, at) = self.phase {
            self.phase = Phase::Blocked(at.min(now));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(ms: u64) -> Now {
        Duration::from_millis(ms)
    }

    fn acts(beats: &mut Beats, times: &[u64]) -> Vec<Act> {
        times.iter().map(|at| beats.beat(ms(*at), Toward::Max)).collect()
    }

    #[test]
    fn the_second_beat_moves() {
        let mut beats = Beats::default();
        assert_eq!(acts(&mut beats, &[0, 60, 120]), [Act::Arm, Act::Start, Act::Renew]);
        beats.end();
        assert_eq!(acts(&mut beats, &[130]), [Act::Arm]);
    }

    #[test]
    fn beats_too_far_apart_move_nothing() {
        let mut beats = Beats::default();
        assert_eq!(acts(&mut beats, &[0, 300, 600]), [Act::Arm; 3]);
        assert_eq!(acts(&mut beats, &[650, 949]), [Act::Start, Act::Renew]);
        assert_eq!(acts(&mut beats, &[1249]), [Act::Arm], "it has lapsed");
    }

    #[test]
    fn the_other_way_begins_anew() {
        let mut beats = Beats::default();
        acts(&mut beats, &[0, 60]);
        assert_eq!(beats.beat(ms(100), Toward::Min), Act::Turn);
        assert_eq!(beats.beat(ms(150), Toward::Min), Act::Start);
        let mut beats = Beats::default();
        assert_eq!(beats.beat(ms(0), Toward::Min), Act::Arm);
        assert_eq!(beats.beat(ms(10), Toward::Max), Act::Arm, "two first beats are no second one");
    }

    #[test]
    fn after_another_end_it_has_to_be_let_go() {
        let mut beats = Beats::default();
        acts(&mut beats, &[0, 60]);
        beats.ended(ms(100));
        assert_eq!(acts(&mut beats, &[120, 400, 650]), [Act::Ended; 3]);
        assert_eq!(acts(&mut beats, &[950, 1000]), [Act::Arm, Act::Start]);
        beats.ended(ms(1010));
        beats.end();
        assert_eq!(acts(&mut beats, &[1020]), [Act::Arm]);
    }

    #[test]
    fn a_hand_that_held_on_through_a_stall_has_to_let_go() {
        let mut beats = Beats::default();
        acts(&mut beats, &[0, 60]);
        beats.late(ms(1000));
        assert_eq!(acts(&mut beats, &[1010, 1070, 1130]), [Act::Ended; 3]);
        assert_eq!(
            acts(&mut beats, &[1430, 1490]),
            [Act::Arm, Act::Start],
            "300 ms without a beat"
        );
        beats.late(ms(1500));
        assert_eq!(acts(&mut beats, &[1550]), [Act::Renew], "one late beat of a good stream");
        let mut beats = Beats::default();
        beats.late(ms(0));
        beats.end();
        assert_eq!(acts(&mut beats, &[10, 70]), [Act::Arm, Act::Start]);
    }

    #[test]
    fn what_a_stalled_connection_delivers_late_is_not_fresh() {
        let mut delay = Delay::default();
        let mut is_fresh = |at, sent_ms| delay.is_fresh(ms(at), sent_ms, Sleep::default());
        assert!(is_fresh(10_000, 50.0));
        assert!(is_fresh(10_060, 110.0) && is_fresh(10_250, 170.0));
        assert!(!is_fresh(10_900, 230.0), "610 ms late");
        assert!(!is_fresh(10_900, 290.0));
        assert!(is_fresh(10_901, 880.0));
        assert!(!is_fresh(11_000, f64::NAN));
    }

    /// A clock that is 100 ppm slower is 8.6 s behind after a day.
    #[test]
    fn a_slower_clock_makes_no_beat_late() {
        let (mut delay, awake) = (Delay::default(), Sleep::default());
        for second in 0..86_400_u64 {
            let now = ms(second * 1000);
            assert!(delay.is_fresh(now, millis(now) * 0.9999, awake), "after {second} s");
        }
        let now = ms(86_400_000);
        let sent_ms = millis(now) * 0.9999;
        assert!(!delay.is_fresh(now, sent_ms - 310.0, awake), "a late one is late still");
        assert!(delay.longer(now, sent_ms - 900.0).is_some_and(|it| it < ms(1000)));
    }
}
