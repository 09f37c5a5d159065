//! The start: what is known, and that nothing opens or closes by it.

use std::sync::Arc;

use lafet_texts::{Text as _, site as text};

use super::contact::Contact;
use super::detector::Detector;
use super::monitor::Monitor;
use super::water::{Output, Pump};
use super::zone::{Ended, Zone};
use super::{Site, ms};
use crate::config::{Config, Problem};
use crate::event::Bypass;
use crate::output::{Entry, Reaction};
use crate::persisted::{Persisted, StoredMonitor, StoredZone, VERSION};
use crate::plan::Plan;
use crate::rules::Rules;

impl Site {
    /// A machine at the start of the hub. It sends no command for a monitor, a pump or a valve: votes of
    /// before the start do not count, and water that runs is found when its monitor reports it.
    ///
    /// # Errors
    ///
    /// All problems of the configuration, and a stored state of another version.
    pub fn new(
        config: Config,
        now_ms: u64,
        stored: Option<&Persisted>,
    ) -> Result<(Self, Reaction), Vec<Problem>> {
        Self::with_rules(config, now_ms, stored, Rules::RIGHT)
    }

    /// As [`Site::new`], by other rules: for the tests of the oracle alone.
    ///
    /// # Errors
    ///
    /// As [`Site::new`].
    #[doc(hidden)]
    pub fn with_rules(
        config: Config,
        now_ms: u64,
        stored: Option<&Persisted>,
        rules: Rules,
    ) -> Result<(Self, Reaction), Vec<Problem>> {
        let mut problems = config.check();
        if let Some(version) = stored.map(|it| it.version).filter(|it| *it != VERSION) {
            problems.push(Problem {
                place: "state".to_owned(),
                what: text::StoredVersion { found: version, wanted: VERSION }.words(),
                remedy: text::StoredVersionRemedy.words(),
            });
        }
        if !problems.is_empty() {
            return Err(problems);
        }
        let mut site = Self::empty(config, now_ms, rules);
        let dropped = stored.map(|stored| site.restore(stored)).unwrap_or_default();
        site.record(Entry::Started { dropped }, Vec::new());
        if !rules.start_is_inert {
            for index in 0..site.monitors.len() {
                site.shut(index, false, &[]);
            }
        }
        site.settle();
        let reaction = std::mem::take(&mut site.out);
        Ok((site, reaction))
    }

    fn empty(config: Config, now: u64, rules: Rules) -> Self {
        let plan = Arc::new(Plan::new(config));
        let config = &plan.config;
        let detector = Detector { heard: now, condition_since: now, ..Detector::default() };
        let zones = config.zones.iter();
        let zones = zones
            .map(|zone| Zone { mode: zone.mode, last_alarm: now, ..Zone::default() })
            .collect();
        Self {
            rules,
            started: now,
            now,
            next: None,
            number: 0,
            detectors: vec![detector; config.detectors.len()],
            contacts: vec![Contact::default(); config.contacts.len()],
            zones,
            monitors: vec![Monitor::default(); config.monitors.len()],
            pumps: vec![Pump::default(); config.pumps.len()],
            outputs: vec![Output::default(); config.outputs.len()],
            lockout: false,
            locked_at: None,
            cut_at: None,
            pumps_since: None,
            troubles: std::collections::BTreeMap::new(),
            silenced: false,
            out: Reaction::default(),
            busy: false,
            plan,
        }
    }

    /// Takes the stored state in; the names in it that are not configured any more.
    fn restore(&mut self, stored: &Persisted) -> Vec<String> {
        let now = self.now;
        let mut dropped = Vec::new();
        self.lockout = stored.lockout;
        for (id, zone) in &stored.zones {
            let Some(index) = self.plan.zone(id) else {
                dropped.push(id.clone());
                continue;
            };
            let state = &mut self.zones[index];
            state.mode = zone.mode;
            // A test that lost its end is over.
            state.mode_until = match zone.returns_in_ms {
                None if zone.mode.is_test() => Some(now),
                left => left.map(|left| now.saturating_add(left)),
            };
            state.ended = zone.ended.map(|why| Ended { why, at: now, said: why.is_said() });
        }
        for (id, bypass) in &stored.detectors {
            match self.plan.detector(id) {
                Some(index) => self.detectors[index].bypass = *bypass,
                None => dropped.push(id.clone()),
            }
        }
        for id in &stored.pressed {
            match self.plan.contact(id).filter(|it| self.plan.config.contacts[*it].kind.is_kept()) {
                Some(index) => self.contacts[index].level = true,
                None => dropped.push(id.clone()),
            }
        }
        // A lockout of before the start counts as one of now, as each no does.
        self.locked_at = self.is_locked().then_some(now);
        for id in &stored.pumps_off {
            match self.plan.pump(id) {
                Some(index) => {
                    let pump = &mut self.pumps[index];
                    (pump.hand, pump.hand_at) = (Some(false), now);
                }
                None => dropped.push(id.clone()),
            }
        }
        for (id, monitor) in &stored.monitors {
            let Some(index) = self.plan.monitor(id) else {
                dropped.push(id.clone());
                continue;
            };
            self.monitors[index].refused =
                monitor.refused.map(|why| Ended { why, at: now, said: true });
            self.monitors[index].stored_left = monitor.water_left_ms;
            self.monitors[index].by_person = monitor.by_person;
            let zone = monitor.zone.as_ref().and_then(|zone| self.plan.zone(zone));
            let serves = |zone: &usize| self.plan.monitor_zones[index].contains(zone);
            self.monitors[index].water_of = zone.filter(serves);
        }
        dropped
    }

    /// What has to survive a loss of power. Store it when a reaction says so, and every few seconds while a
    /// time runs in it.
    pub fn persisted(&self) -> Persisted {
        let left = |at: Option<u64>| at.map(|at| at.saturating_sub(self.now));
        let config = &self.plan.config;
        let zones = config.zones.iter().zip(&self.zones).map(|(zone, state)| {
            let stored = StoredZone {
                mode: state.mode,
                returns_in_ms: left(state.mode_until),
                ended: state.ended.as_ref().map(|it| it.why),
            };
            (zone.id.clone(), stored)
        });
        let detectors = config.detectors.iter().zip(&self.detectors);
        let detectors = detectors.filter(|(_, state)| state.bypass != Bypass::None);
        let monitors = config.monitors.iter().zip(&self.monitors).map(|(id, state)| {
            let water = state.owner.map(|zone| match &self.zones[zone].release {
                Some(release) if release.until.is_some() => left(release.until).unwrap_or_default(),
                _ => ms(config.zones[zone].water_max_s),
            });
            // One that was not heard of yet has what was stored before.
            let before = state.stored_left.filter(|_| !state.seen);
            let before = before.map(|left| self.started.saturating_add(left));
            // Its end was ordered, and is not confirmed.
            let water = water.or(state.closing.as_ref().map(|_| 0));
            let water_left_ms = water
                .or(left(state.found))
                .or(left(state.lent.and_then(|(_, until)| until)))
                .or(left(before));
            let zone = state.owner.or(state.water_of);
            let stored = StoredMonitor {
                refused: state.refused.as_ref().map(|it| it.why),
                water_left_ms,
                zone: zone.map(|zone| self.zone_id(zone)),
                by_person: state.by_person && zone.is_none(),
            };
            (id.clone(), stored)
        });
        let contacts = config.contacts.iter().zip(&self.contacts);
        let pressed = contacts.filter(|(it, state)| it.kind.is_kept() && state.level);
        let pumps = config.pumps.iter().zip(&self.pumps);
        let pumps_off = pumps.filter(|(_, state)| state.hand == Some(false));
        Persisted {
            pressed: pressed.map(|(it, _)| it.id.clone()).collect(),
            version: VERSION,
            lockout: self.lockout,
            zones: zones.collect(),
            detectors: detectors.map(|(it, state)| (it.id.clone(), state.bypass)).collect(),
            monitors: monitors.filter(|(_, it)| *it != StoredMonitor::default()).collect(),
            pumps_off: pumps_off.map(|(it, _)| it.id.clone()).collect(),
        }
    }
}
