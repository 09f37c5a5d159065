//! What the hub publishes: JSON by topic, of which the latest value wins.
//!
//! Values are not queued. A reader remembers the version that it has seen, and is given the topics
//! that are newer, as they are now: a slow reader gets fewer values, and holds up no other.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::Bound;
use std::sync::{Arc, Mutex, OnceLock};

use serde::Serialize;
use serde_json::value::{RawValue, to_raw_value};
use tokio::sync::watch;
use utoipa::ToSchema;

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
    /// Of topics of monitors, when they changed in more than figures: what people wait for, and the
    /// rest.
    news: [BTreeMap<u64, String>; 2],
}

/// Version up to which news were sent, of each kind.
pub type News = [u64; 2];

/// A value, and when it became so.
#[derive(Clone, Debug, Default)]
struct Topic {
    version: u64,
    /// When it last changed in more than figures.
    news: u64,
    /// `None`: removed. Kept, so that every reader learns of it; topics are few.
    value: Option<Published>,
}

/// A value, written when it is read first: most values are replaced before they are read.
#[derive(Clone)]
struct Published {
    text: OnceLock<Arc<RawValue>>,
    value: Arc<dyn Fn() -> Option<Arc<RawValue>> + Send + Sync>,
}

impl fmt::Debug for Published {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Published").field(&self.text()).finish()
    }
}

impl Published {
    fn written(text: Arc<RawValue>) -> Self {
        Self { text: text.into(), value: Arc::new(|| None) }
    }

    fn text(&self) -> Option<Arc<RawValue>> {
        if self.text.get().is_none() {
            _ = self.text.set((self.value)()?);
        }
        self.text.get().cloned()
    }
}

/// Of which monitors a client is sent every change; of the others it hears once a second what is
/// more than figures. `None`: of all.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Audience(pub Option<BTreeSet<String>>);

/// Parts of a monitor that people wait for, as they do for alarms: of who is not looked at, their
/// news go before those of
const FIRST: [&str; 4] = ["authority", "readiness", "program", "urgent"];
/// these parts.
const REST: [&str; 4] = ["link", "limits", "hotbeds", SUMMARY];
/// Parts that are sent only to who looks at the monitor.
const OWN: [&str; 4] = ["status", "params", "params_progress", "tune"];
/// What others than its own pages show of the state of a monitor.
const SUMMARY: &str = "summary";

/// The monitor that a topic is of, and which of [`All::news`] its news are, if any; topics of no
/// monitor are sent to every client at once.
fn live(topic: &str) -> Option<(&str, usize)> {
    if let Some((monitor, _)) = topic.strip_prefix("alarms/").and_then(|id| id.split_once('/')) {
        return (monitor != "hub").then_some((monitor, 0));
    }
    let (monitor, part) = topic.strip_prefix("monitors/")?.rsplit_once('/')?;
    let kinds: [&[&str]; 3] = [&FIRST, &REST, &OWN];
    Some((monitor, kinds.iter().position(|kind| kind.contains(&part))?))
}

impl Audience {
    /// Whether every change of a topic is sent.
    pub fn wants(&self, topic: &str) -> bool {
        match (&self.0, live(topic)) {
            (Some(monitors), Some((monitor, _))) => monitors.contains(monitor),
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
#[derive(Clone, Debug, Default, Serialize, ToSchema)]
#[schema(as = TopicChange)]
pub struct Change {
    /// Values of the topics that have changed.
    #[schema(value_type = BTreeMap<String, Object>)]
    pub set: BTreeMap<String, Arc<RawValue>>,
    /// Names of the topics that were removed.
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
        if all.text(name).is_none_or(|old| old.get() != value.get()) {
            self.put(&mut all, name, Some(Published::written(value.into())), true);
        }
    }

    /// Publishes what changes all the time, and is written only if a client reads it before it
    /// changes again. Unless it is `news`, who does not look at this monitor need not hear.
    pub fn set_live(&self, name: &str, value: impl Serialize + Send + Sync + 'static, news: bool) {
        let value = Arc::new(move || to_raw_value(&value).ok().map(Arc::from));
        let value = Published { text: OnceLock::new(), value };
        self.put(&mut lock(&self.all), name, Some(value), news);
    }

    /// Removes a topic.
    pub fn remove(&self, name: &str) {
        let mut all = lock(&self.all);
        if all.topics.get(name).is_some_and(|topic| topic.value.is_some()) {
            self.put(&mut all, name, None, true);
        }
    }

    /// The value of a topic.
    pub fn get(&self, name: &str) -> Option<Arc<RawValue>> {
        lock(&self.all).text(name)
    }

    /// The version, now and whenever it grows.
    pub fn version(&self) -> watch::Receiver<u64> {
        self.version.subscribe()
    }

    /// What is newer than a version, and the version that this is.
    pub fn since(&self, version: u64) -> (u64, Changed) {
        let all = lock(&self.all);
        let mut changed = Changed::default();
        let new = all.order.range(after(version)).map(|(_, name)| name);
        for name in new.filter(|name| !name.ends_with(SUMMARY)) {
            let change = match live(name) {
                Some((monitor, _)) => changed.live.entry(monitor.to_owned()).or_default(),
                None => &mut changed.common,
            };
            all.tell(name, change);
        }
        (*self.version.borrow(), changed)
    }

    /// News of monitors, newer than versions: what people wait for, then the rest, of each the
    /// oldest first until they have so many bytes; and how far they go.
    pub fn news(&self, seen: News, bytes_max: usize) -> (News, Change) {
        let all = lock(&self.all);
        let mut piece = Piece::new(bytes_max);
        let (seen, _) = all.news(seen, &mut piece, |_| true);
        (seen, piece.change)
    }

    /// What an audience that has seen a version, and news up to others, is to be sent next: the
    /// oldest first, until it has so many bytes; how far that goes, and whether it is all.
    pub fn missed(
        &self,
        (mut version, news): (u64, News),
        audience: &Audience,
        bytes_max: usize,
    ) -> ((u64, News), Change, bool) {
        let all = lock(&self.all);
        let mut piece = Piece::new(bytes_max);
        for (at, name) in all.order.range(after(version)) {
            let wanted = audience.wants(name) && !name.ends_with(SUMMARY);
            if wanted && !piece.add(&all, name) {
                return ((version, news), piece.change, false);
            }
            version = *at;
        }
        let (news, told) = all.news(news, &mut piece, |name| !audience.wants(name));
        let now = *self.version.borrow();
        let news = if told { [now; 2] } else { news };
        ((now, news), piece.change, told)
    }

    /// The values of what changes all the time of a monitor.
    pub fn live_of(&self, monitor: &str) -> Change {
        let all = lock(&self.all);
        let mut change = Change::default();
        let wanted = |name: &&String| {
            live(name).is_some_and(|(of, _)| of == monitor) && !name.ends_with(SUMMARY)
        };
        // A large site has thousands of others: their names are not looked at.
        for begin in [format!("alarms/{monitor}/"), format!("monitors/{monitor}/")] {
            let from = (Bound::Included(begin.as_str()), Bound::Unbounded);
            let names = all.topics.range::<str, _>(from).map(|(name, _)| name);
            let own = names.take_while(|name| name.starts_with(&begin));
            own.filter(wanted).for_each(|name| all.tell(name, &mut change));
        }
        change
    }

    fn put(&self, all: &mut All, name: &str, value: Option<Published>, news: bool) {
        // Counted under the lock: a reader never sees a version before its value.
        let version = *self.version.borrow() + 1;
        let All { topics, order, news: all_news } = all;
        // That a part is gone is news of every part.
        let told = |kind: usize| if value.is_none() { kind.min(1) } else { kind };
        let kind = live(name).filter(|_| news).map(|(_, kind)| told(kind));
        let kind = kind.and_then(|kind| all_news.get_mut(kind));
        let topic = match topics.get_mut(name) {
            Some(topic) => topic,
            None => topics.entry(name.to_owned()).or_default(),
        };
        topic.value = value;
        move_to(order, &mut topic.version, version, name);
        if let Some(kind) = kind {
            move_to(kind, &mut topic.news, version, name);
        }
        self.version.send_replace(version);
    }
}

/// Puts a name at the end of an order.
fn move_to(order: &mut BTreeMap<u64, String>, at: &mut u64, version: u64, name: &str) {
    let known = order.remove(&std::mem::replace(at, version));
    order.insert(version, known.unwrap_or_else(|| name.to_owned()));
}

/// The range of versions after this one.
const fn after(version: u64) -> (Bound<u64>, Bound<u64>) {
    (Bound::Excluded(version), Bound::Unbounded)
}

impl All {
    fn text(&self, name: &str) -> Option<Arc<RawValue>> {
        self.topics.get(name)?.value.as_ref()?.text()
    }

    /// Adds news to a piece; how far they go then, and whether that is all of them.
    fn news(
        &self,
        mut seen: News,
        piece: &mut Piece,
        wanted: impl Fn(&str) -> bool,
    ) -> (News, bool) {
        let mut told = true;
        for (news, seen) in self.news.iter().zip(&mut seen) {
            for (version, name) in news.range(after(*seen)) {
                if wanted(name) && !piece.add(self, name) {
                    told = false;
                    break;
                }
                *seen = *version;
            }
        }
        (seen, told)
    }

    /// What a topic is now.
    fn tell(&self, name: &str, change: &mut Change) {
        match self.text(name) {
            Some(value) => _ = change.set.insert(name.to_owned(), value),
            None => change.gone.push(name.to_owned()),
        }
    }
}

/// A change of so many bytes at most; a larger topic comes alone.
struct Piece {
    change: Change,
    left: usize,
}

impl Piece {
    fn new(bytes_max: usize) -> Self {
        Self { change: Change::default(), left: bytes_max }
    }

    /// Whether there was room for a topic.
    fn add(&mut self, all: &All, name: &str) -> bool {
        let bytes = name.len() + all.text(name).map_or(0, |value| value.get().len());
        if bytes > self.left && !self.change.is_empty() {
            return false;
        }
        self.left = self.left.saturating_sub(bytes);
        all.tell(name, &mut self.change);
        true
    }
}

impl Change {
    /// Whether nothing has changed.
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
            topics.set(&format!("monitors/M{id}/link"), &format!("{id:0>1000}"));
        }
        let (version, _) = topics.since(0);
        for id in 1..=100 {
            topics.set_live(&format!("monitors/M{id}/link"), id, false);
        }
        topics.set("alarms/hub/x", &1);
        let (_, changed) = topics.since(version);
        let names: Vec<_> = changed.of(&one).set.into_keys().collect();
        assert_eq!(names, ["alarms/hub/x", "monitors/M1/link"]);
        assert_eq!(changed.of(&Audience::default()).set.len(), 101);
        assert!(topics.news([version; 2], 9000).1.is_empty(), "figures are no news");
        for id in (1..=100).rev() {
            topics.set_live(&format!("monitors/M{id}/link"), "x".repeat(1000), true);
        }
        let (mut news, mut all, mut pieces) = ([version; 2], BTreeSet::new(), 0);
        loop {
            let (to, change) = topics.news(news, 9000);
            if change.is_empty() {
                break;
            }
            assert!(change.set.len() <= 9);
            assert!(pieces > 0 || change.set.contains_key("monitors/M100/link"), "oldest first");
            all.extend(change.set.into_keys());
            (news, pieces) = (to, pieces + 1);
        }
        assert_eq!((all.len(), pieces), (100, 13));
        let (_, missed, _) = topics.missed((version, [version; 2]), &one, usize::MAX);
        assert_eq!(missed.set.len(), 101, "who is behind is sent all of it");
    }

    #[test]
    fn who_is_behind_is_sent_pieces_and_in_the_end_has_everything() {
        let topics = Topics::default();
        let one = Audience(Some(["M1".to_owned()].into()));
        let set = |id: u32, part: &str, text: &str| {
            topics.set(&format!("monitors/M{id}/{part}"), &text.repeat(1000));
        };
        for id in 1..=100 {
            set(id, "link", "x");
            set(id, "status", "x");
            topics.set(&format!("alarms/hub/{id}"), &"x".repeat(1000));
        }
        topics.set("monitors/M1/params", &"x".repeat(20_000));
        for (audience, count) in [(Audience::default(), 301), (one, 100 + 3 + 99)] {
            let (mut seen, mut has, mut sizes) = ((0, [0; 2]), BTreeMap::new(), Vec::new());
            let (mut round, mut all) = (0, false);
            while !all {
                let (to, change, told) = topics.missed(seen, &audience, 9000);
                let bytes = change.set.iter().map(|(name, value)| name.len() + value.get().len());
                sizes.push(bytes.sum::<usize>());
                has.extend(change.set.into_iter().map(|(name, value)| (name, value.to_string())));
                (seen, round, all) = (to, round + 1, told);
                // Meanwhile values change: there is no end of that, but of this there is.
                if round < 20 {
                    set(1, "link", &round.to_string());
                    set(2, "link", &round.to_string());
                }
            }
            assert!(sizes.iter().all(|it| *it <= 9000 || *it > 20_000), "{sizes:?}");
            assert_eq!(sizes.iter().filter(|it| **it > 20_000).count(), 1, "a large one is alone");
            assert_eq!(has.len(), count, "{:?}", audience.0);
            let now = |name: &String| topics.get(name).unwrap().to_string();
            assert!(has.iter().all(|(name, value)| now(name) == *value), "the latest wins");
        }
    }

    #[test]
    fn a_summary_is_for_who_does_not_see_all() {
        let topics = Topics::default();
        topics.set("monitors/M1/summary", &1);
        for audience in [Audience::default(), Audience(Some(["M1".to_owned()].into()))] {
            assert!(topics.since(0).1.of(&audience).is_empty());
            assert!(topics.live_of("M1").is_empty());
        }
        assert_eq!(topics.news([0; 2], 9000).1.set["monitors/M1/summary"].get(), "1");
    }

    #[test]
    fn of_other_monitors_all_is_bounded_and_alarms_come_first() {
        let (topics, one) = (Topics::default(), Audience(Some(["M1".to_owned()].into())));
        for id in 1..=100 {
            topics.set_live(&format!("monitors/M{id}/link"), "x".repeat(1000), true);
        }
        for id in 1..=100 {
            for topic in ["readiness", "authority", "program"] {
                topics.set(&format!("monitors/M{id}/{topic}"), &"x".repeat(300));
            }
            topics.set(&format!("alarms/M{id}/Link/Stale"), &"x".repeat(1000));
        }
        let (version, changed) = topics.since(0);
        let own = changed.of(&one).set;
        assert!(own.len() == 5 && own.keys().all(|name| name.contains("/M1/")), "{own:?}");
        let (mut news, mut order) = ([0; 2], Vec::new());
        while news.iter().max() < Some(&version) || order.len() < 500 {
            let (to, change) = topics.news(news, 9000);
            let bytes: usize = change.set.values().map(|value| value.get().len()).sum();
            assert!((1..=9000).contains(&bytes), "{bytes} bytes at a time");
            order.extend(change.set.into_keys());
            news = to;
        }
        let first_link = order.iter().position(|name| name.ends_with("link"));
        assert!(first_link >= Some(370), "what people wait for goes first: {first_link:?}");
        assert_eq!(order.len(), 500, "and nothing is sent twice");
    }
}
