//! What overtakes: Stop, Close and Lockout on go out before everything that waits, are repeated
//! sooner, and remove what would undo them.

use std::time::Duration;

use super::operation::{Operation, Outstanding};
use super::{Now, Outcome, Session, Ticket, URGENT_MAX};
use crate::answers::RequestBuf;

/// The wait for the answer to an urgent frame doubles with each try, this often at most.
const DOUBLINGS_MAX: u32 = 6;

impl Session {
    /// Remembers an urgent request: what belongs to a batch begun before is later sent to nobody.
    pub(super) fn note_stop(&mut self, ticket: Ticket, requests: Vec<RequestBuf>) {
        if self.stops.len() >= URGENT_MAX {
            self.stops.pop_front();
        }
        self.stops.push_back((ticket, requests));
    }

    /// How long the answer to an operation is waited for that is about to be sent. An urgent one is
    /// repeated as soon as the bus controller would (observed: 150 ms, doubled each time), or twice
    /// the usual round trip: twice does no harm, and a lost Stop must not cost a second.
    pub(super) fn wait(&self, operation: &Operation) -> Duration {
        if !operation.is_urgent() {
            return self.config.timeout;
        }
        let usual = self.stats.rtt_average.unwrap_or_default() * 2;
        let first = self.config.patience.max(usual);
        (first * (1 << operation.tries.min(DOUBLINGS_MAX))).min(self.config.timeout)
    }

    /// Whether an operation without answer is to be sent once more.
    pub(super) fn may_try_again(&self, now: Now, operation: &Operation) -> bool {
        if operation.is_urgent() {
            let all = self.config.timeout * self.config.tries;
            return operation.first_sent.is_none_or(|first| now < first + all);
        }
        let left = operation.tries < self.config.tries;
        operation.is_repeatable() && left && !operation.cancelled
    }

    /// Takes what would undo an urgent operation out of the queue: anything that waits when
    /// `newest` is that urgent operation itself, or only `newest`, which continues a batch that
    /// was begun at `since`.
    pub(super) fn supersede(&mut self, newest: Ticket, since: Option<Ticket>) {
        let Some(since) = since else { return };
        let stops = self.stops.iter().filter(|(ticket, _)| *ticket >= since);
        let stops: Vec<&RequestBuf> = stops.flat_map(|(_, requests)| requests).collect();
        let outcomes = &mut self.outcomes;
        self.queue.retain(|operation| {
            let concerned = newest == since || operation.ticket == newest;
            let by = stops.iter().find(|stop| {
                concerned && operation.requests.iter().any(|other| stop.supersedes(other))
            });
            let Some(by) = by else { return true };
            let outcome = Outcome::Superseded { by: by.id(), sent: operation.sent };
            outcomes.push_back((operation.ticket, outcome));
            false
        });
    }

    pub(super) fn can_be_overtaken(&self, outstanding: &Outstanding) -> bool {
        let Some(urgent) = self.urgent.front() else { return false };
        let blind = outstanding.sent < outstanding.believe_from;
        !outstanding.operation.is_urgent() || (blind && !urgent.sent)
    }

    /// An urgent operation takes the place of one that is out without answer for too long.
    pub(super) fn overtake(&mut self, now: Now) {
        let Some(outstanding) = self.outstanding.take() else { return };
        let patience = outstanding.due || now >= outstanding.sent + self.config.patience;
        if !patience || !self.can_be_overtaken(&outstanding) {
            self.outstanding = Some(outstanding);
            return;
        }
        let Outstanding { operation, .. } = self.give_up(outstanding);
        if operation.is_urgent() {
            self.urgent.push_back(operation);
        } else if operation.is_repeatable() || !operation.sent {
            self.queue.push_front(operation);
        } else if let Some(by) = self.urgent.front().and_then(Operation::first) {
            self.outcomes.push_back((operation.ticket, Outcome::Superseded { by, sent: true }));
        }
    }

    /// Takes out of the queue what nobody wants any more at this time. What waits there and has been
    /// sent before is a read.
    pub(super) fn drop_expired(&mut self, now: Now) {
        let outcomes = &mut self.outcomes;
        self.queue.retain(|operation| {
            let alive = operation.expires.is_none_or(|expires| now < expires);
            if !alive {
                outcomes.push_back((operation.ticket, Outcome::Expired));
            }
            alive
        });
    }
}
