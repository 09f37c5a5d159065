//! Errors of the client as exceptions of the package.

use std::sync::atomic::{AtomicBool, Ordering};

use lafet_client::{Error, MonitorStatus};
use lafet_proto::{Status, SubsystemId};
use lafet_texts::{Lang, Shown, Text};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::texts::say;

static RUSSIAN: AtomicBool = AtomicBool::new(false);

/// Sets the language of messages: `en` or `ru`.
#[pyfunction]
pub fn set_language(language: &str) -> PyResult<()> {
    let russian = match language {
        "en" => false,
        "ru" => true,
        _ => return Err(PyValueError::new_err(say("language", &[("language", &language)]))),
    };
    RUSSIAN.store(russian, Ordering::Relaxed);
    Ok(())
}

pub fn language() -> Lang {
    if RUSSIAN.load(Ordering::Relaxed) { Lang::Ru } else { Lang::En }
}

/// A failed operation: the error, and the state of the monitor that explains a refusal.
pub struct Failure {
    pub error: Error,
    pub state: Option<Box<MonitorStatus>>,
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self { error, state: None }
    }
}

impl Failure {
    /// The exception; its class is one of `lafet.errors`.
    pub fn raise(&self, py: Python<'_>) -> PyErr {
        self.exception(py).unwrap_or_else(|broken| broken)
    }

    fn exception(&self, py: Python<'_>) -> PyResult<PyErr> {
        let lang = language();
        let flags = |who: SubsystemId| self.state.as_ref()?.flags(who);
        let text = self.error.explained(&flags).of(lang);
        let class = py.import("lafet.errors")?.getattr(class(&self.error))?;
        let about = PyDict::new(py);
        if let Error::Refused { request, to, status, by } = &self.error {
            about.set_item("request", Shown(request).of(Lang::En))?;
            about.set_item("to", Shown(to).of(Lang::En))?;
            about.set_item("status", name(*status))?;
            about.set_item("by", Shown(by).of(Lang::En))?;
        }
        Ok(PyErr::from_value(class.call((text,), Some(&about))?))
    }
}

/// The name of a status (§2), or its number.
pub fn name(status: Status) -> String {
    status.name().map_or_else(|| format!("{:#06x}", status.0), str::to_owned)
}

fn class(error: &Error) -> &'static str {
    match error {
        Error::Refused { .. } => "Refused",
        Error::NoAnswer { .. } | Error::Absent { .. } | Error::NotProbed { .. } => "NoAnswer",
        Error::OutcomeUnknown { .. } => "OutcomeUnknown",
        Error::NotSent { .. } => "NotSent",
        Error::Link { .. } | Error::Closed => "LinkLost",
        Error::Protocol { .. } => "ProtocolError",
        error if error.is_usage() => "UsageError",
        _ => "Error",
    }
}
