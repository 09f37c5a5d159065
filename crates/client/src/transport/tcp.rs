//! A TCP connection: a monitor's own port or a transparent serial server.

use std::io;
use std::task::{Context, Poll};

use tokio::net::TcpStream;

/// An open connection.
#[derive(Debug)]
pub struct Tcp(TcpStream);

impl Tcp {
    /// Connects.
    ///
    /// # Errors
    ///
    /// The error of the system: the name is unknown, or no address of it accepts the connection.
    pub async fn connect(host: &str, port: u16) -> io::Result<Self> {
        let stream = TcpStream::connect((host, port)).await?;
        // A frame is complete: waiting for more bytes would only add latency.
        stream.set_nodelay(true)?;
        Ok(Self(stream))
    }

    /// Sends the rest of a frame, of which `sent` bytes are gone.
    pub fn poll_send(
        &mut self,
        cx: &mut Context<'_>,
        frame: &[u8],
        sent: &mut usize,
    ) -> Poll<io::Result<()>> {
        super::poll_write_all(&mut self.0, cx, frame, sent)
    }

    /// Waits for bytes; `UnexpectedEof` at the end of the connection.
    pub fn poll_recv(
        &mut self,
        cx: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<io::Result<usize>> {
        super::poll_read(&mut self.0, cx, buffer)
    }
}
