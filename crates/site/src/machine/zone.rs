//! A zone: from votes to a release, and from a release to its end.

use std::collections::BTreeSet;

use super::{Site, ms};
use crate::config::{ContactKind, Mode};
use crate::event::Scope;
use crate::output::{Cause, Entry, Why};
use crate::state::Trouble;

/// A zone.
#[derive(Clone, Debug, Default)]
pub(super) struct Zone {
    pub mode: Mode,
    pub mode_until: Option<u64>,
    /// Enough votes coincide since, while the zone is armed.
    pub met_since: Option<u64>,
    /// The delay runs.
    pub counting: bool,
    /// Held so far, without the present hold.
    pub held_ms: u64,
    /// Held since.
    pub held_since: Option<u64>,
    /// A person holds at a console.
    pub hold_by: Option<String>,
    pub release: Option<Release>,
    /// It was ended; not ready until a reset.
    pub ended: Option<Ended>,
    /// A detector is in alarm.
    pub alarmed: bool,
    /// The last alarm began.
    pub alarm_since: u64,
    /// When the last alarm ended.
    pub last_alarm: u64,
    /// The planner's order of its monitors.
    pub preferred: Vec<usize>,
    /// Those that votes may open; `None`: all.
    pub opens: Option<Vec<usize>>,
    pub reacted_in_ms: Option<u64>,
}

/// A release.
#[derive(Clone, Debug)]
pub(super) struct Release {
    pub automatic: bool,
    pub wet: bool,
    /// Its water ends at.
    pub until: Option<u64>,
    pub quiet_since: Option<u64>,
    pub cause: Vec<Cause>,
    /// Detectors that have voted for it.
    pub voters: BTreeSet<usize>,
    /// Its first monitors have been chosen.
    pub chosen: bool,
}

/// What ended a zone.
#[derive(Clone, Debug)]
pub(super) struct Ended {
    pub why: Why,
    pub at: u64,
    /// A person said it: a release by hand at the same time loses.
    pub said: bool,
}

impl Site {
    pub(super) fn zone(&mut self, zone: usize) {
        self.mode_returns(zone);
        let alarm = self.tally(zone).alarm;
        if self.zones[zone].alarmed && !alarm {
            self.zones[zone].last_alarm = self.now;
        }
        if !self.zones[zone].alarmed && alarm {
            self.zones[zone].alarm_since = self.now;
        }
        self.zones[zone].alarmed = alarm;
        self.no_lapses(zone);
        if self.zones[zone].release.is_some() {
            self.released(zone);
        } else {
            self.waiting(zone);
        }
    }

    fn mode_returns(&mut self, zone: usize) {
        let Some(until) = self.zones[zone].mode_until else { return };
        if self.due(until) && self.rules.mode_returns {
            let tested = self.zones[zone].mode.is_test();
            self.set_mode(zone, Mode::Automatic, None, Vec::new());
            // Votes that are there when the test ends by itself release nothing without a person.
            if tested && self.tally(zone).met {
                self.is_old(zone, Why::TestOver, self.now);
            }
        }
    }

    /// What was there while something kept it back needs a reset.
    fn is_old(&mut self, zone: usize, why: Why, at: u64) {
        if self.zones[zone].ended.is_none() {
            let said = why.is_said();
            self.zones[zone].ended = Some(Ended { why, at, said });
            self.out.persist = true;
            self.record(Entry::Ended { zone: self.zone_id(zone), why }, Vec::new());
        }
    }

    /// The key is back: what is in alarm does not release by it, nor by votes that are missing yet. The lockout was
    /// the no, not its end: a reset may follow at once.
    pub(super) fn after_lockout(&mut self) {
        if self.is_locked() {
            return;
        }
        let least = self.now.saturating_sub(self.rules.no_holds_ms);
        let at = self.locked_at.map_or(self.now, |at| at.max(least));
        for zone in 0..self.zones.len() {
            if self.tally(zone).alarm {
                self.is_old(zone, Why::Lockout, at);
            }
        }
    }

    pub(super) fn set_mode(
        &mut self,
        zone: usize,
        mode: Mode,
        for_ms: Option<u64>,
        cause: Vec<Cause>,
    ) {
        self.zones[zone].mode = mode;
        self.zones[zone].mode_until = for_ms.map(|it| self.now.saturating_add(it));
        self.out.persist = true;
        let entry = Entry::Mode { zone: self.zone_id(zone), mode, returns_in_ms: for_ms };
        self.record(entry, cause);
    }

    /// The time after which a no of a zone lapses, if it is quiet until then.
    pub(super) fn lapse(&self, zone: usize, at: u64) -> Option<u64> {
        let after = self.plan.config.zones[zone].return_after_s?;
        let quiet = !self.zones[zone].alarmed && self.zones[zone].release.is_none();
        quiet.then(|| at.max(self.zones[zone].last_alarm).saturating_add(ms(after)))
    }

    fn no_lapses(&mut self, zone: usize) {
        let Some(at) = self.zones[zone].ended.as_ref().map(|it| it.at) else { return };
        let Some(lapse) = self.lapse(zone, at) else { return };
        if self.says_no(zone).is_none() && self.due(lapse) {
            self.zones[zone].ended = None;
            self.out.persist = true;
            let scope = Scope::Zone(self.zone_id(zone));
            self.record(Entry::Lapsed { scope }, Vec::new());
        }
    }

    /// The mode, with the switch.
    pub(super) fn mode(&self, zone: usize) -> Mode {
        let mode = self.zones[zone].mode;
        let switched = mode == Mode::Automatic && self.pressed(zone, ContactKind::ManualSwitch);
        if switched { Mode::Manual } else { mode }
    }

    /// Nothing but missing votes keeps it from releasing by itself.
    pub(super) fn armed(&self, zone: usize) -> bool {
        let mode = self.mode(zone).votes_release() || !self.rules.mode_counts;
        mode && self.says_no(zone).is_none()
            && !self.is_locked()
            && self.zones[zone].ended.is_none()
    }

    fn waiting(&mut self, zone: usize) {
        let tally = self.tally(zone);
        if !tally.met || !self.armed(zone) {
            if self.zones[zone].met_since.is_some() {
                let why = if tally.met { Why::Mode } else { Why::Votes };
                self.cancel(zone, why);
            }
            return;
        }
        let since = match self.zones[zone].met_since {
            Some(since) => since,
            None => {
                self.zones[zone].met_since = Some(self.now);
                let cause = self.vote_causes(&tally, self.now);
                self.silenced = false;
                self.record(Entry::Enough { zone: self.zone_id(zone) }, cause);
                self.now
            }
        };
        let configured = &self.plan.config.zones[zone];
        let (coincidence, delay) = (ms(configured.coincidence_s), ms(configured.delay_s));
        let from = since.saturating_add(if self.rules.coincidence { coincidence } else { 0 });
        if !self.due(from) {
            return;
        }
        if !self.zones[zone].counting {
            self.zones[zone].counting = true;
            let entry = Entry::Countdown { zone: self.zone_id(zone), delay_ms: delay };
            self.record(entry, self.vote_causes(&tally, since));
        }
        let stuck: Vec<usize> =
            self.holds(zone).filter(|(_, held)| !held).map(|(index, _)| index).collect();
        for index in stuck {
            self.trouble(Trouble::ContactStuck, index, true);
        }
        if self.held(zone, from) {
            return;
        }
        let held_ms = self.zones[zone].held_ms;
        let delay = if self.rules.delay { delay } else { 0 };
        let at = from.saturating_add(delay).saturating_add(held_ms);
        if self.due(at) {
            let mut cause = self.vote_causes(&tally, since);
            cause.push(Cause::Delay { delay_ms: delay, held_ms });
            self.release(zone, true, at, cause);
        }
    }

    /// The delay is held now. All holds of a countdown together are limited.
    fn held(&mut self, zone: usize, from: u64) -> bool {
        let configured = &self.plan.config.zones[zone];
        let most = match self.rules.hold_ends {
            true => ms(configured.hold_max_s),
            false => u64::MAX,
        };
        let wanted = configured.hold && self.rules.hold && self.holding(zone);
        let used = self.zones[zone].held_ms;
        let Some(since) = self.zones[zone].held_since else {
            if wanted && used < most {
                self.zones[zone].held_since = Some(self.now.max(from));
                self.record_hold(zone, true, most - used);
                return self.held(zone, from);
            }
            return false;
        };
        let end = since.saturating_add(most - used);
        let over = self.due(end);
        if wanted && !over {
            return true;
        }
        let held = self.now.min(end).saturating_sub(since);
        self.zones[zone].held_ms = used.saturating_add(held);
        self.zones[zone].held_since = None;
        self.record_hold(zone, false, most - used - held);
        false
    }

    /// A person holds, by contact or console.
    pub(super) fn holding(&self, zone: usize) -> bool {
        self.zones[zone].hold_by.is_some() || self.holds(zone).any(|(_, held)| held)
    }

    fn record_hold(&mut self, zone: usize, on: bool, left_ms: u64) {
        let by = self.zones[zone].hold_by.clone().map(|by| Cause::Hand { by });
        let pressed = self.holds(zone).filter(|(_, held)| *held);
        let pressed = pressed.map(|(it, _)| self.plan.config.contacts[it].id.clone());
        let cause = by.into_iter().chain(pressed.map(|input| Cause::Contact { input })).collect();
        self.record(Entry::Held { zone: self.zone_id(zone), on, left_ms }, cause);
    }

    /// Ends what comes before a release.
    pub(super) fn cancel(&mut self, zone: usize, why: Why) {
        let state = &mut self.zones[zone];
        state.counting = false;
        state.held_ms = 0;
        state.held_since = None;
        if state.met_since.take().is_some() {
            self.record(Entry::Cancelled { zone: self.zone_id(zone), why }, Vec::new());
        }
    }

    /// Releases a zone; its monitors are chosen in the same walk.
    pub(super) fn release(
        &mut self,
        zone: usize,
        automatic: bool,
        condition_at: u64,
        cause: Vec<Cause>,
    ) {
        let wet = !self.mode(zone).is_test() || !self.rules.test_is_dry;
        let most = ms(self.plan.config.zones[zone].water_max_s);
        let until = automatic.then(|| self.now.saturating_add(most));
        let state = &mut self.zones[zone];
        state.met_since = None;
        state.counting = false;
        state.held_ms = 0;
        state.held_since = None;
        state.hold_by = None;
        state.reacted_in_ms = Some(self.now.saturating_sub(condition_at));
        let entry = Entry::Released {
            zone: self.zone_id(zone),
            automatic,
            wet,
            condition_at_ms: condition_at,
        };
        let record = self.record(entry, cause.clone());
        let mut cause = cause;
        cause.push(Cause::Release { record });
        let quiet_since = None;
        let voters = BTreeSet::new();
        let release = Release { automatic, wet, until, quiet_since, cause, voters, chosen: false };
        self.zones[zone].release = Some(release);
        self.silenced = false;
        self.out.persist = true;
    }

    fn released(&mut self, zone: usize) {
        let Some(release) = &self.zones[zone].release else { return };
        let (automatic, wet, until) = (release.automatic, release.wet, release.until);
        if !wet && !self.mode(zone).is_test() {
            self.end(zone, Why::TestOver, &[]);
            return;
        }
        if let Some(until) = until
            && self.rules.water_ends
            && self.due(until)
        {
            self.end(zone, Why::Duration, &[]);
            return;
        }
        let Some(quiet_ends) = self.plan.config.zones[zone].quiet_ends_s.filter(|_| automatic)
        else {
            return;
        };
        let (alarm, now) = (self.zones[zone].alarmed, self.now);
        let votes = self.tally(zone).votes;
        self.zones[zone].release.iter_mut().for_each(|it| it.voters.extend(&votes));
        // One that has seen the fire and cannot see now does not say that it is out.
        let blind = |voter: &usize| self.unable(*voter).is_some();
        let blind = self.zones[zone].release.iter().any(|it| it.voters.iter().any(blind));
        let Some(release) = &mut self.zones[zone].release else { return };
        if alarm || blind {
            release.quiet_since = None;
            return;
        }
        let since = *release.quiet_since.get_or_insert(now);
        if self.due(since.saturating_add(ms(quiet_ends))) {
            self.end(zone, Why::Quiet, &[]);
        }
    }

    /// Ends a release: its monitors close. A no or the greatest duration last until a reset.
    pub(super) fn end(&mut self, zone: usize, why: Why, cause: &[Cause]) {
        let Some(release) = self.zones[zone].release.take() else { return };
        self.out.persist = true;
        if why == Why::Duration {
            self.zones[zone].ended = Some(Ended { why, at: self.now, said: false });
        }
        // The time without alarm that lets a no lapse is counted from here.
        self.zones[zone].last_alarm = self.now;
        self.record(Entry::Ended { zone: self.zone_id(zone), why }, cause.to_vec());
        let mut chain = release.cause;
        chain.extend_from_slice(cause);
        chain.push(Cause::End(why));
        for monitor in 0..self.monitors.len() {
            if self.monitors[monitor].owner == Some(zone) {
                self.shut(monitor, why == Why::Stop || why == Why::Lockout, &chain);
            }
        }
    }
}
