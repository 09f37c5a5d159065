//! What is seen while people try the test outlet of a zone. Nothing is ordered; what must not be ends the run.

use std::collections::{BTreeMap, BTreeSet};

use lafet_texts::{Text as _, acceptance as text};

use super::look::wet;
use super::{End, POLL_MS, Run, Step};
use crate::check;
use crate::facts::{Pump, Zones};
use crate::wire::{Person, Wire};

/// A zone whose test outlet people try.
#[derive(Debug, Default)]
pub(super) struct Trial {
    pub zone: String,
    /// Detectors that vote for it: their alarms are those of test sources.
    pub detectors: Vec<String>,
    /// Output of its valve, which stays closed.
    pub valve: Option<String>,
    /// Output of its test outlet.
    pub outlet: String,
    /// Its mode when it is not tried.
    pub mode: String,
    pub seen: Seen,
}

/// When something was first seen, ms since the start of the hub.
#[derive(Debug, Default)]
pub(super) struct Seen {
    /// Enough votes.
    pub pending: Option<u64>,
    pub released: Option<u64>,
    /// The outlet was ordered open, and is not reported otherwise.
    pub open: Option<u64>,
    /// Pumps: ordered on, reported running, with pressure.
    pub on: BTreeMap<String, u64>,
    pub runs: BTreeMap<String, u64>,
    pub pressure: BTreeMap<String, u64>,
    /// Pumps that were reported running without having been ordered.
    pub strange: BTreeSet<String>,
    pub failed: BTreeSet<String>,
    /// The zone valve was not closed.
    pub valve: bool,
}

impl Trial {
    fn see(&mut self, zones: &Zones) {
        let (seen, at) = (&mut self.seen, zones.state.at_ms);
        let phase = zones.zone(&self.zone).map_or("", |it| it.phase());
        match phase {
            "coincidence" | "countdown" | "held" => _ = seen.pending.get_or_insert(at),
            "released" => _ = seen.released.get_or_insert(at),
            // Votes that were withdrawn begin again.
            "quiet" | "alarm" if seen.released.is_none() => seen.pending = None,
            _ => {}
        }
        if let Some(outlet) = zones.output(&self.outlet)
            && outlet.on == Some(true)
            && outlet.reported != Some(false)
        {
            seen.open.get_or_insert(at);
        }
        let valve = self.valve.as_ref().and_then(|it| zones.output(it));
        seen.valve |= valve.is_some_and(|it| it.on == Some(true) || it.reported == Some(true));
        zones.state.pumps.iter().for_each(|it| seen.pump(it, at));
    }
}

impl Seen {
    fn pump(&mut self, pump: &Pump, at: u64) {
        let id = || pump.pump.clone();
        let (runs, pressure) = (pump.runs == Some(true), pump.pressure == Some(true));
        if pump.on == Some(true) {
            self.on.entry(id()).or_insert(at);
            if runs {
                self.runs.entry(id()).or_insert(at);
            }
            if pressure {
                self.pressure.entry(id()).or_insert(at);
            }
        } else if runs {
            // Pressure says nothing: a contact may be that of several pumps.
            self.strange.insert(id());
        }
        if pump.failed {
            self.failed.insert(id());
        }
    }
}

impl<W: Wire, P: Person> Run<'_, W, P> {
    /// Looks at the zone that is tried, and at all others. What must not be then ends the run.
    pub(super) async fn watch(&mut self) -> Step<Zones> {
        let (zones, monitors) = self.seen().await?;
        if zones.state.lockout {
            return Err(End::Unsafe(text::LockoutOn.words()));
        }
        let Some(trial) = &mut self.trial else { return Ok(zones) };
        trial.see(&zones);
        let zone = trial.zone.clone();
        if let Some(id) = wet(&monitors) {
            let words = text::ValveNotClosed { monitor: id }.words();
            self.tried(&check::NO_WATER, &zone, false, text::NoWaterLimit, words.clone());
            return Err(End::Unsafe(words));
        }
        let stranger = |it: &&&str| !trial.detectors.iter().any(|id| id == **it);
        if let Some(detector) = zones.alarms().iter().find(stranger) {
            return Err(End::Unsafe(text::StrangeAlarm { detector }.words()));
        }
        let all = zones.state.zones.iter().filter(|it| it.is_active());
        let mut wrong = all.filter(|it| match it.zone == zone {
            true => it.mode != "test_outlet",
            // It shares a detector with the one that is tried.
            false => !it.mode.starts_with("test_"),
        });
        match wrong.next() {
            Some(it) => Err(End::Unsafe(text::NotInTest { zone: &it.zone }.words())),
            None => Ok(zones),
        }
    }

    /// Looks until something of the zones is so, `ms` at most; how long it took.
    pub(super) async fn watched<T>(
        &mut self,
        ms: u64,
        mut so: impl FnMut(&Zones, &Seen) -> Option<T>,
    ) -> Step<Option<(T, u64)>> {
        let start = self.wire.now_ms();
        loop {
            let zones = self.watch().await?;
            let took = self.wire.now_ms().saturating_sub(start);
            let seen = self.trial.as_ref().map(|it| so(&zones, &it.seen));
            if let Some(it) = seen.flatten() {
                return Ok(Some((it, took)));
            }
            if took >= ms {
                return Ok(None);
            }
            self.pause(POLL_MS).await?;
        }
    }
}
