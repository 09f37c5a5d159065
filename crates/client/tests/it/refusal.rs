//! Each refusal has a reason in both languages, and the scenario that it cites exists.

use lafet_client::refusal::{Reason, reason};
use lafet_proto::{Status, SubsystemId, dictionary};

/// Every request × status × refuser.
#[test]
fn every_refusal_has_its_scenario() {
    let spec = concat!(env!("CARGO_MANIFEST_DIR"), "/../conform/src/spec.txt");
    let spec = std::fs::read_to_string(spec).expect("the list of scenarios");
    let statuses = (2..=19).map(Status);
    for status in statuses {
        for request in dictionary::REQUESTS.iter().map(|info| info.id) {
            for to in SubsystemId::TABLE.into_iter().chain([SubsystemId::ALL]) {
                for by in SubsystemId::TABLE {
                    let Reason { scenario, why, remedy } = reason(request, to, status, by);
                    let line = format!("{scenario}\t");
                    let known = spec.lines().any(|item| item.starts_with(&line));
                    assert!(known, "{scenario}: {request} {to} {status} {by}");
                    for text in [why, remedy] {
                        assert!(text.en.ends_with('.') && text.ru.ends_with('.'), "{text:?}");
                        assert!(text.ru.chars().any(|c| ('а'..='я').contains(&c)), "{text:?}");
                    }
                }
            }
        }
    }
}
