//! Values that are read periodically, for any number of subscribers.
//!
//! One task polls a value for all its subscribers, with the shortest period of them. Each
//! subscriber has the latest value with its age, and a bounded queue of updates; a slow subscriber
//! misses updates, receives their number, and delays no other. Polling continues after the
//! connection was restored, so a subscription need not be renewed.

use std::sync::{Arc, Mutex, Weak};
use std::time::Duration;

use lafet_proto::Request;
use tokio::sync::broadcast::{self, error::RecvError};
use tokio::time::{Instant, sleep_until};

use crate::answers::{Answers, RequestBuf};
use crate::client::{Client, WeakClient};
use crate::error::Error;
use crate::session::LONGEST;
use crate::shared::lock;

/// Most updates waiting for a slow subscriber.
pub const UPDATES_MAX: usize = 64;
/// A value that was not renewed in this many periods is stale.
const STALE_PERIODS: u32 = 3;
/// The shortest period.
const PERIOD_MIN: Duration = Duration::from_millis(10);

/// A value and the time of its answers.
#[derive(Clone, Debug)]
pub struct Sample {
    answers: Arc<Answers>,
    at: Instant,
    stale: bool,
}

impl Sample {
    /// The answers.
    pub fn answers(&self) -> &Answers {
        &self.answers
    }

    /// When the answers came.
    pub const fn at(&self) -> Instant {
        self.at
    }

    /// The age of the answers.
    pub fn age(&self) -> Duration {
        self.at.elapsed()
    }

    /// Whether later reads failed, so that the value may have changed.
    pub const fn is_stale(&self) -> bool {
        self.stale
    }
}

/// An update.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Update {
    /// A new value.
    Value(Sample),
    /// The value cannot be read, with the reason. Polling continues.
    Stale(Error),
    /// This many updates were missed; the next ones follow.
    Missed(u64),
}

/// A value that is kept up to date while this exists.
#[derive(Debug)]
pub struct Subscription {
    feed: Arc<Feed>,
    updates: broadcast::Receiver<Update>,
    /// Keeps the client: polling ends with the last subscription, not with the last client.
    _client: Client,
    _period: Arc<Duration>,
}

impl Subscription {
    /// The latest value, with its age; `None` before the first.
    pub fn latest(&self) -> Option<Sample> {
        let state = lock(&self.feed.state);
        let (answers, at) = state.latest.clone()?;
        let stale = state.error.is_some() || at.elapsed() > state.period() * STALE_PERIODS;
        Some(Sample { answers, at, stale })
    }

    /// Why the value cannot be read at present.
    pub fn error(&self) -> Option<Error> {
        lock(&self.feed.state).error.clone()
    }

    /// Waits for the next update. Dropping the future loses nothing.
    pub async fn next(&mut self) -> Update {
        match self.updates.recv().await {
            Ok(update) => update,
            Err(RecvError::Lagged(missed)) => Update::Missed(missed),
            // The feed exists as long as the subscription.
            Err(RecvError::Closed) => Update::Stale(Error::Closed),
        }
    }
}

impl Client {
    /// Keeps the answers to a request that changes nothing up to date: sends it every `period` (10 ms
    /// to a day; what is outside counts as the nearer of the two), and continues after the connection
    /// was lost and restored. Subscriptions to the same request share the answers.
    ///
    /// # Errors
    ///
    /// [`Error::NotARead`] for a request that changes something, [`Error::Unsendable`] for more
    /// than 255 bytes of data. Later errors are [`Update`]s.
    pub fn subscribe(
        &self,
        request: &Request<'_>,
        period: Duration,
    ) -> Result<Subscription, Error> {
        let request = RequestBuf::new(request)?;
        if !request.is_read() {
            return Err(Error::NotARead { request: request.id(), to: request.to() });
        }
        let period = Arc::new(period.clamp(PERIOD_MIN, LONGEST));
        let key = (self.address(), request.bytes().to_vec());
        let mut feeds = lock(&self.shared.feeds);
        feeds.retain(|_, feed| feed.strong_count() > 0);
        let known = feeds.get(&key).and_then(Weak::upgrade);
        let feed = known.unwrap_or_else(|| {
            let feed = Arc::new(Feed::default());
            feeds.insert(key, Arc::downgrade(&feed));
            tokio::spawn(poll(Arc::downgrade(&feed), self.downgrade(), request));
            feed
        });
        lock(&feed.state).periods.push(Arc::downgrade(&period));
        feed.sooner.notify_one();
        let updates = feed.updates.subscribe();
        Ok(Subscription { feed, updates, _client: self.clone(), _period: period })
    }
}

/// A value and its subscribers.
#[derive(Debug)]
pub struct Feed {
    state: Mutex<State>,
    updates: broadcast::Sender<Update>,
    /// Notified when a subscriber needs a shorter period.
    sooner: tokio::sync::Notify,
}

#[derive(Debug, Default)]
struct State {
    latest: Option<(Arc<Answers>, Instant)>,
    error: Option<Error>,
    periods: Vec<Weak<Duration>>,
}

impl State {
    /// The shortest period of the subscribers.
    fn period(&self) -> Duration {
        let periods = self.periods.iter().filter_map(Weak::upgrade);
        periods.map(|period| *period).min().unwrap_or(PERIOD_MIN)
    }
}

impl Default for Feed {
    fn default() -> Self {
        let updates = broadcast::Sender::new(UPDATES_MAX);
        Self { state: Mutex::default(), updates, sooner: tokio::sync::Notify::new() }
    }
}

impl Feed {
    fn publish(&self, result: Result<Answers, Error>) {
        let mut state = lock(&self.state);
        let update = match result {
            Ok(answers) => {
                let (answers, at) = (Arc::new(answers), Instant::now());
                state.latest = Some((answers.clone(), at));
                state.error = None;
                Update::Value(Sample { answers, at, stale: false })
            }
            // Reported once, not every period.
            Err(error) if state.error.is_some() => return state.error = Some(error),
            Err(error) => {
                state.error = Some(error.clone());
                Update::Stale(error)
            }
        };
        drop(state);
        _ = self.updates.send(update);
    }
}

async fn poll(feed: Weak<Feed>, client: WeakClient, request: RequestBuf) {
    let mut next = Instant::now();
    let Some(mut link) = client.upgrade().map(|client| client.link_state()) else { return };
    loop {
        {
            let (Some(feed), Some(client)) = (feed.upgrade(), client.upgrade()) else { return };
            let asked = Instant::now();
            let result = client.run(vec![request.clone()]).await;
            feed.publish(result.into_iter().next().unwrap_or(Err(Error::Closed)));
            let mut state = lock(&feed.state);
            state.periods.retain(|period| period.strong_count() > 0);
            // Polls missed during a stall are not made up for.
            next = (next + state.period()).max(asked);
        }
        link.mark_unchanged();
        loop {
            let Some(feed) = feed.upgrade() else { return };
            let sooner = next.min(Instant::now() + lock(&feed.state).period());
            next = sooner;
            tokio::select! {
                () = sleep_until(next) => break,
                () = feed.sooner.notified() => {}
                changed = link.changed() => match changed {
                    // A value missed while the link was down is read as soon as it is up.
                    Ok(()) if link.borrow().up => break,
                    Ok(()) => {}
                    Err(_) => return,
                },
            }
        }
    }
}
