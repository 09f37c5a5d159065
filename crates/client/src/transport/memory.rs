//! A stream provided by the caller: a simulator in the same process, a test, a tunnel.

use std::fmt;
use std::io;
use std::pin::Pin;
use std::task::{Context, Poll, ready};

use tokio::io::{AsyncRead, AsyncWrite, DuplexStream};

/// Most bytes under way in each direction of a [`pair`].
const UNDER_WAY_MAX: usize = 64 * 1024;

/// Any readable and writable stream.
trait ReadWrite: AsyncRead + AsyncWrite + Send + Unpin {}

impl<S: AsyncRead + AsyncWrite + Send + Unpin> ReadWrite for S {}

/// A link over any stream.
pub struct Memory(Box<dyn ReadWrite>);

impl Memory {
    /// A link over this stream.
    pub fn new<S: AsyncRead + AsyncWrite + Send + Unpin + 'static>(stream: S) -> Self {
        Self(Box::new(stream))
    }

    /// Sends the rest of a frame, of which `sent` bytes are gone.
    pub fn poll_send(
        &mut self,
        cx: &mut Context<'_>,
        frame: &[u8],
        sent: &mut usize,
    ) -> Poll<io::Result<()>> {
        ready!(super::poll_write_all(&mut self.0, cx, frame, sent))?;
        Pin::new(&mut self.0).poll_flush(cx)
    }

    /// Waits for bytes; `UnexpectedEof` at the end of the stream.
    pub fn poll_recv(
        &mut self,
        cx: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<io::Result<usize>> {
        super::poll_read(&mut self.0, cx, buffer)
    }
}

impl fmt::Debug for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Memory")
    }
}

/// The two ends of a stream inside this process: one for the client, one for the monitor.
pub fn pair() -> (DuplexStream, DuplexStream) {
    tokio::io::duplex(UNDER_WAY_MAX)
}
