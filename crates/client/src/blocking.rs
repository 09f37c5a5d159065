//! Client and monitor for programs without async; every call blocks until its result.
//!
//! A thread serves the connection, so that a motion that is no longer held is stopped and
//! subscriptions are updated while the caller does something else. Calls inside an async runtime
//! panic, because they would block its other tasks.
//!
//! ```no_run
//! # fn example() -> Result<(), lafet_client::Error> {
//! use lafet_client::blocking::Monitor;
//! use lafet_client::Toward;
//!
//! let monitor = Monitor::connect(&"serial:///dev/ttyUSB0?baud=19200&addr=1".parse()?)?;
//! monitor.deploy()?;
//! println!("{:?}", monitor.status_all()?.deployer);
//! let jog = monitor.vertical().jog(Toward::UP)?;
//! while jog.renew() && still_pressed() {}
//! println!("{:?}", jog.release());
//! # Ok(())
//! # }
//! # fn still_pressed() -> bool { false }
//! ```

mod direct;

use std::future::Future;
use std::io;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use lafet_proto::param::Param;
use lafet_proto::request::{LimitsState, Quench, Seek, Trajectory};
use lafet_proto::status::{DriveStatus, FaultInfo, Hotbed, Limits};
use lafet_proto::{ParamId, Request, Status, SubsystemId};
use tokio::runtime::{Builder, Handle};
use tokio::sync::oneshot;
use tokio::time::sleep;

pub use direct::Direct;

use crate::session::{Config, Stats};
use crate::{
    AnswerBuf, Answers, Endpoint, Error, Hold, JogEnd, MonitorStatus, Progress, StatusSample,
    StatusUpdate, Toward,
};

/// Pause between two checks whether all requests are done.
const LINGER: Duration = Duration::from_millis(5);

/// The thread of a connection; it ends with the last handle.
#[derive(Debug)]
struct Background {
    handle: Handle,
    /// The thread ends when this is dropped.
    _alive: oneshot::Sender<()>,
}

impl Background {
    fn start() -> io::Result<Arc<Self>> {
        let runtime = Builder::new_current_thread().enable_all().build()?;
        let handle = runtime.handle().clone();
        let (alive, ended) = oneshot::channel();
        thread::Builder::new().name("lafet-client".into()).spawn(move || {
            // An error means that all handles are dropped.
            _ = runtime.block_on(ended);
            // Motions that are still held are stopped and urgent requests sent before the end.
            runtime.block_on(async {
                while Handle::current().metrics().num_alive_tasks() > 0 {
                    sleep(LINGER).await;
                }
            });
        })?;
        Ok(Arc::new(Self { handle, _alive: alive }))
    }

    fn wait<T>(&self, future: impl Future<Output = T>) -> T {
        self.handle.block_on(future)
    }
}

/// Any request to one monitor: see [`crate::Client`].
#[derive(Clone, Debug)]
pub struct Client {
    inner: crate::Client,
    thread: Arc<Background>,
}

impl Client {
    /// Connects.
    ///
    /// # Errors
    ///
    /// As [`crate::Client::connect`]; [`Error::Link`] also when no thread can be started.
    pub fn connect(endpoint: &Endpoint) -> Result<Self, Error> {
        Self::connect_with(endpoint, Config::default())
    }

    /// Connects with timeouts and limits other than the defaults.
    ///
    /// # Errors
    ///
    /// As [`Client::connect`].
    pub fn connect_with(endpoint: &Endpoint, config: Config) -> Result<Self, Error> {
        let thread = Background::start().map_err(|source| Error::Link {
            endpoint: endpoint.to_string().into(),
            source: Arc::new(source),
        })?;
        let inner = thread.wait(crate::Client::connect_with(endpoint, config))?;
        Ok(Self { inner, thread })
    }

    /// The client of another monitor on the same link: see [`crate::Client::at`].
    ///
    /// # Errors
    ///
    /// As [`crate::Client::at`].
    pub fn at(&self, address: u8) -> Result<Self, Error> {
        Ok(Self { inner: self.inner.at(address)?, thread: self.thread.clone() })
    }

    /// The asynchronous client that this one uses.
    pub const fn inner(&self) -> &crate::Client {
        &self.inner
    }

    /// Counters of the exchange with this monitor.
    pub fn stats(&self) -> Stats {
        self.inner.stats()
    }

    /// See [`crate::Client::request`].
    ///
    /// # Errors
    ///
    /// As [`crate::Client::request`].
    pub fn request(&self, request: &Request<'_>) -> Result<Answers, Error> {
        self.thread.wait(self.inner.request(request))
    }

    /// See [`crate::Client::batch`].
    pub fn batch(&self, requests: &[Request<'_>]) -> Vec<Result<Answers, Error>> {
        self.thread.wait(self.inner.batch(requests))
    }

    /// See [`crate::Client::complete`].
    pub fn complete(
        &self,
        requests: &[Request<'_>],
        progress: impl FnMut(Progress),
    ) -> Vec<Result<Answers, Error>> {
        self.thread.wait(self.inner.complete(requests, progress))
    }

    /// See [`crate::Client::probe`].
    ///
    /// # Errors
    ///
    /// As [`crate::Client::probe`].
    pub fn probe(&self) -> Result<(), Error> {
        self.thread.wait(self.inner.probe())
    }
}

/// A monitor: see [`crate::Monitor`].
#[derive(Clone, Debug)]
pub struct Monitor {
    client: Client,
    inner: crate::Monitor,
}

/// Declares a method that waits for the asynchronous method of the same name.
macro_rules! waits {
    ($($section:literal $name:ident($($argument:ident: $type:ty),*) -> $result:ty;)*) => {$(
        #[doc = concat!($section, " See [`crate::Monitor::", stringify!($name), "`].")]
        ///
        /// # Errors
        ///
        #[doc = concat!("As [`crate::Monitor::", stringify!($name), "`].")]
        pub fn $name(&self $(, $argument: $type)*) -> Result<$result, Error> {
            self.client.thread.wait(self.inner.$name($($argument),*))
        }
    )*};
}

impl Monitor {
    /// A monitor on an existing client.
    pub fn new(client: Client) -> Self {
        Self { inner: crate::Monitor::new(client.inner.clone()), client }
    }

    /// Connects.
    ///
    /// # Errors
    ///
    /// As [`Client::connect`].
    pub fn connect(endpoint: &Endpoint) -> Result<Self, Error> {
        Client::connect(endpoint).map(Self::new)
    }

    /// The client of this monitor.
    pub const fn client(&self) -> &Client {
        &self.client
    }

    /// Another monitor on the same link: see [`crate::Client::at`].
    ///
    /// # Errors
    ///
    /// As [`crate::Client::at`].
    pub fn at(&self, address: u8) -> Result<Self, Error> {
        self.client.at(address).map(Self::new)
    }

    /// The elevation drive.
    pub fn vertical(&self) -> Drive {
        Drive { inner: self.inner.vertical(), thread: self.client.thread.clone() }
    }

    /// The traverse drive.
    pub fn horizontal(&self) -> Drive {
        Drive { inner: self.inner.horizontal(), thread: self.client.thread.clone() }
    }

    /// The drive of the nozzle.
    pub fn nozzle(&self) -> Drive {
        Drive { inner: self.inner.nozzle(), thread: self.client.thread.clone() }
    }

    /// Polls the state: see [`crate::Monitor::watch`].
    ///
    /// # Errors
    ///
    /// As [`crate::Monitor::watch`].
    pub fn watch(&self, period: Duration) -> Result<Watch, Error> {
        let _inside = self.client.thread.handle.enter();
        let inner = self.inner.watch(period)?;
        Ok(Watch { inner, thread: self.client.thread.clone() })
    }

    /// §3.4 The values of many parameters, several in a frame: see [`crate::Monitor::params_with`].
    pub fn params(
        &self,
        which: &[Param],
        progress: impl FnMut(Progress),
    ) -> Vec<Result<Vec<i32>, Error>> {
        self.client.thread.wait(self.inner.params_with(which, progress))
    }

    waits! {
        "§3.1" move_to(drive: SubsystemId, position: i16) -> Status;
        "§3.2" stop(who: SubsystemId) -> Answers;
        "§3.3" status_all() -> MonitorStatus;
        "§3.3" status(who: SubsystemId) -> AnswerBuf;
        "§3.4" param(who: SubsystemId, name: &str) -> Vec<i32>;
        "§3.4" param_id(who: SubsystemId, id: ParamId) -> Vec<i32>;
        "§3.5" set_param(who: SubsystemId, name: &str, values: &[i32]) -> Status;
        "§3.6" correction_table(first: u8, corrections: &[i8]) -> Status;
        "§3.7" limits(drive: SubsystemId) -> Limits;
        "§3.7" limits_all() -> Vec<(SubsystemId, Limits)>;
        "§3.8" open(valve: SubsystemId) -> Status;
        "§3.9" close(valve: SubsystemId) -> Status;
        "§3.10" deploy() -> Status;
        "§3.11" wrap() -> Status;
        "§3.12" restart() -> Answers;
        "§3.13" justify() -> Status;
        "§3.14" quench(quench: Quench<'_>) -> Status;
        "§3.15" trajectory(trajectory: Trajectory<'_>) -> Status;
        "§3.16" seek(seek: Seek) -> Status;
        "§3.17" switch_limits(who: SubsystemId, state: LimitsState) -> Answers;
        "§3.18" lockout(on: bool) -> Answers;
        "§3.19" clean_flash() -> Status;
        "§3.20" crash_data() -> FaultInfo;
        "§3.21" hotbeds() -> Vec<Hotbed>;
    }
}

/// A drive: see [`crate::Drive`].
#[derive(Clone, Debug)]
pub struct Drive {
    inner: crate::Drive,
    thread: Arc<Background>,
}

impl Drive {
    /// §3.1 See [`crate::Drive::move_to`].
    ///
    /// # Errors
    ///
    /// As [`crate::Drive::move_to`].
    pub fn move_to(&self, position: i16) -> Result<Status, Error> {
        self.thread.wait(self.inner.move_to(position))
    }

    /// §3.2 See [`crate::Drive::stop`].
    ///
    /// # Errors
    ///
    /// As [`crate::Drive::stop`].
    pub fn stop(&self) -> Result<Answers, Error> {
        self.thread.wait(self.inner.stop())
    }

    /// §3.3 See [`crate::Drive::status`].
    ///
    /// # Errors
    ///
    /// As [`crate::Drive::status`].
    pub fn status(&self) -> Result<DriveStatus, Error> {
        self.thread.wait(self.inner.status())
    }

    /// §3.7 See [`crate::Drive::limits`].
    ///
    /// # Errors
    ///
    /// As [`crate::Drive::limits`].
    pub fn limits(&self) -> Result<Limits, Error> {
        self.thread.wait(self.inner.limits())
    }

    /// Moves while the caller renews the motion: see [`crate::Drive::jog`].
    ///
    /// # Errors
    ///
    /// As [`crate::Drive::jog`].
    pub fn jog(&self, toward: Toward) -> Result<Jog, Error> {
        self.jog_with(toward, Hold::default())
    }

    /// Like [`Drive::jog`], with times other than the defaults.
    ///
    /// # Errors
    ///
    /// As [`crate::Drive::jog`].
    pub fn jog_with(&self, toward: Toward, hold: Hold) -> Result<Jog, Error> {
        let _inside = self.thread.handle.enter();
        let inner = self.inner.jog_with(toward, hold)?;
        Ok(Jog { inner, thread: self.thread.clone() })
    }
}

/// A motion that lasts while it is renewed: see [`crate::Jog`].
#[derive(Debug)]
pub struct Jog {
    inner: crate::Jog,
    thread: Arc<Background>,
}

impl Jog {
    /// Extends the motion by another lease; `false` if it has ended already. Does not block.
    pub fn renew(&self) -> bool {
        self.inner.renew()
    }

    /// Stops the motion and waits until the drive is at rest; without answers, for up to ten minutes, in
    /// which Stop is sent again and again. To drop it instead stops the motion without a wait.
    pub fn release(self) -> JogEnd {
        let Self { inner, thread } = self;
        thread.wait(inner.release())
    }
}

/// A state that is kept up to date: see [`crate::StatusSubscription`].
#[derive(Debug)]
pub struct Watch {
    inner: crate::StatusSubscription,
    thread: Arc<Background>,
}

impl Watch {
    /// The latest state, with its age; `None` before the first. Does not block.
    pub fn latest(&self) -> Option<StatusSample> {
        self.inner.latest()
    }

    /// Waits for the next update.
    pub fn wait(&mut self) -> StatusUpdate {
        self.thread.wait(self.inner.next())
    }
}
