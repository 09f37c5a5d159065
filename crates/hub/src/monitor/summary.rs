//! What pages of other monitors and of the whole site show of a monitor's state, in a fifth of its
//! bytes.

use std::collections::BTreeMap;
use std::sync::Arc;

use lafet_proto::SubsystemId;
use serde::{Serialize, Serializer};

use crate::monitor::status::{Status, Subsystem};
use crate::text::Both;

/// The subsystems and fields that it contains.
const SHOWN: [(SubsystemId, &[&str]); 8] = [
    (SubsystemId::GENERAL, &["pressure", "flowrate"]),
    (SubsystemId::VERTICAL, &["position"]),
    (SubsystemId::HORIZONTAL, &["position"]),
    (SubsystemId::VALVE1, &[]),
    (SubsystemId::VALVE2, &[]),
    (SubsystemId::CONTROL, &[]),
    (SubsystemId::DETECTOR, &[]),
    (SubsystemId::DEPLOYER, &[]),
];

/// The summary of a state, made when it is written.
#[derive(Debug)]
pub struct Summary(pub Arc<Status>);

#[derive(Serialize)]
struct Written<'a> {
    at_ms: Option<u64>,
    stale: bool,
    error: &'a Option<Both>,
    resumes_ms: Option<u64>,
    subsystems: BTreeMap<&'static str, Brief<'a>>,
}

#[derive(Serialize)]
struct Brief<'a> {
    bits: u32,
    flags: &'a [String],
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    bad: BTreeMap<&'static str, &'static str>,
    #[serde(flatten)]
    fields: BTreeMap<&'static str, i64>,
}

impl Serialize for Summary {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Status { at_ms, stale, error, resumes_ms, subsystems, .. } = &*self.0;
        let brief = |(id, fields): &(SubsystemId, &[&'static str])| {
            let name = id.name()?;
            Some((name, Brief::of(subsystems.get(name)?, fields)))
        };
        let subsystems = SHOWN.iter().filter_map(brief).collect();
        let (at_ms, stale, resumes_ms) = (*at_ms, *stale, *resumes_ms);
        Written { at_ms, stale, error, resumes_ms, subsystems }.serialize(serializer)
    }
}

impl<'a> Brief<'a> {
    fn of(state: &'a Subsystem, fields: &[&'static str]) -> Self {
        let value = |name: &&'static str| Some((*name, *state.fields.get(name)?));
        let why = |name: &&'static str| Some((*name, *state.bad.get(name)?));
        Self {
            bits: state.bits,
            flags: &state.flags,
            bad: fields.iter().filter_map(why).collect(),
            fields: fields.iter().filter_map(value).collect(),
        }
    }
}

/// Whether two states have the same summary, but for the time.
pub fn is_same(one: &Status, other: &Status) -> bool {
    let shown = |(id, fields): &(SubsystemId, &[&'static str])| {
        let state = |of: &Status| id.name().and_then(|name| of.subsystems.get(name).cloned());
        match (state(one), state(other)) {
            (Some(one), Some(other)) => {
                Arc::ptr_eq(&one, &other)
                    || one.bits == other.bits
                        && fields.iter().all(|it| one.fields.get(it) == other.fields.get(it))
            }
            (one, other) => one.is_none() == other.is_none(),
        }
    };
    one.stale == other.stale
        && one.at_ms.is_some() == other.at_ms.is_some()
        && one.resumes_ms == other.resumes_ms
        && one.error == other.error
        && SHOWN.iter().all(shown)
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn status(vertical: u32, position: i64, current: i64) -> Arc<Status> {
        let mut state = Subsystem::default();
        state.set_bits(SubsystemId::VERTICAL, vertical);
        state.fields = [("position", position), ("current", current)].into();
        let subsystems =
            [("Vertical", Arc::new(state)), ("Radio", Arc::new(Subsystem::default()))].into();
        Arc::new(Status { at_ms: Some(1), subsystems, ..Status::default() })
    }

    #[test]
    fn it_has_what_is_shown_and_is_new_only_when_that_changes() {
        let written: Value = json!(Summary(status(0, 7, 100)));
        let vertical = json!({ "bits": 0, "flags": [], "position": 7 });
        let subsystems = json!({ "Vertical": vertical });
        let all = json!({
            "at_ms": 1, "stale": false, "error": null, "resumes_ms": null, "subsystems": subsystems,
        });
        assert_eq!(written, all);
        let one = status(0, 7, 100);
        assert!(is_same(&one, &status(0, 7, 200)), "the current is not in it");
        assert!(!is_same(&one, &status(0, 8, 100)) && !is_same(&one, &status(1, 7, 100)));
        assert!(!is_same(&one, &Status::default()));
    }
}
