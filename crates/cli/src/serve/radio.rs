//! Radio modems between clients and simulated monitors: `lafet sim --radio`.
//!
//! Every connection to a `radio+` listener is a modem on one channel, and so are the monitors. All
//! receive each other, so a bus controller, consoles and programs can be tried on it too.

use std::collections::HashMap;
use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lafet_device::Source;
use lafet_proto::link::WIRE_MAX;
use lafet_sim::radio::{Radio, RadioConfig, Station};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::UdpSocket;
use tokio::sync::{Notify, mpsc};
use tokio::time::{Duration, Instant, sleep_until};

use super::{Bus, Wire};

/// Most packets that a client has not read; further ones are lost.
const UNREAD_MAX: usize = 64;
/// Most senders of datagrams, which have a modem each; the one silent for longest is dropped.
const SENDERS_MAX: usize = 16;

/// The channel shared by all connections.
#[derive(Clone)]
pub struct Air(Arc<Shared>);

struct Shared {
    state: Mutex<State>,
    changed: Notify,
    start: Instant,
}

struct State {
    radio: Radio,
    ways: HashMap<Station, mpsc::Sender<Vec<u8>>>,
}

impl Air {
    /// A channel in real time.
    pub fn new(config: RadioConfig, seed: u64) -> Self {
        let state = State { radio: Radio::new(config, seed), ways: HashMap::new() };
        let (changed, start) = (Notify::new(), Instant::now());
        Self(Arc::new(Shared { state: Mutex::new(state), changed, start }))
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now_us(&self) -> u64 {
        u64::try_from(self.0.start.elapsed().as_micros()).unwrap_or(u64::MAX)
    }

    fn join(&self) -> (Station, mpsc::Receiver<Vec<u8>>) {
        let (way, packets) = mpsc::channel(UNREAD_MAX);
        let mut state = self.lock();
        let station = state.radio.join();
        state.ways.insert(station, way);
        (station, packets)
    }

    fn leave(&self, station: Station) {
        let mut state = self.lock();
        state.radio.leave(station);
        state.ways.remove(&station);
    }

    fn send(&self, station: Station, bytes: &[u8]) {
        self.lock().radio.send(station, self.now_us(), bytes);
        self.0.changed.notify_one();
    }

    /// Carries packets, and delivers to the monitors those that reach them, for ever.
    pub async fn carry(self, bus: impl Bus) -> io::Result<()> {
        let monitors = self.lock().radio.join();
        let mut wire = Wire::link(Source::Radio);
        loop {
            let next = {
                let mut state = self.lock();
                while let Some((to, bytes)) = state.radio.poll(self.now_us()) {
                    if to == monitors {
                        let answers = bus.receive(&mut wire, &bytes);
                        state.radio.send(monitors, self.now_us(), &answers);
                    } else if let Some(way) = state.ways.get(&to) {
                        // A client that does not read loses packets.
                        let _ = way.try_send(bytes);
                    }
                }
                state.radio.next_us()
            };
            let due = next.map(|next| self.0.start + Duration::from_micros(next));
            tokio::select! {
                () = self.0.changed.notified() => {}
                () = until(due) => {}
            }
        }
    }

    /// Runs the modem of a client connected by a stream.
    pub async fn serve_stream(self, stream: impl AsyncRead + AsyncWrite + Unpin) -> io::Result<()> {
        let (station, mut packets) = self.join();
        let (mut reader, mut writer) = tokio::io::split(stream);
        let mut buffer = [0; WIRE_MAX];
        let ended = loop {
            tokio::select! {
                read = reader.read(&mut buffer) => match read {
                    Ok(0) => break Ok(()),
                    Ok(len) => self.send(station, &buffer[..len]),
                    Err(error) => break Err(error),
                },
                Some(packet) = packets.recv() => {
                    if let Err(error) = writer.write_all(&packet).await {
                        break Err(error);
                    }
                }
            }
        };
        self.leave(station);
        ended
    }

    /// Runs the modems of clients that send datagrams, one per sender.
    pub async fn serve_datagrams(self, socket: UdpSocket) -> io::Result<()> {
        let socket = Arc::new(socket);
        let mut senders: Vec<(SocketAddr, Station)> = Vec::new();
        let mut datagram = [0; WIRE_MAX + 1];
        loop {
            // An error of the socket mostly means that a sender has gone; the others continue.
            let Ok((len, from)) = socket.recv_from(&mut datagram).await else {
                tokio::time::sleep(Duration::from_millis(50)).await;
                continue;
            };
            let known = senders.iter().position(|(sender, _)| *sender == from);
            let sender = match known {
                Some(index) => senders.remove(index),
                None => (from, self.datagrams_to(from, socket.clone())),
            };
            if senders.len() >= SENDERS_MAX {
                let (_, silent) = senders.remove(0);
                self.leave(silent);
            }
            senders.push(sender);
            self.send(sender.1, &datagram[..len]);
        }
    }

    /// A modem whose packets are sent as datagrams.
    fn datagrams_to(&self, to: SocketAddr, socket: Arc<UdpSocket>) -> Station {
        let (station, mut packets) = self.join();
        tokio::spawn(async move {
            while let Some(packet) = packets.recv().await {
                // A datagram that cannot be sent is lost, like any other.
                let _ = socket.send_to(&packet, to).await;
            }
        });
        station
    }
}

async fn until(time: Option<Instant>) {
    match time {
        Some(time) => sleep_until(time).await,
        None => std::future::pending().await,
    }
}
