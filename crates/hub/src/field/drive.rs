//! What the outputs of a bus are to be, and what has to be written for it. It has no I/O.
//!
//! A write counts if the device has answered it *and* the value was read back afterwards. What closes is
//! written until then, and again when the device shows something else. What opens or starts has a time
//! after which it is not written any more: whether it is still wanted the zone controller knows, which
//! orders it again as long as it is not reported.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use lafet_site::PathFault;
use serde::Serialize;
use utoipa::ToSchema;

use super::OutputConfig;
use super::target::Target;
use super::wire::{Failure, Table};
use crate::control::authority::Now;

/// Pauses before a write is tried again: the first, and the longest.
const AGAIN_FIRST: Duration = Duration::from_millis(100);
const AGAIN_LAST: Duration = Duration::from_secs(1);
/// A heartbeat changes this often.
const BEAT: Duration = Duration::from_secs(1);

/// How urgent something is on a bus, the most urgent first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Urgency {
    /// A valve closes, a pump stops.
    Closes,
    /// A valve opens, a pump starts.
    Opens,
    /// Sounders and lamps.
    Signals,
    /// The heartbeat of the hub, and reads.
    Waits,
}

/// What an output drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ModbusDrives)]
pub enum Drives {
    /// A zone valve or a test outlet.
    Valve,
    /// A sounder or a lamp.
    Signal,
    /// A pump.
    Pump,
}

/// What is wrong with an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ModbusOutputTrouble)]
pub enum Trouble {
    /// Nothing valid was read for too long, or the line is lost.
    Lost,
    /// The device reports a fault.
    Fault,
    /// The device has lost what it had: as after a restart of its own.
    Dropped,
    /// The device refuses the write.
    Refused,
}

impl Trouble {
    /// As the zone controller gets it.
    pub const fn of_path(self) -> PathFault {
        match self {
            Self::Lost | Self::Refused => PathFault::Lost,
            Self::Fault => PathFault::Open,
            Self::Dropped => PathFault::Power,
        }
    }
}

/// An order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// On, open.
    pub on: bool,
    /// Orders count up.
    pub number: u64,
    /// It is void afterwards: what opens or starts.
    pub not_after: Option<Now>,
}

/// What is to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Job {
    /// Of what.
    pub of: Of,
    /// Address of the device.
    pub unit: u8,
    /// On, open.
    pub on: bool,
    /// How urgent it is.
    pub urgency: Urgency,
    /// It has failed before.
    pub again: bool,
    number: u64,
}

/// What a write is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// An output, by its position.
    Output(usize),
    /// A heartbeat, by its position.
    Beat(usize),
}

/// What is reported to the zone controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// Which output.
    pub output: usize,
    /// As it is, if that is news.
    pub on: Option<bool>,
    /// What is wrong with it, if that is news.
    pub trouble: Option<Option<Trouble>>,
}

/// An output.
#[derive(Clone, Debug)]
pub struct Output {
    pub config: OutputConfig,
    /// The latest order.
    pub wanted: Option<Order>,
    /// The order has not been answered yet.
    pending: bool,
    /// The latest closing was not answered yet.
    closing: bool,
    /// It goes before what opens.
    closes_first: bool,
    /// It is not written before.
    again: Now,
    failures: u32,
    refused: bool,
    /// The latest write that was answered.
    pub written: Option<(Now, bool)>,
    /// Reads in a row, after the write, that show what is wanted.
    agrees: u8,
    confirmed: bool,
    dropped: bool,
    values: BTreeMap<(Table, u16), (Now, u16)>,
    reported: Option<bool>,
    troubled: Option<Option<Trouble>>,
}

/// The heartbeat of the hub in a device.
#[derive(Clone, Debug)]
struct Beat {
    unit: u8,
    target: Target,
    next: bool,
    due: Now,
    works: bool,
}

/// The outputs of a bus.
#[derive(Clone, Debug)]
pub struct Drive {
    pub outputs: Vec<Output>,
    beats: Vec<Beat>,
    /// Devices that have not answered a write: how often, and when they are written again.
    silent: BTreeMap<u8, (u32, Now)>,
    /// Devices that have not answered a read.
    broken: BTreeSet<u8>,
    /// A value counts for this time.
    counts_for: Duration,
    /// Reads that confirm a write.
    reads: u8,
    connected: bool,
}

impl Drive {
    /// Outputs of which nothing is known and nothing is wanted.
    pub fn new(
        outputs: &[OutputConfig],
        beats: &[(u8, Target)],
        counts_for: Duration,
        reads: u8,
    ) -> Self {
        let beat = |&(unit, target): &(u8, Target)| {
            let (next, due, works) = (true, Now::ZERO, false);
            Beat { unit, target, next, due, works }
        };
        Self {
            outputs: outputs.iter().cloned().map(Output::new).collect(),
            beats: beats.iter().map(beat).collect(),
            silent: BTreeMap::new(),
            broken: BTreeSet::new(),
            counts_for,
            reads,
            connected: false,
        }
    }

    /// Takes an order; `false`: there is no such output.
    pub fn order(&mut self, id: &str, order: Order) -> bool {
        let Some(output) = self.outputs.iter_mut().find(|it| it.config.id == id) else {
            return false;
        };
        // What is new does not wait until a silent device is tried again.
        if output.order(order) {
            self.silent.remove(&output.config.unit);
        }
        true
    }

    /// The heartbeats go on, or stand still because the zone controller does; whether they go on again.
    pub fn beats(&mut self, works: bool) -> bool {
        let starts = works && self.beats.iter().any(|it| !it.works);
        self.beats.iter_mut().for_each(|it| it.works = works);
        starts
    }

    /// What has to be written next.
    pub fn next(&self, now: Now) -> Option<Job> {
        let awake = |unit: u8| self.silent.get(&unit).is_none_or(|(_, again)| *again <= now);
        let outputs = self.outputs.iter().enumerate();
        let outputs = outputs.filter_map(|(index, it)| it.job(index, now));
        let beats = self.beats.iter().enumerate().filter(|(_, it)| it.works && it.due <= now);
        let beats = beats.map(|(index, it)| Job {
            of: Of::Beat(index),
            unit: it.unit,
            on: it.next,
            urgency: Urgency::Waits,
            again: false,
            number: 0,
        });
        let again = |mut job: Job| {
            job.again |= self.silent.contains_key(&job.unit);
            job
        };
        let all = outputs.chain(beats).filter(|job| awake(job.unit)).map(again);
        all.min_by_key(|job| (job.urgency, job.again, job.number))
    }

    /// Whether a job is still what has to be written.
    pub fn is_current(&self, job: &Job, now: Now) -> bool {
        match job.of {
            Of::Beat(_) => true,
            Of::Output(index) => {
                let found = self.outputs.get(index).and_then(|it| it.job(index, now));
                found.is_some_and(|it| (it.on, it.number) == (job.on, job.number))
            }
        }
    }

    /// When something will have to be written, if no order comes.
    pub fn due(&self, now: Now) -> Option<Now> {
        let awake = |unit: u8, at: Now| self.silent.get(&unit).map_or(at, |(_, it)| at.max(*it));
        let outputs = self.outputs.iter().filter_map(|it| {
            let at = awake(it.config.unit, it.again.max(now));
            it.job(0, at).map(|_| at)
        });
        let beats = self.beats.iter().filter(|it| it.works);
        outputs.chain(beats.map(|it| awake(it.unit, it.due))).min()
    }

    /// Where a job is written.
    pub fn target(&self, job: &Job) -> Option<Target> {
        match job.of {
            Of::Output(index) => self.outputs.get(index).map(|it| it.config.target),
            Of::Beat(index) => self.beats.get(index).map(|it| it.target),
        }
    }

    /// Whether what a job has written is read back.
    pub fn is_read_back(&self, job: &Job) -> bool {
        match job.of {
            Of::Output(index) => self.outputs.get(index).is_some_and(|it| it.config.read_back),
            Of::Beat(_) => false,
        }
    }

    /// What came of a write.
    pub fn wrote(&mut self, now: Now, job: &Job, failure: Option<&Failure>) {
        match failure {
            None | Some(Failure::Exception(_)) => _ = self.silent.remove(&job.unit),
            Some(Failure::GivenUp) => {}
            Some(_) => {
                let (failures, again) = self.silent.entry(job.unit).or_default();
                *again = now + pause(*failures);
                *failures = failures.saturating_add(1);
            }
        }
        match job.of {
            Of::Output(index) => {
                if let Some(output) = self.outputs.get_mut(index) {
                    output.wrote(now, job, failure);
                }
            }
            Of::Beat(index) => {
                if let Some(beat) = self.beats.get_mut(index) {
                    beat.due = now + BEAT;
                    beat.next ^= failure.is_none();
                }
            }
        }
    }

    /// A value was read, by a request of after the latest write.
    pub fn read(&mut self, now: Now, unit: u8, place: (Table, u16), value: u16) {
        // Who comes back may have lost everything.
        if self.broken.remove(&unit) {
            self.silent.remove(&unit);
            self.restore(Some(unit));
        }
        let reads = self.reads;
        let of_unit = self.outputs.iter_mut().filter(|it| it.config.unit == unit);
        for output in of_unit.filter(|it| it.config.places().contains(&place)) {
            output.values.insert(place, (now, value));
            let target = output.config.target;
            if output.config.read_back && place == (target.table, target.address) {
                output.shows(now, target.state(value), reads);
            }
        }
    }

    /// A device has not answered a read.
    pub fn breaks(&mut self, unit: u8) {
        self.outputs.iter_mut().filter(|it| it.config.unit == unit).for_each(|it| it.agrees = 0);
        self.broken.insert(unit);
    }

    /// The connection is new, or lost.
    pub fn connects(&mut self, connected: bool) {
        self.connected = connected;
        if connected {
            self.silent.clear();
            self.broken.clear();
            self.restore(None);
        }
    }

    /// What is wanted without an end is written once more: never what opens.
    fn restore(&mut self, unit: Option<u8>) {
        for output in self.outputs.iter_mut() {
            let of_unit = unit.is_none_or(|unit| unit == output.config.unit);
            output.agrees = 0;
            let lasts = output.wanted.is_some_and(|it| it.not_after.is_none());
            if of_unit && lasts && !output.pending {
                (output.pending, output.again) = (true, Now::ZERO);
            }
        }
    }

    /// What is news for the zone controller.
    pub fn reports(&mut self, now: Now) -> Vec<Report> {
        let (connected, counts_for) = (self.connected, self.counts_for);
        let mut reports = Vec::new();
        for (index, output) in self.outputs.iter_mut().enumerate() {
            let trouble = output.trouble(now, connected, counts_for);
            let lost = trouble.is_none_or(|it| it == Some(Trouble::Lost));
            let on = output.state().filter(|_| !lost && output.config.reports());
            let news = Report {
                output: index,
                on: on.filter(|_| output.reported != on),
                trouble: trouble.filter(|_| output.troubled != trouble),
            };
            output.reported = on.or(output.reported);
            output.troubled = trouble.or(output.troubled);
            if news.on.is_some() || news.trouble.is_some() {
                reports.push(news);
            }
        }
        reports
    }

    /// What is wrong with an output.
    pub fn trouble(&self, output: &Output, now: Now) -> Option<Trouble> {
        output.trouble(now, self.connected, self.counts_for).flatten()
    }
}

impl Output {
    fn new(config: OutputConfig) -> Self {
        Self {
            config,
            wanted: None,
            pending: false,
            closing: false,
            closes_first: false,
            again: Now::ZERO,
            failures: 0,
            refused: false,
            written: None,
            agrees: 0,
            confirmed: false,
            dropped: false,
            values: BTreeMap::new(),
            reported: None,
            troubled: None,
        }
    }

    /// Takes an order; whether it is another than before.
    fn order(&mut self, order: Order) -> bool {
        let before = self.wanted.map(|it| it.on);
        // A closing that is still under way is not overtaken by what opens.
        self.closing |= !order.on;
        self.closes_first = order.not_after.is_some() && self.closing;
        if before != Some(order.on) {
            (self.confirmed, self.dropped) = (false, false);
            (self.agrees, self.failures, self.again) = (0, 0, Now::ZERO);
        }
        (self.wanted, self.pending) = (Some(order), true);
        before != Some(order.on)
    }

    fn job(&self, index: usize, now: Now) -> Option<Job> {
        let order = self.wanted.filter(|_| self.pending && self.again <= now)?;
        let on = order.on && !self.closes_first;
        if on && order.not_after.is_some_and(|until| now > until) {
            return None;
        }
        let urgency = match (self.config.drives, on) {
            (Drives::Signal, _) => Urgency::Signals,
            (_, true) => Urgency::Opens,
            (_, false) => Urgency::Closes,
        };
        let (of, unit, again) = (Of::Output(index), self.config.unit, self.failures > 0);
        Some(Job { of, unit, on, urgency, again, number: order.number })
    }

    fn wrote(&mut self, now: Now, job: &Job, failure: Option<&Failure>) {
        self.refused = matches!(failure, Some(Failure::Exception(_)));
        match failure {
            None => {
                (self.written, self.agrees) = (Some((now, job.on)), 0);
                self.closing &= job.on;
                if self.closes_first && !job.on {
                    self.closes_first = false;
                } else if self.wanted.is_some_and(|it| it.number == job.number) {
                    self.pending = false;
                    self.confirmed |= !self.config.read_back;
                    if !self.config.read_back {
                        self.failures = 0;
                    }
                }
            }
            Some(Failure::GivenUp) => {}
            Some(_) => self.postpone(now),
        }
    }

    fn postpone(&mut self, now: Now) {
        self.again = now + pause(self.failures);
        self.failures = self.failures.saturating_add(1);
    }

    /// The value was read back.
    fn shows(&mut self, now: Now, state: Option<bool>, reads: u8) {
        let Some(order) = self.wanted else { return };
        if state == Some(order.on) {
            let answered = !self.pending && self.written.is_some_and(|(_, on)| on == order.on);
            if answered {
                self.agrees = self.agrees.saturating_add(1);
                if self.agrees >= reads {
                    (self.confirmed, self.dropped, self.failures) = (true, false, 0);
                }
            }
            return;
        }
        self.agrees = 0;
        let lost = std::mem::take(&mut self.confirmed);
        self.dropped |= lost;
        // What opens is not written again by itself.
        if !self.pending && order.not_after.is_none() {
            self.pending = true;
            if !lost {
                self.postpone(now);
            }
        }
    }

    /// As it is: as wanted only if everything that is known of it says so.
    pub fn state(&self) -> Option<bool> {
        let (reported, read) = (self.feedback(), self.read_back());
        let Some(order) = self.wanted else { return reported.or(read) };
        let reports = self.config.on.is_none() || reported == Some(order.on);
        let reads = !self.config.read_back || read == Some(order.on);
        Some(order.on == (self.confirmed && reports && reads))
    }

    /// What its feedback says.
    pub fn feedback(&self) -> Option<bool> {
        let point = self.config.on?;
        let (_, value) = self.values.get(&(point.table, point.address))?;
        Some(point.is_met(*value))
    }

    /// What was read back.
    pub fn read_back(&self) -> Option<bool> {
        let target = self.config.target;
        let (_, value) = self.values.get(&(target.table, target.address))?;
        target.state(*value).filter(|_| self.config.read_back)
    }

    /// Age of the oldest of its values.
    pub fn read_at(&self) -> Option<Now> {
        let places = self.config.places();
        let known = places.iter().map(|place| self.values.get(place).map(|(at, _)| *at));
        known.collect::<Option<Vec<Now>>>()?.into_iter().min()
    }

    /// What is wrong; `None`: not known yet.
    fn trouble(&self, now: Now, connected: bool, counts_for: Duration) -> Option<Option<Trouble>> {
        let lost = match self.read_at() {
            _ if self.config.places().is_empty() => !connected || self.failures > 0,
            Some(at) => now.saturating_sub(at) >= counts_for,
            None => true,
        };
        if lost {
            let known = self.read_at().is_some() || now >= counts_for;
            return known.then_some(Some(Trouble::Lost));
        }
        let fault = self.config.fault.is_some_and(|point| {
            let value = self.values.get(&(point.table, point.address));
            value.is_some_and(|(_, value)| point.is_met(*value))
        });
        Some(match (fault, self.dropped, self.refused) {
            (true, ..) => Some(Trouble::Fault),
            (_, true, _) => Some(Trouble::Dropped),
            (_, _, true) => Some(Trouble::Refused),
            _ => None,
        })
    }
}

/// Pause after so many failures before.
fn pause(failures: u32) -> Duration {
    AGAIN_FIRST.saturating_mul(1 << failures.min(8)).min(AGAIN_LAST)
}

#[cfg(test)]
#[path = "drive_tests.rs"]
mod tests;
