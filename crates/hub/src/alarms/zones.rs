//! What is wrong with the zones, as alarms: troubles that no alarm of a monitor has, zones that release nothing.

use std::collections::BTreeSet;

use lafet_site::{Mode, Phase, State as Site, Trouble, ZoneState};

use super::alarm::Priority;
use super::catalogue::Texts;
use super::machine::{Alarms, Change, Condition};
use crate::text::{Both, both};

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
        Trouble::Path => ("PathFault", path(subject)),
        Trouble::ContactStuck => ("ContactStuck", contact(subject)),
        Trouble::MonitorUnreachable | Trouble::MonitorFailure => return None,
        // Nothing drives outputs and pumps.
        Trouble::OutputOverdue
        | Trouble::PumpFailed
        | Trouble::PumpOverdue
        | Trouble::NoPressure => return None,
    };
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
    both(format!("{subject}: {}.", text.en), format!("{subject}: {}.", text.ru))
}

fn detector(trouble: Trouble, subject: &str) -> Texts {
    Texts {
        priority: Priority::Medium,
        what: what(subject, &trouble.text().into()),
        cause: both(
            "The detector or its gateway has no power, no link or a fault, or its window is dirty.",
            "У извещателя или его шлюза нет питания или связи, он неисправен либо загрязнено окно.",
        ),
        consequence: both(
            "It has no vote: its zones may release later, or only alarm.",
            "Голоса у него нет: пуск в его зонах задержится или останется только тревога.",
        ),
        remedy: both(
            "Watch its area; look at the detector, its gateway and its link.",
            "Наблюдайте за его участком; проверьте извещатель, шлюз и связь.",
        ),
    }
}

fn idle(subject: &str) -> Texts {
    Texts {
        priority: Priority::High,
        what: what(subject, &Trouble::MonitorIdle.text().into()),
        cause: both(
            "It refuses, a valve or drive does not move, or its post is locked.",
            "Ствол отказывает, не движется затвор или привод либо заблокирован пост.",
        ),
        consequence: both(
            "Another monitor is used in its place, if the zone has one.",
            "Вместо него используется другой ствол зоны, если он есть.",
        ),
        remedy: both(
            "Take control and open it by hand, or use its button post.",
            "Возьмите управление и откройте вручную либо используйте пост у ствола.",
        ),
    }
}

fn not_closed(subject: &str) -> Texts {
    Texts {
        priority: Priority::High,
        what: what(subject, &Trouble::NotClosed.text().into()),
        cause: both(
            "The valve does not close, its sensor has failed, or the monitor does not answer.",
            "Затвор не закрывается, отказал его датчик либо ствол не отвечает.",
        ),
        consequence: both("Water may still run.", "Вода может идти."),
        remedy: both(
            "Look whether water runs; shut it off at the monitor.",
            "Посмотрите, идёт ли вода; перекройте её у ствола.",
        ),
    }
}

fn no_monitor(subject: &str) -> Texts {
    Texts {
        priority: Priority::High,
        what: what(subject, &Trouble::NoMonitor.text().into()),
        cause: both(
            "All of its monitors are lost, failed, locked, closed or controlled by people.",
            "Все её стволы не отвечают, неисправны, заблокированы, закрыты или под управлением людей.",
        ),
        consequence: both("A released zone gets no water.", "В зону с пуском вода не идёт."),
        remedy: both(
            "Extinguish by other means; give control of a monitor up, or reset it.",
            "Тушите другими средствами; верните управление стволом или сбросьте его.",
        ),
    }
}

fn path(subject: &str) -> Texts {
    Texts {
        priority: Priority::Medium,
        what: what(subject, &Trouble::Path.text().into()),
        cause: both(
            "A broken wire, a device without power, or a bus that does not answer.",
            "Обрыв провода, устройство без питания либо линия, которая не отвечает.",
        ),
        consequence: both(
            "It counts as it was last: a press of it is not seen.",
            "Действует последнее состояние: нажатие не будет замечено.",
        ),
        remedy: both(
            "Use the console or the posts of the monitors; look at the wire and the device.",
            "Используйте пульт или посты стволов; проверьте провод и устройство.",
        ),
    }
}

fn contact(subject: &str) -> Texts {
    Texts {
        priority: Priority::Medium,
        what: what(subject, &Trouble::ContactStuck.text().into()),
        cause: both(
            "The station is still pressed, or its contact is welded.",
            "Пост ещё нажат либо контакт сварился.",
        ),
        consequence: both(
            "A press of it releases nothing until it was seen released.",
            "Пуска от него нет, пока не замечено отпускание.",
        ),
        remedy: both(
            "Reset the station; if the trouble stays, look at its contact.",
            "Верните пост в исходное положение; если неисправность осталась, проверьте контакт.",
        ),
    }
}

fn disabled(subject: &str) -> Texts {
    Texts {
        priority: Priority::Low,
        what: both(
            format!("Zone {subject} is disabled: not in automatic, ended or locked."),
            format!(
                "Зона {subject} отключена: не в автоматическом режиме, прекращена или заблокирована."
            ),
        ),
        cause: both("A person's order.", "Команда человека."),
        consequence: both(
            "A fire is only an alarm; water comes by hand, if at all.",
            "Пожар даёт только тревогу; вода — рукой, если вообще возможна.",
        ),
        remedy: both(
            "Watch the zone. Afterwards set automatic, reset it or unlock the zones.",
            "Наблюдайте за зоной. Затем верните автоматический режим, сбросьте зону или снимите блокировку.",
        ),
    }
}

fn not_ready(subject: &str) -> Texts {
    Texts {
        priority: Priority::Medium,
        what: both(
            format!("Zone {subject} is not ready: it would release nothing by itself."),
            format!("Зона {subject} не готова: сама она пуска не даст."),
        ),
        cause: both(
            "Too many of its detectors have failed, or none of its monitors can serve it.",
            "Отказало слишком много её извещателей либо её не может обслужить ни один ствол.",
        ),
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
