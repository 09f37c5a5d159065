//! A stream provided by the caller: a simulator in the same process, a test, a tunnel.

use std::fmt;
use std::io;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, DuplexStream};

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

    /// Sends all bytes.
    ///
    /// # Errors
    ///
    /// The error of the system when the connection is lost.
    pub async fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes).await?;
        self.0.flush().await
    }

    /// Waits for bytes.
    ///
    /// # Errors
    ///
    /// The error of the system when the connection is lost; `UnexpectedEof` at its end.
    pub async fn recv(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        super::not_ended(self.0.read(buffer).await?)
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
