//! How a session behaves.

use std::time::Duration;

use super::CheckMode;
use super::medium::{Addresses, Echo, Framing, Role};

/// How late an answer is expected to come at most, where nothing else is said: its request 5 s on
/// the way, and the answer as long.
pub const LATE_DEFAULT: Duration = Duration::from_secs(10);

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
    /// The same for a monitor that does not: what a suspicious request has to wait. `late=` of a URL.
    pub drain_bound: Duration,
    /// The way outlives programs, as a serial port or a socket of a serial server does: answers to
    /// another one may come for `late_bound` after connecting, so every request is in doubt until
    /// then. [`crate::Client::connect`] sets it for all ways but those in memory.
    pub outlives: bool,
    /// The number of the first frame in doubt; `None`: chosen by the operating system's randomness.
    pub first_number: Option<u32>,
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
    /// How long a new connection is listened to before the first frame that is not urgent: where a
    /// controller gives access to others, a direct client says nothing.
    pub listen: Duration,
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
            drain_bound: LATE_DEFAULT,
            outlives: false,
            first_number: None,
            duplicates: false,
            tags: true,
            role: Role::Direct,
            check: CheckMode::Crc16,
            echo: Echo::Off,
            turnaround: Duration::ZERO,
            listen: Duration::ZERO,
            resume: Duration::from_secs(10),
        }
    }
}
