//! What has changed, written once for all clients that look at the same: clients are many, changes
//! are the same.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::extract::ws::Utf8Bytes;
use tokio::sync::watch;
use tokio::time::{Instant, sleep_until};

use crate::hub::Hub;
use crate::publish::messages::{Message, Published};
use crate::publish::topics::{Audience, Change, News};
use crate::sync::lock;

/// Changes are not sent more often.
const EVERY: Duration = Duration::from_millis(50);
/// At least this often, so that clients can show ages. News of monitors that a client does not look
/// at are sent so often,
const AT_LEAST: Duration = Duration::from_secs(1);
/// and are so many bytes at a time; the rest follows.
const NEWS_BYTES: usize = 20 * 1024;
/// The first message is so large at most, and each piece of what one client has missed.
const STATE_BYTES: usize = 256 * 1024;
const PIECE_BYTES: usize = 64 * 1024;

/// How far a client is up to date.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// Version of the topics.
    pub version: u64,
    /// Version up to which it has heard the news of monitors that it does not look at.
    pub news: News,
}

impl Seen {
    /// Whether it has all news that another one has.
    pub fn has_news_of(&self, other: &Self) -> bool {
        self.news.iter().zip(&other.news).all(|(own, other)| own >= other)
    }

    /// With what another one has seen.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        let news = std::array::from_fn(|kind| self.news[kind].max(other.news[kind]));
        Self { version: self.version.max(other.version), news }
    }
}

/// The text of a change between two versions of the topics.
#[derive(Clone, Debug, Default)]
pub struct Shared {
    /// Who has seen this …
    pub from: Seen,
    /// … has seen this after it.
    pub to: Seen,
    /// The message, empty if there is nothing to say; `None`: it was not written.
    pub text: Option<Utf8Bytes>,
}

/// The clients by what they look at. Those that look at the same share what is written for them.
#[derive(Debug, Default)]
pub struct Audiences {
    all: Mutex<HashMap<Audience, watch::Sender<Arc<Shared>>>>,
}

impl Audiences {
    /// What is written for an audience from now on.
    pub fn join(&self, audience: &Audience) -> watch::Receiver<Arc<Shared>> {
        lock(&self.all).entry(audience.clone()).or_default().subscribe()
    }
}

fn text(hub: &Hub, kind: fn(Published) -> Message, change: Change) -> Utf8Bytes {
    kind(Published { now_ms: hub.clock().now_ms(), up_ms: hub.up_ms(), change }).written()
}

/// What is sent to one client alone, piece by piece as it takes them: everything at first, and later
/// what it has missed, or begins to look at.
#[derive(Debug, Default)]
pub struct Own {
    /// How far the client is up to date.
    pub seen: Seen,
    /// Whether pieces are left.
    pub behind: bool,
    /// The version with which it has everything that was there when it came.
    whole: u64,
    /// Monitors that it begins to look at, whose values it has not been sent yet.
    monitors: VecDeque<String>,
}

impl Own {
    /// The message with everything, or the first piece of it.
    pub fn state(&mut self, hub: &Hub) -> Utf8Bytes {
        self.whole = *hub.topics().version().borrow();
        let mut change = self.missed(hub, &Audience::default(), STATE_BYTES);
        change.gone.clear();
        text(hub, Message::State, change)
    }

    /// Whether it has everything that was there when it came.
    pub const fn is_whole(&self) -> bool {
        self.seen.version >= self.whole
    }

    /// It begins to look at something else.
    pub fn turn(&mut self, hub: &Hub, audience: &Audience) {
        let all = || hub.stations().iter().map(|it| it.id().to_owned()).collect();
        self.monitors = audience.0.as_ref().map_or_else(all, |it| it.iter().cloned().collect());
        self.behind = true;
    }

    /// The next piece of what the client has missed.
    pub fn piece(&mut self, hub: &Hub, audience: &Audience) -> Utf8Bytes {
        let mut change = self.missed(hub, audience, PIECE_BYTES);
        let size = |change: &Change| -> usize {
            change.set.iter().map(|(name, value)| name.len() + value.get().len()).sum()
        };
        let mut bytes = size(&change);
        while bytes < PIECE_BYTES
            && let Some(monitor) = self.monitors.pop_front()
        {
            let live = hub.topics().live_of(&monitor);
            bytes += size(&live);
            change.set.extend(live.set);
        }
        self.behind |= !self.monitors.is_empty();
        text(hub, Message::Change, change)
    }

    fn missed(&mut self, hub: &Hub, audience: &Audience, bytes_max: usize) -> Change {
        let Seen { version, news } = self.seen;
        let seen = (version, news);
        let ((version, news), change, told) = hub.topics().missed(seen, audience, bytes_max);
        (self.seen, self.behind) = (Seen { version, news }, !told);
        change
    }
}

/// Writes each change until the hub ends.
pub async fn run(hub: Hub) {
    let mut version = hub.topics().version();
    let mut shutdown = hub.shutdown();
    let now = *version.borrow();
    let (mut last, mut last_news) = (Instant::now(), Instant::now());
    let mut from = Seen { version: now, news: [now; 2] };
    loop {
        let dirty = *version.borrow_and_update() != from.version;
        let next = last + if dirty { EVERY } else { AT_LEAST };
        tokio::select! {
            () = sleep_until(next) => {
                last = Instant::now();
                let due = last_news + AT_LEAST <= last;
                if due {
                    last_news = last;
                }
                from = write(&hub, from, due);
            }
            Ok(()) = version.changed(), if !dirty => {}
            () = shutdown.requested() => return,
        }
    }
}

/// Writes what is new for each audience; `due`: the news, and a word even if there is nothing.
fn write(hub: &Hub, from: Seen, due: bool) -> Seen {
    let mut all = lock(&hub.audiences().all);
    // A client that begins to look at what no client looks at is sent what it misses.
    all.retain(|_, changes| changes.receiver_count() > 0);
    if all.is_empty() {
        let version = *hub.topics().version().borrow();
        return Seen { version, news: [version; 2] };
    }
    let (version, changed) = hub.topics().since(from.version);
    let (news, brief) = match due {
        true => hub.topics().news(from.news, NEWS_BYTES),
        false => (from.news, Change::default()),
    };
    let to = Seen { version, news };
    for (audience, changes) in all.iter() {
        let mut change = changed.of(audience);
        let others = |name: &&String| !audience.wants(name);
        let set = brief.set.iter().filter(|(name, _)| others(name));
        change.set.extend(set.map(|(name, value)| (name.clone(), value.clone())));
        change.gone.extend(brief.gone.iter().filter(others).cloned());
        let said = match due || !change.is_empty() {
            true => text(hub, Message::Change, change),
            false => Utf8Bytes::default(),
        };
        changes.send_replace(Arc::new(Shared { from, to, text: Some(said) }));
    }
    to
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use serde_json::{Value, json};

    use super::*;
    use crate::{Clock, Config};

    /// A client that comes to a large site: each message waits until the one before is taken.
    #[tokio::test]
    async fn a_large_site_is_sent_in_pieces() {
        let hub = Hub::new(Config::default(), Clock::System, json!({})).unwrap();
        for id in 1..=100 {
            for part in ["status", "params", "link", "info"] {
                hub.topics().set(&format!("monitors/M{id}/{part}"), &"x".repeat(5000));
            }
        }
        let (mut own, everything) = (Own::default(), Audience::default());
        let first = own.state(&hub);
        assert!(first.starts_with("{\"type\":\"state\"") && own.behind, "{}", first.len());
        assert!((200_000..270_000).contains(&first.len()), "{}", first.len());
        let (mut all, mut pieces) = (BTreeSet::new(), vec![first]);
        while own.behind {
            pieces.push(own.piece(&hub, &everything));
        }
        assert!(own.is_whole());
        for (number, piece) in pieces.iter().enumerate() {
            assert!(number == 0 || piece.len() < 75_000, "{}", piece.len());
            let message: Value = serde_json::from_str(piece).unwrap();
            all.extend(message["set"].as_object().unwrap().keys().cloned());
        }
        assert_eq!(all.iter().filter(|it| it.starts_with("monitors/")).count(), 400);
        // Of what it begins to look at, it is sent the values, in pieces as well.
        let looks = Audience(Some((1..=30).map(|id| format!("M{id}")).collect()));
        own.turn(&hub, &looks);
        let mut values = BTreeSet::new();
        while own.behind {
            let piece = own.piece(&hub, &looks);
            assert!(piece.len() < 85_000, "{}", piece.len());
            let message: Value = serde_json::from_str(&piece).unwrap();
            values.extend(message["set"].as_object().unwrap().keys().cloned());
        }
        assert_eq!(values.len(), 30 * 3, "info is no topic that changes all the time");
    }
}
