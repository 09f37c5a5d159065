//! The controlling side of one monitor without I/O and clock: bytes and times in, bytes out.
//!
//! One frame of requests is outstanding at a time. Stop, Close and Lockout on are sent before
//! waiting requests, replace an outstanding frame that is without answer for too long, and cancel
//! requests that would reverse them. A request without answer is repeated only if executing it
//! twice has the effect of once. `session/late_answers.rs` describes how late, foreign and duplicate
//! answers are rejected; [`mod@line`], how several monitors share a line; [`jog`], how a motion
//! ends that is no longer held.
//!
//! ```text
//! submit ─▶ queue ─▶ poll_transmit ─▶ outstanding ─▶ handle_bytes ───▶ poll_outcome
//!              ▲                          │  ▲          (an answer)
//!              └── overtaken, link lost ──┤  └─ again ─┐
//!                                         └─ handle_timeout ─▶ tries used up ─▶ poll_outcome
//! ```

mod bus_access;
mod check;
mod config;
mod counters;
pub mod echo;
mod input;
pub mod jog;
pub(crate) mod late_answers;
pub mod line;
pub(crate) mod matching;
pub mod medium;
mod noise;
mod operation;
mod receive;
mod send;
pub mod statistics;
mod unanswered;
mod urgent;

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use lafet_proto::RequestId;
use lafet_proto::link::Check;

use crate::answers::Requests;
use crate::deviation::Deviation;
pub use check::CheckMode;
use check::Negotiation;
pub(crate) use config::LONGEST;
pub use config::{Config, LATE_DEFAULT};
pub use counters::{Direction, Stats, Traced, Verdict};
use input::Input;
use late_answers::{Suspicion, Tag, Tags};
pub use matching::{Slot, Slots};
use medium::Framing;
use operation::{Echo, Operation, Outstanding, Recent};
use unanswered::Unheard;

/// Time since a fixed moment.
pub type Now = Duration;

/// Most waiting operations; more are refused.
pub const QUEUE_MAX: usize = 256;
/// Most waiting urgent operations.
pub const URGENT_MAX: usize = 64;
/// Frames remembered to distinguish late answers from duplicate and foreign ones.
const RECENT_MAX: usize = 128;
/// Traced frames kept for a listener that does not fetch them.
const TRACED_MAX: usize = 1024;
/// Untagged answers to tagged frames after which the monitor is known not to support tags.
const UNTAGGED_PROOF: u32 = 3;

/// Identifies a submitted operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Ticket(u64);

impl Ticket {
    /// Tickets of the sessions of a line differ by their monitor's address.
    const ADDRESS_SHIFT: u32 = 56;

    /// Of the session's own operation, see `late_answers`: no monitor has address 255.
    const QUESTION: Self = Self(u64::MAX);

    /// Address of the monitor whose session created it.
    const fn address(self) -> u8 {
        (self.0 >> Self::ADDRESS_SHIFT) as u8
    }
}

/// Too many operations are waiting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueueFull;

/// Conditions of submitted requests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Terms {
    /// The first frame of the same batch: a Stop submitted after that frame is later than the
    /// batch, so it is sent before this frame too.
    pub first: Option<Ticket>,
    /// Time after which it must not be sent: a motion that is no longer held.
    pub expires: Option<Now>,
}

/// How an operation ended.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// Answered: one slot for each request.
    Answered(Slots),
    /// Not answered.
    Silence {
        /// Number of transmissions.
        tries: u32,
        /// A request that was not sent but that the monitor answered meanwhile.
        stray: Option<RequestId>,
    },
    /// The monitor answered every transmission, but never as the protocol requires.
    Odd {
        /// Deviation of the last answer.
        what: Deviation,
    },
    /// Sent, and the connection was lost before the answer.
    LinkLost,
    /// Cancelled by an urgent request.
    Superseded {
        /// The urgent request.
        by: RequestId,
        /// Whether it had been sent before, so that it may have been executed.
        sent: bool,
    },
    /// Not sent: the monitor did not answer the question before it (see `late_answers`).
    Unheard {
        /// Number of transmissions of the question.
        tries: u32,
    },
    /// Not sent: there is no connection.
    NotConnected,
    /// Not sent: its time limit passed before its turn came.
    Expired,
    /// Not executed: CRC-32C is required, and the monitor does not support it.
    CheckMissing,
    /// Not sent: no controller granted access (`role=active`).
    NoGrant {
        /// Whether there is a controller.
        controller: bool,
    },
    /// Not sent: there is a controller that grants access, and the request was not to wait for it.
    ControllerPresent,
    /// Not sent: bytes that are no frames arrive (see [`Config::heed`]).
    Unreadable,
}

/// The core: see the module's documentation.
#[derive(Debug)]
pub struct Session {
    config: Config,
    input: Input,
    urgent: VecDeque<Operation>,
    queue: VecDeque<Operation>,
    outstanding: Option<Outstanding>,
    connected: bool,
    was_connected: bool,
    suspicion: Suspicion,
    tags: Tags,
    echo: Echo,
    check: Negotiation,
    recent: VecDeque<Recent>,
    /// The latest urgent requests.
    stops: VecDeque<(Ticket, Requests)>,
    outcomes: VecDeque<(Ticket, Outcome)>,
    traced: Option<VecDeque<Traced>>,
    stats: Stats,
    /// Consecutive frames that were not answered in all the time for it.
    silent_frames: u32,
    /// When the latest of them were sent: as many as a request has tries.
    silences: VecDeque<Now>,
    /// For how long it was not heard.
    unheard: Unheard,
    /// Consecutive frames without answer, even after a short wait.
    misses: u32,
    /// When the latest of them was sent.
    missed_at: Option<Now>,
    /// Time of the latest answer.
    answered_at: Option<Now>,
    /// The usual round trip of other monitors on the same line.
    others: Option<Duration>,
    next_ticket: u64,
}

impl Session {
    /// A session without connection.
    pub fn new(config: Config) -> Self {
        let config = config.bounded();
        let next_ticket = u64::from(config.addresses.monitor) << Ticket::ADDRESS_SHIFT;
        Self {
            input: Input::new(config.framing),
            check: Negotiation::new(config.check, config.framing),
            urgent: VecDeque::new(),
            queue: VecDeque::new(),
            outstanding: None,
            connected: false,
            was_connected: false,
            suspicion: Suspicion::default(),
            tags: Tags::new(config.first_number),
            echo: Echo::Unknown { untagged: 0 },
            recent: VecDeque::new(),
            stops: VecDeque::new(),
            outcomes: VecDeque::new(),
            traced: None,
            stats: Stats::default(),
            silent_frames: 0,
            silences: VecDeque::new(),
            unheard: Unheard::default(),
            misses: 0,
            missed_at: None,
            answered_at: None,
            others: None,
            next_ticket,
            config,
        }
    }

    /// The configuration.
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// Counters since the session was created.
    pub fn stats(&self) -> Stats {
        let crc32c = u32::from(self.check() == Check::Crc32c && self.stats.believed > 0);
        self.input.counted(Stats { crc32c, ..self.stats })
    }

    /// When the monitor was heard last, if not before this time.
    fn heard_since(&self, time: Now) -> Option<Now> {
        self.answered_at.filter(|at| *at >= time)
    }

    /// Whether no operation is waiting or outstanding.
    pub fn is_idle(&self) -> bool {
        self.outstanding.is_none() && self.urgent.is_empty() && self.queue.is_empty()
    }

    /// Whether nothing is to be done until an operation is submitted or bytes are received.
    fn rests(&self) -> bool {
        self.is_idle() && !self.check.is_probing()
    }

    /// Whether a Stop, Close or Lockout is still to be sent or answered.
    pub fn is_urgent(&self) -> bool {
        let outstanding = self.outstanding.as_ref();
        !self.urgent.is_empty() || outstanding.is_some_and(|o| o.operation.is_urgent())
    }

    /// Switches the recording of frames for [`Session::poll_traced`].
    pub fn set_tracing(&mut self, on: bool) {
        match on {
            true => _ = self.traced.get_or_insert_default(),
            false => self.traced = None,
        }
    }

    /// Queues requests that go out in one frame; none: a presence probe (observed).
    ///
    /// # Errors
    ///
    /// [`QueueFull`] when [`QUEUE_MAX`] requests wait already, or [`URGENT_MAX`] urgent ones.
    pub fn submit(&mut self, now: Now, requests: impl Into<Requests>) -> Result<Ticket, QueueFull> {
        self.submit_on(now, Terms::default(), requests)
    }

    /// Like [`Session::submit`], with conditions.
    ///
    /// # Errors
    ///
    /// As [`Session::submit`].
    pub fn submit_on(
        &mut self,
        now: Now,
        terms: Terms,
        requests: impl Into<Requests>,
    ) -> Result<Ticket, QueueFull> {
        let ticket = Ticket(self.next_ticket);
        let operation = Operation::new(ticket, requests.into(), now, terms.expires);
        let urgent = operation.is_urgent();
        let (queue, limit) = match urgent {
            true => (&mut self.urgent, URGENT_MAX),
            false => (&mut self.queue, QUEUE_MAX),
        };
        if queue.len() >= limit {
            return Err(QueueFull);
        }
        self.next_ticket += 1;
        let stop = urgent.then(|| operation.requests.clone());
        // Urgent ones that have been sent take turns behind those that have not.
        let place = if urgent { queue.iter().position(|other| other.sent) } else { None };
        match place {
            Some(place) => queue.insert(place, operation),
            None => queue.push_back(operation),
        }
        if let Some(stop) = stop {
            self.note_stop(ticket, stop);
        }
        self.supersede(ticket, if urgent { Some(ticket) } else { terms.first });
        Ok(ticket)
    }

    /// Cancels an operation whose outcome is not needed. Requests that have not been sent are not
    /// sent, except urgent ones.
    pub fn cancel(&mut self, ticket: Ticket) {
        self.queue.retain(|operation| operation.ticket != ticket);
        let outstanding = self.outstanding.iter_mut().map(|outstanding| &mut outstanding.operation);
        for operation in self.urgent.iter_mut().chain(outstanding) {
            operation.cancelled |= operation.ticket == ticket;
        }
    }

    /// Takes an urgent operation back that has not been sent: what it was to stop is over.
    pub(super) fn recall(&mut self, ticket: Ticket) {
        let recalled = |operation: &Operation| operation.ticket == ticket && !operation.sent;
        let waits = self.urgent.len();
        self.urgent.retain(|operation| !recalled(operation));
        let due = self.outstanding.take_if(|it| it.due && recalled(&it.operation));
        let is_due = due.map(|outstanding| self.give_up(outstanding)).is_some();
        if is_due || self.urgent.len() < waits {
            self.outcomes.push_back((ticket, Outcome::Expired));
        }
    }

    /// The connection is open.
    pub fn handle_connected(&mut self, now: Now) {
        self.stats.reconnects += u64::from(self.was_connected);
        (self.connected, self.was_connected) = (true, true);
        // What was lost with the last connection says nothing about this one.
        self.forget_silence();
        self.input.reset();
        if self.config.outlives {
            self.suspicion.raise_all(now);
        }
        if self.config.framing == Framing::Link {
            self.check.connected();
        }
        if self.echo == Echo::No {
            self.echo = Echo::Unknown { untagged: 0 };
        }
    }

    /// The connection is lost. An outstanding frame waits for the next one if it may be repeated.
    pub fn handle_disconnected(&mut self, now: Now) {
        self.connected = false;
        self.check.disconnected();
        self.input.reset();
        // A Stop behind a frame that the peer did not take goes out over the next connection: its
        // time without one starts now.
        for urgent in &mut self.urgent {
            (urgent.submitted, urgent.silent_from) = (now, None);
        }
        if let Some(outstanding) = self.outstanding.take() {
            let Outstanding { mut operation, .. } = self.give_up(outstanding);
            if operation.cancelled && !operation.is_urgent() {
                return;
            }
            let again = match operation.is_urgent() {
                true => self.may_try_again(now, &operation),
                false => operation.is_repeatable() && operation.tries < self.config.tries,
            };
            (operation.first_sent, operation.silent_from) = (None, None);
            if again || !operation.sent {
                operation.submitted = now;
                self.requeue(operation);
            } else {
                self.outcomes.push_back((operation.ticket, Outcome::LinkLost));
            }
        }
    }

    /// Takes bytes of a stream.
    pub fn handle_bytes(&mut self, now: Now, mut bytes: &[u8]) {
        let end = self.outstanding.as_ref().and_then(|outstanding| outstanding.tag);
        while let Some(frame) = self.input.take(&mut bytes, end) {
            self.handle_incoming(now, &frame);
        }
    }

    /// Takes a datagram: one link frame (ours).
    pub fn handle_datagram(&mut self, now: Now, datagram: &[u8]) {
        if let Some(frame) = self.input.take_datagram(datagram) {
            self.handle_incoming(now, &frame);
        }
    }

    /// Handles the time: see [`Session::poll_timeout`].
    pub fn handle_timeout(&mut self, now: Now) {
        self.drop_expired(now);
        if !self.connected {
            self.expire(now);
            return;
        }
        self.check_timed_out(now);
        if let Some(outstanding) = self.outstanding.take_if(|o| !o.due && now >= o.deadline) {
            self.try_failed(now, outstanding);
        }
        self.overtake(now);
    }

    /// Latest time for the next call of [`Session::handle_timeout`] or [`Session::poll_transmit`].
    pub fn poll_timeout(&self, now: Now) -> Option<Now> {
        let expiry = self.queue.iter().filter_map(|operation| operation.expires).min();
        expiry.into_iter().chain(self.next_timeout(now)).min()
    }

    /// If an answer is awaited and nothing else is to be done: the time until which it is.
    fn only_awaits(&self) -> Option<Now> {
        let waits = !self.urgent.is_empty() || !self.queue.is_empty();
        if waits || !self.connected || self.check.is_probing() {
            return None;
        }
        self.outstanding.as_ref().filter(|outstanding| !outstanding.due).map(|o| o.deadline)
    }

    fn next_timeout(&self, now: Now) -> Option<Now> {
        let waiting = self.urgent.iter().chain(&self.queue);
        if !self.connected {
            return waiting.map(|it| Self::waits_until(&self.config, it)).min();
        }
        if let Some(until) = self.probed_until(self.next_is_urgent())
            && self.outstanding.as_ref().is_none_or(|outstanding| outstanding.due)
        {
            return Some(until);
        }
        match &self.outstanding {
            Some(outstanding) if outstanding.due => Some(now),
            Some(outstanding) => {
                let patience = self.patience(outstanding).map(|time| outstanding.sent + time);
                Some(patience.map_or(outstanding.deadline, |time| time.min(outstanding.deadline)))
            }
            None if !self.urgent.is_empty() => Some(now),
            None => {
                let next = self.queue.get(self.first_queued());
                next.map(|operation| self.drained(now, operation).unwrap_or(now))
            }
        }
    }

    /// The next operation that has ended.
    pub fn poll_outcome(&mut self) -> Option<(Ticket, Outcome)> {
        while let Some((ticket, outcome)) = self.outcomes.pop_front() {
            if ticket != Ticket::QUESTION {
                return Some((ticket, outcome));
            }
        }
        None
    }

    /// The next recorded frame.
    pub fn poll_traced(&mut self) -> Option<Traced> {
        self.traced.as_mut()?.pop_front()
    }

    fn trace(&mut self, verdict: Verdict, dst: u8, src: u8, tagged: bool, payload: &[u8]) {
        if self.traced.is_some() {
            self.record(verdict, dst, src, tagged, payload);
        }
    }

    #[cold]
    fn record(&mut self, verdict: Verdict, dst: u8, src: u8, tagged: bool, payload: &[u8]) {
        let Some(traced) = &mut self.traced else { return };
        if traced.len() < TRACED_MAX {
            traced.push_back(Traced { verdict, dst, src, tagged, payload: Arc::from(payload) });
        }
    }
}

#[cfg(test)]
mod tests;
