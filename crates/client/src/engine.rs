//! What a client has of its line: sessions, link, times, and who waits for what.
//!
//! # Who serves the link
//!
//! The engine is locked within a single poll, never across an await, so that none can keep it from
//! others: the task of the link ([`crate::task`]), callers that wait for their outcome
//! ([`crate::exchange`]). Each poll of each of them serves the line completely ([`Engine::drive`]):
//! it reads what has come, sends what may be sent, and hands outcomes to whom they belong. When it
//! unlocks the engine, there is nothing left that could be done:
//!
//! - The link has [`Turn`] as its waker, or `Turn` has been signalled. It wakes the leader: the
//!   caller whose frame is on the line; without one the task. A leader is set only while the task
//!   looks at the link every 20 ms by itself ([`Lead`]), so that one that is not polled delays the
//!   link by 20 ms at most; then none leads for a second.
//! - The alarm of the task is not later than what is due next, or the task has been woken.
//! - While a Stop, Close or Lockout waits, no caller leads. Its own first poll sends it.
//!
//! Nothing that runs under the lock waits for code of callers, except the stream they gave.
//!
//! A caller whose future is dropped cancels its operation and wakes the task, for it may have been
//! woken in vain.

use std::io;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use lafet_proto::link::WIRE_MAX;
use lafet_proto::{RequestId, SubsystemId};
use tokio::time::Instant;

use crate::answers::{RequestBuf, Requests};
use crate::lead::Lead;
use crate::session::line::Line;
use crate::session::statistics::Meter;
use crate::session::{Config, Now, Outcome, QueueFull, Slot, Stats, Terms, Ticket};
use crate::shared::{LinkEvent, LinkState, Shared, lock};
use crate::transport::Link;
use crate::turn::Turn;

/// Consecutive transmissions without answer after which a TCP connection is replaced: it may be
/// half open.
pub const SILENT_TRIES_MAX: u32 = 2;
/// Pause after the first connection that failed; doubled after each further failure.
const REDIAL_FIRST: Duration = Duration::from_millis(100);
/// The longest pause.
const REDIAL_LAST: Duration = Duration::from_secs(2);
/// Most pieces read before others have their turn.
const READS_MAX: usize = 16;

/// Requests of one frame.
#[derive(Debug)]
pub struct Job {
    pub address: u8,
    pub requests: Requests,
    /// The first frame of the same batch.
    pub first: Option<Ticket>,
    /// Time after which it must not be sent.
    pub expires: Option<Instant>,
    urgent: bool,
    read: bool,
    of_motion: bool,
}

impl Job {
    pub fn new(
        address: u8,
        requests: Requests,
        first: Option<Ticket>,
        expires: Option<Instant>,
    ) -> Self {
        let all = |of: fn(&RequestBuf) -> bool| !requests.is_empty() && requests.iter().all(of);
        let (urgent, read) = (all(RequestBuf::is_urgent), all(RequestBuf::is_read));
        Self { address, requests, first, expires, urgent, read, of_motion: false }
    }

    /// It belongs to a held motion.
    pub fn of_motion(self) -> Self {
        Self { of_motion: true, ..self }
    }

    /// What it sets in motion, unless it belongs to a held motion: the places of such requests, and their drives, or all.
    fn begins(&self) -> Vec<(usize, Option<SubsystemId>)> {
        if self.urgent || self.read || self.of_motion {
            return Vec::new();
        }
        let begins = |request: &RequestBuf| match request.id() {
            RequestId::MOVE => Some(Some(request.to())),
            RequestId::START_QUENCH
            | RequestId::START_TRAJECTORY
            | RequestId::START_SEEK
            | RequestId::START_JUSTIFY
            | RequestId::DEPLOY
            | RequestId::WRAP => Some(None),
            _ => None,
        };
        let all = self.requests.iter().enumerate();
        all.filter_map(|(at, request)| Some((at, begins(request)?))).collect()
    }

    /// The drive that it stops for a held motion which has ended.
    fn ends(&self) -> Option<(u8, SubsystemId)> {
        let request = self.requests.first().filter(|_| self.urgent && self.of_motion);
        request.map(|request| (self.address, request.to()))
    }

    /// Whether it is sent before others.
    pub const fn is_urgent(&self) -> bool {
        self.urgent
    }

    /// Whether it only reads: whatever comes after it loses nothing.
    const fn is_read(&self) -> bool {
        self.read
    }
}

pub type Reply = Result<Ended, QueueFull>;

/// How a job ended, and the latest error of the link.
#[derive(Debug)]
pub struct Ended {
    pub outcome: Outcome,
    /// `None`: it did not reach a session.
    pub ticket: Option<Ticket>,
    link: Option<Arc<io::Error>>,
}

impl Ended {
    /// An outcome with the latest error of the link.
    pub const fn new(
        outcome: Outcome,
        ticket: Option<Ticket>,
        link: Option<Arc<io::Error>>,
    ) -> Self {
        Self { outcome, ticket, link }
    }

    /// The latest error of the link.
    pub fn source(&self) -> Arc<io::Error> {
        self.link.clone().unwrap_or_else(|| Arc::new(io::ErrorKind::NotConnected.into()))
    }
}

/// A caller that waits.
#[derive(Debug)]
struct Waiting {
    ticket: Ticket,
    since: Now,
    waker: Waker,
    ended: Option<Ended>,
    address: u8,
    /// See [`Job::begins`].
    begins: Vec<(usize, Option<SubsystemId>)>,
    /// See [`Job::ends`].
    ends: Option<(u8, SubsystemId)>,
}

/// The frame is being sent.
#[derive(Debug)]
struct Unsent {
    /// Bytes of it that are gone.
    sent: usize,
    until: Now,
}

/// The engine of a link: see the module's documentation.
#[derive(Debug)]
pub struct Engine {
    line: Line,
    link: Option<Link>,
    /// The task replaces a lost link.
    redials: bool,
    /// There are handles.
    open: bool,
    /// The task runs.
    runs: bool,
    pause: Duration,
    error: Option<Arc<io::Error>>,
    shared: Arc<Shared>,
    state: LinkState,
    /// `state` is to be published.
    changed: bool,
    meter: Option<Meter>,
    /// End of the time in which requests are held back, as last reported.
    held: Now,
    waiting: Vec<Waiting>,
    /// The latest frame.
    frame: Vec<u8>,
    unsent: Option<Unsent>,
    /// When something is to be done without bytes of the link.
    due: Option<Now>,
    lead: Lead,
    turn: Arc<Turn>,
    /// Of `turn`.
    waker: Waker,
    buffer: Box<[u8]>,
    start: Instant,
}

/// What the task of the link does next.
#[derive(Debug, PartialEq, Eq)]
pub enum Next {
    /// It ends.
    End,
    /// It connects again; otherwise it waits for its alarm, if there is one.
    Wait { dial: Option<Dial>, alarm: Option<Instant> },
}

/// How the task connects again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dial {
    /// Before it does.
    pub pause: Duration,
    /// A Stop, Close or Lockout waits for it.
    pub urgent: bool,
}

impl Engine {
    pub fn new(config: Config, link: Link, redials: bool, shared: Arc<Shared>) -> Self {
        let mut line = Line::new(config);
        line.handle_connected(Now::ZERO);
        let turn = Arc::new(Turn::default());
        // It has not been read from yet.
        turn.signal();
        Self {
            line,
            link: Some(link),
            redials,
            open: true,
            runs: true,
            pause: Duration::ZERO,
            error: None,
            shared,
            state: LinkState::CONNECTED,
            changed: false,
            meter: None,
            held: Now::ZERO,
            waiting: Vec::new(),
            frame: Vec::new(),
            unsent: None,
            due: None,
            lead: Lead::default(),
            waker: Waker::from(turn.clone()),
            turn,
            buffer: vec![0; 2 * WIRE_MAX].into(),
            start: Instant::now(),
        }
    }

    pub fn now(&self) -> Now {
        self.start.elapsed()
    }

    pub const fn turn(&self) -> &Arc<Turn> {
        &self.turn
    }

    /// Counters of the exchange with a monitor.
    pub fn stats(&self, address: u8) -> Stats {
        self.line.stats(address)
    }

    /// Counters of the exchange with all monitors.
    pub fn total(&self) -> Stats {
        self.line.total()
    }

    /// The last handle was dropped: urgent requests are still served.
    pub fn close(&mut self) {
        self.open = false;
        self.turn.wake_task();
    }

    /// Queues a job of the caller with this waker; an error is the reply. Urgent ones are sent, and
    /// reads that nothing waits for: a caller that wakes itself costs two system calls.
    pub fn submit(&mut self, now: Now, job: Job, waker: &Waker) -> Result<Ticket, Option<Reply>> {
        if !self.runs {
            return Err(None);
        }
        if self.link.is_none() && !self.redials {
            let ended = Ended::new(Outcome::NotConnected, None, self.error.clone());
            return Err(Some(Ok(ended)));
        }
        let (urgent, read) = (job.is_urgent(), job.is_read());
        let expires = job.expires.map(|time| time.saturating_duration_since(self.start));
        let terms = Terms { first: job.first, expires };
        let (address, begins, ends) = (job.address, job.begins(), job.ends());
        let ticket = match self.line.submit(now, address, terms, job.requests) {
            Ok(ticket) => ticket,
            Err(full) => return Err(Some(Err(full))),
        };
        let waker = waker.clone();
        let waiting = Waiting { ticket, since: now, waker, ended: None, address, begins, ends };
        self.waiting.push(waiting);
        self.lead.submitted(now);
        self.due = Some(now);
        let leads = self.lead.is_allowed() && self.line.awaited().is_none();
        if leads && !urgent && !read {
            // It is sent by the next poll: a Stop that is submitted in the same moment goes first.
            self.waiting.last().inspect(|caller| caller.waker.wake_by_ref());
            return Ok(ticket);
        }
        if urgent || leads {
            self.drive(now, None);
        } else {
            self.due = self.next_due(now);
        }
        self.wake_if_late();
        if urgent && self.link.is_none() {
            self.turn.wake_task();
        }
        Ok(ticket)
    }

    /// The outcome of a caller's operation. Serves the link if the caller may lead.
    pub fn poll(&mut self, ticket: Ticket, waker: &Waker) -> Poll<Option<Reply>> {
        let Some(index) = self.place(ticket) else { return Poll::Ready(None) };
        if self.waiting[index].ended.is_none() && self.runs {
            self.waiting[index].waker.clone_from(waker);
            if !self.lead.is_allowed() {
                return Poll::Pending;
            }
            let now = self.now();
            self.drive(now, Some(ticket));
            self.wake_if_late();
        }
        match &self.waiting[index].ended {
            None if self.runs => Poll::Pending,
            _ => Poll::Ready(self.waiting.swap_remove(index).ended.map(Ok)),
        }
    }

    /// The caller does not wait for the outcome any more.
    pub fn forget(&mut self, ticket: Ticket) {
        if let Some(index) = self.place(ticket) {
            self.waiting.swap_remove(index);
        }
        self.line.cancel(ticket);
        self.due = Some(self.now());
        self.turn.set_leader(None);
        self.turn.wake_task();
    }

    /// What the task does when it is polled.
    pub fn work(&mut self) -> Next {
        let now = self.now();
        self.drive(now, None);
        if !self.open && !self.line.is_urgent() {
            return Next::End;
        }
        let due = self.lead.look(now, self.due);
        if !self.lead.is_allowed() {
            self.turn.set_leader(None);
        }
        let dial = (self.link.is_none() && self.redials).then(|| self.dial());
        Next::Wait { dial, alarm: due.map(|due| self.start + due) }
    }

    fn dial(&self) -> Dial {
        let urgent = self.line.is_urgent();
        let longest = if urgent { REDIAL_FIRST } else { REDIAL_LAST };
        Dial { pause: self.pause.min(longest), urgent }
    }

    /// The task has ended: callers get no outcome any more.
    pub fn end(&mut self) {
        self.runs = false;
        self.link = None;
        self.turn.set_leader(None);
        self.waiting.iter().for_each(|caller| caller.waker.wake_by_ref());
    }

    /// The task opens a connection: the pause before the next attempt.
    pub fn dialing(&mut self) {
        self.pause = (self.pause * 2).clamp(REDIAL_FIRST, REDIAL_LAST);
    }

    /// The task has opened a connection, or could not.
    pub fn dialed(&mut self, link: io::Result<Link>) {
        match link {
            Ok(link) => {
                self.link = Some(link);
                self.line.handle_connected(self.now());
                self.turn.signal();
                self.state.up = true;
                self.changed = true;
                self.shared.events.send(LinkEvent::Up);
            }
            Err(error) => self.error = Some(Arc::new(error)),
        }
    }

    /// What to publish when the engine is unlocked: a listener may hold on to the former state while
    /// it locks the engine.
    pub fn news(&mut self) -> Option<LinkState> {
        std::mem::take(&mut self.changed).then_some(self.state)
    }

    fn place(&self, ticket: Ticket) -> Option<usize> {
        self.waiting.iter().position(|caller| caller.ticket == ticket)
    }

    /// Does all that can be done now, for a caller with this operation or for the task.
    fn drive(&mut self, now: Now, own: Option<Ticket>) {
        let signalled = self.turn.take_signal();
        let due = self.due.is_some_and(|due| due <= now);
        if signalled || due {
            self.line.set_tracing(self.shared.trace.is_listened_to());
            if signalled {
                self.flush(now);
                self.receive(now);
            }
            if due {
                self.timed_out(now);
            }
            // The Stop of a motion that is over by an answer which has come is not sent.
            if self.waiting.iter().any(|it| it.ends.is_some()) {
                self.deliver(now, own);
            }
            self.transmit(now);
            self.deliver(now, own);
            self.due = self.next_due(now);
        }
        self.choose_leader();
    }

    fn next_due(&self, now: Now) -> Option<Now> {
        let meter = self.meter.as_ref().map(Meter::poll_timeout);
        let line = match &self.unsent {
            Some(unsent) => Some(unsent.until),
            None => self.line.poll_timeout(now),
        };
        line.into_iter().chain(meter).min()
    }

    fn choose_leader(&mut self) {
        let next = self.lead.is_allowed().then(|| self.line.awaited()).flatten();
        let caller = next.and_then(|ticket| self.place(ticket));
        self.turn.set_leader(caller.map(|index| self.waiting[index].waker.clone()));
    }

    fn wake_if_late(&self) {
        if self.lead.is_late_for(self.due) {
            self.turn.wake_task();
        }
    }

    fn receive(&mut self, now: Now) {
        let mut cx = Context::from_waker(&self.waker);
        for _ in 0..READS_MAX {
            let Some(link) = &mut self.link else { return };
            let Poll::Ready(read) = link.poll_recv(&mut cx, &mut self.buffer) else { return };
            match (read, link.is_datagram()) {
                (Ok(len), true) => self.line.handle_datagram(now, &self.buffer[..len]),
                (Ok(len), false) => self.line.handle_bytes(now, &self.buffer[..len]),
                (Err(error), _) => return self.lost(now, error),
            }
        }
        self.turn.signal();
    }

    fn transmit(&mut self, now: Now) {
        // The rest of a frame goes before any other, or both would be lost.
        if self.unsent.is_some() {
            return;
        }
        if !self.line.transmit(now, &mut self.frame) {
            return;
        }
        // A peer that does not read must not delay urgent requests without limit.
        let until = now + self.line.config().timeout;
        self.unsent = Some(Unsent { sent: 0, until });
        self.flush(now);
    }

    fn flush(&mut self, now: Now) {
        let (Some(unsent), Some(link)) = (&mut self.unsent, &mut self.link) else { return };
        let mut cx = Context::from_waker(&self.waker);
        match link.poll_send(&mut cx, &self.frame, &mut unsent.sent) {
            Poll::Ready(Ok(())) => self.unsent = None,
            Poll::Ready(Err(error)) => self.lost(now, error),
            Poll::Pending => {}
        }
    }

    fn deliver(&mut self, now: Now, own: Option<Ticket>) {
        while let Some((ticket, outcome)) = self.line.poll_outcome() {
            if let Outcome::Answered(_) = outcome {
                self.pause = Duration::ZERO;
            }
            let Some(index) = self.place(ticket) else { continue };
            if !self.waiting[index].begins.is_empty() {
                self.begun(index, &outcome);
            }
            let caller = &mut self.waiting[index];
            caller.ended = Some(Ended::new(outcome, Some(ticket), self.error.clone()));
            self.lead.ended(now, caller.since, own.is_some());
            if own != Some(ticket) {
                caller.waker.wake_by_ref();
            }
        }
        if self.line.is_tracing() {
            while let Some(traced) = self.line.poll_traced() {
                self.shared.trace.send(traced);
            }
        }
        self.report(now);
    }

    /// What has set drives in motion is answered: motions of them that were being stopped are over, and so are their Stops
    /// that wait.
    #[cold]
    fn begun(&mut self, index: usize, outcome: &Outcome) {
        let Outcome::Answered(slots) = outcome else { return };
        let Waiting { since, address, begins, .. } = &mut self.waiting[index];
        let (submitted, address, begins) = (self.start + *since, *address, std::mem::take(begins));
        for (at, drive) in begins {
            let accepted = slots.get(at).is_some_and(
                |slot| matches!(slot, Slot::Answered(it) if it.first().status().is_success()),
            );
            if !accepted {
                continue;
            }
            for drive in self.shared.begun(address, drive, submitted) {
                let of = self.waiting.iter().filter(|it| it.ends == Some((address, drive)));
                of.filter(|it| it.ended.is_none()).for_each(|it| self.line.recall(it.ticket));
            }
        }
    }

    /// Publishes the statistics of each second while there are listeners.
    fn report(&mut self, now: Now) {
        if self.shared.events.is_listened_to() {
            self.report_to_listeners(now);
        } else if self.meter.is_some() {
            self.meter = None;
        }
    }

    #[cold]
    fn report_to_listeners(&mut self, now: Now) {
        if let Some(until) = self.line.held_until(now).filter(|until| *until > self.held) {
            self.held = until;
            self.shared.events.send(LinkEvent::Held(until - now));
        }
        let total = self.line.total();
        let meter = self.meter.get_or_insert_with(|| Meter::new(now, total));
        if let Some(figures) = meter.poll(now, total) {
            self.shared.events.send(LinkEvent::Statistics(Box::new(figures)));
        }
    }

    fn timed_out(&mut self, now: Now) {
        if let Some(unsent) = &self.unsent {
            if now >= unsent.until {
                self.lost(now, io::ErrorKind::TimedOut.into());
            }
            return;
        }
        if !self.link.as_ref().is_some_and(Link::can_be_half_open)
            || self.line.silent_tries() + 1 < SILENT_TRIES_MAX
        {
            return;
        }
        self.replace_half_open(now);
    }

    #[cold]
    fn replace_half_open(&mut self, now: Now) {
        // One more may have passed.
        self.line.handle_timeout(now);
        if self.line.silent_tries() >= SILENT_TRIES_MAX {
            // The time without answers was pause enough.
            self.pause = Duration::ZERO;
            self.lost(now, io::ErrorKind::TimedOut.into());
        }
    }

    #[cold]
    fn lost(&mut self, now: Now, error: io::Error) {
        let error = Arc::new(error);
        let link = self.link.take();
        if self.redials {
            // What it still holds must not arrive after what the next one sends.
            link.iter().for_each(Link::abandon);
        }
        self.unsent = None;
        self.error = Some(error.clone());
        self.line.handle_disconnected(now);
        // The next connection may lead to another monitor.
        lock(&self.shared.holds).clear();
        self.state = LinkState { up: false, gone: !self.redials, losses: self.state.losses + 1 };
        self.changed = true;
        self.shared.events.send(LinkEvent::Down(error));
        self.turn.wake_task();
    }
}

/// The engine for its callers; dropped with the last handle of the client.
#[derive(Debug)]
pub struct Handle(Arc<Mutex<Engine>>);

impl Handle {
    pub const fn new(engine: Arc<Mutex<Engine>>) -> Self {
        Self(engine)
    }

    pub fn engine(&self) -> &Mutex<Engine> {
        &self.0
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        lock(&self.0).close();
    }
}
