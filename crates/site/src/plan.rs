//! The configuration with its names resolved: the machine works with indexes.

use crate::config::{Config, ContactKind, Zone};

/// The configuration, and who belongs to whom.
#[derive(Debug)]
pub(crate) struct Plan {
    pub config: Config,
    pub zone_detectors: Vec<Vec<usize>>,
    pub zone_monitors: Vec<Vec<usize>>,
    pub zone_valve: Vec<Option<usize>>,
    pub zone_outlet: Vec<Option<usize>>,
    pub monitor_zones: Vec<Vec<usize>>,
    pub detector_zones: Vec<Vec<usize>>,
    pub contact_zones: Vec<Vec<usize>>,
    pub output_zone: Vec<Option<usize>>,
    pub pump_pressure: Vec<Option<usize>>,
    /// Inputs, outputs, further paths, pumps: the ids that a fault of a path may name.
    pub paths: Vec<String>,
}

/// Position of an id.
fn find<'a>(mut ids: impl Iterator<Item = &'a String>, id: &str) -> Option<usize> {
    ids.position(|it| it == id)
}

impl Plan {
    pub fn new(config: Config) -> Self {
        let zone = |id: &String| find(config.zones.iter().map(|it| &it.id), id);
        let output = |id: &String| find(config.outputs.iter().map(|it| &it.id), id);
        let monitor = |id: &String| find(config.monitors.iter(), id);
        let contact = |id: &String| find(config.contacts.iter().map(|it| &it.id), id);
        let detector_zones: Vec<Vec<usize>> = config
            .detectors
            .iter()
            .map(|detector| detector.zones.iter().filter_map(zone).collect())
            .collect();
        let zone_monitors: Vec<Vec<usize>> = config
            .zones
            .iter()
            .map(|zone| zone.monitors.iter().filter_map(monitor).collect())
            .collect();
        let all: Vec<usize> = (0..config.zones.len()).collect();
        let contact_zones = config.contacts.iter().map(|contact| match contact.zones.as_slice() {
            [] => all.clone(),
            named => named.iter().filter_map(zone).collect(),
        });
        let paths = config.contacts.iter().map(|it| &it.id);
        let paths = paths.chain(config.outputs.iter().map(|it| &it.id)).chain(&config.paths);
        let paths = paths.chain(config.pumps.iter().map(|it| &it.id));
        Self {
            zone_detectors: inverse(&detector_zones, config.zones.len()),
            monitor_zones: inverse(&zone_monitors, config.monitors.len()),
            zone_valve: config.zones.iter().map(|it| it.valve.as_ref().and_then(output)).collect(),
            zone_outlet: config
                .zones
                .iter()
                .map(|it| it.test_outlet.as_ref().and_then(output))
                .collect(),
            contact_zones: contact_zones.collect(),
            output_zone: config.outputs.iter().map(|it| it.zone.as_ref().and_then(zone)).collect(),
            pump_pressure: config
                .pumps
                .iter()
                .map(|it| it.pressure.as_ref().and_then(contact))
                .collect(),
            paths: paths.cloned().collect(),
            detector_zones,
            zone_monitors,
            config,
        }
    }

    pub fn zone(&self, id: &str) -> Option<usize> {
        find(self.config.zones.iter().map(|it| &it.id), id)
    }

    pub fn detector(&self, id: &str) -> Option<usize> {
        find(self.config.detectors.iter().map(|it| &it.id), id)
    }

    pub fn monitor(&self, id: &str) -> Option<usize> {
        find(self.config.monitors.iter(), id)
    }

    pub fn contact(&self, id: &str) -> Option<usize> {
        find(self.config.contacts.iter().map(|it| &it.id), id)
    }

    pub fn output(&self, id: &str) -> Option<usize> {
        find(self.config.outputs.iter().map(|it| &it.id), id)
    }

    pub fn pump(&self, id: &str) -> Option<usize> {
        find(self.config.pumps.iter().map(|it| &it.id), id)
    }

    pub fn path(&self, id: &str) -> Option<usize> {
        find(self.paths.iter(), id)
    }

    pub fn zones(&self) -> impl Iterator<Item = (usize, &Zone)> {
        self.config.zones.iter().enumerate()
    }

    /// The contacts of a kind that are for a zone.
    pub fn contacts_of(&self, zone: usize, kind: ContactKind) -> impl Iterator<Item = usize> {
        self.contacts(kind).filter(move |index| self.contact_zones[*index].contains(&zone))
    }

    /// The contacts of a kind.
    pub fn contacts(&self, kind: ContactKind) -> impl Iterator<Item = usize> {
        let contacts = self.config.contacts.iter().enumerate();
        contacts.filter(move |(_, it)| it.kind == kind).map(|(index, _)| index)
    }
}

/// Who names whom, the other way round.
fn inverse(lists: &[Vec<usize>], count: usize) -> Vec<Vec<usize>> {
    let mut inverse = vec![Vec::new(); count];
    for (from, list) in lists.iter().enumerate() {
        for to in list {
            inverse[*to].push(from);
        }
    }
    inverse
}
