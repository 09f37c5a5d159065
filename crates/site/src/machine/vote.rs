//! The count of the votes of a zone.

use std::collections::BTreeSet;

use super::Site;
use crate::config::{Kind, Reduced};
use crate::output::Cause;

/// The votes of a zone.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    /// Detectors that vote.
    pub votes: Vec<usize>,
    /// Detectors without a vote.
    pub unable: usize,
    /// A detector is in alarm, with or without a vote.
    pub alarm: bool,
    /// An alarm of before the start does not vote.
    pub stale: bool,
    /// Votes that release; `None`: nothing does.
    pub need: Option<u16>,
    /// The votes are of enough kinds.
    pub kinds: bool,
    /// They release.
    pub met: bool,
}

impl Site {
    pub(super) fn tally(&self, zone: usize) -> Tally {
        let configured = &self.plan.config.zones[zone];
        let mut tally = Tally::default();
        let (mut kinds, mut able_kinds) = (BTreeSet::new(), BTreeSet::new());
        for &index in &self.plan.zone_detectors[zone] {
            tally.alarm |= self.alarms(index);
            let able = self.unable(index).is_none();
            tally.unable += usize::from(!able);
            let kind = self.plan.config.detectors[index].kind;
            if able {
                able_kinds.insert(kind);
            }
            if self.votes(index) {
                tally.votes.push(index);
                kinds.insert(kind);
            } else {
                tally.stale |= able && self.detectors[index].stale;
            }
        }
        tally.need = match tally.unable.checked_sub(1) {
            None => Some(configured.votes.need),
            Some(_) if !self.rules.failure_reduces => Some(configured.votes.need),
            Some(failed) => match configured.when_failed.get(failed) {
                Some(Reduced::Votes(votes)) => Some(votes.need),
                Some(Reduced::Alarm) | None => None,
            },
        };
        let enough = |kinds: &BTreeSet<Kind>| kinds.len() >= usize::from(configured.kinds);
        tally.kinds = !self.rules.kinds_count || enough(&kinds);
        // With those that are left it can never be met.
        if self.rules.kinds_count && !enough(&able_kinds) {
            tally.need = None;
        }
        let have = tally.votes.len() + self.rules.missing_votes;
        tally.met = tally.kinds && tally.need.is_some_and(|need| have >= usize::from(need));
        tally
    }

    /// The chain from the votes to a release.
    pub(super) fn vote_causes(&self, tally: &Tally, since_ms: u64) -> Vec<Cause> {
        let votes = tally.votes.iter().map(|index| Cause::Vote {
            detector: self.plan.config.detectors[*index].id.clone(),
            since_ms: self.detectors[*index].since,
        });
        let enough = Cause::Enough { need: tally.need.unwrap_or_default(), since_ms };
        votes.chain([enough]).collect()
    }

    /// Forgets the time of coincidence where the votes are not enough without a detector that just
    /// turned out to be silent.
    pub(super) fn drop_unmet(&mut self, detector: usize) {
        for zone in self.plan.detector_zones[detector].clone() {
            if self.zones[zone].met_since.is_some() && !self.tally(zone).met {
                self.cancel(zone, crate::output::Why::Votes);
            }
        }
    }
}
