//! What a configuration may say. Each problem says where, what and what to do.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::RangeInclusive;

use lafet_texts::{Text, Words, site as text};
use serde::{Deserialize, Serialize};

use super::{Config, ContactKind, OutputKind, Reduced, Zone};

/// Most things of one sort.
const MOST: usize = 1024;
/// Longest id, in characters.
const ID_MAX: usize = 64;

/// What is wrong with a configuration.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Problem {
    /// Where: `zone hall`.
    pub place: String,
    /// What is wrong.
    pub what: Words,
    /// What to do.
    pub remedy: Words,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} {}", self.place, self.what.en, self.remedy.en)
    }
}

impl Config {
    /// All problems; none if the site can run by it.
    pub fn check(&self) -> Vec<Problem> {
        let mut check = Check { config: self, problems: Vec::new() };
        check.ids();
        check.range("site", "run_on_s", self.run_on_s, 0..=3600);
        check.detectors();
        for zone in &self.zones {
            check.zone(zone);
        }
        check.contacts();
        check.outputs();
        check.pumps();
        check.problems
    }
}

struct Check<'a> {
    config: &'a Config,
    problems: Vec<Problem>,
}

impl Check<'_> {
    fn say(&mut self, place: impl Into<String>, what: &dyn Text, remedy: &dyn Text) {
        let (what, remedy) = (what.words(), remedy.words());
        self.problems.push(Problem { place: place.into(), what, remedy });
    }

    fn range(&mut self, place: &str, key: &str, value: u32, range: RangeInclusive<u32>) {
        if !range.contains(&value) {
            let (least, most) = (range.start(), range.end());
            self.say(
                place,
                &text::OutOfRange { key, value },
                &text::OutOfRangeRemedy { least, most },
            );
        }
    }

    /// A name that has to be one of a list.
    fn known<'i>(
        &mut self,
        place: &str,
        key: &str,
        name: &str,
        mut list: impl Iterator<Item = &'i str>,
    ) {
        if !list.any(|known| known == name) {
            self.say(place, &text::NotConfigured { key, name }, &text::NotConfiguredRemedy);
        }
    }

    /// Names of a list that has to be of known and different names.
    fn list<'i>(
        &mut self,
        place: &str,
        key: &str,
        names: &[String],
        list: impl Iterator<Item = &'i str> + Clone,
    ) {
        let mut seen = BTreeSet::new();
        for name in names {
            self.known(place, key, name, list.clone());
            if !seen.insert(name) {
                self.say(place, &text::NamedTwice { key, name }, &text::NamedTwiceRemedy);
            }
        }
    }

    fn ids(&mut self) {
        let config = self.config;
        let sorts: [(&str, Vec<&str>); 7] = [
            ("monitors", config.monitors.iter().map(String::as_str).collect()),
            ("detector", config.detectors.iter().map(|it| it.id.as_str()).collect()),
            ("zone", config.zones.iter().map(|it| it.id.as_str()).collect()),
            ("input", config.contacts.iter().map(|it| it.id.as_str()).collect()),
            ("output", config.outputs.iter().map(|it| it.id.as_str()).collect()),
            ("pump", config.pumps.iter().map(|it| it.id.as_str()).collect()),
            ("paths", config.paths.iter().map(String::as_str).collect()),
        ];
        // A fault of a path is reported by the id of an input, an output, a pump or a
        // further path.
        let mut paths = BTreeMap::new();
        for (sort, ids) in &sorts {
            let mut seen = BTreeSet::new();
            let path = matches!(*sort, "input" | "output" | "pump" | "paths");
            for id in ids {
                // Names of dots alone are taken out of an address: an abort would be lost.
                let dots = id.chars().all(|c| c == '.');
                if dots || id.chars().count() > ID_MAX {
                    self.say(*sort, &text::IdLength { id }, &text::IdLengthRemedy { most: ID_MAX });
                }
                let twice = !seen.insert(*id) || (path && paths.insert(*id, *sort).is_some());
                if twice {
                    self.say(format!("{sort} {id}"), &text::IdTwice, &text::IdTwiceRemedy);
                }
            }
            if ids.len() > MOST {
                self.say(
                    *sort,
                    &text::TooMany { count: ids.len() },
                    &text::TooManyRemedy { most: MOST },
                );
            }
        }
    }

    fn detectors(&mut self) {
        let config = self.config;
        for detector in &config.detectors {
            let place = format!("detector {}", detector.id);
            self.range(&place, "silent_after_s", detector.silent_after_s, 1..=3600);
            self.range(&place, "self_test_max_s", detector.self_test_max_s, 1..=3600);
            self.list(
                &place,
                "zones",
                &detector.zones,
                config.zones.iter().map(|it| it.id.as_str()),
            );
            if detector.zones.is_empty() {
                self.say(place, &text::DetectorWithoutZone, &text::DetectorWithoutZoneRemedy);
            }
        }
    }

    fn zone(&mut self, zone: &Zone) {
        let place = format!("zone {}", zone.id);
        self.range(&place, "coincidence_s", zone.coincidence_s, 0..=60);
        self.range(&place, "delay_s", zone.delay_s, 0..=60);
        self.range(&place, "hold_max_s", zone.hold_max_s, 1..=600);
        self.range(&place, "water_max_s", zone.water_max_s, 1..=7200);
        self.range(&place, "act_within_s", zone.act_within_s, 1..=300);
        if let Some(value) = zone.quiet_ends_s {
            self.range(&place, "quiet_ends_s", value, 1..=3600);
        }
        if let Some(value) = zone.return_after_s {
            self.range(&place, "return_after_s", value, 1..=604_800);
        }
        if zone.mode.is_test() {
            self.say(place.clone(), &text::StartsInTest, &text::StartsInTestRemedy);
        }
        self.votes(&place, zone);
        self.reduced(&place, zone);
        self.serving(&place, zone);
    }

    fn votes(&mut self, place: &str, zone: &Zone) {
        let detectors = self.config.detectors.iter().filter(|it| it.zones.contains(&zone.id));
        let kinds: BTreeSet<_> = detectors.clone().map(|it| it.kind).collect();
        let count = detectors.count();
        let votes = zone.votes;
        if votes.need == 0 || votes.need > votes.of {
            self.say(
                place,
                &text::VotesImpossible { votes: format_args!("{votes}") },
                &text::VotesImpossibleRemedy,
            );
        }
        if usize::from(votes.of) != count {
            self.say(
                place,
                &text::VotesNotOfDetectors { votes: format_args!("{votes}"), count },
                &text::VotesNotOfDetectorsRemedy { count },
            );
        }
        if votes.need == 1 && !zone.one_detector_releases {
            self.say(place, &text::OneVoteReleases, &text::OneVoteReleasesRemedy);
        }
        let needed = usize::from(zone.kinds);
        if zone.kinds == 0 || zone.kinds > votes.need || needed > kinds.len() {
            self.say(
                place,
                &text::KindsImpossible {
                    needed,
                    votes: format_args!("{votes}"),
                    kinds: kinds.len(),
                },
                &text::KindsImpossibleRemedy,
            );
        }
    }

    fn reduced(&mut self, place: &str, zone: &Zone) {
        for (index, reduced) in zone.when_failed.iter().enumerate() {
            let Reduced::Votes(votes) = *reduced else { continue };
            let failed = index + 1;
            let left = usize::from(zone.votes.of).saturating_sub(failed);
            let wrong = votes.need == 0 || votes.need > votes.of || usize::from(votes.of) != left;
            if wrong || votes.need < zone.kinds {
                self.say(
                    place,
                    &text::ReducedNotFitting {
                        votes: format_args!("{votes}"),
                        failed,
                        of: zone.votes.of,
                    },
                    &text::ReducedNotFittingRemedy { left, kinds: zone.kinds.max(1) },
                );
            } else if votes.need == 1 && !zone.one_detector_releases {
                self.say(place, &text::ReducedToOne { failed }, &text::ReducedToOneRemedy);
            }
        }
    }

    fn serving(&mut self, place: &str, zone: &Zone) {
        let config = self.config;
        self.list(place, "monitors", &zone.monitors, config.monitors.iter().map(String::as_str));
        if zone.monitors.is_empty() {
            self.say(place, &text::NoMonitor, &text::NoMonitorRemedy);
        }
        if let Some(jets) = zone.jets
            && (jets == 0 || usize::from(jets) > zone.monitors.len())
        {
            self.say(
                place,
                &text::JetsImpossible { jets, monitors: zone.monitors.len() },
                &text::JetsImpossibleRemedy,
            );
        }
        let valves = || {
            let valves = config.outputs.iter().filter(|it| it.kind == OutputKind::Valve);
            valves.map(|it| it.id.as_str())
        };
        for (key, output) in [("valve", &zone.valve), ("test_outlet", &zone.test_outlet)] {
            if let Some(output) = output {
                self.known(place, key, output, valves());
            }
        }
        let users = |output: &str| {
            let named = config.zones.iter().flat_map(|it| [&it.valve, &it.test_outlet]);
            named.flatten().filter(|it| *it == output).count()
        };
        for output in [&zone.valve, &zone.test_outlet].into_iter().flatten() {
            if users(output) > 1 {
                self.say(place, &text::ValveUsedTwice { output }, &text::ValveUsedTwiceRemedy);
            }
        }
    }

    fn contacts(&mut self) {
        let config = self.config;
        for contact in &config.contacts {
            let place = format!("input {}", contact.id);
            self.range(&place, "debounce_ms", contact.debounce_ms, 0..=1000);
            self.list(
                &place,
                "zones",
                &contact.zones,
                config.zones.iter().map(|it| it.id.as_str()),
            );
            let whole = matches!(contact.kind, ContactKind::Lockout | ContactKind::Pressure);
            if whole && !contact.zones.is_empty() {
                self.say(place.clone(), &text::ContactOfWholeSite, &text::ContactOfWholeSiteRemedy);
            }
            if contact.kind == ContactKind::Release && contact.zones.is_empty() {
                self.say(place, &text::StationWithoutZones, &text::StationWithoutZonesRemedy);
            }
        }
    }

    fn outputs(&mut self) {
        let config = self.config;
        for output in &config.outputs {
            let place = format!("output {}", output.id);
            if let Some(zone) = &output.zone {
                self.known(&place, "zone", zone, config.zones.iter().map(|it| it.id.as_str()));
            }
            let named = config.zones.iter().flat_map(|it| [&it.valve, &it.test_outlet]);
            let used = named.flatten().any(|it| *it == output.id);
            if output.kind == OutputKind::Valve && !used {
                self.say(place, &text::ValveUnused, &text::ValveUnusedRemedy);
            }
        }
    }

    fn pumps(&mut self) {
        let config = self.config;
        for pump in &config.pumps {
            let place = format!("pump {}", pump.id);
            self.range(&place, "start_delay_s", pump.start_delay_s, 0..=120);
            self.range(&place, "start_timeout_s", pump.start_timeout_s, 1..=300);
            let gauges = config.contacts.iter().filter(|it| it.kind == ContactKind::Pressure);
            if let Some(pressure) = &pump.pressure {
                self.known(&place, "pressure", pressure, gauges.map(|it| it.id.as_str()));
            }
        }
        if !config.pumps.is_empty() && config.pumps.iter().all(|pump| pump.standby) {
            self.say("pump", &text::AllStandby, &text::AllStandbyRemedy);
        }
    }
}
