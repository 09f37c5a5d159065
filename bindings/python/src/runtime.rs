//! The threads behind the connections of this process.

use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::PyResult;
use pyo3::exceptions::PyRuntimeError;
use tokio::runtime::{Builder, Handle, Runtime};

use crate::texts::say;

/// What has to happen with the interpreter's lock held.
type Delivery = Box<dyn FnOnce() + Send>;

/// One thread that serves all connections, and one that waits for the interpreter's lock in its place: a
/// program that keeps the lock must not keep a Stop from being sent.
pub struct Threads {
    process: u32,
    runtime: Runtime,
    deliveries: Sender<Delivery>,
}

static THREADS: Mutex<Option<Arc<Threads>>> = Mutex::new(None);

impl Threads {
    /// Those of this process. A fork has none of its parent's threads, so it gets its own.
    pub fn of_this_process() -> PyResult<Arc<Self>> {
        let mut threads = THREADS.lock().unwrap_or_else(PoisonError::into_inner);
        let process = std::process::id();
        if let Some(own) = threads.as_ref().filter(|it| it.process == process) {
            return Ok(own.clone());
        }
        let started = Arc::new(Self::start(process)?);
        if let Some(parents) = threads.replace(started.clone()) {
            // To drop it would wait for threads that do not exist here.
            std::mem::forget(parents);
        }
        Ok(started)
    }

    fn start(process: u32) -> PyResult<Self> {
        let failed =
            |e: std::io::Error| PyRuntimeError::new_err(say("no-thread", &[("error", &e)]));
        let mut builder = Builder::new_multi_thread();
        let builder = builder.worker_threads(1).thread_name("lafet").enable_all();
        let runtime = builder.build().map_err(failed)?;
        let (deliveries, all) = channel::<Delivery>();
        let deliver = move || all.into_iter().for_each(|delivery| delivery());
        std::thread::Builder::new().name("lafet-deliver".into()).spawn(deliver).map_err(failed)?;
        Ok(Self { process, runtime, deliveries })
    }

    pub fn handle(&self) -> &Handle {
        self.runtime.handle()
    }

    /// Has something done on the thread that may wait for the interpreter's lock.
    pub fn deliver(&self, delivery: impl FnOnce() + Send + 'static) {
        // The receiver lives as long as the process.
        let _ = self.deliveries.send(Box::new(delivery));
    }
}
