//! A simulated monitor inside this process, at a port of the loopback interface.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use lafet_client::os_text;
use lafet_device::Source;
use lafet_device::image::Axis;
use lafet_device::port::Port;
use lafet_sim::fault::Fault;
use lafet_sim::fire::FireSpec;
use lafet_sim::sim::{Config, Sim};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;

use crate::failures::language;
use crate::fork::Own;
use crate::texts::say;

/// How often the world is brought up to date.
const PACE: Duration = Duration::from_millis(5);
/// How often a connection looks whether the simulator has ended.
const LISTEN: Duration = Duration::from_millis(100);
/// A client that does not take its answers is dropped after this time.
const UNREAD: Duration = Duration::from_secs(1);
/// The strongest wind of a hurricane, m/s.
const WIND_MPS: f64 = 60.0;
/// Most connections at a time.
const CONNECTIONS: usize = 16;
/// What a world that was held up makes up for at once, ms.
const BEHIND_MS: u64 = 1_000;
/// Time that is skipped at once, ms.
const SLICE_MS: u64 = 1_000;
/// The longest time that a program may skip, s: a day.
const SKIP_S: f64 = 86_400.0;

struct Shared {
    sim: Mutex<Sim>,
    ended: AtomicBool,
    connections: AtomicUsize,
}

impl Shared {
    fn sim(&self) -> MutexGuard<'_, Sim> {
        self.sim.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }
}

#[pyclass(frozen, subclass, module = "lafet._native")]
pub struct Simulator {
    shared: Own<Arc<Shared>>,
    url: String,
    life: Mutex<Option<JoinHandle<()>>>,
}

impl Simulator {
    /// Something with the simulation, without the interpreter's lock: a step may have it for a while.
    fn with<T: Send>(&self, py: Python<'_>, ask: impl FnOnce(&mut Sim) -> T + Send) -> PyResult<T> {
        let shared = self.shared.get()?;
        Ok(py.detach(|| ask(&mut shared.sim())))
    }
}

#[pymethods]
impl Simulator {
    /// Builds the world, powers the monitor up and listens.
    #[new]
    #[pyo3(signature = (*, profile=None, fires=Vec::new(), seed=1, address=1, wind=(0.0, 0.0)))]
    fn new(
        profile: Option<&str>,
        fires: Vec<String>,
        seed: u64,
        address: u8,
        wind: (f64, f64),
    ) -> PyResult<Self> {
        let mut config = Config { seed, address, wind, ..Config::default() };
        if let Some(name) = profile {
            let unknown = || PyValueError::new_err(say("no-profile", &[("name", &name)]));
            config.profile(name).ok_or_else(unknown)?;
        }
        if !(1..=127).contains(&address) {
            return Err(PyValueError::new_err(say("address", &[("address", &address)])));
        }
        if wind.0.hypot(wind.1).is_nan() || wind.0.hypot(wind.1) >= WIND_MPS {
            let speed = wind.0.hypot(wind.1);
            let text = say("wind", &[("speed", &speed), ("most", &WIND_MPS)]);
            return Err(PyValueError::new_err(text));
        }
        for fire in fires {
            config.fires.push(spec_of(&fire)?);
        }
        let failed = |error: io::Error| PyOSError::new_err(os_text(&error, language()));
        let listener = TcpListener::bind("127.0.0.1:0").map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let place = listener.local_addr().map_err(failed)?;
        let shared = Arc::new(Shared {
            sim: Mutex::new(Sim::new(config)),
            ended: AtomicBool::new(false),
            connections: AtomicUsize::new(0),
        });
        let own = shared.clone();
        let life = thread::Builder::new().name("lafet-sim".into());
        let life = life.spawn(move || live(&listener, &own)).map_err(failed)?;
        let url = format!("tcp://{place}?addr={address}");
        let shared = Own::saying("fork-of-simulator", shared);
        Ok(Self { shared, url, life: Mutex::new(Some(life)) })
    }

    /// Where it listens.
    #[getter]
    fn url(&self) -> &str {
        &self.url
    }

    /// Simulated time since it was built, s.
    #[getter]
    fn now(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.with(py, |sim| sim.now_ms())? as f64 / 1000.0)
    }

    /// Lets time pass at once, s.
    fn skip(&self, py: Python<'_>, seconds: f64) -> PyResult<()> {
        if !(0.0..=SKIP_S).contains(&seconds) {
            let text = say("skip", &[("seconds", &seconds), ("most", &SKIP_S)]);
            return Err(PyValueError::new_err(text));
        }
        // In slices, so that clients are answered and Ctrl-C is seen meanwhile.
        let mut left = (seconds * 1000.0) as u64;
        while left > 0 {
            let slice = left.min(SLICE_MS);
            self.with(py, |sim| sim.advance_ms(slice))?;
            left -= slice;
            py.check_signals()?;
        }
        Ok(())
    }

    /// Breaks something; returns the faults that there are now.
    fn inject(&self, py: Python<'_>, name: &str) -> PyResult<Vec<String>> {
        let fault = fault(name)?;
        self.with(py, |sim| {
            sim.world_mut().inject(fault);
            active(sim)
        })
    }

    /// Repairs something; returns the faults that are left.
    fn repair(&self, py: Python<'_>, name: &str) -> PyResult<Vec<String>> {
        let fault = fault(name)?;
        self.with(py, |sim| {
            sim.world_mut().clear(fault);
            active(sim)
        })
    }

    /// The names of all faults.
    #[staticmethod]
    fn faults() -> Vec<String> {
        Fault::all().map(Fault::name).collect()
    }

    /// Lights a fire; returns its number.
    fn light(&self, py: Python<'_>, fire: &str) -> PyResult<usize> {
        let spec = spec_of(fire)?;
        self.with(py, |sim| sim.world_mut().light(spec))
    }

    /// Whether each fire burns.
    #[getter]
    fn burning(&self, py: Python<'_>) -> PyResult<Vec<bool>> {
        self.with(py, |sim| sim.world().fires.iter().map(|fire| fire.burns()).collect())
    }

    /// Where a drive truly is: arc-minutes, mm of the nozzle.
    fn position(&self, py: Python<'_>, drive: &str) -> PyResult<f64> {
        let axis = match drive {
            "Vertical" => Axis::Vertical,
            "Horizontal" => Axis::Horizontal,
            "Nozzle" => Axis::Nozzle,
            _ => return Err(PyValueError::new_err(say("not-a-drive", &[("name", &drive)]))),
        };
        self.with(py, |sim| sim.world().drives[axis as usize].position)
    }

    /// Water that leaves the nozzle, l/s.
    #[getter]
    fn flow(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |sim| sim.world().water.jet_lps())
    }

    /// Whether it is truly deployed.
    #[getter]
    fn deployed(&self, py: Python<'_>) -> PyResult<bool> {
        self.with(py, |sim| sim.world().deployed())
    }

    /// Takes its power for a moment.
    fn power_cycle(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, Sim::power_cycle)
    }

    /// Ends it and its connections; nothing in a fork, which has not the threads of its parent.
    fn close(&self, py: Python<'_>) {
        let Some(shared) = self.shared.here() else { return };
        shared.ended.store(true, Ordering::Relaxed);
        let life = self.life.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(life) = life {
            // It ends by itself; a panic of it has been shown.
            let _ = py.detach(|| life.join());
        }
    }
}

impl Drop for Simulator {
    fn drop(&mut self) {
        if let Some(shared) = self.shared.here() {
            shared.ended.store(true, Ordering::Relaxed);
        }
    }
}

fn fault(name: &str) -> PyResult<Fault> {
    Fault::from_name(name).ok_or_else(|| PyValueError::new_err(say("no-fault", &[("name", &name)])))
}

fn active(sim: &Sim) -> Vec<String> {
    sim.world().faults.active().iter().map(|fault| fault.name()).collect()
}

/// The monitor's life, and the connections to it.
fn live(listener: &TcpListener, shared: &Arc<Shared>) {
    let mut last = Instant::now();
    let mut over = Duration::ZERO;
    while !shared.has_ended() {
        let now = Instant::now();
        over += now - last;
        last = now;
        let ms = (over.as_millis() as u64 / 10 * 10).min(BEHIND_MS);
        if ms > 0 {
            shared.sim().advance_ms(ms);
            over = over.saturating_sub(Duration::from_millis(ms)).min(PACE * 2);
        }
        match listener.accept() {
            Ok((stream, _)) => admit(stream, shared),
            Err(_) => thread::park_timeout(PACE),
        }
    }
}

fn admit(stream: TcpStream, shared: &Arc<Shared>) {
    if shared.connections.fetch_add(1, Ordering::Relaxed) >= CONNECTIONS {
        shared.connections.fetch_sub(1, Ordering::Relaxed);
        return;
    }
    let own = shared.clone();
    let served = thread::Builder::new().name("lafet-sim-client".into()).spawn(move || {
        // A connection that breaks is its client's affair.
        let _ = serve(stream, &own);
        own.connections.fetch_sub(1, Ordering::Relaxed);
    });
    if served.is_err() {
        shared.connections.fetch_sub(1, Ordering::Relaxed);
    }
}

fn serve(mut stream: TcpStream, shared: &Shared) -> io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(LISTEN))?;
    stream.set_write_timeout(Some(UNREAD))?;
    let mut port = Port::new(Source::ExternalConn);
    let mut bytes = [0; 512];
    while !shared.has_ended() {
        match stream.read(&mut bytes) {
            Ok(0) => return Ok(()),
            Ok(len) => {
                let answers = shared.sim().receive(&mut port, &bytes[..len]);
                stream.write_all(&answers)?;
            }
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(e) => return Err(e),
        }
    }
    Ok(())
}

/// Reads what a fire is; what is wrong with it is said in the language of the exceptions.
fn spec_of(fire: &str) -> PyResult<FireSpec> {
    let wrong =
        |error: <FireSpec as FromStr>::Err| PyValueError::new_err(error.of(language()).to_owned());
    fire.parse().map_err(wrong)
}
