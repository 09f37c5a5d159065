//! What is published of a monitor and of the hub: JSON. A value that is not the present one is null.

use std::collections::BTreeMap;

use lafet_ballistics::DATM_MPA;
use lafet_proto::SubsystemId;
use serde::Serialize;

use super::desk::Reply;
use super::words;
use crate::alarms::{Alarm, Priority, State as AlarmState};
use crate::clock::ms;
use crate::monitor::status::Status;
use crate::plugs::orders::AXES;
use crate::plugs::seat::PlugSeat;
use crate::plugs::sight::{Holder, Known, is_faulty, mode};
use crate::text::Both;

/// Alarms that are listed; of more there is the number.
const ALARMS_MAX: usize = 64;

/// The state of a monitor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct State {
    pub(super) at_ms: Option<u64>,
    pub(super) age_ms: Option<u64>,
    pub(super) quality: &'static str,
    pub(super) mode: Option<&'static str>,
    pub(super) holder: Holder,
    pub(super) traverse: Option<f64>,
    pub(super) elevation: Option<f64>,
    pub(super) nozzle: Option<i64>,
    pub(super) pressure_mpa: Option<f64>,
    pub(super) flow_lps: Option<i64>,
    pub(super) voltage_v: Option<i64>,
    pub(super) valves: BTreeMap<&'static str, Option<Valve>>,
    pub(super) fire: Option<bool>,
    pub(super) water: bool,
    pub(super) locked_out: Option<bool>,
    pub(super) ready: bool,
    pub(super) alarms: Alarms,
    pub(super) motion: Option<Motion>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Valve {
    pub(super) open: bool,
    pub(super) closed: bool,
    pub(super) opening: bool,
    pub(super) closing: bool,
    pub(super) blocked: bool,
    pub(super) fault: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Alarms {
    pub(super) count: u16,
    pub(super) waiting: u16,
    pub(super) worst: Option<Priority>,
    pub(super) fire: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Motion {
    pub(super) traverse: bool,
    pub(super) elevation: bool,
    pub(super) nozzle: bool,
}

/// Of a state, what is published at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Urgent {
    available: bool,
    fire: Option<bool>,
    water: bool,
    locked_out: Option<bool>,
    alarms: Alarms,
}

fn round(value: f64, digits: i32) -> f64 {
    let scale = 10_f64.powi(digits);
    (value * scale).round() / scale
}

impl State {
    /// The state of a monitor as it is known.
    pub fn new(known: &Known<'_>) -> Self {
        let (status, fresh) = (known.status, known.is_fresh());
        let general = |field| status.valid(SubsystemId::GENERAL, field).filter(|_| fresh);
        let is_set = |id, flag| fresh.then(|| status.is_set(id, flag));
        let [traverse, elevation, nozzle] = AXES.map(|axis| {
            let position = status.position(axis);
            position.filter(|_| fresh)
        });
        let degrees = |arcmin: i64| round(arcmin as f64 / 60.0, 3);
        let [moves_traverse, moves_elevation, moves_nozzle] =
            AXES.map(|axis| status.is_set(axis, "Move"));
        Self {
            at_ms: status.at_ms,
            age_ms: known.age.map(ms),
            quality: match (known.age, known.up) {
                (None, _) => "never",
                (Some(_), false) => "down",
                (Some(_), true) if fresh => "good",
                (Some(_), true) => "stale",
            },
            mode: fresh.then(|| mode(status).1),
            holder: known.control.holder,
            traverse: traverse.map(degrees),
            elevation: elevation.map(degrees),
            nozzle,
            pressure_mpa: general("pressure").map(|it| round(it as f64 * DATM_MPA, 4)),
            flow_lps: general("flowrate"),
            voltage_v: general("main_voltage"),
            valves: valves(status, fresh),
            fire: is_set(SubsystemId::DETECTOR, "Found"),
            water: !fresh || status.flows(),
            locked_out: is_set(SubsystemId::GENERAL, "LockedOut"),
            ready: fresh && known.ready,
            alarms: Alarms {
                count: known.alarms.count,
                waiting: known.alarms.waiting,
                worst: known.alarms.worst,
                fire: known.alarms.fire,
            },
            motion: fresh.then_some(Motion {
                traverse: moves_traverse,
                elevation: moves_elevation,
                nozzle: moves_nozzle,
            }),
        }
    }

    /// Of it, what is published at once.
    pub fn urgent(&self) -> Urgent {
        let Self { fire, water, locked_out, alarms, .. } = *self;
        Urgent { available: self.is_available(), fire, water, locked_out, alarms }
    }

    /// There is a connection, and the state is fresh.
    pub fn is_available(&self) -> bool {
        self.quality == "good"
    }
}

/// The states of monitors, in their order.
pub fn all(seat: PlugSeat<'_>, ids: &[String]) -> Vec<State> {
    let tallies = seat.tallies(ids);
    ids.iter().zip(tallies).map(|(id, tally)| seat.sees(id, tally, State::new)).collect()
}

/// The valves that the monitor has; null: not known.
fn valves(status: &Status, fresh: bool) -> BTreeMap<&'static str, Option<Valve>> {
    let one = |valve: SubsystemId| {
        let is_set = |flag| status.is_set(valve, flag);
        fresh.then(|| Valve {
            open: is_set("Open"),
            closed: is_set("Closed"),
            opening: is_set("Opening"),
            closing: is_set("Closing"),
            blocked: is_set("Blocked"),
            fault: is_faulty(status, valve),
        })
    };
    let name = |valve| if valve == SubsystemId::VALVE2 { "valve2" } else { "valve1" };
    status.valves().into_iter().map(|valve| (name(valve), one(valve))).collect()
}

/// The alarms that are not normal.
#[derive(Clone, Debug, Serialize)]
pub struct AlarmList<'a> {
    alarms: Vec<Listed<'a>>,
    /// So many more are not listed.
    more: usize,
}

#[derive(Clone, Debug, Serialize)]
struct Listed<'a> {
    id: &'a str,
    monitor: Option<&'a str>,
    priority: Priority,
    state: &'static str,
    active: bool,
    since_ms: u64,
    text: &'a Both,
    remedy: &'a Both,
}

impl<'a> AlarmList<'a> {
    /// Those of some monitors and of the hub itself; the most urgent first.
    pub fn new(alarms: &[&'a Alarm], monitors: &[String]) -> Self {
        let own = |it: &&&'a Alarm| it.monitor.is_empty() || monitors.contains(&it.monitor);
        let one = |it: &&'a Alarm| Listed {
            id: &it.id,
            monitor: Some(it.monitor.as_str()).filter(|it| !it.is_empty()),
            priority: it.priority,
            state: AlarmState::word(Some(it.state)),
            active: it.active,
            since_ms: it.since_ms,
            text: &it.what,
            remedy: &it.remedy,
        };
        let own: Vec<&&'a Alarm> = alarms.iter().filter(own).collect();
        let more = own.len().saturating_sub(ALARMS_MAX);
        Self { alarms: own.into_iter().take(ALARMS_MAX).map(one).collect(), more }
    }
}

/// Whether the hub is there.
#[derive(Clone, Debug, Serialize)]
pub struct Online<'a> {
    /// It is.
    pub online: bool,
    /// Version of the program.
    pub version: &'static str,
    /// The session: another one after each connection. Null when it is not there.
    pub session: Option<&'a str>,
    /// Since when, ms since 1970.
    pub since_ms: Option<u64>,
}

impl<'a> Online<'a> {
    /// In a session.
    pub fn since(session: &'a str, since_ms: u64) -> Self {
        let version = env!("CARGO_PKG_VERSION");
        Self { online: true, version, session: Some(session), since_ms: Some(since_ms) }
    }

    /// The hub is not there, or not connected.
    pub fn no() -> Self {
        Self { online: false, version: env!("CARGO_PKG_VERSION"), session: None, since_ms: None }
    }
}

/// A ticket.
#[derive(Clone, Debug, Serialize)]
pub struct Ticket<'a> {
    /// The number.
    pub ticket: String,
    /// The session.
    pub session: &'a str,
}

/// The key of a monitor.
#[derive(Clone, Debug, Serialize)]
pub struct Key {
    /// The number; null: none is offered.
    pub key: Option<String>,
}

/// The result of a command.
#[derive(Clone, Debug, Serialize)]
pub struct Result<'a> {
    id: Option<&'a str>,
    command: Option<&'static str>,
    ok: bool,
    refusal: Option<u16>,
    text: Option<Both>,
    status: Option<u16>,
    retained: bool,
    repeated: bool,
}

impl<'a> Result<'a> {
    /// Of a reply.
    pub fn new(reply: &'a Reply) -> Self {
        let failed = reply.result.err();
        Self {
            id: reply.id.as_deref(),
            command: reply.command.map(crate::plugs::orders::Command::name),
            ok: failed.is_none(),
            refusal: failed.map(|it| it.why.number()),
            text: failed.map(|it| words::of(it.why)),
            status: failed.map(|it| it.status).filter(|it| *it != 0),
            retained: reply.retained,
            repeated: reply.repeated,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Duration;

    use serde_json::{Value, json};

    use super::*;
    use crate::monitor::status::Subsystem;
    use crate::plugs::sight::fixture::status;
    use crate::plugs::sight::{Control, Tally};

    fn shown(status: &Status, age: Option<u64>, up: bool) -> Value {
        let mut alarms = Tally::default();
        alarms.add(Priority::High, AlarmState::Unack);
        let control = Control { holder: Holder::Mine, ..Control::default() };
        let age = age.map(Duration::from_millis);
        let known = Known { status, age, up, ready: true, control, alarms };
        serde_json::to_value(State::new(&known)).unwrap()
    }

    #[test]
    fn a_fresh_state_is_in_the_units_that_are_documented() {
        let state = shown(&status(), Some(40), true);
        for (key, value) in [
            ("quality", json!("good")),
            ("age_ms", json!(40)),
            ("holder", json!("mine")),
            ("traverse", json!(-10.083)),
            ("elevation", json!(20.05)),
            ("nozzle", json!(60)),
            ("pressure_mpa", json!(0.8106)),
            ("flow_lps", json!(20)),
            ("voltage_v", json!(24)),
            ("water", json!(true)),
            ("locked_out", json!(false)),
            ("alarms", json!({"count": 1, "waiting": 1, "worst": "high", "fire": false})),
            ("motion", json!({"traverse": true, "elevation": false, "nozzle": false})),
        ] {
            assert_eq!(state[key], value, "{key}");
        }
        assert!(state["valves"]["valve1"].is_object() && state["valves"].get("valve2").is_none());
    }

    /// Not the last value as if it were good, and water may flow.
    #[test]
    fn what_is_not_known_is_null() {
        let stale = Status { stale: true, ..status() };
        let mut all = vec![
            ("stale", shown(&stale, Some(900), true)),
            ("down", shown(&status(), Some(40), false)),
            ("never", shown(&Status::default(), None, true)),
        ];
        for (quality, state) in &all {
            assert_eq!(state["quality"], *quality);
            for key in [
                "mode",
                "traverse",
                "elevation",
                "nozzle",
                "pressure_mpa",
                "flow_lps",
                "voltage_v",
                "fire",
                "locked_out",
                "motion",
            ] {
                assert!(state[key].is_null(), "{quality} {key}: {state}");
            }
            assert_eq!((&state["water"], &state["ready"]), (&json!(true), &json!(false)));
        }
        assert!(all.remove(0).1["valves"]["valve1"].is_null());
        let mut faulty = status();
        let mut general = Subsystem::clone(&faulty.subsystems["General"]);
        general.set_bits(SubsystemId::GENERAL, 1 << 16);
        faulty.subsystems.insert("General", Arc::new(general));
        let state = shown(&faulty, Some(1), true);
        assert_eq!((&state["pressure_mpa"], &state["flow_lps"]), (&Value::Null, &json!(20)));
    }
}
