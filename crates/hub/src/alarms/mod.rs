//! Alarms after ISA-18.2 and IEC 62682: from the flags of the dictionary that warn, and the hub's own.

mod catalogue;
mod machine;

pub use machine::{Alarm, Alarms, Change};

use crate::hub::Hub;
use crate::sync::lock;

impl Hub {
    /// Publishes alarms that have changed, and keeps the history of them.
    pub fn publish_alarms(&self, changes: Vec<Change>) {
        if changes.is_empty() {
            return;
        }
        let now_ms = self.clock.now_ms();
        let alarms = lock(&self.alarms);
        for change in &changes {
            let topic = format!("alarms/{}", change.id);
            match alarms.get(&change.id) {
                Some(alarm) => self.topics.set(&topic, alarm),
                None => self.topics.remove(&topic),
            }
            let written = alarms.get(&change.id).and_then(|it| serde_json::to_string(it).ok());
            self.events.note_alarm(&change.id, written);
        }
        drop(alarms);
        self.events.flush();
        let history = lock(&self.history);
        for Change { id, monitor, before, after, user, reason } in changes {
            if before == after {
                continue;
            }
            tracing::info!(alarm = %id, before, after, user, "alarm");
            if before == "normal" && after == "unack" {
                self.recordings.alarm(now_ms, &monitor, &id);
            }
            let alarm = [id, monitor, before.to_owned(), after.to_owned()];
            history.alarm(now_ms, alarm, user, reason);
        }
    }
}
