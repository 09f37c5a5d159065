//! What the machine records, in the audit log and in words.

use std::time::Duration;

use lafet_site::{Cause, Entry, Mode, Record, Scope, Signal, Trouble, Why};
use lafet_texts::{Text, hub as text};
use serde::Serialize;
use serde_json::Value;

use crate::hub::{Caller, Hub};
use crate::store::Act;
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
        let what = format!("zones: {}", word_of(&record.entry));
        let outcome = if matches!(record.entry, Entry::Refused { .. }) { "refused" } else { "Ok" };
        let act = Act::Zone { entry: record.entry.clone(), cause: record.cause.clone() };
        let monitor = monitor_of(&record.entry).unwrap_or_default();
        drop(self.audit().note(self.record(by, monitor, &what, outcome).about(&act)));
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
