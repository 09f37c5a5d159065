//! What is wrong with a link: looks, tells what was seen, and what to do.
//!
//! ```text
//! examine ─▶ Evidence ─▶ findings ─▶ Finding::seen, Finding::remedy
//! ```
//!
//! [`examine`] says nothing that could move anything: presence probes and GetStatus General. Where
//! others speak, it says nothing at all, at whatever speed they do.

mod examine;
mod finding;
mod texts;

pub use examine::{Options, examine};
pub use finding::{Finding, Severity, findings};

use std::time::Duration;

use crate::error::Cause;
use crate::prober::Heard;
use crate::url::Endpoint;

/// What was seen on a link.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Evidence {
    /// The link.
    pub endpoint: Endpoint,
    /// Why it could not be opened, or was lost.
    pub lost: Option<String>,
    /// What came before anything was asked.
    pub quiet: Heard,
    /// How long that was.
    pub quiet_for: Duration,
    /// What came upon presence probes to the monitor's address.
    pub probed: Heard,
    /// How many there were.
    pub probes: u32,
    /// How many of them the monitor answered.
    pub answered: u32,
    /// More than one answer to a probe.
    pub doubled: bool,
    /// The monitor answers only frames with a CRC-32C (§L/7).
    pub crc32c_only: bool,
    /// What answered in the other framing than the URL's: bare records, or link frames.
    pub other_framing: bool,
    /// Answers came to our address that we had not asked for.
    pub address_taken: bool,
    /// Nothing was asked, because others speak on this line.
    pub held_back: bool,
    /// Why a console of the bus was not let ask.
    pub no_access: Option<Cause>,
    /// Other addresses that answer probes.
    pub others: Vec<u8>,
    /// What came at other speeds, and whether the monitor answered; serial lines only.
    pub speeds: Vec<Speed>,
    /// What came of a number of requests, if the monitor answers.
    pub exchange: Option<Exchange>,
}

/// What came at another speed of a serial line.
#[derive(Clone, Debug)]
pub struct Speed {
    /// The speed.
    pub baud: u32,
    /// What came.
    pub heard: Heard,
    /// The monitor answered.
    pub answered: bool,
}

/// A number of requests, one after the other.
#[derive(Clone, Debug, Default)]
pub struct Exchange {
    /// How many were sent.
    pub sent: u32,
    /// How many were answered.
    pub answered: u32,
    /// How many of the answers were not what the protocol says.
    pub odd: u32,
    /// The records of the first of those.
    pub odd_sample: Option<Vec<u8>>,
    /// All that came meanwhile.
    pub heard: Heard,
    /// The longest round trip.
    pub rtt_max: Duration,
    /// The mean round trip.
    pub rtt_mean: Duration,
}

impl Speed {
    /// Others speak at this speed, without being asked.
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

    /// The monitor answers.
    pub const fn is_answered(&self) -> bool {
        self.answered > 0
    }
}
