//! A motion that lasts while it is renewed.

use std::sync::{Arc, Mutex, PoisonError};

use lafet_client::{Error, Jog, JogEnd, Reason};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use tokio::time::timeout;

use crate::fork::Own;
use crate::link::seconds;
use crate::operation::{Operation, Outcome};
use crate::runtime::Threads;
use crate::texts::say;

/// The longest time that the end of a motion is waited for, s.
const WAITS_S: f64 = 600.0;

#[pyclass(frozen, module = "lafet._native")]
pub struct Hold {
    threads: Arc<Threads>,
    jog: Own<Mutex<Option<Jog>>>,
}

impl Hold {
    pub fn new(threads: Arc<Threads>, jog: Jog) -> Self {
        Self { threads, jog: Own::new(Mutex::new(Some(jog))) }
    }

    fn with<T>(&self, ask: impl FnOnce(&mut Option<Jog>) -> T) -> PyResult<T> {
        Ok(ask(&mut self.jog.get()?.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}

#[pymethods]
impl Hold {
    /// Extends the motion by another lease; false when it is ending or has ended.
    fn renew(&self) -> PyResult<bool> {
        self.with(|jog| jog.as_ref().is_some_and(Jog::renew))
    }

    /// Whether the motion is still held.
    #[getter]
    fn held(&self) -> PyResult<bool> {
        self.with(|jog| jog.as_ref().is_some_and(Jog::is_held))
    }

    /// Stops the motion; ends, with the way it ended, when the drive is at rest, and with `unknown` when that
    /// takes longer. Stop is still sent then.
    fn release(&self, within_s: f64) -> PyResult<Operation> {
        let within = seconds(within_s, WAITS_S)?;
        let jog = self.with(Option::take)?;
        let jog = jog.ok_or_else(|| PyRuntimeError::new_err(say("released", &[])))?;
        // The Stop goes out at once, whether or not the end is waited for.
        let ending = self.threads.handle().spawn(jog.release());
        Ok(Operation::new(self.threads.clone(), async move {
            let how = match timeout(within, ending).await {
                Ok(end) => word(end.map_err(|_| Error::Closed)?)?,
                Err(_) => "unknown",
            };
            Ok(Outcome::End(how.to_owned()))
        }))
    }
}

/// The way a motion ended, as a word.
fn word(end: JogEnd) -> Result<&'static str, Error> {
    match end {
        JogEnd::Stopped { reason: Reason::Released, .. } => Ok("released"),
        JogEnd::Stopped { reason: Reason::Lapsed, .. } => Ok("lapsed"),
        JogEnd::Stopped { reason: Reason::LinkLost, .. } => Ok("link lost"),
        JogEnd::Stopped { .. } => Ok("stopped"),
        JogEnd::Standing(_) => Ok("at rest"),
        JogEnd::Replaced => Ok("replaced"),
        JogEnd::TakenOver { .. } => Ok("taken over"),
        JogEnd::StillMoving(_) => Ok("still moving"),
        JogEnd::Unbounded(_) => Ok("not started"),
        JogEnd::Refused(error) | JogEnd::Unknown(error) => Err(error),
        _ => Ok("ended"),
    }
}
