//! How a session behaves.

use std::time::Duration;

use super::CheckMode;
use crate::url::{Addresses, Echo, Framing, Role};

/// How a session behaves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Config {
    /// Who talks to whom.
    pub addresses: Addresses,
    /// What the bytes are.
    pub framing: Framing,
    /// How long an answer is waited for.
    pub timeout: Duration,
    /// How often a request that may be repeated is sent.
    pub tries: u32,
    /// How long an urgent request lets an outstanding frame wait for its answer.
    pub patience: Duration,
    /// No answer comes later than this after its request: the bound up to which nothing wrong is
    /// believed of a monitor that answers tags.
    pub late_bound: Duration,
    /// The same for a monitor that does not: what a suspicious request has to wait.
    pub drain_bound: Duration,
    /// The medium may copy frames (UDP).
    pub duplicates: bool,
    /// Number frames in doubt; without it they wait for `drain_bound`.
    pub tags: bool,
    /// What this side is on its bus.
    pub role: Role,
    /// Which check frames bear.
    pub check: CheckMode,
    /// Whether what is sent comes back, as on RS-485 adapters that hear themselves.
    pub echo: Echo,
    /// Silence that is kept between the last byte heard and a frame: a transceiver needs it to turn
    /// round.
    pub turnaround: Duration,
    /// How long requests are asked again that the monitor answers with Busy, NotCached or Cached
    /// (§2), where the caller wants them complete.
    pub resume: Duration,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            addresses: Addresses::default(),
            framing: Framing::Link,
            timeout: Duration::from_secs(1),
            tries: 3,
            patience: Duration::from_millis(lafet_proto::bus::REPLY_TIMEOUT_MS as u64),
            late_bound: Duration::from_secs(30),
            drain_bound: Duration::from_secs(3),
            duplicates: false,
            tags: true,
            role: Role::Direct,
            check: CheckMode::Crc16,
            echo: Echo::Off,
            turnaround: Duration::ZERO,
            resume: Duration::from_secs(10),
        }
    }
}
