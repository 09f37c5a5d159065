//! Which requests read what the detectors of a bus need, and whose turn it is.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use super::wire::{Request, Table};
use crate::control::authority::Now;

/// A device that has not answered so often in a row is asked less often.
const SILENT: u32 = 3;
/// Pauses before it is asked again: the first, and the longest.
const AGAIN_FIRST: Duration = Duration::from_secs(1);
const AGAIN_LAST: Duration = Duration::from_secs(10);
/// Asking devices that do not answer takes at most one part of so many of the time: while they are
/// tried again at once, and later.
const SHARE_FIRST: u32 = 2;
const SHARE_LATER: u32 = 10;

/// The requests of each device, of neighbouring values at once.
pub fn requests(needs: &BTreeSet<(u8, Table, u16)>) -> BTreeMap<u8, Vec<Request>> {
    let mut all: BTreeMap<u8, Vec<Request>> = BTreeMap::new();
    for &(unit, table, address) in needs {
        let of_unit = all.entry(unit).or_default();
        match of_unit.last_mut() {
            Some(last)
                if last.table == table
                    && u32::from(last.first) + u32::from(last.count) == u32::from(address)
                    && last.count < table.most() =>
            {
                last.count += 1;
            }
            _ => of_unit.push(Request { unit, table, first: address, count: 1 }),
        }
    }
    all
}

/// A device of a bus.
#[derive(Clone, Debug)]
struct Turn {
    unit: u8,
    due: Now,
    /// Times in a row that it has not answered.
    silent: u32,
}

/// Whose turn it is: who waits longest. Devices that do not answer cost the others little.
#[derive(Clone, Debug)]
pub struct Turns {
    period: Duration,
    turns: Vec<Turn>,
    /// No device that does not answer is asked before.
    probe: Now,
}

impl Turns {
    /// All devices are due.
    pub fn new(period: Duration, units: impl Iterator<Item = u8>) -> Self {
        let turns = units.map(|unit| Turn { unit, due: Now::ZERO, silent: 0 });
        Self { period, turns: turns.collect(), probe: Now::ZERO }
    }

    /// All devices are due again, on a new connection.
    pub fn restart(&mut self) {
        self.turns.iter_mut().for_each(|turn| turn.due = Now::ZERO);
    }

    /// The next device, and when it is due; `None` without devices.
    pub fn next(&self) -> Option<(u8, Now)> {
        let due = |turn: &Turn| match turn.silent {
            0 => (turn.due, turn.due, turn.unit),
            _ => (turn.due.max(self.probe), turn.due, turn.unit),
        };
        self.turns.iter().map(due).min().map(|(at, _, unit)| (unit, at))
    }

    /// A device was asked, from one time to another.
    pub fn asked(&mut self, unit: u8, from: Now, to: Now, answered: bool) {
        let Some(turn) = self.turns.iter_mut().find(|it| it.unit == unit) else { return };
        // The read that confirms the first one after a break comes a whole period later.
        let first = turn.silent > 0 || turn.due == Now::ZERO;
        turn.silent = if answered { 0 } else { turn.silent.saturating_add(1) };
        let took = to.saturating_sub(from);
        match turn.silent {
            0 if first => turn.due = from + self.period,
            0 => turn.due = (turn.due + self.period).max(from),
            1..SILENT => {
                turn.due = (turn.due + self.period).max(from);
                self.probe = to + took * (SHARE_FIRST - 1);
            }
            many => {
                let doubled = AGAIN_FIRST.saturating_mul(1 << (many - SILENT).min(8));
                turn.due = to + doubled.min(AGAIN_LAST);
                self.probe = to + took * (SHARE_LATER - 1);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_read_at_once_and_nothing_else() {
        let mut needs: BTreeSet<_> = (8..=21).map(|it| (1, Table::Holding, it)).collect();
        needs.extend([(1, Table::Holding, 23), (2, Table::Holding, 24), (1, Table::Input, 22)]);
        needs.extend([(1, Table::Holding, 65535), (1, Table::Input, 0)]);
        needs.extend((1000..1300).map(|it| (3, Table::Holding, it)));
        needs.extend((0..2001).map(|it| (3, Table::Coil, it)));
        let found = requests(&needs);
        let shape = |unit| -> Vec<(Table, u16, u16)> {
            found[&unit].iter().map(|it| (it.table, it.first, it.count)).collect()
        };
        let (holding, input) = (Table::Holding, Table::Input);
        assert_eq!(
            shape(1),
            [
                (holding, 8, 14),
                (holding, 23, 1),
                (holding, 65535, 1),
                (input, 0, 1),
                (input, 22, 1)
            ]
        );
        assert_eq!(shape(2), [(holding, 24, 1)]);
        assert_eq!(
            shape(3),
            [
                (Table::Coil, 0, 2000),
                (Table::Coil, 2000, 1),
                (holding, 1000, 125),
                (holding, 1125, 125),
                (holding, 1250, 50)
            ]
        );
    }

    /// Asks for a time; an answer takes 10 ms, silence the timeout of 500 ms. Times asked by unit.
    fn polled(units: u8, silent: impl Fn(u8) -> bool, seconds: u64) -> BTreeMap<u8, Vec<Now>> {
        let mut turns = Turns::new(Duration::from_millis(200), 1..=units);
        let (mut now, mut asked) = (Now::ZERO, BTreeMap::<u8, Vec<Now>>::new());
        while now < Duration::from_secs(seconds) {
            let (unit, at) = turns.next().unwrap();
            now = now.max(at);
            let took = if silent(unit) { 500 } else { 10 };
            let to = now + Duration::from_millis(took);
            asked.entry(unit).or_default().push(now);
            turns.asked(unit, now, to, !silent(unit));
            now = to;
        }
        asked
    }

    #[test]
    fn who_answers_is_asked_at_the_same_rate() {
        let asked = polled(5, |_| false, 10);
        assert!(asked.values().all(|it| (49..=51).contains(&it.len())), "{asked:?}");
    }

    #[test]
    fn who_does_not_answer_costs_the_others_little() {
        let asked = polled(20, |unit| unit > 2, 300);
        for unit in [1, 2] {
            let asked = &asked[&unit];
            // Once all were asked (9 s), half of the time is left; after the first tries 90 %.
            let mut gaps = asked.windows(2).filter(|it| it[0].as_secs() >= 10);
            assert!(gaps.all(|it| it[1] - it[0] <= Duration::from_millis(700)), "{unit}");
            let late = asked.iter().filter(|it| it.as_secs() >= 60).count();
            assert!(late >= 1000, "{unit}: {late} of 1200");
        }
        for unit in 3..=20 {
            let late = asked[&unit].iter().filter(|it| it.as_secs() >= 60).count();
            assert!((2..=4).contains(&late), "{unit}: {late}");
        }
    }

    #[test]
    fn one_that_answers_again_is_asked_as_before() {
        let mut turns = Turns::new(Duration::from_millis(200), 1..=1);
        let ms = Duration::from_millis;
        for at in [0, 1000, 2000] {
            turns.asked(1, ms(at), ms(at + 500), false);
        }
        let (_, at) = turns.next().unwrap();
        assert!(at >= ms(2500 + 4500), "{at:?}");
        turns.asked(1, at, at + ms(10), true);
        assert_eq!(turns.next(), Some((1, at + ms(200))));
        turns.restart();
        assert_eq!(turns.next(), Some((1, Now::ZERO)));
    }
}
