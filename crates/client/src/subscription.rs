//! Values that are read again and again, for as many as want them.
//!
//! A value is polled by one task for all its subscribers, as often as the quickest of them wants
//! it. Each has the latest value with its age, and a bounded queue of what is new; who is slow
//! misses updates and is told how many, and holds up nobody. Polling goes on when the connection is
//! made again, so a subscription is never made anew.

use std::sync::{Arc, Mutex, Weak};
use std::time::Duration;

use lafet_proto::Request;
use tokio::sync::broadcast::{self, error::RecvError};
use tokio::time::{Instant, sleep_until};

use crate::answers::{Answers, RequestBuf};
use crate::client::{Client, WeakClient};
use crate::error::Error;
use crate::shared::lock;

/// Updates that a slow subscriber may lag behind.
pub const UPDATES_MAX: usize = 64;
/// A value that was not renewed in this many periods is stale.
const STALE_PERIODS: u32 = 3;
/// Nobody needs a value more often.
const PERIOD_MIN: Duration = Duration::from_millis(10);

/// A value, and when it was true.
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

    /// When they came.
    pub const fn at(&self) -> Instant {
        self.at
    }

    /// How old they are.
    pub fn age(&self) -> Duration {
        self.at.elapsed()
    }

    /// The value was not to be had since: what it says may not be so any more.
    pub const fn is_stale(&self) -> bool {
        self.stale
    }
}

/// What is new.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Update {
    /// A value.
    Value(Sample),
    /// The value is not to be had, and why. It goes on being asked for.
    Stale(Error),
    /// So many updates were missed; the next ones follow.
    Missed(u64),
}

/// A value that is kept up to date as long as this lives.
#[derive(Debug)]
pub struct Subscription {
    feed: Arc<Feed>,
    updates: broadcast::Receiver<Update>,
    /// Polling ends with the last subscription, not with the last client.
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

    /// Why the value is not to be had just now.
    pub fn error(&self) -> Option<Error> {
        lock(&self.feed.state).error.clone()
    }

    /// Waits for what is new. Dropping the future loses nothing.
    pub async fn next(&mut self) -> Update {
        match self.updates.recv().await {
            Ok(update) => update,
            Err(RecvError::Lagged(missed)) => Update::Missed(missed),
            // The feed lives as long as we do.
            Err(RecvError::Closed) => Update::Stale(Error::Closed),
        }
    }
}

impl Client {
    /// Keeps the answers to a request that changes nothing up to date: asks for them every
    /// `period`, and goes on when the connection was lost and made again. Several subscriptions of
    /// the same request share its answers.
    ///
    /// # Errors
    ///
    /// [`Error::NotARead`] for a request that changes something, [`Error::Unsendable`] for one of
    /// more than 255 bytes of data. What goes wrong later comes as an [`Update`].
    pub fn subscribe(
        &self,
        request: &Request<'_>,
        period: Duration,
    ) -> Result<Subscription, Error> {
        let request = RequestBuf::new(request)?;
        if !request.is_read() {
            return Err(Error::NotARead { request: request.id(), to: request.to() });
        }
        let period = Arc::new(period.max(PERIOD_MIN));
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
    /// Somebody wants it sooner.
    sooner: tokio::sync::Notify,
}

#[derive(Debug, Default)]
struct State {
    latest: Option<(Arc<Answers>, Instant)>,
    error: Option<Error>,
    periods: Vec<Weak<Duration>>,
}

impl State {
    /// As often as the quickest wants it.
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
            // Told once, not every period.
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
            // A stall is not made up for.
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
                    // What was missed is asked for as soon as it can be.
                    Ok(()) if link.borrow().up => break,
                    Ok(()) => {}
                    Err(_) => return,
                },
            }
        }
    }
}
