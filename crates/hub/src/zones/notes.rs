//! What the machine records, in the audit log and in words.

use std::time::Duration;

use lafet_site::{Cause, Entry, Mode, Persisted, Record, Scope, Signal, Trouble, Why};
use lafet_texts::{Text, hub as text};
use serde::Serialize;
use serde_json::Value;

use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::store::{Act, Record as Noted};
use crate::text::Both;

impl Hub {
    /// Notes what has happened: for the audit log with its causes, for people in words.
    pub(super) fn note_entry(&self, caller: &Caller, record: &Record) {
        if let Some(text) = words(record, &caller.principal.user) {
            self.event(monitor_of(&record.entry), &text);
        }
        // What detectors and lines say all day is in the event log alone, which forgets.
        let says = |it: &Entry| {
            matches!(it, Entry::Detector { .. } | Entry::Trouble { .. } | Entry::Unknown { .. })
        };
        if says(&record.entry) {
            return;
        }
        let by_hand = record.cause.iter().any(|it| matches!(it, Cause::Hand { .. }));
        let zones = Caller::zones();
        let by = if by_hand { caller } else { &zones };
        let outcome = if matches!(record.entry, Entry::Refused { .. }) { "refused" } else { "Ok" };
        drop(self.audit().note(self.record_of(by, record, outcome)));
    }

    /// What the machine records, as the audit log has it.
    pub(super) fn record_of(&self, by: &Caller, record: &Record, outcome: &str) -> Noted {
        let what = format!("zones: {}", word_of(&record.entry));
        let act = Act::Zone { entry: record.entry.clone(), cause: record.cause.clone() };
        let monitor = monitor_of(&record.entry).unwrap_or_default();
        self.record(by, monitor, &what, outcome).about(&act)
    }
}

/// The name of a variant in the API, and what it is about: `released hall`.
pub fn word_of(entry: &impl Serialize) -> String {
    let value = serde_json::to_value(entry).unwrap_or_default();
    let Value::Object(map) = &value else {
        return value.as_str().unwrap_or_default().to_owned();
    };
    let Some((name, fields)) = map.iter().next() else { return String::new() };
    let about = ["zone", "detector", "monitor", "pump", "output", "subject"]
        .iter()
        .find_map(|it| fields[*it].as_str());
    match about {
        Some(about) => format!("{name} {about}"),
        None => name.clone(),
    }
}

fn monitor_of(entry: &Entry) -> Option<&str> {
    match entry {
        Entry::WaterFound { monitor, .. } | Entry::Replaced { monitor, .. } => Some(monitor),
        Entry::No { scope: Scope::Monitor(monitor), .. } => Some(monitor),
        Entry::Trouble {
            trouble:
                Trouble::MonitorUnreachable
                | Trouble::MonitorFailure
                | Trouble::MonitorIdle
                | Trouble::NotClosed,
            subject,
            ..
        } => Some(subject),
        _ => None,
    }
}

impl Hub {
    /// A monitor ends water by itself after so long, s, if no client confirms it: what a zone gives must
    /// not run for longer when the hub fails.
    pub fn water_timeout_is(&self, station: &Station, seconds: u32) {
        let zones = self.zones().map(|it| &it.config.site.zones[..]).unwrap_or_default();
        let of = zones.iter().filter(|it| it.monitors.iter().any(|id| id == station.id()));
        let Some(longest) = of.max_by_key(|it| it.water_max_s) else { return };
        if let Some(text) = endless(seconds, &longest.id, longest.water_max_s) {
            self.event(Some(station.id()), &text);
        }
    }
}

/// What is wrong with WaterTimeout of a monitor that serves a zone.
fn endless(seconds: u32, zone: &str, most: u32) -> Option<Both> {
    match seconds {
        0 => Some(text::WaterTimeoutOff { zone, most }.words()),
        _ if seconds > most => Some(text::WaterTimeoutLonger { seconds, zone, most }.words()),
        _ => None,
    }
}

/// What people have to know of what was stored before the start.
pub fn of_stored(config: &lafet_site::Config, stored: &Persisted) -> Vec<Both> {
    let mut said = Vec::new();
    for (id, stored) in &stored.zones {
        match config.zones.iter().find(|it| it.id == *id) {
            Some(zone) if zone.mode != stored.mode => {
                let (stored, file) = (mode_words(stored.mode), mode_words(zone.mode));
                said.push(text::ZoneStoredMode { zone: id, stored, file }.words());
            }
            None if stored.mode != Mode::Automatic || stored.ended.is_some() => {
                said.push(text::ZoneStoredGone { what: id }.words());
            }
            _ => {}
        }
    }
    let detectors =
        stored.detectors.keys().filter(|id| !config.detectors.iter().any(|it| it.id == **id));
    let refused = stored.monitors.iter().filter(|it| it.1.refused.is_some()).map(|it| it.0);
    let monitors = refused.filter(|id| !config.monitors.contains(id));
    let pumps = stored.pumps_off.iter().filter(|id| !config.pumps.iter().any(|it| it.id == **id));
    let names = detectors.chain(monitors).chain(pumps);
    said.extend(names.map(|what| text::ZoneStoredGone { what }.words()));
    said
}

/// That the disk takes the state of the zones, or does not.
pub fn storing(failing: bool) -> Both {
    match failing {
        true => text::ZonesNotStored.words(),
        false => text::ZonesStored.words(),
    }
}

/// That the monitors of a zone cannot be assigned to fires, or can again.
pub fn planning(zone: &str, failed: Option<&Both>) -> Both {
    match failed {
        Some(why) => text::ZoneNotPlanned { zone, why }.words(),
        None => text::ZonePlanned { zone }.words(),
    }
}

/// That the anemometer has not reported for so long.
pub fn no_wind(silent: Duration) -> Both {
    text::ZonesNoWind { minutes: silent.as_secs() / 60 }.words()
}

/// The event, for people; `None`: it is not news for them. `by` has reported what is of a detector.
fn words(record: &Record, by: &str) -> Option<Both> {
    let text = match &record.entry {
        Entry::Detector { detector, signal: Signal::Alarm, .. } => {
            text::ZoneDetectorAlarm { detector, by }.words()
        }
        Entry::Countdown { zone, delay_ms } => {
            let seconds = delay_ms / 1000;
            text::ZoneCountdown { zone, seconds }.words()
        }
        Entry::Cancelled { zone, why } => {
            text::ZoneCancelled { zone, why: why_words(*why) }.words()
        }
        Entry::Held { zone, on: true, .. } => text::ZoneHeld { zone }.words(),
        Entry::Held { zone, on: false, .. } => text::ZoneHoldOver { zone }.words(),
        Entry::Released { zone, automatic, wet, .. } => released(zone, *automatic, *wet),
        Entry::Ended { zone, why } => text::ZoneEnded { zone, why: why_words(*why) }.words(),
        Entry::No { scope, why } => {
            text::ZoneNo { scope: scope_words(scope), why: why_words(*why) }.words()
        }
        Entry::Lapsed { scope } | Entry::Reset(scope) => {
            text::ZoneReset { scope: scope_words(scope) }.words()
        }
        Entry::Mode { zone, mode, .. } => text::ZoneNews { zone, news: mode_words(*mode) }.words(),
        Entry::Lockout { on: true } => text::ZonesLockoutOn.words(),
        Entry::Lockout { on: false } => text::ZonesLockoutOff.words(),
        Entry::Trouble { trouble, subject, active } => {
            let trouble = trouble.text();
            match active {
                true => text::ZoneTrouble { subject, trouble }.words(),
                false => text::ZoneTroubleOver { subject, trouble }.words(),
            }
        }
        Entry::WaterFound { monitor, left_ms } => {
            let seconds = left_ms / 1000;
            text::ZoneWaterFound { monitor, seconds }.words()
        }
        Entry::StationRefused { input, zone, why } => {
            text::ZoneStationRefused { input, zone, why: why.text() }.words()
        }
        Entry::Replaced { zone, monitor } => text::ZoneMonitorReplaced { zone, monitor }.words(),
        _ => return None,
    };
    Some(text)
}

fn released(zone: &str, automatic: bool, wet: bool) -> Both {
    let news: &dyn Text = match (automatic, wet) {
        (_, false) => &text::ReleasedDry,
        (true, true) => &text::ReleasedByVotes,
        (false, true) => &text::ReleasedByHand,
    };
    text::ZoneNews { zone, news }.words()
}

fn scope_words(scope: &Scope) -> Both {
    match scope {
        Scope::Site => text::ScopeSite.words(),
        Scope::Zone(zone) => text::ScopeZone { zone }.words(),
        Scope::Monitor(monitor) => Both::same(monitor),
    }
}

fn why_words(why: Why) -> Both {
    match why {
        Why::Lockout => text::WhyLockout.words(),
        Why::Stop => Both::same("Stop"),
        Why::Close => Both::same("Close"),
        Why::Abort => text::WhyAbort.words(),
        Why::Duration => text::WhyDuration.words(),
        Why::Quiet => text::WhyQuiet.words(),
        Why::TestOver => text::WhyTestOver.words(),
        Why::Votes => text::WhyVotes.words(),
        Why::Mode => text::WhyMode.words(),
    }
}

fn mode_words(mode: Mode) -> Both {
    match mode {
        Mode::Automatic => text::ModeAutomatic.words(),
        Mode::Manual => text::ModeManual.words(),
        Mode::Off => text::ModeOff.words(),
        Mode::TestDry => text::ModeTestDry.words(),
        Mode::TestOutlet => text::ModeTestOutlet.words(),
    }
}

#[cfg(test)]
mod tests {
    use lafet_site::{Bypass, Refusal, StoredMonitor, StoredZone};

    use super::*;

    #[test]
    fn what_was_stored_otherwise_than_the_file_has_it_is_said() {
        let config: lafet_site::Config = toml::from_str(
            r#"
            monitors = ["M1"]
            [[zone]]
            id = "hall"
            votes = "1oo1"
            water_max_s = 60
            monitors = ["M1"]
            [[detector]]
            id = "flame"
            kind = "flame"
            zones = ["hall"]
            "#,
        )
        .unwrap();
        let zone = |mode| StoredZone { mode, returns_in_ms: None, ended: None };
        let refused = StoredMonitor { refused: Some(Why::Close), ..Default::default() };
        let stored = |hall, gone| Persisted {
            version: lafet_site::VERSION,
            lockout: false,
            zones: [("hall".into(), zone(hall)), ("attic".into(), zone(gone))].into(),
            detectors: [("flame".into(), Bypass::Masked)].into(),
            monitors: [("M1".into(), refused.clone())].into(),
            pressed: Default::default(),
            pumps_off: Default::default(),
        };
        let said = |stored: &Persisted| {
            let all = of_stored(&config, stored).into_iter();
            all.map(|it| [it.en, it.ru].concat()).collect::<Vec<_>>()
        };
        assert!(said(&stored(Mode::Automatic, Mode::Automatic)).is_empty());
        let told = said(&stored(Mode::Off, Mode::Automatic));
        assert!(told.len() == 1 && told[0].contains("off. The file says: automatic"), "{told:?}");
        let mut gone = stored(Mode::Automatic, Mode::Off);
        gone.detectors.insert("smoke".into(), Bypass::Disabled);
        gone.monitors.insert("M9".into(), refused.clone());
        gone.pumps_off.insert("P9".into());
        let events = said(&gone);
        assert_eq!(events.len(), 4, "{events:?}");
        for (said, name) in events.iter().zip(["attic", "smoke", "M9", "P9"]) {
            assert!(said.contains(name) && said.contains("не действует"), "{said}");
        }
    }

    #[test]
    fn a_release_point_that_was_refused_is_an_event() {
        let (input, zone) = ("post".to_owned(), "hall".to_owned());
        let entry = Entry::StationRefused { input, zone, why: Refusal::Lockout };
        let record = Record { number: 1, at_ms: 0, entry, cause: Vec::new() };
        let said = words(&record, "").expect("an event");
        assert!(said.en.contains("post") && said.ru.contains("hall"), "{said:?}");
    }

    #[test]
    fn water_that_a_monitor_would_not_end_is_an_event() {
        assert!(endless(0, "hall", 60).is_some_and(|it| it.en.contains("is 0")));
        assert!(endless(61, "hall", 60).is_some_and(|it| it.en.contains("61 s, more than")));
        assert_eq!(endless(60, "hall", 60), None);
    }
}
