//! What users do with alarms: the same from a console, from a program and through a plug.

use serde::Serialize;

use crate::control::authority::REASON_MAX;
use crate::hub::{Caller, Hub};
use crate::store::Act;

/// What a user has written of an alarm that was acknowledged, or of any.
#[derive(Debug, Serialize)]
struct Commented<'a> {
    comment: &'a str,
}

/// For how long and why an alarm is shelved.
#[derive(Debug, Serialize)]
struct Shelved<'a> {
    minutes: u64,
    reason: &'a str,
}

/// Whether it can be noted as a reason or a comment: not every base stores all characters, and a log shows some badly.
pub fn are_words(text: &str) -> bool {
    text.chars().count() <= REASON_MAX && !text.chars().any(char::is_control)
}

impl Hub {
    /// Acknowledges alarms; without a list, all. How many were.
    pub fn acknowledge_alarms(
        &self,
        caller: &Caller,
        ids: Option<Vec<String>>,
        comment: &str,
    ) -> usize {
        let (now_ms, user) = (self.clock().now_ms(), &caller.principal.user);
        let changes: Vec<_> = {
            let mut alarms = self.alarms();
            let ids = ids.unwrap_or_else(|| alarms.unacknowledged());
            ids.iter().filter_map(|id| alarms.acknowledge(now_ms, id, user)).collect()
        };
        for change in &changes {
            let what = format!("acknowledge {}", change.id);
            let act = Act::Acknowledge { alarm: change.id.clone() };
            let mut record = self.record(caller, &change.monitor, &what, "Ok");
            if !comment.is_empty() {
                record = record.with(&Commented { comment });
            }
            drop(self.audit().note(record.about(&act)));
        }
        let count = changes.len();
        self.publish_alarms(changes);
        count
    }

    /// Notes what a user has written of an alarm.
    pub fn comment_alarm(&self, caller: &Caller, (id, monitor): (&str, &str), comment: &str) {
        let record = self.record(caller, monitor, &format!("comment {id}"), "Ok");
        drop(self.audit().note(record.with(&Commented { comment })));
    }

    /// Puts an alarm on the shelf; `false`: there is none.
    pub fn shelve_alarm(&self, caller: &Caller, id: &str, minutes: u64, reason: &str) -> bool {
        let until_ms = self.clock().now_ms() + minutes * 60_000;
        let change = self.alarms().shelve(id, &caller.principal.user, until_ms, reason);
        let Some(change) = change else { return false };
        let record = self.record(caller, &change.monitor, &format!("shelve {id}"), "Ok");
        let record = record.with(&Shelved { minutes, reason });
        let act = Act::Shelve { alarm: id.to_owned(), minutes, reason: reason.into() };
        drop(self.audit().note(record.about(&act)));
        self.publish_alarms(vec![change]);
        true
    }

    /// Ends the shelving of an alarm; `false`: there is none.
    pub fn unshelve_alarm(&self, caller: &Caller, id: &str) -> bool {
        let change = self.alarms().unshelve(id, Some(&caller.principal.user));
        let Some(change) = change else { return false };
        let record = self.record(caller, &change.monitor, &format!("unshelve {id}"), "Ok");
        drop(self.audit().note(record.about(&Act::Unshelve { alarm: id.to_owned() })));
        self.publish_alarms(vec![change]);
        true
    }
}
