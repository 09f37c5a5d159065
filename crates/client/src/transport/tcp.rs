//! A TCP connection: a monitor's own port or a transparent serial server.

use std::io;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
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

    /// Sends as many bytes as there is room for; an error is returned when the rest is sent.
    pub fn send_now(&self, bytes: &[u8]) -> usize {
        self.0.try_write(bytes).unwrap_or(0)
    }

    /// Sends all bytes.
    ///
    /// # Errors
    ///
    /// The error of the system when the connection is lost.
    pub async fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes).await
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
