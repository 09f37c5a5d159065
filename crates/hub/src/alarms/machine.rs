//! The states of alarms. No clock.
//!
//! ```text
//!            active            acknowledged
//!  normal ─────────▶ unack ────────────────▶ ack
//!    ▲                │ ▲                      │
//!    │        returns │ │ active again         │ returns
//!    │                ▼ │                      │
//!    ├───────────── rtn_unack                  │
//!    │  acknowledged                           │
//!    └─────────────────────────────────────────┘
//!  any ── shelve ──▶ shelved ── time over, unshelve ──▶ unack, or normal when it has returned
//! ```

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Bound;

use lafet_proto::SubsystemId;
use lafet_proto::flags::{Severity, set_flags};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;

use super::catalogue::{self, Texts};
use super::holding::Holding;
use crate::clock::shifted;
use crate::model::Status;
use crate::text::Both;

/// A condition has to be gone for so long before its alarm returns: no chattering.
const OFF_DELAY_MS: u64 = 2_000;

/// One of a few words. That it has a name keeps serde from reading it as a text that is borrowed.
type Word = &'static str;

/// An alarm.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct Alarm {
    /// `M1/Vertical/AmperageOverload`.
    pub id: String,
    /// The monitor; empty: the hub itself.
    pub monitor: String,
    /// The subsystem, or `Link`.
    pub subsystem: String,
    /// The flag.
    pub flag: String,
    /// `fire`, `high`, `medium` or `low`.
    #[serde(deserialize_with = "priority")]
    #[schema(value_type = String)]
    pub priority: Word,
    /// `unack`, `ack`, `rtn_unack` or `shelved`.
    #[serde(deserialize_with = "state")]
    #[schema(value_type = String)]
    pub state: Word,
    /// Its condition holds.
    pub active: bool,
    /// Since when, ms since 1970.
    pub since_ms: u64,
    /// When it returned.
    #[schema(required)]
    pub returned_ms: Option<u64>,
    /// How often it came since it was normal.
    pub count: u32,
    /// Who acknowledged it.
    #[schema(required)]
    pub ack: Option<Ack>,
    /// Who put it on the shelf.
    #[schema(required)]
    pub shelved: Option<Shelf>,
    /// What it is.
    pub what: Both,
    /// What usually leads to it.
    pub cause: Both,
    /// What it leads to.
    pub consequence: Both,
    /// What to do.
    pub remedy: Both,
    /// Since when its condition is gone.
    #[serde(skip)]
    gone_ms: Option<u64>,
}

/// The most urgent first.
const PRIORITIES: [Word; 4] = [catalogue::FIRE, "high", "medium", "low"];
const STATES: [Word; 4] = ["unack", "rtn_unack", "ack", "shelved"];

fn priority<'de, D: Deserializer<'de>>(from: D) -> Result<Word, D::Error> {
    word(&PRIORITIES, from)
}

fn state<'de, D: Deserializer<'de>>(from: D) -> Result<Word, D::Error> {
    word(&STATES, from)
}

fn word<'de, D: Deserializer<'de>>(all: &[Word], from: D) -> Result<Word, D::Error> {
    let written = String::deserialize(from)?;
    let known = all.iter().find(|it| **it == written).copied();
    known.ok_or_else(|| D::Error::custom(format!("no word of alarms: {written}")))
}

/// The fire alarm of the site.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct Fire {
    /// A detector sees a fire now.
    pub active: bool,
    /// Somebody has yet to acknowledge one, also one that is gone.
    pub waiting: bool,
    /// Monitors whose detectors see one, or whose alarm waits.
    pub monitors: Vec<String>,
    /// Since when the first of them, ms since 1970.
    #[schema(required)]
    pub since_ms: Option<u64>,
}

/// An acknowledgement.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct Ack {
    /// By whom.
    pub user: String,
    /// When.
    pub at_ms: u64,
}

/// A place on the shelf.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct Shelf {
    /// By whom.
    pub user: String,
    /// Until when.
    pub until_ms: u64,
    /// Why.
    pub reason: String,
}

/// How the hub itself is: each one that holds is an alarm.
#[derive(Clone, Copy, Debug, Default)]
pub struct Conditions {
    /// The audit log cannot be stored.
    pub audit: bool,
    /// The history cannot be stored.
    pub history: bool,
    /// The audit log was changed.
    pub chain: bool,
    /// Files of the state were lost before the start.
    pub state: bool,
    /// Many logins fail.
    pub logins: bool,
    /// What was revoked is not on the disk.
    pub revocations: bool,
}

/// An alarm that has changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// Its id.
    pub id: String,
    /// Its monitor.
    pub monitor: String,
    /// Its state before.
    pub before: &'static str,
    /// Its state now.
    pub after: &'static str,
    /// By whom, if not by itself.
    pub user: Option<String>,
    /// Why, if said.
    pub reason: Option<String>,
}

/// The alarms that are not normal.
#[derive(Debug, Default)]
pub struct Alarms {
    all: BTreeMap<String, Alarm>,
    /// By monitor.
    holdings: BTreeMap<String, Holding>,
}

/// The flag of a monitor whose motion by hand is not sure to end in time.
const UNHELD: &str = "Unheld";

/// A condition that holds.
struct Condition {
    monitor: String,
    subsystem: String,
    flag: String,
    texts: Texts,
}

impl Alarms {
    /// As they were when the hub ended: those of monitors that are still there. Whether their
    /// conditions hold shows soon.
    pub fn restored(written: &[String], monitors: &BTreeSet<String>) -> Self {
        let read = |text: &String| serde_json::from_str::<Alarm>(text).ok();
        let known = |it: &Alarm| it.monitor.is_empty() || monitors.contains(&it.monitor);
        let all = written.iter().filter_map(read).filter(known);
        Self { all: all.map(|alarm| (alarm.id.clone(), alarm)).collect(), ..Self::default() }
    }

    /// The alarm with this id.
    pub fn get(&self, id: &str) -> Option<&Alarm> {
        self.all.get(id)
    }

    /// All of them, the most urgent first.
    pub fn list(&self) -> Vec<&Alarm> {
        let mut list: Vec<&Alarm> = self.all.values().collect();
        let rank = |alarm: &Alarm| {
            let place = |all: &[&str], one| all.iter().position(|it| *it == one);
            (
                place(&STATES, alarm.state),
                place(&PRIORITIES, alarm.priority),
                u64::MAX - alarm.since_ms,
            )
        };
        list.sort_by_key(|alarm| rank(alarm));
        list
    }

    /// The fire alarm of the site: it ends when every fire is gone and acknowledged. What is on the
    /// shelf is left out.
    pub fn fire(&self) -> Fire {
        let fires = self.all.values().filter(|it| it.priority == catalogue::FIRE);
        let fires: Vec<&Alarm> = fires.filter(|it| it.state != "shelved").collect();
        Fire {
            active: fires.iter().any(|it| it.active),
            waiting: fires.iter().any(|it| it.state != "ack"),
            monitors: fires.iter().map(|it| it.monitor.clone()).collect(),
            since_ms: fires.iter().map(|it| it.since_ms).min(),
        }
    }

    /// The state of a monitor. Of one that does not answer nothing new is known.
    pub fn observe(
        &mut self,
        now_ms: u64,
        monitor: &str,
        status: &Status,
        up: bool,
    ) -> Vec<Change> {
        let mut changes = Vec::new();
        // A connection that is made anew, as a monitor was silent, is no alarm of its own.
        let down = !up && (status.stale || status.at_ms.is_none());
        let own = |flag: &str, texts| Condition {
            monitor: monitor.to_owned(),
            subsystem: "Link".into(),
            flag: flag.to_owned(),
            texts,
        };
        let mut holding = Vec::new();
        if down {
            holding.push(own("Down", catalogue::link_down()));
        }
        if status.stale && !status.queued {
            holding.push(own("Stale", catalogue::stale()));
        }
        let bounded = self.holdings.get(monitor).and_then(|it| it.is_bounded());
        if bounded == Some(false) {
            holding.push(own(UNHELD, catalogue::unheld()));
        }
        let known = up && !status.stale;
        if known {
            for (name, state) in &status.subsystems {
                let Some(id) = SubsystemId::from_name(name) else { continue };
                let bad = set_flags(id, state.bits).filter(|it| it.severity() >= Severity::Warning);
                holding.extend(bad.map(|flag| Condition {
                    monitor: monitor.to_owned(),
                    subsystem: (*name).to_owned(),
                    flag: flag.info.name.to_owned(),
                    texts: catalogue::of_flag(id, flag.info),
                }));
            }
        }
        let mut ids = BTreeSet::new();
        for condition in holding {
            let id = format!("{monitor}/{}/{}", condition.subsystem, condition.flag);
            self.holds(now_ms, id.clone(), condition, &mut changes);
            ids.insert(id);
        }
        let gone: Vec<String> = self
            .of(monitor)
            .filter(|alarm| !ids.contains(&alarm.id))
            .filter(|alarm| known || alarm.subsystem == "Link")
            .filter(|alarm| alarm.flag != UNHELD || bounded.is_some())
            .map(|alarm| alarm.id.clone())
            .collect();
        gone.iter().for_each(|id| self.gone(now_ms, id, &mut changes));
        changes
    }

    /// How a motion by hand of a monitor ends.
    pub fn holding(&mut self, monitor: &str) -> &mut Holding {
        self.holdings.entry(monitor.to_owned()).or_default()
    }

    /// The alarms of a monitor.
    fn of<'a>(&'a self, monitor: &'a str) -> impl Iterator<Item = &'a Alarm> {
        // Their ids begin with its.
        let own = self.all.range::<str, _>((Bound::Included(monitor), Bound::Unbounded));
        let own = own.take_while(move |(id, _)| id.starts_with(monitor));
        own.map(|(_, alarm)| alarm).filter(move |alarm| alarm.monitor == monitor)
    }

    /// Whether the condition of an alarm of a monitor is gone, and not yet for long enough.
    pub fn is_returning(&self, monitor: &str) -> bool {
        self.of(monitor).any(|alarm| alarm.active && alarm.gone_ms.is_some())
    }

    /// A monitor is not there any more.
    pub fn forget(&mut self, monitor: &str) -> Vec<Change> {
        self.holdings.remove(monitor);
        let own = self.all.extract_if(.., |_, alarm| alarm.monitor == monitor);
        let change = |(id, alarm): (String, Alarm)| Change {
            id,
            monitor: alarm.monitor,
            before: alarm.state,
            after: "normal",
            user: None,
            reason: None,
        };
        own.map(change).collect()
    }

    /// Time has passed, and this is how the hub itself is.
    pub fn handle_time(&mut self, now_ms: u64, hub: Conditions) -> Vec<Change> {
        let mut changes = Vec::new();
        for (holds, flag, texts) in [
            (hub.audit, "Audit", catalogue::audit as fn() -> Texts),
            (hub.history, "History", catalogue::history),
            (hub.chain, "AuditChain", catalogue::chain),
            (hub.state, "State", catalogue::state),
            (hub.logins, "Logins", catalogue::logins),
            (hub.revocations, "Revocations", catalogue::revocations),
        ] {
            let id = format!("hub/{flag}");
            if holds {
                let condition = Condition {
                    monitor: String::new(),
                    subsystem: "Hub".into(),
                    flag: flag.into(),
                    texts: texts(),
                };
                self.holds(now_ms, id, condition, &mut changes);
            } else {
                self.gone(now_ms, &id, &mut changes);
            }
        }
        let over: Vec<String> = self
            .all
            .values()
            .filter(|it| it.shelved.as_ref().is_some_and(|shelf| shelf.until_ms <= now_ms))
            .map(|alarm| alarm.id.clone())
            .collect();
        changes.extend(over.iter().filter_map(|id| self.unshelve(id, None)));
        changes
    }

    /// The date has stepped: what is shelved stays so for the time that is left.
    pub fn stepped(&mut self, by_ms: i64) -> Vec<Change> {
        let mut changes = Vec::new();
        for alarm in self.all.values_mut() {
            alarm.gone_ms = alarm.gone_ms.map(|it| shifted(it, by_ms));
            if let Some(shelf) = &mut alarm.shelved {
                shelf.until_ms = shifted(shelf.until_ms, by_ms);
                let (id, monitor) = (alarm.id.clone(), alarm.monitor.clone());
                let (before, after) = (alarm.state, alarm.state);
                changes.push(Change { id, monitor, before, after, user: None, reason: None });
            }
        }
        changes
    }

    /// Acknowledges an alarm.
    pub fn acknowledge(&mut self, now_ms: u64, id: &str, user: &str) -> Option<Change> {
        let alarm = self.all.get_mut(id)?;
        let after = match alarm.state {
            "unack" => "ack",
            "rtn_unack" => "normal",
            _ => return None,
        };
        alarm.ack = Some(Ack { user: user.to_owned(), at_ms: now_ms });
        Some(self.turn(id, after, Some(user), None))
    }

    /// Every alarm that waits for it.
    pub fn unacknowledged(&self) -> Vec<String> {
        let waits = |alarm: &&Alarm| matches!(alarm.state, "unack" | "rtn_unack");
        self.all.values().filter(waits).map(|alarm| alarm.id.clone()).collect()
    }

    /// Puts an alarm on the shelf for a while.
    pub fn shelve(&mut self, id: &str, user: &str, until_ms: u64, reason: &str) -> Option<Change> {
        let alarm = self.all.get_mut(id)?;
        let shelf = Shelf { user: user.to_owned(), until_ms, reason: reason.to_owned() };
        alarm.shelved = Some(shelf);
        Some(self.turn(id, "shelved", Some(user), Some(reason)))
    }

    /// Takes it down.
    pub fn unshelve(&mut self, id: &str, user: Option<&str>) -> Option<Change> {
        let alarm = self.all.get_mut(id)?;
        alarm.shelved.take()?;
        let after = if alarm.active { "unack" } else { "normal" };
        Some(self.turn(id, after, user, None))
    }

    fn holds(&mut self, now_ms: u64, id: String, it: Condition, changes: &mut Vec<Change>) {
        if let Some(alarm) = self.all.get_mut(&id) {
            alarm.gone_ms = None;
            if alarm.active {
                return;
            }
            (alarm.active, alarm.since_ms, alarm.returned_ms) = (true, now_ms, None);
            alarm.count += 1;
            let after = if alarm.state == "shelved" { "shelved" } else { "unack" };
            return changes.push(self.turn(&id, after, None, None));
        }
        let Texts { priority, what, cause, consequence, remedy } = it.texts;
        let alarm = Alarm {
            id: id.clone(),
            monitor: it.monitor,
            subsystem: it.subsystem,
            flag: it.flag,
            priority,
            state: "normal",
            active: true,
            since_ms: now_ms,
            returned_ms: None,
            count: 1,
            ack: None,
            shelved: None,
            what,
            cause,
            consequence,
            remedy,
            gone_ms: None,
        };
        self.all.insert(id.clone(), alarm);
        changes.push(self.turn(&id, "unack", None, None));
    }

    fn gone(&mut self, now_ms: u64, id: &str, changes: &mut Vec<Change>) {
        let Some(alarm) = self.all.get_mut(id).filter(|alarm| alarm.active) else { return };
        if now_ms < *alarm.gone_ms.get_or_insert(now_ms) + OFF_DELAY_MS {
            return;
        }
        (alarm.active, alarm.returned_ms) = (false, Some(now_ms));
        let after = match alarm.state {
            "unack" => "rtn_unack",
            "shelved" => "shelved",
            _ => "normal",
        };
        changes.push(self.turn(id, after, None, None));
    }

    /// The one place where a state changes.
    fn turn(
        &mut self,
        id: &str,
        after: &'static str,
        user: Option<&str>,
        reason: Option<&str>,
    ) -> Change {
        let (mut before, mut monitor) = ("normal", String::new());
        if let Some(alarm) = self.all.get_mut(id) {
            (before, monitor) = (alarm.state, alarm.monitor.clone());
            alarm.state = after;
        }
        if after == "normal" {
            self.all.remove(id);
        }
        let own = str::to_owned;
        Change {
            id: id.to_owned(),
            monitor,
            before,
            after,
            user: user.map(own),
            reason: reason.map(own),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::model::Subsystem;

    const ID: &str = "M1/Vertical/AmperageOverload";

    fn status(bits: u32) -> Status {
        let state = Subsystem { bits, ..Subsystem::default() };
        let subsystems = [("Vertical", Arc::new(state))].into();
        Status { at_ms: Some(1), subsystems, ..Status::default() }
    }

    fn see(alarms: &mut Alarms, now_ms: u64, bits: u32) -> Vec<(&'static str, &'static str)> {
        let changes = alarms.observe(now_ms, "M1", &status(bits), true);
        changes.iter().map(|change| (change.before, change.after)).collect()
    }

    const OVERLOAD: u32 = 1 << 18;

    #[test]
    fn comes_is_acknowledged_and_goes() {
        let mut alarms = Alarms::default();
        assert_eq!(see(&mut alarms, 0, OVERLOAD), [("normal", "unack")]);
        assert!(see(&mut alarms, 10, OVERLOAD).is_empty());
        let alarm = alarms.get(ID).unwrap();
        assert!(!alarm.consequence.ru.is_empty() && alarm.active);
        assert_eq!(alarms.acknowledge(20, ID, "anna").unwrap().after, "ack");
        assert!(alarms.acknowledge(20, ID, "anna").is_none());
        assert!(see(&mut alarms, 100, 0).is_empty(), "it has to be gone for a while");
        assert_eq!(see(&mut alarms, 100 + OFF_DELAY_MS, 0), [("ack", "normal")]);
        assert!(alarms.list().is_empty());
    }

    /// A fire that a detector has found is the site's, until it is gone and acknowledged.
    #[test]
    fn a_found_fire_is_an_alarm_of_the_site() {
        let found = |found: bool| {
            let mut detector = crate::model::Subsystem::default();
            detector.set_bits(SubsystemId::DETECTOR, u32::from(found) << 17);
            let subsystems = [("Detector", Arc::new(detector))].into();
            Status { at_ms: Some(1), subsystems, ..Status::default() }
        };
        let mut alarms = Alarms::default();
        assert_eq!(alarms.fire(), Fire::default());
        alarms.observe(10, "M2", &found(true), true);
        alarms.observe(20, "M1", &found(true), true);
        let monitors = vec!["M1".to_owned(), "M2".to_owned()];
        let burning = Fire { active: true, waiting: true, monitors, since_ms: Some(10) };
        assert_eq!(alarms.fire(), burning);
        let id = "M2/Detector/Found";
        assert_eq!(alarms.get(id).unwrap().priority, "fire");
        alarms.acknowledge(30, id, "anna");
        alarms.acknowledge(30, "M1/Detector/Found", "anna");
        assert!(alarms.fire().active && !alarms.fire().waiting);
        for now_ms in [100, 100 + OFF_DELAY_MS] {
            alarms.observe(now_ms, "M1", &found(false), true);
            alarms.observe(now_ms, "M2", &found(false), true);
        }
        assert_eq!(alarms.fire(), Fire::default());
    }

    #[test]
    fn what_returns_unacknowledged_stays_until_it_is() {
        let mut alarms = Alarms::default();
        see(&mut alarms, 0, OVERLOAD);
        see(&mut alarms, 10, 0);
        assert_eq!(see(&mut alarms, 3000, 0), [("unack", "rtn_unack")]);
        assert_eq!(see(&mut alarms, 4000, OVERLOAD), [("rtn_unack", "unack")]);
        assert_eq!(alarms.get(ID).unwrap().count, 2);
        see(&mut alarms, 5000, 0);
        see(&mut alarms, 8000, 0);
        assert_eq!(alarms.acknowledge(9000, ID, "anna").unwrap().after, "normal");
    }

    #[test]
    fn flicker_is_one_alarm() {
        let mut alarms = Alarms::default();
        let bits = |at| if at % 1000 == 0 { OVERLOAD } else { 0 };
        let changes: usize =
            (0..100).map(|step| see(&mut alarms, step * 500, bits(step * 500)).len()).sum();
        assert_eq!(changes, 1);
    }

    #[test]
    fn the_shelf_is_left_in_time() {
        let mut alarms = Alarms::default();
        see(&mut alarms, 0, OVERLOAD);
        assert_eq!(alarms.shelve(ID, "anna", 10_000, "known").unwrap().after, "shelved");
        assert!(alarms.unacknowledged().is_empty());
        assert!(alarms.handle_time(9_999, Conditions::default()).is_empty());
        assert_eq!(alarms.handle_time(10_000, Conditions::default())[0].after, "unack");
        alarms.shelve(ID, "anna", 90_000, "known");
        see(&mut alarms, 11_000, 0);
        assert_eq!(see(&mut alarms, 14_000, 0), [("shelved", "shelved")]);
        assert_eq!(alarms.unshelve(ID, Some("anna")).unwrap().after, "normal");
    }

    #[test]
    fn the_date_may_step_and_the_shelf_lasts_as_long() {
        let mut alarms = Alarms::default();
        see(&mut alarms, 0, OVERLOAD);
        alarms.shelve(ID, "anna", 10_000, "known");
        assert_eq!(alarms.stepped(-5000).len(), 1);
        assert_eq!(alarms.get(ID).unwrap().shelved.as_ref().unwrap().until_ms, 5000);
        alarms.stepped(1_000_000);
        assert!(alarms.handle_time(1_004_999, Conditions::default()).is_empty());
        assert_eq!(alarms.handle_time(1_005_000, Conditions::default()).len(), 1);
    }

    #[test]
    fn of_a_silent_monitor_nothing_new_is_known() {
        let mut alarms = Alarms::default();
        see(&mut alarms, 0, OVERLOAD);
        let silent = Status { stale: true, ..status(0) };
        for at in [10, 5_000, 10_000] {
            alarms.observe(at, "M1", &silent, true);
        }
        assert!(alarms.get(ID).unwrap().active);
        assert!(alarms.get("M1/Link/Stale").unwrap().active);
        alarms.observe(20_000, "M1", &silent, false);
        assert!(alarms.get("M1/Link/Down").unwrap().active);
        alarms.observe(23_000, "M1", &silent, false);
        assert_eq!(alarms.get("M1/Link/Stale").unwrap().state, "unack");
        for at in [30_000, 33_000] {
            alarms.observe(at, "M1", &status(OVERLOAD), true);
        }
        assert_eq!(alarms.get("M1/Link/Down").unwrap().state, "rtn_unack");
    }

    #[test]
    fn whose_turn_on_the_line_has_not_come_is_not_silent() {
        let mut alarms = Alarms::default();
        let queued = Status { stale: true, queued: true, ..status(0) };
        assert!(alarms.observe(10, "M1", &queued, true).is_empty());
        let silent = Status { queued: false, ..queued };
        assert_eq!(alarms.observe(20, "M1", &silent, true).len(), 1);
    }

    #[test]
    fn a_motion_by_hand_that_does_not_end_in_time_is_an_alarm() {
        let (id, mut alarms) = ("M1/Link/Unheld", Alarms::default());
        assert_eq!(see(&mut alarms, 0, 0), [], "not known yet");
        alarms.holding("M1").set_hold(false);
        assert_eq!(see(&mut alarms, 1000, 0), [("normal", "unack")]);
        let alarm = alarms.get(id).unwrap();
        assert_eq!(alarm.priority, "medium");
        assert!(alarm.remedy.en.contains("MoveHold") && alarm.remedy.ru.contains("MoveHold"));
        // After a restart it stays until it is known whether it holds.
        let written = [serde_json::to_string(alarms.get(id).unwrap()).unwrap()];
        let mut again = Alarms::restored(&written, &["M1".to_owned()].into());
        let seen = [5000, 9000].map(|at| see(&mut again, at, 0).len());
        assert_eq!((seen, again.get(id).unwrap().active), ([0, 0], true));
        again.holding("M1").set_hold(true);
        see(&mut again, 10_000, 0);
        assert_eq!(see(&mut again, 13_000, 0), [("unack", "rtn_unack")]);
        alarms.forget("M1");
        assert!(alarms.get(id).is_none() && alarms.holdings.is_empty());
    }

    #[test]
    fn a_log_that_is_not_stored_is_an_alarm() {
        let mut alarms = Alarms::default();
        assert_eq!(
            alarms.handle_time(0, Conditions { audit: true, ..Conditions::default() })[0].after,
            "unack"
        );
        alarms.handle_time(1, Conditions::default());
        assert_eq!(alarms.handle_time(3_000, Conditions::default())[0].after, "rtn_unack");
    }

    #[test]
    fn a_restart_forgets_nothing() {
        let both = Conditions { audit: true, history: true, ..Conditions::default() };
        let mut alarms = Alarms::default();
        alarms.handle_time(5, both);
        alarms.shelve("hub/History", "anna", 500, "being moved");
        alarms.acknowledge(6, "hub/Audit", "boris");
        let written = |alarms: &Alarms| -> Vec<String> {
            alarms.list().iter().map(|it| serde_json::to_string(it).unwrap()).collect()
        };
        let before = written(&alarms);
        let mut again = Alarms::restored(&before, &BTreeSet::new());
        assert_eq!(written(&again), before);
        assert!(again.handle_time(7, both).is_empty(), "nothing is new");
        assert_eq!(again.get("hub/History").unwrap().state, "shelved");
        again.handle_time(500, both);
        assert_eq!(again.get("hub/History").unwrap().state, "unack");

        let gone = before[0].replace(r#""monitor":"""#, r#""monitor":"M9""#);
        let junk = ["{}".into(), gone];
        assert!(Alarms::restored(&junk, &BTreeSet::from(["M1".into()])).list().is_empty());
    }
}
