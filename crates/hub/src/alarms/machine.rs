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

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Bound;

use lafet_proto::SubsystemId;
use lafet_proto::flags::{Severity, set_flags};

use super::alarm::{Ack, Alarm, Fire, Priority, Shelf, State};
use super::catalogue::{self, Texts};
use super::holding::Holding;
use crate::clock::shifted;
use crate::monitor::status::{Status, Withheld};

/// A condition has to be gone for this time before its alarm returns: no chattering.
const OFF_DELAY_MS: u64 = 2_000;
/// Longest time on the shelf, minutes.
pub const SHELVE_MAX_MIN: u64 = 480;

/// Conditions of the hub itself: each one that is `true` is an alarm.
#[derive(Clone, Copy, Debug, Default)]
pub struct Conditions {
    /// The audit log cannot be stored.
    pub audit: bool,
    /// The history cannot be stored.
    pub history: bool,
    /// The event log and the states of alarms cannot be stored.
    pub events: bool,
    /// The audit log was changed.
    pub chain: bool,
    /// Files of the state were lost before the start.
    pub state: bool,
    /// Many logins have failed.
    pub logins: bool,
    /// A revocation is not on the disk yet.
    pub revocations: bool,
    /// The state of the zones cannot be stored.
    pub zones: bool,
    /// The disk of the state is almost full.
    pub disk: bool,
    /// Nothing can be recorded.
    pub recordings: bool,
    /// The certificate ends soon, or has ended.
    pub certificate: bool,
}

/// An alarm that has changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The id of the alarm.
    pub id: String,
    /// The id of the monitor; empty: the hub itself.
    pub monitor: String,
    /// The state before; `None`: normal.
    pub before: Option<State>,
    /// The state now; `None`: normal.
    pub after: Option<State>,
    /// The user who changed it; `None`: the condition did.
    pub user: Option<String>,
    /// The reason that the user gave.
    pub reason: Option<String>,
}

impl Change {
    /// The condition has come, or come again, and waits to be acknowledged. What leaves the shelf has not
    /// come just now.
    pub const fn begins(&self) -> bool {
        matches!((self.before, self.after), (None | Some(State::RtnUnack), Some(State::Unack)))
    }
}

/// The alarms that are not normal.
#[derive(Debug, Default)]
pub struct Alarms {
    all: BTreeMap<String, Alarm>,
    /// Ends of motions by hand, by monitor.
    holdings: BTreeMap<String, Holding>,
    /// Keep-outs that water goes into, by monitor.
    kept_out: BTreeMap<String, String>,
}

/// The flag of a monitor whose motion by hand is not sure to end in time.
const UNHELD: &str = "Unheld";
/// Subsystem of the alarm for water that goes into a keep-out.
const KEEP_OUT: &str = "KeepOut";

/// An active condition of an alarm.
pub(super) struct Condition {
    pub(super) monitor: String,
    pub(super) subsystem: String,
    pub(super) flag: String,
    pub(super) texts: Texts,
}

impl Alarms {
    /// As they were when the hub ended: those of monitors that are still there. Whether their
    /// conditions hold shows soon.
    pub fn restored(now_ms: u64, written: &[String], monitors: &BTreeSet<String>) -> Self {
        let read = |text: &String| serde_json::from_str::<Alarm>(text).ok();
        let known = |it: &Alarm| it.monitor.is_empty() || monitors.contains(&it.monitor);
        let all = written.iter().filter_map(read).filter(known).map(|mut alarm| {
            // A computer may start with an old date, which steps forward later.
            alarm.shelved.iter_mut().for_each(|shelf| bound(shelf, now_ms));
            alarm
        });
        Self { all: all.map(|alarm| (alarm.id.clone(), alarm)).collect(), ..Self::default() }
    }

    /// The alarm with this id.
    pub fn get(&self, id: &str) -> Option<&Alarm> {
        self.all.get(id)
    }

    /// All of them, the most urgent first.
    pub fn list(&self) -> Vec<&Alarm> {
        let mut list: Vec<&Alarm> = self.all.values().collect();
        list.sort_by_key(|alarm| (alarm.state, alarm.priority, Reverse(alarm.since_ms)));
        list
    }

    /// The fire alarm of the site: it ends when every fire is gone and acknowledged. What is on the
    /// shelf is left out.
    pub fn fire(&self) -> Fire {
        let fires = self.all.values().filter(|it| it.priority == Priority::Fire);
        let fires: Vec<&Alarm> = fires.filter(|it| it.state != State::Shelved).collect();
        Fire {
            active: fires.iter().any(|it| it.active),
            waiting: fires.iter().any(|it| it.state != State::Ack),
            monitors: fires.iter().map(|it| it.monitor.clone()).collect(),
            since_ms: fires.iter().map(|it| it.since_ms).min(),
        }
    }

    /// Water of a monitor goes into this keep-out.
    pub fn set_kept_out(&mut self, monitor: &str, name: Option<String>) {
        match name {
            Some(name) => _ = self.kept_out.insert(monitor.to_owned(), name),
            None => _ = self.kept_out.remove(monitor),
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
        // A reconnection because a monitor was silent is no alarm of its own.
        let down = !up && (status.stale || status.at_ms.is_none());
        let of = |subsystem: &str, flag: &str, texts| Condition {
            monitor: monitor.to_owned(),
            subsystem: subsystem.to_owned(),
            flag: flag.to_owned(),
            texts,
        };
        let own = |flag, texts| of("Link", flag, texts);
        let mut holding = Vec::new();
        if down {
            holding.push(own("Down", catalogue::link_down()));
        }
        match status.withheld {
            Some(Withheld::Unreadable { baud }) => {
                holding.push(own("Unreadable", catalogue::unreadable(baud)));
            }
            Some(Withheld::Controller) => {
                holding.push(own("Controller", catalogue::foreign_controller()));
            }
            None if status.stale && !status.queued => {
                holding.push(own("Stale", catalogue::stale()));
            }
            None => {}
        }
        let bounded = self.holdings.get(monitor).and_then(|it| it.is_bounded());
        if bounded == Some(false) {
            holding.push(own(UNHELD, catalogue::unheld()));
        }
        if let Some(name) = self.kept_out.get(monitor) {
            holding.push(of(KEEP_OUT, "Water", catalogue::kept_out(name)));
        }
        let known = up && !status.stale;
        if known {
            for (name, state) in &status.subsystems {
                let Some(id) = SubsystemId::from_name(name) else { continue };
                let bad = set_flags(id, state.bits).filter(|it| it.severity() >= Severity::Warning);
                holding
                    .extend(bad.map(|it| of(name, it.info.name, catalogue::of_flag(id, it.info))));
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
        self.kept_out.remove(monitor);
        let own = self.all.extract_if(.., |_, alarm| alarm.monitor == monitor);
        let change = |(id, alarm): (String, Alarm)| Change {
            id,
            monitor: alarm.monitor,
            before: Some(alarm.state),
            after: None,
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
            (hub.events, "Events", catalogue::events),
            (hub.chain, "AuditChain", catalogue::chain),
            (hub.state, "State", catalogue::state),
            (hub.logins, "Logins", catalogue::logins),
            (hub.revocations, "Revocations", catalogue::revocations),
            (hub.zones, "Zones", catalogue::zones),
            (hub.disk, "Disk", catalogue::disk),
            (hub.recordings, "Recordings", catalogue::recordings),
            (hub.certificate, "Certificate", catalogue::certificate),
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
    pub fn stepped(&mut self, now_ms: u64, by_ms: i64) -> Vec<Change> {
        let mut changes = Vec::new();
        for alarm in self.all.values_mut() {
            alarm.gone_ms = alarm.gone_ms.map(|it| shifted(it, by_ms));
            if let Some(shelf) = &mut alarm.shelved {
                shelf.until_ms = shifted(shelf.until_ms, by_ms);
                bound(shelf, now_ms);
                let (id, monitor) = (alarm.id.clone(), alarm.monitor.clone());
                let (before, after) = (Some(alarm.state), Some(alarm.state));
                changes.push(Change { id, monitor, before, after, user: None, reason: None });
            }
        }
        changes
    }

    /// Acknowledges an alarm.
    pub fn acknowledge(&mut self, now_ms: u64, id: &str, user: &str) -> Option<Change> {
        let alarm = self.all.get_mut(id)?;
        let after = match alarm.state {
            State::Unack => Some(State::Ack),
            State::RtnUnack => None,
            State::Ack | State::Shelved => return None,
        };
        alarm.ack = Some(Ack { user: user.to_owned(), at_ms: now_ms });
        Some(self.turn(id, after, Some(user), None))
    }

    /// Every alarm that waits for it.
    pub fn unacknowledged(&self) -> Vec<String> {
        let waits = |alarm: &&Alarm| matches!(alarm.state, State::Unack | State::RtnUnack);
        self.all.values().filter(waits).map(|alarm| alarm.id.clone()).collect()
    }

    /// Puts an alarm on the shelf for a while.
    pub fn shelve(&mut self, id: &str, user: &str, until_ms: u64, reason: &str) -> Option<Change> {
        let alarm = self.all.get_mut(id)?;
        let shelf = Shelf { user: user.to_owned(), until_ms, reason: reason.to_owned() };
        alarm.shelved = Some(shelf);
        Some(self.turn(id, Some(State::Shelved), Some(user), Some(reason)))
    }

    /// Ends the shelving of an alarm.
    pub fn unshelve(&mut self, id: &str, user: Option<&str>) -> Option<Change> {
        let alarm = self.all.get_mut(id)?;
        alarm.shelved.take()?;
        let after = alarm.active.then_some(State::Unack);
        Some(self.turn(id, after, user, None))
    }

    pub(super) fn holds(
        &mut self,
        now_ms: u64,
        id: String,
        it: Condition,
        changes: &mut Vec<Change>,
    ) {
        if let Some(alarm) = self.all.get_mut(&id) {
            alarm.gone_ms = None;
            if alarm.active {
                return;
            }
            (alarm.active, alarm.since_ms, alarm.returned_ms) = (true, now_ms, None);
            alarm.count += 1;
            let shelved = alarm.state == State::Shelved;
            let after = if shelved { State::Shelved } else { State::Unack };
            return changes.push(self.turn(&id, Some(after), None, None));
        }
        let Texts { priority, what, cause, consequence, remedy } = it.texts;
        let alarm = Alarm {
            id: id.clone(),
            monitor: it.monitor,
            subsystem: it.subsystem,
            flag: it.flag,
            priority,
            state: State::Unack,
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
        changes.push(Change {
            id: id.clone(),
            monitor: alarm.monitor.clone(),
            before: None,
            after: Some(State::Unack),
            user: None,
            reason: None,
        });
        self.all.insert(id, alarm);
    }

    pub(super) fn gone(&mut self, now_ms: u64, id: &str, changes: &mut Vec<Change>) {
        let Some(alarm) = self.all.get_mut(id).filter(|alarm| alarm.active) else { return };
        if now_ms < *alarm.gone_ms.get_or_insert(now_ms) + OFF_DELAY_MS {
            return;
        }
        (alarm.active, alarm.returned_ms) = (false, Some(now_ms));
        let after = match alarm.state {
            State::Unack => Some(State::RtnUnack),
            State::Shelved => Some(State::Shelved),
            State::RtnUnack | State::Ack => None,
        };
        changes.push(self.turn(id, after, None, None));
    }

    /// The one place where the state of a known alarm changes.
    fn turn(
        &mut self,
        id: &str,
        after: Option<State>,
        user: Option<&str>,
        reason: Option<&str>,
    ) -> Change {
        let (mut before, mut monitor) = (None, String::new());
        if let Some(alarm) = self.all.get_mut(id) {
            (before, monitor) = (Some(alarm.state), alarm.monitor.clone());
            alarm.state = after.unwrap_or(alarm.state);
        }
        if after.is_none() {
            self.all.remove(id);
        }
        let (user, reason) = (user.map(str::to_owned), reason.map(str::to_owned));
        Change { id: id.to_owned(), monitor, before, after, user, reason }
    }
}

/// Whatever the date was, nothing is shelved for longer than a user may shelve it.
fn bound(shelf: &mut Shelf, now_ms: u64) {
    shelf.until_ms = shelf.until_ms.min(now_ms.saturating_add(SHELVE_MAX_MIN * 60_000));
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::monitor::status::Subsystem;

    const ID: &str = "M1/Vertical/AmperageOverload";

    fn status(bits: u32) -> Status {
        let state = Subsystem { bits, ..Subsystem::default() };
        let subsystems = [("Vertical", Arc::new(state))].into();
        Status { at_ms: Some(1), subsystems, ..Status::default() }
    }

    fn see(alarms: &mut Alarms, now_ms: u64, bits: u32) -> Vec<(Option<State>, Option<State>)> {
        let changes = alarms.observe(now_ms, "M1", &status(bits), true);
        changes.iter().map(|change| (change.before, change.after)).collect()
    }

    const OVERLOAD: u32 = 1 << 18;

    #[test]
    fn comes_is_acknowledged_and_goes() {
        let mut alarms = Alarms::default();
        assert_eq!(see(&mut alarms, 0, OVERLOAD), [(None, Some(State::Unack))]);
        assert!(see(&mut alarms, 10, OVERLOAD).is_empty());
        let alarm = alarms.get(ID).unwrap();
        assert!(!alarm.consequence.ru.is_empty() && alarm.active);
        assert_eq!(alarms.acknowledge(20, ID, "anna").unwrap().after, Some(State::Ack));
        assert!(alarms.acknowledge(20, ID, "anna").is_none());
        assert!(see(&mut alarms, 100, 0).is_empty(), "it has to be gone for a while");
        assert_eq!(see(&mut alarms, 100 + OFF_DELAY_MS, 0), [(Some(State::Ack), None)]);
        assert!(alarms.list().is_empty());
    }

    /// A fire that a detector has found is the site's, until it is gone and acknowledged.
    #[test]
    fn a_found_fire_is_an_alarm_of_the_site() {
        let found = |found: bool| {
            let mut detector = crate::monitor::status::Subsystem::default();
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
        assert_eq!(alarms.get(id).unwrap().priority, Priority::Fire);
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
        assert_eq!(see(&mut alarms, 3000, 0), [(Some(State::Unack), Some(State::RtnUnack))]);
        let again = alarms.observe(4000, "M1", &status(OVERLOAD), true);
        assert_eq!((again[0].before, again[0].after), (Some(State::RtnUnack), Some(State::Unack)));
        assert!(again[0].begins(), "it is recorded as the first time");
        assert_eq!(alarms.get(ID).unwrap().count, 2);
        see(&mut alarms, 5000, 0);
        see(&mut alarms, 8000, 0);
        assert_eq!(alarms.acknowledge(9000, ID, "anna").unwrap().after, None);
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
        assert_eq!(alarms.shelve(ID, "anna", 10_000, "known").unwrap().after, Some(State::Shelved));
        assert!(alarms.unacknowledged().is_empty());
        assert!(alarms.handle_time(9_999, Conditions::default()).is_empty());
        let over = alarms.handle_time(10_000, Conditions::default());
        assert_eq!((over[0].after, over[0].begins()), (Some(State::Unack), false));
        alarms.shelve(ID, "anna", 90_000, "known");
        see(&mut alarms, 11_000, 0);
        assert_eq!(see(&mut alarms, 14_000, 0), [(Some(State::Shelved), Some(State::Shelved))]);
        assert_eq!(alarms.unshelve(ID, Some("anna")).unwrap().after, None);
    }

    #[test]
    fn the_date_may_step_and_the_shelf_lasts_as_long() {
        let mut alarms = Alarms::default();
        see(&mut alarms, 0, OVERLOAD);
        alarms.shelve(ID, "anna", 10_000, "known");
        assert_eq!(alarms.stepped(4000, -5000).len(), 1);
        assert_eq!(alarms.get(ID).unwrap().shelved.as_ref().unwrap().until_ms, 5000);
        alarms.stepped(1_004_000, 1_000_000);
        assert!(alarms.handle_time(1_004_999, Conditions::default()).is_empty());
        assert_eq!(alarms.handle_time(1_005_000, Conditions::default()).len(), 1);
    }

    /// Assumed: a computer without a battery starts in 1970, and the time server comes later.
    #[test]
    fn an_old_date_at_the_start_shelves_nothing_for_longer() {
        let (now_ms, most_ms) = (1_795_000_000_000_u64, SHELVE_MAX_MIN * 60_000);
        let mut alarms = Alarms::default();
        see(&mut alarms, now_ms, OVERLOAD);
        alarms.shelve(ID, "anna", now_ms + 60_000, "known");
        let written = [serde_json::to_string(alarms.get(ID).unwrap()).unwrap()];
        let until = |it: &Alarms| it.get(ID).unwrap().shelved.as_ref().unwrap().until_ms;
        let mut again = Alarms::restored(5000, &written, &["M1".to_owned()].into());
        assert_eq!(until(&again), 5000 + most_ms);
        again.stepped(now_ms, i64::try_from(now_ms - 5000).unwrap());
        assert_eq!(until(&again), now_ms + most_ms);
        // Nor does a step that is longer than the time that has passed.
        alarms.stepped(now_ms, i64::try_from(most_ms * 100).unwrap());
        assert_eq!(until(&alarms), now_ms + most_ms);
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
        assert_eq!(alarms.get("M1/Link/Stale").unwrap().state, State::Unack);
        for at in [30_000, 33_000] {
            alarms.observe(at, "M1", &status(OVERLOAD), true);
        }
        assert_eq!(alarms.get("M1/Link/Down").unwrap().state, State::RtnUnack);
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
        assert_eq!(see(&mut alarms, 1000, 0), [(None, Some(State::Unack))]);
        let alarm = alarms.get(id).unwrap();
        assert_eq!(alarm.priority, Priority::Medium);
        assert!(alarm.remedy.en.contains("MoveHold") && alarm.remedy.ru.contains("MoveHold"));
        // After a restart it stays until it is known whether it holds.
        let written = [serde_json::to_string(alarms.get(id).unwrap()).unwrap()];
        let mut again = Alarms::restored(1000, &written, &["M1".to_owned()].into());
        let seen = [5000, 9000].map(|at| see(&mut again, at, 0).len());
        assert_eq!((seen, again.get(id).unwrap().active), ([0, 0], true));
        again.holding("M1").set_hold(true);
        see(&mut again, 10_000, 0);
        assert_eq!(see(&mut again, 13_000, 0), [(Some(State::Unack), Some(State::RtnUnack))]);
        alarms.forget("M1");
        assert!(alarms.get(id).is_none() && alarms.holdings.is_empty());
    }

    #[test]
    fn a_log_that_is_not_stored_is_an_alarm() {
        let mut alarms = Alarms::default();
        assert_eq!(
            alarms.handle_time(0, Conditions { audit: true, ..Conditions::default() })[0].after,
            Some(State::Unack)
        );
        alarms.handle_time(1, Conditions::default());
        assert_eq!(
            alarms.handle_time(3_000, Conditions::default())[0].after,
            Some(State::RtnUnack)
        );
    }

    #[test]
    fn events_that_are_not_stored_are_an_alarm() {
        let mut alarms = Alarms::default();
        alarms.handle_time(0, Conditions { events: true, ..Conditions::default() });
        let alarm = alarms.get("hub/Events").unwrap();
        assert!(alarm.what.ru.contains("событий") && alarm.remedy.en.contains("events.db"));
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
        let mut again = Alarms::restored(6, &before, &BTreeSet::new());
        assert_eq!(written(&again), before);
        assert!(again.handle_time(7, both).is_empty(), "nothing is new");
        assert_eq!(again.get("hub/History").unwrap().state, State::Shelved);
        again.handle_time(500, both);
        assert_eq!(again.get("hub/History").unwrap().state, State::Unack);

        let gone = before[0].replace(r#""monitor":"""#, r#""monitor":"M9""#);
        let junk = ["{}".into(), gone];
        let monitors = BTreeSet::from(["M1".into()]);
        assert!(Alarms::restored(6, &junk, &monitors).list().is_empty());
    }
}
