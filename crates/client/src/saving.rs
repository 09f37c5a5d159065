//! Setting a value and waiting until it stands in non-volatile memory (§3.5/9, §3.18/8, ours).
//!
//! A monitor of ours answers Accepted to what will be stored, and Ok to what is. The document knows
//! Accepted only; a monitor that never says more has each repetition to write, perhaps, so there are
//! few of them.

use std::time::Duration;

use lafet_proto::flags::CommonFlags;
use lafet_proto::request::Body;
use lafet_proto::{Ints, ParamId, Request, Status, SubsystemId};
use tokio::time::sleep;

use crate::answers::Answers;
use crate::error::Error;
use crate::monitor::Monitor;

/// Times between a request and its repetitions.
const PAUSES: [Duration; 3] =
    [Duration::from_millis(60), Duration::from_millis(340), Duration::from_millis(1100)];
/// How long a remote unit may take for a parameter, in pauses of `UNIT_PAUSE`.
const UNIT_TRIES: usize = 12;
const UNIT_PAUSE: Duration = Duration::from_millis(150);

/// What became of a value that was set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saved {
    /// It stands in non-volatile memory: Ok was answered.
    Stored,
    /// It is in force, and nothing has said that it is stored: a drive may be moving, the value may
    /// be on a remote unit, this monitor may never say so, or the connection is lost since.
    Unconfirmed,
    /// It is in force until the next reset: the monitor cannot write it (ConfigWriteFault).
    WriteFailed,
}

impl Saved {
    /// Its name for programs.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stored => "stored",
            Self::Unconfirmed => "unconfirmed",
            Self::WriteFailed => "write_failed",
        }
    }
}

impl Monitor {
    /// §3.5 Sets a parameter by its name, or by its id written as `0x23FE`, and waits until it is
    /// stored: see [`Monitor::save`].
    ///
    /// # Errors
    ///
    /// As [`Monitor::set_param`], for the first request. That nothing says whether it is stored is
    /// no error: [`Saved::Unconfirmed`].
    pub async fn save_param(
        &self,
        who: SubsystemId,
        name: &str,
        values: &[i32],
    ) -> Result<Saved, Error> {
        self.save_param_id(who, crate::monitor::param_id(name), values).await
    }

    /// The same, by the id.
    ///
    /// # Errors
    ///
    /// As [`Monitor::set_param`], for the first request. That nothing says whether it is stored is
    /// no error: [`Saved::Unconfirmed`].
    pub async fn save_param_id(
        &self,
        who: SubsystemId,
        id: ParamId,
        values: &[i32],
    ) -> Result<Saved, Error> {
        let body = Body::SetParam { id, values: Ints::Values(values) };
        self.saved(&Request::new(who, body)).await.map(|(_, saved)| saved)
    }

    /// §3.18 Locks the monitor out, or releases it, and waits until a power loss would not change
    /// that. The answers are those to the first request, which is what stops the monitor.
    ///
    /// # Errors
    ///
    /// As [`Monitor::lockout`], for the first request.
    pub async fn save_lockout(&self, on: bool) -> Result<(Answers, Saved), Error> {
        self.saved(&Request::lockout(on)).await
    }

    async fn saved(&self, request: &Request<'_>) -> Result<(Answers, Saved), Error> {
        let (answers, saved) = self.save(request).await?;
        Ok((answers.accepted()?, saved.unwrap_or(Saved::Unconfirmed)))
    }

    /// Sends a request that changes what is stored (SetParam, Lockout), and waits until it is
    /// stored: two seconds at most, with three repetitions at most. A parameter of a remote unit
    /// is repeated until the unit has taken it. The answers are the first ones; `None`: refused.
    ///
    /// # Errors
    ///
    /// As [`Client::request`](crate::Client::request), for the first request.
    pub async fn save(&self, request: &Request<'_>) -> Result<(Answers, Option<Saved>), Error> {
        let mut tries = 0;
        let answers = loop {
            let answers = self.client().request(request).await?;
            let cached = answers.refusal().is_some_and(|it| it.status() == Status::CACHED);
            if !cached || tries == UNIT_TRIES {
                break answers;
            }
            tries += 1;
            // §3.5/7
            sleep(UNIT_PAUSE).await;
        };
        let saved = match word(&answers, owner(request)) {
            _ if answers.refusal().is_some() => None,
            Status::OK => Some(Saved::Stored),
            // Each repetition would be one more write for the unit, too.
            _ if tries > 0 => Some(Saved::Unconfirmed),
            // It is in force, whatever becomes of the connection.
            _ => Some(self.confirm(request).await.unwrap_or(Saved::Unconfirmed)),
        };
        Ok((answers, saved))
    }

    /// Repeats what was accepted until Ok says that it is stored.
    async fn confirm(&self, request: &Request<'_>) -> Result<Saved, Error> {
        let mut saved = Saved::Unconfirmed;
        for pause in PAUSES {
            sleep(pause).await;
            let answers = self.client().request(request).await?;
            // A zero point that was taken is not the present position any more (§3.17).
            if answers.refusal().is_some() {
                return Ok(Saved::Unconfirmed);
            }
            if word(&answers, owner(request)) == Status::OK {
                return Ok(Saved::Stored);
            }
            let status = self.status(owner(request)).await?;
            let flags = status.decode().ok().and_then(|answer| answer.data.flags_bits());
            let flags = CommonFlags::from_bits_retain(flags.unwrap_or(0));
            // The flag may be another value's, but then this one is stored soon.
            let failed = flags.contains(CommonFlags::CONFIG_WRITE_FAULT);
            saved = if failed { Saved::WriteFailed } else { Saved::Unconfirmed };
        }
        Ok(saved)
    }
}

/// Who stores it: General for what goes to all (§3.18).
fn owner(request: &Request<'_>) -> SubsystemId {
    if request.to == SubsystemId::ALL { SubsystemId::GENERAL } else { request.to }
}

/// What the owner says; one in whose name somebody else answers has said nothing.
fn word(answers: &Answers, owner: SubsystemId) -> Status {
    let said = answers.iter().find(|answer| answer.from() == owner);
    said.map_or(Status::ACCEPTED, |answer| answer.status())
}
