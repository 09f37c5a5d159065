//! Urgent operations: Stop, Close and Lockout on are sent before waiting ones, repeated sooner, and
//! cancel those that would reverse them.

use std::time::Duration;

use super::medium::Role;
use super::operation::{Haste, Operation, Outstanding};
use super::unanswered::ends_with_others;
use super::{Now, Outcome, Session, Ticket, URGENT_MAX};
use crate::answers::{RequestBuf, Requests};

/// Consecutive frames without answer after which a monitor counts as absent.
const ABSENT_MISSES: u32 = 2;
/// Margin for an absent monitor over the usual round trip of the others.
const ABSENT_SPARE: Duration = Duration::from_millis(40);
/// Repetitions of what is urgent, for absent monitors, take one part in this many of the line's
/// time, if others want the rest.
const REPEATED_SHARE: u32 = 4;
/// Margin for a monitor that answers over twice the usual round trip.
const PRESENT_SPARE: Duration = Duration::from_millis(100);
/// The shortest wait for the answer to the renewal of a held motion.
const RENEWAL_LEAST: Duration = Duration::from_millis(50);
/// Margin of a renewal over twice the usual round trip.
const RENEWAL_SPARE: Duration = Duration::from_millis(20);
/// The wait for the answer to an urgent frame doubles with each try, at most this often.
const DOUBLINGS_MAX: u32 = 6;

impl Session {
    /// Remembers an urgent request: frames of a batch that was started before it are not sent.
    pub(super) fn note_stop(&mut self, ticket: Ticket, requests: Requests) {
        if self.stops.len() >= URGENT_MAX {
            self.stops.pop_front();
        }
        self.stops.push_back((ticket, requests));
    }

    /// Time to wait for the answer to an operation that is about to be sent. An urgent one is
    /// repeated as soon as a bus controller would (observed: 150 ms, doubled each time), or after
    /// twice the usual round trip: repetitions do no harm, and a lost Stop must not cost a second.
    pub(super) fn wait(&self, now: Now, outstanding: &Outstanding) -> Duration {
        let operation = &outstanding.operation;
        if !operation.is_urgent() {
            // A lost renewal must be sent again while the motion still lasts.
            let renews = operation.is_held() && operation.is_repeatable();
            return if renews {
                self.wait_of_renewal()
            } else {
                self.wait_beside_others(operation)
            };
        }
        self.wait_urgently(now, outstanding)
    }

    #[cold]
    fn wait_urgently(&self, now: Now, outstanding: &Outstanding) -> Duration {
        let operation = &outstanding.operation;
        let usual = self.stats.rtt_average.unwrap_or_default() * 2;
        let first = self.config.patience.max(usual);
        let wait = (first * (1 << operation.tries.min(DOUBLINGS_MAX))).min(self.config.timeout);
        let Some(taken) = self.wait_in_vain(operation) else { return wait };
        // Where it had to wait for others, the next try is not later for that.
        let due = if outstanding.tries == 0 { now } else { outstanding.deadline };
        (due + wait).max(now + taken).saturating_sub(now)
    }

    /// If other monitors answer, a read does not occupy the line longer than an answer can take.
    fn wait_beside_others(&self, operation: &Operation) -> Duration {
        let Some(others) = self.others.filter(|_| operation.is_repeatable()) else {
            return self.config.timeout;
        };
        let wait = match (self.is_absent(), self.stats.rtt_average) {
            (true, _) => self.answer_of_absent(others),
            (false, own) => others.max(own.unwrap_or_default()) * 2 + PRESENT_SPARE,
        };
        wait.min(self.config.timeout)
    }

    /// How long an urgent frame takes the line if its monitor is absent: no longer than a read,
    /// though an answer to it is awaited until the next try.
    pub(super) fn wait_in_vain(&self, operation: &Operation) -> Option<Duration> {
        if operation.is_urgent() { self.taken_in_vain() } else { None }
    }

    #[cold]
    fn taken_in_vain(&self) -> Option<Duration> {
        let others = self.others.filter(|_| self.is_absent())?;
        Some(self.answer_of_absent(others).min(self.config.timeout))
    }

    /// How long the answer of an absent monitor may take. That of one that is slower than the others must not meet a
    /// frame of theirs.
    fn answer_of_absent(&self, others: Duration) -> Duration {
        others.max(self.stats.rtt_average.unwrap_or_default()) + ABSENT_SPARE
    }

    /// Whether the next frame repeats what is urgent, for a monitor that does not answer while
    /// others on the line do.
    pub(super) fn repeats_in_vain(&self) -> bool {
        if !self.is_absent() || self.others.is_none() {
            return false;
        }
        let waiting = self.urgent.front();
        let repeats = |it: &Operation| it.is_urgent() && it.sent;
        // A later one overtakes the repetition that is due.
        let next = self.outstanding.as_ref().map(|outstanding| &outstanding.operation).or(waiting);
        next.is_some_and(repeats) && waiting.is_none_or(repeats)
    }

    /// Time until the next repetition, from an urgent frame on that has just been sent to one of so
    /// many absent monitors: short enough for as many tries as without others, or where they are
    /// several, for one of each within the timeout; the others have half of the line at least.
    pub(super) fn rest_in_vain(&self, many: usize) -> Option<Duration> {
        let outstanding = self.outstanding.as_ref()?;
        let taken = self.wait_in_vain(&outstanding.operation)?;
        let rest = (taken * REPEATED_SHARE).min(self.config.timeout / 2);
        let each = self.config.timeout / u32::try_from(many.max(1)).unwrap_or(u32::MAX);
        Some(rest.min(each.max(taken * 2)))
    }

    /// Since when an urgent frame waits to be sent.
    pub(super) fn urgent_since(&self) -> Option<Now> {
        let due = self.outstanding.as_ref().filter(|it| it.due && it.operation.is_urgent());
        let again = due.map(|it| if it.tries == 0 { it.operation.submitted } else { it.deadline });
        again.or_else(|| self.urgent.front().map(|operation| operation.submitted))
    }

    /// Whether the last frames were not answered.
    pub(super) const fn is_absent(&self) -> bool {
        self.misses >= ABSENT_MISSES
    }

    /// Whether the last frame was answered.
    pub(super) const fn is_present(&self) -> bool {
        self.misses == 0 && self.stats.rtt_average.is_some()
    }

    /// Time of the last answer, if the monitor is present.
    pub(super) fn present_at(&self) -> Option<Now> {
        self.answered_at.filter(|_| self.is_present())
    }

    /// Whether only reads wait for a monitor that does not answer, on a line where others do.
    pub(super) fn can_wait(&self) -> bool {
        if !self.is_absent() || self.others.is_none() {
            return false;
        }
        let next = match &self.outstanding {
            Some(outstanding) => Some(&outstanding.operation),
            None => self.urgent.front().or(self.queue.get(self.first_queued())),
        };
        let reads = |it: &Operation| it.haste() == Haste::Usual && it.is_repeatable();
        next.is_some_and(reads)
    }

    /// The usual round trip, while the monitor answers.
    pub(super) fn usual(&self) -> Option<Duration> {
        self.stats.rtt_average.filter(|_| !self.is_absent())
    }

    /// Sets the usual round trip of the others on the line.
    pub(super) const fn set_others(&mut self, others: Option<Duration>) {
        self.others = others;
    }

    /// Time until which a read for an absent monitor waits for its turn. With a controller it waits
    /// for longer until a frame since it was asked is not answered: without a grant nothing shows
    /// that the monitor is still absent.
    fn read_ends(&self) -> impl Fn(&Operation) -> Option<Now> + use<> {
        let time = self.config.timeout * self.config.tries;
        let (direct, missed_at) = (self.config.role == Role::Direct, self.missed_at);
        move |operation| {
            let limited =
                direct || missed_at.is_some_and(|missed_at| operation.submitted <= missed_at);
            (limited && ends_with_others(operation)).then(|| operation.submitted + time)
        }
    }

    /// Time of the next call of [`Session::give_up_reads`].
    pub(super) fn gives_up_at(&self) -> Option<Now> {
        if !self.can_wait() {
            return None;
        }
        self.queue.iter().filter_map(self.read_ends()).min()
    }

    /// Ends the reads for an absent monitor whose turn has not come in time.
    pub(super) fn give_up_reads(&mut self, now: Now) {
        if self.gives_up_at().is_none_or(|at| now < at) {
            return;
        }
        let ends = self.read_ends();
        self.end_reads(|operation| ends(operation).is_some_and(|at| now >= at));
    }

    fn wait_of_renewal(&self) -> Duration {
        let Some(usual) = self.stats.rtt_average else { return self.config.timeout };
        let least = match self.config.role {
            Role::Direct => RENEWAL_LEAST,
            // The controller repeats requests that the monitor does not answer.
            Role::Active => self.config.patience,
        };
        (usual * 2 + RENEWAL_SPARE).clamp(least, self.config.timeout.max(least))
    }

    /// Whether an operation without answer is sent once more.
    pub(super) fn may_try_again(&self, now: Now, operation: &Operation) -> bool {
        if operation.is_urgent() {
            let all = self.config.timeout * self.config.tries;
            return operation.began.is_none_or(|began| now < began + all);
        }
        let absent = self.is_absent() && self.others.is_some();
        let tries = if absent { 1 } else { self.config.tries };
        let left = operation.tries < tries && !self.is_vain(operation);
        operation.is_repeatable() && left && !operation.cancelled
    }

    /// Removes from the queue the operations that would reverse an urgent one: all waiting ones if
    /// `newest` is the urgent operation itself, or only `newest` if it continues a batch that was
    /// started at `since`.
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

    /// Time for which waiting operations let an outstanding frame wait for its answer; `None`:
    /// until its deadline. An urgent operation replaces any other one; one that has been sent before
    /// waits for another urgent one. Those of a held motion replace a read.
    pub(super) fn patience(&self, outstanding: &Outstanding) -> Option<Duration> {
        let operation = &outstanding.operation;
        if let Some(urgent) = self.urgent.front() {
            let overtakes = !operation.is_urgent() || !urgent.sent;
            // A frame that does not take the line any more holds back nothing.
            let patience = self.config.patience;
            let taken = self.wait_in_vain(operation).unwrap_or(patience);
            return overtakes.then(|| patience.min(taken));
        }
        if !self.queue.iter().any(Operation::is_held) {
            return None;
        }
        let asks = operation.ticket == Ticket::QUESTION;
        let gives_way = operation.haste() == Haste::Usual && operation.is_repeatable() && !asks;
        gives_way.then(|| self.wait_of_renewal())
    }

    /// Replaces a frame that is without answer for too long by an operation that cannot wait.
    pub(super) fn overtake(&mut self, now: Now) {
        let Some(outstanding) = &self.outstanding else { return };
        let patience = self.patience(outstanding);
        if !patience.is_some_and(|time| outstanding.due || now >= outstanding.sent + time) {
            return;
        }
        let Some(outstanding) = self.outstanding.take() else { return };
        let Outstanding { operation, .. } = self.give_up(outstanding);
        if operation.is_urgent() {
            self.urgent.push_back(operation);
        } else if operation.is_repeatable() || !operation.sent {
            self.queue.push_front(operation);
        } else if let Some(by) = self.urgent.front().and_then(Operation::first) {
            self.outcomes.push_back((operation.ticket, Outcome::Superseded { by, sent: true }));
        }
    }

    /// Removes operations from the queue whose time limit has passed. Those that wait there and
    /// have been sent before are reads.
    pub(super) fn drop_expired(&mut self, now: Now) {
        let outcomes = &mut self.outcomes;
        let alive = |operation: &Operation| operation.expires.is_none_or(|expires| now < expires);
        if self.queue.iter().all(alive) {
            return;
        }
        self.queue.retain(|operation| {
            if !alive(operation) {
                outcomes.push_back((operation.ticket, Outcome::Expired));
            }
            alive(operation)
        });
    }
}
