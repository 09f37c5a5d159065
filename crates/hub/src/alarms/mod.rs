//! Alarms after ISA-18.2 and IEC 62682: from the flags of the dictionary that warn, and the hub's own.

mod acts;
mod alarm;
mod catalogue;
mod holding;
mod machine;
mod zones;

pub use acts::are_words;
pub use alarm::{Alarm, Fire, Priority, State};
pub use machine::{Alarms, Change, Conditions, SHELVE_MAX_MIN};

use crate::hub::Hub;
use crate::monitor::station::Station;
use crate::store::integrity::ChainWord;

impl Hub {
    /// Raises and clears the alarms of the hub itself.
    pub fn look_at_itself(&self) {
        let state = self.alarms().get("hub/State").map(|it| it.state);
        if state == Some(State::Ack) {
            self.integrity().known();
        }
        let conditions = Conditions {
            audit: self.audit().is_failing(),
            history: self.history().is_failing(),
            events: self.events().is_failing(),
            chain: self.integrity().chain().state == ChainWord::Broken,
            state: !self.integrity().losses().is_empty(),
            logins: self.logins().attack(self.now()),
            revocations: self.access().revocations_wait(),
            zones: self.zones_fail_to_be_stored(),
            disk: self.lacks_room(),
            recordings: self.recordings().is_failing(),
            certificate: self.certificate_ends(),
        };
        let zones = self.zones_view().ok().map(|it| it.state);
        let now_ms = self.clock().now_ms();
        let changes = {
            let mut alarms = self.alarms();
            let mut changes = alarms.handle_time(now_ms, conditions);
            changes.extend(alarms.zones(now_ms, zones.as_ref()));
            changes
        };
        self.publish_alarms(changes);
    }

    /// Raises and clears the alarms of a monitor.
    pub fn observe(&self, station: &Station) {
        let (now_ms, status) = (self.clock().now_ms(), station.status());
        let changes = self.alarms().observe(now_ms, station.id(), &status, station.is_up());
        self.publish_alarms(changes);
    }

    /// Publishes alarms that have changed, and keeps the history of them.
    pub fn publish_alarms(&self, changes: Vec<Change>) {
        if changes.is_empty() {
            return;
        }
        let now_ms = self.clock().now_ms();
        let alarms = self.alarms();
        for change in &changes {
            let topic = format!("alarms/{}", change.id);
            match alarms.get(&change.id) {
                Some(alarm) => self.topics().set(&topic, alarm),
                None => self.topics().remove(&topic),
            }
            let written = alarms.get(&change.id).and_then(|it| serde_json::to_string(it).ok());
            self.events().note_alarm(&change.id, written);
        }
        self.topics().set("fire", &alarms.fire());
        drop(alarms);
        self.events().flush();
        for change in changes.iter().filter(|it| it.before != it.after) {
            let Change { id, monitor, user, .. } = change;
            let (from, to) = (State::word(change.before), State::word(change.after));
            tracing::info!(alarm = %id, before = from, after = to, user, "alarm");
            if change.begins() {
                self.recordings().alarm(now_ms, monitor, id);
            }
        }
        // Nothing that may wait comes under this lock.
        let history = self.history();
        for Change { id, monitor, before, after, user, reason } in changes {
            if before == after {
                continue;
            }
            let (from, to) = (State::word(before), State::word(after));
            let alarm = [id, monitor, from.to_owned(), to.to_owned()];
            history.alarm(now_ms, alarm, user, reason);
        }
    }
}
