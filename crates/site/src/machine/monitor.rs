//! Monitors: which one works for which zone, and how each is opened and closed.

use super::zone::{Ended, Zone};
use super::{Site, ms};
use crate::event::{Authority, MonitorReport, Scope, Valve};
use crate::output::{Cause, Entry, Order, Why};
use crate::state::{Trouble, Withheld};

/// A monitor.
#[derive(Clone, Debug, Default)]
pub(super) struct Monitor {
    pub report: MonitorReport,
    /// Its valve was reported since the start.
    pub seen: bool,
    /// The zone that it works for.
    pub owner: Option<usize>,
    /// The zone for which it was last engaged, and whether by votes.
    pub engaged: Option<(usize, bool)>,
    pub engaged_at: u64,
    /// It does not act on its order.
    pub idle: bool,
    /// The zone towards which it was last turned.
    pub prepared: Option<usize>,
    pub closing: Option<Closing>,
    /// A person closed or stopped it.
    pub refused: Option<Ended>,
    /// Water of before the start, or that a person left on, ends at.
    pub found: Option<u64>,
    /// A person began the water that flows: an earlier no of the zone does not end it, nor does it end when the
    /// person releases the button.
    pub by_person: bool,
    /// A person took it from this zone, whose water was to end at this time. Found water may be of none.
    pub lent: Option<(Option<usize>, Option<u64>)>,
    /// A person took it before its order had opened it, which it may still do until then.
    pub on_its_way: Option<u64>,
    /// The zone for which the water that flows was ordered last, as far as it is known.
    pub water_of: Option<usize>,
    /// What the stored state allows that water, ms.
    pub stored_left: Option<u64>,
}

/// A Close that is not confirmed yet.
#[derive(Clone, Debug)]
pub(super) struct Closing {
    pub since: u64,
    pub next: u64,
    /// The valve was reported closed since the last order: what is open now was opened after it.
    pub shut: bool,
    /// A person has released this zone since: it may have the monitor before it is closed.
    pub yields: Option<usize>,
    pub cause: Vec<Cause>,
}

impl Monitor {
    /// It gives water, or is about to.
    pub(super) fn acts(&self) -> bool {
        self.report.acts()
    }

    /// It is reported closed.
    fn is_shut(&self) -> bool {
        let MonitorReport { reachable, valve, extinguishing, .. } = self.report;
        reachable && valve == Valve::Closed && !extinguishing
    }

    /// It does what was ordered; a valve that only moves has not yet.
    fn has_acted(&self) -> bool {
        self.report.valve == Valve::Open || self.report.extinguishing
    }
}

impl Site {
    pub(super) fn monitor_reports(&mut self, index: usize, report: MonitorReport) {
        self.order_lapses(index);
        let old = std::mem::replace(&mut self.monitors[index].report, report);
        let known = report.reachable && report.valve != Valve::Unknown;
        if known && !self.monitors[index].seen {
            self.monitors[index].seen = true;
            self.look_for_water(index);
        }
        self.water_of_people(index, &old);
        self.own_lockout(index, &old);
        let keeps = self.rules.person_keeps;
        let monitor = &mut self.monitors[index];
        if !report.reachable && old.reachable {
            // Its order is given again when it answers again.
            monitor.engaged = None;
            monitor.prepared = None;
        }
        if report.authority == Authority::Person && old.authority != Authority::Person && keeps {
            self.taken_by_person(index, old.acts());
        }
        let monitor = &mut self.monitors[index];
        if monitor.acts() {
            monitor.on_its_way = None;
        }
        if monitor.is_shut() {
            monitor.found = None;
            if monitor.on_its_way.is_none() {
                monitor.lent = None;
            }
            // Before it flows for the first time it is ordered all the same.
            if old.reachable && old.acts() {
                monitor.water_of = None;
            }
        }
        // Also when it was given back while its order was on its way.
        if report.authority != Authority::Person {
            self.given_back(index);
        }
    }

    /// A person takes it over, from a zone or with found water, which keeps its end. An order that has not opened it
    /// yet may be on its way: its water is no person's.
    fn taken_by_person(&mut self, index: usize, acted: bool) {
        let monitor = &mut self.monitors[index];
        let owner = monitor.owner.take();
        let ordered = owner.is_some() && monitor.water_of.is_some();
        if ordered && !acted && !monitor.acts() {
            monitor.on_its_way = Some(self.now.saturating_add(self.rules.valid_ms));
        }
        let until = |zone: usize| self.zones[zone].release.as_ref().and_then(|it| it.until);
        let lent = owner.map(|zone| (Some(zone), until(zone)));
        let zone = monitor.water_of.or(self.plan.monitor_zones[index].first().copied());
        let found = monitor.found.map(|until| (zone, Some(until)));
        monitor.lent = lent.or(found).or(monitor.lent);
        monitor.engaged = None;
        monitor.prepared = None;
        monitor.found = None;
        monitor.idle = false;
        self.out.persist = true;
    }

    /// An order that has not opened it in time will not any more: water that comes later is a person's.
    fn order_lapses(&mut self, index: usize) {
        let Some(until) = self.monitors[index].on_its_way else { return };
        if !self.due(until) {
            return;
        }
        let monitor = &mut self.monitors[index];
        monitor.on_its_way = None;
        if monitor.is_shut() {
            (monitor.lent, monitor.water_of) = (None, None);
        }
        self.out.persist = true;
    }

    /// What people do with the water of a monitor, by the report before this one.
    fn water_of_people(&mut self, index: usize, old: &MonitorReport) {
        let locked = self.is_locked();
        let (now, monitor) = (self.now, &mut self.monitors[index]);
        let (report, before) = (monitor.report, monitor.by_person);
        let person = report.authority == Authority::Person;
        if report.reachable && !monitor.acts() {
            monitor.by_person = false;
            // It was closed, and not by us: it is not opened again at once.
            if old.acts() && monitor.engaged.is_some() {
                monitor.engaged_at = now;
            }
        } else if person && report.reachable && monitor.acts() && !(old.reachable && old.acts()) {
            // What a person has taken over ends in its time: water of before the start, or of an order on its way.
            monitor.by_person = monitor.lent.is_none();
        }
        let closed = report.reachable && report.valve == Valve::Closed;
        monitor.closing.iter_mut().for_each(|it| it.shut |= closed);
        // One that opens is stronger than a Close of before, whose end was not reported; a valve takes its time.
        // One that jams while it closes is open again without having been closed.
        let shut = monitor.closing.as_ref().is_some_and(|it| it.shut);
        let begins = report.valve == Valve::Opening && old.valve != Valve::Opening;
        let opens = old.reachable && old.valve != Valve::Open;
        let opens = opens && (begins || (shut && report.valve == Valve::Open));
        if person && opens && !locked && !report.lockout && monitor.closing.take().is_some() {
            monitor.by_person = true;
        }
        self.out.persist |= monitor.by_person != before;
    }

    /// A monitor that was locked out while it worked, or was about to, does not come back with its key.
    fn own_lockout(&mut self, index: usize, old: &MonitorReport) {
        if !self.monitors[index].report.lockout || old.lockout {
            return;
        }
        let zones = self.plan.monitor_zones[index].iter().map(|zone| &self.zones[*zone]);
        let mut under_way = zones.map(|zone| zone.release.is_some() || zone.met_since.is_some());
        if self.monitors[index].owner.is_some() || under_way.any(|it| it) {
            let why = Why::Lockout;
            self.monitors[index].refused = Some(Ended { why, at: self.now, said: true });
            self.out.persist = true;
            let scope = Scope::Monitor(self.monitor_id(index));
            self.record(Entry::No { scope, why }, Vec::new());
        }
        // Its order would be accepted when the lockout is lifted.
        if self.monitors[index].owner.is_some() {
            self.shut(index, false, &[Cause::End(Why::Lockout)]);
        }
    }

    /// A person gives a monitor back: its release goes on, or what is left of its water.
    fn given_back(&mut self, index: usize) {
        let monitor = &self.monitors[index];
        let Some((zone, until)) = monitor.lent.filter(|_| monitor.owner.is_none()) else { return };
        // Its order may still open it.
        if monitor.on_its_way.is_some() {
            return;
        }
        let is_wet = |zone: &usize| self.zones[*zone].release.as_ref().is_some_and(|it| it.wet);
        let goes_on = zone.filter(is_wet);
        let monitor = &mut self.monitors[index];
        monitor.lent = None;
        if goes_on.is_some() && monitor.closing.is_none() && monitor.refused.is_none() {
            monitor.owner = goes_on;
        } else if monitor.acts() {
            monitor.found = until;
        }
    }

    /// Water that runs at the start is not ours to stop at once, nor to run for ever.
    fn look_for_water(&mut self, index: usize) {
        let monitor = &self.monitors[index];
        if !monitor.acts() || monitor.owner.is_some() {
            return;
        }
        if monitor.report.authority == Authority::Person {
            // Only water that a person took over from votes has a stored end; what was closed names no zone.
            let stored = monitor.stored_left.filter(|left| *left > 0 || monitor.water_of.is_some());
            let until = stored.map(|left| self.started.saturating_add(left));
            let zone = monitor.water_of.or(self.plan.monitor_zones[index].first().copied());
            self.monitors[index].lent = until.map(|until| (zone, Some(until)));
            return;
        }
        // What a person began ends by hand, as before.
        if monitor.by_person {
            return;
        }
        let zones = &self.plan.monitor_zones[index];
        let longest = zones.iter().map(|zone| ms(self.plan.config.zones[*zone].water_max_s)).max();
        // Its zones are not configured any more: what is stored ends all the same.
        let left = longest.into_iter().chain(monitor.stored_left).min();
        let Some(left) = left else { return };
        let until = self.started.saturating_add(left);
        self.monitors[index].found = Some(until);
        let left_ms = until.saturating_sub(self.now);
        let entry = Entry::WaterFound { monitor: self.monitor_id(index), left_ms };
        self.record(entry, Vec::new());
    }

    pub(super) fn prefer(&mut self, zone: usize, monitors: &[String], opens: Option<&[String]>) {
        self.zones[zone].preferred = self.of_zone(zone, monitors);
        self.zones[zone].opens = opens.map(|opens| self.of_zone(zone, opens));
        for index in 0..self.monitors.len() {
            if self.monitors[index].owner == Some(zone) && self.left_out(index, zone) {
                self.take_back(index, zone);
            }
        }
    }

    /// What votes have started with a monitor that they may not open any more ends. It is chosen again when it may.
    fn take_back(&mut self, index: usize, zone: usize) {
        let ordered = self.monitors[index].engaged.is_some();
        let cause = self.zones[zone].release.as_ref().map(|it| it.cause.clone());
        if let Some(cause) = cause.filter(|_| ordered) {
            self.shut(index, true, &cause);
        }
        (self.monitors[index].owner, self.monitors[index].idle) = (None, false);
        self.out.persist = true;
    }

    /// The monitors of a zone by their ids, each once.
    fn of_zone(&mut self, zone: usize, monitors: &[String]) -> Vec<usize> {
        let mut order = Vec::new();
        for id in monitors.iter().take(self.monitors.len()) {
            match self.plan.monitor(id) {
                Some(index) if self.plan.zone_monitors[zone].contains(&index) => {
                    if !order.contains(&index) {
                        order.push(index);
                    }
                }
                _ => self.unknown(id),
            }
        }
        order
    }

    /// Votes do not open it: the water would not suffice. Water that flows stays, and a hand is free.
    fn left_out(&self, index: usize, zone: usize) -> bool {
        let Zone { release, opens, .. } = &self.zones[zone];
        let automatic = release.as_ref().is_some_and(|it| it.automatic);
        let out = opens.as_ref().is_some_and(|opens| !opens.contains(&index));
        automatic && out && !self.monitors[index].acts()
    }

    /// The zone that a monitor works for.
    pub(super) fn works_for(&self, index: usize) -> Option<usize> {
        self.monitors[index].owner.filter(|zone| !self.left_out(index, *zone))
    }

    /// The monitors of a zone, the preferred first.
    fn in_order(&self, zone: usize) -> Vec<usize> {
        let mut order = self.zones[zone].preferred.clone();
        for &index in &self.plan.zone_monitors[zone] {
            if !order.contains(&index) {
                order.push(index);
            }
        }
        order
    }

    /// Why a monitor is not used.
    pub(super) fn withheld(&self, index: usize) -> Option<Withheld> {
        let Monitor { report, refused, .. } = &self.monitors[index];
        if report.lockout || (self.is_locked() && self.rules.lockout_before_hand) {
            Some(Withheld::Lockout)
        } else if refused.is_some() {
            Some(Withheld::Refused)
        } else if report.authority == Authority::Person && self.rules.person_keeps {
            Some(Withheld::Person)
        } else if !report.reachable {
            Some(Withheld::Unreachable)
        } else if report.failure {
            Some(Withheld::Failure)
        } else {
            None
        }
    }

    pub(super) fn monitors(&mut self) {
        let released = |site: &Self, zone: &usize, automatic: bool| {
            let release = site.zones[*zone].release.as_ref();
            release.is_some_and(|release| release.wet && release.automatic == automatic)
        };
        // A release by hand chooses first.
        for automatic in [false, true] {
            for zone in 0..self.zones.len() {
                if released(self, &zone, automatic) {
                    self.choose(zone, automatic);
                }
            }
        }
        for index in 0..self.monitors.len() {
            self.monitor(index);
        }
        let all_working = self.all_working();
        for (zone, working) in all_working.into_iter().enumerate() {
            let wet = released(self, &zone, false) || released(self, &zone, true);
            self.trouble(Trouble::NoMonitor, zone, wet && working == 0);
            let few = wet && working > 0 && working < self.jets_wanted(zone);
            self.trouble(Trouble::FewJets, zone, few);
        }
    }

    /// So many monitors the zone wants at once: where `jets` says so, as far as the planner has water for
    /// them.
    fn jets_wanted(&self, zone: usize) -> usize {
        let Some(jets) = self.plan.config.zones[zone].jets else { return 0 };
        let Zone { release, opens, .. } = &self.zones[zone];
        let automatic = release.as_ref().is_some_and(|it| it.automatic);
        let most = opens.as_ref().filter(|_| automatic).map_or(usize::MAX, Vec::len);
        usize::from(jets).min(most)
    }

    /// Monitors that work for a zone as ordered.
    fn working(&self, zone: usize) -> usize {
        (0..self.monitors.len()).filter(|index| self.works_as_ordered(*index) == Some(zone)).count()
    }

    /// The same of each zone, in one walk: there are many monitors.
    fn all_working(&self) -> Vec<usize> {
        let mut working = vec![0; self.zones.len()];
        let zones = (0..self.monitors.len()).filter_map(|index| self.works_as_ordered(index));
        zones.for_each(|zone| working[zone] += 1);
        working
    }

    fn works_as_ordered(&self, index: usize) -> Option<usize> {
        let zone = self.works_for(index)?;
        (!self.monitors[index].idle && self.withheld(index).is_none()).then_some(zone)
    }

    /// Takes monitors for a released zone, until it has its jets.
    fn choose(&mut self, zone: usize, automatic: bool) {
        let order = self.in_order(zone);
        let jets = self.plan.config.zones[zone].jets.map_or(order.len(), usize::from);
        let Some(chosen) = self.zones[zone].release.as_ref().map(|it| it.chosen) else { return };
        if chosen && !self.rules.lost_is_replaced {
            return;
        }
        let mut working = self.working(zone);
        for index in order {
            if working >= jets {
                break;
            }
            let monitor = &self.monitors[index];
            let taken = monitor.owner.is_some_and(|other| {
                let theirs = self.zones[other].release.as_ref();
                other == zone || automatic || theirs.is_some_and(|it| !it.automatic)
            });
            let withheld = self.withheld(index).is_some() || self.left_out(index, zone);
            let waits = |it: &&Closing| automatic || it.yields != Some(zone);
            let closing = monitor.closing.as_ref().filter(waits).map(|it| it.since);
            // One that never reports that it is closed is not lost for the next fire.
            let late = self.rules.overdue_ms;
            let closes = closing.is_some_and(|since| !self.due(since.saturating_add(late)));
            if taken || closes || withheld {
                continue;
            }
            let monitor = &mut self.monitors[index];
            monitor.closing = None;
            monitor.owner = Some(zone);
            monitor.idle = false;
            monitor.found = None;
            (monitor.lent, monitor.on_its_way) = (None, None);
            self.out.persist = true;
            working += 1;
            self.busy = true;
            if chosen {
                let (zone, monitor) = (self.zone_id(zone), self.monitor_id(index));
                self.record(Entry::Replaced { zone, monitor }, Vec::new());
            }
        }
        if let Some(release) = &mut self.zones[zone].release {
            release.chosen = true;
        }
    }

    fn monitor(&mut self, index: usize) {
        self.monitor_troubles(index);
        self.refusal_lapses(index);
        self.order_lapses(index);
        if let Some(until) = self.monitors[index].found
            && self.due(until)
        {
            let cause =
                [Cause::Found { monitor: self.monitor_id(index) }, Cause::End(Why::Duration)];
            self.shut(index, false, &cause);
            for zone in self.plan.monitor_zones[index].clone() {
                self.known_valves(zone);
            }
        }
        self.water_in_spite(index);
        if self.monitors[index].closing.is_some() {
            self.close_again(index);
            return;
        }
        self.trouble(Trouble::NotClosed, index, false);
        match self.monitors[index].owner {
            Some(zone) => self.engage(index, zone),
            None => self.prepare(index),
        }
    }

    fn monitor_troubles(&mut self, index: usize) {
        let MonitorReport { reachable, failure, .. } = self.monitors[index].report;
        let patience = self.started.saturating_add(self.rules.overdue_ms);
        let lost = !reachable && (self.monitors[index].seen || self.due(patience));
        self.trouble(Trouble::MonitorUnreachable, index, lost);
        self.trouble(Trouble::MonitorFailure, index, failure);
    }

    /// A no for a monitor lapses like one for its zones.
    fn refusal_lapses(&mut self, index: usize) {
        let Some(at) = self.monitors[index].refused.as_ref().map(|it| it.at) else { return };
        let zones = self.plan.monitor_zones[index].iter();
        let lapses: Option<Vec<u64>> = zones.map(|zone| self.lapse(*zone, at)).collect();
        let Some(lapse) = lapses.and_then(|all| all.into_iter().max()) else { return };
        if self.due(lapse) {
            self.monitors[index].refused = None;
            self.out.persist = true;
            let scope = Scope::Monitor(self.monitor_id(index));
            self.record(Entry::Lapsed { scope }, Vec::new());
        }
    }

    /// Water that comes in spite of a no is closed again: a late order, or a valve that does not hold.
    /// A person at the monitor is stronger, except against lockout.
    fn water_in_spite(&mut self, index: usize) {
        let monitor = &self.monitors[index];
        let locked = self.is_locked() || monitor.report.lockout;
        let person = monitor.report.authority == Authority::Person;
        let theirs = person || monitor.by_person;
        if monitor.closing.is_some() || !monitor.acts() || (theirs && !locked) {
            return;
        }
        // Of found water it is known for which zone it runs, if that was stored.
        let of_one = monitor.water_of.filter(|_| monitor.found.is_some());
        let all = self.plan.monitor_zones[index].iter();
        let ended = all.filter(|it| of_one.is_none_or(|one| one == **it)).find_map(|zone| {
            let ended = self.zones[*zone].ended.as_ref().map(|it| it.why);
            ended.or(self.says_no(*zone))
        });
        let why = match (&monitor.refused, ended) {
            _ if locked => Why::Lockout,
            (Some(refused), _) => refused.why,
            (None, Some(why)) if monitor.owner.is_none() => why,
            _ => return,
        };
        self.shut(index, false, &[Cause::End(why)]);
    }

    /// Closes a monitor now, and again until it is reported closed.
    pub(super) fn shut(&mut self, index: usize, stop: bool, cause: &[Cause]) {
        let next = self.now.saturating_add(self.rules.repeat_ms);
        let monitor = &mut self.monitors[index];
        let since = monitor.closing.as_ref().map_or(self.now, |it| it.since);
        let shut = monitor.report.reachable && monitor.report.valve == Valve::Closed;
        monitor.closing = Some(Closing { since, next, shut, yields: None, cause: cause.to_vec() });
        monitor.owner = None;
        monitor.engaged = None;
        monitor.prepared = None;
        monitor.found = None;
        (monitor.lent, monitor.on_its_way) = (None, None);
        monitor.water_of = None;
        monitor.by_person = false;
        monitor.idle = false;
        self.out.persist = true;
        if stop {
            self.command(Order::Stop { monitor: self.monitor_id(index) }, cause.to_vec());
        }
        self.command(Order::Close { monitor: self.monitor_id(index) }, cause.to_vec());
    }

    /// The first look is a repetition later: a report of before the order does not confirm it.
    fn close_again(&mut self, index: usize) {
        let Some(Closing { since, next, cause, .. }) = self.monitors[index].closing.clone() else {
            return;
        };
        let late = self.due(since.saturating_add(self.rules.overdue_ms));
        self.trouble(Trouble::NotClosed, index, late);
        if !self.due(next) {
            return;
        }
        if self.monitors[index].is_shut() || !self.rules.close_repeats {
            self.monitors[index].closing = None;
            self.busy = true;
            self.out.persist = true;
            return;
        }
        if let Some(closing) = &mut self.monitors[index].closing {
            closing.next = self.now.saturating_add(self.rules.repeat_ms);
        }
        let mut chain = cause;
        chain.push(Cause::Repeated);
        self.command(Order::Close { monitor: self.monitor_id(index) }, chain);
    }

    fn engage(&mut self, index: usize, zone: usize) {
        if self.withheld(index).is_some() {
            return;
        }
        if self.left_out(index, zone) {
            self.trouble(Trouble::MonitorIdle, index, false);
            return;
        }
        let Some(release) = &self.zones[zone].release else { return };
        let (automatic, until) = (release.automatic, release.until);
        let mut cause = release.cause.clone();
        let within = ms(self.plan.config.zones[zone].act_within_s);
        let acted = self.monitors[index].has_acted();
        if acted {
            self.monitors[index].idle = false;
        }
        let engaged = self.monitors[index].engaged;
        let same = engaged == Some((zone, automatic));
        let since = self.monitors[index].engaged_at;
        let overdue = same && !acted && self.due(since.saturating_add(within));
        if overdue {
            self.monitors[index].idle = true;
            cause.push(Cause::Repeated);
        }
        let idle = self.monitors[index].idle;
        self.trouble(Trouble::MonitorIdle, index, idle);
        if same && !overdue {
            return;
        }
        self.monitors[index].engaged = Some((zone, automatic));
        self.monitors[index].engaged_at = self.now;
        self.monitors[index].by_person = false;
        self.monitors[index].water_of = Some(zone);
        self.out.persist = true;
        let water_max_ms = until.map(|until| until.saturating_sub(self.now));
        let (monitor, zone) = (self.monitor_id(index), self.zone_id(zone));
        self.command(Order::Engage { monitor, zone, water_max_ms }, cause);
    }

    /// Turns a monitor before the release, and in a test instead of it.
    fn prepare(&mut self, index: usize) {
        self.trouble(Trouble::MonitorIdle, index, false);
        let wants = |zone: &&usize| {
            let zone = &self.zones[**zone];
            zone.met_since.is_some() || zone.release.as_ref().is_some_and(|it| !it.wet)
        };
        let zone = self.plan.monitor_zones[index].iter().find(wants).copied();
        let monitor = &self.monitors[index];
        if zone.is_none() || monitor.prepared == zone {
            self.monitors[index].prepared = zone;
            return;
        }
        if monitor.acts() || self.withheld(index).is_some() {
            return;
        }
        self.monitors[index].prepared = zone;
        if let Some(zone) = zone {
            let since = self.zones[zone].met_since.unwrap_or(self.now);
            let cause = match &self.zones[zone].release {
                Some(release) => release.cause.clone(),
                None => self.vote_causes(&self.tally(zone), since),
            };
            let (monitor, zone) = (self.monitor_id(index), self.zone_id(zone));
            self.command(Order::Prepare { monitor, zone }, cause);
        }
    }
}
