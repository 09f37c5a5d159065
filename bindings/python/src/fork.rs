//! What a fork of the process has of its parent.

use std::cell::RefCell;

use lafet_client::transport::lines::{Fork, Identity};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::texts::say;

thread_local! {
    /// That of the thread that forks.
    static FORK: RefCell<Option<Fork>> = const { RefCell::new(None) };
}

/// Before the process forks, in the thread that does.
#[pyfunction]
pub fn before_fork() {
    FORK.replace(Some(Fork::begin()));
}

/// After that, in the same process.
#[pyfunction]
pub fn after_fork_in_parent() {
    FORK.replace(None);
}

/// After that, in the fork: device and number of the open files that are lines of its parent.
#[pyfunction]
pub fn after_fork_in_child() -> Vec<Identity> {
    FORK.take().map(Fork::inherited).unwrap_or_default()
}

/// Something of the process that made it. A fork cannot use it, and leaves it as it is: a thread that the fork
/// does not have may have locked what is in it.
pub struct Own<T> {
    process: u32,
    it: Option<T>,
    /// The text that says so.
    text: &'static str,
}

impl<T> Own<T> {
    /// Part of a connection.
    pub fn new(it: T) -> Self {
        Self::saying("fork", it)
    }

    /// With this text for a fork.
    pub fn saying(text: &'static str, it: T) -> Self {
        Self { process: std::process::id(), it: Some(it), text }
    }

    /// It; an error in a fork.
    pub fn get(&self) -> PyResult<&T> {
        self.here()
            .ok_or_else(|| PyRuntimeError::new_err(say(self.text, &[("process", &self.process)])))
    }

    /// It; `None` in a fork.
    pub fn here(&self) -> Option<&T> {
        self.it.as_ref().filter(|_| self.process == std::process::id())
    }
}

impl<T> Drop for Own<T> {
    fn drop(&mut self) {
        if self.here().is_none() {
            std::mem::forget(self.it.take());
        }
    }
}
