//! The dictionary has an entry in both languages for everything that the protocol names.

use lafet_proto::dictionary::{self, REQUESTS, STATUSES, SUBSYSTEMS, Text};
use lafet_proto::flags::{self, Button, ButtonState, Severity};
use lafet_proto::id::{RequestId, Status, SubsystemId};
use lafet_proto::param::{Param, Unit};
use std::collections::BTreeSet;

fn is_cyrillic(text: &str) -> bool {
    text.chars().any(|c| ('а'..='я').contains(&c) || ('А'..='Я').contains(&c))
}

fn check(name: &str, text: &Text) {
    assert!(!text.en.is_empty() && !is_cyrillic(text.en), "{name}: {}", text.en);
    assert!(is_cyrillic(text.ru), "{name}: {}", text.ru);
    for text in [text.en, text.ru] {
        assert!(!text.contains("  ") && !text.contains('\n'), "{name}: {text}");
    }
}

/// §2: nineteen statuses, in their order.
#[test]
fn statuses() {
    assert_eq!(STATUSES.len(), 19);
    for (info, (status, name)) in STATUSES.iter().zip(Status::KNOWN) {
        assert_eq!((info.status, info.name), (*status, *name));
        assert_eq!(dictionary::status(*status), Some(info));
        check(name, &info.meaning);
        check(name, &info.remedy);
    }
    assert_eq!(dictionary::status(Status(19)), None);
}

/// §1: sixteen subsystems, in the order of the table.
#[test]
fn subsystems() {
    assert_eq!(SUBSYSTEMS.len(), 16);
    for (info, (id, name)) in SUBSYSTEMS.iter().zip(SubsystemId::KNOWN) {
        assert_eq!((info.id, info.name), (*id, *name));
        assert_eq!(dictionary::subsystem(*id), Some(info));
        check(name, &info.title);
        check(name, &info.meaning);
    }
    assert_eq!(dictionary::subsystem(SubsystemId(0)), None);
}

/// §3: every request, and the services of the bus controller.
#[test]
fn requests() {
    assert_eq!(REQUESTS.len(), RequestId::KNOWN.len() + RequestId::BUS.len());
    for (id, name) in RequestId::KNOWN.iter().chain(RequestId::BUS) {
        let info = dictionary::request(*id).expect("every request has an entry");
        assert_eq!(info.name, *name);
        check(name, &info.title);
        check(name, &info.meaning);
    }
    // §3.1–§3.21 in order, each section once.
    let sections: Vec<&str> = REQUESTS.iter().map(|info| info.section).collect();
    let expected: Vec<String> = (1..=21).map(|n| format!("3.{n}")).collect();
    assert_eq!(sections[..21], expected);
    assert_eq!(sections[21..], ["bus"; 3]);
}

#[test]
fn nothing_is_said_twice() {
    let mut names = BTreeSet::new();
    for name in REQUESTS.iter().map(|i| i.name).chain(SUBSYSTEMS.iter().map(|i| i.name)) {
        assert!(names.insert(name), "{name}");
    }
    let meanings: BTreeSet<&str> = STATUSES.iter().map(|info| info.meaning.en).collect();
    assert_eq!(meanings.len(), STATUSES.len());
}

#[test]
fn flags_parameters_and_small_words() {
    for id in SubsystemId::TABLE {
        for info in flags::flags_of(id).flags {
            check(info.name, &info.meaning);
            check(info.name, &info.cause);
            check(info.name, &info.remedy);
        }
    }
    for param in Param::ALL {
        check(param.name(), &param.text());
    }
    Severity::ALL.iter().for_each(|severity| check("severity", &severity.text()));
    ButtonState::ALL.iter().for_each(|state| check("state", &state.text()));
    Button::ALL.iter().for_each(|button| check("button", &button.text()));
    assert!(Severity::ALL.is_sorted());
    assert_eq!(Unit::DeciAmpere.name().map(|it| it.ru), Some("×0,1 А"));
}
