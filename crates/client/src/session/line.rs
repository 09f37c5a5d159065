//! Several monitors on one link: a [`Session`] for each address, one frame on the line at a time.
//!
//! A line is half duplex, and behind a TCP connection there may be one. So a session that has sent
//! holds the line until its answer comes or its time is over; then the next one has its turn, round
//! and round, so that a silent monitor costs the others one timeout for each frame of theirs. Urgent
//! requests go first, whosesoever they are, and wait for a frame that is out no longer than
//! [`Config::patience`].

use std::time::Duration;

use super::bus_ear::BusEar;
use super::echo::EchoFilter;
use super::input::{Incoming, Input};
use super::{Config, Now, Outcome, QueueFull, Session, Stats, Terms, Ticket, Traced, Verdict};
use crate::answers::RequestBuf;
use crate::url::{Addresses, Framing, Role};

/// A controller has tried three times by then: 150, 300 and 600 ms (observed), and the frames.
const CONTROLLER_GIVES_UP: Duration = Duration::from_millis(1200);

/// The sessions of a link: see the module's documentation.
#[derive(Debug)]
pub struct Line {
    pub(super) config: Config,
    pub(super) sessions: Vec<Session>,
    input: Input,
    echo: EchoFilter,
    /// Whose turn is looked at first.
    turn: usize,
    /// One frame may be sent now, in the role `active`.
    pub(super) granted: bool,
    connected: bool,
    pub(super) heard: Option<Now>,
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
            granted: false,
            connected: false,
            heard: None,
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
    pub fn handle_connected(&mut self) {
        self.connected = true;
        self.granted = false;
        self.bus = BusEar::default();
        self.input.reset();
        self.echo.reset();
        self.sessions.iter_mut().for_each(Session::handle_connected);
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
        self.sessions.iter_mut().for_each(|session| session.handle_timeout(now));
        self.mind_the_bus(now);
    }

    /// When [`Line::handle_timeout`] or [`Line::poll_transmit`] is to be called at the latest.
    pub fn poll_timeout(&self, now: Now) -> Option<Now> {
        let waiting = |session: &&Session| !self.connected || session.wants(now).is_none();
        let timers = self.sessions.iter().filter(waiting).filter_map(|s| s.poll_timeout(now));
        timers.chain(self.send_from(now)).chain(self.bus_timeout(now)).min()
    }

    /// Bytes to send, if any.
    pub fn poll_transmit(&mut self, now: Now) -> Option<Vec<u8>> {
        self.handle_timeout(now);
        if let Some(word) = self.word(now) {
            return self.answer_controller(now, word);
        }
        self.poll_sessions(now)
    }

    pub(super) fn poll_sessions(&mut self, now: Now) -> Option<Vec<u8>> {
        if self.send_from(now)? > now {
            return None;
        }
        let urgent = self.sessions.iter().any(|session| session.wants(now) == Some(true));
        let count = self.sessions.len();
        for step in 0..count {
            let index = (self.turn + step) % count;
            let session = &mut self.sessions[index];
            if session.wants(now) != Some(urgent) {
                continue;
            }
            if let Some(bytes) = session.poll_transmit(now) {
                self.turn = (index + 1) % count;
                self.granted = false;
                self.echo.sent(&bytes);
                return Some(bytes);
            }
        }
        None
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
        let urgent = self.sessions.iter().filter_map(|session| session.wants(now)).max()?;
        let free = self.sessions.iter().filter_map(|session| {
            let (sent, until) = session.occupies(now)?;
            let overtaken = sent + self.config.patience;
            Some(if urgent { until.min(overtaken) } else { until })
        });
        let quiet = self.heard.map(|heard| heard + self.config.turnaround);
        Some(free.chain(quiet).fold(now, Now::max))
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
        let mut session = Session::new(Config { addresses, ..self.config.clone() });
        session.set_tracing(self.tracing);
        if self.connected {
            session.handle_connected();
        }
        self.sessions.push(session);
        self.sessions.len() - 1
    }
}
