//! Who is on the bus: found by probes, dropped after silence, looked for again.

use std::collections::VecDeque;
use std::time::Duration;

use lafet_proto::bus::{CONSOLES, MONITORS, NetworkStatus};

use crate::session::Now;

/// Looks in a period at addresses nobody has ever answered at, while the bus is idle.
const IDLE_LOOKS: u32 = 10;

/// Somebody has come or gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// It answers.
    Appeared(u8),
    /// It has not answered as often as it was tried.
    Dropped(u8),
}

/// The addresses of a bus.
#[derive(Clone, Debug)]
pub struct Roster {
    present: NetworkStatus,
    /// Absent addresses in the order in which they are looked for, with the time from which on.
    absent: VecDeque<(u8, Now)>,
    /// The last look at an address nobody has ever answered at.
    looked: Now,
    again: Duration,
    known: NetworkStatus,
    changes: VecDeque<Change>,
}

impl Roster {
    /// Everybody absent; all are looked for at once, one after the other.
    pub fn new(addresses: impl Iterator<Item = u8>, again: Duration) -> Self {
        let valid = |address: &u8| MONITORS.contains(address) || CONSOLES.contains(address);
        Self {
            present: NetworkStatus::default(),
            absent: addresses.filter(valid).map(|address| (address, Now::ZERO)).collect(),
            looked: Now::ZERO,
            again,
            known: NetworkStatus::default(),
            changes: VecDeque::new(),
        }
    }

    /// Who answers.
    pub const fn present(&self) -> &NetworkStatus {
        &self.present
    }

    /// Whom to probe now.
    ///
    /// Those who were there are looked for once in each period. Of the addresses where nobody ever
    /// was, one is looked at in each period once all have been tried, so that an almost empty bus
    /// is not filled with probes; ten of them while the bus is idle.
    pub fn due(&mut self, now: Now, idle: bool) -> Option<u8> {
        let next_look = self.next_look(idle);
        let due = |(address, from): &(u8, Now)| {
            let first = *from == Now::ZERO;
            *from <= now && (first || self.known.contains(*address) || next_look <= now)
        };
        let at = self.absent.iter().position(due)?;
        let (address, from) = self.absent.remove(at)?;
        if from > Now::ZERO && !self.known.contains(address) {
            self.looked = now;
        }
        self.absent.push_back((address, now + self.again));
        Some(address)
    }

    fn next_look(&self, idle: bool) -> Now {
        self.looked + if idle { self.again / IDLE_LOOKS } else { self.again }
    }

    /// When [`Roster::due`] has somebody next.
    pub fn next_due(&self, idle: bool) -> Option<Now> {
        let next_look = self.next_look(idle);
        let when = |(address, from): &(u8, Now)| {
            let known = *from == Now::ZERO || self.known.contains(*address);
            if known { *from } else { (*from).max(next_look) }
        };
        self.absent.iter().map(when).min()
    }

    /// It answered.
    pub fn appeared(&mut self, address: u8) {
        let absent = self.absent.len();
        self.absent.retain(|(known, _)| *known != address);
        if self.absent.len() < absent {
            self.present.set(address, true);
            self.known.set(address, true);
            self.changes.push_back(Change::Appeared(address));
        }
    }

    /// It has not answered for too long.
    pub fn dropped(&mut self, address: u8, now: Now) {
        if self.present.contains(address) {
            self.present.set(address, false);
            self.absent.push_back((address, now + self.again));
            self.changes.push_back(Change::Dropped(address));
        }
    }

    /// The next change that has not been told yet.
    pub fn poll_change(&mut self) -> Option<Change> {
        self.changes.pop_front()
    }
}
