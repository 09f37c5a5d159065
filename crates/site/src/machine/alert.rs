//! What is seen and heard: troubles, sounders, lamps.

use super::Site;
use super::water::Set;
use crate::config::OutputKind;
use crate::event::Bypass;
use crate::output::{Cause, Entry, Tone};
use crate::state::{Phase, Trouble};

/// A trouble of the list.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub active: bool,
    pub since: u64,
}

impl Site {
    /// A trouble is there or not. What is over stays in the list until a reset.
    pub(super) fn trouble(&mut self, trouble: Trouble, index: usize, active: bool) {
        let known = self.troubles.get_mut(&(trouble, index));
        match known {
            None if !active => return,
            Some(known) if known.active == active => return,
            _ => {}
        }
        self.troubles.insert((trouble, index), Known { active, since: self.now });
        if active {
            self.silenced = false;
        }
        let subject = self.subject(trouble, index);
        self.record(Entry::Trouble { trouble, subject, active }, Vec::new());
    }

    /// The id of what a trouble is about.
    pub(super) fn subject(&self, trouble: Trouble, index: usize) -> String {
        let config = &self.plan.config;
        match trouble {
            Trouble::DetectorFault
            | Trouble::DetectorSilent
            | Trouble::DetectorDirty
            | Trouble::DetectorStuck => config.detectors[index].id.clone(),
            Trouble::Path => self.plan.paths[index].clone(),
            Trouble::ContactStuck => config.contacts[index].id.clone(),
            Trouble::MonitorUnreachable
            | Trouble::MonitorFailure
            | Trouble::MonitorIdle
            | Trouble::NotClosed => config.monitors[index].clone(),
            Trouble::OutputOverdue => config.outputs[index].id.clone(),
            Trouble::PumpFailed | Trouble::PumpOverdue => config.pumps[index].id.clone(),
            Trouble::NoPressure => String::new(),
            Trouble::NoMonitor | Trouble::FewJets => config.zones[index].id.clone(),
        }
    }

    pub(super) fn alerts(&mut self) {
        for output in 0..self.outputs.len() {
            let zone = self.plan.output_zone[output];
            let set = match self.plan.config.outputs[output].kind {
                OutputKind::Valve => continue,
                OutputKind::Sounder => Set::Tone(self.tone(zone)),
                OutputKind::AlarmLamp => Set::On(self.loudest(zone) >= Tone::Alarm),
                OutputKind::TroubleLamp => Set::On(!self.troubles.is_empty()),
                OutputKind::DisabledLamp => Set::On(self.is_disabled(zone)),
            };
            self.drive(output, set, vec![Cause::Shown]);
        }
    }

    /// What a sounder sounds.
    pub(super) fn tone(&self, zone: Option<usize>) -> Tone {
        let loudest = self.loudest(zone);
        let trouble = zone.is_none() && self.troubles.values().any(|known| known.active);
        let tone = if loudest == Tone::Off && trouble { Tone::Trouble } else { loudest };
        if self.silenced && tone < Tone::Countdown { Tone::Off } else { tone }
    }

    /// The most urgent of a zone, or of all.
    fn loudest(&self, zone: Option<usize>) -> Tone {
        let zones = (0..self.zones.len()).filter(|it| zone.is_none_or(|zone| zone == *it));
        let tone = |zone| match self.phase(zone) {
            Phase::Quiet => Tone::Off,
            Phase::Alarm | Phase::Coincidence => Tone::Alarm,
            Phase::Countdown => Tone::Countdown,
            Phase::Held => Tone::Held,
            Phase::Released { .. } => Tone::Released,
            Phase::Ended(_) if self.zones[zone].alarmed => Tone::Alarm,
            Phase::Ended(_) => Tone::Off,
        };
        zones.map(tone).max().unwrap_or_default()
    }

    pub(super) fn phase(&self, zone: usize) -> Phase {
        let state = &self.zones[zone];
        match (&state.release, &state.ended) {
            (Some(release), _) => {
                Phase::Released { automatic: release.automatic, wet: release.wet }
            }
            (None, Some(ended)) => Phase::Ended(ended.why),
            _ if state.held_since.is_some() => Phase::Held,
            _ if state.counting => Phase::Countdown,
            _ if state.met_since.is_some() => Phase::Coincidence,
            _ if state.alarmed => Phase::Alarm,
            _ => Phase::Quiet,
        }
    }

    /// Something of a zone, or of the site, is disabled.
    fn is_disabled(&self, zone: Option<usize>) -> bool {
        let bypassed = |index: &usize| self.detectors[*index].bypass != Bypass::None;
        match zone {
            None => !self.disablements().is_empty(),
            Some(zone) => {
                !self.armed(zone)
                    || self.zones[zone].mode.is_test()
                    || self.plan.config.zones[zone].delay_s > 0
                    || self.plan.zone_detectors[zone].iter().any(bypassed)
            }
        }
    }
}
