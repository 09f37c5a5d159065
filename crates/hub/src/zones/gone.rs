//! Water whose zone is gone: it ran, or its end was not confirmed, when the hub ended, and the file has no zone with
//! its monitor any more. The machine ends it all the same, as long as the hub knows the monitor.

use lafet_site::{Persisted, VERSION};
use lafet_texts::{Text as _, hub as text};

use super::stored::Stored;
use crate::config::{Config, ZonesConfig};
use crate::store::StoreError;
use crate::text::Both;

/// The zones of the file and what is stored of them; `None`: there are none, nor any water of before.
pub fn open(
    config: &Config,
) -> Result<Option<(ZonesConfig, Stored, Option<Persisted>)>, StoreError> {
    if let Some(zones) = config.zones.clone() {
        let (stored, persisted) = Stored::open(config.data.as_deref())?;
        return Ok(Some((zones, stored, persisted)));
    }
    // A hub without zones starts with whatever is stored.
    let Some(folder) = &config.data else { return Ok(None) };
    let opened = Stored::open(Some(folder));
    let opened = opened.inspect_err(|error| tracing::warn!(%error, "the state of zones of before"));
    let Ok((stored, Some(persisted))) = opened else { return Ok(None) };
    let runs = persisted.monitors.values().any(|it| it.water_left_ms.is_some());
    if !runs || persisted.version != VERSION {
        return Ok(None);
    }
    Ok(Some((ZonesConfig::default(), stored, Some(persisted))))
}

/// Has the machine watch the monitors of such water, without a zone; what people have to know of it.
pub fn watch(zones: &mut ZonesConfig, config: &Config, stored: &Persisted) -> Vec<Both> {
    let mut said = Vec::new();
    for (monitor, stored) in &stored.monitors {
        let Some(left_ms) = stored.water_left_ms else { continue };
        if zones.site.monitors.contains(monitor) {
            continue;
        }
        if config.monitors.iter().any(|it| it.id == *monitor) {
            zones.site.monitors.push(monitor.clone());
            let seconds = left_ms / 1000;
            said.push(text::ZoneWaterGone { monitor, seconds }.words());
        } else {
            said.push(text::ZoneWaterLost { monitor }.words());
        }
    }
    zones.site.monitors.sort();
    said
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use lafet_site::{Event, MonitorReport, Order, StoredMonitor, Valve};
    use serde_json::Value;

    use super::super::hall::configured;
    use super::*;
    use crate::Clock;
    use crate::hub::Hub;

    const MONITORS: &str = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://127.0.0.1:1?addr=1\"\n\
                            [[monitor]]\nid = \"M2\"\nurl = \"tcp://127.0.0.1:1?addr=2\"\n";
    const STORE: &str = "[[detector]]\nid = \"flame\"\nkind = \"flame\"\nzones = [\"store\"]\n\
                         [[zone]]\nid = \"store\"\nvotes = \"1oo1\"\none_detector_releases = true\n\
                         water_max_s = 60\nmonitors = [\"M2\"]\n\
                         [[aim]]\nzone = \"store\"\nmonitor = \"M2\"\nhorizontal = 600\n\
                         vertical = 300\nnozzle = 60\n";

    fn with(folder: &Path, text: &str) -> Config {
        Config { data: Some(folder.to_owned()), ..configured(text) }
    }

    /// M1 and M9 gave water to a zone that is gone; M1 for so long yet.
    async fn water(folder: &Path, left_ms: u64) {
        let water = |left_ms| StoredMonitor {
            water_left_ms: Some(left_ms),
            zone: Some("hall".to_owned()),
            ..StoredMonitor::default()
        };
        let monitors = [("M1".to_owned(), water(left_ms)), ("M9".to_owned(), water(0))].into();
        let persisted = Persisted { version: VERSION, monitors, ..Persisted::default() };
        let (stored, _) = Stored::open(Some(folder)).unwrap();
        stored.write(&persisted).await.unwrap();
    }

    #[tokio::test]
    async fn water_whose_zone_is_gone_is_ended_and_said() {
        for (text, left_ms) in [(STORE, 0), ("", 0), ("", 7000)] {
            let name = format!("lafet-gone-{}-{}-{left_ms}", std::process::id(), text.len());
            let folder = std::env::temp_dir().join(name);
            _ = std::fs::remove_dir_all(&folder);
            std::fs::create_dir_all(&folder).unwrap();
            let text = format!("{MONITORS}{text}");
            assert_eq!(open(&with(&folder, MONITORS)).unwrap().map(|it| it.0), None);
            water(&folder, left_ms).await;
            let hub = Hub::new(with(&folder, &text), Clock::System, Value::Null).unwrap();
            let zones = hub.zones().expect("there is water to be ended");
            let mut machine = zones.machine();
            let said = machine.first.as_ref().map(|it| it.1.clone()).unwrap_or_default();
            let named = |it: &Both, name: &str| it.en.contains(name) && it.ru.contains(name);
            assert!(said.len() == 2 && named(&said[0], "M1") && named(&said[1], "M9"), "{said:?}");
            let (reachable, valve) = (true, Valve::Open);
            let report = MonitorReport { reachable, valve, ..MonitorReport::default() };
            let event = Event::Monitor { monitor: "M1".into(), report };
            let close = Order::Close { monitor: "M1".into() };
            let closes = |orders: &[lafet_site::Command]| orders.iter().any(|it| it.order == close);
            let first = machine.site.handle(1, &event).commands;
            assert_eq!(closes(&first), left_ms == 0, "{first:?}");
            assert!(closes(&machine.site.step(left_ms + 1500).commands), "{left_ms}");
            assert!(closes(&machine.site.step(left_ms + 3000).commands), "until it is closed");
            drop(machine);
            drop(hub);
            _ = std::fs::remove_dir_all(&folder);
        }
    }
}
