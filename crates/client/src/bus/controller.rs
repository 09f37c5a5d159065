//! The network controller, address 128 (observed; its schedule is ours).

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use lafet_proto::bus::{ACCESS_GRANTED, CONSOLES, CONTROLLER, MONITORS, NetworkStatus};
use lafet_proto::link::{Check, Decoder, Frame, PAYLOAD_MAX, WIRE_MAX, encode_with};
use lafet_proto::record::{Record, Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, Status, SubsystemId};

use super::config::{ControllerConfig, Port, Ports, Repeat};
use super::journal::Journal;
use super::kind::is_repeatable;
use super::roster::{Change, Roster};
use crate::session::Now;

/// A bus without requests for this long is idle, and new devices can be probed.
const BUSY: Duration = Duration::from_millis(500);
/// Urgent frames of the controller's own client in a row: however many it has, consoles have their
/// turns, for a Stop of their own.
const URGENT_SHARE: u32 = 4;
/// Longest pause within an answer.
const PAUSE: Duration = Duration::from_millis(20);

/// Bytes to transmit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transmit {
    /// The line to transmit on.
    pub port: Port,
    /// A complete frame.
    pub bytes: Vec<u8>,
}

/// Counters of a bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusStats {
    /// Frames sent, without forwarded ones.
    pub sent: u64,
    /// Frames forwarded between the lines.
    pub passed_on: u64,
    /// Frames of consoles to monitors.
    pub requests: u64,
    /// Answers to them.
    pub answers: u64,
    /// Probes, grants and requests sent again.
    pub repeated: u64,
    /// Requests whose console had stopped waiting when the monitors' line was free.
    pub expired: u64,
    /// Grants that a console did not use.
    pub idle_grants: u64,
    /// Frames received when no device was allowed to transmit.
    pub strays: u64,
}

/// The device that may transmit.
#[derive(Clone, Debug)]
enum Turn {
    Nobody,
    /// A probe was sent; its answer is awaited.
    Probed(u8),
    /// A console has access.
    Granted {
        console: u8,
        tries: u32,
    },
    /// A monitor is to answer a console.
    Asked {
        monitor: u8,
        console: u8,
        request: Relayed,
        tries: u32,
    },
    /// A monitor is to answer the controller's own client, which repeats requests itself.
    Own {
        monitor: u8,
        source: u8,
        tells_nothing: bool,
    },
}

/// A frame of a console to a monitor.
#[derive(Clone, Debug)]
struct Relayed {
    wire: Vec<u8>,
    /// §L/7: a probe of a form that the monitor may not support; without an answer it proves
    /// nothing.
    tells_nothing: bool,
    /// Whether it may be repeated if no answer comes.
    repeatable: bool,
    /// Time at which its console stops waiting.
    until: Now,
}

/// A frame that waits for its line.
#[derive(Clone, Debug)]
struct Outgoing {
    transmit: Transmit,
    /// Longest time until its answer starts; `None` if no answer is expected. It counts from the
    /// last byte sent, so a frame that is still waiting is never taken for unanswered.
    answer_in: Option<Duration>,
    /// Time after which it is not sent.
    until: Option<Now>,
}

/// The controller of a bus.
///
/// The caller moves bytes: [`Controller::handle_bytes`] for received bytes,
/// [`Controller::poll_transmit`] for bytes to send, [`Controller::handle_timeout`] at the time of
/// [`Controller::poll_timeout`]. The controller's own client (a hub) is asked for frames when its
/// turn has come, and receives the same bytes.
#[derive(Debug)]
pub struct Controller {
    config: ControllerConfig,
    decoders: [Box<Decoder>; 2],
    roster: Roster,
    journal: Journal,
    turn: Turn,
    deadline: Option<Now>,
    /// Latest time for `deadline`, however many bytes come.
    deadline_most: Now,
    /// Earliest time to transmit on each line.
    free_from: [Now; 2],
    /// On each line, the latest byte, and the first one after a frame or a pause.
    heard_bytes: [(Now, Now); 2],
    /// Start of the present pause on each line.
    silent_since: [Now; 2],
    /// Until then the bus counts as busy, because of a recent request.
    busy_until: Now,
    outgoing: VecDeque<Outgoing>,
    /// Consoles in the order of their next turns.
    round: VecDeque<u8>,
    own_left: u32,
    /// Urgent frames of the controller's own client before the consoles have their turn.
    urgent_left: u32,
    probed: bool,
    misses: BTreeMap<u8, u32>,
    heard: BTreeMap<u8, Now>,
    /// The controller's own client has an urgent request.
    urgent: bool,
    /// A console's request that is to be repeated after an urgent one.
    parked: Option<Turn>,
    stats: BusStats,
}

impl Controller {
    /// A controller that knows no devices yet.
    pub fn new(config: ControllerConfig) -> Self {
        let config = config.bounded();
        let addresses = config.addresses.clone().into_iter();
        Self {
            roster: Roster::new(addresses, config.probe_again),
            own_left: config.own_share,
            urgent_left: URGENT_SHARE,
            config,
            decoders: Default::default(),
            journal: Journal::default(),
            turn: Turn::Nobody,
            deadline: None,
            deadline_most: Now::ZERO,
            heard_bytes: [(Now::ZERO, Now::ZERO); 2],
            free_from: [Now::ZERO; 2],
            silent_since: [Now::ZERO; 2],
            busy_until: Now::ZERO,
            outgoing: VecDeque::new(),
            round: VecDeque::new(),
            probed: false,
            misses: BTreeMap::new(),
            heard: BTreeMap::new(),
            urgent: false,
            parked: None,
            stats: BusStats::default(),
        }
    }

    /// The addresses that answer.
    pub const fn present(&self) -> &NetworkStatus {
        self.roster.present()
    }

    /// The next device that has appeared or was dropped.
    pub fn poll_change(&mut self) -> Option<Change> {
        self.roster.poll_change()
    }

    /// Control requests that went over the bus.
    pub const fn journal(&self) -> &Journal {
        &self.journal
    }

    /// Counters since the controller was created.
    pub const fn stats(&self) -> BusStats {
        self.stats
    }

    /// Sets whether the controller's own client has a Stop, Close or Lockout to send: it is sent
    /// before everything except an answer that is awaited, and before repetitions. After four of them
    /// in a row, a console has its turn.
    pub const fn set_urgent(&mut self, urgent: bool) {
        self.urgent = urgent;
    }

    /// The line was lost and is open again: no device may transmit.
    pub fn line_lost(&mut self) {
        self.turn = Turn::Nobody;
        self.deadline = None;
        self.parked = None;
        self.outgoing.clear();
        self.decoders = Default::default();
    }

    /// Time for the next call of [`Controller::handle_timeout`] or [`Controller::poll_transmit`].
    pub fn poll_timeout(&self, now: Now) -> Option<Now> {
        let outgoing = self.outgoing.front();
        let waiting = outgoing.map(|frame| self.free_from(frame.transmit.port).max(now));
        if waiting.is_some() || self.deadline.is_some() {
            return waiting.into_iter().chain(self.deadline).min();
        }
        let all_free = self.all_free_from();
        if !self.round.is_empty() || self.parked.is_some() {
            return Some(all_free.max(now));
        }
        let idle = now >= self.busy_until;
        let due = self.roster.next_due(idle).into_iter().chain(self.next_watch()).min();
        due.map(|due| due.max(all_free))
    }

    /// Takes received bytes.
    pub fn handle_bytes(&mut self, now: Now, port: Port, bytes: &[u8]) {
        let index = self.index(port);
        self.wait_for_end(now, index);
        if self.index(self.awaited()) == index
            && let Some(deadline) = &mut self.deadline
        {
            *deadline = (*deadline).max((now + PAUSE).min(self.deadline_most));
        }
        let mut rest = bytes;
        while !rest.is_empty() {
            let (taken, frame) = self.decoders[index].push_slice(rest);
            rest = &rest[taken..];
            if let Some(Frame { dst, src, payload }) = frame {
                let payload = payload.to_vec();
                let check = self.decoders[index].check();
                self.heard_bytes[index] = (now, now);
                self.handle_frame(now, check, dst, src, &payload);
            }
        }
    }

    /// Handles the time: see [`Controller::poll_timeout`].
    pub fn handle_timeout(&mut self, now: Now) {
        if self.deadline.is_none_or(|deadline| deadline > now) {
            return;
        }
        self.deadline = None;
        match std::mem::replace(&mut self.turn, Turn::Nobody) {
            Turn::Nobody => {}
            Turn::Probed(address) => {
                if self.roster.present().contains(address) {
                    self.missed(address, now);
                }
            }
            Turn::Granted { console, tries } if tries < self.config.tries => {
                self.stats.repeated += 1;
                self.grant(console, tries + 1);
            }
            Turn::Granted { console, .. } => self.dropped(console, now),
            Turn::Asked { request, .. } if request.tells_nothing => {}
            Turn::Asked { monitor, request, .. } if !request.repeatable => {
                self.missed(monitor, now);
            }
            turn @ Turn::Asked { tries, .. } if tries < self.config.tries => match self.urgent {
                true => self.parked = Some(turn),
                false => self.ask_again(turn),
            },
            Turn::Asked { monitor, .. } => self.dropped(monitor, now),
            Turn::Own { tells_nothing: true, .. } => {}
            Turn::Own { monitor, .. } => self.missed(monitor, now),
        }
    }

    /// Nothing is sent while a frame comes. Bytes that last longer than a frame are noise: a line
    /// that is never quiet must not hold back a Stop.
    fn wait_for_end(&mut self, now: Now, index: usize) {
        let turnaround = self.config.turnaround;
        let (latest, first) = self.heard_bytes[index];
        let first = if now > latest + turnaround { now } else { first };
        self.heard_bytes[index] = (now, first);
        let end = first + self.config.sending(WIRE_MAX) + PAUSE + turnaround;
        self.free_from[index] = self.free_from[index].max((now + turnaround).min(end));
        self.silent_since[index] = self.silent_since[index].max(now.min(end));
    }

    /// The line on which an answer is awaited.
    const fn awaited(&self) -> Port {
        match self.turn {
            Turn::Granted { .. } => Port::Consoles,
            Turn::Probed(address) if address > CONTROLLER => Port::Consoles,
            Turn::Nobody | Turn::Probed(_) | Turn::Asked { .. } | Turn::Own { .. } => {
                Port::Monitors
            }
        }
    }

    /// An answer is awaited until then; while it comes, for the duration of a frame at most.
    fn await_until(&mut self, deadline: Now) {
        self.deadline = Some(deadline);
        self.deadline_most = deadline + self.config.sending(WIRE_MAX) + PAUSE;
    }

    /// Repeats a console's request.
    fn ask_again(&mut self, turn: Turn) {
        let Turn::Asked { monitor, console, request, tries } = turn else { return };
        self.stats.repeated += 1;
        self.pass_on(&request, self.config.reply_timeout * (1 << tries));
        self.turn = Turn::Asked { monitor, console, request, tries: tries + 1 };
    }

    fn pass_on(&mut self, request: &Relayed, answer_in: Duration) {
        let transmit = Transmit { port: Port::Monitors, bytes: request.wire.clone() };
        let (answer_in, until) = (Some(answer_in), Some(request.until));
        self.outgoing.push_back(Outgoing { transmit, answer_in, until });
    }

    /// Handles a device that did not answer the controller.
    fn missed(&mut self, address: u8, now: Now) {
        let misses = self.misses.entry(address).or_default();
        *misses += 1;
        if *misses >= self.config.tries {
            self.dropped(address, now);
        }
    }

    /// Time at which the next monitor that has been quiet for long is probed.
    fn next_watch(&self) -> Option<Now> {
        let watch = self.config.watch?;
        self.monitors_heard().map(|(_, heard)| heard + watch).min()
    }

    /// The monitor that has been quiet for longest, if it is to be probed now.
    fn due_for_watch(&mut self, now: Now) -> Option<u8> {
        let watch = self.config.watch?;
        let (address, heard) = self.monitors_heard().min_by_key(|(_, heard)| *heard)?;
        let due = heard + watch <= now;
        // Not immediately again, answered or not: the others have their turns.
        due.then(|| {
            self.heard.insert(address, now.saturating_sub(watch) + self.config.probe_timeout)
        });
        due.then_some(address)
    }

    fn monitors_heard(&self) -> impl Iterator<Item = (u8, Now)> {
        let present = self.present().iter().filter(|address| MONITORS.contains(address));
        present.map(|address| (address, self.heard.get(&address).copied().unwrap_or_default()))
    }

    /// Earliest time to ask `own` of [`Controller::poll_transmit`]; `None` while an answer is
    /// awaited.
    pub fn own_from(&self, now: Now) -> Option<Now> {
        if !matches!(self.turn, Turn::Nobody) {
            return None;
        }
        let own_next = self.own_is_next();
        let free = if own_next { self.free_from(Port::Monitors) } else { self.all_free_from() };
        Some(free.max(now))
    }

    const fn own_is_next(&self) -> bool {
        if self.urgent { self.urgent_left > 0 } else { self.own_left > 0 }
    }

    /// The next frame to transmit. `own` is asked for a frame of the controller's own client
    /// (source address 128, or one assigned by [`super::Gateway`]) when its turn has come; it must
    /// be a complete link frame.
    pub fn poll_transmit(
        &mut self,
        now: Now,
        mut own: impl FnMut() -> Option<Vec<u8>>,
    ) -> Option<Transmit> {
        self.handle_timeout(now);
        if let Some(transmit) = self.poll_outgoing(now) {
            return Some(transmit);
        }
        if !matches!(self.turn, Turn::Nobody) || now < self.free_from(Port::Monitors) {
            return None;
        }
        if self.own_is_next()
            && let Some(wire) = own()
        {
            return Some(self.send_own(now, wire));
        }
        if !self.outgoing.is_empty() || now < self.all_free_from() {
            return None;
        }
        if let Some(turn) = self.parked.take() {
            self.ask_again(turn);
            return self.poll_outgoing(now);
        }
        if !self.probed
            && let Some(address) =
                self.roster.due(now, now >= self.busy_until).or_else(|| self.due_for_watch(now))
        {
            self.probed = true;
            self.turn = Turn::Probed(address);
            let port = if CONSOLES.contains(&address) { Port::Consoles } else { Port::Monitors };
            let transmit = Transmit { port, bytes: frame(address, &[]) };
            return Some(self.send(now, transmit, Some(self.config.probe_timeout)));
        }
        self.probed = false;
        self.own_left = self.config.own_share;
        self.urgent_left = URGENT_SHARE;
        match self.round.pop_front() {
            Some(console) => {
                self.round.push_back(console);
                self.grant(console, 1);
                self.poll_outgoing(now)
            }
            None => own().map(|wire| self.send_own(now, wire)),
        }
    }

    /// The frame that waits for its line, if the line is free.
    fn poll_outgoing(&mut self, now: Now) -> Option<Transmit> {
        while let Some(next) = self.outgoing.front() {
            if now < self.free_from(next.transmit.port) {
                return None;
            }
            let Outgoing { transmit, answer_in, until } = self.outgoing.pop_front()?;
            if until.is_none_or(|until| now <= until) {
                return Some(self.send(now, transmit, answer_in));
            }
            self.stats.expired += 1;
            self.turn = Turn::Nobody;
        }
        None
    }

    /// The timeout counts from the last byte sent.
    fn send(&mut self, now: Now, transmit: Transmit, answer_in: Option<Duration>) -> Transmit {
        self.stats.sent += 1;
        let sent = now + self.config.sending(transmit.bytes.len());
        match answer_in {
            Some(time) => self.await_until(sent + time),
            None => self.free_from[self.index(transmit.port)] = sent,
        }
        self.silent_since[self.index(transmit.port)] = sent;
        transmit
    }

    const fn index(&self, port: Port) -> usize {
        match self.config.ports {
            Ports::One => 0,
            Ports::Two => port as usize,
        }
    }

    /// Earliest time to transmit on a line. A console may take bytes without a pause for one frame,
    /// so a frame to it follows a pause.
    fn free_from(&self, port: Port) -> Now {
        let index = self.index(port);
        match port {
            Port::Monitors => self.free_from[index],
            Port::Consoles => {
                self.free_from[index].max(self.silent_since[index] + self.config.frame_pause)
            }
        }
    }

    fn all_free_from(&self) -> Now {
        self.free_from(Port::Monitors).max(self.free_from(Port::Consoles))
    }

    fn send_own(&mut self, now: Now, wire: Vec<u8>) -> Transmit {
        self.own_left = self.own_left.saturating_sub(1);
        if self.urgent {
            self.urgent_left = self.urgent_left.saturating_sub(1);
        }
        self.begin_own(now, &wire);
        let transmit = Transmit { port: Port::Monitors, bytes: wire };
        self.send(now, transmit, Some(self.config.reply_timeout))
    }

    fn begin_own(&mut self, now: Now, wire: &[u8]) {
        self.busy_until = now + BUSY;
        let mut decoder: Box<Decoder> = Box::default();
        if let (_, Some(frame)) = decoder.push_slice(wire) {
            let Frame { dst: monitor, src: source, payload } = frame;
            self.journal.note(self.time_s(now), monitor, source, payload);
            let tells_nothing = payload.is_empty() && decoder.check() == Check::Crc32c;
            self.turn = Turn::Own { monitor, source, tells_nothing };
        }
    }

    fn grant(&mut self, console: u8, tries: u32) {
        let mut buffer = [0; 16];
        let mut writer = Writer::new(&mut buffer);
        // The record always fits.
        let _ = writer.push(&ACCESS_GRANTED);
        let bytes = frame(console, writer.written());
        self.turn = Turn::Granted { console, tries };
        let answer_in = Some(self.config.probe_timeout * (1 << (tries - 1)));
        let transmit = Transmit { port: Port::Consoles, bytes };
        self.outgoing.push_back(Outgoing { transmit, answer_in, until: None });
    }

    /// Queues a frame to a console that needs no answer.
    fn tell(&mut self, bytes: Vec<u8>) {
        let transmit = Transmit { port: Port::Consoles, bytes };
        self.outgoing.push_back(Outgoing { transmit, answer_in: None, until: None });
    }

    fn handle_frame(&mut self, now: Now, check: Check, dst: u8, src: u8, payload: &[u8]) {
        self.heard.insert(src, now);
        self.appeared(src);
        match std::mem::replace(&mut self.turn, Turn::Nobody) {
            Turn::Probed(address) if src == address => self.deadline = None,
            Turn::Own { monitor, source, .. } if (src, dst) == (monitor, source) => {
                self.deadline = None;
            }
            Turn::Granted { console, .. } if src == console => {
                self.deadline = None;
                self.handle_console(now, check, console, dst, payload);
            }
            // The console's frame was received with errors only by this side.
            Turn::Granted { console, .. } if dst == console && MONITORS.contains(&src) => {
                self.deadline = None;
                self.stats.answers += 1;
            }
            Turn::Asked { monitor, console, .. } if (src, dst) == (monitor, console) => {
                self.deadline = None;
                self.stats.answers += 1;
                if self.config.ports == Ports::Two {
                    self.stats.passed_on += 1;
                    self.tell(wire(check, dst, src, payload));
                }
            }
            turn => {
                self.stats.strays += 1;
                self.turn = turn;
            }
        }
    }

    /// Handles the frame with which a console has used its grant.
    fn handle_console(&mut self, now: Now, check: Check, console: u8, dst: u8, payload: &[u8]) {
        if dst == CONTROLLER {
            if payload.is_empty() {
                self.stats.idle_grants += 1;
            } else {
                let answers = self.services(payload);
                self.tell(wire(check, console, CONTROLLER, &answers));
            }
        } else if MONITORS.contains(&dst) {
            self.stats.requests += 1;
            self.busy_until = now + BUSY;
            self.journal.note(self.time_s(now), dst, console, payload);
            let request = Relayed {
                wire: wire(check, dst, console, payload),
                tells_nothing: check == Check::Crc32c && payload.is_empty(),
                repeatable: self.config.repeat == Repeat::All || is_repeatable(payload),
                until: now + self.config.patience(),
            };
            match self.config.ports {
                // The monitor has received it directly.
                Ports::One => self.await_until(now + self.config.reply_timeout),
                Ports::Two => {
                    self.stats.passed_on += 1;
                    self.pass_on(&request, self.config.reply_timeout);
                }
            }
            self.turn = Turn::Asked { monitor: dst, console, request, tries: 1 };
        }
    }

    /// The controller's own services (§B/1): the answers to a frame.
    pub fn services(&self, payload: &[u8]) -> Vec<u8> {
        let mut buffer = [0; PAYLOAD_MAX];
        let mut out = Writer::new(&mut buffer);
        for record in Records::new(payload).map_while(Result::ok) {
            let body = Request::decode(&record).map(|request| request.body);
            let written = match body {
                Ok(Body::GetNetworkStatus) => out.push(&Record {
                    request: RequestId::GET_NETWORK_STATUS,
                    device: SubsystemId::GENERAL,
                    status: Status::OK,
                    data: &self.roster.present().0,
                }),
                Ok(Body::GetLog { first, count }) => self.journal.answer(first, count, &mut out),
                Ok(_) => out.push(&refusal(record.request, Status::WRONG_REQUEST)),
                Err(_) => out.push(&refusal(record.request, Status::WRONG_DATA)),
            };
            if written.is_err() {
                break;
            }
        }
        out.written().to_vec()
    }

    fn appeared(&mut self, address: u8) {
        self.misses.remove(&address);
        self.roster.appeared(address);
        let here = CONSOLES.contains(&address) && self.present().contains(address);
        if here && !self.round.contains(&address) {
            self.round.push_back(address);
        }
    }

    fn dropped(&mut self, address: u8, now: Now) {
        self.misses.remove(&address);
        self.round.retain(|console| *console != address);
        self.roster.dropped(address, now);
    }

    const fn time_s(&self, now: Now) -> u32 {
        self.config.epoch_s.wrapping_add(now.as_secs() as u32)
    }
}

const fn refusal(request: RequestId, status: Status) -> Record<'static> {
    Record { request, device: SubsystemId::GENERAL, status, data: &[] }
}

/// A frame from the controller.
fn frame(dst: u8, payload: &[u8]) -> Vec<u8> {
    wire(Check::Crc16, dst, CONTROLLER, payload)
}

pub(super) fn wire(check: Check, dst: u8, src: u8, payload: &[u8]) -> Vec<u8> {
    let mut out = [0; WIRE_MAX];
    // The content of a received frame always fits a frame.
    let len = encode_with(check, &Frame { dst, src, payload }, &mut out).unwrap_or(0);
    out.get(..len).unwrap_or_default().to_vec()
}
