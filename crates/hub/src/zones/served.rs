//! The zones that a monitor serves, for what takes it out of service for a while.

use lafet_site::Phase;

use crate::hub::Hub;

/// A zone that a monitor serves.
#[derive(Debug)]
pub struct Served {
    /// Its id.
    pub zone: String,
    /// What it does.
    pub phase: Phase,
    /// The other monitors that serve it.
    pub others: Vec<String>,
}

impl Hub {
    /// The zones that a monitor serves; none without zones.
    pub(crate) fn served_by(&self, monitor: &str) -> Vec<Served> {
        let Some(zones) = self.zones() else { return Vec::new() };
        let Some(at) = zones.index.monitor(monitor) else { return Vec::new() };
        let state = zones.machine().site.state();
        let served = zones.index.zones_of(at).iter().filter_map(|zone| {
            let (configured, state) =
                (zones.config.site.zones.get(*zone)?, state.zones.get(*zone)?);
            let others = configured.monitors.iter().filter(|it| *it != monitor).cloned();
            let (zone, phase) = (configured.id.clone(), state.phase);
            Some(Served { zone, phase, others: others.collect() })
        });
        served.collect()
    }
}

#[cfg(test)]
mod tests {
    use lafet_site::Hand;

    use super::super::hall::hall;
    use super::*;
    use crate::hub::Caller;

    #[tokio::test]
    async fn a_monitor_knows_its_zone_and_who_else_serves_it() {
        let hub = hall();
        let of = |monitor| hub.served_by(monitor);
        let [served] = &of("M1")[..] else { panic!("one zone") };
        assert_eq!((served.zone.as_str(), &served.others[..]), ("hall", &["M2".to_owned()][..]));
        assert_eq!(served.phase, Phase::Quiet);
        assert!(of("M9").is_empty() && Hub::of_one(None).0.served_by("M1").is_empty());
        hub.order_zones(&Caller::hub(), Hand::Release { zone: "hall".into() }).unwrap();
        assert!(of("M2").iter().all(|it| matches!(it.phase, Phase::Released { .. })));
    }
}
