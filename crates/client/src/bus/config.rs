//! How a controller behaves.

use std::time::Duration;

use lafet_proto::bus::{
    BAUD_DEFAULT, CONSOLES, MONITORS, PROBE_TIMEOUT_MS, REPLY_TIMEOUT_MS, TRIES,
};

/// Bits of a byte on the line: start, eight, stop (8N1, observed).
const BITS: u32 = 10;

/// How consoles and monitors are connected (ours).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ports {
    /// One line: monitors hear consoles by themselves, and the controller only listens.
    #[default]
    One,
    /// Consoles on a line of their own: the controller passes their frames and the answers on.
    Two,
}

/// One of the lines of [`Ports::Two`]; with [`Ports::One`] they are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Port {
    /// Where the monitors are.
    Monitors,
    /// Where the consoles are.
    Consoles,
}

/// Which requests of consoles are sent to the monitor again when no answer comes (ours).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Repeat {
    /// What is the same twice: reads, Stop, Close and Lockout on.
    #[default]
    Repeatable,
    /// Everything (observed): when only the answer was lost, the monitor executes it twice.
    All,
}

/// How a controller behaves.
#[derive(Clone, Debug)]
pub struct ControllerConfig {
    /// Speed of the line, which says how long frames take.
    pub baud: u32,
    /// How the devices are connected.
    pub ports: Ports,
    /// Addresses that may be used: others are never probed.
    pub addresses: Vec<u8>,
    /// How long the answer to a request may take to begin (observed: 150 ms).
    pub reply_timeout: Duration,
    /// The same for probes and grants (observed: 30 ms).
    pub probe_timeout: Duration,
    /// How often something is sent, each time with twice the timeout (observed: 3).
    pub tries: u32,
    /// What is sent again without an answer.
    pub repeat: Repeat,
    /// From one probe of a device that was dropped to the next (observed: about 1 s).
    pub probe_again: Duration,
    /// Monitors that are there and have not been heard for this long are probed (ours); without it
    /// they are noticed to be gone only by whoever asks them.
    pub watch: Option<Duration>,
    /// Silence between the last byte heard and the next frame.
    pub turnaround: Duration,
    /// Silence on the line before a frame to a console, so that it is not taken for a part of the
    /// one before (ours).
    pub frame_pause: Duration,
    /// Frames of the controller's own between two grants, as long as it has some (ours).
    pub own_share: u32,
    /// Unix time at the time 0 of the caller's clock, s: for the journal.
    pub epoch_s: u32,
}

impl Default for ControllerConfig {
    fn default() -> Self {
        Self {
            baud: BAUD_DEFAULT,
            ports: Ports::One,
            addresses: MONITORS.chain(CONSOLES).collect(),
            reply_timeout: Duration::from_millis(REPLY_TIMEOUT_MS.into()),
            probe_timeout: Duration::from_millis(PROBE_TIMEOUT_MS.into()),
            tries: TRIES,
            repeat: Repeat::default(),
            probe_again: Duration::from_secs(1),
            watch: None,
            turnaround: Duration::ZERO,
            frame_pause: Duration::from_millis(3),
            own_share: 8,
            epoch_s: 0,
        }
    }
}

impl ControllerConfig {
    /// How long so many bytes take on the line.
    pub fn sending(&self, bytes: usize) -> Duration {
        let bits = BITS * bytes as u32;
        Duration::from_secs(bits.into()) / self.baud.max(1)
    }

    /// How long a console waits for an answer: what all tries together take. Its request is not
    /// passed on later.
    pub fn patience(&self) -> Duration {
        self.reply_timeout * ((1 << self.tries) - 1)
    }
}
