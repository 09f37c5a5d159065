//! UDP: one datagram = one link frame (ours).

use std::io;
use std::task::{Context, Poll, ready};

use tokio::io::ReadBuf;
use tokio::net::{UdpSocket, lookup_host};

use super::lines::Listed;

/// A socket that receives from one peer only.
#[derive(Debug)]
pub struct Udp {
    socket: UdpSocket,
    _listed: Listed,
}

impl Udp {
    /// Binds a free port, and connects to the first reachable address of the host.
    ///
    /// # Errors
    ///
    /// The error of the system: the name is unknown, or no address of it can be reached from here.
    pub async fn connect(host: &str, port: u16) -> io::Result<Self> {
        let mut last = io::Error::from(io::ErrorKind::NotFound);
        for peer in lookup_host((host, port)).await? {
            let any = if peer.is_ipv6() { "[::]:0" } else { "0.0.0.0:0" };
            let opened = async {
                let socket = UdpSocket::bind(any).await?;
                socket.connect(peer).await?;
                Ok(Self { _listed: Listed::new(&socket), socket })
            };
            match opened.await {
                Ok(udp) => return Ok(udp),
                Err(error) => last = error,
            }
        }
        Err(last)
    }

    /// Sends a datagram. A port without a program on the other side is not an error: the program
    /// may be starting.
    pub fn poll_send(&mut self, cx: &mut Context<'_>, datagram: &[u8]) -> Poll<io::Result<()>> {
        match ready!(self.socket.poll_send(cx, datagram)) {
            Err(error) if nobody_listens(&error) => Poll::Ready(Ok(())),
            other => Poll::Ready(other.map(|_| ())),
        }
    }

    /// Waits for a datagram.
    pub fn poll_recv(
        &mut self,
        cx: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<io::Result<usize>> {
        let mut buffer = ReadBuf::new(buffer);
        loop {
            match ready!(self.socket.poll_recv(cx, &mut buffer)) {
                Err(error) if nobody_listens(&error) => {}
                other => return Poll::Ready(other.map(|()| buffer.filled().len())),
            }
        }
    }
}

/// Whether the peer's host answered an earlier datagram by ICMP because no program listens. The
/// monitor may be starting; the requests without answer show it, and a lost datagram is not a lost
/// connection.
pub fn nobody_listens(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::ConnectionRefused | io::ErrorKind::ConnectionReset)
}
