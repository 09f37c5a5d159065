//! One UDP datagram is one frame; the answer goes to its sender.

use std::io;
use std::time::Duration;

use lafet_device::Source;
use lafet_proto::link::WIRE_MAX;
use tokio::net::UdpSocket;

use super::Bus;

/// Pause after an error of the socket, so that a lasting one does not keep the processor busy; also
/// the longest wait for room to send.
const REST: Duration = Duration::from_millis(50);

/// Answers datagrams for ever.
pub async fn serve_datagrams(socket: UdpSocket, source: Source, bus: impl Bus) -> io::Result<()> {
    let mut datagram = [0; WIRE_MAX + 1];
    loop {
        // An error of the socket mostly means that a sender has gone; the others continue.
        let Ok((count, sender)) = socket.recv_from(&mut datagram).await else {
            tokio::time::sleep(REST).await;
            continue;
        };
        let answer = bus.datagram(source, &datagram[..count]);
        if let Some(answer) = answer {
            // A datagram that cannot be sent is lost, like any other.
            let _ = tokio::time::timeout(REST, socket.send_to(&answer, sender)).await;
        }
    }
}
