//! The way to the monitor, with a clock: a real link, or whatever a test brings.

use std::fmt;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use lafet_client::transport::Link;
use lafet_client::url::Endpoint;
use tokio::runtime::Handle;

/// Bytes read at once.
const CHUNK: usize = 2048;
/// However fast a simulator's clock is, an answer needs this long to get through two programs.
const WAIT_MIN: Duration = Duration::from_millis(30);

/// For how long a way that was lost is tried, and the pause between two tries.
const REACH: Duration = Duration::from_secs(30);
const REDIAL: Duration = Duration::from_millis(200);

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
    /// Makes the way anew after it was lost, for as long as that makes sense; false where it cannot be
    /// made anew.
    fn renew(&mut self) -> io::Result<bool> {
        Ok(false)
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
    /// None while there is no connection.
    link: Option<Link>,
    datagrams: bool,
    endpoint: Option<Endpoint>,
    handle: Handle,
    start: Instant,
    speed: f64,
    /// Since when nothing has been heard over any connection.
    lost: Option<Instant>,
    cut: Cut,
}

/// What is done when the way is lost while the monitor may move.
#[derive(Clone, Default)]
pub struct Cut {
    /// Tells the user, once.
    pub tell: Option<Arc<dyn Fn() + Send + Sync>>,
    /// Set from outside: nothing is tried any more.
    pub give_up: Arc<AtomicBool>,
}

impl fmt::Debug for Cut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Cut")
    }
}

impl LinkLine {
    /// Takes an open link. `speed` is 1 but for a simulator whose clock is faster.
    pub fn new(link: Link, endpoint: Option<Endpoint>, handle: Handle, speed: f64) -> Self {
        let (datagrams, start, cut) = (link.is_datagram(), Instant::now(), Cut::default());
        Self { link: Some(link), datagrams, endpoint, handle, start, speed, lost: None, cut }
    }

    /// What is done when the way is lost.
    #[must_use]
    pub fn when_cut(self, cut: Cut) -> Self {
        Self { cut, ..self }
    }
}

impl Line for LinkLine {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let Some(link) = &mut self.link else { return Err(io::ErrorKind::NotConnected.into()) };
        let send = tokio::time::timeout(Duration::from_secs(5), link.send(bytes));
        // A timer is made inside the runtime.
        let _inside = self.handle.enter();
        self.handle.block_on(send).unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
    }

    fn recv(&mut self, wait_ms: u64) -> io::Result<Vec<u8>> {
        let wait = Duration::from_millis(wait_ms).div_f64(self.speed);
        let wait = if wait_ms == 0 { Duration::ZERO } else { wait.max(WAIT_MIN) };
        let mut buffer = [0; CHUNK];
        let Some(link) = &mut self.link else { return Err(io::ErrorKind::NotConnected.into()) };
        let read = self
            .handle
            .block_on(async { tokio::time::timeout(wait, link.recv(&mut buffer)).await });
        match read {
            Ok(Ok(len)) => {
                self.lost = None;
                Ok(buffer.get(..len).unwrap_or_default().to_vec())
            }
            Ok(Err(error)) => Err(error),
            Err(_) => Ok(Vec::new()),
        }
    }

    fn now_ms(&self) -> u64 {
        (self.start.elapsed().as_secs_f64() * 1000.0 * self.speed) as u64
    }

    fn is_datagram(&self) -> bool {
        self.datagrams
    }

    fn renew(&mut self) -> io::Result<bool> {
        let Some(endpoint) = &self.endpoint else { return Ok(false) };
        if let Some(tell) = self.cut.tell.take() {
            tell();
        }
        // A port is free again only when nobody has it.
        self.link = None;
        let until = *self.lost.get_or_insert_with(Instant::now) + REACH;
        let mut last = io::ErrorKind::TimedOut.into();
        loop {
            self.handle.block_on(async { tokio::time::sleep(REDIAL).await });
            if self.cut.give_up.load(Ordering::Relaxed) {
                return Err(io::ErrorKind::Interrupted.into());
            }
            if Instant::now() >= until {
                // Nothing else is waited for so long again.
                self.cut.give_up.store(true, Ordering::Relaxed);
                return Err(last);
            }
            match self.handle.block_on(Link::open(endpoint)) {
                Ok(link) => {
                    self.link = Some(link);
                    return Ok(true);
                }
                Err(error) => last = error,
            }
        }
    }

    fn another(&mut self) -> Option<Box<dyn Line>> {
        let endpoint = self.endpoint.clone().filter(|e| matches!(e, Endpoint::Tcp { .. }))?;
        let link = self.handle.block_on(Link::open(&endpoint)).ok()?;
        Some(Box::new(Self::new(link, Some(endpoint), self.handle.clone(), self.speed)))
    }
}
