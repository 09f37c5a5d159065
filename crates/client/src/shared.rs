//! State shared by the task of a link and its handles.

use std::collections::{HashMap, HashSet};
use std::io;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use tokio::sync::{Notify, broadcast, watch};

use crate::answers::RequestBuf;
use crate::jog::Held;
use crate::session::statistics::LinkStatistics;
use crate::session::{QUEUE_MAX, Stats, Traced, URGENT_MAX};
use crate::subscription::Feed;

/// Most traced frames waiting for a slow listener.
const TRACE_MAX: usize = 1024;
/// Most events waiting for a slow listener.
const EVENTS_MAX: usize = 256;
/// Most jobs waiting between handles and task.
const JOBS_MAX: usize = QUEUE_MAX;
/// Most waiting jobs, with urgent ones.
const URGENT_JOBS_MAX: usize = JOBS_MAX + URGENT_MAX;

/// Event of a link.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum LinkEvent {
    /// The connection was opened again.
    Up,
    /// The connection was lost, or could not be used.
    Down(Arc<io::Error>),
    /// The monitor does not answer the numbers of frames, so that requests that could be confused
    /// with late answers wait this long (`late=` of the URL).
    Held(Duration),
    /// Statistics of the last second.
    Statistics(Box<LinkStatistics>),
}

/// Whether there is a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinkState {
    /// There is a connection.
    pub up: bool,
    /// There is no connection, and none will be opened.
    pub gone: bool,
    /// Number of losses.
    pub losses: u64,
}

/// State that the task publishes, and state of all handles.
#[derive(Debug)]
pub struct Shared {
    pub stats: Mutex<AllStats>,
    pub trace: broadcast::Sender<Traced>,
    pub events: broadcast::Sender<LinkEvent>,
    pub state: watch::Sender<LinkState>,
    /// Wakes the task when a new listener appears.
    pub wake: Notify,
    pub jogs: Mutex<Vec<Weak<Held>>>,
    /// Addresses of monitors that have MoveHold, as far as known from this connection.
    pub holds: Mutex<HashSet<u8>>,
    pub feeds: Mutex<Feeds>,
    jobs: AtomicUsize,
}

/// Polled values, by address and record.
type Feeds = HashMap<(u8, Vec<u8>), Weak<Feed>>;

#[derive(Debug, Default)]
pub struct AllStats {
    pub total: Stats,
    /// Counters by address.
    pub each: Vec<(u8, Stats)>,
}

impl Default for Shared {
    fn default() -> Self {
        Self {
            stats: Mutex::default(),
            trace: broadcast::Sender::new(TRACE_MAX),
            events: broadcast::Sender::new(EVENTS_MAX),
            state: watch::Sender::new(LinkState { up: true, gone: false, losses: 0 }),
            wake: Notify::new(),
            jogs: Mutex::default(),
            holds: Mutex::default(),
            feeds: Mutex::default(),
            jobs: AtomicUsize::new(0),
        }
    }
}

impl Shared {
    /// Whether one more job may wait for the task.
    pub fn has_room(&self, urgent: bool) -> bool {
        let limit = if urgent { URGENT_JOBS_MAX } else { JOBS_MAX };
        let more = |jobs| (jobs < limit).then_some(jobs + 1);
        self.jobs.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more).is_ok()
    }

    /// Counts a job that the task has taken.
    pub fn taken(&self) {
        self.jobs.fetch_sub(1, Ordering::Relaxed);
    }

    /// Ends motions held by this client that an urgent request stops.
    pub fn stop_jogs(&self, address: u8, requests: &[RequestBuf]) {
        let jogs: Vec<Arc<Held>> = lock(&self.jogs).iter().filter_map(Weak::upgrade).collect();
        for jog in jogs {
            if jog.address() == address && requests.iter().any(|stop| jog.is_undone_by(stop)) {
                jog.stop_asked();
            }
        }
    }
}

/// Locks a mutex; a panic of another thread leaves the data behind it consistent.
pub fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
