//! What the hub publishes: JSON by topic, of which the latest value wins.
//!
//! Nobody queues values. A reader remembers the version that it has seen, and is given the topics
//! that are newer, as they are now: who is slow gets fewer values, and costs nobody anything.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Bound;
use std::sync::{Arc, Mutex};

use serde::Serialize;
use serde_json::value::{RawValue, to_raw_value};
use tokio::sync::watch;

use crate::sync::lock;

/// The published values.
#[derive(Debug)]
pub struct Topics {
    all: Mutex<All>,
    version: watch::Sender<u64>,
}

/// The topics, and in which order they changed: what is new is found without looking at the rest.
#[derive(Debug, Default)]
struct All {
    topics: BTreeMap<String, Topic>,
    order: BTreeMap<u64, String>,
    /// Of topics that change all the time, when they changed in more than figures.
    news: BTreeMap<u64, String>,
}

/// A value, and when it became so.
#[derive(Clone, Debug)]
struct Topic {
    version: u64,
    /// When it last changed in more than figures.
    news: u64,
    /// `None`: it is gone. Kept, so that everybody hears of it; ids of topics are few.
    value: Option<Arc<RawValue>>,
}

/// Of which monitors a client is sent every change of what is large or changes all the time; of the
/// others it hears once a second what is more than figures. `None`: of all.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Audience(pub Option<BTreeSet<String>>);

/// Parts of a monitor that are large or change all the time, and that its own pages show.
const LIVE: [&str; 6] = ["status", "link", "params", "params_progress", "limits", "hotbeds"];

/// The monitor whose part a topic is, if that is one of these.
fn live(topic: &str) -> Option<&str> {
    let (monitor, part) = topic.strip_prefix("monitors/")?.rsplit_once('/')?;
    LIVE.contains(&part).then_some(monitor)
}

impl Audience {
    /// Whether every change of a topic is sent.
    fn wants(&self, topic: &str) -> bool {
        match (&self.0, live(topic)) {
            (Some(monitors), Some(monitor)) => monitors.contains(monitor),
            _ => true,
        }
    }
}

/// What is new, sorted by who wants it.
#[derive(Debug, Default)]
pub struct Changed {
    common: Change,
    live: BTreeMap<String, Change>,
}

impl Changed {
    /// What of it an audience is sent.
    pub fn of(&self, audience: &Audience) -> Change {
        let mut change = self.common.clone();
        let mut add = |live: &Change| {
            change.set.extend(live.set.iter().map(|(name, value)| (name.clone(), value.clone())));
            change.gone.extend(live.gone.iter().cloned());
        };
        match &audience.0 {
            None => self.live.values().for_each(add),
            Some(monitors) => monitors.iter().filter_map(|it| self.live.get(it)).for_each(&mut add),
        }
        change
    }
}

/// What is new: topics with their values, and those that are gone.
#[derive(Clone, Debug, Default, Serialize)]
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
        self.set_live(name, value, true);
    }

    /// As [`Topics::set`]; unless it is `news`, who does not look at this monitor need not hear.
    pub fn set_live(&self, name: &str, value: &impl Serialize, news: bool) {
        let Ok(value) = to_raw_value(value) else { return };
        let mut all = lock(&self.all);
        let same = all
            .topics
            .get(name)
            .and_then(|topic| topic.value.as_ref())
            .is_some_and(|old| old.get() == value.get());
        if !same {
            self.put(&mut all, name, Some(value.into()), news);
        }
    }

    /// Takes a topic away.
    pub fn remove(&self, name: &str) {
        let mut all = lock(&self.all);
        if all.topics.get(name).is_some_and(|topic| topic.value.is_some()) {
            self.put(&mut all, name, None, true);
        }
    }

    /// The value of a topic.
    pub fn get(&self, name: &str) -> Option<Arc<RawValue>> {
        lock(&self.all).topics.get(name).and_then(|topic| topic.value.clone())
    }

    /// The version, now and whenever it grows.
    pub fn version(&self) -> watch::Receiver<u64> {
        self.version.subscribe()
    }

    /// What is newer than a version, and the version that this is.
    pub fn since(&self, version: u64) -> (u64, Changed) {
        let all = lock(&self.all);
        let mut changed = Changed::default();
        for name in all.order.range(after(version)).map(|(_, name)| name) {
            let change = match live(name) {
                Some(monitor) => changed.live.entry(monitor.to_owned()).or_default(),
                None => &mut changed.common,
            };
            all.tell(name, change);
        }
        (*self.version.borrow(), changed)
    }

    /// News of topics that change all the time, newer than a version, the oldest first until they
    /// have so many bytes; and how far they go.
    pub fn news(&self, mut version: u64, bytes_max: usize) -> (u64, Change) {
        let all = lock(&self.all);
        let (mut change, mut bytes) = (Change::default(), 0);
        for (news, name) in all.news.range(after(version)) {
            let value = all.topics.get(name).and_then(|topic| topic.value.as_ref());
            bytes += name.len() + value.map_or(0, |value| value.get().len());
            if bytes > bytes_max && !change.is_empty() {
                return (version, change);
            }
            version = *news;
            all.tell(name, &mut change);
        }
        (*self.version.borrow(), change)
    }

    /// What an audience that has seen a version, and news up to another one, has to be sent.
    pub fn missed(&self, version: u64, news: u64, audience: &Audience) -> (u64, Change) {
        let (to, changed) = self.since(version);
        let mut change = changed.of(audience);
        let (_, mut rest) = self.news(news, usize::MAX);
        rest.set.append(&mut change.set);
        rest.gone.append(&mut change.gone);
        (to, rest)
    }

    /// The values of what changes all the time and an audience is sent every change of.
    pub fn live_of(&self, audience: &Audience) -> Change {
        let all = lock(&self.all);
        let mut change = Change::default();
        for name in all.topics.keys().filter(|it| live(it).is_some() && audience.wants(it)) {
            all.tell(name, &mut change);
        }
        change
    }

    fn put(&self, all: &mut All, name: &str, value: Option<Arc<RawValue>>, news: bool) {
        // Counted under the lock: a reader never sees a version before its value.
        let version = *self.version.borrow() + 1;
        let old = all.topics.get(name).map(|topic| (topic.version, topic.news));
        if let Some((old, _)) = old {
            all.order.remove(&old);
        }
        all.order.insert(version, name.to_owned());
        let mut told = old.map_or(0, |(_, news)| news);
        if live(name).is_some() && news {
            all.news.remove(&told);
            all.news.insert(version, name.to_owned());
            told = version;
        }
        all.topics.insert(name.to_owned(), Topic { version, news: told, value });
        self.version.send_replace(version);
    }
}

/// Versions after one.
const fn after(version: u64) -> (Bound<u64>, Bound<u64>) {
    (Bound::Excluded(version), Bound::Unbounded)
}

impl All {
    /// What a topic is now.
    fn tell(&self, name: &str, change: &mut Change) {
        match self.topics.get(name).and_then(|topic| topic.value.as_ref()) {
            Some(value) => _ = change.set.insert(name.to_owned(), value.clone()),
            None => change.gone.push(name.to_owned()),
        }
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
        let everything = Audience::default();
        let (version, changed) = topics.since(0);
        let change = changed.of(&everything);
        assert_eq!(change.set.len(), 2);
        assert_eq!(change.set["a"].get(), "99");
        topics.set("b", &"x");
        assert_eq!(topics.since(version).0, version, "the same value is nothing new");
        topics.remove("b");
        let change = topics.since(version).1.of(&everything);
        assert_eq!((change.set.len(), &change.gone[..]), (0, &["b".to_owned()][..]));
        assert!(topics.get("b").is_none());
    }

    #[test]
    fn of_what_is_not_looked_at_only_news_are_sent_in_bounded_pieces() {
        let topics = Topics::default();
        let one = Audience(Some(["M1".to_owned()].into()));
        for id in 1..=100 {
            topics.set(&format!("monitors/M{id}/status"), &format!("{id:0>1000}"));
        }
        let (version, _) = topics.since(0);
        for id in 1..=100 {
            topics.set_live(&format!("monitors/M{id}/status"), &id, false);
        }
        topics.set("alarms/M7/x", &1);
        let (_, changed) = topics.since(version);
        let names: Vec<_> = changed.of(&one).set.into_keys().collect();
        assert_eq!(names, ["alarms/M7/x", "monitors/M1/status"]);
        assert_eq!(changed.of(&Audience::default()).set.len(), 101);
        assert!(topics.news(version, 9000).1.is_empty(), "figures are no news");
        for id in (1..=100).rev() {
            topics.set_live(&format!("monitors/M{id}/status"), &"x".repeat(1000), true);
        }
        let (mut news, mut all, mut pieces) = (version, BTreeSet::new(), 0);
        loop {
            let (to, change) = topics.news(news, 9000);
            if change.is_empty() {
                break;
            }
            assert!(change.set.len() <= 9);
            assert!(pieces > 0 || change.set.contains_key("monitors/M100/status"), "oldest first");
            all.extend(change.set.into_keys());
            (news, pieces) = (to, pieces + 1);
        }
        assert_eq!((all.len(), pieces), (100, 13));
        let (_, missed) = topics.missed(version, version, &one);
        assert_eq!(missed.set.len(), 101, "who is behind is sent all of it");
    }
}
