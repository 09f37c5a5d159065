//! What the host could not hear: values with the time at which they were so, bounded by their number and their age.

use std::collections::VecDeque;
use std::time::Duration;

use super::metrics::Cell;
use crate::plugs::mqtt::desk::Now;

/// A value that was so.
#[derive(Clone, Debug, PartialEq)]
pub struct Past {
    /// The device.
    pub device: usize,
    /// The place of its metric.
    pub row: usize,
    /// What it showed.
    pub cell: Cell,
    /// Since when, ms since 1970.
    pub at_ms: u64,
    /// When that was noted here.
    pub noted: Now,
}

/// What waits to be said.
#[derive(Debug)]
pub struct History {
    waiting: VecDeque<Past>,
    count: usize,
    age: Duration,
    dropped: u64,
}

impl History {
    /// So many values at most, of this age at most.
    pub const fn new(count: usize, age: Duration) -> Self {
        Self { waiting: VecDeque::new(), count, age, dropped: 0 }
    }

    /// Values that wait.
    pub fn waiting(&self) -> u64 {
        self.waiting.len() as u64
    }

    /// Values that were dropped since the start.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// One more; the oldest ones are dropped.
    pub fn push(&mut self, past: Past) {
        self.waiting.push_back(past);
        self.bound();
    }

    /// Those that were sent, and of which it is not known whether they have arrived. Some may be newer than those that wait.
    pub fn put_back(&mut self, sent: VecDeque<Past>) {
        let mut all = sent;
        all.append(&mut self.waiting);
        all.make_contiguous().sort_by_key(|it| it.noted);
        self.waiting = all;
        self.bound();
    }

    /// Time has passed.
    pub fn tick(&mut self, now: Now) {
        let before = self.waiting.len();
        while self.waiting.front().is_some_and(|it| now.saturating_sub(it.noted) > self.age) {
            self.waiting.pop_front();
        }
        self.dropped += (before - self.waiting.len()) as u64;
    }

    /// Takes the oldest ones of one device out, so many at most.
    pub fn take(&mut self, most: usize, is_there: impl Fn(usize) -> bool) -> Vec<Past> {
        let Some(first) = self.waiting.iter().position(|it| is_there(it.device)) else {
            return Vec::new();
        };
        let device = self.waiting.get(first).map(|it| it.device);
        let same = self.waiting.iter().skip(first).take(most);
        let count = same.take_while(|it| Some(it.device) == device).count();
        self.waiting.drain(first..first + count).collect()
    }

    fn bound(&mut self) {
        while self.waiting.len() > self.count {
            self.waiting.pop_front();
            self.dropped += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn past(device: usize, number: u64) -> Past {
        let noted = Duration::from_secs(number);
        Past { device, row: 0, cell: Cell::long(number), at_ms: number, noted }
    }

    #[test]
    fn the_oldest_are_dropped_and_counted() {
        let mut history = History::new(3, Duration::from_secs(10));
        (0..5).for_each(|number| history.push(past(0, number)));
        assert_eq!((history.waiting(), history.dropped()), (3, 2));
        history.tick(Duration::from_secs(12));
        assert_eq!((history.waiting(), history.dropped()), (3, 2), "of ten seconds at most");
        history.tick(Duration::from_secs(13));
        assert_eq!((history.waiting(), history.dropped()), (2, 3));
        let taken = history.take(10, |_| true);
        assert_eq!(taken, [past(0, 3), past(0, 4)]);
        history.push(past(0, 5));
        history.put_back(taken.into());
        assert_eq!(history.take(10, |_| true).first(), Some(&past(0, 3)), "the oldest come first");
        let mut none = History::new(0, Duration::from_secs(10));
        none.push(past(0, 0));
        assert_eq!((none.waiting(), none.dropped()), (0, 1));
    }

    /// A connection breaks while the host still hears what it has missed: what was sent meanwhile of the present is newer.
    #[test]
    fn what_is_put_back_has_its_place_by_its_time() {
        let mut history = History::new(3, Duration::from_secs(10));
        (1..4).for_each(|number| history.push(past(0, number)));
        let mut sent: VecDeque<Past> = history.take(1, |_| true).into();
        sent.push_back(past(0, 4));
        history.put_back(sent);
        assert_eq!((history.waiting(), history.dropped()), (3, 1), "the oldest is dropped");
        history.tick(Duration::from_secs(13));
        let left = history.take(9, |_| true);
        assert_eq!(left, [past(0, 3), past(0, 4)], "and what is too old, wherever it was");
    }

    #[test]
    fn those_of_a_device_that_is_lost_wait_for_it() {
        let mut history = History::new(10, Duration::from_secs(10));
        let all = [past(0, 0), past(1, 1), past(1, 2), past(0, 3)];
        all.into_iter().for_each(|it| history.push(it));
        assert_eq!(history.take(1, |device| device == 1), [past(1, 1)]);
        assert_eq!(history.take(9, |device| device == 1), [past(1, 2)]);
        assert_eq!(history.take(9, |device| device == 1), []);
        assert_eq!(history.take(9, |_| true), [past(0, 0), past(0, 3)]);
    }
}
