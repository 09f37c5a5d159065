//! What has to be so before the software of a monitor is updated.

use lafet_client::MonitorStatus;
use lafet_client::update::Unready;
use lafet_proto::SubsystemId;
use lafet_proto::flags::flags_of;
use lafet_site::Phase;
use lafet_texts::{Shown, Text as _, hub as text};

use crate::hub::Hub;
use crate::monitor::station::Station;
use crate::sync::lock;
use crate::text::Both;

/// The flags of what a monitor does by itself.
const PROGRAMS: [(SubsystemId, &str); 4] = [
    (SubsystemId::CONTROL, "Quench"),
    (SubsystemId::CONTROL, "Trajectory"),
    (SubsystemId::DETECTOR, "Searching"),
    (SubsystemId::DETECTOR, "Justifying"),
];

/// What a monitor lacks, by the state that it has just reported. The lockout is not looked at: it comes afterwards.
pub fn missing(hub: &Hub, station: &Station, status: &MonitorStatus) -> Vec<Both> {
    let mut all = at_rest(status);
    let is_set = |(id, flag): (SubsystemId, &str)| {
        let info = flags_of(id).by_name(flag);
        let value = status.flags(id).zip(info).map(|(bits, info)| info.value(bits));
        value.is_some_and(|value| value != 0)
    };
    let accepted = lock(&station.programs).current().is_some();
    if accepted || PROGRAMS.into_iter().any(is_set) {
        all.push(text::UpdatesProgramRuns.words());
    }
    if lock(&station.tuning).is_some() {
        all.push(text::UpdatesTuningRuns.words());
    }
    if is_set((SubsystemId::DETECTOR, "Found")) {
        all.push(text::UpdatesFireFound.words());
    }
    all.extend(of_zones(hub, station.id()));
    all
}

/// What keeps a monitor from being at rest, in standby and closed.
pub fn at_rest(status: &MonitorStatus) -> Vec<Both> {
    let seen = Unready::seen(status).into_iter().filter_map(|it| {
        Some(match it {
            Unready::NotLockedOut => return None,
            Unready::NotStowed => text::UpdatesNotStowed.words(),
            Unready::ValveOpen(valve) => text::UpdatesValveOpen { valve: Shown(valve) }.words(),
            Unready::Moves(drive) => text::UpdatesDriveMoves { drive: Shown(drive) }.words(),
            Unready::BadSupply => text::UpdatesBadSupply.words(),
            // Also what a later version of the client may tell apart.
            other => other.words(),
        })
    });
    let silent = status.general.is_none().then(|| text::UpdatesGeneralSilent.words());
    silent.into_iter().chain(seen).collect()
}

/// Why the zones of a monitor cannot be without it.
fn of_zones(hub: &Hub, monitor: &str) -> Vec<Both> {
    let mut all = Vec::new();
    for served in hub.served_by(monitor) {
        let zone = &served.zone;
        if served.phase != Phase::Quiet {
            all.push(text::UpdatesZoneNotQuiet { zone }.words());
        }
        for other in &served.others {
            let station = hub.station(other).ok().filter(|it| it.health() == "up");
            let locked = |it: &Station| it.status().is_set(SubsystemId::GENERAL, "LockedOut");
            match station {
                None => all.push(text::UpdatesOtherSilent { other, zone }.words()),
                Some(station) if locked(&station) => {
                    all.push(text::UpdatesOtherLocked { other, zone }.words());
                }
                Some(_) => {}
            }
        }
    }
    all
}

/// The zone of a monitor that is not quiet, if one is not.
pub fn alarmed(hub: &Hub, monitor: &str) -> Option<String> {
    hub.served_by(monitor).into_iter().find(|it| it.phase != Phase::Quiet).map(|it| it.zone)
}

/// Sentences one behind the other.
pub fn joined(all: &[Both]) -> Both {
    Both::each(|lang| all.iter().map(|it| it.of(lang)).collect::<Vec<_>>().join(" "))
}
