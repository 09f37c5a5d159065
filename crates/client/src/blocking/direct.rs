//! A client without a thread: the calling thread serves the connection while it waits.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs, UdpSocket};
use std::sync::Arc;
use std::thread::park_timeout;
use std::time::{Duration, Instant};

use lafet_proto::Request;
use lafet_proto::link::WIRE_MAX;

use crate::answers::{Answers, RequestBuf};
use crate::batch::{fits, well_formed};
use crate::client::{failure, probed};
use crate::engine::{Ended, Reply, SILENT_TRIES_MAX};
use crate::error::Error;
use crate::session::line::Line;
use crate::session::{Config, Now, Outcome, Slot, Stats, Terms, Ticket};
use crate::transport::udp::nobody_listens;
use crate::transport::{CONNECT_TIMEOUT, not_ended};
use crate::url::Endpoint;

/// Pause between two attempts to connect.
const REDIAL: Duration = Duration::from_millis(100);
/// After a pause of this length the connection is checked before it is used.
const IDLE: Duration = Duration::from_millis(10);

/// One request at a time to one monitor over TCP or UDP, without a thread and a runtime: the
/// shortest round trip. Between calls nothing is sent, so that it cannot hold a motion or a
/// subscription, and a Stop waits for the outstanding request. [`super::Client`] has these, and
/// serial ports.
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
    name: Arc<str>,
    line: Line,
    link: Option<Link>,
    lost: Option<Arc<io::Error>>,
    start: Instant,
    used: Now,
    buffer: Vec<u8>,
}

impl Direct {
    /// Connects.
    ///
    /// # Errors
    ///
    /// [`Error::Link`] when there is no connection, or for an unsupported scheme.
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
        let name: Arc<str> = endpoint.to_string().into();
        let link = Link::open(endpoint)
            .map_err(|source| Error::Link { endpoint: name.clone(), source: Arc::new(source) })?;
        let mut line = Line::new(config.of(endpoint));
        line.handle_connected(Now::ZERO);
        let start = Instant::now();
        let (endpoint, link, buffer) = (endpoint.clone(), Some(link), vec![0; 2 * WIRE_MAX]);
        Ok(Self { endpoint, name, line, link, lost: None, start, used: Now::ZERO, buffer })
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
            let ended = Some(self.exchange(vec![request.clone()], first));
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
        let ended = self.exchange(vec![], None);
        probed(&self.name, Some(ended))
    }

    fn exchange(&mut self, requests: Vec<RequestBuf>, first: Option<Ticket>) -> Reply {
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
        }
    }

    /// The outcome of the operation, if it has ended.
    fn ended(&mut self, now: Now, ticket: Ticket) -> Option<Ended> {
        while let Some((ended, outcome)) = self.line.poll_outcome() {
            if ended == ticket {
                self.used = now;
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
        let Some(bytes) = self.line.poll_transmit(now) else { return };
        let Some(link) = &mut self.link else { return };
        if let Err(error) = link.send(&bytes, self.line.config().timeout) {
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
            Ok(None) => {
                let half_open = matches!(self.link, Some(Link::Tcp { .. }));
                if half_open && self.line.silent_tries() >= SILENT_TRIES_MAX {
                    self.lose(io::ErrorKind::TimedOut.into());
                }
            }
            Err(error) => self.lose(error),
        }
        now
    }

    fn received(&mut self, now: Now, count: usize) {
        let bytes = &self.buffer[..count];
        match self.link {
            Some(Link::Udp { .. }) => self.line.handle_datagram(now, bytes),
            _ => self.line.handle_bytes(now, bytes),
        }
    }

    /// Takes the bytes that came since the last call; they may include the end of the connection.
    fn look(&mut self) {
        while let Some(link) = &mut self.link {
            match link.recv_now(&mut self.buffer) {
                Ok(Some(count)) => self.received(self.now(), count),
                Ok(None) => return,
                Err(error) => self.lose(error),
            }
        }
    }

    fn lose(&mut self, error: io::Error) {
        self.link = None;
        self.lost = Some(Arc::new(error));
        self.line.handle_disconnected(self.now());
    }

    fn dial(&mut self, now: Now) {
        match Link::open(&self.endpoint) {
            Ok(link) => {
                self.link = Some(link);
                self.line.handle_connected(now);
            }
            Err(error) => self.lost = Some(Arc::new(error)),
        }
    }
}

/// A blocking socket with its present timeout.
#[derive(Debug)]
enum Link {
    Tcp { stream: TcpStream, waits: Duration },
    Udp { socket: UdpSocket, waits: Duration },
}

impl Link {
    fn open(endpoint: &Endpoint) -> io::Result<Self> {
        let (host, port, datagrams) = match endpoint {
            Endpoint::Tcp { host, port, .. } => (host, *port, false),
            Endpoint::Udp { host, port, .. } => (host, *port, true),
            _ => return Err(io::ErrorKind::Unsupported.into()),
        };
        let mut last = io::Error::from(io::ErrorKind::NotFound);
        for peer in (host.as_str(), port).to_socket_addrs()? {
            match if datagrams { Self::udp(peer) } else { Self::tcp(peer) } {
                Ok(link) => return Ok(link),
                Err(error) => last = error,
            }
        }
        Err(last)
    }

    fn tcp(peer: SocketAddr) -> io::Result<Self> {
        let stream = TcpStream::connect_timeout(&peer, CONNECT_TIMEOUT)?;
        stream.set_nodelay(true)?;
        Ok(Self::Tcp { stream, waits: Duration::ZERO })
    }

    fn udp(peer: SocketAddr) -> io::Result<Self> {
        let any = if peer.is_ipv6() { "[::]:0" } else { "0.0.0.0:0" };
        let socket = UdpSocket::bind(any)?;
        socket.connect(peer)?;
        Ok(Self::Udp { socket, waits: Duration::ZERO })
    }

    /// Sends a frame; waits at most `longest` for a peer that does not read.
    fn send(&mut self, bytes: &[u8], longest: Duration) -> io::Result<()> {
        match self {
            Self::Tcp { stream, waits } => {
                if waits.is_zero() {
                    stream.set_write_timeout(Some(longest))?;
                }
                stream.write_all(bytes)
            }
            Self::Udp { socket, .. } => match socket.send(bytes) {
                Err(error) if nobody_listens(&error) => Ok(()),
                sent => sent.map(|_| ()),
            },
        }
    }

    /// Waits for bytes, at most `time`.
    fn recv(&mut self, buffer: &mut [u8], time: Duration) -> io::Result<Option<usize>> {
        // Usually the timeout is the same as before, and the system call can be left out.
        match self {
            Self::Tcp { stream, waits } if *waits != time => {
                stream.set_read_timeout(Some(time))?;
                *waits = time;
            }
            Self::Udp { socket, waits } if *waits != time => {
                socket.set_read_timeout(Some(time))?;
                *waits = time;
            }
            _ => {}
        }
        self.read(buffer)
    }

    /// Takes bytes that have come already.
    fn recv_now(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>> {
        self.set_nonblocking(true)?;
        let read = self.read(buffer);
        self.set_nonblocking(false)?;
        read
    }

    fn set_nonblocking(&self, on: bool) -> io::Result<()> {
        match self {
            Self::Tcp { stream, .. } => stream.set_nonblocking(on),
            Self::Udp { socket, .. } => socket.set_nonblocking(on),
        }
    }

    fn read(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>> {
        let read = match self {
            Self::Tcp { stream, .. } => stream.read(buffer).and_then(not_ended),
            Self::Udp { socket, .. } => socket.recv(buffer),
        };
        match read {
            Ok(count) => Ok(Some(count)),
            Err(error) if nothing_came(&error) || nobody_listens(&error) => Ok(None),
            Err(error) => Err(error),
        }
    }
}

fn nothing_came(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), WouldBlock | TimedOut | Interrupted)
}
