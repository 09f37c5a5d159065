//! What the hub looks after on its disk: room, certificates. Each look is made where waiting for a disk holds
//! nothing up, and is remembered.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use tokio::time::{MissedTickBehavior, interval};

use super::Hub;
use crate::monitor::status::Status;
use crate::server::tls::{self, Reloading};
use crate::store::{self, reserve::RESERVE_BYTES};

/// Time between two looks.
const LOOK_EACH: Duration = Duration::from_secs(10);
/// Less free room than this, bytes, is too little on any disk …
const FREE_LEAST: u64 = 500_000_000;
/// … and less than this part of it, unless that is more than anything here needs, bytes.
const FREE_PART: u64 = 20;
const FREE_ENOUGH: u64 = 5_000_000_000;
/// A certificate is to be replaced so long before it ends, ms.
const RENEW_MS: u64 = 30 * 24 * 3_600_000;

/// What was seen at the last look.
#[derive(Debug, Default)]
pub(super) struct Upkeep {
    disk: AtomicBool,
    certificate: AtomicBool,
}

impl Hub {
    /// The disk of the state is almost full.
    pub fn lacks_room(&self) -> bool {
        self.0.upkeep.disk.load(Ordering::Relaxed)
    }

    /// The certificate ends soon, or has ended.
    pub fn certificate_ends(&self) -> bool {
        self.0.upkeep.certificate.load(Ordering::Relaxed)
    }

    /// Whether it is no time to end the hub for something that can wait: water flows or may flow, or there is a
    /// fire.
    pub fn is_busy(&self) -> bool {
        let fire = self.alarms().fire();
        let water = |status: &Status| status.at_ms.is_some() && status.flows();
        fire.active || fire.waiting || self.stations().iter().any(|it| water(&it.status()))
    }

    /// Looks until the hub ends.
    pub(crate) async fn look_after(self, certificates: Option<std::sync::Arc<Reloading>>) {
        let mut looks = interval(LOOK_EACH);
        looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut shutdown = self.shutdown();
        loop {
            tokio::select! {
                _ = looks.tick() => {}
                () = shutdown.requested() => return,
            }
            let (own, certificates) = (self.clone(), certificates.clone());
            // A disk that does not answer holds up the next look alone.
            _ = tokio::task::spawn_blocking(move || own.look(certificates.as_deref())).await;
        }
    }

    fn look(&self, certificates: Option<&Reloading>) {
        let upkeep = &self.0.upkeep;
        let room = self.config().data.as_deref().and_then(room);
        upkeep.disk.store(room.is_some_and(is_little), Ordering::Relaxed);
        let fits = room.is_none_or(|(free, _)| free >= 2 * RESERVE_BYTES);
        let folder = self.config().data.as_deref().filter(|_| fits);
        if let Some(Err(error)) = folder.map(store::reserve::keep) {
            tracing::warn!(%error, "no room is reserved for the next start");
        }
        let Some(certificates) = certificates else { return };
        if let Some(what) = certificates.look() {
            self.event(None, &what);
        }
        let soon_ms = self.clock().now_ms() + RENEW_MS;
        let ends = tls::ends_ms(certificates.config()).is_some_and(|ends_ms| ends_ms < soon_ms);
        upkeep.certificate.store(ends, Ordering::Relaxed);
    }
}

/// Whether free and total bytes of a disk are too little.
const fn is_little((free, total): (u64, u64)) -> bool {
    free < FREE_LEAST || (free < total / FREE_PART && free < FREE_ENOUGH)
}

/// Memory of a process (`self`: this one), bytes, where Linux reports it.
pub fn resident(process: &str) -> Option<u64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

/// Free and total bytes of the disk that has a folder.
#[cfg(unix)]
pub fn room(folder: &Path) -> Option<(u64, u64)> {
    let disk = rustix::fs::statvfs(folder).ok()?;
    Some((disk.f_bavail.saturating_mul(disk.f_frsize), disk.f_blocks.saturating_mul(disk.f_frsize)))
}

/// Other systems are not asked.
#[cfg(not(unix))]
pub fn room(_: &Path) -> Option<(u64, u64)> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_that_is_almost_full() {
        const GB: u64 = 1_000_000_000;
        for (free, total, little) in [
            (GB / 4, 8 * GB, true),
            (GB * 6 / 10, 8 * GB, false),
            (GB * 6 / 10, 16 * GB, true),
            (6 * GB, 2000 * GB, false),
            (4 * GB, 2000 * GB, true),
        ] {
            assert_eq!(is_little((free, total)), little, "{free} of {total}");
        }
    }

    #[test]
    fn water_keeps_the_hub_busy() {
        use crate::monitor::status::Subsystem;
        use lafet_proto::SubsystemId;
        use std::sync::Arc;
        let (hub, station) = Hub::of_one(None);
        assert!(!hub.is_busy(), "a monitor that was never heard");
        let set = |flag: &str| {
            let info = lafet_proto::flags::flags_of(SubsystemId::VALVE1).by_name(flag).unwrap();
            let mut valve = Subsystem::default();
            valve.set_bits(SubsystemId::VALVE1, info.mask());
            let subsystems = [("Valve1", Arc::new(valve))].into();
            station.set_status(&hub, Status { at_ms: Some(1), subsystems, ..Status::default() });
            hub.is_busy()
        };
        assert_eq!([set("Closed"), set("Opening")], [false, true]);
    }

    #[test]
    fn what_was_seen_is_an_alarm() {
        let (hub, _) = Hub::of_one(None);
        hub.look_at_itself();
        let alarms = |hub: &Hub| {
            let alarms = hub.alarms();
            ["hub/Disk", "hub/Certificate"].map(|id| alarms.get(id).is_some_and(|it| it.active))
        };
        assert_eq!(alarms(&hub), [false; 2]);
        hub.0.upkeep.disk.store(true, Ordering::Relaxed);
        hub.look_at_itself();
        assert_eq!(alarms(&hub), [true, false]);
        hub.0.upkeep.certificate.store(true, Ordering::Relaxed);
        hub.look_at_itself();
        assert_eq!(alarms(&hub), [true; 2]);
    }
}
