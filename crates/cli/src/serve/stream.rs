//! Frames on a byte stream: a TCP connection, a pseudo-terminal, a pipe inside the process.

use std::io;
use std::time::Duration;

use lafet_device::Source;
use lafet_device::port::{Port, RecordPort};
use lafet_sim::sim::Sim;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};

use super::Bus;

/// Bytes read at a time. The answers to them are written before more is read, which bounds the
/// memory of a connection: each frame of 12 bytes or more has one answer of at most 512.
const CHUNK: usize = 512;

/// Framing of a stream, and the partial frame of each monitor on it.
pub struct Wire {
    source: Source,
    records: bool,
    ports: Vec<Framing>,
}

enum Framing {
    Link(Box<Port>),
    Records(Box<RecordPort>),
}

impl Wire {
    /// Link frames on this interface.
    pub const fn link(source: Source) -> Self {
        Self { source, records: false, ports: Vec::new() }
    }

    /// Bare records on this interface.
    pub const fn records(source: Source) -> Self {
        Self { source, records: true, ports: Vec::new() }
    }

    /// The interface at which the bytes arrive.
    pub const fn source(&self) -> Source {
        self.source
    }

    /// Passes bytes to monitor `number` on the stream; returns its answers.
    pub fn receive(&mut self, number: usize, sim: &mut Sim, bytes: &[u8]) -> Vec<u8> {
        while self.ports.len() <= number {
            self.ports.push(match self.records {
                false => Framing::Link(Box::new(Port::new(self.source))),
                true => Framing::Records(Box::new(RecordPort::new(self.source))),
            });
        }
        match &mut self.ports[number] {
            Framing::Link(port) => sim.receive(port, bytes),
            Framing::Records(port) => sim.receive_records(port, bytes),
        }
    }
}

/// Timeouts of a connection.
pub struct Habits {
    /// Time a peer has to take an answer; after it, the peer or the answer is dropped.
    pub write_timeout: Duration,
    /// Whether a peer that does not take an answer is dropped, not only the answer.
    pub drop_slow: bool,
}

impl Default for Habits {
    fn default() -> Self {
        Self { write_timeout: Duration::from_secs(3), drop_slow: true }
    }
}

/// Answers the frames of a stream until it ends; `heard` is called after each valid frame.
///
/// Bytes that are not a frame, and frames for other addresses, are not answered.
pub async fn serve_stream<S, B: Bus>(
    stream: S,
    mut wire: Wire,
    bus: &B,
    habits: Habits,
    mut heard: impl FnMut(),
) -> io::Result<()>
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    let mut stream = stream;
    let mut chunk = [0; CHUNK];
    loop {
        let count = stream.read(&mut chunk).await?;
        if count == 0 {
            return Ok(());
        }
        let answers = bus.receive(&mut wire, &chunk[..count]);
        if !answers.is_empty() {
            heard();
            let write = tokio::time::timeout(habits.write_timeout, stream.write_all(&answers));
            match write.await {
                Ok(result) => result?,
                Err(_) if habits.drop_slow => return Err(io::ErrorKind::TimedOut.into()),
                Err(_) => {}
            }
        }
        // A peer that sends without pause must not starve the others.
        if count == CHUNK {
            tokio::task::yield_now().await;
        }
    }
}
