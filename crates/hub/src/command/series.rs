//! What a client says again and again to all monitors or to the zones: the audit log has the first time, and then how
//! often.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::time::Duration;

use lafet_client::RequestBuf;
use tokio::time::{Instant, sleep};

use super::urgent::{CALLERS_MAX, REPEATS_NOTED, Repeats};
use crate::hub::{Caller, Hub};
use crate::store::Record;
use crate::sync::lock;

/// A series ends when nothing more has come for this time.
const QUIET: Duration = Duration::from_millis(250);

/// What may be repeated, by session.
#[derive(Debug, Default)]
pub struct Series(Mutex<BTreeMap<Key, Repeated>>);

type Key = (Said, String);

/// What a client says.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Said {
    /// A request to all monitors.
    Request(RequestBuf),
    /// Abort of a zone.
    Abort(String),
    /// Lockout of the zones.
    Lockout,
}

/// How it is noted, and its repetitions so far.
#[derive(Debug)]
struct Repeated {
    record: Record,
    since: Instant,
    last: Instant,
    repeats: Repeats,
}

impl Series {
    /// Takes what a client says; whether it is the first time of its session. `noted`: how its repetitions are noted for a
    /// client.
    pub fn take(
        &self,
        hub: &Hub,
        caller: &Caller,
        said: Said,
        noted: impl Fn(&Caller) -> Record,
    ) -> bool {
        let (now_ms, now) = (hub.clock().now_ms(), Instant::now());
        let mut all = lock(&self.0);
        let mut key = (said, caller.seat.seat.clone());
        let full = all.len() >= CALLERS_MAX && !all.contains_key(&key);
        if full {
            key.1.clear();
        }
        if let Some(known) = all.get_mut(&key) {
            known.last = now;
            known.repeats.again(now_ms);
            return false;
        }
        let mut repeats = Repeats::default();
        let record = match full {
            true => noted(&Caller::hub()),
            false => noted(caller),
        };
        if full {
            repeats.again(now_ms);
        }
        all.insert(key.clone(), Repeated { record, since: now, last: now, repeats });
        tokio::spawn(watch_over(hub.clone(), key, now));
        !full
    }

    /// Ends all of them: what comes next is no repetition.
    pub fn end(&self, hub: &Hub) {
        let all = std::mem::take(&mut *lock(&self.0));
        all.into_values().for_each(|known| known.note(hub));
    }
}

impl Repeated {
    /// Writes the repetitions into the audit log.
    fn note(self, hub: &Hub) {
        if self.repeats.count > 0 {
            let record = Record { at_ms: hub.clock().now_ms(), ..self.record };
            drop(hub.audit().note(record.with(&self.repeats)));
        }
    }

    fn is_over(&self) -> bool {
        self.last.elapsed() >= QUIET || self.since.elapsed() >= REPEATS_NOTED
    }
}

/// Notes the repetitions of a series when it is over.
async fn watch_over(hub: Hub, key: Key, since: Instant) {
    loop {
        sleep(QUIET).await;
        let mut all = lock(&hub.urgent_series().0);
        match all.get(&key).filter(|known| known.since == since) {
            None => return,
            Some(known) if !known.is_over() => {}
            Some(_) => {
                let known = all.remove(&key);
                drop(all);
                return known.into_iter().for_each(|it| it.note(&hub));
            }
        }
    }
}
