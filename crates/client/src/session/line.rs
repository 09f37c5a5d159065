//! Several monitors on one link: a [`Session`] for each address, one frame on the line at a time.
//!
//! A line is half duplex, and there may be one behind a TCP connection. So a session that has sent
//! a frame occupies the line until its answer comes or its time limit passes; then the next session
//! has its turn, in rotation. Urgent requests come first, for any monitor, then the frames of a
//! held motion; both wait at most [`Config::patience`] for an outstanding frame. A monitor that has
//! not answered twice counts as absent: its reads wait for the share of the line that all absent
//! ones have together, until a frame of it is received. An urgent frame to it takes the line no
//! longer than a read does, and its repetitions give way to the frames of others for a while.

use std::cmp::Reverse;
use std::time::Duration;

use lafet_proto::bus::CONTROLLER;

use super::bus_access::BusAccess;
use super::echo::EchoFilter;
use super::input::{Incoming, Input};
use super::medium::{Addresses, Framing, Role};
use super::noise::Noise;
use super::operation::Haste;
use super::{Config, Now, Outcome, QueueFull, Session, Stats, Terms, Ticket, Traced, Verdict};
use crate::answers::Requests;

/// By then a controller has tried three times: 150, 300 and 600 ms (observed), and the frames.
const CONTROLLER_GIVES_UP: Duration = Duration::from_millis(1200);

/// Waiting for absent monitors takes at most one part in this many of the line's time.
const ABSENT_SHARE: u32 = 13;

/// Whose turn it is.
#[derive(Clone, Copy, Debug, Default)]
struct Rotation {
    /// Index of the session that is considered first.
    next: usize,
    /// Session of the last frame, and whether its monitor had not answered, or not recently.
    last: Option<(usize, bool)>,
}

/// The sessions of a link: see the module's documentation.
#[derive(Debug)]
pub struct Line {
    pub(super) config: Config,
    pub(super) sessions: Vec<Session>,
    input: Input,
    echo: EchoFilter,
    /// What is urgent has its own: it does not change whose turn it is among the other frames.
    rotation: Rotation,
    urgent: Rotation,
    /// Earliest time to send to an absent monitor again.
    absent_from: Now,
    /// Until then repetitions of what is urgent, for absent monitors, give way to other frames.
    repeat_from: Now,
    /// Since when they do.
    rests_since: Now,
    /// In the role `active`: one frame may be sent now.
    pub(super) granted: bool,
    connected: bool,
    connected_at: Now,
    pub(super) heard: Option<Now>,
    /// The connection is new: listening starts at the next call with a time.
    fresh: bool,
    /// Until then only urgent frames are sent.
    listen_until: Now,
    pub(super) bus: BusAccess,
    /// Where it is heeded.
    pub(super) noise: Option<Noise>,
    foreign: u64,
    tracing: bool,
}

impl Line {
    /// A line without connection; a session is created with the first request to an address.
    pub fn new(config: Config) -> Self {
        let config = config.bounded();
        let timeout = match config.role {
            Role::Direct => config.timeout,
            Role::Active => config.timeout.max(CONTROLLER_GIVES_UP),
        };
        let config = Config { timeout, ..config };
        let heed = config.heed;
        Self {
            input: Input::new(Framing::Link),
            echo: EchoFilter::new(config.echo),
            config,
            sessions: Vec::new(),
            rotation: Rotation::default(),
            urgent: Rotation::default(),
            absent_from: Now::ZERO,
            repeat_from: Now::ZERO,
            rests_since: Now::ZERO,
            granted: false,
            connected: false,
            connected_at: Now::ZERO,
            heard: None,
            fresh: false,
            listen_until: Now::ZERO,
            bus: BusAccess::default(),
            noise: heed.then(Noise::default),
            foreign: 0,
            tracing: false,
        }
    }

    /// The configuration; its monitor address is that of the first session.
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
        requests: impl Into<Requests>,
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

    /// See [`Session::recall`].
    pub(crate) fn recall(&mut self, ticket: Ticket) {
        if let Some(session) = self.find(ticket.address()) {
            session.recall(ticket);
        }
    }

    /// The connection is open.
    pub fn handle_connected(&mut self, now: Now) {
        self.connected = true;
        self.fresh = true;
        self.granted = false;
        self.bus = BusAccess::default();
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

    /// Takes bytes of a stream.
    pub fn handle_bytes(&mut self, now: Now, bytes: &[u8]) {
        self.heard = Some(now);
        let bytes = self.echo.received(bytes);
        if let Some(noise) = &mut self.noise
            && !bytes.is_empty()
        {
            noise.received(now);
        }
        self.take_bytes(now, &bytes);
        if self.noise.is_some() {
            // Each of them puts off what waits for silence; it is refused when it would wait in vain.
            self.end_vain_waits(now);
        }
    }

    fn take_bytes(&mut self, now: Now, mut bytes: &[u8]) {
        if self.config.framing == Framing::Records {
            // Bare records have no addresses: one monitor for each connection.
            self.sessions.iter_mut().take(1).for_each(|session| session.handle_bytes(now, bytes));
            return;
        }
        while !bytes.is_empty() {
            let Some(frame) = self.input.take(&mut bytes, None) else { return };
            self.handle_frame(now, &frame);
        }
    }

    /// Takes a datagram: one link frame (ours).
    pub fn handle_datagram(&mut self, now: Now, datagram: &[u8]) {
        if let Some(frame) = self.input.take_datagram(datagram) {
            self.handle_frame(now, &frame);
        }
    }

    /// Handles the time: see [`Line::poll_timeout`].
    pub fn handle_timeout(&mut self, now: Now) {
        if std::mem::take(&mut self.fresh) {
            self.listen_until = now + self.listens_for();
        }
        self.sessions.iter_mut().for_each(|session| session.handle_timeout(now));
        self.adapt_waits(now);
        self.end_vain_waits(now);
    }

    /// Latest time for the next call of [`Line::handle_timeout`] or [`Line::poll_transmit`].
    pub fn poll_timeout(&self, now: Now) -> Option<Now> {
        if self.rests() {
            return None;
        }
        if let [session] = &*self.sessions
            && self.bus.rests()
            && let Some(deadline) = session.only_awaits()
        {
            debug_assert_eq!(self.timeout_of_all(now), Some(deadline));
            return Some(deadline);
        }
        self.timeout_of_all(now)
    }

    fn timeout_of_all(&self, now: Now) -> Option<Now> {
        let rests = (now < self.absent_from).then_some(self.absent_from);
        let (mut next, mut haste) = (self.bus_timeout(now), None);
        let mut at = |time: Option<Now>| next = next.into_iter().chain(time).min();
        for session in &self.sessions {
            let wants = self.gives_way(session, now, session.wants(now));
            if wants == Some(Haste::Again) {
                at(Some(self.repeat_from));
            }
            if !self.connected || wants.is_none() {
                at(session.poll_timeout(now));
            }
            if session.can_wait() {
                at(session.gives_up_at());
                at(rests);
            }
            if rests.is_none() || !session.can_wait() {
                haste = haste.max(wants);
            }
        }
        at(haste.and_then(|haste| self.send_from(now, haste)));
        next
    }

    /// The next bytes to send.
    pub fn poll_transmit(&mut self, now: Now) -> Option<Vec<u8>> {
        let mut wire = Vec::new();
        self.transmit(now, &mut wire).then_some(wire)
    }

    /// Replaces the contents of `wire` by the next bytes to send, if there are any.
    pub fn transmit(&mut self, now: Now, wire: &mut Vec<u8>) -> bool {
        if self.rests() {
            return false;
        }
        self.handle_timeout(now);
        match self.word(now) {
            Some(word) => self.answer_controller(now, word, wire),
            None => self.transmit_sessions(now, wire),
        }
    }

    /// Whether nothing is to be done until an operation is submitted or bytes are received.
    fn rests(&self) -> bool {
        !self.fresh && self.bus.rests() && self.sessions.iter().all(Session::rests)
    }

    fn is_present(&self, index: usize) -> bool {
        self.sessions.get(index).is_some_and(Session::is_present)
    }

    pub(super) fn transmit_sessions(&mut self, now: Now, wire: &mut Vec<u8>) -> bool {
        // The highest priority among the frames that may be sent now.
        let wants = match &*self.sessions {
            // Alone, it gives way to no other.
            [session] => session.wants(now),
            sessions => sessions.iter().filter_map(|session| self.wants(session, now)).max(),
        };
        let Some(haste) = wants else { return false };
        if self.send_from(now, haste).is_none_or(|from| from > now) {
            return false;
        }
        let count = self.sessions.len();
        if count == 1 {
            return self.transmit_session(0, now, wire);
        }
        let Rotation { next, last } = *self.rotation_of(haste);
        // After each monitor that did not or may not answer, one that answers has its turn: the one
        // heard most recently, because when many stop answering at once, the others only seem to
        // answer.
        let doubtful = last.is_some_and(|(index, was)| was || !self.is_present(index));
        let by_presence = if doubtful { self.by_presence(next) } else { Vec::new() };
        for step in 0..count {
            let index = by_presence.get(step).copied().unwrap_or((next + step) % count);
            if self.wants(&self.sessions[index], now) != Some(haste) {
                continue;
            }
            let present = self.is_present(index);
            if !self.transmit_session(index, now, wire) {
                continue;
            }
            let rotation = self.rotation_of(haste);
            rotation.last = Some((index, !present));
            // The rotation continues where it was left for a monitor that answers.
            if !(doubtful && present) {
                rotation.next = (index + 1) % count;
            }
            return true;
        }
        false
    }

    const fn rotation_of(&mut self, haste: Haste) -> &mut Rotation {
        match haste {
            Haste::Urgent | Haste::Again => &mut self.urgent,
            Haste::Usual | Haste::Held => &mut self.rotation,
        }
    }

    fn transmit_session(&mut self, index: usize, now: Now, wire: &mut Vec<u8>) -> bool {
        let session = &mut self.sessions[index];
        let absent = session.is_absent().then(|| (session.can_wait(), session.repeats_in_vain()));
        if !session.transmit(now, wire) {
            return false;
        }
        if let Some((reads, repeats)) = absent {
            self.sent_to_absent(index, now, reads, repeats);
        }
        self.granted = false;
        if let Some(noise) = &mut self.noise {
            noise.sent(now);
        }
        self.echo.sent(wire);
        true
    }

    /// Notes when the next frame may be sent to an absent monitor: the frame was a read, or repeats
    /// what is urgent.
    #[cold]
    fn sent_to_absent(&mut self, index: usize, now: Now, reads: bool, repeats: bool) {
        let session = &self.sessions[index];
        if reads && let Some((sent, until)) = session.occupies(now) {
            self.absent_from = now + (until - sent) * ABSENT_SHARE;
        }
        let many = self.sessions.iter().filter(|it| it.is_urgent() && it.is_absent()).count();
        let Some(rest) = session.rest_in_vain(many) else { return };
        // However often something is urgent for the first time, repetitions wait no longer than
        // the timeout.
        if repeats || now >= self.repeat_from {
            self.rests_since = now;
        }
        self.repeat_from = (now + rest).min(self.rests_since + self.config.timeout);
    }

    /// Indexes of all sessions, that of the monitor heard most recently first.
    #[cold]
    fn by_presence(&self, next: usize) -> Vec<usize> {
        let count = self.sessions.len();
        let mut indexes: Vec<usize> = (0..count).map(|step| (next + step) % count).collect();
        indexes.sort_by_key(|index| Reverse(self.sessions[*index].present_at()));
        indexes
    }

    /// The next operation that has ended.
    pub fn poll_outcome(&mut self) -> Option<(Ticket, Outcome)> {
        self.sessions.iter_mut().find_map(Session::poll_outcome)
    }

    /// The next recorded frame.
    pub fn poll_traced(&mut self) -> Option<Traced> {
        self.sessions.iter_mut().find_map(Session::poll_traced)
    }

    /// Whether frames are recorded.
    pub const fn is_tracing(&self) -> bool {
        self.tracing
    }

    /// Switches the recording of frames for [`Line::poll_traced`].
    pub fn set_tracing(&mut self, on: bool) {
        if on == self.tracing {
            return;
        }
        self.tracing = on;
        self.sessions.iter_mut().for_each(|session| session.set_tracing(on));
    }

    /// Counters of the exchange with the monitor at an address, and of frames dropped on the link.
    pub fn stats(&self, address: u8) -> Stats {
        let session = self.sessions.iter().find(|s| s.config().addresses.monitor == address);
        self.counted(session.map(Session::stats).unwrap_or_default())
    }

    /// Counters of all addresses together; round trips are those of the first.
    pub fn total(&self) -> Stats {
        let all = self.sessions.iter().map(Session::stats).reduce(Stats::and);
        let all = all.unwrap_or_default();
        let reconnects = self.sessions.iter().map(|session| session.stats().reconnects).max();
        self.counted(Stats { reconnects: reconnects.unwrap_or(0), ..all })
    }

    /// Whether a Stop, Close or Lockout is still to be sent or answered.
    pub fn is_urgent(&self) -> bool {
        self.sessions.iter().any(Session::is_urgent)
    }

    /// The operation whose answer is awaited; none while an urgent one is to be sent or answered.
    pub fn awaited(&self) -> Option<Ticket> {
        if self.is_urgent() {
            return None;
        }
        let mut sent = self.sessions.iter().filter_map(|session| session.outstanding.as_ref());
        sent.find(|outstanding| !outstanding.due).map(|outstanding| outstanding.operation.ticket)
    }

    /// Whether no operation is waiting or outstanding.
    pub fn is_idle(&self) -> bool {
        self.sessions.iter().all(Session::is_idle)
    }

    /// Time until which a request waits because its monitor does not answer tags (see `late_answers`).
    pub fn held_until(&self, now: Now) -> Option<Now> {
        self.sessions.iter().filter_map(|session| session.held_until(now)).max()
    }

    /// Timeouts for which one monitor was not heard since any was: a TCP connection may be half open. Monitors that were
    /// not heard on it say nothing of it while others were: they may be off.
    pub fn silent_tries(&self) -> u32 {
        let heard = |session: &Session| session.heard_since(self.connected_at);
        let latest = self.sessions.iter().filter_map(heard).max();
        let of = self.sessions.iter().filter(|it| latest.is_none() || heard(it).is_some());
        of.map(|session| session.unheard.since(latest)).max().unwrap_or(0)
    }

    /// Earliest time of the next frame, which has this priority; `None` without a grant.
    fn send_from(&self, now: Now, haste: Haste) -> Option<Now> {
        if !self.connected || (self.config.role == Role::Active && !self.granted) {
            return None;
        }
        let free = self.sessions.iter().filter_map(|session| {
            let (sent, until) = session.occupies(now)?;
            let overtaken = sent + self.config.patience;
            Some(if haste <= Haste::Usual { until } else { until.min(overtaken) })
        });
        // Before a grant was used, the pause has passed.
        let heard = self.heard.filter(|_| !self.granted);
        let quiet = heard.map(|heard| heard + self.config.turnaround);
        // Bytes without end must not hold back a Stop.
        let at_most = if haste == Haste::Urgent { self.urgent_since() } else { None };
        let longest = self.config.patience.max(self.config.turnaround);
        let quiet = quiet.map(|until| at_most.map_or(until, |since| until.min(since + longest)));
        // A console waits for its grant anyway; the controller itself does not wait.
        let listens = self.config.role == Role::Direct
            && (self.config.heed || self.config.addresses.source != CONTROLLER)
            && haste == Haste::Usual;
        let listened = listens.then_some(self.listen_until);
        let noise = self.noise.as_ref().filter(|_| listens);
        let understood = noise.and_then(|noise| noise.quiet_from(now));
        Some(free.chain(quiet).chain(listened).chain(understood).fold(now, Now::max))
    }

    /// Since when the first urgent frame waits for the line. One that gave way waits since it no
    /// longer does: until then the pauses of the others are kept.
    fn urgent_since(&self) -> Option<Now> {
        let since = |session: &Session| {
            let since = session.urgent_since()?;
            Some(if session.repeats_in_vain() { since.max(self.repeat_from) } else { since })
        };
        self.sessions.iter().filter_map(since).min()
    }

    /// All absent monitors share one part of the line's time, however many they are.
    fn wants(&self, session: &Session, now: Now) -> Option<Haste> {
        let rests = now < self.absent_from && session.can_wait();
        self.gives_way(session, now, session.wants(now).filter(|_| !rests))
    }

    /// What is urgent for a monitor that does not answer is repeated behind the frames of others,
    /// until these have had the line for a while.
    fn gives_way(&self, session: &Session, now: Now, wants: Option<Haste>) -> Option<Haste> {
        let behind =
            wants == Some(Haste::Urgent) && now < self.repeat_from && session.repeats_in_vain();
        if behind { Some(Haste::Again) } else { wants }
    }

    /// Adapts the waits of each monitor to the others on the line.
    fn adapt_waits(&mut self, now: Now) {
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

    /// Time to listen on a new connection. Where a monitor has answered since the start, its speed is right and
    /// a lost link is to be used again soon.
    fn listens_for(&self) -> Duration {
        if self.is_guest() { self.config.first_listen() } else { self.config.listen }
    }

    /// Whether others on the line come first, where they are heeded: no monitor has answered since the start.
    pub(super) fn is_guest(&self) -> bool {
        self.config.heed && self.sessions.iter().all(|session| session.stats.believed == 0)
    }

    fn handle_frame(&mut self, now: Now, frame: &Incoming) {
        let own = self.config.addresses.source;
        if let Some(noise) = &mut self.noise
            && frame.addresses.is_none_or(|(_, src)| src != own)
        {
            noise.readable();
        }
        if self.heard_controller(now, frame) {
            return;
        }
        let to_us = |(dst, _)| dst == self.config.addresses.source;
        let from = frame.addresses.filter(|addresses| to_us(*addresses)).map(|(_, src)| src);
        match from.and_then(|address| self.find(address)) {
            Some(session) => session.handle_incoming(now, frame),
            None => self.count_foreign(frame),
        }
    }

    pub(super) fn echo_sent(&mut self, bytes: &[u8]) {
        self.echo.sent(bytes);
    }

    fn count_foreign(&mut self, frame: &Incoming) {
        self.foreign += 1;
        // Recorded with the frames of a session, so that the order is kept.
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
        // A controller is not a monitor (§B): it may not answer requests to subsystems.
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
