//! What is wrong with the zones, as alarms: troubles that no alarm of a monitor has, zones that release nothing.

use std::collections::BTreeSet;

use lafet_site::{Mode, Phase, State as Site, Trouble, ZoneState};
use lafet_texts::{Text as _, hub as text};

use super::alarm::Priority;
use super::catalogue::Texts;
use super::machine::{Alarms, Change, Condition};
use crate::text::Both;

/// Ids begin with it: `zones/heat/DetectorSilent`.
const PREFIX: &str = "zones/";

impl Alarms {
    /// The zones as they are; `None`: the hub has none.
    pub fn zones(&mut self, now_ms: u64, site: Option<&Site>) -> Vec<Change> {
        let mut changes = Vec::new();
        let mut ids = BTreeSet::new();
        for condition in site.map(conditions).unwrap_or_default() {
            let id = format!("{PREFIX}{}/{}", condition.subsystem, condition.flag);
            self.holds(now_ms, id.clone(), condition, &mut changes);
            ids.insert(id);
        }
        let known = self.list().into_iter().filter(|it| it.monitor.is_empty()).map(|it| &it.id);
        let gone: Vec<String> =
            known.filter(|id| id.starts_with(PREFIX) && !ids.contains(*id)).cloned().collect();
        gone.iter().for_each(|id| self.gone(now_ms, id, &mut changes));
        changes
    }
}

fn conditions(site: &Site) -> Vec<Condition> {
    let active = site.troubles.iter().filter(|it| it.active);
    let troubles = active.filter_map(|it| of_trouble(it.trouble, &it.subject));
    let zones = site.zones.iter().filter_map(|it| of_zone(it, site.lockout));
    troubles.chain(zones).collect()
}

fn condition(flag: &str, subject: &str, texts: Texts) -> Condition {
    let (subsystem, flag) = (subject.to_owned(), flag.to_owned());
    Condition { monitor: String::new(), subsystem, flag, texts }
}

/// A monitor that does not answer or has failed has alarms of its own.
fn of_trouble(trouble: Trouble, subject: &str) -> Option<Condition> {
    let (flag, texts) = match trouble {
        Trouble::DetectorFault => ("DetectorFault", detector(trouble, subject)),
        Trouble::DetectorSilent => ("DetectorSilent", detector(trouble, subject)),
        Trouble::DetectorDirty => ("DetectorDirty", detector(trouble, subject)),
        Trouble::DetectorStuck => ("DetectorStuck", detector(trouble, subject)),
        Trouble::MonitorIdle => ("MonitorIdle", idle(subject)),
        Trouble::NotClosed => ("NotClosed", not_closed(subject)),
        Trouble::NoMonitor => ("NoMonitor", no_monitor(subject)),
        Trouble::FewJets => ("FewJets", few_jets(subject)),
        Trouble::Path => ("PathFault", path(subject)),
        Trouble::ContactStuck => ("ContactStuck", contact(subject)),
        Trouble::MonitorUnreachable | Trouble::MonitorFailure => return None,
        Trouble::OutputOverdue => ("OutputOverdue", output(trouble, subject)),
        Trouble::PumpOverdue => ("PumpOverdue", output(trouble, subject)),
        Trouble::PumpFailed => ("PumpFailed", pump(trouble, subject)),
        Trouble::NoPressure => ("NoPressure", pump(trouble, "pumps")),
    };
    let subject = if subject.is_empty() { "pumps" } else { subject };
    Some(condition(flag, subject, texts))
}

fn of_zone(zone: &ZoneState, lockout: bool) -> Option<Condition> {
    if zone.ready || matches!(zone.phase, Phase::Released { .. }) {
        return None;
    }
    let by_people =
        lockout || zone.mode != Mode::Automatic || matches!(zone.phase, Phase::Ended(_));
    let (flag, texts) = match by_people || zone.switch_manual {
        true => ("ZoneDisabled", disabled(&zone.zone)),
        false => ("ZoneNotReady", not_ready(&zone.zone)),
    };
    Some(condition(flag, &zone.zone, texts))
}

fn what(subject: &str, text: &Both) -> Both {
    text::AlarmTrouble { subject, trouble: text }.words()
}

fn detector(trouble: Trouble, subject: &str) -> Texts {
    Texts {
        priority: Priority::Medium,
        what: what(subject, &trouble.text()),
        cause: text::AlarmDetectorCause.words(),
        consequence: text::AlarmDetectorConsequence.words(),
        remedy: text::AlarmDetectorRemedy.words(),
    }
}

fn idle(subject: &str) -> Texts {
    Texts {
        priority: Priority::High,
        what: what(subject, &Trouble::MonitorIdle.text()),
        cause: text::AlarmIdleCause.words(),
        consequence: text::AlarmIdleConsequence.words(),
        remedy: text::AlarmIdleRemedy.words(),
    }
}

fn not_closed(subject: &str) -> Texts {
    Texts {
        priority: Priority::High,
        what: what(subject, &Trouble::NotClosed.text()),
        cause: text::AlarmNotClosedCause.words(),
        consequence: text::AlarmNotClosedConsequence.words(),
        remedy: text::AlarmNotClosedRemedy.words(),
    }
}

fn no_monitor(subject: &str) -> Texts {
    Texts {
        priority: Priority::High,
        what: what(subject, &Trouble::NoMonitor.text()),
        cause: text::AlarmNoMonitorCause.words(),
        consequence: text::AlarmNoMonitorConsequence.words(),
        remedy: text::AlarmNoMonitorRemedy.words(),
    }
}

fn few_jets(subject: &str) -> Texts {
    Texts {
        priority: Priority::High,
        what: what(subject, &Trouble::FewJets.text()),
        cause: text::AlarmFewJetsCause.words(),
        consequence: text::AlarmFewJetsConsequence.words(),
        remedy: text::AlarmFewJetsRemedy.words(),
    }
}

fn path(subject: &str) -> Texts {
    Texts {
        priority: Priority::Medium,
        what: what(subject, &Trouble::Path.text()),
        cause: text::AlarmPathCause.words(),
        consequence: text::AlarmPathConsequence.words(),
        remedy: text::AlarmPathRemedy.words(),
    }
}

fn contact(subject: &str) -> Texts {
    Texts {
        priority: Priority::Medium,
        what: what(subject, &Trouble::ContactStuck.text()),
        cause: text::AlarmContactCause.words(),
        consequence: text::AlarmContactConsequence.words(),
        remedy: text::AlarmContactRemedy.words(),
    }
}

fn output(trouble: Trouble, subject: &str) -> Texts {
    Texts {
        priority: Priority::High,
        what: what(subject, &trouble.text()),
        cause: text::AlarmOutputCause.words(),
        consequence: text::AlarmOutputConsequence.words(),
        remedy: text::AlarmOutputRemedy.words(),
    }
}

fn pump(trouble: Trouble, subject: &str) -> Texts {
    Texts {
        priority: Priority::High,
        what: what(subject, &trouble.text()),
        cause: text::AlarmPumpCause.words(),
        consequence: text::AlarmPumpConsequence.words(),
        remedy: text::AlarmPumpRemedy.words(),
    }
}

fn disabled(subject: &str) -> Texts {
    Texts {
        priority: Priority::Low,
        what: text::AlarmZoneDisabled { subject }.words(),
        cause: text::AlarmZoneDisabledCause.words(),
        consequence: text::AlarmZoneDisabledConsequence.words(),
        remedy: text::AlarmZoneDisabledRemedy.words(),
    }
}

fn not_ready(subject: &str) -> Texts {
    Texts {
        priority: Priority::Medium,
        what: text::AlarmZoneNotReady { subject }.words(),
        cause: text::AlarmZoneNotReadyCause.words(),
        ..disabled(subject)
    }
}

#[cfg(test)]
mod tests {
    use lafet_site::config::Config;
    use lafet_site::{Condition as Sight, Event, Hand, MonitorReport, Signal};

    use super::*;
    use crate::alarms::State;

    fn hall() -> lafet_site::Site {
        let config: Config = toml::from_str(
            r#"
            monitors = ["M1"]
            [[zone]]
            id = "hall"
            votes = "1oo1"
            one_detector_releases = true
            water_max_s = 600
            monitors = ["M1"]
            [[detector]]
            id = "heat/1"
            kind = "heat"
            zones = ["hall"]
            "#,
        )
        .unwrap();
        let mut site = lafet_site::Site::new(config, 0, None).unwrap().0;
        let report = MonitorReport { reachable: true, ..MonitorReport::default() };
        site.handle(0, &Event::Monitor { monitor: "M1".into(), report });
        sees(&mut site, 0, Sight::Ready);
        site
    }

    fn sees(site: &mut lafet_site::Site, at: u64, condition: Sight) {
        let detector = "heat/1".into();
        site.handle(at, &Event::Detector { detector, signal: Signal::Quiet, condition });
    }

    fn ids(alarms: &Alarms) -> Vec<(&str, Priority, bool)> {
        alarms.list().iter().map(|it| (it.id.as_str(), it.priority, it.active)).collect()
    }

    #[test]
    fn a_fault_and_what_it_does_to_the_zone_come_and_go() {
        let (mut site, mut alarms) = (hall(), Alarms::default());
        assert!(alarms.zones(0, Some(&site.state())).is_empty());
        sees(&mut site, 10, Sight::Fault);
        assert_eq!(alarms.zones(10, Some(&site.state())).len(), 2);
        let both = [
            ("zones/hall/ZoneNotReady", Priority::Medium, true),
            ("zones/heat/1/DetectorFault", Priority::Medium, true),
        ];
        assert_eq!(ids(&alarms), both);
        sees(&mut site, 20, Sight::Ready);
        alarms.zones(20, Some(&site.state()));
        alarms.zones(2020, Some(&site.state()));
        assert!(alarms.list().iter().all(|it| it.state == State::RtnUnack && !it.active));
    }

    /// A Stop that is not heard any more is as bad as a detector.
    #[test]
    fn a_contact_whose_line_is_lost_is_an_alarm() {
        let text = r#"
            monitors = ["M1"]
            [[zone]]
            id = "hall"
            votes = "1oo1"
            one_detector_releases = true
            water_max_s = 600
            monitors = ["M1"]
            [[detector]]
            id = "heat"
            kind = "heat"
            zones = ["hall"]
            [[input]]
            id = "stop"
            kind = "stop"
        "#;
        let mut site = lafet_site::Site::new(toml::from_str(text).unwrap(), 0, None).unwrap().0;
        let mut alarms = Alarms::default();
        let fault = Some(lafet_site::PathFault::Lost);
        site.handle(10, &Event::Path { path: "stop".into(), fault });
        alarms.zones(10, Some(&site.state()));
        let path = ids(&alarms).into_iter().find(|(id, ..)| id.starts_with("zones/stop/"));
        assert_eq!(path, Some(("zones/stop/PathFault", Priority::Medium, true)));
    }

    #[test]
    fn what_people_switch_off_is_a_low_alarm_and_a_hub_without_zones_has_none() {
        let (mut site, mut alarms) = (hall(), Alarms::default());
        let order = Hand::Mode { zone: "hall".into(), mode: Mode::Off, for_s: None };
        site.handle(10, &Event::Hand { by: "anna".into(), order });
        alarms.zones(10, Some(&site.state()));
        assert_eq!(ids(&alarms), [("zones/hall/ZoneDisabled", Priority::Low, true)]);
        alarms.zones(20, None);
        alarms.zones(2020, None);
        assert!(!alarms.get("zones/hall/ZoneDisabled").unwrap().active);
    }
}
