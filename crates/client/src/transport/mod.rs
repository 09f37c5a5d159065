//! Transport of bytes to the monitor and back, regardless of their meaning.

pub mod memory;
pub mod port;
pub mod serial;
pub mod tcp;
pub mod udp;

use std::io;
use std::time::Duration;

use crate::url::Endpoint;

/// Longest time for opening a connection.
pub const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// An open connection to a monitor.
#[derive(Debug)]
pub enum Link {
    /// A TCP connection.
    Tcp(tcp::Tcp),
    /// A UDP socket with a peer.
    Udp(udp::Udp),
    /// A serial port.
    Serial(serial::Serial),
    /// A stream provided by the caller.
    Memory(memory::Memory),
}

impl Link {
    /// Opens the connection of an endpoint.
    ///
    /// # Errors
    ///
    /// The error of the system; `TimedOut` after [`CONNECT_TIMEOUT`]; `Unsupported` for `sim:`. For
    /// a serial port: with a [`PortError`](port::PortError) inside if another program uses it,
    /// permission is missing or it does not exist.
    pub async fn open(endpoint: &Endpoint) -> io::Result<Self> {
        let opening = async {
            match endpoint {
                Endpoint::Tcp { host, port, .. } => {
                    tcp::Tcp::connect(host, *port).await.map(Self::Tcp)
                }
                Endpoint::Udp { host, port, .. } => {
                    udp::Udp::connect(host, *port).await.map(Self::Udp)
                }
                Endpoint::Serial { path, line, .. } => {
                    serial::Serial::open(path, line).map(Self::Serial)
                }
                Endpoint::Sim { .. } => Err(io::ErrorKind::Unsupported.into()),
            }
        };
        tokio::time::timeout(CONNECT_TIMEOUT, opening)
            .await
            .unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
    }

    /// Sends as much as possible without waiting; returns the number of bytes.
    pub fn send_now(&self, frame: &[u8]) -> usize {
        match self {
            Self::Tcp(link) => link.send_now(frame),
            _ => 0,
        }
    }

    /// Sends a whole frame.
    ///
    /// # Errors
    ///
    /// The error of the system when the connection is lost.
    pub async fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        match self {
            Self::Tcp(link) => link.send(frame).await,
            Self::Udp(link) => link.send(frame).await,
            Self::Serial(link) => link.send(frame).await,
            Self::Memory(link) => link.send(frame).await,
        }
    }

    /// Waits for bytes, or for a datagram. At the end of a stream: UnexpectedEof.
    ///
    /// When the future is dropped, nothing is lost.
    ///
    /// # Errors
    ///
    /// The error of the system when the connection is lost; `UnexpectedEof` at the end of a stream.
    pub async fn recv(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(link) => link.recv(buffer).await,
            Self::Udp(link) => link.recv(buffer).await,
            Self::Serial(link) => link.recv(buffer).await,
            Self::Memory(link) => link.recv(buffer).await,
        }
    }

    /// Whether datagrams are received.
    pub const fn is_datagram(&self) -> bool {
        matches!(self, Self::Udp(_))
    }

    /// Whether a peer without answers may be a half-open connection, which only a new connection
    /// can show.
    pub const fn can_be_half_open(&self) -> bool {
        matches!(self, Self::Tcp(_))
    }
}

/// An error for a stream that has ended: its other side is gone.
pub(crate) fn not_ended(read: usize) -> io::Result<usize> {
    if read == 0 { Err(io::ErrorKind::UnexpectedEof.into()) } else { Ok(read) }
}
