//! Several monitors on one link: a [`Session`] for each address, one frame on the line at a time.
//!
//! A line is half duplex, and behind a TCP connection there may be one. So a session that has sent
//! holds the line until its answer comes or its time is over; then the next one has its turn, round
//! and round. Urgent requests go first, whichever monitor they are for, then what keeps a held motion
//! going; both wait for a frame that is out no longer than [`Config::patience`]. A monitor that has not
//! answered twice is taken for absent: its reads wait for a share of the line that all absent ones
//! have together, until something of it is heard.

use std::cmp::Reverse;
use std::time::Duration;

use lafet_proto::bus::CONTROLLER;

use super::bus_ear::BusEar;
use super::echo::EchoFilter;
use super::input::{Incoming, Input};
use super::medium::{Addresses, Framing, Role};
use super::operation::Haste;
use super::{Config, Now, Outcome, QueueFull, Session, Stats, Terms, Ticket, Traced, Verdict};
use crate::answers::RequestBuf;

/// A controller has tried three times by then: 150, 300 and 600 ms (observed), and the frames.
const CONTROLLER_GIVES_UP: Duration = Duration::from_millis(1200);

/// Absent monitors are asked so seldom that waiting for them takes one part in so many of the line.
const ABSENT_SHARE: u32 = 13;

/// The sessions of a link: see the module's documentation.
#[derive(Debug)]
pub struct Line {
    pub(super) config: Config,
    pub(super) sessions: Vec<Session>,
    input: Input,
    echo: EchoFilter,
    /// Whose turn is looked at first.
    turn: usize,
    /// To which the last frame went, and whether no answer of it was known, or not lately.
    last: Option<(usize, bool)>,
    /// From when on an absent monitor may be asked again.
    absent_from: Now,
    /// One frame may be sent now, in the role `active`.
    pub(super) granted: bool,
    connected: bool,
    connected_at: Now,
    pub(super) heard: Option<Now>,
    /// The connection is a new one: it is listened to from the next look at the time on.
    fresh: bool,
    /// Nothing but what is urgent is sent before.
    listen_until: Now,
    pub(super) bus: BusEar,
    foreign: u64,
    tracing: bool,
}

impl Line {
    /// A line without connection; sessions come into being with the first request to an address.
    pub fn new(config: Config) -> Self {
        let timeout = match config.role {
            Role::Direct => config.timeout,
            Role::Active => config.timeout.max(CONTROLLER_GIVES_UP),
        };
        let config = Config { timeout, ..config };
        Self {
            input: Input::new(Framing::Link),
            echo: EchoFilter::new(config.echo),
            config,
            sessions: Vec::new(),
            turn: 0,
            last: None,
            absent_from: Now::ZERO,
            granted: false,
            connected: false,
            connected_at: Now::ZERO,
            heard: None,
            fresh: false,
            listen_until: Now::ZERO,
            bus: BusEar::default(),
            foreign: 0,
            tracing: false,
        }
    }

    /// How it behaves; the monitor's address is the first one's.
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// Queues requests to the monitor at an address.
    ///
    /// # Errors
    ///
    /// [`QueueFull`] when [`QUEUE_MAX`](super::QUEUE_MAX) requests to this monitor wait already, or
    /// [`URGENT_MAX`](super::URGENT_MAX) urgent ones.
    pub fn submit(
        &mut self,
        now: Now,
        address: u8,
        terms: Terms,
        requests: Vec<RequestBuf>,
    ) -> Result<Ticket, QueueFull> {
        let index = self.index(address);
        self.sessions[index].submit_on(now, terms, requests)
    }

    /// See [`Session::cancel`].
    pub fn cancel(&mut self, ticket: Ticket) {
        if let Some(session) = self.find(ticket.address()) {
            session.cancel(ticket);
        }
    }

    /// There is a connection.
    pub fn handle_connected(&mut self, now: Now) {
        self.connected = true;
        self.fresh = true;
        self.granted = false;
        self.bus = BusEar::default();
        self.input.reset();
        self.echo.reset();
        self.connected_at = now;
        self.sessions.iter_mut().for_each(|session| session.handle_connected(now));
    }

    /// The connection is lost.
    pub fn handle_disconnected(&mut self, now: Now) {
        self.connected = false;
        self.input.reset();
        self.echo.reset();
        self.sessions.iter_mut().for_each(|session| session.handle_disconnected(now));
    }

    /// Bytes of a stream have come.
    pub fn handle_bytes(&mut self, now: Now, bytes: &[u8]) {
        self.heard = Some(now);
        let bytes = self.echo.received(bytes);
        if self.config.framing == Framing::Records {
            // Bare records bear no address: one monitor a connection.
            self.sessions.iter_mut().take(1).for_each(|session| session.handle_bytes(now, &bytes));
            return;
        }
        self.input.push(&bytes);
        self.handle_input(now);
    }

    /// A datagram has come: one link frame (ours).
    pub fn handle_datagram(&mut self, now: Now, datagram: &[u8]) {
        self.input.push_datagram(datagram);
        self.handle_input(now);
    }

    /// Time has passed: see [`Line::poll_timeout`].
    pub fn handle_timeout(&mut self, now: Now) {
        if std::mem::take(&mut self.fresh) {
            self.listen_until = now + self.config.listen;
        }
        self.sessions.iter_mut().for_each(|session| session.handle_timeout(now));
        self.mind_the_others(now);
        self.mind_the_bus(now);
    }

    /// When [`Line::handle_timeout`] or [`Line::poll_transmit`] is to be called at the latest.
    pub fn poll_timeout(&self, now: Now) -> Option<Now> {
        let waiting = |session: &&Session| !self.connected || session.wants(now).is_none();
        let timers = self.sessions.iter().filter(waiting).filter_map(|s| s.poll_timeout(now));
        let absent = self.sessions.iter().filter(|session| session.can_wait());
        let rests = (now < self.absent_from).then_some(self.absent_from);
        let absent = absent.flat_map(|session| session.gives_up_at().into_iter().chain(rests));
        timers.chain(self.send_from(now)).chain(self.bus_timeout(now)).chain(absent).min()
    }

    /// Bytes to send, if any.
    pub fn poll_transmit(&mut self, now: Now) -> Option<Vec<u8>> {
        self.handle_timeout(now);
        if let Some(word) = self.word(now) {
            return self.answer_controller(now, word);
        }
        self.poll_sessions(now)
    }

    fn is_present(&self, index: usize) -> bool {
        self.sessions.get(index).is_some_and(Session::is_present)
    }

    pub(super) fn poll_sessions(&mut self, now: Now) -> Option<Vec<u8>> {
        if self.send_from(now)? > now {
            return None;
        }
        let (haste, count) = (self.haste(now), self.sessions.len());
        // Of the monitors that answer, one has its turn after each that may not, or did not: the one
        // heard last, for when many fall silent at once, the others only seem to answer.
        let doubtful = self.last.is_some_and(|(index, was)| was || !self.is_present(index));
        let mut by_presence = Vec::new();
        if doubtful && count > 1 {
            by_presence.extend(self.round());
            by_presence.sort_by_key(|index| Reverse(self.sessions[*index].present_at()));
        }
        for step in 0..count {
            let index = by_presence.get(step).copied().unwrap_or((self.turn + step) % count);
            if self.wants(&self.sessions[index], now) != haste {
                continue;
            }
            let session = &mut self.sessions[index];
            let (absent, present) = (session.can_wait(), session.is_present());
            let Some(bytes) = session.poll_transmit(now) else { continue };
            if let Some((sent, until)) = session.occupies(now).filter(|_| absent) {
                self.absent_from = now + (until - sent) * ABSENT_SHARE;
            }
            // The round goes on where it was left for a monitor that answers.
            if !(doubtful && present) {
                self.turn = (index + 1) % count;
            }
            self.last = Some((index, !present));
            self.granted = false;
            self.echo.sent(&bytes);
            return Some(bytes);
        }
        None
    }

    /// All sessions, from the one whose turn is looked at first.
    fn round(&self) -> impl Iterator<Item = usize> {
        let (turn, count) = (self.turn, self.sessions.len());
        (0..count).map(move |step| (turn + step) % count)
    }

    /// An operation that has ended.
    pub fn poll_outcome(&mut self) -> Option<(Ticket, Outcome)> {
        self.sessions.iter_mut().find_map(Session::poll_outcome)
    }

    /// A frame that was sent or received.
    pub fn poll_traced(&mut self) -> Option<Traced> {
        self.sessions.iter_mut().find_map(Session::poll_traced)
    }

    /// Keep, or do not keep, every frame for [`Line::poll_traced`].
    pub fn set_tracing(&mut self, on: bool) {
        self.tracing = on;
        self.sessions.iter_mut().for_each(|session| session.set_tracing(on));
    }

    /// What was exchanged with the monitor at an address, and what the link has dropped.
    pub fn stats(&self, address: u8) -> Stats {
        let session = self.sessions.iter().find(|s| s.config().addresses.monitor == address);
        self.counted(session.map(Session::stats).unwrap_or_default())
    }

    /// All addresses together; round trips are those of the first.
    pub fn total(&self) -> Stats {
        let all = self.sessions.iter().map(Session::stats).reduce(Stats::and);
        let all = all.unwrap_or_default();
        let reconnects = self.sessions.iter().map(|session| session.stats().reconnects).max();
        self.counted(Stats { reconnects: reconnects.unwrap_or(0), ..all })
    }

    /// A Stop, Close or Lockout is still to be sent or answered.
    pub fn is_urgent(&self) -> bool {
        self.sessions.iter().any(Session::is_urgent)
    }

    /// Nothing waits and nothing is outstanding.
    pub fn is_idle(&self) -> bool {
        self.sessions.iter().all(Session::is_idle)
    }

    /// Until when a request waits because its monitor does not answer tags (see `doubt`).
    pub fn held_until(&self, now: Now) -> Option<Now> {
        self.sessions.iter().filter_map(|session| session.held_until(now)).max()
    }

    /// Tries in a row that nobody at all has answered: the connection may be half open.
    pub fn silent_tries(&self) -> u32 {
        let used = self.sessions.iter().filter(|session| session.stats().frames_sent > 0);
        used.map(Session::silent_tries).min().unwrap_or(0)
    }

    /// From when on the next frame may go out; `None` if there is none, or no grant.
    fn send_from(&self, now: Now) -> Option<Now> {
        if !self.connected || (self.config.role == Role::Active && !self.granted) {
            return None;
        }
        let haste = self.haste(now)?;
        let free = self.sessions.iter().filter_map(|session| {
            let (sent, until) = session.occupies(now)?;
            let overtaken = sent + self.config.patience;
            Some(if haste == Haste::Usual { until } else { until.min(overtaken) })
        });
        let quiet = self.heard.map(|heard| heard + self.config.turnaround);
        // A console waits for its grant anyway, and the controller itself for nobody.
        let listens = self.config.role == Role::Direct
            && self.config.addresses.source != CONTROLLER
            && haste == Haste::Usual;
        let listened = listens.then_some(self.listen_until);
        Some(free.chain(quiet).chain(listened).fold(now, Now::max))
    }

    /// What presses most of what may be sent now.
    fn haste(&self, now: Now) -> Option<Haste> {
        self.sessions.iter().filter_map(|session| self.wants(session, now)).max()
    }

    /// Absent monitors have a share of the line together, however many they are.
    fn wants(&self, session: &Session, now: Now) -> Option<Haste> {
        let rests = now < self.absent_from && session.can_wait();
        session.wants(now).filter(|_| !rests)
    }

    /// Each monitor's waits follow what the others on the line need.
    fn mind_the_others(&mut self, now: Now) {
        if self.sessions.len() < 2 {
            return;
        }
        let usual: Vec<_> = self.sessions.iter().map(Session::usual).collect();
        for (index, session) in self.sessions.iter_mut().enumerate() {
            let others = usual.iter().enumerate().filter(|(other, _)| *other != index);
            session.set_others(others.filter_map(|(_, usual)| *usual).max());
            session.give_up_reads(now);
        }
    }

    fn handle_input(&mut self, now: Now) {
        while let Some(frame) = self.input.poll_frame(None) {
            if self.heard_controller(now, &frame) {
                continue;
            }
            let to_us = |(dst, _)| dst == self.config.addresses.source;
            let from = frame.addresses.filter(|addresses| to_us(*addresses)).map(|(_, src)| src);
            match from.and_then(|address| self.find(address)) {
                Some(session) => session.handle_incoming(now, &frame),
                None => self.count_foreign(&frame),
            }
        }
    }

    pub(super) fn echo_sent(&mut self, bytes: &[u8]) {
        self.echo.sent(bytes);
    }

    fn count_foreign(&mut self, frame: &Incoming) {
        self.foreign += 1;
        // Shown among the frames of a session, so that the order is kept.
        if let (Some((dst, src)), Some(session)) = (frame.addresses, self.sessions.first_mut()) {
            session.trace(Verdict::Foreign, dst, src, false, &frame.payload);
        }
    }

    fn counted(&self, stats: Stats) -> Stats {
        let stats = match self.config.framing {
            Framing::Records => stats,
            Framing::Link => self.input.counted(stats),
        };
        Stats {
            foreign: stats.foreign + self.foreign,
            collisions: self.echo.collisions(),
            echoes_missing: self.echo.missing(),
            ..stats
        }
    }

    fn find(&mut self, address: u8) -> Option<&mut Session> {
        self.sessions.iter_mut().find(|s| s.config().addresses.monitor == address)
    }

    fn index(&mut self, address: u8) -> usize {
        let same = |session: &Session| session.config().addresses.monitor == address;
        if let Some(index) = self.sessions.iter().position(same) {
            return index;
        }
        let Addresses { source, .. } = self.config.addresses;
        let addresses = Addresses { monitor: address, source };
        // A controller is no monitor (§B): it may not answer what is for subsystems.
        let outlives = self.config.outlives && address != CONTROLLER;
        let mut session = Session::new(Config { addresses, outlives, ..self.config.clone() });
        session.set_tracing(self.tracing);
        if self.connected {
            session.handle_connected(self.connected_at);
        }
        self.sessions.push(session);
        self.sessions.len() - 1
    }
}
