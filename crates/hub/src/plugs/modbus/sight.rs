//! What a master sees of the monitors: words made from their states. No I/O, no clock.

use std::time::Duration;

use lafet_proto::SubsystemId;

use super::layout::{
    AXES, DETAIL_LEN, DETAILED, HEADER_LEN, MONITORS, NAME_LEN, SUMMARY_LEN, UNKNOWN,
    UNKNOWN_SIGNED, halves,
};
use crate::alarms::Priority;
use crate::monitor::status::Status;
pub use crate::plugs::sight::{Control, Holder, Known, Tally};
use crate::plugs::sight::{is_faulty, mode};

/// A monitor in words.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// Who holds it.
    pub holder: Holder,
    /// The summary.
    pub words: [u16; SUMMARY_LEN],
    /// The state bit by bit.
    pub detail: [u16; DETAIL_LEN],
    /// Its id.
    pub name: [u16; NAME_LEN],
}

/// What a unit shows.
#[derive(Clone, Debug, Default)]
pub struct Sight {
    /// Version of the map, sign of life, number of monitors, state of the site.
    pub header: [u16; HEADER_LEN],
    /// The monitors, at most [`MONITORS`].
    pub monitors: Vec<Seen>,
}

/// Bits of the quality word.
pub mod quality {
    /// The state is fresh, and there is a connection.
    pub const GOOD: u16 = 1;
    /// The state is not the present one.
    pub const STALE: u16 = 1 << 1;
    /// There is no connection.
    pub const DOWN: u16 = 1 << 2;
    /// Nothing was heard since the start of the hub.
    pub const NEVER: u16 = 1 << 3;
    /// The traverse is not known; the next bits: elevation, nozzle, pressure, flow, valves, voltage.
    pub const TRAVERSE: u16 = 1 << 4;
    /// Bit of the pressure.
    pub const PRESSURE: u16 = 1 << 7;
    /// Bit of the flow.
    pub const FLOW: u16 = 1 << 8;
    /// Bit of the voltage.
    pub const VOLTAGE: u16 = 1 << 10;
}

impl Tally {
    /// The word: the worst priority, and the number of alarms.
    pub fn word(&self) -> u16 {
        let worst = match self.worst {
            None => 0,
            Some(Priority::Fire) => 1,
            Some(Priority::High) => 2,
            Some(Priority::Medium) => 3,
            Some(Priority::Low) => 4,
        };
        worst << 8 | self.count.min(255)
    }
}

impl Control {
    fn word(self) -> u16 {
        let who = match self.holder {
            Holder::Free => 0,
            Holder::Mine => 1,
            Holder::Other => 2,
        };
        who | bit(8, self.lost) | bit(9, self.asked) | bit(10, self.asks)
    }
}

const fn bit(number: u32, set: bool) -> u16 {
    if set { 1 << number } else { 0 }
}

/// A value with the quality bit that is set when it is not known.
struct Values(u16);

impl Values {
    fn take(&mut self, flag: u16, unknown: u16, value: Option<i64>) -> u16 {
        let value = value.and_then(|it| match unknown {
            UNKNOWN_SIGNED => i16::try_from(it).ok().map(i16::cast_unsigned),
            _ => u16::try_from(it).ok(),
        });
        match value.filter(|it| *it != unknown) {
            Some(word) => word,
            None => {
                self.0 |= flag;
                unknown
            }
        }
    }
}

impl Seen {
    /// The words of a monitor.
    pub fn new(name: [u16; NAME_LEN], known: &Known<'_>) -> Self {
        let status = known.status;
        let fresh = known.is_fresh();
        let mut values = Values(0);
        let position = |axis: SubsystemId| {
            let position = status.position(axis).filter(|_| fresh)?;
            // Arc-minutes to tenths of a degree; the nozzle is in mm.
            Some(if axis == SubsystemId::NOZZLE { position } else { tenths(position) })
        };
        let [horizontal, vertical, nozzle] = std::array::from_fn(|at| {
            values.take(quality::TRAVERSE << at, UNKNOWN_SIGNED, position(AXES[at]))
        });
        let general = |field| status.valid(SubsystemId::GENERAL, field).filter(|_| fresh);
        let pressure = values.take(quality::PRESSURE, UNKNOWN, general("pressure"));
        let flow = values.take(quality::FLOW, UNKNOWN, general("flowrate"));
        let voltage = values.take(quality::VOLTAGE, UNKNOWN, general("main_voltage"));
        let valves = valves(status, fresh);
        let bad = values.0 | bit(9, valves & 0x8080 != 0 || valves & 0x4040 == 0);
        let quality = bit(0, fresh) | bit(1, !fresh) | bit(2, !known.up);
        let quality = quality | bit(3, known.age.is_none()) | bad;
        let age = age_word(known.age);
        let words = [
            quality,
            age,
            if fresh { mode(status).0 } else { 0 },
            known.control.word(),
            horizontal,
            vertical,
            nozzle,
            pressure,
            flow,
            valves,
            fire(status, fresh, known.alarms),
            known.alarms.word(),
            state(status, fresh, known),
            motion(status, fresh),
            voltage,
        ];
        let detail = detail(status, fresh, quality, age);
        Self { holder: known.control.holder, words, detail, name }
    }
}

impl Sight {
    /// The summary, detail or name of each monitor, in a row; what is not there is zero.
    pub fn row<const N: usize>(&self, part: impl Fn(&Seen) -> [u16; N]) -> Vec<u16> {
        let each = (0..MONITORS).map(|at| self.monitors.get(at).map_or([0; N], &part));
        each.flatten().collect()
    }
}

/// Milliseconds, at most one less than what is not known.
fn age_word(age: Option<Duration>) -> u16 {
    let ms = age.map(|age| u16::try_from(age.as_millis()).unwrap_or(UNKNOWN).min(UNKNOWN - 1));
    ms.unwrap_or(UNKNOWN)
}

/// To the nearest tenth of a degree.
const fn tenths(arcmin: i64) -> i64 {
    (arcmin + 3 * arcmin.signum()) / 6
}

/// A byte for each valve: open, closed, opening, closing, blocked, fault, there, not known.
fn valves(status: &Status, fresh: bool) -> u16 {
    let one = |valve: SubsystemId| {
        if status.bits(valve).is_none() {
            return 0;
        }
        if !fresh {
            return 1 << 6 | 1 << 7;
        }
        let is_set = |number, flag| bit(number, status.is_set(valve, flag));
        let fault = is_faulty(status, valve);
        let moves = is_set(0, "Open") | is_set(1, "Closed") | is_set(2, "Opening");
        moves | is_set(3, "Closing") | is_set(4, "Blocked") | bit(5, fault) | 1 << 6
    };
    one(SubsystemId::VALVE1) | one(SubsystemId::VALVE2) << 8
}

fn fire(status: &Status, fresh: bool, alarms: Tally) -> u16 {
    let seen = fresh && status.is_set(SubsystemId::DETECTOR, "Found");
    bit(0, seen) | bit(1, alarms.fire) | bit(15, !fresh)
}

fn state(status: &Status, fresh: bool, known: &Known<'_>) -> u16 {
    let locked = fresh && status.is_set(SubsystemId::GENERAL, "LockedOut");
    let flows = !fresh || status.flows();
    bit(0, fresh && known.ready)
        | bit(1, locked)
        | bit(2, flows)
        | bit(3, known.alarms.waiting > 0)
        | bit(15, !fresh)
}

/// Three bits for each drive: it moves, is at its lower limit, at its upper limit.
fn motion(status: &Status, fresh: bool) -> u16 {
    if !fresh {
        return 1 << 15;
    }
    let of = |(at, axis): (u32, SubsystemId)| {
        let is_set = |number, flag| bit(3 * at + number, status.is_set(axis, flag));
        is_set(0, "Move") | is_set(1, "MinLimitReached") | is_set(2, "MaxLimitReached")
    };
    (0..).zip(AXES).map(of).fold(0, |word, bits| word | bits)
}

/// The status words; all ones of a subsystem that is not there or not known.
fn detail(status: &Status, fresh: bool, quality: u16, age: u16) -> [u16; DETAIL_LEN] {
    let mut words = [quality, age].into_iter().chain(
        DETAILED
            .into_iter()
            .flat_map(|id| halves(status.bits(id).filter(|_| fresh).unwrap_or(u32::MAX))),
    );
    std::array::from_fn(|_| words.next().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::alarms::State;
    use crate::monitor::status::Subsystem;
    use crate::plugs::sight::fixture::status;

    fn seen(status: &Status, age: Option<u64>, up: bool) -> Seen {
        let control = Control { holder: Holder::Mine, ..Control::default() };
        let mut alarms = Tally::default();
        alarms.add(Priority::Medium, State::Ack);
        alarms.add(Priority::High, State::Unack);
        alarms.add(Priority::Fire, State::Shelved);
        let age = age.map(Duration::from_millis);
        Seen::new([0; NAME_LEN], &Known { status, age, up, ready: true, control, alarms })
    }

    #[test]
    fn a_fresh_state_is_in_its_units() {
        let it = seen(&status(), Some(40), true);
        let signed = |at: usize| it.words[at].cast_signed();
        assert_eq!((it.words[0], it.words[1], it.words[3]), (quality::GOOD, 40, 1));
        assert_eq!((signed(4), signed(5), signed(6)), (-101, 201, 60));
        assert_eq!(it.words[7..=9], [80, 20, 1 | 1 << 6]);
        assert_eq!(it.words[11], 2 << 8 | 2, "a shelved alarm is not counted");
        assert_eq!(it.words[12], 1 | 1 << 2 | 1 << 3, "ready, water, an alarm waits");
        assert_eq!(it.words[13], 1 | 1 << 5, "the traverse moves, the elevation is at its end");
        assert_eq!((it.words[14], it.detail[4..6].to_vec()), (24, vec![1, 0]));
        assert_eq!(it.detail[18..20], [0xFFFF; 2], "it has no deployer");
    }

    /// A value that is not the present one is never shown as good: neither the numbers nor the bits.
    #[test]
    fn what_is_stale_or_bad_is_marked() {
        let stale = Status { stale: true, ..status() };
        for it in [seen(&stale, Some(900), true), seen(&status(), Some(40), false)] {
            assert_eq!(it.words[0] & (quality::GOOD | quality::STALE), quality::STALE);
            assert_eq!(it.words[0] & 0x07F0, 0x07F0, "every value is marked");
            assert_eq!(it.words[4..=8], [0x8000, 0x8000, 0x8000, 0xFFFF, 0xFFFF]);
            assert_eq!((it.words[2], it.words[9]), (0, 1 << 6 | 1 << 7));
            assert_eq!((it.words[10], it.words[13]), (1 << 15, 1 << 15));
            assert_eq!(it.words[12], 1 << 2 | 1 << 3 | 1 << 15, "water may flow");
            assert!(it.detail[2..].iter().all(|word| *word == 0xFFFF));
        }
        let mut faulty = status();
        let mut general = Subsystem::clone(&faulty.subsystems["General"]);
        general.set_bits(SubsystemId::GENERAL, 1 << 16);
        faulty.subsystems.insert("General", Arc::new(general));
        let it = seen(&faulty, Some(1), true);
        assert_eq!(it.words[0], quality::GOOD | quality::PRESSURE);
        assert_eq!((it.words[7], it.words[8]), (0xFFFF, 20));
    }

    #[test]
    fn ages_saturate_and_one_that_was_never_heard_has_none() {
        let age = |ms| seen(&status(), ms, true).words[1];
        assert_eq!([age(Some(65_534)), age(Some(1 << 40)), age(None)], [65_534, 65_534, 65_535]);
        let never = seen(&Status::default(), None, true);
        assert_eq!(never.words[0] & 0xF, quality::STALE | quality::NEVER);
    }

    #[test]
    fn modes_have_an_order() {
        let mut status = status();
        assert_eq!(seen(&status, Some(1), true).words[2], 6);
        let set = |status: &mut Status, id: SubsystemId, bits: u32| {
            let mut state = Subsystem::default();
            state.set_bits(id, bits);
            status.subsystems.insert(id.name().unwrap(), Arc::new(state));
        };
        set(&mut status, SubsystemId::CONTROL, 0);
        assert_eq!(seen(&status, Some(1), true).words[2], 4);
        set(&mut status, SubsystemId::DEPLOYER, 1 << 30);
        assert_eq!(seen(&status, Some(1), true).words[2], 1);
        set(&mut status, SubsystemId::GENERAL, 1 << 18);
        assert_eq!(seen(&status, Some(1), true).words[2], 9);
    }
}
