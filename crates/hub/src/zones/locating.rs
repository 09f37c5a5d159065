//! Fires are located on the thread of the plans, without the lock of the machine.
//!
//! ```text
//!  a detector reports ─▶ counted ─▶ what is shown when its turn comes ─▶ places ─▶ still shown? ─▶ the plan
//! ```
//!
//! One search of a zone is under way at a time: what is reported meanwhile is looked at by the next one. A report
//! of which water may follow waits for the search that has it, as it does for the plan. Fewer than two bearings
//! give no place and need no search, so that a fire which is not seen any more is gone at once.

use lafet_site::config::Zone;

use super::fires::{FirePlace, Sights};
use super::planning::LOST;
use super::{Machine, Zones};
use crate::control::authority::Now;
use crate::hub::Hub;
use crate::sync::lock;

/// How far the reports of the detectors of a zone were looked at.
#[derive(Debug, Default)]
pub struct Locating {
    /// Reports so far, and those that its fires follow from.
    reported: u64,
    located: u64,
    /// Since when a search is under way, and the number of the latest one.
    since: Option<Now>,
    number: u64,
}

/// A search whose turn has come.
#[derive(Debug)]
pub struct Search {
    number: u64,
    /// The reports that it has.
    reported: u64,
    sights: Sights,
}

/// What a search has found.
#[derive(Debug)]
pub struct Located {
    search: Search,
    places: Vec<FirePlace>,
}

impl Locating {
    /// The latest report.
    pub(super) const fn reported(&self) -> u64 {
        self.reported
    }

    /// Whether the fires follow from this report.
    pub(super) const fn has(&self, report: u64) -> bool {
        self.located >= report
    }

    /// A search that does not end is not waited for any more.
    pub(super) fn end_lost(&mut self, now: Now) {
        if self.since.is_some_and(|at| now.saturating_sub(at) >= LOST) {
            (self.since, self.located) = (None, self.reported);
        }
    }

    fn is_latest(&self, number: u64) -> bool {
        self.since.is_some() && self.number == number
    }
}

impl Search {
    /// Looks for the fires.
    pub(super) fn run(self) -> Located {
        Located { places: self.sights.places(), search: self }
    }
}

impl Hub {
    /// Has the fires of a zone located, and then planned for.
    pub(super) fn locate_fires(&self, zones: &Zones, machine: &mut Machine, zone: &Zone) {
        let sights = Sights::now(&zones.config, &zone.id, &machine.reported, self.now());
        let locating = machine.locating.entry(zone.id.clone()).or_default();
        locating.reported += 1;
        if sights.may_cross() {
            if locating.since.is_none() {
                self.search(locating, zone);
            }
            return;
        }
        // A search that is under way has what is not seen any more.
        (locating.since, locating.located) = (None, locating.reported);
        self.place_fires(zones, machine, zone, Vec::new());
    }

    fn search(&self, locating: &mut Locating, zone: &Zone) {
        locating.number += 1;
        locating.since = Some(self.now());
        let (hub, number, zone) = (self.clone(), locating.number, zone.clone());
        tokio::task::spawn_blocking(move || {
            let Some(zones) = hub.zones() else { return };
            let located = {
                let _one = lock(&zones.planning);
                let search = hub.next_search(zones, &zones.machine(), &zone, number);
                search.map(Search::run)
            };
            if let Some(located) = located {
                hub.take_located(zones, &mut zones.machine(), &zone, located);
            }
        });
    }

    /// The search of a zone that is under way.
    #[cfg(test)]
    pub(super) fn latest_search(
        &self,
        zones: &Zones,
        machine: &Machine,
        zone: &Zone,
    ) -> Option<Search> {
        let number = machine.locating.get(&zone.id)?.number;
        self.next_search(zones, machine, zone, number)
    }

    /// What the detectors of a zone show now, for the search of this number; none unless it is the latest.
    fn next_search(
        &self,
        zones: &Zones,
        machine: &Machine,
        zone: &Zone,
        number: u64,
    ) -> Option<Search> {
        let locating = machine.locating.get(&zone.id).filter(|it| it.is_latest(number))?;
        let sights = Sights::now(&zones.config, &zone.id, &machine.reported, self.now());
        Some(Search { number, reported: locating.reported, sights })
    }

    /// Takes what the latest search has found, as far as it is shown still.
    pub(super) fn take_located(
        &self,
        zones: &Zones,
        machine: &mut Machine,
        zone: &Zone,
        located: Located,
    ) {
        let Located { search, mut places } = located;
        let sights = Sights::now(&zones.config, &zone.id, &machine.reported, self.now());
        let locating = machine.locating.get_mut(&zone.id);
        let Some(locating) = locating.filter(|it| it.is_latest(search.number)) else { return };
        locating.since = None;
        let found = places.len();
        if sights.are_those_of(&search.sights) {
            // Detectors repeat what they see.
            locating.located = locating.reported;
        } else {
            places.retain(|place| sights.still_show(place, &search.sights));
            // Who waits for a place that was dropped waits for the next search.
            if places.len() == found {
                locating.located = search.reported;
            }
            self.search(locating, zone);
        }
        self.place_fires(zones, machine, zone, places);
        self.release_held(zones, machine);
    }

    fn place_fires(
        &self,
        zones: &Zones,
        machine: &mut Machine,
        zone: &Zone,
        places: Vec<FirePlace>,
    ) {
        let known = machine.fires.entry(zone.id.clone()).or_default();
        if places != *known {
            *known = places;
            machine.news = true;
        }
        self.plan_fires(zones, machine, zone);
    }
}

#[cfg(test)]
#[path = "locating_tests.rs"]
mod tests;
