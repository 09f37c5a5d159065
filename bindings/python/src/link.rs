//! A connection to one monitor.

use std::str::FromStr;
use std::sync::Arc;
use std::time::Duration;

use lafet_client::{Client, Config, Endpoint, Error, Hold as Lease, Monitor, Toward};
use lafet_proto::{Status, SubsystemId};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use tokio::time::timeout;

use crate::failures::Failure;
use crate::fork::Own;
use crate::hold::Hold;
use crate::operation::{Operation, Outcome};
use crate::requests::{Request, subsystem};
use crate::runtime::Threads;
use crate::texts::say;

/// How long the state is waited for that explains a refusal.
const EXPLAINED: Duration = Duration::from_secs(1);
/// The longest lease of a held motion, s: so long it goes on when nothing renews it.
const LEASE_S: f64 = 2.0;
/// The longest time that an answer is waited for, s: so long a Stop waits for each that goes before it.
const ANSWER_S: f64 = 10.0;

#[pyclass(frozen, module = "lafet._native")]
pub struct Link {
    threads: Arc<Threads>,
    endpoint: String,
    monitor: Own<Monitor>,
}

/// Connects to the monitor at a URL; an answer is waited for as long as `timeout_s`.
#[pyfunction]
#[pyo3(signature = (url, timeout_s=None))]
pub fn connect(url: &str, timeout_s: Option<f64>) -> PyResult<Operation> {
    let threads = Threads::of_this_process()?;
    let timeout = timeout_s.map(|time| seconds(time, ANSWER_S)).transpose()?;
    let url = url.to_owned();
    let own = threads.clone();
    Ok(Operation::new(threads, async move {
        let endpoint = Endpoint::from_str(&url).map_err(Error::from)?;
        let mut config = Config { addresses: endpoint.addresses(), ..Config::default() };
        config.timeout = timeout.unwrap_or(config.timeout);
        let client = Client::connect_with(&endpoint, config).await?;
        Ok(Outcome::Link(Link::new(own, Monitor::new(client))))
    }))
}

/// A time that a program gives.
pub fn seconds(time: f64, longest: f64) -> PyResult<Duration> {
    if time > 0.0 && time <= longest {
        return Ok(Duration::from_secs_f64(time));
    }
    Err(PyValueError::new_err(say("time", &[("time", &time), ("longest", &longest)])))
}

impl Link {
    fn new(threads: Arc<Threads>, monitor: Monitor) -> Self {
        let endpoint = monitor.client().endpoint().to_owned();
        Self { threads, endpoint, monitor: Own::new(monitor) }
    }

    fn monitor(&self) -> PyResult<Monitor> {
        self.monitor.get().cloned()
    }

    fn operation(
        &self,
        work: impl Future<Output = Result<Outcome, Failure>> + Send + 'static,
    ) -> Operation {
        Operation::new(self.threads.clone(), work)
    }
}

#[pymethods]
impl Link {
    /// The URL.
    #[getter]
    fn endpoint(&self) -> &str {
        &self.endpoint
    }

    /// Another monitor on the same line.
    fn at(&self, address: u8) -> PyResult<Self> {
        let monitor = self.monitor()?.at(address);
        let monitor =
            monitor.map_err(|error| Python::attach(|py| Failure::from(error).raise(py)))?;
        Ok(Self::new(self.threads.clone(), monitor))
    }

    /// Sends a request; a refusal is an error, with the reason that the monitor's state shows.
    fn command(&self, request: &Request) -> PyResult<Operation> {
        let (monitor, request) = (self.monitor()?, request.0.clone());
        let urgent = request.is_urgent();
        let operation = self.operation(async move {
            match monitor.client().send(request).await?.accepted() {
                Ok(answers) => Ok(Outcome::Answers(answers)),
                Err(error) => Err(explained(&monitor, error).await),
            }
        });
        Ok(operation.despite_cancelling(urgent))
    }

    /// Sends a request; returns what is answered, refusals too.
    fn send(&self, request: &Request) -> PyResult<Operation> {
        let (monitor, request) = (self.monitor()?, request.0.clone());
        let urgent = request.is_urgent();
        let send = async move { Ok(Outcome::Answers(monitor.client().send(request).await?)) };
        Ok(self.operation(send).despite_cancelling(urgent))
    }

    /// §3.4 The values of a parameter, as soon as the monitor has them.
    fn param(&self, whose: &str, name: &str) -> PyResult<Operation> {
        let (monitor, whose, name) = (self.monitor()?, subsystem(whose)?, name.to_owned());
        Ok(self.operation(async move { Ok(Outcome::Values(monitor.param(whose, &name).await?)) }))
    }

    /// §3.5 Sets a parameter.
    fn set_param(&self, whose: &str, name: &str, values: Vec<i32>) -> PyResult<Operation> {
        let (monitor, whose, name) = (self.monitor()?, subsystem(whose)?, name.to_owned());
        Ok(self.operation(async move {
            match monitor.set_param(whose, &name, &values).await {
                Ok(_) => Ok(Outcome::Nothing),
                Err(error) => Err(explained(&monitor, error).await),
            }
        }))
    }

    /// §3.6 Stores corrections of the elevation.
    fn correction_table(&self, first: u8, corrections: Vec<i8>) -> PyResult<Operation> {
        let monitor = self.monitor()?;
        Ok(self.operation(async move {
            monitor.correction_table(first, &corrections).await?;
            Ok(Outcome::Nothing)
        }))
    }

    /// Begins a motion that lasts while it is renewed.
    fn hold(&self, drive: &str, forward: bool, lease_s: f64) -> PyResult<Operation> {
        let (monitor, lease) = (self.monitor()?, seconds(lease_s, LEASE_S)?);
        let drive = match subsystem(drive)? {
            SubsystemId::HORIZONTAL => monitor.horizontal(),
            SubsystemId::VERTICAL => monitor.vertical(),
            SubsystemId::NOZZLE => monitor.nozzle(),
            _ => return Err(PyValueError::new_err(say("not-a-drive", &[("name", &drive)]))),
        };
        let toward = if forward { Toward::Max } else { Toward::Min };
        let threads = self.threads.clone();
        Ok(self.operation(async move {
            let lease = Lease { lease, first_lease: lease, ..Lease::default() };
            Ok(Outcome::Hold(Hold::new(threads, drive.jog_with(toward, lease)?)))
        }))
    }

    fn __repr__(&self) -> String {
        format!("<lafet link to {}>", self.endpoint)
    }
}

/// A refusal with the state of the monitor that shows its reason, if it is answered soon.
async fn explained(monitor: &Monitor, error: Error) -> Failure {
    let denied = matches!(error, Error::Refused { status: Status::DENIED, .. });
    let state = match denied {
        true => timeout(EXPLAINED, monitor.status_all()).await.ok().and_then(Result::ok),
        false => None,
    };
    Failure { error, state: state.map(Box::new) }
}
