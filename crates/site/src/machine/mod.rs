//! The machine: events and time in, commands and records out.
//!
//! An event changes what is known; then [`Site::settle`] walks once through contacts, detectors, zones,
//! monitors, valves, pumps and what is shown, in this order, so a no is looked at before anything that
//! opens. A time that is compared goes through [`Site::due`], which also finds the next deadline.

mod alert;
mod contact;
mod detector;
mod fingerprint;
mod hand;
mod monitor;
mod start;
mod view;
mod vote;
mod water;
mod zone;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::event::Event;
use crate::output::{Cause, Command, Entry, Order, Reaction, Record};
use crate::plan::Plan;
use crate::rules::Rules;
use crate::state::Trouble;

/// Most walks for one event; the second finds nothing more to do.
const WALKS: usize = 4;
/// Longest name of a person that is kept, in characters.
const NAME_MAX: usize = 64;

/// The zone controller of a site.
#[derive(Clone, Debug)]
pub struct Site {
    plan: Arc<Plan>,
    rules: Rules,
    started: u64,
    now: u64,
    next: Option<u64>,
    number: u64,
    detectors: Vec<detector::Detector>,
    contacts: Vec<contact::Contact>,
    zones: Vec<zone::Zone>,
    monitors: Vec<monitor::Monitor>,
    pumps: Vec<water::Pump>,
    outputs: Vec<water::Output>,
    /// Lockout by command.
    lockout: bool,
    /// Lockout was ordered last.
    locked_at: Option<u64>,
    /// The pumps were last cut by a Stop or lockout of the site.
    cut_at: Option<u64>,
    pumps_since: Option<u64>,
    troubles: BTreeMap<(Trouble, usize), alert::Known>,
    silenced: bool,
    out: Reaction,
    /// Something changed during this walk.
    busy: bool,
}

impl Site {
    /// Takes an event in. A time before the last one counts as the last one.
    pub fn handle(&mut self, now_ms: u64, event: &Event) -> Reaction {
        self.now = self.now.max(now_ms);
        match event {
            Event::Detector { detector, signal, condition } => match self.plan.detector(detector) {
                Some(index) => self.detector_reports(index, *signal, *condition),
                None => self.unknown(detector),
            },
            Event::Contact { input, pressed } => match self.plan.contact(input) {
                Some(index) => self.contact_reports(index, *pressed),
                None => self.unknown(input),
            },
            Event::Path { path, fault } => match self.plan.path(path) {
                Some(index) => self.path_reports(index, fault.is_some()),
                None => self.unknown(path),
            },
            Event::Monitor { monitor, report } => match self.plan.monitor(monitor) {
                Some(index) => self.monitor_reports(index, *report),
                None => self.unknown(monitor),
            },
            Event::Output { output, on } => match self.plan.output(output) {
                Some(index) => self.outputs[index].reported = Some(*on),
                None => self.unknown(output),
            },
            Event::Pump { pump, on } => match self.plan.pump(pump) {
                Some(index) => self.pumps[index].reported = Some(*on),
                None => self.unknown(pump),
            },
            Event::Hand { by, order } => {
                let by: String = by.chars().take(NAME_MAX).collect();
                self.hand(&by, order);
            }
            Event::Prefer { zone, monitors, opens } => match self.plan.zone(zone) {
                Some(index) => self.prefer(index, monitors, opens.as_deref()),
                None => self.unknown(zone),
            },
        }
        self.settle();
        std::mem::take(&mut self.out)
    }

    /// Lets time pass.
    pub fn step(&mut self, now_ms: u64) -> Reaction {
        self.now = self.now.max(now_ms);
        self.settle();
        std::mem::take(&mut self.out)
    }

    /// When [`Site::step`] has to be called at the latest; `None`: an event comes first.
    pub fn next_deadline(&self) -> Option<u64> {
        self.next
    }

    fn settle(&mut self) {
        for _ in 0..WALKS {
            self.next = None;
            self.busy = false;
            self.walk();
            if !self.busy {
                return;
            }
        }
        let soon = self.now.saturating_add(1);
        self.next = Some(self.next.map_or(soon, |next| next.min(soon)));
    }

    fn walk(&mut self) {
        self.contacts();
        self.detectors();
        for zone in 0..self.zones.len() {
            self.zone(zone);
        }
        self.monitors();
        self.valves();
        self.pumps();
        self.alerts();
    }

    /// Whether a time has come; if not, it is a deadline.
    fn due(&mut self, at: u64) -> bool {
        if at <= self.now {
            return true;
        }
        self.next = Some(self.next.map_or(at, |next| next.min(at)));
        false
    }

    fn number(&mut self) -> u64 {
        self.number = self.number.saturating_add(1);
        self.number
    }

    fn command(&mut self, order: Order, cause: Vec<Cause>) {
        let opens = matches!(
            order,
            Order::Prepare { .. }
                | Order::Engage { .. }
                | Order::Pump { on: true, .. }
                | Order::Valve { open: true, .. }
        );
        let not_after_ms = opens.then(|| self.now.saturating_add(self.rules.valid_ms));
        let number = self.number();
        self.busy = true;
        self.out.commands.push(Command { number, at_ms: self.now, not_after_ms, order, cause });
    }

    /// Records what happened; the number of the record.
    fn record(&mut self, entry: Entry, cause: Vec<Cause>) -> u64 {
        let number = self.number();
        self.busy = true;
        self.out.records.push(Record { number, at_ms: self.now, entry, cause });
        number
    }

    fn unknown(&mut self, name: &str) {
        let name = name.chars().take(NAME_MAX).collect();
        self.record(Entry::Unknown { name }, Vec::new());
    }

    fn zone_id(&self, zone: usize) -> String {
        self.plan.config.zones[zone].id.clone()
    }

    fn monitor_id(&self, monitor: usize) -> String {
        self.plan.config.monitors[monitor].clone()
    }
}

/// Seconds of the configuration in milliseconds.
fn ms(seconds: u32) -> u64 {
    u64::from(seconds) * 1000
}
