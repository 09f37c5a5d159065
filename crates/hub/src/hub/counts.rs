//! Totals for the metrics.

use std::sync::atomic::{AtomicU64, Ordering};

use super::Hub;

/// Totals for the metrics.
#[derive(Debug, Default)]
pub struct Counts {
    /// Connections that are open.
    pub connections: AtomicU64,
    /// WebSockets that are open.
    pub sockets: AtomicU64,
    /// Requests sent to monitors.
    pub commands: AtomicU64,
    /// Requests that were not accepted.
    pub refused: AtomicU64,
    /// States that were polled.
    pub polls: AtomicU64,
    /// Requests over HTTP.
    pub requests: AtomicU64,
    /// Messages to WebSockets.
    pub messages: AtomicU64,
    /// Bytes of messages to WebSockets.
    pub message_bytes: AtomicU64,
    /// Motions by hand.
    pub jogs: AtomicU64,
    /// Messages dropped, as a connection was slow.
    pub missed: AtomicU64,
    /// Logins that failed.
    pub logins_failed: AtomicU64,
    /// Longest time from a Stop's arrival to its answer, microseconds.
    pub stop_max_us: AtomicU64,
}

impl Hub {
    /// Requests sent to monitors since the start.
    pub fn count_of_commands(&self) -> u64 {
        self.counts().commands.load(Ordering::Relaxed)
    }
}
