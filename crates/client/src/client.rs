//! Any request to one monitor: a handle to the sessions of a link.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, Weak};

use lafet_proto::link::Check;
use lafet_proto::{Request, SubsystemId};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::{broadcast, watch};
use tokio::time::Instant;

use crate::answers::{Answers, RequestBuf, Requests};
use crate::deviation::Deviation;
use crate::engine::{Ended, Engine, Handle, Job, Reply};
use crate::error::{Cause, Error};
use crate::exchange::Exchange;
use crate::ports::Adapters;
use crate::session::{Config, Outcome, QueueFull, Stats, Ticket, Traced};
use crate::shared::{LinkEvent, LinkState, Shared, lock};
use crate::task::{Redial, Task};
use crate::transport::Link;
use crate::transport::memory::Memory;
use crate::url::{Endpoint, Framing};

/// The controlling side of one monitor. Clones share one connection, also with the clients of the
/// other monitors on the same link: [`Client::at`].
///
/// Stop, Close and Lockout on are sent before waiting requests, and waiting requests that would
/// reverse them are not sent any more. Dropping a future cancels its requests that have not been
/// sent; an urgent request is sent even so, once its future was polled. The connection is closed
/// when the last clone is dropped.
#[derive(Clone, Debug)]
pub struct Client {
    endpoint: Arc<str>,
    pub(crate) config: Arc<Config>,
    address: u8,
    handle: Arc<Handle>,
    pub(crate) shared: Arc<Shared>,
}

impl Client {
    /// Connects. Call it inside a Tokio runtime: the client's task runs there.
    ///
    /// # Errors
    ///
    /// [`Error::Link`] when there is no connection within 5 s, [`Error::NeedsStream`] for `sim:`.
    pub async fn connect(endpoint: &Endpoint) -> Result<Self, Error> {
        Self::connect_with(endpoint, Config::default()).await
    }

    /// Connects with timeouts and limits other than the defaults; addresses, framing and the kind
    /// of line are taken from the endpoint.
    ///
    /// # Errors
    ///
    /// As [`Client::connect`].
    pub async fn connect_with(endpoint: &Endpoint, config: Config) -> Result<Self, Error> {
        if matches!(endpoint, Endpoint::Sim { .. }) {
            return Err(Error::NeedsStream);
        }
        let link = Link::open(endpoint).await.map_err(|source| Error::Link {
            endpoint: endpoint.to_string().into(),
            source: Arc::new(source),
        })?;
        Ok(Self::connect_on(endpoint, link, config))
    }

    /// Uses a link of this endpoint that is open already, as after [`crate::overhear::overhear`]; when
    /// it is lost, the endpoint is opened again.
    pub fn connect_on(endpoint: &Endpoint, link: Link, config: Config) -> Self {
        let name: Arc<str> = endpoint.to_string().into();
        let adapters = Arc::new(Adapters::of(endpoint));
        let config = config.of(endpoint);
        let endpoint = endpoint.clone();
        let redial = Redial::new(move |urgent| {
            let (endpoint, adapters) = (endpoint.clone(), adapters.clone());
            Box::pin(async move { Link::open_same(&endpoint, &adapters, urgent).await })
        });
        Self::start(name, link, Some(redial), config)
    }

    /// Uses an existing stream, which is not reopened when it ends: a simulator in this process, a
    /// tunnel. `name` identifies it in messages.
    pub fn over<S>(name: &str, stream: S, config: Config) -> Self
    where
        S: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        Self::start(name.into(), Link::Memory(Memory::new(stream)), None, config)
    }

    /// Uses a link that is open already and is not reopened.
    pub(crate) fn on_link(name: &str, link: Link, config: Config) -> Self {
        Self::start(name.into(), link, None, config)
    }

    /// Uses streams that `dial` opens: now, and again after each loss.
    ///
    /// # Errors
    ///
    /// [`Error::Link`] when `dial` fails the first time; later it is called again.
    pub async fn dial<S, D, F>(name: &str, mut dial: D, config: Config) -> Result<Self, Error>
    where
        S: AsyncRead + AsyncWrite + Send + Unpin + 'static,
        D: FnMut() -> F + Send + 'static,
        F: Future<Output = io::Result<S>> + Send + 'static,
    {
        let endpoint: Arc<str> = name.into();
        let lost = |source| Error::Link { endpoint: endpoint.clone(), source: Arc::new(source) };
        let link = Link::Memory(Memory::new(dial().await.map_err(lost)?));
        let redial = Redial::new(move |_| {
            let stream = dial();
            Box::pin(async move { stream.await.map(|stream| Link::Memory(Memory::new(stream))) })
        });
        Ok(Self::start(endpoint, link, Some(redial), config))
    }

    fn start(endpoint: Arc<str>, link: Link, redial: Option<Redial>, config: Config) -> Self {
        let config = config.bounded();
        let shared = Arc::new(Shared::default());
        let address = config.addresses.monitor;
        let engine = Engine::new(config.clone(), link, redial.is_some(), shared.clone());
        let engine = Arc::new(Mutex::new(engine));
        tokio::spawn(Task::new(engine.clone(), shared.clone(), redial).run());
        let handle = Arc::new(Handle::new(engine));
        Self { endpoint, config: Arc::new(config), address, handle, shared }
    }

    /// The client of another monitor on the same link. The monitors share the line fairly; each
    /// has its own queue, timeouts and numbers.
    ///
    /// # Errors
    ///
    /// [`Error::Address`] for 0, 255 and this side's own address, and for any other monitor where
    /// the link carries bare records.
    pub fn at(&self, address: u8) -> Result<Self, Error> {
        let own = self.config.addresses.source;
        let alone = self.config.framing == Framing::Records && address != self.address;
        if address == 0 || address == u8::MAX || address == own || alone {
            return Err(Error::Address { address, endpoint: self.endpoint.clone() });
        }
        // Errors name the monitor that is meant. What is no URL is the name of a line.
        let of_it =
            self.endpoint.parse::<Endpoint>().map(|line| line.to(address).to_string().into());
        let endpoint = of_it.unwrap_or_else(|_| self.endpoint.clone());
        Ok(Self { address, endpoint, ..self.clone() })
    }

    /// The name of the link, as given.
    pub fn endpoint(&self) -> &str {
        &self.endpoint
    }

    /// The monitor's address on the link.
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// Whether a monitor is found by its address.
    pub(crate) fn has_addresses(&self) -> bool {
        self.config.framing == Framing::Link
    }

    /// Counters of the exchange with this monitor, and of frames dropped on the link.
    pub fn stats(&self) -> Stats {
        self.engine().stats(self.address)
    }

    /// Counters of the exchange with all monitors of the link.
    pub fn link_stats(&self) -> Stats {
        self.engine().total()
    }

    /// The checksum of frames to this monitor (§L/7): CRC-32C if the monitor was found to support
    /// it.
    pub fn check(&self) -> Check {
        if self.stats().crc32c > 0 { Check::Crc32c } else { Check::Crc16 }
    }

    /// Receives every frame that is sent or received on the link from now on.
    pub fn trace(&self) -> broadcast::Receiver<Traced> {
        self.shared.trace.subscribe()
    }

    /// Receives events of the link from now on: lost, connected again, requests held back,
    /// statistics each second.
    pub fn events(&self) -> broadcast::Receiver<LinkEvent> {
        let events = self.shared.events.subscribe();
        self.engine().turn().signal();
        events
    }

    /// Whether the link is connected, now and after each change.
    pub fn link_state(&self) -> watch::Receiver<LinkState> {
        self.shared.state.subscribe()
    }

    /// Sends a request and waits for its answers. A refusal is an answer: [`Answers::accepted`]
    /// turns it into an error.
    ///
    /// # Errors
    ///
    /// [`Error::Unsendable`] for more than 255 bytes of data. Without a valid answer: for a request
    /// that only reads [`Error::NoAnswer`], [`Error::Link`] or
    /// [`Error::Protocol`]; for any other [`Error::OutcomeUnknown`] if it may have been executed
    /// and [`Error::NotSent`] if it certainly was not. [`Error::Closed`] when the task of the
    /// client has ended.
    pub async fn request(&self, request: &Request<'_>) -> Result<Answers, Error> {
        self.run_one(RequestBuf::new(request)?).await
    }

    /// Like [`Client::request`], for an encoded request.
    ///
    /// # Errors
    ///
    /// As [`Client::request`], except [`Error::Unsendable`].
    pub async fn send(&self, request: RequestBuf) -> Result<Answers, Error> {
        self.run_one(request).await
    }

    /// Sends a presence probe (observed: an empty frame is answered by an empty frame).
    ///
    /// # Errors
    ///
    /// [`Error::Absent`] when no probe is answered, [`Error::NotProbed`] when none may be sent (a
    /// bus controller, a required checksum that is missing), [`Error::Link`] without a connection,
    /// [`Error::Closed`] when the task of the client has ended.
    pub async fn probe(&self) -> Result<(), Error> {
        probed(&self.endpoint, self.exchange(Requests::new(), None, None).await)
    }

    /// Sends a frame; `None` if the task has ended.
    pub(crate) fn exchange(
        &self,
        requests: Requests,
        first: Option<Ticket>,
        expires: Option<Instant>,
    ) -> Exchange<'_> {
        let job = Job::new(self.address, requests, first, expires);
        Exchange::new(self.handle.engine(), &self.shared, job)
    }

    /// The same for a held motion: what it sends is its own.
    pub(crate) fn exchange_of_motion(
        &self,
        requests: Requests,
        expires: Option<Instant>,
    ) -> Exchange<'_> {
        let job = Job::new(self.address, requests, None, expires).of_motion();
        Exchange::new(self.handle.engine(), &self.shared, job)
    }

    fn engine(&self) -> MutexGuard<'_, Engine> {
        lock(self.handle.engine())
    }

    pub(crate) fn failure(&self, request: &RequestBuf, ended: &Option<Reply>) -> Error {
        failure(&self.endpoint, request, ended)
    }

    /// A handle that does not keep the connection open.
    pub(crate) fn downgrade(&self) -> WeakClient {
        let Self { endpoint, config, address, handle, shared } = self.clone();
        WeakClient { endpoint, config, address, handle: Arc::downgrade(&handle), shared }
    }
}

/// A client that does not keep the connection open: see [`Client::downgrade`].
#[derive(Debug)]
pub(crate) struct WeakClient {
    endpoint: Arc<str>,
    config: Arc<Config>,
    address: u8,
    handle: Weak<Handle>,
    shared: Arc<Shared>,
}

impl WeakClient {
    /// The client, if another handle still exists.
    pub fn upgrade(&self) -> Option<Client> {
        let Self { endpoint, config, address, handle, shared } = self;
        let (endpoint, config, shared) = (endpoint.clone(), config.clone(), shared.clone());
        Some(Client { endpoint, config, address: *address, handle: handle.upgrade()?, shared })
    }
}

/// The result of a presence probe.
pub(crate) fn probed(endpoint: &Arc<str>, ended: Option<Reply>) -> Result<(), Error> {
    let endpoint = endpoint.clone();
    match ended {
        None => Err(Error::Closed),
        // Any answer proves that a device is present.
        Some(Ok(Ended { outcome: Outcome::Answered(_) | Outcome::Odd { .. }, .. })) => Ok(()),
        Some(Ok(Ended { outcome: Outcome::Silence { tries, .. }, .. })) => {
            Err(Error::Absent { endpoint, tries })
        }
        Some(Ok(Ended {
            outcome:
                outcome @ (Outcome::CheckMissing
                | Outcome::NoGrant { .. }
                | Outcome::ControllerPresent
                | Outcome::Unreadable),
            ..
        })) => Err(Error::NotProbed { endpoint, cause: bus_cause(&outcome) }),
        Some(Ok(ended)) => Err(Error::Link { endpoint, source: ended.source() }),
        Some(Err(QueueFull)) => Err(Error::Absent { endpoint, tries: 0 }),
    }
}

/// The error for a request without answer.
pub(crate) fn failure(endpoint: &Arc<str>, request: &RequestBuf, ended: &Option<Reply>) -> Error {
    let to = request.to();
    let unknown = |cause| {
        let endpoint = endpoint.clone();
        Error::OutcomeUnknown { request: request.id(), to, endpoint, cause }
    };
    match ended {
        None => Error::Closed,
        Some(Err(QueueFull)) => not_sent(request, Cause::QueueFull),
        Some(Ok(ended)) => match ended.outcome {
            Outcome::Silence { tries, stray } if request.is_read() => {
                let endpoint = endpoint.clone();
                Error::NoAnswer { request: request.id(), to, endpoint, tries, stray }
            }
            Outcome::Unheard { tries } if request.is_read() => {
                let endpoint = endpoint.clone();
                Error::NoAnswer { request: request.id(), to, endpoint, tries, stray: None }
            }
            Outcome::LinkLost | Outcome::NotConnected if request.is_read() => {
                Error::Link { endpoint: endpoint.clone(), source: ended.source() }
            }
            Outcome::Odd { ref what } => odd(request, request.to(), what.clone(), endpoint),
            Outcome::Silence { .. } | Outcome::Answered(_) => unknown(Cause::Silence),
            Outcome::LinkLost => unknown(Cause::Link(ended.source())),
            Outcome::Unheard { .. } => not_sent(request, Cause::Silence),
            Outcome::NotConnected => not_sent(request, Cause::Link(ended.source())),
            Outcome::Expired => not_sent(request, Cause::Expired),
            Outcome::CheckMissing => not_sent(request, Cause::CheckMissing),
            Outcome::NoGrant { .. } | Outcome::ControllerPresent | Outcome::Unreadable => {
                not_sent(request, bus_cause(&ended.outcome))
            }
            Outcome::Superseded { by, sent: true } => unknown(Cause::Superseded { by }),
            Outcome::Superseded { by, sent: false } => not_sent(request, Cause::Superseded { by }),
        },
    }
}

/// The cause for which a session refused to send.
const fn bus_cause(outcome: &Outcome) -> Cause {
    match outcome {
        Outcome::CheckMissing => Cause::CheckMissing,
        Outcome::NoGrant { controller: false } => Cause::NoController,
        Outcome::NoGrant { controller: true } => Cause::NotGranted,
        Outcome::Unreadable => Cause::Unreadable,
        _ => Cause::ControllerPresent,
    }
}

/// The error for an answer that breaks the protocol; a request that changes something may have been
/// executed.
pub(crate) fn odd(
    request: &RequestBuf,
    from: SubsystemId,
    what: Deviation,
    endpoint: &str,
) -> Error {
    let (to, request, is_read) = (request.to(), request.id(), request.is_read());
    if is_read {
        return Error::Protocol { request, from, what };
    }
    Error::OutcomeUnknown {
        request,
        to,
        endpoint: endpoint.into(),
        cause: Cause::Odd { from, what },
    }
}

pub(crate) fn not_sent(request: &RequestBuf, cause: Cause) -> Error {
    Error::NotSent { request: request.id(), to: request.to(), cause }
}
