//! Writing a backup to a monitor: only values that differ, each until it is stored; all are read at
//! the end.

use std::time::Duration;

use lafet_proto::Status;
use lafet_proto::param::{Effect, Param};
use tokio::time::sleep;

use super::Backup;
use crate::error::{Cause, Error};
use crate::monitor::Monitor;
use crate::saving::Saved;

/// Most repetitions while a monitor is busy or does not answer.
const TRIES: u32 = 20;
/// Pause before a repetition.
const PAUSE: Duration = Duration::from_millis(500);

/// A step of a restore.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// This many parameters differ and will be written.
    Plan(usize),
    /// This parameter is being written. If no further step follows, it may or may not be stored.
    Begun(Param),
    /// This parameter is stored.
    Stored(Param),
    /// The monitor is busy or does not answer; this parameter is tried again.
    Again(Param),
    /// All parameters are being read.
    Verifying,
}

/// Result of a restore for a parameter.
#[derive(Clone, Debug)]
pub struct Restored {
    /// The parameter.
    pub param: Param,
    /// Its values before; `None`: not set.
    pub before: Option<Vec<i32>>,
    /// Its values in the backup.
    pub wanted: Vec<i32>,
    /// The result.
    pub verdict: Verdict,
}

/// Result of writing a parameter.
#[derive(Clone, Debug)]
pub enum Verdict {
    /// Reads back as written; the state of its storage.
    Written(Saved),
    /// Not sent, or refused.
    Failed(Error),
    /// Accepted, but reads back as other values.
    ReadsBack(Vec<i32>),
}

impl Restored {
    /// Whether the value takes effect only after a restart.
    pub fn needs_restart(&self) -> bool {
        matches!(self.verdict, Verdict::Written(_)) && self.param.spec().effect == Effect::Restart
    }

    /// Whether the value is as wanted and, as far as the monitor reports, stored.
    pub const fn is_done(&self) -> bool {
        matches!(self.verdict, Verdict::Written(Saved::Stored | Saved::Unconfirmed))
    }
}

impl Monitor {
    /// §3.5 Writes the parameters that differ from `wanted`, and reads them back. `anyway`:
    /// parameters that are written even if they do not differ, because an earlier restore was
    /// interrupted before they were known to be stored.
    ///
    /// After a dropped future the parameters written so far are kept; a second call continues.
    ///
    /// # Errors
    ///
    /// As [`Client::request`](crate::Client::request) while values are read at the start and at the
    /// end, and for the first parameter that is not answered however often it is sent: the line is dead
    /// then, and nothing more is sent. A parameter that is refused is a [`Verdict`], not an error.
    pub async fn restore(
        &self,
        wanted: &[(Param, Vec<i32>)],
        anyway: &[Param],
        mut step: impl FnMut(Step),
    ) -> Result<Vec<Restored>, Error> {
        let mut todo = Vec::new();
        let params: Vec<Param> = wanted.iter().map(|(param, _)| *param).collect();
        for ((param, values), now) in wanted.iter().zip(self.params(&params).await) {
            let before = match now {
                Ok(before) => Some(before),
                Err(error) if error.is_refused() => None,
                Err(error) => return Err(error),
            };
            if before.as_ref() != Some(values) || anyway.contains(param) {
                let wanted = values.clone();
                let verdict = Verdict::ReadsBack(Vec::new());
                todo.push(Restored { param: *param, before, wanted, verdict });
            }
        }
        // Parameters that could cut the connection come last: address and interfaces of the
        // monitor.
        todo.sort_by_key(|one| (shuts_out(one.param), one.param));
        step(Step::Plan(todo.len()));
        let mut incomplete = Vec::new();
        for (index, one) in todo.iter_mut().enumerate() {
            step(Step::Begun(one.param));
            one.verdict = self.write(one, &mut step).await;
            match &one.verdict {
                Verdict::Failed(error) if is_silence(error) => return Err(error.clone()),
                Verdict::Failed(error) if is(error, Status::INCOMPLETE_CONFIG) => {
                    incomplete.push(index);
                }
                Verdict::Written(Saved::Stored) => step(Step::Stored(one.param)),
                _ => {}
            }
        }
        // §2 IncompleteConfig: the monitor keeps the values, and stores them with the last of the
        // set.
        for index in incomplete {
            let Some(one) = todo.get_mut(index) else { continue };
            one.verdict = self.write(one, &mut step).await;
            match &one.verdict {
                Verdict::Failed(error) if is_silence(error) => return Err(error.clone()),
                Verdict::Written(Saved::Stored) => step(Step::Stored(one.param)),
                _ => {}
            }
        }
        step(Step::Verifying);
        self.verify(&mut todo).await?;
        Ok(todo)
    }

    async fn write(&self, one: &Restored, step: &mut impl FnMut(Step)) -> Verdict {
        let spec = one.param.spec();
        let mut tries = 0;
        loop {
            let error = match self.save_param_id(spec.subsystem, spec.id, &one.wanted).await {
                Ok(saved) => return Verdict::Written(saved),
                Err(error) => error,
            };
            // Setting a value twice has the effect of once.
            let passes = error.is_no_answer() || is(&error, Status::BUSY);
            tries += 1;
            if !passes || tries >= TRIES || matches!(error, Error::Closed) {
                return Verdict::Failed(error);
            }
            step(Step::Again(one.param));
            sleep(PAUSE).await;
        }
    }

    async fn verify(&self, todo: &mut [Restored]) -> Result<(), Error> {
        let params: Vec<Param> = todo.iter().map(|one| one.param).collect();
        for (one, now) in todo.iter_mut().zip(self.params(&params).await) {
            if matches!(one.verdict, Verdict::Failed(_)) {
                continue;
            }
            match now {
                Ok(values) if values == one.wanted => {}
                Ok(values) => one.verdict = Verdict::ReadsBack(values),
                Err(error) => one.verdict = Verdict::Failed(error),
            }
        }
        Ok(())
    }
}

impl Backup {
    /// The parameters of subsystems that are present, and those of others.
    pub fn of(&self, present: &[String]) -> (Vec<(Param, Vec<i32>)>, Vec<Param>) {
        let is_there = |param: &Param| present.contains(&param.spec().subsystem.to_string());
        let (there, not): (Vec<_>, Vec<_>) =
            self.values.iter().cloned().partition(|(param, _)| is_there(param));
        (there, not.into_iter().map(|(param, _)| param).collect())
    }
}

/// Parameters after which the monitor may no longer answer this client.
fn shuts_out(param: Param) -> bool {
    matches!(
        param,
        Param::GeneralAddress | Param::GeneralChain | Param::ExternalConnCheck | Param::RadioCheck
    )
}

/// Whether no answer came. A monitor that answers oddly may answer for the next parameter as it should.
const fn is_silence(error: &Error) -> bool {
    let odd = matches!(
        error,
        Error::Protocol { .. } | Error::OutcomeUnknown { cause: Cause::Odd { .. }, .. }
    );
    error.is_no_answer() && !odd
}

fn is(error: &Error, status: Status) -> bool {
    matches!(error, Error::Refused { status: refused, .. } if *refused == status)
}
