//! What a connection may take, and what is left of it for the next one of the same client: closing
//! and connecting again buys nothing.

use std::collections::{HashMap, VecDeque};
use std::hash::Hash;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::access::Bucket;

/// A moment: time since the hub's start.
type Now = Duration;

/// Readings of a connection: so many at once, so many a second.
pub const READINGS: (f64, f64) = (50.0, 25.0);
/// And of all connections of an address beyond that.
pub const SHARED: (f64, f64) = (2000.0, 1000.0);
/// Requests of a connection: so many at once, so many a second; what is over is answered later.
const REQUESTS: (f64, f64) = (200.0, 50.0);
/// Messages of a WebSocket: so many at once, so many a second.
const MESSAGES: (f64, f64) = (400.0, 200.0);
/// Stop, Close and Lockout of a WebSocket. Each is carried out at once; more of them only make its
/// next message wait.
const URGENT: (f64, f64) = (50.0, 50.0);
/// After this time nothing is missing of any allowance.
const FULL: Duration = Duration::from_secs(4);
/// Allowances that are kept. An address leaves no more of them than it had connections at a time.
const KEPT_MAX: usize = 4096;
/// How often what is full again is looked for when there are so many.
const SWEEP: Duration = Duration::from_secs(1);

/// An allowance that several look at.
pub type Shared = Arc<Mutex<Bucket>>;

fn bucket(now: Now, (most, per_s): (f64, f64)) -> Shared {
    Arc::new(Mutex::new(Bucket::new(now, most, per_s)))
}

/// The allowance of a connection.
#[derive(Clone, Debug)]
pub struct Allowance {
    /// Bytes and pieces it may read.
    pub readings: Shared,
    /// Requests it may make.
    pub requests: Shared,
    /// The readings that its address shares; `None`: a proxy of ours, behind which there are many.
    pub shared: Option<Shared>,
}

impl Allowance {
    /// A full one; `shared` with others.
    pub fn new(now: Now, shared: Option<Shared>) -> Self {
        Self { readings: bucket(now, READINGS), requests: bucket(now, REQUESTS), shared }
    }

    /// What an address shares, full.
    pub fn of_address(now: Now) -> Shared {
        bucket(now, SHARED)
    }
}

/// The allowance of a WebSocket.
#[derive(Clone, Debug)]
pub struct Talk {
    /// Messages it may send.
    pub messages: Shared,
    /// Stop, Close and Lockout it may send.
    pub urgent: Shared,
}

impl Talk {
    /// A full allowance.
    pub fn new(now: Now) -> Self {
        Self { messages: bucket(now, MESSAGES), urgent: bucket(now, URGENT) }
    }
}

/// What connections have left of their allowances, until these would be full again.
#[derive(Debug)]
pub struct Kept<K, A> {
    all: HashMap<K, VecDeque<(Now, A)>>,
    count: usize,
    swept: Now,
}

impl<K, A> Default for Kept<K, A> {
    fn default() -> Self {
        Self { all: HashMap::new(), count: 0, swept: Now::ZERO }
    }
}

impl<K: Eq + Hash, A> Kept<K, A> {
    /// What a client has left longest ago, if that may not be full yet.
    pub fn take(&mut self, now: Now, key: &K) -> Option<A> {
        let left = self.all.get_mut(key)?;
        let before = left.len();
        while left.front().is_some_and(|(at, _)| is_full(*at, now)) {
            left.pop_front();
        }
        let taken = left.pop_front();
        self.count -= before - left.len();
        if left.is_empty() {
            self.all.remove(key);
        }
        Some(taken?.1)
    }

    /// Keeps what a client has left.
    pub fn put(&mut self, now: Now, key: K, allowance: A) {
        if self.count >= KEPT_MAX && now >= self.swept + SWEEP {
            self.swept = now;
            self.all.retain(|_, left| {
                left.retain(|(at, _)| !is_full(*at, now));
                !left.is_empty()
            });
            self.count = self.all.values().map(VecDeque::len).sum();
        }
        if self.count < KEPT_MAX {
            self.all.entry(key).or_default().push_back((now, allowance));
            self.count += 1;
        }
    }
}

fn is_full(left: Now, now: Now) -> bool {
    now.saturating_sub(left) >= FULL
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sync::lock;

    const S: Duration = Duration::from_secs(1);

    #[test]
    fn what_is_left_is_taken_again_once_and_forgotten_when_full() {
        let mut kept = Kept::<&str, u32>::default();
        kept.put(S, "a", 1);
        kept.put(2 * S, "a", 2);
        kept.put(2 * S, "b", 3);
        assert_eq!(kept.take(2 * S, &"c"), None);
        assert_eq!((kept.take(3 * S, &"a"), kept.take(3 * S, &"a")), (Some(1), Some(2)));
        assert_eq!(kept.take(3 * S, &"a"), None);
        assert_eq!(kept.take(2 * S + FULL, &"b"), None);
        assert_eq!((kept.count, kept.all.len()), (0, 0));
    }

    /// Assumed of [`FULL`]: after this wait a client has no less than with a new one.
    #[test]
    fn everything_is_full_in_time() {
        let (own, talk) = (Allowance::new(Now::ZERO, None), Talk::new(Now::ZERO));
        let shared = Allowance::of_address(Now::ZERO);
        assert_eq!(lock(&own.readings).owe(Now::ZERO, 1e9), Some(FULL / 2), "to owe nothing");
        assert_eq!(lock(&own.readings).take_so_many(FULL, READINGS.0), Ok(()));
        let own = Allowance::new(Now::ZERO, None);
        for bucket in [own.readings, own.requests, shared, talk.messages, talk.urgent] {
            let take = |now| (0..10_000).filter(|_| lock(&bucket).take(now).is_ok()).count();
            let all = take(Now::ZERO);
            assert_eq!(take(FULL), all);
        }
    }

    #[test]
    fn the_table_is_bounded_and_makes_room_again() {
        let mut kept = Kept::<usize, ()>::default();
        (0..2 * KEPT_MAX).for_each(|key| kept.put(S, key, ()));
        assert_eq!((kept.count, kept.all.len()), (KEPT_MAX, KEPT_MAX));
        assert!(kept.take(S, &1).is_some() && kept.take(S, &(KEPT_MAX + 1)).is_none());
        kept.put(S + FULL, KEPT_MAX, ());
        kept.put(S + FULL, KEPT_MAX + 1, ());
        assert_eq!(kept.count, 2);
        assert!(kept.take(S + FULL, &(KEPT_MAX + 1)).is_some());
    }
}
