//! UDP: one datagram = one link frame (ours).

use std::io;

use tokio::net::{UdpSocket, lookup_host};

/// A socket that hears one peer only.
#[derive(Debug)]
pub struct Udp(UdpSocket);

impl Udp {
    /// Takes a free port and the first address of the host that can be reached.
    ///
    /// # Errors
    ///
    /// That of the system: the name is unknown, or no address of it can be reached from here.
    pub async fn connect(host: &str, port: u16) -> io::Result<Self> {
        let mut last = io::Error::from(io::ErrorKind::NotFound);
        for peer in lookup_host((host, port)).await? {
            let any = if peer.is_ipv6() { "[::]:0" } else { "0.0.0.0:0" };
            let opened = async {
                let socket = UdpSocket::bind(any).await?;
                socket.connect(peer).await?;
                Ok(Self(socket))
            };
            match opened.await {
                Ok(udp) => return Ok(udp),
                Err(error) => last = error,
            }
        }
        Err(last)
    }

    /// Sends a datagram.
    ///
    /// # Errors
    ///
    /// That of the system. That no program listens at the other side is no error: it may be
    /// starting.
    pub async fn send(&mut self, datagram: &[u8]) -> io::Result<()> {
        match self.0.send(datagram).await {
            Err(error) if nobody_listens(&error) => Ok(()),
            other => other.map(|_| ()),
        }
    }

    /// Waits for a datagram.
    ///
    /// # Errors
    ///
    /// As [`Udp::send`].
    pub async fn recv(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.0.recv(buffer).await {
                Err(error) if nobody_listens(&error) => {}
                other => return other,
            }
        }
    }
}

/// The peer's host answered an earlier datagram by ICMP: the monitor may be starting. Silence
/// says the same, and a lost datagram is no lost connection.
pub fn nobody_listens(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::ConnectionRefused | io::ErrorKind::ConnectionReset)
}
