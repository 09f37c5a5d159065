//! Something that is done with a monitor, to be waited for in a program with or without asyncio.

use std::future::Future;
use std::pin::Pin;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use lafet_client::Answers;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyCFunction, PyList};

use crate::answers::Answer;
use crate::failures::Failure;
use crate::fork::Own;
use crate::hold::Hold;
use crate::link::Link;
use crate::runtime::Threads;
use crate::texts::say;

/// How often Ctrl-C is looked for.
const SIGNALS: Duration = Duration::from_millis(50);

/// What an operation ends with.
pub enum Outcome {
    Link(Link),
    Answers(Answers),
    Values(Vec<i32>),
    Hold(Hold),
    End(String),
    Nothing,
}

type Work = Pin<Box<dyn Future<Output = Result<Outcome, Failure>> + Send>>;

/// Not started before it is waited for.
#[pyclass(frozen, module = "lafet._native")]
pub struct Operation {
    threads: Arc<Threads>,
    work: Own<Mutex<Option<Work>>>,
    /// It goes on when its future is cancelled.
    goes_on: bool,
}

impl Operation {
    pub fn new(
        threads: Arc<Threads>,
        work: impl Future<Output = Result<Outcome, Failure>> + Send + 'static,
    ) -> Self {
        Self { threads, work: Own::new(Mutex::new(Some(Box::pin(work)))), goes_on: false }
    }

    /// A Stop that was asked for is sent, whatever becomes of who asked.
    pub fn despite_cancelling(mut self, urgent: bool) -> Self {
        self.goes_on = urgent;
        self
    }

    fn take(&self) -> PyResult<Work> {
        let taken = self.work.get()?.lock().unwrap_or_else(PoisonError::into_inner).take();
        taken.ok_or_else(|| PyRuntimeError::new_err(say("operation-started", &[])))
    }
}

#[pymethods]
impl Operation {
    /// Waits for the end in this thread. Ctrl-C ends the waiting, and the operation unless it is a Stop,
    /// a Close or a Lockout.
    fn wait<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let work = self.take()?;
        let (done, mut result) = sync_channel(1);
        let task = self.threads.handle().spawn(async move {
            // After Ctrl-C there is no receiver.
            let _ = done.send(work.await);
        });
        loop {
            let waiting = &mut result;
            match py.detach(move || waiting.recv_timeout(SIGNALS)) {
                Ok(result) => return value(py, result),
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(interrupt) = py.check_signals() {
                        // What has not been sent is not sent later, when the program is elsewhere.
                        if !self.goes_on {
                            task.abort();
                        }
                        return Err(interrupt);
                    }
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(PyRuntimeError::new_err(say("operation-lost", &[])));
                }
            }
        }
    }

    /// Begins it; returns an asyncio future. To cancel that ends the operation, unless it
    /// is a Stop, a Close or a Lockout.
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let work = self.take()?;
        let event_loop = py.import("asyncio")?.call_method0("get_running_loop")?;
        let future = event_loop.call_method0("create_future")?;
        let (at, of) = (event_loop.unbind(), future.clone().unbind());
        let threads = self.threads.clone();
        let task = self.threads.handle().spawn(async move {
            let result = work.await;
            threads.deliver(move || settle(at, of, result));
        });
        if self.goes_on {
            return Ok(future);
        }
        let abort = task.abort_handle();
        let ended =
            move |_: &Bound<'_, pyo3::types::PyTuple>,
                  _: Option<&Bound<'_, pyo3::types::PyDict>>| abort.abort();
        future.call_method1(
            "add_done_callback",
            (PyCFunction::new_closure(py, None, None, ended)?,),
        )?;
        Ok(future)
    }
}

/// Hands the result to the event loop. Nothing happens when the interpreter or the loop has ended.
fn settle(event_loop: Py<PyAny>, future: Py<PyAny>, result: Result<Outcome, Failure>) {
    let _ = Python::try_attach(|py| -> PyResult<()> {
        let settle = py.import("lafet._settle")?;
        let call = match value(py, result) {
            Ok(value) => (settle.getattr("result")?, future, value),
            Err(error) => (
                settle.getattr("exception")?,
                future,
                error.into_value(py).into_bound(py).into_any(),
            ),
        };
        event_loop.call_method1(py, "call_soon_threadsafe", call)?;
        Ok(())
    });
}

fn value(py: Python<'_>, result: Result<Outcome, Failure>) -> PyResult<Bound<'_, PyAny>> {
    match result.map_err(|failure| failure.raise(py))? {
        Outcome::Link(link) => Ok(Bound::new(py, link)?.into_any()),
        Outcome::Hold(hold) => Ok(Bound::new(py, hold)?.into_any()),
        Outcome::Answers(answers) => {
            let all = answers.into_iter().map(|answer| Bound::new(py, Answer::from(answer)));
            Ok(PyList::new(py, all.collect::<PyResult<Vec<_>>>()?)?.into_any())
        }
        Outcome::Values(values) => Ok(values.into_pyobject(py)?.into_any()),
        Outcome::End(text) => Ok(text.into_pyobject(py)?.into_any()),
        Outcome::Nothing => Ok(py.None().into_bound(py)),
    }
}
