//! What the machine records, in the audit log and in words.

use lafet_site::{Cause, Entry, Mode, Record, Scope, Signal, Trouble, Why};
use serde::Serialize;
use serde_json::Value;

use crate::hub::{Caller, Hub};
use crate::store::Act;
use crate::text::{Both, both};

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
    let about =
        ["zone", "detector", "monitor", "subject"].iter().find_map(|it| fields[*it].as_str());
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
        true => both(
            "Modes, masks and refusals of the zones are not stored: a restart would lose them. Check the disk.",
            "Режимы, отключения и запреты зон не сохраняются и пропадут при перезапуске. Проверьте диск.",
        ),
        false => both(
            "Modes, masks and refusals of the zones are stored again.",
            "Режимы, отключения и запреты зон снова сохраняются.",
        ),
    }
}

/// The event, for people; `None`: it is not news for them. `by` has reported what is of a detector.
fn words(record: &Record, by: &str) -> Option<Both> {
    let text = match &record.entry {
        Entry::Detector { detector, signal: Signal::Alarm, .. } => both(
            format!("Detector {detector}: alarm ({by})."),
            format!("Извещатель {detector}: тревога ({by})."),
        ),
        Entry::Countdown { zone, delay_ms } => {
            let seconds = delay_ms / 1000;
            both(
                format!("Zone {zone}: enough votes, release in {seconds} s."),
                format!("Зона {zone}: голосов достаточно, пуск через {seconds} с."),
            )
        }
        Entry::Cancelled { zone, why } => ended(zone, *why, ["cancelled", "отсчёт прекращён"]),
        Entry::Held { zone, on: true, .. } => both(
            format!("Zone {zone}: the delay is held."),
            format!("Зона {zone}: задержка удерживается."),
        ),
        Entry::Held { zone, on: false, .. } => both(
            format!("Zone {zone}: the hold is over."),
            format!("Зона {zone}: удержание окончено."),
        ),
        Entry::Released { zone, automatic, wet, .. } => released(zone, *automatic, *wet),
        Entry::Ended { zone, why } => ended(zone, *why, ["the release ended", "пуск прекращён"]),
        Entry::No { scope, why } => {
            let (scope, why) = (scope_words(scope), why_words(*why));
            both(
                format!("{}: {}; it lasts until a reset.", scope.en, why.en),
                format!("{}: {}; действует до сброса.", scope.ru, why.ru),
            )
        }
        Entry::Lapsed { scope } | Entry::Reset(scope) => {
            let scope = scope_words(scope);
            both(format!("{}: reset.", scope.en), format!("{}: сброс.", scope.ru))
        }
        Entry::Mode { zone, mode, .. } => {
            let mode = mode_words(*mode);
            both(format!("Zone {zone}: {}.", mode.en), format!("Зона {zone}: {}.", mode.ru))
        }
        Entry::Lockout { on } => both(
            format!("Zones: lockout is {}.", if *on { "on" } else { "off" }),
            format!("Зоны: аварийная блокировка {}.", if *on { "включена" } else { "снята" }),
        ),
        Entry::Trouble { trouble, subject, active } => {
            let text = trouble.text();
            let (en, ru) = if *active { ("", "") } else { (", over", ", устранено") };
            both(format!("{subject}: {}{en}.", text.en), format!("{subject}: {}{ru}.", text.ru))
        }
        Entry::WaterFound { monitor, left_ms } => {
            let seconds = left_ms / 1000;
            both(
                format!(
                    "{monitor}: water was running when the hub started; it is closed after {seconds} s."
                ),
                format!("{monitor}: при запуске сервера шла вода; закрытие через {seconds} с."),
            )
        }
        Entry::Replaced { zone, monitor } => both(
            format!("Zone {zone}: {monitor} is used in place of another monitor."),
            format!("Зона {zone}: ствол {monitor} используется вместо другого."),
        ),
        _ => return None,
    };
    Some(text)
}

fn released(zone: &str, automatic: bool, wet: bool) -> Both {
    let (en, ru) = match (automatic, wet) {
        (_, false) => ("released in a test, without water", "испытательный пуск, без воды"),
        (true, true) => ("released by votes", "пуск по голосам извещателей"),
        (false, true) => ("released by hand", "пуск рукой"),
    };
    both(format!("Zone {zone}: {en}."), format!("Зона {zone}: {ru}."))
}

fn ended(zone: &str, why: Why, [en, ru]: [&str; 2]) -> Both {
    let why = why_words(why);
    both(format!("Zone {zone}: {en} ({}).", why.en), format!("Зона {zone}: {ru} ({}).", why.ru))
}

fn scope_words(scope: &Scope) -> Both {
    match scope {
        Scope::Site => both("All zones", "Все зоны"),
        Scope::Zone(zone) => both(format!("Zone {zone}"), format!("Зона {zone}")),
        Scope::Monitor(monitor) => both(monitor, monitor),
    }
}

fn why_words(why: Why) -> Both {
    match why {
        Why::Lockout => both("lockout", "аварийная блокировка"),
        Why::Stop => both("Stop", "Stop"),
        Why::Close => both("Close", "Close"),
        Why::Abort => both("abort", "отмена"),
        Why::Duration => both("greatest duration", "наибольшая длительность"),
        Why::Quiet => both("no detector in alarm", "тревог нет"),
        Why::TestOver => both("the test is over", "испытание окончено"),
        Why::Votes => both("too few votes", "мало голосов"),
        Why::Mode => both("not in automatic", "не в автоматическом режиме"),
    }
}

fn mode_words(mode: Mode) -> Both {
    match mode {
        Mode::Automatic => both("automatic", "автоматический режим"),
        Mode::Manual => both("manual", "ручной режим"),
        Mode::Off => both("off", "отключена"),
        Mode::TestDry => both("dry test", "испытание без воды"),
        Mode::TestOutlet => both("test of the outlet", "испытание выпуска"),
    }
}
