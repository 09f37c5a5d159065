//! The motions by hand of a monitor: whose beats hold which drive. No clock.

use std::collections::HashMap;
use std::time::Duration;

use lafet_client::Toward;
use lafet_proto::SubsystemId;
use tokio::sync::mpsc;

use crate::clock::Sleep;
use crate::command::withdrawn::Accepted;
use crate::control::beats::{Act, Beats, Delay, Now};
use crate::words::MotionWord;

/// A session that has sent no beat for a drive for this long is forgotten. No connection keeps back
/// for so long what it delivers in the end, so no late beat is taken for the first one.
const FORGOTTEN: Duration = Duration::from_secs(60);

/// Beats by session and drive.
#[derive(Debug, Default)]
pub struct Jogs {
    slots: HashMap<Key, Slot>,
    started: u64,
}

/// A session and a drive.
pub type Key = (String, SubsystemId);

/// What becomes of a beat.
#[derive(Debug)]
pub enum Turn {
    /// State to report to the sender.
    Said(MotionWord),
    /// It was under way for too long, and nothing moves.
    Late,
    /// A motion begins: its number, and what renews it. It ends when nothing can renew it any more.
    Start(u64, mpsc::Receiver<()>),
}

/// When a beat was sent.
#[derive(Clone, Copy, Debug, Default)]
pub struct Heard {
    /// By its sender's clock, ms.
    pub sent_ms: Option<f64>,
    /// Too long ago, by the hub's clock.
    pub late: bool,
    /// The last sleep of the hub's machine.
    pub sleep: Sleep,
}

#[derive(Debug)]
struct Slot {
    beats: Beats,
    delay: Delay,
    /// What had undone motions of the drive when the first beat came.
    armed: Option<Accepted>,
    /// Holds the motion; dropped, the motion ends.
    hold: Option<mpsc::Sender<()>>,
    /// Number of the motion.
    number: u64,
    heard: Now,
}

impl Jogs {
    /// A beat, with what is known of when it was sent, and what has undone motions of the drive so far: what is asked for
    /// before a Stop does not begin after it.
    pub fn beat(
        &mut self,
        now: Now,
        key: Key,
        toward: Toward,
        heard: Heard,
        accepted: Accepted,
    ) -> Turn {
        if !self.slots.contains_key(&key) {
            self.slots
                .retain(|_, slot| slot.is_held() || now.saturating_sub(slot.heard) < FORGOTTEN);
        }
        let slot = self.slots.entry(key).or_insert_with(|| Slot::new(now));
        // A clock that has stood still, as that of a machine that slept, is learnt again. The hand that holds
        // a motion is heard.
        if !slot.is_held() && now.saturating_sub(slot.heard) >= FORGOTTEN {
            slot.delay = Delay::default();
        }
        slot.heard = now;
        let is_fresh = |sent_ms| slot.delay.is_fresh(now, sent_ms, heard.sleep);
        let fresh = heard.sent_ms.is_none_or(is_fresh);
        if heard.late || !fresh {
            slot.beats.late(now);
            return match slot.hold {
                Some(_) => Turn::Said(MotionWord::Moving),
                None => Turn::Late,
            };
        }
        if slot.beats.is_armed() && slot.armed != Some(accepted) {
            slot.beats.ended(now);
        }
        match slot.beats.beat(now, toward) {
            Act::Arm | Act::Turn => {
                (slot.hold, slot.armed) = (None, Some(accepted));
                Turn::Said(MotionWord::Armed)
            }
            Act::Renew => {
                Turn::Said(if slot.renew() { MotionWord::Moving } else { MotionWord::Ended })
            }
            Act::Ended => Turn::Said(MotionWord::Ended),
            Act::Start => {
                self.started += 1;
                let (hold, beats) = mpsc::channel(1);
                (slot.number, slot.hold) = (self.started, Some(hold));
                Turn::Start(slot.number, beats)
            }
        }
    }

    /// A session ends the motion of a drive.
    pub fn end(&mut self, key: &Key) {
        if let Some(slot) = self.slots.get_mut(key) {
            slot.beats.end();
            slot.hold = None;
        }
    }

    /// A session ends all its motions.
    pub fn let_go(&mut self, seat: &str) {
        self.slots.retain(|(holder, _), _| holder != seat);
    }

    /// A motion has ended by itself or was taken away.
    pub fn ended(&mut self, now: Now, key: &Key, number: u64) {
        if let Some(slot) = self.slots.get_mut(key)
            && slot.number == number
            && slot.hold.take().is_some()
        {
            slot.beats.ended(now);
        }
    }
}

impl Slot {
    fn new(now: Now) -> Self {
        let (beats, delay) = <(Beats, Delay)>::default();
        Self { beats, delay, armed: None, hold: None, number: 0, heard: now }
    }

    fn is_held(&self) -> bool {
        self.hold.as_ref().is_some_and(|hold| !hold.is_closed())
    }

    /// One renewal that waits renews as well as many.
    fn renew(&self) -> bool {
        let renewed = self.hold.as_ref().map(|hold| hold.try_send(()));
        matches!(renewed, Some(Ok(()) | Err(mpsc::error::TrySendError::Full(()))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::{Clock, ManualTime, Sleeps};

    const NONE: Accepted = Accepted(0);

    const fn ms(ms: u64) -> Now {
        Duration::from_millis(ms)
    }

    fn key(seat: impl ToString) -> Key {
        (seat.to_string(), SubsystemId::VERTICAL)
    }

    fn start(jogs: &mut Jogs, at: Now, seat: &str) -> (u64, mpsc::Receiver<()>) {
        let first = jogs.beat(at, key(seat), Toward::Max, Heard::default(), NONE);
        assert!(matches!(first, Turn::Said(MotionWord::Armed)), "{first:?}");
        match jogs.beat(at + ms(60), key(seat), Toward::Max, Heard::default(), NONE) {
            Turn::Start(number, beats) => (number, beats),
            said => panic!("{said:?}"),
        }
    }

    #[test]
    fn sessions_that_have_gone_are_forgotten_and_motions_are_not() {
        let mut jogs = Jogs::default();
        let (_, _beats) = start(&mut jogs, ms(0), "held");
        for number in 0..10_000_u64 {
            jogs.beat(ms(1000 * number), key(number), Toward::Max, Heard::default(), NONE);
        }
        assert!(jogs.slots.len() <= 62, "{}", jogs.slots.len());
        assert!(jogs.slots[&key("held")].hold.is_some());
    }

    #[test]
    fn beats_that_nobody_takes_do_not_pile_up() {
        let mut jogs = Jogs::default();
        let (_, mut beats) = start(&mut jogs, ms(0), "a");
        for number in 0..10_000 {
            let said =
                jogs.beat(ms(61 + number / 100), key("a"), Toward::Max, Heard::default(), NONE);
            assert!(matches!(said, Turn::Said(MotionWord::Moving)), "{said:?}");
        }
        assert_eq!((beats.len(), beats.try_recv()), (1, Ok(())));
        drop(beats);
        assert!(matches!(
            jogs.beat(ms(170), key("a"), Toward::Max, Heard::default(), NONE),
            Turn::Said(MotionWord::Ended)
        ));
    }

    #[test]
    fn the_end_of_an_earlier_motion_ends_no_later_one() {
        let mut jogs = Jogs::default();
        let (first, _first_beats) = start(&mut jogs, ms(0), "a");
        jogs.let_go("a");
        let (second, _beats) = start(&mut jogs, ms(200), "a");
        jogs.ended(ms(300), &key("a"), first);
        assert!(first != second && jogs.slots[&key("a")].hold.is_some());
        jogs.ended(ms(300), &key("a"), second);
        assert!(jogs.slots[&key("a")].hold.is_none());
        assert!(matches!(
            jogs.beat(ms(310), key("a"), Toward::Max, Heard::default(), NONE),
            Turn::Said(MotionWord::Ended)
        ));
    }

    #[test]
    fn a_clock_that_has_stood_still_is_learnt_anew_after_a_pause_and_lateness_is_said() {
        let mut jogs = Jogs::default();
        let beat = |jogs: &mut Jogs, at, sent_ms| {
            let heard = Heard { sent_ms: Some(sent_ms), ..Heard::default() };
            jogs.beat(ms(at), key("a"), Toward::Max, heard, NONE)
        };
        assert!(matches!(beat(&mut jogs, 0, 0.0), Turn::Said(MotionWord::Armed)));
        jogs.end(&key("a"));
        // It has slept for 5 s.
        assert!(matches!(beat(&mut jogs, 20_000, 15_000.0), Turn::Late));
        assert!(
            matches!(beat(&mut jogs, 79_900, 74_900.0), Turn::Late),
            "not heard for less than 60 s"
        );
        assert!(matches!(
            beat(&mut jogs, 139_900, 134_900.0),
            Turn::Said(MotionWord::Ended | MotionWord::Armed)
        ));
        let Turn::Start(_, held) = beat(&mut jogs, 139_960, 134_960.0) else { panic!("it begins") };
        // While a motion is held nothing is learnt again, however long nothing was heard.
        assert!(matches!(beat(&mut jogs, 239_960, 230_000.0), Turn::Said(MotionWord::Moving)));
        drop(held);
    }

    /// Assumed: the machine sleeps for five minutes, and the clocks of hub and client with it. The hand is off the control
    /// meanwhile, and its last beats come with the first ones of the next hold.
    #[test]
    fn beats_from_before_a_sleep_move_nothing() {
        let clock = ManualTime::at(1_000_000);
        let system = Clock::Manual(clock.clone());
        let sleeps = Sleeps::from_now(&system);
        let mut jogs = Jogs::default();
        let mut beat = |at: u64, sent_ms: f64| {
            let sleep = sleeps.look(ms(at), &system);
            let heard = Heard { sent_ms: Some(sent_ms), sleep, ..Heard::default() };
            jogs.beat(ms(at), key("a"), Toward::Max, heard, NONE)
        };
        assert!(matches!(beat(10_000, 0.0), Turn::Said(MotionWord::Armed)));
        clock.set_date(1_300_000);
        for (at, sent_ms) in [(10_061, 60.0), (10_062, 61.0)] {
            assert!(matches!(beat(at, sent_ms), Turn::Late), "{sent_ms} was sent before it");
        }
        // Awake for a while, and held again.
        assert!(matches!(beat(12_000, 2000.0), Turn::Said(MotionWord::Armed)));
        assert!(matches!(beat(12_060, 2060.0), Turn::Start(..)));
    }

    /// Another client stops the monitor between the first beat and the second.
    #[test]
    fn what_is_armed_before_a_stop_does_not_begin_after_it() {
        let mut jogs = Jogs::default();
        let mut beat = |at, accepted| {
            jogs.beat(ms(at), key("a"), Toward::Max, Heard::default(), Accepted(accepted))
        };
        assert!(matches!(beat(0, 7), Turn::Said(MotionWord::Armed)));
        for at in [60, 120, 400] {
            assert!(matches!(beat(at, 8), Turn::Said(MotionWord::Ended)), "the hand holds on");
        }
        // Released: it is asked for once more.
        assert!(matches!(beat(700, 8), Turn::Said(MotionWord::Armed)));
        let Turn::Start(_, _held) = beat(760, 8) else { panic!("it begins") };
        // A Stop ends what moves in the client of the monitor, which says so.
        assert!(matches!(beat(820, 9), Turn::Said(MotionWord::Moving)));
    }
}
