//! Transport of bytes to the monitor and back, regardless of their meaning.

pub mod door;
pub mod lines;
pub mod memory;
pub mod port;
pub mod serial;
pub mod tcp;
pub mod udp;

use std::future::poll_fn;
use std::io;
use std::path::Path;
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::task::spawn_blocking;
use tokio::time::{Instant, sleep};

use crate::ports::Adapters;
use crate::url::{Endpoint, SerialLine};

/// Longest time for opening a connection.
pub const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
/// How long a port that is in use is tried: its user may be closing it, or looking who has it.
const LETTING_GO: Duration = Duration::from_millis(300);
/// Pause between two attempts to open a port that is in use.
const AGAIN: Duration = Duration::from_millis(10);

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
                    serial_within(LETTING_GO, path, line, false).await.map(Self::Serial)
                }
                Endpoint::Sim { .. } => Err(io::ErrorKind::Unsupported.into()),
            }
        };
        tokio::time::timeout(CONNECT_TIMEOUT, opening)
            .await
            .unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
    }

    /// Opens the connection of an endpoint for what must not wait: who only listens to a serial port
    /// gives way ([`door::giving_way`]), and a port that another program keeps is tried for
    /// [`door::PATIENCE`].
    ///
    /// # Errors
    ///
    /// As [`Link::open`].
    pub async fn open_urgently(endpoint: &Endpoint) -> io::Result<Self> {
        let Endpoint::Serial { path, line, .. } = endpoint else {
            return Self::open(endpoint).await;
        };
        serial_within(door::PATIENCE, path, line, true).await.map(Self::Serial)
    }

    /// Opens the connection of an endpoint again, for something urgent or not: a serial port must have
    /// the same adapter.
    ///
    /// # Errors
    ///
    /// As [`Link::open`], and [`PortError::OtherAdapter`](port::PortError::OtherAdapter).
    pub(crate) async fn open_same(
        endpoint: &Endpoint,
        adapters: &Adapters,
        urgent: bool,
    ) -> io::Result<Self> {
        let link = match urgent {
            true => Self::open_urgently(endpoint).await?,
            false => Self::open(endpoint).await?,
        };
        adapters.check(endpoint)?;
        Ok(link)
    }

    /// Sends a whole frame.
    ///
    /// # Errors
    ///
    /// The error of the system when the connection is lost.
    pub async fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        let mut sent = 0;
        poll_fn(|cx| self.poll_send(cx, frame, &mut sent)).await
    }

    /// Sends the rest of a frame, of which `sent` bytes are gone; counts what it sends there.
    ///
    /// # Errors
    ///
    /// As [`Link::send`].
    pub fn poll_send(
        &mut self,
        cx: &mut Context<'_>,
        frame: &[u8],
        sent: &mut usize,
    ) -> Poll<io::Result<()>> {
        match self {
            Self::Tcp(link) => link.poll_send(cx, frame, sent),
            Self::Udp(link) => link.poll_send(cx, frame),
            Self::Serial(link) => link.poll_send(cx, frame, sent),
            Self::Memory(link) => link.poll_send(cx, frame, sent),
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
        poll_fn(|cx| self.poll_recv(cx, buffer)).await
    }

    /// See [`Link::recv`]; only the waker of the latest call is woken.
    ///
    /// # Errors
    ///
    /// As [`Link::recv`].
    pub fn poll_recv(
        &mut self,
        cx: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<io::Result<usize>> {
        match self {
            Self::Tcp(link) => link.poll_recv(cx, buffer),
            Self::Udp(link) => link.poll_recv(cx, buffer),
            Self::Serial(link) => link.poll_recv(cx, buffer),
            Self::Memory(link) => link.poll_recv(cx, buffer),
        }
    }

    /// Gives up what has been sent and not confirmed: it is not delivered after a connection that
    /// replaces this one.
    pub fn abandon(&self) {
        if let Self::Tcp(link) = self {
            link.abandon();
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

/// Opens a port; as long as it is in use, again and again within `time`, for what is urgent with knocks at the
/// doors of those who have it.
async fn serial_within(
    time: Duration,
    path: &Path,
    line: &SerialLine,
    urgent: bool,
) -> io::Result<serial::Serial> {
    let mut now = Instant::now();
    let (until, mut knock) = (now + time, now);
    let mut visits = door::Visits::default();
    loop {
        match serial::Serial::open_for(urgent, path, line) {
            Err(error) if error.kind() == io::ErrorKind::ResourceBusy && now < until => {
                if urgent && now >= knock {
                    visits.knock(path);
                    knock = now + door::KNOCKS;
                }
                sleep(AGAIN).await;
                now = Instant::now();
            }
            Err(error) => return Err(named(error).await),
            Ok(port) => return Ok(port.visiting(visits)),
        }
    }
}

/// An error with the program that uses the port, which is looked for beside the runtime.
async fn named(error: io::Error) -> io::Error {
    if error.kind() != io::ErrorKind::ResourceBusy {
        return error;
    }
    let named = spawn_blocking(move || port::with_user(error)).await;
    named.unwrap_or_else(|_| io::ErrorKind::ResourceBusy.into())
}

/// Writes the rest of `bytes`, of which `sent` are gone.
fn poll_write_all<S: AsyncWrite + Unpin + ?Sized>(
    stream: &mut S,
    cx: &mut Context<'_>,
    bytes: &[u8],
    sent: &mut usize,
) -> Poll<io::Result<()>> {
    while let Some(rest @ [_, ..]) = bytes.get(*sent..) {
        match ready!(Pin::new(&mut *stream).poll_write(cx, rest))? {
            0 => return Poll::Ready(Err(io::ErrorKind::WriteZero.into())),
            more => *sent += more,
        }
    }
    Poll::Ready(Ok(()))
}

/// Reads bytes; an error at the end of the stream.
fn poll_read<S: AsyncRead + Unpin + ?Sized>(
    stream: &mut S,
    cx: &mut Context<'_>,
    buffer: &mut [u8],
) -> Poll<io::Result<usize>> {
    let mut buffer = ReadBuf::new(buffer);
    ready!(Pin::new(stream).poll_read(cx, &mut buffer))?;
    Poll::Ready(not_ended(buffer.filled().len()))
}

/// An error for a stream that has ended: its other side is gone.
pub(crate) fn not_ended(read: usize) -> io::Result<usize> {
    if read == 0 { Err(io::ErrorKind::UnexpectedEof.into()) } else { Ok(read) }
}
