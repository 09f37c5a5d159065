//! The way to the monitor, with a clock: a real link, or whatever a test brings.

use std::io;
use std::time::{Duration, Instant};

use lafet_client::transport::Link;
use lafet_client::url::Endpoint;
use tokio::runtime::Handle;

/// Bytes read at once.
const CHUNK: usize = 2048;
/// However fast a simulator's clock is, an answer needs this long to get through two programs.
const WAIT_MIN: Duration = Duration::from_millis(30);

/// Bytes to the monitor and back, and the time that passes meanwhile.
///
/// The tester is plain code that waits; on virtual time nothing really does.
pub trait Line {
    /// Sends bytes as they are; over datagrams, as one.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;
    /// Waits for bytes; none when the time is over.
    fn recv(&mut self, wait_ms: u64) -> io::Result<Vec<u8>>;
    /// Time of the monitor's clock, from any beginning, ms.
    fn now_ms(&self) -> u64;
    /// Each send is one datagram.
    fn is_datagram(&self) -> bool {
        false
    }
    /// The same monitor over a connection more; `None` where there can be one only.
    fn another(&mut self) -> Option<Box<dyn Line>> {
        None
    }
}

/// A link of the client.
///
/// It belongs on a thread of its own (`spawn_blocking`), while the runtime runs on another.
#[derive(Debug)]
pub struct LinkLine {
    link: Link,
    endpoint: Option<Endpoint>,
    handle: Handle,
    start: Instant,
    speed: f64,
}

impl LinkLine {
    /// Takes an open link. `speed` is 1 but for a simulator whose clock is faster.
    pub fn new(link: Link, endpoint: Option<Endpoint>, handle: Handle, speed: f64) -> Self {
        Self { link, endpoint, handle, start: Instant::now(), speed }
    }
}

impl Line for LinkLine {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let send = tokio::time::timeout(Duration::from_secs(5), self.link.send(bytes));
        // A timer is made inside the runtime.
        let _inside = self.handle.enter();
        self.handle.block_on(send).unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
    }

    fn recv(&mut self, wait_ms: u64) -> io::Result<Vec<u8>> {
        let wait = Duration::from_millis(wait_ms).div_f64(self.speed);
        let wait = if wait_ms == 0 { Duration::ZERO } else { wait.max(WAIT_MIN) };
        let mut buffer = [0; CHUNK];
        let link = &mut self.link;
        let read = self
            .handle
            .block_on(async { tokio::time::timeout(wait, link.recv(&mut buffer)).await });
        match read {
            Ok(Ok(len)) => Ok(buffer.get(..len).unwrap_or_default().to_vec()),
            Ok(Err(error)) => Err(error),
            Err(_) => Ok(Vec::new()),
        }
    }

    fn now_ms(&self) -> u64 {
        (self.start.elapsed().as_secs_f64() * 1000.0 * self.speed) as u64
    }

    fn is_datagram(&self) -> bool {
        self.link.is_datagram()
    }

    fn another(&mut self) -> Option<Box<dyn Line>> {
        let endpoint = self.endpoint.clone().filter(|e| matches!(e, Endpoint::Tcp { .. }))?;
        let link = self.handle.block_on(Link::open(&endpoint)).ok()?;
        Some(Box::new(Self::new(link, Some(endpoint), self.handle.clone(), self.speed)))
    }
}
