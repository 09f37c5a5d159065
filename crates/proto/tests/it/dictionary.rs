//! The dictionary has an entry for everything that the protocol names. Its texts are tested where
//! they are, in `lafet-texts`.

use lafet_proto::dictionary::{self, Key, REQUESTS, STATUSES, SUBSYSTEMS};
use lafet_proto::flags::Severity;
use lafet_proto::id::{RequestId, Status, SubsystemId};
use std::collections::BTreeSet;

/// Keys are made of the kind of the row, its name, and what the text is.
fn check(key: Key, parts: [&str; 3]) {
    assert_eq!(key.name(), parts.join("-"));
}

/// §2: nineteen statuses, in their order.
#[test]
fn statuses() {
    assert_eq!(STATUSES.len(), 19);
    for (info, (status, name)) in STATUSES.iter().zip(Status::KNOWN) {
        assert_eq!((info.status, info.name), (*status, *name));
        assert_eq!(dictionary::status(*status), Some(info));
        check(info.meaning, ["status", name, "meaning"]);
        check(info.remedy, ["status", name, "remedy"]);
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
        check(info.title, ["subsystem", name, "title"]);
        check(info.meaning, ["subsystem", name, "meaning"]);
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
        check(info.title, ["request", name, "title"]);
        check(info.meaning, ["request", name, "meaning"]);
    }
    // §3.1–§3.21 in order, each section once.
    let sections: Vec<&str> = REQUESTS.iter().map(|info| info.section).collect();
    let expected: Vec<String> = (1..=21).map(|n| format!("3.{n}")).collect();
    assert_eq!(sections[..21], expected);
    assert_eq!(sections[21..], ["bus"; 3]);
}

#[test]
fn nothing_is_named_twice() {
    let mut names = BTreeSet::new();
    for name in REQUESTS.iter().map(|i| i.name).chain(SUBSYSTEMS.iter().map(|i| i.name)) {
        assert!(names.insert(name), "{name}");
    }
    assert!(Severity::ALL.is_sorted());
}
