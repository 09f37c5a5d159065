//! Setting a value and waiting until it is in non-volatile memory (§3.5/9, §3.18/8, ours).
//!
//! A monitor of ours answers Accepted to a value that will be stored, and Ok to one that is stored.
//! The document has only Accepted; a monitor that never answers Ok may write the value at each
//! repetition, so there are few. Meanwhile another client may have set another value, or locked the
//! monitor out: a value is repeated only while it is in force, and the release of a lockout never.

use std::time::Duration;

use lafet_proto::flags::CommonFlags;
use lafet_proto::id::key;
use lafet_proto::request::Body;
use lafet_proto::{Ints, ParamId, Request, Status, SubsystemId};
use tokio::time::sleep;

use crate::answers::{AnswerBuf, Answers};
use crate::error::Error;
use crate::monitor::Monitor;

/// Pauses between a request and its repetitions.
const PAUSES: [Duration; 3] =
    [Duration::from_millis(60), Duration::from_millis(340), Duration::from_millis(1100)];
/// Longest wait for a remote unit to take a parameter, in pauses of `UNIT_PAUSE`.
const UNIT_TRIES: usize = 12;
const UNIT_PAUSE: Duration = Duration::from_millis(150);

/// State of a value that was set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saved {
    /// In non-volatile memory: the monitor answered Ok.
    Stored,
    /// Taken, but not confirmed as stored: a drive may be moving, the value may be on a remote unit,
    /// the monitor may never confirm, the connection was lost, or another client has set another value
    /// since. The release of a lockout that was not stored at once is never confirmed.
    Unconfirmed,
    /// It is in force until the next reset: the monitor cannot write it (ConfigWriteFault).
    WriteFailed,
}

impl Saved {
    /// Name for scripts and JSON.
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
    /// As [`Monitor::set_param`], for the first request. A missing confirmation is not an error:
    /// [`Saved::Unconfirmed`].
    pub async fn save_param(
        &self,
        who: SubsystemId,
        name: &str,
        values: &[i32],
    ) -> Result<Saved, Error> {
        self.save_param_id(who, crate::monitor::param_id(name), values).await
    }

    /// Like [`Monitor::save_param`], with the id of the parameter.
    ///
    /// # Errors
    ///
    /// As [`Monitor::set_param`], for the first request. A missing confirmation is not an error:
    /// [`Saved::Unconfirmed`].
    pub async fn save_param_id(
        &self,
        who: SubsystemId,
        id: ParamId,
        values: &[i32],
    ) -> Result<Saved, Error> {
        let body = Body::SetParam { id, values: Ints::Values(values) };
        self.saved(&Request::new(who, body)).await.map(|(_, saved)| saved)
    }

    /// §3.18 Locks the monitor out, or releases it, and waits until this state would survive a loss
    /// of power. Returns the answers to the first request, which is the one that stops the monitor. A
    /// release is sent once: repeated, it would end a lockout of another client. Whether it is stored,
    /// General then says only by ConfigWriteFault.
    ///
    /// # Errors
    ///
    /// As [`Monitor::lockout`], for the first request.
    pub async fn save_lockout(&self, on: bool) -> Result<(Answers, Saved), Error> {
        self.saved(&Request::lockout(on)).await
    }

    async fn saved(&self, request: &Request<'_>) -> Result<(Answers, Saved), Error> {
        let (answers, saved) = self.save(request).await?;
        match refusal(&answers, owner(request)) {
            None => Ok((answers, saved.unwrap_or(Saved::Unconfirmed))),
            Some(refusal) => Err(answers.refused(refusal)),
        }
    }

    /// Sends a request that changes a stored value (SetParam, Lockout), and waits until it is
    /// stored: at most two seconds and three repetitions, none of them over what another client has
    /// set since. A parameter of a remote unit is repeated until the unit has taken it. Returns the
    /// first answers; `None` if who stores it has refused.
    ///
    /// # Errors
    ///
    /// As [`Client::request`](crate::Client::request), for the first request.
    pub async fn save(&self, request: &Request<'_>) -> Result<(Answers, Option<Saved>), Error> {
        let mut tries = 0;
        let answers = loop {
            let answers = self.client().request(request).await?;
            let refusal = refusal(&answers, owner(request));
            let cached = refusal.is_some_and(|it| it.status() == Status::CACHED);
            if !cached || tries == UNIT_TRIES {
                break answers;
            }
            tries += 1;
            // §3.5/7
            sleep(UNIT_PAUSE).await;
        };
        let saved = match word(&answers, owner(request)) {
            _ if refusal(&answers, owner(request)).is_some() => None,
            Status::OK => Some(Saved::Stored),
            // Each repetition could be another write in the unit.
            _ if tries > 0 => Some(Saved::Unconfirmed),
            // The value is in force, even if the connection is lost now.
            _ => Some(self.confirm(request).await.unwrap_or(Saved::Unconfirmed)),
        };
        Ok((answers, saved))
    }

    /// Repeats an accepted request until Ok says that it is stored.
    async fn confirm(&self, request: &Request<'_>) -> Result<Saved, Error> {
        let mut saved = Saved::Unconfirmed;
        for pause in PAUSES {
            sleep(pause).await;
            if !is_release(request) {
                if !self.is_in_force(request).await? {
                    return Ok(Saved::Unconfirmed);
                }
                let answers = self.client().request(request).await?;
                // After a zero point was taken, the position is a different one (§3.17).
                if refusal(&answers, owner(request)).is_some() {
                    return Ok(Saved::Unconfirmed);
                }
                if word(&answers, owner(request)) == Status::OK {
                    return Ok(Saved::Stored);
                }
            }
            let status = self.status(owner(request)).await?;
            let flags = status.decode().ok().and_then(|answer| answer.data.flags_bits());
            let flags = CommonFlags::from_bits_retain(flags.unwrap_or(0));
            // The flag may belong to another value, but then this one is stored soon.
            let failed = flags.contains(CommonFlags::CONFIG_WRITE_FAULT);
            saved = if failed { Saved::WriteFailed } else { Saved::Unconfirmed };
        }
        Ok(saved)
    }

    /// Whether a parameter has the values that were set: others are those of another client, or wait
    /// for SwitchLimits (§3.17). Other requests set none.
    async fn is_in_force(&self, request: &Request<'_>) -> Result<bool, Error> {
        let Body::SetParam { id, values } = request.body else { return Ok(true) };
        Ok(self.param_id(request.to, id).await?.into_iter().eq(values.iter()))
    }
}

/// The subsystem that stores the value: General for a request to All (§3.18).
fn owner(request: &Request<'_>) -> SubsystemId {
    if request.to == SubsystemId::ALL { SubsystemId::GENERAL } else { request.to }
}

/// Whether it releases the monitor from a lockout.
fn is_release(request: &Request<'_>) -> bool {
    matches!(request.body, Body::Lockout { key: code } if code != key::ENABLE)
}

/// What refused a request. Where the owner took it, others may have nothing to do (a valve that is closed
/// already); a fault of theirs is one all the same. Without the owner's answer, the first refusal.
fn refusal(answers: &Answers, owner: SubsystemId) -> Option<&AnswerBuf> {
    let Some(own) = said(answers, owner) else { return answers.refusal() };
    if !own.status().is_success() {
        return Some(own);
    }
    let idle = |status| matches!(status, Status::DENIED | Status::NOT_SUPPORTED);
    answers.iter().find(|it| !it.status().is_success() && !idle(it.status()))
}

/// What the owner answered.
fn said(answers: &Answers, owner: SubsystemId) -> Option<&AnswerBuf> {
    answers.iter().find(|answer| answer.from() == owner)
}

/// The status that the owner answered; an answer of another subsystem in its name does not count.
fn word(answers: &Answers, owner: SubsystemId) -> Status {
    said(answers, owner).map_or(Status::ACCEPTED, AnswerBuf::status)
}
