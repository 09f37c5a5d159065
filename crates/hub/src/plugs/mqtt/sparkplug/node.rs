//! The edge node: births, data by exception, deaths, and what the host has missed. No I/O, no clock of its own.
//!
//! ```text
//!            subscribed            the host is there       a birth is due
//!   Apart ─────────────▶ Waits ──────────────────▶ Here ──────────────────▶ NBIRTH, DBIRTH …, data
//!     ▲                                              │ the host is gone
//!     └───────────────── lost ◀──────────────────────┘ NDEATH
//!   what changes is kept                               what changes is published
//! ```

use std::collections::VecDeque;
use std::time::Duration;

use prost::Message as _;
use serde::Deserialize;

use super::NodeConfig;
use super::history::{History, Past};
use super::metrics::{
    self, BD_SEQ, Cell, DEVICE, DEVICE_RESULT, HISTORY, KEY, NODE, NODE_MONITOR, PROGRAM,
    REBIRTH_AT, STRIDE, TICKET, VALVE2,
};
use super::payload::{Metric, Payload};
use crate::access::Bucket;
use crate::plugs::mqtt::desk::{Now, Reply};
use crate::plugs::mqtt::outbox::{Letter, Results};
use crate::plugs::mqtt::state::{State, Urgent};

/// Births that are asked for come so many at once and so many a second, however often they are asked for.
pub const REBIRTHS: (f64, f64) = (3.0, 0.2);
/// A monitor that is not heard is stale for this time, then lost. Without a connection it is lost at once.
pub const STALE_LASTS: Duration = Duration::from_secs(3);
/// Values of the past in one message.
const PAST_MAX: usize = 50;
/// Values of which it is not known yet whether the broker has them; beyond that data wait.
const SENT_MAX: usize = 4096;
/// Questions to the broker that are not answered, at most.
const FENCES_MAX: usize = 4;
/// Longest message of a host about itself, bytes.
const HOST_MAX: usize = 4096;

/// How far the connection is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// There is none.
    Apart,
    /// The host is not there.
    Waits,
    /// What there is to say can be said.
    Here,
}

/// What a host says of itself.
#[derive(Debug, Deserialize)]
struct HostState {
    online: bool,
    timestamp: u64,
}

/// A metric as it is, and as it was said last.
#[derive(Clone, Debug, Default)]
struct Slot {
    now: Cell,
    at_ms: u64,
    said: Cell,
}

impl Slot {
    fn set(&mut self, cell: Cell, at_ms: u64) {
        if self.now != cell {
            (self.now, self.at_ms) = (cell, at_ms);
        }
    }

    /// What is to be said of it, if that is something else than was said last.
    fn say(&mut self, alias: u64) -> Option<Metric> {
        if self.now == self.said {
            return None;
        }
        let quality_too = self.now.quality != self.said.quality;
        self.said = self.now.clone();
        Some(metrics::changed(alias, &self.now, self.at_ms, quality_too))
    }
}

/// A monitor.
#[derive(Debug)]
struct Device {
    id: String,
    slots: Vec<Slot>,
    /// When its state was looked at, and what of it mattered at once.
    seen: Option<(Now, Urgent)>,
    /// It was heard since the start: what it shows first is no change.
    known: bool,
    stale: Option<Now>,
    alive: bool,
    has_valve2: bool,
    /// Its birth was published in this connection: with a second valve or without.
    born: Option<bool>,
}

impl Device {
    fn new(id: &str) -> Self {
        let slot = |row| Slot { now: metrics::unwritten(row), ..Slot::default() };
        let slots = DEVICE.iter().map(|row| match row.is_state() {
            true => Slot::default(),
            false => slot(row),
        });
        Self {
            id: id.to_owned(),
            slots: slots.collect(),
            seen: None,
            known: false,
            stale: None,
            alive: false,
            has_valve2: false,
            born: None,
        }
    }

    fn see(&mut self, (now, now_ms): (Now, u64), state: &State, interval: Duration) {
        let urgent = state.urgent();
        let is_same = self.seen.is_some_and(|(_, it)| it == urgent);
        if !is_same || self.seen.is_none_or(|(since, _)| now >= since + interval) {
            self.seen = Some((now, urgent));
            let good = state.is_available();
            let at_ms = state.at_ms.filter(|_| good).unwrap_or(now_ms);
            for (slot, row) in self.slots.iter_mut().zip(&DEVICE) {
                let Some(cell) = row.cell(state) else { continue };
                slot.set(cell, at_ms);
                if !self.known {
                    slot.said = slot.now.clone();
                }
            }
            self.known |= good;
            if good {
                self.has_valve2 = state.valves.contains_key("valve2");
            }
        }
        self.alive = match state.quality {
            "good" => {
                self.stale = None;
                true
            }
            "stale" => self.alive && now < *self.stale.get_or_insert(now) + STALE_LASTS,
            _ => false,
        };
    }

    /// Whether a metric is in its births.
    fn has(&self, row: usize) -> bool {
        self.has_valve2 || !VALVE2.contains(&row)
    }
}

/// The node.
#[derive(Debug)]
pub struct Node {
    config: NodeConfig,
    interval: Duration,
    phase: Phase,
    /// The number of the connection; `None`: there was none yet.
    bd_seq: Option<u8>,
    /// The broker may have heard of it.
    is_used: bool,
    seq: u8,
    /// What the host has said last of itself: whether it is there, and when, by its clock.
    host: Option<(bool, u64)>,
    slots: Vec<Slot>,
    devices: Vec<Device>,
    /// The node was announced in this connection.
    announced: bool,
    birth_due: Option<Now>,
    births: Bucket,
    /// With the monitor, by its place and as it was called.
    results: Results<(Option<usize>, String, Reply)>,
    numbers: u64,
    history: History,
    /// What was sent, in its order, since the broker has confirmed something.
    sent: VecDeque<Past>,
    /// How much was sent in all, how much of it is confirmed, and what the next confirmations are for.
    counts: (u64, u64),
    fences: VecDeque<u64>,
    turn: usize,
}

impl Node {
    /// A node that is not connected.
    pub fn new(config: &NodeConfig, devices: &[String], interval: Duration) -> Self {
        let slot = |row| Slot { now: metrics::unwritten(row), ..Slot::default() };
        let mut slots: Vec<Slot> = NODE.iter().map(slot).collect();
        let program = ["lafet", env!("CARGO_PKG_VERSION")];
        for (at, text) in PROGRAM.into_iter().zip(program) {
            if let Some(slot) = slots.get_mut(at) {
                slot.now = Cell::text(text);
            }
        }
        Self {
            config: config.clone(),
            interval,
            phase: Phase::Apart,
            bd_seq: None,
            is_used: false,
            seq: 0,
            host: None,
            slots,
            devices: devices.iter().map(|id| Device::new(id)).collect(),
            announced: false,
            birth_due: None,
            births: Bucket::new(Now::ZERO, REBIRTHS.0, REBIRTHS.1),
            results: Results::default(),
            numbers: 0,
            history: History::new(config.history, config.history_age),
            sent: VecDeque::new(),
            counts: (0, 0),
            fences: VecDeque::new(),
            turn: 0,
        }
    }

    /// A connection is tried: the death that the broker is to publish when it is lost. A number that no broker has
    /// heard of is tried again.
    pub fn connect(&mut self, now_ms: u64) -> Letter {
        let step = u8::from(std::mem::take(&mut self.is_used));
        self.bd_seq = Some(self.bd_seq.map_or(0, |it| it.wrapping_add(step)));
        let number = Cell::long(self.bd_seq.unwrap_or_default().into());
        self.set(BD_SEQ, number, now_ms);
        self.death(now_ms)
    }

    /// The broker has been reached.
    pub const fn reached(&mut self) {
        self.is_used = true;
    }

    /// The death of the node in this connection.
    pub fn death(&self, now_ms: u64) -> Letter {
        let number = Cell::long(self.bd_seq.unwrap_or_default().into());
        let metric = NODE.first().map(|row| row.announced(None, &number, now_ms));
        let metric = metric.map(|it| Metric { properties: None, ..it });
        let metrics = metric.into_iter().collect();
        let payload = Payload { timestamp: Some(now_ms), metrics, seq: None }.encode_to_vec();
        Letter { topic: self.config.topic("NDEATH"), payload, retained: false, confirmed: true }
    }

    /// The broker has taken the subscriptions.
    pub fn begin(&mut self, now: Now) {
        let is_there = self.config.host.is_none() || self.host.is_some_and(|(online, _)| online);
        self.phase = if is_there { Phase::Here } else { Phase::Waits };
        self.birth_due = Some(now);
    }

    /// The connection has ended. What may not have arrived is kept.
    pub fn lost(&mut self) {
        (self.phase, self.host) = (Phase::Apart, None);
        (self.announced, self.birth_due) = (false, None);
        // What was asked for and did not come is not owed in the next connection.
        self.births = Bucket::new(Now::ZERO, REBIRTHS.0, REBIRTHS.1);
        self.devices.iter_mut().for_each(|it| it.born = None);
        self.results = Results::default();
        self.fences.clear();
        self.history.put_back(std::mem::take(&mut self.sent));
        self.counts.1 = self.counts.0;
    }

    /// Whether it waits for its host.
    pub fn waits(&self) -> bool {
        self.phase == Phase::Waits
    }

    /// A host says something of itself. `true`: it has gone, and the connection is to end.
    pub fn host(&mut self, now: Now, payload: &[u8]) -> bool {
        let state = Some(payload).filter(|it| it.len() <= HOST_MAX);
        let state = state.and_then(|it| serde_json::from_slice::<HostState>(it).ok());
        let Some(HostState { online, timestamp }) = state else { return false };
        // An earlier one that comes late.
        if self.host.is_some_and(|(_, last)| timestamp < last) {
            return false;
        }
        self.host = Some((online, timestamp));
        if online && self.phase == Phase::Waits {
            (self.phase, self.birth_due) = (Phase::Here, Some(now));
        }
        !online && self.phase == Phase::Here
    }

    /// All births are asked for. Until births that have to wait, data go on: results are not to be late for them.
    pub fn rebirth(&mut self, now: Now) {
        if self.birth_due.is_none() {
            self.birth_due = Some(now + self.births.owe(now, 1.0).unwrap_or_default());
        }
    }

    /// The monitors as they are, in their order.
    pub fn look(&mut self, now: Now, now_ms: u64, states: &[State]) {
        for (device, state) in self.devices.iter_mut().zip(states) {
            device.see((now, now_ms), state, self.interval);
        }
        if !self.announced {
            self.keep(now);
        }
        self.history.tick(now);
    }

    /// The host does not hear what has changed: it is kept.
    fn keep(&mut self, now: Now) {
        for (at, device) in self.devices.iter_mut().enumerate() {
            for (row, slot) in device.slots.iter_mut().enumerate().take(KEY) {
                if slot.now != slot.said {
                    slot.said = slot.now.clone();
                    let (cell, at_ms) = (slot.now.clone(), slot.at_ms);
                    self.history.push(Past { device: at, row, cell, at_ms, noted: now });
                }
            }
        }
    }

    /// There is a new ticket.
    pub fn set_ticket(&mut self, now_ms: u64, ticket: String) {
        self.set(TICKET, Cell::text(ticket), now_ms);
        let counts = [self.history.waiting(), self.history.dropped()];
        for (at, count) in HISTORY.into_iter().zip(counts) {
            self.set(at, Cell::long(count), now_ms);
        }
    }

    /// The key of a monitor is another one.
    pub fn set_key(&mut self, device: usize, now_ms: u64, key: Option<String>) {
        let slot = self.devices.get_mut(device).and_then(|it| it.slots.get_mut(KEY));
        if let Some(slot) = slot {
            slot.set(Cell::text(key.unwrap_or_default()), now_ms);
        }
    }

    fn set(&mut self, row: usize, cell: Cell, now_ms: u64) {
        if let Some(slot) = self.slots.get_mut(row) {
            slot.set(cell, now_ms);
        }
    }

    /// There is a result, of a monitor by its place and as it was called; `false`: one was lost.
    pub fn say(&mut self, device: Option<usize>, id: String, reply: Reply) -> bool {
        let of_flood = reply.is_of_flood();
        self.results.push((device, id, reply), of_flood)
    }

    /// Values that were dropped since the start, because the host was not there for too long.
    pub const fn dropped(&self) -> u64 {
        self.history.dropped()
    }

    /// A question to the broker is sent after what was sent: its answer confirms that. `false`: it has not answered those
    /// before.
    pub fn fence(&mut self) -> bool {
        let is_answered = self.fences.len() < FENCES_MAX;
        if is_answered {
            self.fences.push_back(self.counts.0);
        }
        is_answered
    }

    /// Whether so much is not confirmed that data would wait soon.
    pub fn is_full(&self) -> bool {
        self.fences.is_empty() && self.sent.len() >= SENT_MAX / 2
    }

    /// The broker has answered a question.
    pub fn confirmed(&mut self) {
        let Some(fence) = self.fences.pop_front() else { return };
        let confirmed = usize::try_from(fence - self.counts.1).unwrap_or(usize::MAX);
        self.sent.drain(..confirmed.min(self.sent.len()));
        self.counts.1 = fence;
    }

    /// The next message, if there is one.
    pub fn next(&mut self, now: Now, now_ms: u64) -> Option<Letter> {
        if self.phase != Phase::Here {
            return None;
        }
        if self.birth_due.is_some_and(|due| now >= due) {
            return Some(self.birth(now_ms));
        }
        if !self.announced {
            return None;
        }
        self.device_comes_or_goes(now_ms)
            .or_else(|| self.result(now_ms))
            .or_else(|| self.data(now_ms))
            .or_else(|| self.device_data(now, now_ms))
            .or_else(|| self.missed(now_ms))
    }

    fn birth(&mut self, now_ms: u64) -> Letter {
        self.seq = 0;
        (self.announced, self.birth_due) = (true, None);
        self.devices.iter_mut().for_each(|it| it.born = None);
        let mut metrics = Vec::new();
        for (at, (row, slot)) in NODE.iter().zip(&mut self.slots).enumerate() {
            slot.said = slot.now.clone();
            let alias = (at != REBIRTH_AT).then_some(at as u64);
            metrics.push(row.announced(alias, &slot.now, now_ms));
        }
        self.letter("NBIRTH", None, now_ms, metrics)
    }

    fn device_comes_or_goes(&mut self, now_ms: u64) -> Option<Letter> {
        let comes = |it: &Device| it.alive && it.born != Some(it.has_valve2);
        let goes = |it: &Device| !it.alive && it.born.is_some();
        let at = self.devices.iter().position(|it| comes(it) || goes(it))?;
        let device = self.devices.get_mut(at)?;
        if !device.alive {
            device.born = None;
            return Some(self.letter("DDEATH", Some(at), now_ms, Vec::new()));
        }
        device.born = Some(device.has_valve2);
        let mut metrics = Vec::new();
        for (number, row) in DEVICE.iter().enumerate().filter(|(number, _)| device.has(*number)) {
            let Some(slot) = device.slots.get(number) else { continue };
            let at_ms = if row.is_state() && slot.at_ms != 0 { slot.at_ms } else { now_ms };
            metrics.push(row.announced(Some(alias(at, number)), &slot.now, at_ms));
        }
        device.slots.iter_mut().for_each(|it| it.said = it.now.clone());
        Some(self.letter("DBIRTH", Some(at), now_ms, metrics))
    }

    /// A result: of its monitor, or of the node if that is not there.
    fn result(&mut self, now_ms: u64) -> Option<Letter> {
        let (device, id, reply) = self.results.pop()?;
        self.numbers += 1;
        let cells = metrics::result(&reply, self.numbers);
        let device = device.filter(|at| self.devices.get(*at).is_some_and(|it| it.born.is_some()));
        if device.is_none() {
            self.set(NODE_MONITOR, Cell::text(id), now_ms);
        }
        let first = if device.is_some() { DEVICE_RESULT } else { NODE_MONITOR + 1 };
        let slots = match device {
            Some(at) => &mut self.devices.get_mut(at)?.slots,
            None => &mut self.slots,
        };
        let mut metrics = Vec::new();
        for (row, cell) in (first..).zip(cells) {
            let slot = slots.get_mut(row)?;
            *slot = Slot { now: cell.clone(), at_ms: now_ms, said: cell };
            let alias = device.map_or(row as u64, |at| alias(at, row));
            metrics.push(metrics::changed(alias, &slot.now, now_ms, false));
        }
        if device.is_none() {
            let slot = slots.get_mut(NODE_MONITOR)?;
            slot.said = slot.now.clone();
            metrics.push(metrics::changed(NODE_MONITOR as u64, &slot.now, now_ms, false));
        }
        let kind = if device.is_some() { "DDATA" } else { "NDATA" };
        Some(self.letter(kind, device, now_ms, metrics))
    }

    fn data(&mut self, now_ms: u64) -> Option<Letter> {
        let slots = self.slots.iter_mut().enumerate();
        let metrics: Vec<Metric> = slots.filter_map(|(at, slot)| slot.say(at as u64)).collect();
        (!metrics.is_empty()).then(|| self.letter("NDATA", None, now_ms, metrics))
    }

    /// Of the devices in turn, one whose metrics have changed.
    fn device_data(&mut self, now: Now, now_ms: u64) -> Option<Letter> {
        if self.sent.len() >= SENT_MAX {
            return None;
        }
        let count = self.devices.len();
        for offset in 0..count {
            let at = (self.turn + offset) % count;
            let Some(device) = self.devices.get_mut(at).filter(|it| it.born.is_some()) else {
                continue;
            };
            let mut metrics = Vec::new();
            for row in 0..device.slots.len() {
                let has = device.has(row);
                let Some(slot) = device.slots.get_mut(row).filter(|_| has) else { continue };
                let Some(metric) = slot.say(alias(at, row)) else { continue };
                metrics.push(metric);
                if row < KEY {
                    let (cell, at_ms) = (slot.now.clone(), slot.at_ms);
                    self.sent.push_back(Past { device: at, row, cell, at_ms, noted: now });
                    self.counts.0 += 1;
                }
            }
            if !metrics.is_empty() {
                self.turn = at + 1;
                return Some(self.letter("DDATA", Some(at), now_ms, metrics));
            }
        }
        None
    }

    /// What the host has missed, the oldest first.
    fn missed(&mut self, now_ms: u64) -> Option<Letter> {
        if self.sent.len() >= SENT_MAX {
            return None;
        }
        let devices = &self.devices;
        let is_there = |at: usize| devices.get(at).is_some_and(|it| it.born.is_some());
        let past = self.history.take(PAST_MAX, is_there);
        let device = past.first()?.device;
        let metric = |it: &Past| Metric {
            is_historical: Some(true),
            ..metrics::changed(alias(it.device, it.row), &it.cell, it.at_ms, true)
        };
        // A valve that this monitor has no more.
        let known = |it: &&Past| devices.get(it.device).is_some_and(|device| device.has(it.row));
        let metrics: Vec<Metric> = past.iter().filter(known).map(metric).collect();
        self.counts.0 += past.len() as u64;
        self.sent.extend(past);
        Some(self.letter("DDATA", Some(device), now_ms, metrics))
    }

    fn letter(
        &mut self,
        kind: &str,
        device: Option<usize>,
        now_ms: u64,
        metrics: Vec<Metric>,
    ) -> Letter {
        let seq = Some(self.seq.into());
        self.seq = self.seq.wrapping_add(1);
        let payload = Payload { timestamp: Some(now_ms), metrics, seq }.encode_to_vec();
        let topic = match device.and_then(|at| self.devices.get(at)) {
            Some(device) => self.config.topic_of(kind, &device.id),
            None => self.config.topic(kind),
        };
        Letter { topic, payload, retained: false, confirmed: false }
    }
}

/// The alias of a device's metric.
fn alias(device: usize, row: usize) -> u64 {
    (device as u64 + 1) * STRIDE + row as u64
}

/// The name of a metric that is written to at the node, or at a device by its place.
pub fn row_of(device: Option<usize>, metric: &Metric) -> Option<&'static str> {
    let rows = if device.is_some() { &DEVICE[..] } else { &NODE[..] };
    let row = match metric.name.as_deref().filter(|it| !it.is_empty()) {
        Some(name) => rows.iter().find(|it| it.name == name),
        None => {
            let alias = metric.alias?;
            let first = device.map_or(Some(0), |at| (at as u64).checked_add(1));
            let row = usize::try_from(alias % STRIDE).ok()?;
            rows.get(row).filter(|_| Some(alias / STRIDE) == first)
        }
    };
    row.map(|it| it.name)
}
