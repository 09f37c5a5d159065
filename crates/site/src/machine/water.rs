//! Zone valves, test outlets and pumps.

use super::{Site, ms};
use crate::config::Mode;
use crate::event::Authority;
use crate::output::{Cause, Order, Tone};
use crate::state::Trouble;

/// An output.
#[derive(Clone, Debug, Default)]
pub(super) struct Output {
    /// As last commanded.
    pub set: Option<Set>,
    pub set_at: u64,
    pub next: u64,
    pub reported: Option<bool>,
    /// A valve that was opened or refused since the start; before that it stays as found.
    pub known: bool,
}

/// What an output was commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Set {
    On(bool),
    Tone(Tone),
}

impl Set {
    pub(super) fn is_on(self) -> bool {
        match self {
            Self::On(on) => on,
            Self::Tone(tone) => tone != Tone::Off,
        }
    }
}

/// A pump.
#[derive(Clone, Debug, Default)]
pub(super) struct Pump {
    /// As last commanded.
    pub on: Option<bool>,
    pub started: u64,
    /// Its pressure was there.
    pub seen: bool,
    pub lost_since: Option<u64>,
    pub failed: bool,
    /// It failed, and a standby pump runs in its place until no water wants pumps: the pressure may be that one's.
    pub replaced: bool,
    /// It runs, and is not asked for any more, since.
    pub idle_since: Option<u64>,
    /// A person started or stopped it, and when.
    pub hand: Option<bool>,
    pub hand_at: u64,
    pub set_at: u64,
    pub next: u64,
    /// It reports that it runs.
    pub reported: Option<bool>,
    /// Its command may have been lost with its line.
    pub again: bool,
}

impl Site {
    /// The valves of a zone are not left as found any more.
    pub(super) fn known_valves(&mut self, zone: usize) {
        let valves = [self.plan.zone_valve[zone], self.plan.zone_outlet[zone]];
        for output in valves.into_iter().flatten() {
            self.outputs[output].known = true;
        }
    }

    /// A monitor of the zone where a person has water, or left it on. A no of before that does not end it.
    fn water_by_hand(&self, zone: usize) -> Option<usize> {
        let refused = self.is_locked() || self.says_no(zone).is_some();
        let mut monitors = self.plan.zone_monitors[zone].iter().copied();
        let person = |index: &usize| {
            let monitor = &self.monitors[*index];
            let theirs = monitor.report.authority == Authority::Person || monitor.by_person;
            theirs && monitor.acts() && monitor.closing.is_none()
        };
        monitors.find(person).filter(|_| !refused)
    }

    /// Water that runs, or is to run, in a zone: what causes it.
    fn water_cause(&self, zone: usize) -> Option<Vec<Cause>> {
        if let Some(release) = self.zones[zone].release.as_ref().filter(|it| it.wet) {
            return Some(release.cause.clone());
        }
        let monitor = self.water_by_hand(zone)?;
        Some(vec![Cause::WaterByHand { monitor: self.monitor_id(monitor) }])
    }

    /// The release of a test that opens the test outlet.
    fn outlet_cause(&self, zone: usize) -> Option<Vec<Cause>> {
        let release = self.zones[zone].release.as_ref().filter(|it| !it.wet)?;
        (self.zones[zone].mode == Mode::TestOutlet).then(|| release.cause.clone())
    }

    pub(super) fn valves(&mut self) {
        for zone in 0..self.zones.len() {
            if let Some(valve) = self.plan.zone_valve[zone] {
                // Water that was found running keeps the valve as it is.
                let found = |it: &usize| self.monitors[*it].found.is_some();
                let found = self.plan.zone_monitors[zone].iter().any(found);
                let cause = self.water_cause(zone);
                if cause.is_some() || !found {
                    self.valve(valve, cause);
                }
            }
            if let Some(outlet) = self.plan.zone_outlet[zone] {
                let cause = self.outlet_cause(zone);
                self.valve(outlet, cause);
            }
        }
    }

    fn valve(&mut self, output: usize, open: Option<Vec<Cause>>) {
        let on = open.is_some();
        if on {
            self.outputs[output].known = true;
        }
        if self.outputs[output].known {
            self.drive(output, Set::On(on), open.unwrap_or_default());
        }
    }

    /// A line is well again: what was commanded over it may have been lost.
    pub(super) fn command_again(&mut self, path: usize) {
        let (outputs, others) = (self.outputs.len(), self.plan.config.paths.len());
        let Some(at) = path.checked_sub(self.contacts.len()) else { return };
        if let Some(output) = self.outputs.get_mut(at) {
            output.set = None;
        } else if let Some(pump) = at.checked_sub(outputs + others) {
            self.pumps.get_mut(pump).into_iter().for_each(|it| it.again = true);
        }
    }

    /// Commands an output, and repeats it until it is reported where it reports.
    pub(super) fn drive(&mut self, output: usize, set: Set, mut cause: Vec<Cause>) {
        let feedback = self.plan.config.outputs[output].feedback;
        let state = &self.outputs[output];
        let changed = state.set != Some(set);
        let (set_at, next) = (state.set_at, state.next);
        let missing = feedback && state.reported != Some(set.is_on());
        let late = missing && !changed && self.due(set_at.saturating_add(self.rules.overdue_ms));
        self.trouble(Trouble::OutputOverdue, output, late);
        let again = missing && !changed && self.due(next);
        if !changed && !again {
            return;
        }
        if again {
            cause.push(Cause::Repeated);
        }
        let state = &mut self.outputs[output];
        if changed {
            state.set_at = self.now;
        }
        state.set = Some(set);
        state.next = self.now.saturating_add(self.rules.repeat_ms);
        let id = self.plan.config.outputs[output].id.clone();
        let order = match (set, self.plan.config.outputs[output].kind) {
            (Set::Tone(tone), _) => Order::Sound { output: id, tone },
            (Set::On(open), crate::config::OutputKind::Valve) => Order::Valve { output: id, open },
            (Set::On(lit), _) => Order::Lamp { output: id, lit },
        };
        self.command(order, cause);
        if missing || feedback {
            self.due(self.now.saturating_add(self.rules.repeat_ms));
        }
    }

    pub(super) fn pump_by_hand(&mut self, pump: usize, on: bool, cause: &[Cause]) {
        (self.pumps[pump].hand, self.pumps[pump].hand_at) = (Some(on), self.now);
        self.out.persist = true;
        if !on && self.pumps[pump].on != Some(false) {
            self.set_pump(pump, false, cause.to_vec());
        }
    }

    /// After a reset: pumps run by themselves again.
    pub(super) fn forget_pumps(&mut self) {
        for pump in &mut self.pumps {
            (pump.hand, pump.replaced) = (None, false);
            if pump.on != Some(true) {
                pump.failed = false;
            }
        }
    }

    /// Stop and lockout of the site: the pumps stop at once. One that a person keeps off stays off: a mechanic may
    /// work on it.
    pub(super) fn cut_pumps(&mut self, cause: &[Cause]) {
        self.cut_at = Some(self.now);
        for index in 0..self.pumps.len() {
            self.pumps[index].hand.take_if(|on| *on);
            if self.pumps[index].on != Some(false) {
                self.set_pump(index, false, cause.to_vec());
            }
        }
        self.pumps_since = None;
    }

    fn set_pump(&mut self, index: usize, on: bool, cause: Vec<Cause>) {
        let now = self.now;
        let pump = &mut self.pumps[index];
        pump.on = Some(on);
        pump.seen = false;
        pump.lost_since = None;
        pump.failed = false;
        pump.idle_since = None;
        (pump.set_at, pump.next) = (now, now.saturating_add(self.rules.repeat_ms));
        if on {
            pump.started = now;
        }
        self.trouble(Trouble::PumpFailed, index, false);
        let pump = self.plan.config.pumps[index].id.clone();
        self.command(Order::Pump { pump, on }, cause);
    }

    /// Why the pumps run, if they are to.
    fn pumps_cause(&self) -> Option<Vec<Cause>> {
        let zones = self.plan.zones().filter(|(_, zone)| zone.pumps);
        let mut causes = zones
            .filter_map(|(zone, _)| self.water_cause(zone).or_else(|| self.outlet_cause(zone)));
        causes.next()
    }

    pub(super) fn pumps(&mut self) {
        let cause = self.pumps_cause();
        let wanted = cause.is_some();
        if wanted {
            self.pumps_since = Some(self.pumps_since.unwrap_or(self.now));
        } else {
            self.pumps_since = None;
            self.pumps.iter_mut().for_each(|it| it.replaced = false);
        }
        let cause = cause.unwrap_or_default();
        // Water that was found running, or is running out its time, keeps the pumps that run.
        let found = self.monitors.iter().any(|monitor| monitor.found.is_some());
        let mut previous = None;
        let mut waiting = false;
        // Pumps that failed before it in the row.
        let mut missing: Vec<usize> = Vec::new();
        for index in 0..self.pumps.len() {
            let standby = self.plan.config.pumps[index].standby;
            let replaces = standby && !missing.is_empty();
            let asked = self.pumps[index].hand.unwrap_or(wanted && (!standby || replaces));
            let mut cause = cause.clone();
            let lost = (asked && replaces).then(|| missing.remove(0));
            if let Some(lost) = lost {
                cause.push(Cause::InPlaceOf { lost: self.plan.config.pumps[lost].id.clone() });
            }
            if self.pumps[index].on == Some(true) {
                self.watch(index);
                let idle = self.pumps[index].idle_since.unwrap_or(self.now);
                self.pumps[index].idle_since = (!asked).then_some(idle);
                if asked {
                    previous = Some(self.pumps[index].started);
                } else if !found || self.pumps[index].hand == Some(false) {
                    self.stop_pump(index);
                }
            } else if asked && !waiting {
                waiting = !self.start_pump(index, previous, cause);
                previous = Some(self.pumps[index].started).filter(|_| !waiting);
            }
            if let Some(lost) = lost.filter(|_| self.pumps[index].on == Some(true)) {
                self.pumps[lost].replaced |= self.pumps[lost].failed;
            }
            // One that a person keeps off is missing like one that failed.
            let off = wanted && !standby && self.pumps[index].hand == Some(false);
            let Pump { failed, replaced, .. } = self.pumps[index];
            if (off || asked && (failed || replaced)) && self.rules.pump_is_replaced {
                missing.push(index);
            }
        }
        for index in 0..self.pumps.len() {
            self.confirm_pump(index);
        }
        let on = |pump: &&Pump| pump.on == Some(true);
        let running = self.pumps.iter().filter(on).count();
        let failed = self.pumps.iter().filter(on).all(|pump| pump.failed);
        let none = wanted && running == 0 && !waiting && !self.pumps.is_empty();
        self.trouble(Trouble::NoPressure, 0, none || running > 0 && failed);
    }

    /// Commands a pump again that does not report what it was commanded.
    fn confirm_pump(&mut self, index: usize) {
        if std::mem::take(&mut self.pumps[index].again)
            && let Some(on) = self.pumps[index].on
        {
            let pump = self.plan.config.pumps[index].id.clone();
            self.command(Order::Pump { pump, on }, vec![Cause::Repeated]);
        }
        let (configured, pump) = (&self.plan.config.pumps[index], &self.pumps[index]);
        let Some(on) = pump.on.filter(|_| configured.feedback) else { return };
        let (set_at, next) = (pump.set_at, pump.next);
        let missing = pump.reported != Some(on);
        let late = missing && self.due(set_at.saturating_add(self.rules.overdue_ms));
        self.trouble(Trouble::PumpOverdue, index, late);
        // Without a contact for its pressure nothing else says that it has failed.
        if self.plan.pump_pressure[index].is_none() {
            self.pumps[index].failed = on && late;
        }
        if missing && self.due(next) {
            let next = self.now.saturating_add(self.rules.repeat_ms);
            self.pumps[index].next = next;
            let pump = self.plan.config.pumps[index].id.clone();
            self.command(Order::Pump { pump, on }, vec![Cause::Repeated]);
            self.due(next);
        }
    }

    /// Starts a pump when the one before it has had its time.
    fn start_pump(&mut self, index: usize, previous: Option<u64>, cause: Vec<Cause>) -> bool {
        let delay = ms(self.plan.config.pumps[index].start_delay_s);
        let since = previous.or(self.pumps_since).unwrap_or(self.now);
        let delay = if self.pumps_since.is_none() && previous.is_none() { 0 } else { delay };
        if self.rules.pumps_wait && !self.due(since.saturating_add(delay)) {
            return false;
        }
        let cause = if cause.is_empty() { vec![Cause::Shown] } else { cause };
        self.set_pump(index, true, cause);
        true
    }

    fn stop_pump(&mut self, index: usize) {
        let run_on = ms(self.plan.config.run_on_s);
        let idle = self.pumps[index].idle_since.unwrap_or(self.now);
        if self.pumps[index].hand == Some(false) || self.due(idle.saturating_add(run_on)) {
            self.set_pump(index, false, Vec::new());
        }
    }

    /// Pressure that does not come, or goes, is a failure of the pump.
    fn watch(&mut self, index: usize) {
        let Some(gauge) = self.plan.pump_pressure[index] else { return };
        let timeout = ms(self.plan.config.pumps[index].start_timeout_s);
        let now = self.now;
        let pump = &mut self.pumps[index];
        if self.contacts[gauge].level {
            pump.seen = true;
            pump.lost_since = None;
            pump.failed = false;
        } else {
            let from = match pump.seen {
                true => *pump.lost_since.get_or_insert(now),
                false => pump.started,
            };
            let late = self.due(from.saturating_add(timeout));
            self.pumps[index].failed |= late;
        }
        let failed = self.pumps[index].failed;
        self.trouble(Trouble::PumpFailed, index, failed);
    }
}
