//! A client without a thread: the calling thread serves the connection while it waits.

mod link;

use std::io;
use std::sync::Arc;
use std::thread::park_timeout;
use std::time::{Duration, Instant};

use lafet_proto::Request;
use lafet_proto::link::WIRE_MAX;

use crate::answers::{Answers, RequestBuf, Requests};
use crate::batch::{fits, well_formed};
use crate::client::{failure, probed};
use crate::engine::{Ended, Reply, SILENT_TRIES_MAX};
use crate::error::Error;
use crate::ports::Adapters;
use crate::session::line::Line;
use crate::session::{Config, Now, Outcome, Slot, Stats, Terms, Ticket};
use crate::transport::door::Visits;
use crate::transport::port::{of_user, with_user};
use crate::url::Endpoint;
use link::Link;

/// Pause between two attempts to connect.
const REDIAL: Duration = Duration::from_millis(100);
/// After a pause of this length the connection is checked before it is used.
const IDLE: Duration = Duration::from_millis(10);
/// Reads of that check.
const LOOKS_MAX: u32 = 64;

/// One request at a time to one monitor over TCP, UDP or a serial port, without a thread and a
/// runtime: the shortest round trip. Between calls nothing is sent or received, so that it cannot
/// hold a motion or a subscription, a Stop waits for the outstanding request, and a bus controller
/// (`role=active`) finds it absent. [`super::Client`] has all of these.
///
/// ```no_run
/// # fn example() -> Result<(), lafet_client::Error> {
/// use lafet_client::blocking::Direct;
/// use lafet_proto::request::Body;
/// use lafet_proto::{Request, SubsystemId};
///
/// let mut client = Direct::connect(&"tcp://192.168.1.50?addr=1".parse()?)?;
/// let answers = client.request(&Request::new(SubsystemId::VERTICAL, Body::GetStatus))?;
/// println!("{:?}", answers.first().decode());
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Direct {
    endpoint: Endpoint,
    adapters: Adapters,
    name: Arc<str>,
    line: Line,
    link: Option<Link>,
    lost: Option<Arc<io::Error>>,
    start: Instant,
    used: Now,
    frame: Vec<u8>,
    buffer: Vec<u8>,
    /// At who only listens on the port that something urgent needs.
    visits: Visits,
}

impl Direct {
    /// Connects.
    ///
    /// # Errors
    ///
    /// [`Error::Link`] when there is no connection, [`Error::NeedsStream`] for `sim:`.
    pub fn connect(endpoint: &Endpoint) -> Result<Self, Error> {
        Self::connect_with(endpoint, Config::default())
    }

    /// Connects with timeouts and limits other than the defaults; addresses and framing are taken
    /// from the endpoint.
    ///
    /// # Errors
    ///
    /// As [`Direct::connect`].
    pub fn connect_with(endpoint: &Endpoint, config: Config) -> Result<Self, Error> {
        if matches!(endpoint, Endpoint::Sim { .. }) {
            return Err(Error::NeedsStream);
        }
        let name: Arc<str> = endpoint.to_string().into();
        let adapters = Adapters::default();
        let link = Link::open(endpoint, false)
            .and_then(|link| adapters.check(endpoint).map(|()| link))
            .map_err(with_user)
            .map_err(|source| Error::Link { endpoint: name.clone(), source: Arc::new(source) })?;
        let mut line = Line::new(config.of(endpoint));
        line.handle_connected(Now::ZERO);
        let start = Instant::now();
        Ok(Self {
            endpoint: endpoint.clone(),
            adapters,
            name,
            line,
            link: Some(link),
            lost: None,
            start,
            used: Now::ZERO,
            frame: Vec::new(),
            buffer: vec![0; 2 * WIRE_MAX],
            visits: Visits::default(),
        })
    }

    /// Counters since the client was created.
    pub fn stats(&self) -> Stats {
        self.line.total()
    }

    /// Sends a request and waits for its answers: see [`crate::Client::request`].
    ///
    /// # Errors
    ///
    /// As [`crate::Client::request`].
    pub fn request(&mut self, request: &Request<'_>) -> Result<Answers, Error> {
        let request = RequestBuf::new(request)?;
        let mut first = None;
        loop {
            let ended = Some(self.exchange(Requests::from_buf([request.clone()]), first));
            let Some(Ok(Ended { outcome: Outcome::Answered(slots), ticket, .. })) = ended else {
                return Err(failure(&self.name, &request, &ended));
            };
            first = first.or(ticket);
            if let Some(Slot::Answered(answers)) = slots.into_iter().next()
                && fits(&answers, &request, 0)
            {
                return well_formed(&self.name, &request, answers);
            }
        }
    }

    /// Sends a presence probe: see [`crate::Client::probe`].
    ///
    /// # Errors
    ///
    /// As [`crate::Client::probe`].
    pub fn probe(&mut self) -> Result<(), Error> {
        let ended = self.exchange(Requests::new(), None);
        probed(&self.name, Some(ended))
    }

    fn exchange(&mut self, requests: Requests, first: Option<Ticket>) -> Reply {
        let mut now = self.now();
        if now.saturating_sub(self.used) > IDLE {
            self.look();
            now = self.now();
        }
        let address = self.line.config().addresses.monitor;
        let terms = Terms { first, ..Terms::default() };
        let ticket = self.line.submit(now, address, terms, requests)?;
        loop {
            if self.link.is_none() {
                self.dial(now);
            }
            self.transmit(now);
            if let Some(ended) = self.ended(now, ticket) {
                return Ok(ended);
            }
            let due = self.line.poll_timeout(now);
            now = self.wait(due.map_or(REDIAL, |due| due.saturating_sub(now)));
            // Usually the answer has come, and nothing else has to be checked.
            if let Some(ended) = self.ended(now, ticket) {
                return Ok(ended);
            }
            self.line.handle_timeout(now);
            self.replace_half_open();
        }
    }

    /// A connection that may be half open is replaced before anything is sent again.
    fn replace_half_open(&mut self) {
        let half_open = self.link.as_ref().is_some_and(Link::can_be_half_open);
        if half_open && self.line.silent_tries() >= SILENT_TRIES_MAX {
            self.lose(io::ErrorKind::TimedOut.into());
        }
    }

    /// The outcome of the operation, if it has ended.
    fn ended(&mut self, now: Now, ticket: Ticket) -> Option<Ended> {
        while let Some((ended, outcome)) = self.line.poll_outcome() {
            if ended == ticket {
                self.used = now;
                if matches!(outcome, Outcome::LinkLost | Outcome::NotConnected) {
                    self.name_user();
                }
                return Some(Ended::new(outcome, Some(ticket), self.lost.clone()));
            }
        }
        None
    }

    fn now(&self) -> Now {
        self.start.elapsed()
    }

    fn transmit(&mut self, now: Now) {
        // One frame at a time: others wait for its answer.
        if !self.line.transmit(now, &mut self.frame) {
            return;
        }
        let Some(link) = &mut self.link else { return };
        if let Err(error) = link.send(&self.frame, self.line.config().timeout) {
            self.lose(error);
        }
    }

    /// Waits for bytes, or until the time given; returns the time afterwards.
    fn wait(&mut self, time: Duration) -> Now {
        let Some(link) = &mut self.link else {
            park_timeout(time.min(REDIAL));
            return self.now();
        };
        if time.is_zero() {
            return self.now();
        }
        let received = link.recv(&mut self.buffer, time);
        let now = self.now();
        match received {
            Ok(Some(count)) => self.received(now, count),
            Ok(None) => {}
            Err(error) => self.lose(error),
        }
        now
    }

    fn received(&mut self, now: Now, count: usize) {
        let bytes = &self.buffer[..count];
        match self.link.as_ref().is_some_and(Link::is_datagram) {
            true => self.line.handle_datagram(now, bytes),
            false => self.line.handle_bytes(now, bytes),
        }
    }

    /// Takes the bytes that came since the last call; they may include the end of the connection. Of a
    /// peer that sends without a pause the rest is left for the next call.
    fn look(&mut self) {
        for _ in 0..LOOKS_MAX {
            let Some(link) = &mut self.link else { return };
            match link.recv_now(&mut self.buffer) {
                Ok(Some(count)) => self.received(self.now(), count),
                Ok(None) => return,
                Err(error) => self.lose(error),
            }
        }
    }

    fn lose(&mut self, error: io::Error) {
        self.link.take().iter().for_each(Link::abandon);
        self.lost = Some(Arc::new(error));
        self.line.handle_disconnected(self.now());
    }

    fn dial(&mut self, now: Now) {
        let same = |link| self.adapters.check(&self.endpoint).map(|()| link);
        let urgent = self.line.is_urgent();
        match Link::open(&self.endpoint, urgent).and_then(same) {
            Ok(link) => {
                self.link = Some(link.visiting(std::mem::take(&mut self.visits)));
                self.line.handle_connected(now);
            }
            Err(error) => {
                if urgent && let Endpoint::Serial { path, .. } = &self.endpoint {
                    self.visits.knock(path);
                }
                self.lost = Some(Arc::new(error));
            }
        }
    }

    /// Names who uses the port in the latest error: once, when nothing is to be sent any more, for it takes up
    /// to a second.
    fn name_user(&mut self) {
        if let Some(named) = self.lost.as_deref().and_then(of_user) {
            self.lost = Some(Arc::new(named));
        }
    }
}
