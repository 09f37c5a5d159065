//! The connections of a client without a runtime.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs, UdpSocket};
use std::time::Duration;

use serial2::SerialPort;

use crate::transport::door::Visits;
use crate::transport::lines::Listed;
use crate::transport::serial::Port;
use crate::transport::tcp::{abandon, limit_delivery};
use crate::transport::udp::nobody_listens;
use crate::transport::{CONNECT_TIMEOUT, not_ended};
use crate::url::Endpoint;

/// Shortest wait for bytes of a serial port.
const SERIAL_LEAST: Duration = Duration::from_millis(1);

/// A blocking socket or port; a socket with its present timeout.
#[derive(Debug)]
pub enum Link {
    Tcp { stream: TcpStream, waits: Duration, _listed: Listed },
    Udp { socket: UdpSocket, waits: Duration, _listed: Listed },
    Serial(Port<SerialPort>),
}

impl Link {
    /// Opens the connection of an endpoint; `Unsupported` for `sim:`. Who uses a port is not looked for.
    pub fn open(endpoint: &Endpoint, urgent: bool) -> io::Result<Self> {
        let (host, port, datagrams) = match endpoint {
            Endpoint::Tcp { host, port, .. } => (host, *port, false),
            Endpoint::Udp { host, port, .. } => (host, *port, true),
            Endpoint::Serial { path, line, .. } => {
                return Port::open_for(urgent, path, line).map(Self::Serial);
            }
            Endpoint::Sim { .. } => return Err(io::ErrorKind::Unsupported.into()),
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
        limit_delivery(&stream)?;
        Ok(Self::Tcp { _listed: Listed::new(&stream), stream, waits: Duration::ZERO })
    }

    fn udp(peer: SocketAddr) -> io::Result<Self> {
        let any = if peer.is_ipv6() { "[::]:0" } else { "0.0.0.0:0" };
        let socket = UdpSocket::bind(any)?;
        socket.connect(peer)?;
        Ok(Self::Udp { _listed: Listed::new(&socket), socket, waits: Duration::ZERO })
    }

    /// Ends visits together with the port.
    pub fn visiting(self, visits: Visits) -> Self {
        match self {
            Self::Serial(port) => Self::Serial(port.visiting(visits)),
            other => other,
        }
    }

    /// Whether datagrams are received.
    pub const fn is_datagram(&self) -> bool {
        matches!(self, Self::Udp { .. })
    }

    /// Whether a peer without answers may be a half-open connection.
    pub const fn can_be_half_open(&self) -> bool {
        matches!(self, Self::Tcp { .. })
    }

    /// See [`crate::transport::Link::abandon`].
    pub fn abandon(&self) {
        if let Self::Tcp { stream, .. } = self {
            abandon(stream);
        }
    }

    /// Sends a frame; waits at most `longest` for a peer that does not read.
    pub fn send(&mut self, bytes: &[u8], longest: Duration) -> io::Result<()> {
        match self {
            Self::Tcp { stream, waits, .. } => {
                if waits.is_zero() {
                    stream.set_write_timeout(Some(longest))?;
                }
                stream.write_all(bytes)
            }
            Self::Udp { socket, .. } => match socket.send(bytes) {
                Err(error) if nobody_listens(&error) => Ok(()),
                sent => sent.map(|_| ()),
            },
            Self::Serial(port) => {
                port.set_write_timeout(longest)?;
                port.write_all(bytes)
            }
        }
    }

    /// Waits for bytes, at most `time`.
    pub fn recv(&mut self, buffer: &mut [u8], time: Duration) -> io::Result<Option<usize>> {
        // Usually the timeout is the same as before, and the system call can be left out.
        match self {
            Self::Tcp { stream, waits, .. } if *waits != time => {
                stream.set_read_timeout(Some(time))?;
                *waits = time;
            }
            Self::Udp { socket, waits, .. } if *waits != time => {
                socket.set_read_timeout(Some(time))?;
                *waits = time;
            }
            // It counts whole milliseconds.
            Self::Serial(port) => port.set_read_timeout(time.max(SERIAL_LEAST))?,
            _ => {}
        }
        self.read(buffer)
    }

    /// Takes bytes that have come already.
    pub fn recv_now(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>> {
        if let Self::Serial(port) = self {
            port.set_read_timeout(Duration::ZERO)?;
            return self.read(buffer);
        }
        self.set_nonblocking(true)?;
        let read = self.read(buffer);
        self.set_nonblocking(false)?;
        read
    }

    fn set_nonblocking(&self, on: bool) -> io::Result<()> {
        match self {
            Self::Tcp { stream, .. } => stream.set_nonblocking(on),
            Self::Udp { socket, .. } => socket.set_nonblocking(on),
            Self::Serial(_) => Ok(()),
        }
    }

    fn read(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>> {
        let read = match self {
            Self::Tcp { stream, .. } => stream.read(buffer).and_then(not_ended),
            Self::Udp { socket, .. } => socket.recv(buffer),
            Self::Serial(port) => port.read(buffer).and_then(not_ended),
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
