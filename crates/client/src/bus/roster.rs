//! Devices on the bus: found by probes, dropped when they stop answering, then probed again.

use std::collections::VecDeque;
use std::time::Duration;

use lafet_proto::bus::{CONSOLES, MONITORS, NetworkStatus};

use crate::session::Now;

/// Probes per period of addresses that have never answered, while the bus is idle.
const IDLE_LOOKS: u32 = 10;

/// A change of the devices on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The device at this address answers.
    Appeared(u8),
    /// The device at this address did not answer any try.
    Dropped(u8),
}

/// The addresses of a bus.
#[derive(Clone, Debug)]
pub struct Roster {
    present: NetworkStatus,
    /// Absent addresses in the order in which they are probed, with the earliest time.
    absent: VecDeque<(u8, Now)>,
    /// Time of the last probe of an address that has never answered.
    looked: Now,
    again: Duration,
    known: NetworkStatus,
    changes: VecDeque<Change>,
}

impl Roster {
    /// A roster without present devices; all addresses are due, one after the other.
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

    /// The addresses that answer.
    pub const fn present(&self) -> &NetworkStatus {
        &self.present
    }

    /// The address to probe now.
    ///
    /// Addresses that have answered before are probed once per period. Of those that never
    /// answered, one is probed per period once all have been tried, so that an almost empty bus is
    /// not filled with probes; ten while the bus is idle.
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

    /// Time of the next address from [`Roster::due`].
    pub fn next_due(&self, idle: bool) -> Option<Now> {
        let next_look = self.next_look(idle);
        let when = |(address, from): &(u8, Now)| {
            let known = *from == Now::ZERO || self.known.contains(*address);
            if known { *from } else { (*from).max(next_look) }
        };
        self.absent.iter().map(when).min()
    }

    /// Records that the address answered.
    pub fn appeared(&mut self, address: u8) {
        let absent = self.absent.len();
        self.absent.retain(|(known, _)| *known != address);
        if self.absent.len() < absent {
            self.present.set(address, true);
            self.known.set(address, true);
            self.changes.push_back(Change::Appeared(address));
        }
    }

    /// Records that the address no longer answers.
    pub fn dropped(&mut self, address: u8, now: Now) {
        if self.present.contains(address) {
            self.present.set(address, false);
            self.absent.push_back((address, now + self.again));
            self.changes.push_back(Change::Dropped(address));
        }
    }

    /// The next change that has not been reported.
    pub fn poll_change(&mut self) -> Option<Change> {
        self.changes.pop_front()
    }
}
