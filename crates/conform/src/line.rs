//! The connection to the monitor, with a clock: a real link, or a test's own.

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
/// Least wait for an answer, which has to pass two programs however fast a simulator's clock is.
const WAIT_MIN: Duration = Duration::from_millis(30);

/// For how long a lost connection is retried, and the pause between two tries.
const REACH: Duration = Duration::from_secs(30);
const REDIAL: Duration = Duration::from_millis(200);
/// Longest time for sending bytes; once given up, for sending the last ones, and for their answer.
const SEND: Duration = Duration::from_secs(5);
const LAST: Duration = Duration::from_millis(200);
/// How often it is looked whether the user gives up.
const LOOKS: Duration = Duration::from_millis(20);

/// Bytes to the monitor and back, and the time that passes meanwhile.
///
/// The tester is plain blocking code; on virtual time it does not really wait.
pub trait Line {
    /// Sends bytes as they are; over datagrams, as one datagram.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;
    /// Waits for bytes; returns none when the time is over.
    fn recv(&mut self, wait_ms: u64) -> io::Result<Vec<u8>>;
    /// Time of the monitor's clock, ms; the origin is arbitrary.
    fn now_ms(&self) -> u64;
    /// Whether each send is one datagram.
    fn is_datagram(&self) -> bool {
        false
    }
    /// Reconnects after the connection was lost, retrying for a limited time; false if reconnecting
    /// is not possible.
    fn renew(&mut self) -> io::Result<bool> {
        Ok(false)
    }
    /// The monitor has answered: a later loss of the connection is a new one.
    fn heard(&mut self) {}
    /// Whether the user does not wait any more, not even until everything is restored.
    fn is_given_up(&self) -> bool {
        false
    }
    /// Sends the last bytes, after giving up too, and waits shortly for an answer.
    fn send_last(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.send(bytes)
    }
    /// A second connection to the same monitor; `None` if only one is possible.
    fn another(&mut self) -> Option<Box<dyn Line>> {
        None
    }
}

/// A line over a link of the client.
///
/// It blocks, so it belongs on a thread of its own (`spawn_blocking`), with the runtime on another.
#[derive(Debug)]
pub struct LinkLine {
    /// `None` while there is no connection.
    link: Option<Link>,
    datagrams: bool,
    endpoint: Option<Endpoint>,
    handle: Handle,
    start: Instant,
    speed: f64,
    /// Since when the monitor has not answered over any connection. Bytes alone do not count: a gateway
    /// may greet while no monitor is behind it.
    lost: Option<Instant>,
    reach: Duration,
    cut: Cut,
}

/// What to do when the connection is lost while the monitor may move.
#[derive(Clone, Default)]
pub struct Cut {
    /// Called once to inform the user.
    pub tell: Option<Arc<dyn Fn() + Send + Sync>>,
    /// Set from outside to end the attempts.
    pub give_up: Arc<AtomicBool>,
}

impl fmt::Debug for Cut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Cut")
    }
}

impl LinkLine {
    /// Wraps an open link. `speed` is 1 except for a simulator with a faster clock.
    pub fn new(link: Link, endpoint: Option<Endpoint>, handle: Handle, speed: f64) -> Self {
        let (datagrams, start, cut) = (link.is_datagram(), Instant::now(), Cut::default());
        let (lost, reach) = (None, REACH);
        Self { link: Some(link), datagrams, endpoint, handle, start, speed, lost, reach, cut }
    }

    /// Sets for how long a monitor that does not answer is sought over new connections: 30 s if not set.
    #[must_use]
    pub fn reach(self, reach: Duration) -> Self {
        Self { reach, ..self }
    }

    /// Sets what to do when the connection is lost.
    #[must_use]
    pub fn when_cut(self, cut: Cut) -> Self {
        Self { cut, ..self }
    }

    fn send_within(&mut self, time: Duration, bytes: &[u8]) -> io::Result<()> {
        let Some(link) = &mut self.link else { return Err(io::ErrorKind::NotConnected.into()) };
        // Timers must be created inside the runtime.
        let _inside = self.handle.enter();
        let send = tokio::time::timeout(time, link.send(bytes));
        self.handle.block_on(send).unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
    }

    fn recv_unless(
        &mut self,
        given_up: impl Future<Output = ()>,
        wait: Duration,
    ) -> io::Result<Vec<u8>> {
        let mut buffer = [0; CHUNK];
        let Some(link) = &mut self.link else { return Err(io::ErrorKind::NotConnected.into()) };
        let read = self.handle.block_on(async {
            tokio::select! {
                biased;
                read = tokio::time::timeout(wait, link.recv(&mut buffer)) => read,
                () = given_up => Ok(Err(io::ErrorKind::Interrupted.into())),
            }
        });
        match read {
            Ok(Ok(len)) => Ok(buffer.get(..len).unwrap_or_default().to_vec()),
            Ok(Err(error)) => Err(error),
            Err(_) => Ok(Vec::new()),
        }
    }
}

/// Waits until the user gives up.
async fn given_up(flag: Arc<AtomicBool>) {
    while !flag.load(Ordering::Relaxed) {
        tokio::time::sleep(LOOKS).await;
    }
}

impl Line for LinkLine {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.send_within(SEND, bytes)
    }

    fn recv(&mut self, wait_ms: u64) -> io::Result<Vec<u8>> {
        let wait = Duration::from_millis(wait_ms).div_f64(self.speed);
        let wait = if wait_ms == 0 { Duration::ZERO } else { wait.max(WAIT_MIN) };
        let given_up = given_up(Arc::clone(&self.cut.give_up));
        self.recv_unless(given_up, wait)
    }

    fn now_ms(&self) -> u64 {
        (self.start.elapsed().as_secs_f64() * 1000.0 * self.speed) as u64
    }

    fn is_datagram(&self) -> bool {
        self.datagrams
    }

    fn renew(&mut self) -> io::Result<bool> {
        let Some(endpoint) = &self.endpoint else { return Ok(false) };
        if self.is_given_up() {
            return Err(io::ErrorKind::Interrupted.into());
        }
        if let Some(tell) = self.cut.tell.take() {
            tell();
        }
        let until = *self.lost.get_or_insert_with(Instant::now) + self.reach;
        if Instant::now() >= until {
            // It opens, again and again, and nothing answers. The last Stop is sent over what is open.
            self.cut.give_up.store(true, Ordering::Relaxed);
            return Err(io::ErrorKind::TimedOut.into());
        }
        // A port can be opened again only after it is closed.
        self.link = None;
        loop {
            if self.is_given_up() {
                return Err(io::ErrorKind::Interrupted.into());
            }
            let given_up = given_up(Arc::clone(&self.cut.give_up));
            let opening = async {
                tokio::time::sleep(REDIAL).await;
                // The monitor is stopped over it.
                Link::open_urgently(endpoint).await
            };
            let opened = self.handle.block_on(async {
                tokio::select! {
                    opened = opening => opened,
                    () = given_up => Err(io::ErrorKind::Interrupted.into()),
                }
            });
            match opened {
                Ok(link) => {
                    self.link = Some(link);
                    return Ok(true);
                }
                Err(error) if Instant::now() >= until => {
                    // No later loss is waited for as long.
                    self.cut.give_up.store(true, Ordering::Relaxed);
                    return Err(error);
                }
                Err(_) => {}
            }
        }
    }

    fn heard(&mut self) {
        self.lost = None;
    }

    fn is_given_up(&self) -> bool {
        self.cut.give_up.load(Ordering::Relaxed)
    }

    fn send_last(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.send_within(LAST, bytes)?;
        // A connection that is closed with bytes in it may lose those on their way.
        self.recv_unless(std::future::pending(), LAST).map(|_| ())
    }

    fn another(&mut self) -> Option<Box<dyn Line>> {
        let endpoint = self.endpoint.clone().filter(|e| matches!(e, Endpoint::Tcp { .. }))?;
        let link = self.handle.block_on(Link::open(&endpoint)).ok()?;
        Some(Box::new(Self::new(link, Some(endpoint), self.handle.clone(), self.speed)))
    }
}
