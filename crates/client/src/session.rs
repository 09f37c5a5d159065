//! The controlling side of one monitor without any I/O or clock: bytes and times in, bytes out.
//!
//! One frame of requests is outstanding at a time. Stop, Close and Lockout on overtake what waits,
//! take the place of what is outstanding without answer for too long, and remove what would undo
//! them. A request without answer is repeated only where twice is the same as once. How late,
//! foreign and doubled answers are kept from being believed is told in `session/doubt.rs`; how
//! several monitors share a line, in [`mod@line`]; how a motion ends when nobody holds it any more, in
//! [`jog`].
//!
//! ```text
//! submit ─▶ queue ─▶ poll_transmit ─▶ outstanding ─▶ handle_bytes ───▶ poll_outcome
//!              ▲                          │  ▲          (an answer)
//!              └── overtaken, link lost ──┤  └─ again ─┐
//!                                         └─ handle_timeout ─▶ tries used up ─▶ poll_outcome
//! ```

mod bus_ear;
mod check;
pub(crate) mod doubt;
pub mod echo;
mod input;
pub mod jog;
pub mod line;
mod matching;
mod operation;
mod receive;
pub mod statistics;
mod stats;
mod urgent;

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use lafet_proto::RequestId;
use lafet_proto::link::{Check, compose, wire_max};

use crate::answers::RequestBuf;
use crate::url::{Addresses, Echo as EchoMode, Framing, Role};
pub use check::CheckMode;
use check::{Forms, Negotiation};
use doubt::{Suspicion, Tag, Tags, looks_like_tag};
use input::Input;
pub use matching::Slot;
use operation::{Echo, Operation, Outstanding, Recent};
pub use stats::{Direction, Stats, Traced, Verdict};

/// A moment: time since any fixed one.
pub type Now = Duration;

/// Operations that wait at most; more are refused.
pub const QUEUE_MAX: usize = 256;
/// Urgent ones that wait at most.
pub const URGENT_MAX: usize = 64;
/// Frames remembered to tell late answers from doubled and foreign ones.
const RECENT_MAX: usize = 128;
/// Frames kept for a listener that does not fetch them.
const TRACED_MAX: usize = 1024;
/// Untagged answers to tagged frames that prove that the monitor does not answer tags.
const UNTAGGED_PROOF: u32 = 3;

/// How a session behaves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Config {
    /// Who talks to whom.
    pub addresses: Addresses,
    /// What the bytes are.
    pub framing: Framing,
    /// How long an answer is waited for.
    pub timeout: Duration,
    /// How often a request that may be repeated is sent.
    pub tries: u32,
    /// How long an urgent request lets an outstanding frame wait for its answer.
    pub patience: Duration,
    /// No answer comes later than this after its request: the bound up to which nothing wrong is
    /// believed of a monitor that answers tags.
    pub late_bound: Duration,
    /// The same for a monitor that does not: what a suspicious request has to wait.
    pub drain_bound: Duration,
    /// The medium may copy frames (UDP).
    pub duplicates: bool,
    /// Number frames in doubt; without it they wait for `drain_bound`.
    pub tags: bool,
    /// What this side is on its bus.
    pub role: Role,
    /// Which check frames bear.
    pub check: CheckMode,
    /// Whether what is sent comes back, as on RS-485 adapters that hear themselves.
    pub echo: EchoMode,
    /// Silence that is kept between the last byte heard and a frame: a transceiver needs it to turn
    /// round.
    pub turnaround: Duration,
    /// How long requests are asked again that the monitor answers with Busy, NotCached or Cached
    /// (§2), where the caller wants them complete.
    pub resume: Duration,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            addresses: Addresses::default(),
            framing: Framing::Link,
            timeout: Duration::from_secs(1),
            tries: 3,
            patience: Duration::from_millis(lafet_proto::bus::REPLY_TIMEOUT_MS as u64),
            late_bound: Duration::from_secs(30),
            drain_bound: Duration::from_secs(3),
            duplicates: false,
            tags: true,
            role: Role::Direct,
            check: CheckMode::Crc16,
            echo: EchoMode::Off,
            turnaround: Duration::ZERO,
            resume: Duration::from_secs(10),
        }
    }
}

/// Names an operation that was submitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Ticket(u64);

impl Ticket {
    /// Tickets of the sessions of a line differ by their monitor's address.
    const ADDRESS_SHIFT: u32 = 56;

    /// The monitor whose session gave it out.
    const fn address(self) -> u8 {
        (self.0 >> Self::ADDRESS_SHIFT) as u8
    }
}

/// Too many operations wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueueFull;

/// What goes with requests that are submitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Terms {
    /// The first frame of the same batch: a Stop that came since is later than the batch, so it
    /// overtakes this frame too.
    pub first: Option<Ticket>,
    /// Not to be sent after this moment: a motion that nobody holds any more.
    pub expires: Option<Now>,
}

/// How an operation ended.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// With answers: one slot for each request.
    Answered(Vec<Slot>),
    /// Without answer.
    Silence {
        /// How often the frame was sent.
        tries: u32,
    },
    /// It was sent, and the connection was lost before the answer.
    LinkLost,
    /// An urgent request overtook it. `sent` tells whether it may have been executed.
    Superseded {
        /// The urgent request.
        by: RequestId,
        /// Whether it had been sent before.
        sent: bool,
    },
    /// There is no connection; it was not sent.
    NotConnected,
    /// Its time was over before its turn came; it was not sent.
    Expired,
    /// The monitor has no CRC-32C, which is insisted on; it was not executed.
    CheckMissing,
    /// No controller gave leave to speak (`role=active`); it was not sent.
    NoGrant {
        /// Whether there is a controller.
        controller: bool,
    },
    /// There is a controller that gives leave to speak, and we did not wait for it; not sent.
    ControllerPresent,
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
    /// The last urgent requests.
    stops: VecDeque<(Ticket, Vec<RequestBuf>)>,
    outcomes: VecDeque<(Ticket, Outcome)>,
    traced: Option<VecDeque<Traced>>,
    stats: Stats,
    /// Tries in a row that nobody answered.
    silent_tries: u32,
    next_ticket: u64,
}

impl Session {
    /// A session without connection.
    pub fn new(config: Config) -> Self {
        let next_ticket = u64::from(config.addresses.monitor) << Ticket::ADDRESS_SHIFT;
        Self {
            input: Input::new(config.framing),
            check: Negotiation::new(config.check, config.framing),
            config,
            urgent: VecDeque::new(),
            queue: VecDeque::new(),
            outstanding: None,
            connected: false,
            was_connected: false,
            suspicion: Suspicion::default(),
            tags: Tags::default(),
            echo: Echo::Unknown { untagged: 0 },
            recent: VecDeque::new(),
            stops: VecDeque::new(),
            outcomes: VecDeque::new(),
            traced: None,
            stats: Stats::default(),
            silent_tries: 0,
            next_ticket,
        }
    }

    /// How it behaves.
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// What it has seen.
    pub fn stats(&self) -> Stats {
        let crc32c = u32::from(self.check() == Check::Crc32c && self.stats.believed > 0);
        self.input.counted(Stats { crc32c, ..self.stats })
    }

    /// Tries in a row without answer: the connection may be half open.
    pub const fn silent_tries(&self) -> u32 {
        self.silent_tries
    }

    /// Nothing waits and nothing is outstanding.
    pub fn is_idle(&self) -> bool {
        self.outstanding.is_none() && self.urgent.is_empty() && self.queue.is_empty()
    }

    /// A Stop, Close or Lockout is still to be sent or answered.
    pub fn is_urgent(&self) -> bool {
        let outstanding = self.outstanding.as_ref();
        !self.urgent.is_empty() || outstanding.is_some_and(|o| o.operation.is_urgent())
    }

    /// Keep, or do not keep, every frame for [`Session::poll_traced`].
    pub fn set_tracing(&mut self, on: bool) {
        match on {
            true => _ = self.traced.get_or_insert_default(),
            false => self.traced = None,
        }
    }

    /// Queues requests that go out in one frame; none: a presence probe (observed).
    pub fn submit(&mut self, now: Now, requests: Vec<RequestBuf>) -> Result<Ticket, QueueFull> {
        self.submit_on(now, Terms::default(), requests)
    }

    /// The same, on terms.
    pub fn submit_on(
        &mut self,
        now: Now,
        terms: Terms,
        requests: Vec<RequestBuf>,
    ) -> Result<Ticket, QueueFull> {
        let ticket = Ticket(self.next_ticket);
        let operation = Operation::new(ticket, requests, now, terms.expires);
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
        queue.push_back(operation);
        if let Some(stop) = stop {
            self.note_stop(ticket, stop);
        }
        self.supersede(ticket, if urgent { Some(ticket) } else { terms.first });
        Ok(ticket)
    }

    /// Nobody waits for the outcome any more. What has not been sent is not sent, but for urgent
    /// requests: they are sent even if nobody waits.
    pub fn cancel(&mut self, ticket: Ticket) {
        self.queue.retain(|operation| operation.ticket != ticket);
        let outstanding = self.outstanding.iter_mut().map(|outstanding| &mut outstanding.operation);
        for operation in self.urgent.iter_mut().chain(outstanding) {
            operation.cancelled |= operation.ticket == ticket;
        }
    }

    /// There is a connection.
    pub fn handle_connected(&mut self) {
        self.stats.reconnects += u64::from(self.was_connected);
        (self.connected, self.was_connected) = (true, true);
        self.silent_tries = 0;
        self.input.reset();
        if self.config.framing == Framing::Link {
            self.check.connected();
        }
        if self.echo == Echo::No {
            self.echo = Echo::Unknown { untagged: 0 };
        }
    }

    /// The connection is lost. What is outstanding waits for the next one if it may be repeated.
    pub fn handle_disconnected(&mut self, now: Now) {
        self.connected = false;
        self.check.disconnected();
        self.input.reset();
        if let Some(outstanding) = self.outstanding.take() {
            let Outstanding { mut operation, .. } = self.give_up(outstanding);
            if operation.cancelled && !operation.is_urgent() {
                return;
            }
            let again = operation.is_repeatable() && operation.tries < self.config.tries;
            operation.first_sent = None;
            if again || !operation.sent {
                operation.submitted = now;
                self.requeue(operation);
            } else {
                self.outcomes.push_back((operation.ticket, Outcome::LinkLost));
            }
        }
    }

    /// Bytes of a stream have come.
    pub fn handle_bytes(&mut self, now: Now, bytes: &[u8]) {
        self.input.push(bytes);
        self.handle_input(now);
    }

    /// A datagram has come: one link frame (ours).
    pub fn handle_datagram(&mut self, now: Now, datagram: &[u8]) {
        self.input.push_datagram(datagram);
        self.handle_input(now);
    }

    /// Time has passed: see [`Session::poll_timeout`].
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

    /// When [`Session::handle_timeout`] or [`Session::poll_transmit`] is to be called at the latest.
    pub fn poll_timeout(&self, now: Now) -> Option<Now> {
        let expiry = self.queue.iter().filter_map(|operation| operation.expires).min();
        expiry.into_iter().chain(self.next_timeout(now)).min()
    }

    fn next_timeout(&self, now: Now) -> Option<Now> {
        let waiting = self.urgent.iter().chain(&self.queue);
        if !self.connected {
            return waiting.map(|operation| operation.submitted + self.config.timeout).min();
        }
        if let Some(until) = self.probed_until(self.next_is_urgent())
            && self.outstanding.as_ref().is_none_or(|outstanding| outstanding.due)
        {
            return Some(until);
        }
        match &self.outstanding {
            Some(outstanding) if outstanding.due => Some(now),
            Some(outstanding) => {
                let patience = self
                    .can_be_overtaken(outstanding)
                    .then(|| outstanding.sent + self.config.patience);
                Some(patience.map_or(outstanding.deadline, |time| time.min(outstanding.deadline)))
            }
            None if !self.urgent.is_empty() => Some(now),
            None => self.queue.front().map(|operation| self.drained(now, operation).unwrap_or(now)),
        }
    }

    /// Bytes to send, if any.
    pub fn poll_transmit(&mut self, now: Now) -> Option<Vec<u8>> {
        if !self.connected {
            return None;
        }
        if self.outstanding.as_ref().is_none_or(|outstanding| outstanding.due) {
            self.refuse_missing(now);
            let urgent = self.next_is_urgent();
            if !urgent && let Some(probe) = self.poll_check(now) {
                return Some(probe);
            }
            if self.probed_until(urgent).is_some_and(|until| now < until) {
                return None;
            }
            self.probe_failed();
        }
        if self.outstanding.is_none() {
            self.outstanding = self.next(now);
        }
        let form = self.outstanding.as_ref().map_or(Check::Crc16, |o| self.next_form(o));
        let wait = self.outstanding.as_ref().map_or(Duration::ZERO, |o| self.wait(&o.operation));
        let outstanding = self.outstanding.as_mut().filter(|outstanding| outstanding.due)?;
        outstanding.due = false;
        outstanding.sent = now;
        // A frame sent too early to be believed is sent again as soon as it can be.
        let believable = now >= outstanding.believe_from;
        outstanding.deadline = if believable { now + wait } else { outstanding.believe_from };
        outstanding.operation.tries += u32::from(believable);
        outstanding.operation.sent = true;
        outstanding.operation.first_sent.get_or_insert(now);
        outstanding.tries += 1;
        outstanding.forms.add(form);
        if let Some(tag) = outstanding.tag {
            self.tags.sent(now, tag);
        }
        self.stats.frames_sent += 1;
        self.stats.retries += u64::from(outstanding.tries > 1);
        Some(self.frame(form))
    }

    /// An operation that has ended.
    pub fn poll_outcome(&mut self) -> Option<(Ticket, Outcome)> {
        self.outcomes.pop_front()
    }

    /// A frame that was sent or received.
    pub fn poll_traced(&mut self) -> Option<Traced> {
        self.traced.as_mut()?.pop_front()
    }

    /// The bytes of the outstanding frame.
    fn frame(&mut self, form: Check) -> Vec<u8> {
        let Some(Outstanding { operation, tag, .. }) = &self.outstanding else { return vec![] };
        let tag = tag.map(Tag::to_bytes);
        let tagged = tag.is_some();
        let tag = tag.as_ref().map_or(&[][..], |bytes| bytes);
        let requests = operation.requests.iter().map(RequestBuf::bytes);
        let Addresses { monitor: dst, source: src } = self.config.addresses;
        let bytes = match self.config.framing {
            // Bare records have no frame around them: the tag behind them marks the end (ours).
            Framing::Records => requests.chain([tag]).flatten().copied().collect(),
            Framing::Link => {
                let parts = std::iter::once(tag).chain(requests);
                let mut wire = vec![0; wire_max(parts.clone().map(<[u8]>::len).sum())];
                let len = compose(form, dst, src, &mut wire, |mut place| {
                    let room = place.len();
                    for part in parts {
                        let (bytes, rest) = place.split_at_mut_checked(part.len())?;
                        bytes.copy_from_slice(part);
                        place = rest;
                    }
                    Some(room - place.len())
                });
                wire.truncate(len.unwrap_or(0));
                wire
            }
        };
        if self.traced.is_some() {
            let requests: Vec<&[u8]> = operation.requests.iter().map(RequestBuf::bytes).collect();
            self.trace(Verdict::Sent, dst, src, tagged, &requests.concat());
        }
        bytes
    }

    /// The operation whose turn it is, if it may be sent now.
    fn next(&mut self, now: Now) -> Option<Outstanding> {
        let urgent = !self.urgent.is_empty();
        let operation = self.urgent.front().or(self.queue.front())?;
        if !urgent && self.drained(now, operation).is_some() {
            return None;
        }
        let (tag, believe_from) = if !self.is_doubtful(now, operation) {
            (None, Now::ZERO)
        } else if self.tags_work() {
            match self.tags.issue(now, self.config.late_bound) {
                Ok(tag) => (Some(tag), Now::ZERO),
                // Too many tags in too short a time.
                Err(_) if !urgent => return None,
                Err(until) => (None, until),
            }
        } else {
            let until = self.suspicion.until(operation.first(), now, self.config.drain_bound);
            (None, until.unwrap_or(Now::ZERO))
        };
        let operation = self.urgent.pop_front().or_else(|| self.queue.pop_front())?;
        Some(Outstanding {
            operation,
            tag,
            tries: 0,
            sent: now,
            deadline: now,
            due: true,
            believe_from,
            untagged: false,
            forms: Forms::default(),
        })
    }

    /// Whether there is a frame to be sent now, and whether it is urgent.
    fn wants(&self, now: Now) -> Option<bool> {
        let wants = self.wants_now(now)?;
        // What waits for the answer to a probe, but for what is urgent, waits on.
        (wants || !self.check.is_probing()).then_some(wants)
    }

    /// Whether what is to be sent next is urgent.
    fn next_is_urgent(&self) -> bool {
        match &self.outstanding {
            Some(outstanding) => outstanding.operation.is_urgent(),
            None => !self.urgent.is_empty(),
        }
    }

    fn wants_now(&self, now: Now) -> Option<bool> {
        match &self.outstanding {
            _ if !self.connected => None,
            Some(outstanding) => outstanding.due.then(|| outstanding.operation.is_urgent()),
            None if !self.urgent.is_empty() => Some(true),
            None => self.drained(now, self.queue.front()?).is_none().then_some(false),
        }
    }

    /// Since when the line is taken by a frame that is out, and until when.
    fn occupies(&self, now: Now) -> Option<(Now, Now)> {
        if let Some(probe) = self.check.occupies().filter(|(_, until)| now < *until) {
            return Some(probe);
        }
        let outstanding = self.outstanding.as_ref().filter(|outstanding| !outstanding.due)?;
        let until = outstanding.deadline.min(outstanding.sent + self.config.timeout);
        (now < until).then_some((outstanding.sent, until))
    }

    /// Whether an answer to another frame could be taken for one to this operation.
    fn is_doubtful(&self, now: Now, operation: &Operation) -> bool {
        if self.config.framing == Framing::Records {
            return true;
        }
        let bound = if self.tags_work() { self.config.late_bound } else { self.config.drain_bound };
        let own_tag = operation
            .requests
            .first()
            .is_some_and(|request| looks_like_tag(request.id(), request.to()));
        self.suspicion.until(operation.first(), now, bound).is_some()
            || (own_tag && self.tags_work())
    }

    fn tags_work(&self) -> bool {
        self.config.framing == Framing::Records || (self.config.tags && self.echo != Echo::No)
    }

    /// Until when an operation has to wait because it cannot be told from another.
    fn drained(&self, now: Now, operation: &Operation) -> Option<Now> {
        if !self.is_doubtful(now, operation) {
            return None;
        }
        if self.tags_work() {
            return self.tags.resting_until(now, self.config.late_bound);
        }
        self.suspicion.until(operation.first(), now, self.config.drain_bound)
    }

    fn requeue(&mut self, operation: Operation) {
        let queue = if operation.is_urgent() { &mut self.urgent } else { &mut self.queue };
        queue.push_front(operation);
    }

    /// What waits is not sent; what is urgent only if `urgent`.
    fn refuse_waiting(&mut self, outcome: &Outcome, urgent: bool) {
        let due = |o: &mut Outstanding| o.due && (urgent || !o.operation.is_urgent());
        let mut refused = Vec::new();
        if let Some(outstanding) = self.outstanding.take_if(due) {
            refused.push(self.give_up(outstanding).operation);
        }
        if urgent {
            refused.extend(self.urgent.drain(..));
        }
        refused.extend(self.queue.drain(..));
        for Operation { ticket, sent, tries, .. } in refused {
            let outcome = if sent { Outcome::Silence { tries } } else { outcome.clone() };
            self.outcomes.push_back((ticket, outcome));
        }
    }

    /// Without connection nothing waits longer than an answer would be waited for.
    fn expire(&mut self, now: Now) {
        let (timeout, outcomes) = (self.config.timeout, &mut self.outcomes);
        for queue in [&mut self.urgent, &mut self.queue] {
            queue.retain(|operation| {
                let alive = now < operation.submitted + timeout;
                if !alive {
                    let outcome =
                        if operation.sent { Outcome::LinkLost } else { Outcome::NotConnected };
                    outcomes.push_back((operation.ticket, outcome));
                }
                alive
            });
        }
    }

    /// A frame has not been answered in time.
    fn try_failed(&mut self, now: Now, mut outstanding: Outstanding) {
        let blind = outstanding.sent < outstanding.believe_from;
        if blind {
            outstanding.due = true;
            self.outstanding = Some(outstanding);
            return;
        }
        self.stats.timeouts += 1;
        // An urgent frame is repeated sooner than silence means anything.
        let long = now >= outstanding.sent + self.config.timeout;
        self.silent_tries += u32::from(long);
        self.check.silence(now);
        self.note_untagged(&mut outstanding);
        let operation = &outstanding.operation;
        let again = self.may_try_again(now, operation);
        let hopeless = outstanding.tag.is_some() && !self.tags_work();
        if again && !hopeless {
            outstanding.due = true;
            self.outstanding = Some(outstanding);
            return;
        }
        let Outstanding { operation, .. } = self.give_up(outstanding);
        if again {
            self.requeue(operation);
        } else {
            let tries = operation.tries;
            self.outcomes.push_back((operation.ticket, Outcome::Silence { tries }));
        }
        self.overtake(now);
    }

    /// An answer came without the tag it should have: the monitor may not know how to answer one.
    fn note_untagged(&mut self, outstanding: &mut Outstanding) {
        if let Echo::Unknown { untagged } = &mut self.echo
            && std::mem::take(&mut outstanding.untagged)
        {
            *untagged += 1;
            if *untagged >= UNTAGGED_PROOF {
                self.echo = Echo::No;
            }
        }
    }

    /// A frame is no longer outstanding, and its answer may still come.
    fn give_up(&mut self, outstanding: Outstanding) -> Outstanding {
        if outstanding.tries > 0 {
            self.settle(&outstanding, false);
        }
        outstanding
    }

    /// Remembers what may still come of a frame.
    fn settle(&mut self, outstanding: &Outstanding, answered: bool) {
        let first = outstanding.operation.first();
        let accounted = answered && outstanding.tries == 1 && !self.config.duplicates;
        if !accounted {
            // What comes first in the answer decides what it can be confused with: of a tagged
            // frame that is the tag, a GetStatus.
            if outstanding.tag.is_some() {
                self.suspicion.raise(Some(RequestId::GET_STATUS), outstanding.sent);
            }
            if outstanding.tag.is_none() || self.echo != Echo::Yes {
                self.suspicion.raise(first, outstanding.sent);
            }
        }
        if self.recent.len() >= RECENT_MAX {
            self.recent.pop_front();
        }
        self.recent.push_back(Recent { tag: outstanding.tag, first, answered });
    }

    fn trace(&mut self, verdict: Verdict, dst: u8, src: u8, tagged: bool, payload: &[u8]) {
        let Some(traced) = &mut self.traced else { return };
        if traced.len() < TRACED_MAX {
            traced.push_back(Traced { verdict, dst, src, tagged, payload: Arc::from(payload) });
        }
    }
}

#[cfg(test)]
mod tests;
