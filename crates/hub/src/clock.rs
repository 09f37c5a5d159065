//! The one clock of the hub: the date, for logs, and a steady time, for ages.
//!
//! The date may jump: a user sets it, or the time server comes back. The age of a session, of a
//! shelving or of what is kept must not jump with it, so these are measured by a steady time. It is
//! the date at the start and what has passed since, by a clock that cannot be set.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use lafet_texts::{Decimal, Text as _, hub as text};
use tokio::time::Instant;

use crate::hub::{Caller, Hub};
use crate::store::Act;
use crate::sync::lock;

/// A difference between date and steady time that changes by this within a second is a step; what
/// a time server slews is less.
const STEP_MS: u64 = 2000;
/// A machine that has slept for less is not noticed: two clocks are not read at the same moment.
const SLEPT_MS: i64 = 250;
/// What is sent within this time after a sleep was noticed may have been sent before it.
const WAKES: Duration = Duration::from_secs(1);

/// A steady time in whole milliseconds.
pub fn ms(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}

/// Where the time comes from.
#[derive(Clone, Debug, Default)]
pub enum Clock {
    /// Clock of the system.
    #[default]
    System,
    /// One that is set by hand, for tests.
    Manual(Arc<ManualTime>),
}

/// A time that is set by hand.
#[derive(Debug)]
pub struct ManualTime {
    date_ms: AtomicU64,
    steady_ms: AtomicU64,
}

impl ManualTime {
    /// A clock that shows this date.
    pub fn at(date_ms: u64) -> Arc<Self> {
        Arc::new(Self { date_ms: date_ms.into(), steady_ms: date_ms.into() })
    }

    /// Lets time pass.
    pub fn pass(&self, ms: u64) {
        self.date_ms.fetch_add(ms, Ordering::Relaxed);
        self.steady_ms.fetch_add(ms, Ordering::Relaxed);
    }

    /// The date is set, and no time passes.
    pub fn set_date(&self, date_ms: u64) {
        self.date_ms.store(date_ms, Ordering::Relaxed);
    }
}

impl Clock {
    /// The date, ms since 1970. It may jump; nothing that moves a monitor and no age depends on it.
    pub fn now_ms(&self) -> u64 {
        match self {
            Self::System => date_ms(),
            Self::Manual(time) => time.date_ms.load(Ordering::Relaxed),
        }
    }

    /// The date at the start and what has passed since, ms: never jumps.
    pub fn steady_ms(&self) -> u64 {
        static START: OnceLock<(Instant, u64)> = OnceLock::new();
        match self {
            Self::System => {
                let (start, date_ms) = START.get_or_init(|| (Instant::now(), date_ms()));
                date_ms.saturating_add(u64::try_from(start.elapsed().as_millis()).unwrap_or(0))
            }
            Self::Manual(time) => time.steady_ms.load(Ordering::Relaxed),
        }
    }

    /// How far the date is ahead of the steady time, ms.
    pub fn ahead_ms(&self) -> i64 {
        let (date_ms, steady_ms) = (self.now_ms(), self.steady_ms());
        let ahead = i128::from(date_ms) - i128::from(steady_ms);
        i64::try_from(ahead).unwrap_or(i64::MAX)
    }

    /// The date by which what is old is removed: one that has jumped ahead removes nothing more.
    pub fn cautious_ms(&self) -> u64 {
        self.now_ms().min(self.steady_ms())
    }
}

/// Notices steps of the date.
#[derive(Debug)]
pub struct Steps {
    ahead_ms: i64,
}

impl Steps {
    /// Watches the clock from now on.
    pub fn from_now(clock: &Clock) -> Self {
        Self { ahead_ms: clock.ahead_ms() }
    }

    /// By how much the date has stepped since the last look, ms.
    pub fn look(&mut self, clock: &Clock) -> Option<i64> {
        let ahead_ms = clock.ahead_ms();
        let step_ms = ahead_ms.saturating_sub(std::mem::replace(&mut self.ahead_ms, ahead_ms));
        (step_ms.unsigned_abs() >= STEP_MS).then_some(step_ms)
    }
}

/// A sleep of the hub's machine, or a pause of it: the date goes on meanwhile, and no clock by which ages are measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sleep {
    /// When it was noticed, by the time since the hub's start.
    noticed: Duration,
    /// How long it was.
    long: Duration,
}

impl Sleep {
    /// How old something is that is so old by a clock that stops in a sleep, as it is at `now`: a date that was
    /// set ahead makes it older as well.
    pub fn age(self, now: Duration, age: Duration) -> Duration {
        let may_be_before = now.saturating_sub(age) < self.noticed.saturating_add(WAKES);
        age.saturating_add(if may_be_before { self.long } else { Duration::ZERO })
    }
}

/// Notices sleeps.
#[derive(Debug)]
pub struct Sleeps(Mutex<(i64, Sleep)>);

impl Sleeps {
    /// Watches the clock from now on.
    pub fn from_now(clock: &Clock) -> Self {
        Self(Mutex::new((clock.ahead_ms(), Sleep::default())))
    }

    /// The last one, also if it has only just ended; `now` is the time since the hub's start.
    pub fn look(&self, now: Duration, clock: &Clock) -> Sleep {
        let mut seen = lock(&self.0);
        let ahead_ms = clock.ahead_ms();
        let by_ms = ahead_ms.saturating_sub(std::mem::replace(&mut seen.0, ahead_ms));
        if by_ms >= SLEPT_MS {
            seen.1 = Sleep { noticed: now, long: Duration::from_millis(by_ms.unsigned_abs()) };
        }
        seen.1
    }
}

impl Hub {
    /// How old something is, with the last sleep of the machine, that is so old by the clock of the hub.
    pub fn age(&self, age: Duration) -> Duration {
        self.last_sleep().age(self.now(), age)
    }

    /// Looks whether the date has stepped: it is recorded, and ages stay what they were.
    pub fn look_at_clock(&self, steps: &mut Steps) {
        let Some(by_ms) = steps.look(self.clock()) else { return };
        let text = text::ClockStepped { by_s: Decimal(by_ms as f64 / 1000.0, 1) }.words();
        let record = self.record(&Caller::hub(), "", "clock step", "Ok");
        drop(self.audit().note(record.about(&Act::ClockStep { by_ms })));
        self.event(None, &text);
        self.recordings().stepped(by_ms);
        for station in self.stations() {
            lock(&station.programs).stepped(by_ms);
        }
        let changes = self.alarms().stepped(self.clock().now_ms(), by_ms);
        self.publish_alarms(changes);
        let own = self.clone();
        // The disk is waited for elsewhere.
        tokio::task::spawn_blocking(move || own.access().stepped(by_ms));
    }
}

/// A time of the steady clock or of the past as a date, or the other way round.
pub fn shifted(ms: u64, by_ms: i64) -> u64 {
    ms.saturating_add_signed(by_ms)
}

#[expect(clippy::disallowed_methods, reason = "logs bear the date; ages are measured otherwise")]
fn date_ms() -> u64 {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |since| u64::try_from(since.as_millis()).unwrap_or(u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn s(s: u64) -> Duration {
        Duration::from_secs(s)
    }

    /// Assumed: the machine sleeps for five minutes, and the clocks of the hub and of its client with it.
    #[test]
    fn what_was_sent_before_a_sleep_is_as_old_as_that() {
        let time = ManualTime::at(1_000_000);
        let clock = Clock::Manual(time.clone());
        let sleeps = Sleeps::from_now(&clock);
        time.pass(60_000);
        assert_eq!(sleeps.look(s(60), &clock).age(s(60), s(1)), s(1), "time has passed");
        time.set_date(1_000_000 + 60_000 + 300_000);
        let sleep = sleeps.look(s(60), &clock);
        for (now, age, real) in [
            (s(60), Duration::ZERO, s(300)),
            (s(60), s(1), s(301)),
            (s(61), Duration::from_millis(10), Duration::from_millis(300_010)),
            (s(62), s(1), s(1)),
            (s(62), s(2), s(302)),
            (s(90), Duration::ZERO, Duration::ZERO),
            (s(90), Duration::MAX, Duration::MAX),
        ] {
            assert_eq!(sleep.age(now, age), real, "{age:?} old at {now:?}");
        }
        assert_eq!(sleeps.look(s(61), &clock), sleep, "it is noticed once");
        time.set_date(5000);
        assert_eq!(sleeps.look(s(62), &clock), sleep, "a date that is set back is no sleep");
        time.set_date(5249);
        assert_eq!(sleeps.look(s(63), &clock), sleep, "two clocks are read one after the other");
    }

    #[test]
    fn a_step_is_noticed_once_and_moves_no_age() {
        let time = ManualTime::at(1_000_000);
        let clock = Clock::Manual(time.clone());
        let mut steps = Steps::from_now(&clock);
        time.pass(5000);
        assert_eq!((steps.look(&clock), clock.steady_ms()), (None, 1_005_000));
        time.set_date(9_005_000);
        assert_eq!((steps.look(&clock), steps.look(&clock)), (Some(8_000_000), None));
        assert_eq!((clock.steady_ms(), clock.cautious_ms()), (1_005_000, 1_005_000));
        time.set_date(5000);
        assert_eq!(steps.look(&clock), Some(-9_000_000));
        assert_eq!(clock.cautious_ms(), 5000);
    }
}
