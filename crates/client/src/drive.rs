//! One drive of a monitor.

use lafet_proto::answer::Reply;
use lafet_proto::status::{DriveStatus, Limits};
use lafet_proto::{Status, SubsystemId};

use crate::answers::Answers;
use crate::error::Error;
use crate::jog::Jog;
use crate::monitor::{Monitor, typed, wrong_shape};
use crate::session::jog::{Hold, Toward};

/// A drive of a monitor: see [`Monitor::vertical`].
#[derive(Clone, Debug)]
pub struct Drive {
    monitor: Monitor,
    id: SubsystemId,
}

impl Drive {
    pub(crate) const fn new(monitor: Monitor, id: SubsystemId) -> Self {
        Self { monitor, id }
    }

    /// The subsystem of the drive.
    pub const fn id(&self) -> SubsystemId {
        self.id
    }

    /// §3.1 Moves to a position, arc-minutes (nozzle: mm). A position beyond a limit means the
    /// limit.
    ///
    /// # Errors
    ///
    /// As [`Monitor::move_to`].
    pub async fn move_to(&self, position: i16) -> Result<Status, Error> {
        self.monitor.move_to(self.id, position).await
    }

    /// §3.2 Stops the drive. DENIED is possible while the monitor deploys, searches or
    /// extinguishes; [`Monitor::stop`] with All is never denied.
    ///
    /// # Errors
    ///
    /// As [`Monitor::stop`].
    pub async fn stop(&self) -> Result<Answers, Error> {
        self.monitor.stop(self.id).await
    }

    /// §3.3 Reads position, current, speed and flags.
    ///
    /// # Errors
    ///
    /// As [`Monitor::status`].
    pub async fn status(&self) -> Result<DriveStatus, Error> {
        let answer = self.monitor.status(self.id).await?;
        match typed(&answer)? {
            Reply::Drive(status) => Ok(status),
            _ => Err(wrong_shape(&answer)),
        }
    }

    /// §3.7 Reads the limits.
    ///
    /// # Errors
    ///
    /// As [`Monitor::limits`].
    pub async fn limits(&self) -> Result<Limits, Error> {
        self.monitor.limits(self.id).await
    }

    /// Moves while the caller renews the motion (ours): see [`Jog`]. The lease is 300 ms and starts
    /// now. Call it inside a Tokio runtime.
    ///
    /// # Errors
    ///
    /// None in practice: the request always fits a record ([`Error::Unsendable`]). Later errors are
    /// in the [`JogEnd`](crate::JogEnd).
    pub fn jog(&self, toward: Toward) -> Result<Jog, Error> {
        self.jog_with(toward, Hold::default())
    }

    /// Like [`Drive::jog`], with times other than the defaults.
    ///
    /// # Errors
    ///
    /// As [`Drive::jog`].
    pub fn jog_with(&self, toward: Toward, hold: Hold) -> Result<Jog, Error> {
        Jog::start(self.monitor.client(), self.id, toward, hold)
    }
}
