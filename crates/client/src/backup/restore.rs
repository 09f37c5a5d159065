//! Writing parameters back: only what differs, each until it is stored, and read again at the end.

use std::time::Duration;

use lafet_proto::Status;
use lafet_proto::param::{Effect, Param};
use tokio::time::sleep;

use super::Backup;
use crate::error::Error;
use crate::monitor::Monitor;
use crate::saving::Saved;

/// A monitor that is busy, or not to be reached, is asked again so often.
const TRIES: u32 = 20;
/// Pause before.
const PAUSE: Duration = Duration::from_millis(500);

/// What a restore is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// So many parameters differ and will be written.
    Plan(usize),
    /// This one is being written. If nothing follows, it may or may not be stored.
    Begun(Param),
    /// It is stored.
    Stored(Param),
    /// The monitor is busy or not to be reached; this one is tried again.
    Again(Param),
    /// Everything is read again.
    Verifying,
}

/// What became of a parameter.
#[derive(Clone, Debug)]
pub struct Restored {
    /// Which.
    pub param: Param,
    /// What it was before; `None`: unset.
    pub before: Option<Vec<i32>>,
    /// What it was to be.
    pub wanted: Vec<i32>,
    /// What came of it.
    pub verdict: Verdict,
}

/// What came of writing a parameter.
#[derive(Clone, Debug)]
pub enum Verdict {
    /// It reads back as it should, and this is known of its storage.
    Written(Saved),
    /// It was not written, or not taken.
    Failed(Error),
    /// It was taken, and reads back as something else.
    ReadsBack(Vec<i32>),
}

impl Restored {
    /// The value acts only after a restart.
    pub fn needs_restart(&self) -> bool {
        matches!(self.verdict, Verdict::Written(_)) && self.param.spec().effect == Effect::Restart
    }

    /// It is what it should be, and will be after a loss of power as far as the monitor says.
    pub const fn is_done(&self) -> bool {
        matches!(self.verdict, Verdict::Written(Saved::Stored | Saved::Unconfirmed))
    }
}

impl Monitor {
    /// §3.5 Writes what differs from `wanted`, and reads it again. `anyway`: parameters that are
    /// written also when they read as they should: an earlier restore was cut short before they
    /// were known to be stored.
    ///
    /// A dropped future leaves the parameters that were written; calling it again goes on.
    ///
    /// # Errors
    ///
    /// As [`Client::request`](crate::Client::request) while the present values are read and at the
    /// end; a parameter that cannot be written is a [`Verdict`] and no error.
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
        // What could shut us out comes last: who talks to the monitor, and how.
        todo.sort_by_key(|one| (shuts_out(one.param), one.param));
        step(Step::Plan(todo.len()));
        let mut incomplete = Vec::new();
        for (index, one) in todo.iter_mut().enumerate() {
            step(Step::Begun(one.param));
            one.verdict = self.write(one, &mut step).await;
            match &one.verdict {
                Verdict::Failed(error) if is(error, Status::INCOMPLETE_CONFIG) => {
                    incomplete.push(index);
                }
                Verdict::Written(Saved::Stored) => step(Step::Stored(one.param)),
                _ => {}
            }
        }
        // §2 IncompleteConfig: the monitor keeps the values, and stores them with the last one.
        for index in incomplete {
            let Some(one) = todo.get_mut(index) else { continue };
            one.verdict = self.write(one, &mut step).await;
            if matches!(one.verdict, Verdict::Written(Saved::Stored)) {
                step(Step::Stored(one.param));
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
            // A value that is set twice is the same value.
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
    /// The parameters of subsystems that are there; those of others are left out.
    pub fn of(&self, present: &[String]) -> (Vec<(Param, Vec<i32>)>, Vec<Param>) {
        let is_there = |param: &Param| present.contains(&param.spec().subsystem.to_string());
        let (there, not): (Vec<_>, Vec<_>) =
            self.values.iter().cloned().partition(|(param, _)| is_there(param));
        (there, not.into_iter().map(|(param, _)| param).collect())
    }
}

/// Parameters after which the monitor may not answer us any more.
fn shuts_out(param: Param) -> bool {
    matches!(
        param,
        Param::GeneralAddress | Param::GeneralChain | Param::ExternalConnCheck | Param::RadioCheck
    )
}

fn is(error: &Error, status: Status) -> bool {
    matches!(error, Error::Refused { status: refused, .. } if *refused == status)
}
