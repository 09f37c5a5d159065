//! What the hub puts into its logs.

use serde_json::{Map, Value};

use super::{Caller, Hub};
use crate::publish::messages::Message;
use crate::store::{Act, Record};
use crate::text::Both;
use crate::zones::ZONES;

impl Hub {
    /// Notes an event and sends it to every client.
    pub fn event(&self, monitor: Option<&str>, what: &Both) {
        tracing::info!(monitor, "{}", what.en);
        let at_ms = self.clock().now_ms();
        self.events().note(at_ms, monitor, what);
        let monitor = monitor.map(str::to_owned);
        self.send_to_all(&Message::Event { at_ms, monitor, what: what.clone() });
    }

    /// A record of an action for the audit log.
    pub fn record(&self, caller: &Caller, monitor: &str, what: &str, outcome: &str) -> Record {
        Record {
            at_ms: self.clock().now_ms(),
            user: caller.principal.user.clone(),
            role: caller.principal.role.name().to_owned(),
            from: caller.seat.from.clone(),
            via: caller.via.to_owned(),
            seat: caller.seat.seat.clone(),
            monitor: monitor.to_owned(),
            what: what.to_owned(),
            outcome: outcome.to_owned(),
            details: Value::Object(Map::new()),
            kind: (!matches!(caller.via, "hub" | ZONES)).then_some(caller.principal.kind),
            act: None,
        }
    }

    /// The record that the hub ends: the last one of an orderly end.
    pub fn record_of_end(&self) -> Record {
        self.record(&Caller::hub(), "", "end", "Ok").about(&Act::End)
    }
}
