//! The connections of a TCP listener: a bounded number; the one silent for longest is dropped
//! first.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use tokio::task::AbortHandle;

/// Most connections of one listener.
pub const CONNECTIONS_MAX: usize = 64;

/// Time of the last valid frame of a connection, or of its start.
#[derive(Clone)]
pub struct Heard {
    began: Instant,
    last_ms: Arc<AtomicU64>,
}

impl Heard {
    /// Records that a frame has arrived now.
    pub fn now(&self) {
        let elapsed = u64::try_from(self.began.elapsed().as_millis()).unwrap_or(u64::MAX);
        self.last_ms.store(elapsed, Ordering::Relaxed);
    }
}

struct Slot {
    heard: Heard,
    task: AbortHandle,
}

/// The open connections of a listener.
pub struct Connections {
    began: Instant,
    slots: Vec<Slot>,
}

impl Connections {
    /// No connections yet.
    pub fn new() -> Self {
        Self { began: Instant::now(), slots: Vec::new() }
    }

    /// A timestamp for a new connection.
    pub fn heard(&self) -> Heard {
        let heard = Heard { began: self.began, last_ms: Arc::default() };
        heard.now();
        heard
    }

    /// Adds a new connection; when there are too many, the one silent for longest is dropped, so
    /// that half-open connections cannot lock out new clients.
    pub fn add(&mut self, heard: Heard, task: AbortHandle) {
        self.slots.retain(|slot| !slot.task.is_finished());
        if self.slots.len() >= CONNECTIONS_MAX {
            let last = |slot: &Slot| slot.heard.last_ms.load(Ordering::Relaxed);
            let silent = (0..self.slots.len()).min_by_key(|index| last(&self.slots[*index]));
            if let Some(index) = silent {
                self.slots.remove(index).task.abort();
            }
        }
        self.slots.push(Slot { heard, task });
    }
}

impl Drop for Connections {
    fn drop(&mut self) {
        self.slots.iter().for_each(|slot| slot.task.abort());
    }
}
