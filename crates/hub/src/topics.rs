//! What the hub publishes: JSON by topic, of which the latest value wins.
//!
//! Nobody queues values. A reader remembers the version that it has seen, and is given the topics
//! that are newer, as they are now: who is slow gets fewer values, and costs nobody anything.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use serde::Serialize;
use serde_json::value::{RawValue, to_raw_value};
use tokio::sync::watch;

use crate::sync::lock;

/// The published values.
#[derive(Debug)]
pub struct Topics {
    all: Mutex<BTreeMap<String, Topic>>,
    version: watch::Sender<u64>,
}

/// A value, and when it became so.
#[derive(Clone, Debug)]
struct Topic {
    version: u64,
    /// `None`: it is gone. Kept, so that everybody hears of it; ids of topics are few.
    value: Option<Arc<RawValue>>,
}

/// What is new: topics with their values, and those that are gone.
#[derive(Debug, Default, Serialize)]
pub struct Change {
    /// New values.
    pub set: BTreeMap<String, Arc<RawValue>>,
    /// Topics that are gone.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gone: Vec<String>,
}

impl Default for Topics {
    fn default() -> Self {
        Self { all: Mutex::default(), version: watch::Sender::new(0) }
    }
}

impl Topics {
    /// Publishes a value, if it is another one than before.
    pub fn set(&self, name: &str, value: &impl Serialize) {
        let Ok(value) = to_raw_value(value) else { return };
        let mut all = lock(&self.all);
        let same = all
            .get(name)
            .and_then(|topic| topic.value.as_ref())
            .is_some_and(|old| old.get() == value.get());
        if !same {
            self.put(&mut all, name, Some(value.into()));
        }
    }

    /// Takes a topic away.
    pub fn remove(&self, name: &str) {
        let mut all = lock(&self.all);
        if all.get(name).is_some_and(|topic| topic.value.is_some()) {
            self.put(&mut all, name, None);
        }
    }

    /// The value of a topic.
    pub fn get(&self, name: &str) -> Option<Arc<RawValue>> {
        lock(&self.all).get(name).and_then(|topic| topic.value.clone())
    }

    /// The version, now and whenever it grows.
    pub fn version(&self) -> watch::Receiver<u64> {
        self.version.subscribe()
    }

    /// What is newer than a version, and the version that this is.
    pub fn since(&self, version: u64) -> (u64, Change) {
        let all = lock(&self.all);
        let mut change = Change::default();
        for (name, topic) in all.iter().filter(|(_, topic)| topic.version > version) {
            match &topic.value {
                Some(value) => _ = change.set.insert(name.clone(), value.clone()),
                None => change.gone.push(name.clone()),
            }
        }
        (*self.version.borrow(), change)
    }

    fn put(&self, all: &mut BTreeMap<String, Topic>, name: &str, value: Option<Arc<RawValue>>) {
        // Counted under the lock: a reader never sees a version before its value.
        let version = *self.version.borrow() + 1;
        all.insert(name.to_owned(), Topic { version, value });
        self.version.send_replace(version);
    }
}

impl Change {
    /// Nothing is new.
    pub fn is_empty(&self) -> bool {
        self.set.is_empty() && self.gone.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_value_wins_and_what_is_gone_is_told() {
        let topics = Topics::default();
        for value in 0..100 {
            topics.set("a", &value);
        }
        topics.set("b", &"x");
        let (version, change) = topics.since(0);
        assert_eq!(change.set.len(), 2);
        assert_eq!(change.set["a"].get(), "99");
        topics.set("b", &"x");
        assert_eq!(topics.since(version).0, version, "the same value is nothing new");
        topics.remove("b");
        let (_, change) = topics.since(version);
        assert_eq!((change.set.len(), &change.gone[..]), (0, &["b".to_owned()][..]));
        assert!(topics.get("b").is_none());
    }
}
