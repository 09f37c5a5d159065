//! Configuration of a session.

use std::time::Duration;

use super::CheckMode;
use super::medium::{Addresses, CONTROLLER_PAUSE, Echo, Framing, Role};

/// Default bound for late answers: 5 s for the request on its way, and 5 s for the answer.
pub const LATE_DEFAULT: Duration = Duration::from_secs(10);
/// A longer time counts as this one, so that no sum of times overflows.
pub(crate) const LONGEST: Duration = Duration::from_secs(24 * 60 * 60);

/// Configuration of a session. A time of more than a day counts as a day.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Config {
    /// Addresses of both sides.
    pub addresses: Addresses,
    /// Framing of the bytes.
    pub framing: Framing,
    /// Longest wait for an answer.
    pub timeout: Duration,
    /// Transmissions of a request that may be repeated.
    pub tries: u32,
    /// Time for which an urgent request waits for the answer to an outstanding frame.
    pub patience: Duration,
    /// Longest delay of an answer after its request, for a monitor that answers tags: up to this
    /// bound no wrong answer is accepted.
    pub late_bound: Duration,
    /// The same for a monitor that does not answer tags: a suspicious request waits this long.
    /// `late=` of a URL.
    pub drain_bound: Duration,
    /// The connection outlives programs, as a serial port or a socket of a serial server does:
    /// answers to another program may come for `late_bound` after connecting, so every request is
    /// in doubt until then. [`crate::Client::connect`] sets it for all connections except those in
    /// memory.
    pub outlives: bool,
    /// Number of the first frame in doubt; `None`: random, from the operating system.
    pub first_number: Option<u32>,
    /// Whether the medium may duplicate frames (UDP).
    pub duplicates: bool,
    /// Whether frames in doubt are numbered; otherwise they wait for `drain_bound`.
    pub tags: bool,
    /// Role of this side on its bus.
    pub role: Role,
    /// Checksum of frames.
    pub check: CheckMode,
    /// Whether sent bytes come back, as with RS-485 adapters that receive what they send.
    pub echo: Echo,
    /// Pause between the last received byte and a frame, which a transceiver needs to change
    /// direction.
    pub turnaround: Duration,
    /// Time to listen on a new connection before the first frame that is not urgent: if a
    /// controller grants access to others, a direct client does not transmit.
    pub listen: Duration,
    /// For programs that send for as long as they run, on a serial line: until a monitor has answered
    /// `listen` is as long as a controller may be silent, and beside bytes that are no frames, or a
    /// controller, nothing but Stop, Close and Lockout on is sent (beside bytes that go on, after 30 s, a
    /// request each 10 s). `insist=1` in the URL turns it off.
    pub heed: bool,
    /// Time for which requests answered with Busy, NotCached or Cached (§2) are repeated, where the
    /// caller wants them complete.
    pub resume: Duration,
}

impl Config {
    /// Without times that are too long to be added to others.
    pub(crate) fn bounded(self) -> Self {
        let most = |time: Duration| time.min(LONGEST);
        Self {
            timeout: most(self.timeout),
            patience: most(self.patience),
            late_bound: most(self.late_bound),
            drain_bound: most(self.drain_bound),
            turnaround: most(self.turnaround),
            listen: most(self.listen),
            resume: most(self.resume),
            ..self
        }
    }

    /// Time to listen before the first frame that is not urgent, as long as no monitor has answered.
    pub fn first_listen(&self) -> Duration {
        if self.heed { self.listen.max(CONTROLLER_PAUSE) } else { self.listen }
    }
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
            heed: false,
            resume: Duration::from_secs(10),
        }
    }
}
