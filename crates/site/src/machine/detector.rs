//! Detectors: who can vote.

use super::{Site, ms};
use crate::event::{Bypass, Condition, Signal};
use crate::output::Entry;
use crate::state::{Trouble, Unable};

/// A detector.
#[derive(Clone, Debug, Default)]
pub(super) struct Detector {
    /// `None`: not heard since the start.
    pub signal: Option<Signal>,
    pub condition: Condition,
    pub condition_since: u64,
    pub heard: u64,
    pub silent: bool,
    /// A self-test or start does not end.
    pub stuck: bool,
    /// It was in alarm when it was first heard.
    pub stale: bool,
    /// In alarm since.
    pub since: u64,
    pub bypass: Bypass,
}

impl Site {
    pub(super) fn detector_reports(&mut self, index: usize, signal: Signal, condition: Condition) {
        let now = self.now;
        let limit = ms(self.plan.config.detectors[index].silent_after_s);
        let detector = &mut self.detectors[index];
        let late = now >= detector.heard.saturating_add(limit);
        if late && !detector.silent {
            // The silence comes to light with the report that ends it: what voted before is over.
            detector.silent = true;
            self.drop_unmet(index);
        }
        let detector = &mut self.detectors[index];
        detector.heard = now;
        detector.silent = false;
        let same = detector.signal == Some(signal) && detector.condition == condition;
        if same {
            return;
        }
        if detector.condition != condition {
            detector.condition = condition;
            detector.condition_since = now;
            detector.stuck = false;
        }
        if signal != Signal::Alarm {
            detector.stale = false;
        } else if detector.signal != Some(Signal::Alarm) {
            detector.stale = detector.signal.is_none();
            detector.since = now;
            if detector.bypass != Bypass::Disabled {
                self.silenced = false;
            }
        }
        self.detectors[index].signal = Some(signal);
        let unable = self.unable(index);
        let detector = self.plan.config.detectors[index].id.clone();
        self.record(Entry::Detector { detector, signal, condition, unable }, Vec::new());
    }

    pub(super) fn detectors(&mut self) {
        for index in 0..self.detectors.len() {
            let configured = &self.plan.config.detectors[index];
            let (quiet, test) = (ms(configured.silent_after_s), ms(configured.self_test_max_s));
            let Detector { heard, condition, condition_since, .. } = self.detectors[index];
            let testing = matches!(condition, Condition::SelfTest | Condition::Starting);
            self.detectors[index].silent = self.due(heard.saturating_add(quiet));
            self.detectors[index].stuck = testing && self.due(condition_since.saturating_add(test));
            let Detector { silent, stuck, .. } = self.detectors[index];
            self.trouble(Trouble::DetectorSilent, index, silent);
            self.trouble(Trouble::DetectorStuck, index, stuck);
            self.trouble(Trouble::DetectorFault, index, condition == Condition::Fault);
            self.trouble(Trouble::DetectorDirty, index, condition == Condition::Dirty);
        }
    }

    /// Why a detector has no vote.
    pub(super) fn unable(&self, index: usize) -> Option<Unable> {
        let detector = &self.detectors[index];
        let masked = detector.bypass != Bypass::None && self.rules.masked_has_no_vote;
        let dirty_votes = self.plan.config.detectors[index].dirty_votes;
        match detector.condition {
            _ if masked => Some(Unable::Bypass(detector.bypass)),
            _ if detector.signal.is_none() => Some(Unable::NeverHeard),
            _ if detector.silent && self.rules.silent_has_no_vote => Some(Unable::Silent),
            Condition::Ready => None,
            Condition::Dirty if dirty_votes => None,
            _ if !self.rules.fault_has_no_vote => None,
            _ if detector.stuck => Some(Unable::TestStuck),
            condition => Some(Unable::Condition(condition)),
        }
    }

    /// Its alarm is shown.
    pub(super) fn alarms(&self, index: usize) -> bool {
        let detector = &self.detectors[index];
        detector.signal == Some(Signal::Alarm) && detector.bypass != Bypass::Disabled
    }

    /// It votes now.
    pub(super) fn votes(&self, index: usize) -> bool {
        let stale = self.detectors[index].stale && self.rules.stale_has_no_vote;
        self.detectors[index].signal == Some(Signal::Alarm)
            && !stale
            && self.unable(index).is_none()
    }
}
