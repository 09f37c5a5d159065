//! How long a valve may be driven towards closed, and when it may rest though it is open (§3.3.5): no motor
//! is fed without end.

use lafet_device::image::ValveInput;

/// §D/6 A contact counts when it has lasted for longer than this, ms.
pub(super) const STABLE_MS: u64 = 30;

/// An attempt to close. What is repeated while it lasts is the same attempt.
#[derive(Clone, Copy, Debug)]
struct Attempt {
    /// Over at this moment: half as much again as TravelTime after its begin.
    until_ms: u64,
    /// A request has stopped it: after it the motor rests for as long.
    rest_ms: u64,
}

/// A step, and TravelTime in it, ms.
#[derive(Clone, Copy, Debug)]
pub struct Passing {
    /// Its end.
    pub now_ms: u64,
    /// Since the step before.
    pub passed_ms: u64,
    /// Of this valve.
    pub travel_ms: u32,
}

/// The closing of a valve.
#[derive(Clone, Copy, Debug)]
pub struct Closing {
    /// The last one, until it has succeeded.
    attempt: Option<Attempt>,
    /// For how long the valve has shown closed, ms.
    closed_ms: u64,
    blocked: bool,
    /// For how long its block has shown otherwise, ms.
    differs_ms: u64,
    online: bool,
    /// It has had its second chance, and has neither rested nor closed since.
    again: bool,
    /// Another one has come since: it is taken when the motor has rested.
    due: bool,
}

impl Default for Closing {
    fn default() -> Self {
        Self {
            attempt: None,
            closed_ms: 0,
            blocked: false,
            differs_ms: 0,
            online: true,
            again: false,
            due: false,
        }
    }
}

impl Closing {
    /// A request or a rule closes it.
    pub fn begin(&mut self, now_ms: u64, travel_ms: u32, asked: bool) {
        let ms = limit_ms(travel_ms);
        let rest_ms = if asked || self.again { ms } else { 0 };
        let (until_ms, rest_ms) = match self.attempt {
            Some(runs) if now_ms < runs.until_ms => {
                (runs.until_ms.min(now_ms + ms), rest_ms.max(runs.rest_ms))
            }
            Some(rests) if now_ms < rests.until_ms + rests.rest_ms => return,
            _ => (now_ms + ms, rest_ms),
        };
        self.attempt = Some(Attempt { until_ms, rest_ms });
    }

    /// A rule closes, and it has not been tried before.
    pub fn begin_by_rule(&mut self, now_ms: u64, travel_ms: u32) {
        if self.attempt.is_none() {
            self.begin(now_ms, travel_ms, false);
        }
    }

    /// Stopped: an attempt that runs ends, and says nothing of the motor.
    pub fn stop(&mut self, now_ms: u64) {
        self.attempt = self.attempt.filter(|attempt| now_ms >= attempt.until_ms);
    }

    /// A request opens it.
    pub fn open(&mut self) {
        (self.attempt, self.again, self.due) = (None, false, false);
    }

    /// What its contacts show, if they can be believed (`sound`), and whether its unit answers. What was in
    /// vain behind a block or without a unit is tried again, and what still runs has all its time again; once until the
    /// motor has rested, and then once more behind each rest.
    pub fn sense(&mut self, time: Passing, input: &ValveInput, online: bool, sound: bool) {
        let Passing { now_ms, passed_ms, travel_ms } = time;
        let closed = input.close_switch && sound;
        self.closed_ms = if closed { self.closed_ms + passed_ms } else { 0 };
        let differs = input.blocked != self.blocked;
        self.differs_ms = if differs { self.differs_ms + passed_ms } else { 0 };
        let freed = self.blocked && self.differs_ms > STABLE_MS;
        if self.differs_ms > STABLE_MS {
            (self.blocked, self.differs_ms) = (input.blocked, 0);
        }
        let was_online = std::mem::replace(&mut self.online, online);
        let back = online && !was_online;
        if freed || back {
            self.free(now_ms, limit_ms(travel_ms));
        }
        if self.has_rested(now_ms) {
            self.again = false;
            if std::mem::take(&mut self.due) {
                self.attempt = None;
            }
        }
        if self.is_closed() {
            (self.attempt, self.again, self.due) = (None, false, false);
        }
    }

    fn free(&mut self, now_ms: u64, ms: u64) {
        let Some(attempt) = self.attempt else { return };
        let runs = now_ms <= attempt.until_ms;
        if self.again && !self.has_rested(now_ms) {
            self.due |= !runs;
            return;
        }
        self.again = true;
        self.attempt = runs.then_some(Attempt { until_ms: now_ms + ms, rest_ms: ms });
    }

    /// The rest behind an attempt in vain is over.
    fn has_rested(&self, now_ms: u64) -> bool {
        self.attempt.is_some_and(|Attempt { until_ms, rest_ms }| {
            rest_ms > 0 && now_ms >= until_ms + rest_ms
        })
    }

    /// It has shown closed for long enough to be believed.
    pub const fn is_closed(&self) -> bool {
        self.closed_ms > STABLE_MS
    }

    /// Its time is over, and the valve has not closed.
    pub fn is_in_vain(&self, now_ms: u64) -> bool {
        self.attempt.is_some_and(|attempt| now_ms >= attempt.until_ms)
    }
}

/// Half as much again as TravelTime, for the cold.
fn limit_ms(travel_ms: u32) -> u64 {
    u64::from(travel_ms) + u64::from(travel_ms / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLOCKED: fn(bool) -> ValveInput = |blocked| {
        let mut input = ValveInput::default();
        input.blocked = blocked;
        input
    };

    /// Asked for or not, in vain when the time is over and not a moment before; repeated or stopped, it does
    /// not start again.
    #[test]
    fn an_attempt() {
        for asked in [false, true] {
            let mut closing = Closing::default();
            closing.begin(1000, 4000, asked);
            closing.begin(5000, 4000, asked);
            assert!(!closing.is_in_vain(6999) && closing.is_in_vain(7000));
            closing.stop(8000);
            closing.begin_by_rule(8000, 4000);
            closing.begin(8000, 4000, asked);
            assert_eq!(closing.is_in_vain(8000), asked, "it rests");
            closing.begin(13_000, 4000, true);
            assert!(!closing.is_in_vain(13_999), "{asked}");
            let mut stopped = closing;
            stopped.stop(13_500);
            assert!(!stopped.is_in_vain(20_000));
            closing.open();
            assert!(!closing.is_in_vain(20_000));
        }
        let mut closing = Closing::default();
        closing.begin(0, 4000, true);
        closing.begin(1000, 2000, true);
        assert!(!closing.is_in_vain(3999) && closing.is_in_vain(4000), "TravelTime is shorter now");
    }

    /// 10 ms that end then; TravelTime 2 s.
    const fn step(now_ms: u64) -> Passing {
        Passing { now_ms, passed_ms: 10, travel_ms: 2000 }
    }

    /// Freed, back or closed, it is tried again; a blip frees nothing.
    #[test]
    fn a_new_chance() {
        let mut vain = Closing::default();
        vain.begin(0, 2000, true);
        let mut blocked = vain;
        for _ in 0..4 {
            blocked.sense(step(3100), &BLOCKED(true), true, true);
        }
        assert!(blocked.is_in_vain(3000));
        for ms in [10, 20, 30, 40] {
            assert!(blocked.is_in_vain(3000), "{ms}");
            blocked.sense(step(3200), &BLOCKED(false), true, true);
        }
        assert!(!blocked.is_in_vain(3000));
        let mut lost = vain;
        lost.sense(step(3100), &BLOCKED(false), false, true);
        assert!(lost.is_in_vain(3000));
        lost.sense(step(3110), &BLOCKED(false), true, true);
        assert!(!lost.is_in_vain(3000));
        for (sound, still) in [(true, false), (false, true)] {
            let mut closed = vain;
            let mut input = BLOCKED(false);
            input.close_switch = true;
            for _ in 0..4 {
                closed.sense(step(3100), &input, true, sound);
            }
            assert_eq!(closed.is_in_vain(3000), still);
        }
    }

    /// Freed while it runs, it has all its time from there on, and rests after it as before.
    #[test]
    fn freed_on_its_way() {
        for asked in [false, true] {
            let mut closing = Closing::default();
            closing.begin(0, 2000, asked);
            closing.sense(step(1000), &BLOCKED(false), false, true);
            closing.sense(step(2000), &BLOCKED(false), true, true);
            assert!(!closing.is_in_vain(4999) && closing.is_in_vain(5000), "{asked}");
            closing.begin(5000, 2000, true);
            assert!(closing.is_in_vain(5000), "it rests, {asked}");
        }
    }

    /// A unit that comes and goes gives one more attempt, and then one behind each rest.
    #[test]
    fn freed_again_and_again() {
        let mut closing = Closing::default();
        closing.begin(0, 2000, true);
        let mut in_vain_ms = 0;
        for now_ms in (10..60_000).step_by(10) {
            closing.sense(step(now_ms), &BLOCKED(false), now_ms % 500 >= 100, true);
            closing.begin_by_rule(now_ms, 2000);
            in_vain_ms += if closing.is_in_vain(now_ms) { 10 } else { 0 };
        }
        assert!(in_vain_ms >= 60_000 / 3, "{in_vain_ms}");
    }
}
