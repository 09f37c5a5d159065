//! What the task of a link and the handles on it share.

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

/// Frames that a slow listener of the trace may lag behind.
const TRACE_MAX: usize = 1024;
/// Events that a slow listener may lag behind.
const EVENTS_MAX: usize = 256;
/// Jobs that may wait between handles and task.
const JOBS_MAX: usize = QUEUE_MAX;
/// The same for urgent ones.
const URGENT_JOBS_MAX: usize = JOBS_MAX + URGENT_MAX;

/// Something that happens to a link.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum LinkEvent {
    /// The connection was made again.
    Up,
    /// The connection was lost, or could not be used.
    Down(Arc<io::Error>),
    /// The monitor does not answer the numbers of frames, so what may not be confused with late
    /// answers waits this long (`late=` of the URL).
    Held(Duration),
    /// The figures of the last second.
    Statistics(Box<LinkStatistics>),
}

/// Whether there is a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinkState {
    /// There is.
    pub up: bool,
    /// There is none, and none will be made.
    pub gone: bool,
    /// How often it was lost.
    pub losses: u64,
}

/// What the task shows to the handles, and what they have in common.
#[derive(Debug)]
pub struct Shared {
    pub stats: Mutex<AllStats>,
    pub trace: broadcast::Sender<Traced>,
    pub events: broadcast::Sender<LinkEvent>,
    pub state: watch::Sender<LinkState>,
    /// Has the task look around: somebody listens who did not before.
    pub wake: Notify,
    pub jogs: Mutex<Vec<Weak<Held>>>,
    /// Addresses of monitors that have MoveHold, as far as this connection has shown.
    pub holds: Mutex<HashSet<u8>>,
    pub feeds: Mutex<Feeds>,
    jobs: AtomicUsize,
}

/// What is polled, by address and record.
type Feeds = HashMap<(u8, Vec<u8>), Weak<Feed>>;

#[derive(Debug, Default)]
pub struct AllStats {
    pub total: Stats,
    /// By address.
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

    /// The task has taken a job.
    pub fn taken(&self) {
        self.jobs.fetch_sub(1, Ordering::Relaxed);
    }

    /// Ends what this client holds in motion and an urgent request is to stop.
    pub fn stop_jogs(&self, address: u8, requests: &[RequestBuf]) {
        let jogs: Vec<Arc<Held>> = lock(&self.jogs).iter().filter_map(Weak::upgrade).collect();
        for jog in jogs {
            if jog.address() == address && requests.iter().any(|stop| jog.is_undone_by(stop)) {
                jog.stop_asked();
            }
        }
    }
}

/// Nothing that is kept behind these locks can be left half done.
pub fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
