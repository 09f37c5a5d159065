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
    /// be on a remote unit, or this monitor never says so.
    Unconfirmed,
    /// It is in force until the next reset: the monitor cannot write it (ConfigWriteFault).
    WriteFailed,
}

impl Monitor {
    /// §3.5 Sets a parameter by its name, or by its id written as `0x23FE`, and waits until it is
    /// stored: two seconds at most, with three repetitions at most. A parameter of a remote unit
    /// is repeated until the unit has taken it.
    pub async fn save_param(
        &self,
        who: SubsystemId,
        name: &str,
        values: &[i32],
    ) -> Result<Saved, Error> {
        self.save_param_id(who, crate::monitor::param_id(name), values).await
    }

    /// The same, by the id.
    pub async fn save_param_id(
        &self,
        who: SubsystemId,
        id: ParamId,
        values: &[i32],
    ) -> Result<Saved, Error> {
        let body = Body::SetParam { id, values: Ints::Values(values) };
        let request = Request::new(who, body);
        let set = async || Ok(self.client().request(&request).await?.accepted()?.first().status());
        let mut tries = 0;
        let first = loop {
            match set().await {
                // §3.5/7
                Err(error) if is_cached(&error) && tries < UNIT_TRIES => sleep(UNIT_PAUSE).await,
                other => break other?,
            }
            tries += 1;
        };
        match first {
            Status::OK => Ok(Saved::Stored),
            // Each repetition would be one more write for the unit, too.
            _ if tries > 0 => Ok(Saved::Unconfirmed),
            _ => self.confirm(who, set).await,
        }
    }

    /// §3.18 Locks the monitor out, or releases it, and waits until a power loss would not change
    /// that. The answers are those to the first request, which is what stops the monitor.
    pub async fn save_lockout(&self, on: bool) -> Result<(Answers, Saved), Error> {
        let answers = self.lockout(on).await?;
        let lock = async || Ok(general(&self.lockout(on).await?));
        let saved = match general(&answers) {
            Status::OK => Saved::Stored,
            _ => self.confirm(SubsystemId::GENERAL, lock).await?,
        };
        Ok((answers, saved))
    }

    async fn confirm(
        &self,
        owner: SubsystemId,
        again: impl AsyncFn() -> Result<Status, Error>,
    ) -> Result<Saved, Error> {
        let mut saved = Saved::Unconfirmed;
        for pause in PAUSES {
            sleep(pause).await;
            match again().await {
                Ok(Status::OK) => return Ok(Saved::Stored),
                Ok(_) => {}
                // A zero point that was taken is not the present position any more (§3.17).
                Err(error) if error.is_refused() => return Ok(Saved::Unconfirmed),
                Err(error) => return Err(error),
            }
            let status = self.status(owner).await?;
            let flags = status.decode().ok().and_then(|answer| answer.data.flags_bits());
            let flags = CommonFlags::from_bits_retain(flags.unwrap_or(0));
            // The flag may be another value's, but then this one is stored soon.
            let failed = flags.contains(CommonFlags::CONFIG_WRITE_FAULT);
            saved = if failed { Saved::WriteFailed } else { Saved::Unconfirmed };
        }
        Ok(saved)
    }
}

/// What General says; a monitor in whose name somebody else answers has said nothing.
fn general(answers: &Answers) -> Status {
    let general = answers.iter().find(|answer| answer.from() == SubsystemId::GENERAL);
    general.map_or(Status::ACCEPTED, |answer| answer.status())
}

fn is_cached(error: &Error) -> bool {
    matches!(error, Error::Refused { status: Status::CACHED, .. })
}
