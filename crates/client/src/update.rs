//! Updating the software of a monitor over its own link (ours; docs/update.md): the side that sends.
//!
//! [`Monitor::update`] goes from whatever state an update is in to its end. The report of the monitor is what
//! counts: an order without an answer is repeated only where a report shows that it was not carried out.
//!
//! ```text
//! state ─▶ begin ─▶ data … ─▶ verify ─▶ commit ─▶ (restart) ─▶ checks ─▶ confirm ─▶ state
//!   └── on trial already: ──────────────────────────────────────▲
//! ```

mod before;
mod error;
mod image;
mod sender;
mod word;

use std::io;
use std::sync::Arc;
use std::time::Duration;

use lafet_proto::request::Body;
use lafet_proto::update::{DIGEST_LEN, ORDER_MAX, Order, WORD_LEN};
use lafet_proto::{Request, RequestId, Status, SubsystemId};
use tokio::time::sleep;

use crate::answers::Answers;
use crate::error::{Cause, Error};
use crate::monitor::{Monitor, wrong_shape};
use crate::session::medium::Role;
use crate::url::Endpoint;

pub use before::Before;
pub use error::{Change, Dotted, Unready, UpdateError};
pub use image::{FILE_MAX, Image, ImageError, are_a_set};
pub use lafet_proto::update::{Phase, Report};
use sender::Sender;
pub use word::{Choice, Kept, Note, Wordless, choose, hex, is_of_others, is_over, unhex};

/// A line that is dead for less than this does not end an update: a cable may be pulled and plugged in again.
pub const PATIENCE: Duration = Duration::from_secs(60);
/// Pause before an order without an answer is looked into.
const PAUSE: Duration = Duration::from_millis(500);
/// Transmissions of the first order, as of any request that only reads.
const TRIES: u32 = 3;

/// An image on trial has to be as the monitor was before for so long without a break, and to answer all the while.
pub const PROVEN: Duration = Duration::from_secs(20);

/// What confirms an image that is on trial: random, and another one for each update.
pub type Word = [u8; WORD_LEN];

/// What the monitor gets of a word before it has to be confirmed.
pub fn digest_of(word: &Word) -> [u8; DIGEST_LEN] {
    image::sha256(word)
}

/// How much of a line's time the data may take, percent: after each part there is a pause for the others on
/// the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace(u8);

impl Pace {
    /// On a bus with other monitors or clients.
    pub const SHARED: Self = Self(20);
    /// All of it.
    pub const FULL: Self = Self(100);

    /// What a link takes unless its user says otherwise: on a serial line, and with `role=active`, others wait
    /// meanwhile.
    pub fn usual(endpoint: &Endpoint) -> Self {
        let line = matches!(endpoint, Endpoint::Serial { .. });
        let shared = line || endpoint.behaviour().role == Role::Active;
        if shared { Self::SHARED } else { Self::FULL }
    }

    /// 1 to 100 percent.
    pub const fn new(percent: u8) -> Option<Self> {
        match percent {
            1..=100 => Some(Self(percent)),
            _ => None,
        }
    }

    /// 1 to 100.
    pub const fn percent(self) -> u8 {
        self.0
    }

    /// The pause after an exchange that took so long.
    fn pause(self, took: Duration) -> Duration {
        took.saturating_mul(u32::from(100 - self.0)) / u32::from(self.0)
    }
}

impl Default for Pace {
    fn default() -> Self {
        Self::SHARED
    }
}

/// How far an update is. Each stage may come more than once: after a loss of power, data are sent again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Data are sent.
    Sending {
        /// Bytes of the payload that are there.
        done: u32,
        /// Bytes of the payload.
        size: u32,
        /// Time left at the speed so far; `None`: not known yet.
        left: Option<Duration>,
    },
    /// The monitor hashes what it has received.
    Verifying,
    /// The order is sent after which the next start of the monitor tries the image.
    Committing,
    /// The next start of the monitor tries the image.
    Committed,
    /// It is awaited.
    Restarting,
    /// The image runs on trial; the monitor is compared with what it was before.
    OnTrial,
    /// The word is sent.
    Confirming,
    /// The image is kept.
    Confirmed,
}

impl Stage {
    /// The image may have been committed and is not confirmed: unless it is, the monitor goes back to the old one.
    pub const fn is_trial(&self) -> bool {
        matches!(
            self,
            Self::Committing
                | Self::Committed
                | Self::Restarting
                | Self::OnTrial
                | Self::Confirming
        )
    }
}

/// How an image is tried.
#[derive(Clone, Copy)]
pub struct Trial<'a> {
    /// What confirms it.
    pub word: &'a Word,
    /// The word is a new one: what is on trial already does not wait for it.
    pub fresh: bool,
    /// What the monitor was before an earlier run with this word was cut off, as it was kept.
    pub before: Option<&'a Before>,
    /// Keeps what the monitor is before it is restarted, for a later run; without that nothing is committed.
    pub keep: &'a (dyn Fn(&Before) -> io::Result<()> + Sync),
    /// How long it has to be as the monitor was before; see [`PROVEN`].
    pub proven: Duration,
    /// How much of the line's time the data take.
    pub pace: Pace,
}

impl<'a> Trial<'a> {
    /// With this word, of which nothing more is known; nothing is kept for a later run.
    pub const fn new(word: &'a Word, pace: Pace) -> Self {
        Self { word, fresh: false, before: None, keep: &not_kept, proven: PROVEN, pace }
    }
}

impl std::fmt::Debug for Trial<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { fresh, before, proven, pace, .. } = self;
        let mut out = f.debug_struct("Trial");
        out.field("fresh", fresh).field("before", before).field("proven", proven);
        out.field("pace", pace).finish_non_exhaustive()
    }
}

#[expect(clippy::unnecessary_wraps, reason = "what keeps may fail")]
const fn not_kept(_: &Before) -> io::Result<()> {
    Ok(())
}

/// An update that has come to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Updated {
    /// The version before; where the image was on trial already at the start of [`Monitor::update`], it is
    /// not known, and the same as `to`.
    pub from: [u16; 4],
    /// The version that is running, confirmed.
    pub to: [u16; 4],
}

impl Monitor {
    /// How far an update of the software is, and which version is running.
    ///
    /// # Errors
    ///
    /// As [`Client::request`](crate::Client::request); [`Error::Refused`] with `WRONG_REQUEST`, under lockout
    /// `DENIED`, of a monitor that cannot be updated over its link.
    pub async fn software(&self) -> Result<Report, Error> {
        let mut tries = 1;
        loop {
            match give(self, &Order::State).await {
                Ok(given) => return given.report(),
                Err(error) if passes(&error) && tries < TRIES => tries += 1,
                Err(error) => return Err(error),
            }
            sleep(PAUSE).await;
        }
    }

    /// Updates the software, from whatever state the update is in to its end: starts to receive the image for
    /// the slot that is not running, or goes on with it; sends the data, has them verified, commits, waits for
    /// the restart, compares the monitor with what it was before, and confirms with the word. An image of
    /// these that is on trial already is checked and confirmed.
    ///
    /// Moves nothing and changes no lockout: the monitor has to be in standby and locked out, and is so at the
    /// end. A future that is dropped leaves what was received; a call with the same image and word goes on.
    /// A line that is dead for up to [`PATIENCE`] is waited for.
    ///
    /// # Errors
    ///
    /// [`UpdateError`]. What was not confirmed does not stay: the monitor goes back by itself.
    pub async fn update(
        &self,
        images: &[Image],
        word: &Word,
        pace: Pace,
        told: impl FnMut(Stage),
    ) -> Result<Updated, UpdateError> {
        self.update_with(images, &Trial::new(word, pace), told).await
    }

    /// Like [`Monitor::update`]; what the monitor was before its restart is kept for a later run, which then
    /// compares it with that as well.
    ///
    /// # Errors
    ///
    /// As [`Monitor::update`]; [`UpdateError::Note`] if `keep` fails: then nothing was committed.
    pub async fn update_with(
        &self,
        images: &[Image],
        trial: &Trial<'_>,
        told: impl FnMut(Stage),
    ) -> Result<Updated, UpdateError> {
        Sender::new(self, trial, told).run(images).await
    }
}

/// What an order was answered.
struct Given {
    status: Status,
    report: Option<Report>,
    answers: Answers,
}

impl Given {
    /// The report of an order that was not refused.
    fn report(self) -> Result<Report, Error> {
        match self.report {
            Some(report) if self.status.is_success() => Ok(report),
            _ => Err(self.refused()),
        }
    }

    fn refused(&self) -> Error {
        let answer = self.answers.first();
        match answer.status().is_success() {
            true => wrong_shape(answer),
            false => self.answers.refused(answer),
        }
    }
}

/// Sends an order once.
async fn give(monitor: &Monitor, order: &Order<'_>) -> Result<Given, Error> {
    let mut buffer = [0; ORDER_MAX];
    let data = order.encode(&mut buffer).unwrap_or_default();
    let body = Body::Unknown { request: RequestId::UPDATE, data };
    let asked = monitor.client().request(&Request::new(SubsystemId::GENERAL, body)).await;
    let answers = match asked {
        Err(error) if order.is_read() => return Err(of_read(error, monitor.client().endpoint())),
        asked => asked?,
    };
    let answer = answers.first();
    let report = Report::decode(answer.data()).ok().filter(Report::is_possible);
    let status = answer.status();
    Ok(Given { status, report, answers })
}

/// The error of an order that changes nothing, as other requests that read have it.
fn of_read(error: Error, endpoint: &str) -> Error {
    let endpoint: Arc<str> = endpoint.into();
    match error {
        Error::OutcomeUnknown { request, to, cause: Cause::Silence, .. }
        | Error::NotSent { request, to, cause: Cause::Silence } => {
            Error::NoAnswer { request, to, endpoint, tries: 1, stray: None }
        }
        Error::OutcomeUnknown { cause: Cause::Link(source), .. }
        | Error::NotSent { cause: Cause::Link(source), .. } => Error::Link { endpoint, source },
        error => error,
    }
}

/// Whether the same order may be answered a little later.
const fn passes(error: &Error) -> bool {
    match error {
        Error::Closed => false,
        Error::Refused { status, .. } => matches!(*status, Status::BUSY | Status::NO_ROOM),
        error => error.is_no_answer(),
    }
}
