//! Who belongs to whom. It follows from the configuration, so it is computed once: what is looked at every 50 ms does
//! not compare each monitor with each zone.

use std::collections::{BTreeMap, btree_map};
use std::iter::Peekable;
use std::sync::Arc;

use lafet_site::Config;

use crate::monitor::station::Station;

/// Monitors by their positions in the configuration, and the zones that each serves.
#[derive(Debug)]
pub struct Index {
    positions: BTreeMap<String, usize>,
    zones_of: Vec<Vec<usize>>,
}

impl Index {
    /// Of the configuration.
    pub fn new(config: &Config) -> Self {
        let positions = config.monitors.iter().cloned().zip(0..).collect::<BTreeMap<_, usize>>();
        let mut zones_of = vec![Vec::new(); config.monitors.len()];
        for (zone, configured) in config.zones.iter().enumerate() {
            for monitor in configured.monitors.iter().filter_map(|id| positions.get(id)) {
                zones_of[*monitor].push(zone);
            }
        }
        Self { positions, zones_of }
    }

    /// The position of a monitor.
    pub fn monitor(&self, id: &str) -> Option<usize> {
        self.positions.get(id).copied()
    }

    /// The positions in the order of the ids, which is that of the lines.
    pub fn by_id(&self) -> impl Iterator<Item = usize> {
        self.positions.values().copied()
    }

    /// The zones that a monitor serves, in their order.
    pub fn zones_of(&self, monitor: usize) -> &[usize] {
        self.zones_of.get(monitor).map_or(&[], Vec::as_slice)
    }
}

/// Walks through the stations beside ids that ascend.
pub struct Beside<'a>(Peekable<btree_map::Iter<'a, String, Arc<Station>>>);

impl<'a> Beside<'a> {
    /// From the first one.
    pub fn new(stations: &'a BTreeMap<String, Arc<Station>>) -> Self {
        Self(stations.iter().peekable())
    }

    /// The station with this id, which is greater than the one before.
    pub fn of(&mut self, id: &str) -> Option<&'a Arc<Station>> {
        while self.0.next_if(|it| it.0.as_str() < id).is_some() {}
        self.0.next_if(|it| it.0 == id).map(|it| it.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::MonitorConfig;

    #[test]
    fn monitors_know_their_zones() {
        let config: Config = toml::from_str(
            "monitors = [\"M2\", \"M10\", \"M1\"]\n\
             [[zone]]\nid = \"a\"\nvotes = \"1oo1\"\nmonitors = [\"M1\", \"M2\"]\nwater_max_s = 60\n\
             [[zone]]\nid = \"b\"\nvotes = \"1oo1\"\nmonitors = [\"M1\"]\nwater_max_s = 60\n",
        )
        .unwrap();
        let index = Index::new(&config);
        assert_eq!(index.by_id().collect::<Vec<_>>(), [2, 1, 0]);
        assert_eq!((index.monitor("M10"), index.monitor("M3")), (Some(1), None));
        assert_eq!(
            [2, 1, 0, 7].map(|it| index.zones_of(it)),
            [&[0, 1][..], &[][..], &[0][..], &[][..]]
        );
    }

    #[test]
    fn stations_are_found_beside_ids() {
        let station = |id: &str| {
            let config = MonitorConfig {
                id: id.into(),
                name: crate::text::both(id, id),
                endpoint: "tcp://127.0.0.1:1?addr=1".parse().unwrap(),
                poll_ms: 200,
            };
            (id.to_owned(), Arc::new(Station::new(config, std::time::Duration::ZERO)))
        };
        let stations = ["M1", "M3", "M4"].map(station).into();
        let mut beside = Beside::new(&stations);
        let found = ["M0", "M1", "M2", "M4", "M5"].map(|id| beside.of(id).map(|it| it.id()));
        assert_eq!(found, [None, Some("M1"), None, Some("M4"), None]);
    }
}
