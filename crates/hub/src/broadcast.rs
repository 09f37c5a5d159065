//! What has changed, written once for all clients that look at the same: clients are many, changes
//! are the same.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::extract::ws::Utf8Bytes;
use serde::Serialize;
use tokio::sync::watch;
use tokio::time::{Instant, sleep_until};

use crate::hub::Hub;
use crate::sync::lock;
use crate::topics::{Audience, Change, News};

/// Changes are not sent more often.
const EVERY: Duration = Duration::from_millis(50);
/// And not more seldom, so that ages can be told. News of monitors that a client does not look at
/// are sent so often,
const AT_LEAST: Duration = Duration::from_secs(1);
/// and are so many bytes at a time; the rest follows.
const NEWS_BYTES: usize = 20 * 1024;

/// How far a client has been told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// Version of the topics.
    pub version: u64,
    /// Version up to which it has heard the news of monitors that it does not look at.
    pub news: News,
}

impl Seen {
    /// Whether all news up to those of another one are told.
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

/// `state` and `change`.
#[derive(Serialize)]
struct Published {
    #[serde(rename = "type")]
    kind: &'static str,
    now_ms: u64,
    #[serde(flatten)]
    change: Change,
}

fn text(hub: &Hub, kind: &'static str, change: Change) -> Utf8Bytes {
    let published = Published { kind, now_ms: hub.clock.now_ms(), change };
    serde_json::to_string(&published).unwrap_or_default().into()
}

/// The message with everything.
pub fn state(hub: &Hub) -> (Seen, Utf8Bytes) {
    let (version, changed) = hub.topics.since(0);
    let mut change = changed.of(&Audience::default());
    change.gone.clear();
    (Seen { version, news: [version; 2] }, text(hub, "state", change))
}

/// The message with what a client of an audience has missed.
pub fn missed(hub: &Hub, seen: Seen, audience: &Audience) -> (Seen, Utf8Bytes) {
    let (version, change) = hub.topics.missed(seen.version, seen.news, audience);
    (Seen { version, news: [version; 2] }, text(hub, "change", change))
}

/// The message for who begins to look at something else.
pub fn turned(hub: &Hub, seen: Seen, audience: &Audience) -> (Seen, Utf8Bytes) {
    let (version, mut change) = hub.topics.missed(seen.version, seen.news, audience);
    let mut live = hub.topics.live_of(audience);
    live.set.append(&mut change.set);
    live.gone = change.gone;
    (Seen { version, news: [version; 2] }, text(hub, "change", live))
}

/// Writes each change until the hub ends.
pub async fn run(hub: Hub) {
    let mut version = hub.topics.version();
    let mut ending = hub.ending.subscribe();
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
            () = async { _ = ending.wait_for(|ending| *ending).await } => return,
        }
    }
}

/// Writes what is new for each audience; `due`: the news, and a word even if there is nothing.
fn write(hub: &Hub, from: Seen, due: bool) -> Seen {
    let mut all = lock(&hub.changes.all);
    // Who comes to look at what no client looks at is told what is missing.
    all.retain(|_, changes| changes.receiver_count() > 0);
    if all.is_empty() {
        let version = *hub.topics.version().borrow();
        return Seen { version, news: [version; 2] };
    }
    let (version, changed) = hub.topics.since(from.version);
    let (news, brief) = match due {
        true => hub.topics.news(from.news, NEWS_BYTES),
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
            true => text(hub, "change", change),
            false => Utf8Bytes::default(),
        };
        changes.send_replace(Arc::new(Shared { from, to, text: Some(said) }));
    }
    to
}
