//! A motion that lasts while it is renewed.

use std::sync::{Arc, Mutex, PoisonError};

use lafet_client::{Error, Jog, JogEnd, Reason};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::operation::{Operation, Outcome};
use crate::runtime::Threads;

#[pyclass(frozen, module = "lafet._native")]
pub struct Hold {
    threads: Arc<Threads>,
    jog: Mutex<Option<Jog>>,
}

impl Hold {
    pub fn new(threads: Arc<Threads>, jog: Jog) -> Self {
        Self { threads, jog: Mutex::new(Some(jog)) }
    }

    fn with<T>(&self, ask: impl FnOnce(Option<&Jog>) -> T) -> T {
        ask(self.jog.lock().unwrap_or_else(PoisonError::into_inner).as_ref())
    }
}

#[pymethods]
impl Hold {
    /// Extends the motion by another lease; false when it is ending or has ended.
    fn renew(&self) -> PyResult<bool> {
        self.threads.check()?;
        Ok(self.with(|jog| jog.is_some_and(Jog::renew)))
    }

    /// Whether the motion is still held.
    #[getter]
    fn held(&self) -> bool {
        self.with(|jog| jog.is_some_and(Jog::is_held))
    }

    /// Stops the motion; ends, with the way it ended, when the drive is at rest.
    fn release(&self) -> PyResult<Operation> {
        self.threads.check()?;
        let jog = self.jog.lock().unwrap_or_else(PoisonError::into_inner).take();
        let jog = jog.ok_or_else(|| PyRuntimeError::new_err("the motion was released already"))?;
        // The Stop goes out at once, whether or not the end is waited for.
        let ending = self.threads.handle().spawn(jog.release());
        Ok(Operation::new(self.threads.clone(), async move {
            let end = ending.await.map_err(|_| Error::Closed)?;
            Ok(Outcome::End(word(end)?.to_owned()))
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
