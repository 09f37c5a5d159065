//! What the handles of a link share besides its engine.

use std::collections::{HashMap, HashSet};
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use lafet_proto::SubsystemId;
use tokio::runtime::Handle;
use tokio::sync::{broadcast, watch};
use tokio::time::Instant;

use crate::answers::RequestBuf;
use crate::jog::Held;
use crate::session::Traced;
use crate::session::statistics::LinkStatistics;
use crate::subscription::Feed;

/// Most traced frames waiting for a slow listener.
const TRACE_MAX: usize = 1024;
/// Most events waiting for a slow listener.
const EVENTS_MAX: usize = 256;

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

impl LinkState {
    /// Of a new client.
    pub(crate) const CONNECTED: Self = Self { up: true, gone: false, losses: 0 };
}

/// A channel to listeners, of which there are usually none.
#[derive(Debug)]
pub struct Listened<T> {
    sender: broadcast::Sender<T>,
    /// There may be listeners. To count them takes a lock, which each exchange would pay for.
    perhaps: AtomicBool,
}

impl<T: Clone> Listened<T> {
    fn new(waiting_max: usize) -> Self {
        Self { sender: broadcast::Sender::new(waiting_max), perhaps: AtomicBool::new(false) }
    }

    pub fn subscribe(&self) -> broadcast::Receiver<T> {
        let listener = self.sender.subscribe();
        self.perhaps.store(true, Ordering::SeqCst);
        listener
    }

    /// Whether there are listeners. Not to be called by two threads at once.
    #[inline]
    pub fn is_listened_to(&self) -> bool {
        self.perhaps.load(Ordering::SeqCst) && self.count()
    }

    #[cold]
    fn count(&self) -> bool {
        if self.sender.receiver_count() == 0 {
            self.perhaps.store(false, Ordering::SeqCst);
        }
        // One that subscribed in between has been counted by now, or will say so itself.
        let any = self.sender.receiver_count() > 0;
        if any {
            self.perhaps.store(true, Ordering::SeqCst);
        }
        any
    }

    /// Sends to the listeners, if there are any.
    pub fn send(&self, value: T) {
        _ = self.sender.send(value);
    }
}

/// What the engine publishes, and state of all handles.
#[derive(Debug)]
pub struct Shared {
    pub trace: Listened<Traced>,
    pub events: Listened<LinkEvent>,
    pub state: watch::Sender<LinkState>,
    pub jogs: Mutex<Vec<Weak<Held>>>,
    /// Addresses of monitors that have MoveHold, as far as known from this connection.
    pub holds: Mutex<HashSet<u8>>,
    pub feeds: Mutex<Feeds>,
    /// Whose threads look at the links.
    runtime: Option<Handle>,
}

/// Polled values, by address and record.
type Feeds = HashMap<(u8, Vec<u8>), Weak<Feed>>;

impl Default for Shared {
    fn default() -> Self {
        Self {
            trace: Listened::new(TRACE_MAX),
            events: Listened::new(EVENTS_MAX),
            state: watch::Sender::new(LinkState::CONNECTED),
            jogs: Mutex::default(),
            holds: Mutex::default(),
            feeds: Mutex::default(),
            runtime: Handle::try_current().ok(),
        }
    }
}

impl Shared {
    /// Publishes a state of the link, unless a later one has been published by another thread.
    pub fn publish(&self, new: LinkState) {
        self.state.send_if_modified(|state| {
            let later = (new.losses, new.up) > (state.losses, state.up);
            if later {
                *state = new;
            }
            later
        });
    }

    /// Has another thread of the runtime look at the links, if there is one: the one that did may be busy with a
    /// caller whom it has woken, and tokio then leaves the links to that thread until it waits again.
    pub fn look_elsewhere(&self) {
        if let Some(runtime) = &self.runtime {
            drop(runtime.spawn(std::future::ready(())));
        }
    }

    /// Ends motions held by this client that an urgent request stops.
    #[cold]
    pub fn stop_jogs(&self, address: u8, requests: &[RequestBuf]) {
        let jogs: Vec<Arc<Held>> = lock(&self.jogs).iter().filter_map(Weak::upgrade).collect();
        for jog in jogs {
            if jog.address() == address && requests.iter().any(|stop| jog.is_undone_by(stop)) {
                jog.stop_asked();
            }
        }
    }

    /// Others have set a drive in motion, or all of them, by a request that was submitted then. The drives whose motions were
    /// being stopped, and are not any more.
    #[cold]
    pub fn begun(
        &self,
        address: u8,
        drive: Option<SubsystemId>,
        submitted: Instant,
    ) -> Vec<SubsystemId> {
        let jogs: Vec<Arc<Held>> = lock(&self.jogs).iter().filter_map(Weak::upgrade).collect();
        let of = jogs.iter().filter(|jog| jog.address() == address);
        of.filter(|jog| jog.is_replaced(drive, submitted)).map(|jog| jog.drive()).collect()
    }
}

/// Locks a mutex; a panic of another thread leaves the data behind it consistent.
pub fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;

    use super::*;

    #[test]
    fn listeners_are_noticed_whenever_they_come_and_go() {
        let channel = Listened::new(4);
        assert!(!channel.is_listened_to());
        let first = channel.subscribe();
        assert!(channel.is_listened_to());
        let second = first.resubscribe();
        drop(first);
        assert!(channel.is_listened_to());
        drop(second);
        assert!(!channel.is_listened_to());
        let mut third = channel.subscribe();
        assert!(channel.is_listened_to());
        channel.send(7);
        assert_eq!(third.try_recv(), Ok(7));
        drop(third);
        assert!(!channel.is_listened_to());
    }

    /// One that subscribes while another thread counts is noticed by the next look.
    #[test]
    fn a_listener_that_comes_while_others_are_counted_is_noticed() {
        const ROUNDS: usize = 5000;
        let channel = Listened::<u8>::new(1);
        let (start, end) = (Barrier::new(2), Barrier::new(2));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for _ in 0..ROUNDS {
                    start.wait();
                    let listener = channel.subscribe();
                    end.wait();
                    end.wait();
                    drop(listener);
                }
            });
            for round in 0..ROUNDS {
                // As one that has gone leaves it.
                channel.perhaps.store(true, Ordering::SeqCst);
                start.wait();
                _ = channel.is_listened_to();
                end.wait();
                assert!(channel.is_listened_to(), "round {round}");
                end.wait();
            }
        });
    }

    /// Threads may publish in another order than the states had.
    #[test]
    fn the_latest_state_remains() {
        let state = |losses, up| LinkState { up, gone: false, losses };
        let shared = Shared::default();
        for (new, expected) in [
            (state(1, true), state(1, true)),
            (state(1, false), state(1, true)),
            (state(3, false), state(3, false)),
            (state(2, true), state(3, false)),
            (state(3, true), state(3, true)),
        ] {
            shared.publish(new);
            assert_eq!(*shared.state.borrow(), expected);
        }
    }
}
