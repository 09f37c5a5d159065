//! What has changed, written once for everybody: clients are many, changes are the same.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::Utf8Bytes;
use serde::Serialize;
use tokio::time::{Instant, sleep_until};

use crate::hub::Hub;
use crate::topics::Change;

/// Changes are not sent more often.
const EVERY: Duration = Duration::from_millis(50);
/// And not more seldom, so that ages can be told.
const AT_LEAST: Duration = Duration::from_secs(1);

/// The text of a change between two versions of the topics.
#[derive(Clone, Debug, Default)]
pub struct Shared {
    /// Who has seen this version …
    pub from: u64,
    /// … has seen this one after it.
    pub to: u64,
    /// The message.
    pub text: Utf8Bytes,
}

/// `state` and `change`.
#[derive(Serialize)]
struct Published {
    #[serde(rename = "type")]
    kind: &'static str,
    now_ms: u64,
    #[serde(flatten)]
    change: Change,
}

/// The message with everything, or what is newer than a version; and the version that it leads to.
pub fn since(hub: &Hub, version: u64) -> (u64, Utf8Bytes) {
    let (to, mut change) = hub.topics.since(version);
    let kind = if version == 0 { "state" } else { "change" };
    if version == 0 {
        change.gone.clear();
    }
    let published = Published { kind, now_ms: hub.clock.now_ms(), change };
    (to, serde_json::to_string(&published).unwrap_or_default().into())
}

/// Writes each change until the hub ends.
pub async fn run(hub: Hub) {
    let mut version = hub.topics.version();
    let mut ending = hub.ending.subscribe();
    let (mut last, mut from) = (Instant::now(), *version.borrow());
    loop {
        let dirty = *version.borrow_and_update() != from;
        let next = last + if dirty { EVERY } else { AT_LEAST };
        tokio::select! {
            () = sleep_until(next) => {
                last = Instant::now();
                // Nobody listens: who comes is given the whole state first.
                let (to, text) = match hub.changes.receiver_count() {
                    0 => (*version.borrow(), Utf8Bytes::default()),
                    _ => since(&hub, from.max(1)),
                };
                hub.changes.send_replace(Arc::new(Shared { from, to, text }));
                from = to;
            }
            Ok(()) = version.changed(), if !dirty => {}
            () = async { _ = ending.wait_for(|ending| *ending).await } => return,
        }
    }
}
