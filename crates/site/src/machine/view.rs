//! The state for a console.

use super::water::Set;
use super::{Site, ms};
use crate::config::{ContactKind, Mode};
use crate::event::{Bypass, Scope};
use crate::output::Why;
use crate::state::{
    DetectorState, Disablement, MonitorState, NotReleased, OutputState, Phase, PumpState, State,
    Trouble, TroubleState, Voteless, ZoneState,
};

impl Site {
    /// Whether a no for this lasts: one more changes nothing before a reset.
    pub fn is_refused(&self, scope: &Scope) -> bool {
        match scope {
            Scope::Site => {
                let by_hand = self.pumps.iter().any(|pump| pump.hand == Some(true));
                self.zones.iter().all(|zone| zone.ended.is_some()) && !by_hand
            }
            Scope::Zone(id) => {
                self.plan.zone(id).is_some_and(|zone| self.zones[zone].ended.is_some())
            }
            Scope::Monitor(id) => {
                self.plan.monitor(id).is_some_and(|it| self.monitors[it].refused.is_some())
            }
        }
    }

    /// The state now, as of the last event or step.
    pub fn state(&self) -> State {
        let config = &self.plan.config;
        let detectors = config.detectors.iter().enumerate().map(|(index, it)| DetectorState {
            detector: it.id.clone(),
            signal: self.detectors[index].signal,
            unable: self.unable(index),
            stale: self.detectors[index].stale,
        });
        let monitors = self.monitors.iter().enumerate().map(|(index, it)| MonitorState {
            monitor: self.monitor_id(index),
            engaged_for: self.works_for(index).map(|zone| self.zone_id(zone)),
            closing: it.closing.is_some(),
            withheld: self.withheld(index),
            found_left_ms: it.found.map(|until| until.saturating_sub(self.now)),
        });
        let pumps = self.pumps.iter().enumerate().map(|(index, it)| PumpState {
            pump: config.pumps[index].id.clone(),
            on: it.on,
            pressure: self.plan.pump_pressure[index].map(|gauge| self.contacts[gauge].level),
            failed: it.failed,
            runs: it.reported,
            hand: it.hand,
        });
        let outputs = self.outputs.iter().enumerate().map(|(index, it)| OutputState {
            output: config.outputs[index].id.clone(),
            on: it.set.map(Set::is_on),
            reported: it.reported,
        });
        let troubles = self.troubles.iter().map(|((trouble, index), known)| TroubleState {
            trouble: *trouble,
            subject: self.subject(*trouble, *index),
            since_ms: known.since,
            active: known.active,
        });
        State {
            at_ms: self.now,
            lockout: self.is_locked(),
            tone: self.tone(None),
            zones: self.zone_states(),
            detectors: detectors.collect(),
            monitors: monitors.collect(),
            pumps: pumps.collect(),
            outputs: outputs.collect(),
            troubles: troubles.collect(),
            disablements: self.disablements(),
        }
    }

    fn zone_states(&self) -> Vec<ZoneState> {
        let mut monitors = vec![Vec::new(); self.zones.len()];
        for index in 0..self.monitors.len() {
            if let Some(zone) = self.works_for(index) {
                monitors[zone].push(self.monitor_id(index));
            }
        }
        let zones = monitors.into_iter().enumerate();
        zones.map(|(zone, monitors)| self.zone_state(zone, monitors)).collect()
    }

    fn zone_state(&self, zone: usize, monitors: Vec<String>) -> ZoneState {
        let config = &self.plan.config;
        let (configured, state) = (&config.zones[zone], &self.zones[zone]);
        let tally = self.tally(zone);
        let id = |index: &usize| config.detectors[*index].id.clone();
        let detectors = &self.plan.zone_detectors[zone];
        let unable = detectors
            .iter()
            .filter_map(|it| Some(Voteless { detector: id(it), why: self.unable(*it)? }));
        let held_now = state.held_since.map_or(0, |since| self.now.saturating_sub(since));
        let held_ms = state.held_ms.saturating_add(held_now);
        let until = state.release.as_ref().and_then(|release| release.until);
        let coincides = state.met_since.map(|since| {
            let from = since.saturating_add(ms(configured.coincidence_s));
            from.saturating_add(ms(configured.delay_s)).saturating_add(held_ms)
        });
        ZoneState {
            zone: configured.id.clone(),
            phase: self.phase(zone),
            mode: state.mode,
            switch_manual: self.pressed(zone, ContactKind::ManualSwitch),
            returns_in_ms: state.mode_until.map(|until| until.saturating_sub(self.now)),
            votes: tally.votes.iter().map(id).collect(),
            alarms: detectors.iter().filter(|it| self.alarms(**it)).map(id).collect(),
            need: tally.need,
            unable: unable.collect(),
            ready: self.armed(zone)
                && tally.need.is_some()
                && self.can_serve(zone)
                && self.is_supplied(zone),
            left_ms: coincides.map(|at| at.saturating_sub(self.now)),
            hold_left_ms: ms(configured.hold_max_s).saturating_sub(held_ms),
            water_left_ms: until.map(|until| until.saturating_sub(self.now)),
            reacted_in_ms: state.reacted_in_ms,
            not_released: self.not_released(zone),
            monitors,
        }
    }

    fn can_serve(&self, zone: usize) -> bool {
        self.plan.zone_monitors[zone].iter().any(|index| self.withheld(*index).is_none())
    }

    /// Its valve and as many pumps as it has without those in reserve can be reached and run, and no
    /// supervised supply is lost.
    fn is_supplied(&self, zone: usize) -> bool {
        let config = &self.plan.config;
        let lost = |id: &String| {
            let path =
                self.plan.path(id).and_then(|path| self.troubles.get(&(Trouble::Path, path)));
            path.is_some_and(|known| known.active)
        };
        let valve = config.zones[zone].valve.as_ref();
        if valve.is_some_and(lost) || config.paths.iter().any(lost) {
            return false;
        }
        let wanted = config.pumps.iter().filter(|pump| !pump.standby).count();
        let able = config.pumps.iter().zip(&self.pumps);
        let able =
            able.filter(|(it, pump)| !pump.failed && pump.hand != Some(false) && !lost(&it.id));
        !config.zones[zone].pumps || able.count() >= wanted
    }

    /// Everything that keeps a zone with an alarm from being released.
    fn not_released(&self, zone: usize) -> Vec<NotReleased> {
        let state = &self.zones[zone];
        let tally = self.tally(zone);
        if !tally.alarm || state.release.is_some() {
            return Vec::new();
        }
        let mode = self.mode(zone);
        let have = u16::try_from(tally.votes.len()).unwrap_or(u16::MAX);
        let few = tally.need.filter(|need| have < *need);
        let reasons = [
            self.is_locked().then_some(NotReleased::Lockout),
            self.pressed(zone, ContactKind::Abort).then_some(NotReleased::AbortPressed),
            self.pressed(zone, ContactKind::Stop).then_some(NotReleased::StopPressed),
            state.ended.as_ref().map(|ended| NotReleased::Ended(ended.why)),
            (!mode.votes_release()).then_some(NotReleased::Mode(mode)),
            tally.need.is_none().then_some(NotReleased::Failed),
            few.map(|need| NotReleased::Votes { have, need }),
            (!tally.kinds && few.is_none()).then_some(NotReleased::Kinds),
            tally.stale.then_some(NotReleased::Stale),
            match self.phase(zone) {
                Phase::Coincidence => Some(NotReleased::Coincidence),
                Phase::Countdown => Some(NotReleased::Delay),
                Phase::Held => Some(NotReleased::Held),
                _ => None,
            },
            (!self.can_serve(zone)).then_some(NotReleased::NoMonitor),
        ];
        reasons.into_iter().flatten().collect()
    }

    /// Everything that is disabled.
    pub(super) fn disablements(&self) -> Vec<Disablement> {
        let config = &self.plan.config;
        let mut all: Vec<Disablement> =
            self.is_locked().then_some(Disablement::Lockout).into_iter().collect();
        for (index, detector) in self.detectors.iter().enumerate() {
            if detector.bypass != Bypass::None {
                let bypass = detector.bypass;
                let detector = config.detectors[index].id.clone();
                all.push(Disablement::Detector { detector, bypass });
            }
        }
        for (index, state) in self.zones.iter().enumerate() {
            let (zone, mode) = (self.zone_id(index), self.mode(index));
            if mode != Mode::Automatic {
                let returns_in_ms = state.mode_until.map(|until| until.saturating_sub(self.now));
                all.push(Disablement::Mode { zone: zone.clone(), mode, returns_in_ms });
            }
            if let Some(ended) = &state.ended {
                all.push(Disablement::Ended { zone: zone.clone(), why: ended.why });
            }
            if config.zones[index].delay_s > 0 {
                all.push(Disablement::Delay { zone, delay_ms: ms(config.zones[index].delay_s) });
            }
        }
        let refused = |index: usize| -> Option<Why> {
            self.monitors[index].refused.as_ref().map(|it| it.why)
        };
        for index in 0..self.monitors.len() {
            if let Some(why) = refused(index) {
                all.push(Disablement::Monitor { monitor: self.monitor_id(index), why });
            }
        }
        for (index, pump) in self.pumps.iter().enumerate() {
            if pump.hand == Some(false) {
                all.push(Disablement::Pump { pump: config.pumps[index].id.clone() });
            }
        }
        all
    }
}
