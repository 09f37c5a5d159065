//! A TCP connection: a monitor's own port or a transparent serial server.

use std::io;
#[cfg(unix)]
use std::os::fd::AsFd;
use std::task::{Context, Poll};

use tokio::net::TcpStream;

use super::lines::Listed;

/// Time after which the system gives up bytes that the peer does not confirm, with the connection.
/// Without a limit it delivers them for a quarter of an hour, even those of a program that was
/// killed: a motion could start long after its sender was stopped.
#[cfg(target_os = "linux")]
const UNCONFIRMED_MAX_MS: u32 = 10_000;

/// An open connection.
#[derive(Debug)]
pub struct Tcp {
    stream: TcpStream,
    _listed: Listed,
}

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
        limit_delivery(&stream)?;
        Ok(Self { _listed: Listed::new(&stream), stream })
    }

    /// Gives up what has been sent and not confirmed: see `abandon`.
    pub fn abandon(&self) {
        abandon(&self.stream);
    }

    /// Sends the rest of a frame, of which `sent` bytes are gone.
    pub fn poll_send(
        &mut self,
        cx: &mut Context<'_>,
        frame: &[u8],
        sent: &mut usize,
    ) -> Poll<io::Result<()>> {
        super::poll_write_all(&mut self.stream, cx, frame, sent)
    }

    /// Waits for bytes; `UnexpectedEof` at the end of the connection.
    pub fn poll_recv(
        &mut self,
        cx: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<io::Result<usize>> {
        super::poll_read(&mut self.stream, cx, buffer)
    }
}

/// Limits the time in which the system tries to deliver bytes.
#[cfg(target_os = "linux")]
pub(crate) fn limit_delivery(stream: impl AsFd) -> io::Result<()> {
    Ok(rustix::net::sockopt::set_tcp_user_timeout(stream, UNCONFIRMED_MAX_MS)?)
}

/// Other systems have no such limit.
#[cfg(not(target_os = "linux"))]
pub(crate) fn limit_delivery<S>(_: S) -> io::Result<()> {
    Ok(())
}

/// What has been sent and not confirmed is not delivered any more once the connection is closed: a
/// Move that another connection has stopped meanwhile must not start.
#[cfg(unix)]
pub(crate) fn abandon(stream: impl AsFd) {
    // Without the option the system's limit applies.
    _ = rustix::net::sockopt::set_socket_linger(stream, Some(std::time::Duration::ZERO));
}

/// Other systems deliver it.
#[cfg(not(unix))]
pub(crate) fn abandon<S>(_: S) {}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[tokio::test]
    async fn delivery_is_limited() {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = listener.local_addr().unwrap().port();
        let tcp = Tcp::connect("127.0.0.1", port).await.unwrap();
        let limit = rustix::net::sockopt::tcp_user_timeout(&tcp.stream).unwrap();
        assert_eq!(limit, UNCONFIRMED_MAX_MS);
    }
}
