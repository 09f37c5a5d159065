//! Diagnosis of a link: examines it, reports what was observed, and what to do.
//!
//! ```text
//! examine ─▶ Evidence ─▶ findings ─▶ Finding::seen, Finding::remedy
//! ```
//!
//! [`examine`] sends nothing that could cause a motion: only presence probes and GetStatus General.
//! If other devices transmit, at any speed, it sends nothing at all.

mod examine;
mod finding;
mod texts;

pub use examine::{Options, examine};
pub use finding::{Finding, Severity, findings};

use std::io;
use std::sync::Arc;
use std::time::Duration;

use crate::error::Cause;
use crate::prober::Heard;
use crate::url::Endpoint;

/// What was observed on a link.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Evidence {
    /// The link.
    pub endpoint: Endpoint,
    /// Why it could not be opened, or was lost.
    pub lost: Option<Arc<io::Error>>,
    /// Received before anything was sent.
    pub quiet: Heard,
    /// Duration of that time.
    pub quiet_for: Duration,
    /// Received after presence probes to the monitor's address.
    pub probed: Heard,
    /// Number of probes.
    pub probes: u32,
    /// Number of probes that the monitor answered.
    pub answered: u32,
    /// More than one answer to a probe.
    pub doubled: bool,
    /// The monitor answers only frames with a CRC-32C (§L/7).
    pub crc32c_only: bool,
    /// The monitor answered in the framing that the URL does not have: bare records, or link
    /// frames.
    pub other_framing: bool,
    /// Answers to our address came that we had not asked for.
    pub address_taken: bool,
    /// Nothing was sent, because other devices transmit on this line.
    pub held_back: bool,
    /// Why a console of the bus could not send.
    pub no_access: Option<Cause>,
    /// Other addresses that answer probes.
    pub others: Vec<u8>,
    /// Observations at other speeds; serial lines only.
    pub speeds: Vec<Speed>,
    /// Result of a number of requests, if the monitor answers.
    pub exchange: Option<Exchange>,
}

/// Observations at another speed of a serial line.
#[derive(Clone, Debug)]
pub struct Speed {
    /// The speed, baud.
    pub baud: u32,
    /// What was received.
    pub heard: Heard,
    /// Whether the monitor answered.
    pub answered: bool,
}

/// Result of a number of requests, one after the other.
#[derive(Clone, Debug, Default)]
pub struct Exchange {
    /// Requests sent.
    pub sent: u32,
    /// Requests answered.
    pub answered: u32,
    /// Answers that break the protocol.
    pub odd: u32,
    /// The records of the first such answer.
    pub odd_sample: Option<Vec<u8>>,
    /// All that was received meanwhile.
    pub heard: Heard,
    /// The longest round trip.
    pub rtt_max: Duration,
    /// The mean round trip.
    pub rtt_mean: Duration,
}

impl Speed {
    /// Whether other devices transmit at this speed without being asked.
    pub fn has_others(&self) -> bool {
        !self.answered && !self.heard.frames.is_empty()
    }
}

impl Evidence {
    fn new(endpoint: &Endpoint) -> Self {
        Self {
            endpoint: endpoint.clone(),
            lost: None,
            quiet: Heard::default(),
            quiet_for: Duration::ZERO,
            probed: Heard::default(),
            probes: 0,
            answered: 0,
            doubled: false,
            crc32c_only: false,
            other_framing: false,
            address_taken: false,
            held_back: false,
            no_access: None,
            others: Vec::new(),
            speeds: Vec::new(),
            exchange: None,
        }
    }

    /// Whether the monitor answers.
    pub const fn is_answered(&self) -> bool {
        self.answered > 0
    }
}
