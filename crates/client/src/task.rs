//! The task of a client: moves bytes between a line and its link, and keeps the link open.

use std::collections::HashMap;
use std::fmt;
use std::future::{Future, pending};
use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use lafet_proto::link::WIRE_MAX;
use tokio::sync::{mpsc, oneshot};
use tokio::time::{Instant, sleep, sleep_until, timeout};

use crate::answers::RequestBuf;
use crate::session::line::Line;
use crate::session::statistics::Meter;
use crate::session::{Config, Now, Outcome, QueueFull, Terms, Ticket};
use crate::shared::{LinkEvent, LinkState, Shared, lock};
use crate::transport::Link;

/// Tries in a row without answer after which a TCP connection is made anew: it may be half open.
const SILENT_TRIES_MAX: u32 = 2;
/// Pause after the first connection that failed; each next one is twice as long.
const REDIAL_FIRST: Duration = Duration::from_millis(100);
/// The longest pause.
const REDIAL_LAST: Duration = Duration::from_secs(2);

/// Requests for one frame, and who waits for the outcome.
#[derive(Debug)]
pub struct Job {
    pub address: u8,
    pub requests: Vec<RequestBuf>,
    /// The first frame of the same batch.
    pub first: Option<Ticket>,
    /// Not to be sent after this moment.
    pub expires: Option<Instant>,
    pub reply: oneshot::Sender<Reply>,
}

pub type Reply = Result<Ended, QueueFull>;

/// How a job ended, and what happened to the link last.
#[derive(Debug)]
pub struct Ended {
    pub outcome: Outcome,
    /// `None`: it never came to a session.
    pub ticket: Option<Ticket>,
    link: Option<Arc<io::Error>>,
}

impl Ended {
    /// What the system said of the link.
    pub fn source(&self) -> Arc<io::Error> {
        self.link.clone().unwrap_or_else(|| Arc::new(io::ErrorKind::NotConnected.into()))
    }
}

/// A link that is being opened.
pub type Dialing = Pin<Box<dyn Future<Output = io::Result<Link>> + Send>>;

/// How the link is opened again.
#[derive(Clone)]
pub struct Redial(Arc<Mutex<dyn FnMut() -> Dialing + Send>>);

impl Redial {
    pub fn new(dial: impl FnMut() -> Dialing + Send + 'static) -> Self {
        Self(Arc::new(Mutex::new(dial)))
    }
}

impl fmt::Debug for Redial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Redial")
    }
}

#[derive(Debug)]
pub struct Task {
    line: Line,
    link: Option<Link>,
    /// How to connect again; without it a lost link stays lost.
    redial: Option<Redial>,
    pause: Duration,
    error: Option<Arc<io::Error>>,
    shared: Arc<Shared>,
    meter: Option<Meter>,
    waiting: HashMap<Ticket, oneshot::Sender<Reply>>,
    start: Instant,
}

enum Event {
    Job(Option<Job>),
    Read(io::Result<usize>),
    Dialed(io::Result<Link>),
    Woken,
    Time,
}

impl Task {
    pub fn new(config: Config, link: Link, redial: Option<Redial>, shared: Arc<Shared>) -> Self {
        let mut line = Line::new(config);
        line.handle_connected();
        Self {
            line,
            link: Some(link),
            redial,
            pause: Duration::ZERO,
            error: None,
            shared,
            meter: None,
            waiting: HashMap::new(),
            start: Instant::now(),
        }
    }

    /// Runs until nobody has a handle any more, and what is urgent is done.
    pub async fn run(mut self, mut jobs: mpsc::UnboundedReceiver<Job>) {
        let mut buffer = [0; 2 * WIRE_MAX];
        let mut dialing: Option<Dialing> = None;
        let mut open = true;
        loop {
            while let Ok(job) = jobs.try_recv() {
                self.submit(job);
            }
            self.forget_cancelled();
            self.line.set_tracing(self.shared.trace.receiver_count() > 0);
            self.transmit().await;
            self.deliver();
            if !open && !self.line.is_urgent() {
                return;
            }
            if self.link.is_none() && dialing.is_none() {
                dialing = self.dial();
            }
            let timeout = self.poll_timeout().map(|time| self.start + time);
            let event = tokio::select! {
                job = jobs.recv(), if open => Event::Job(job),
                read = recv(&mut self.link, &mut buffer) => Event::Read(read),
                link = dialed(&mut dialing) => Event::Dialed(link),
                () = self.shared.wake.notified() => Event::Woken,
                () = until(timeout) => Event::Time,
            };
            match event {
                Event::Job(Some(job)) => self.submit(job),
                Event::Job(None) => open = false,
                Event::Read(Ok(len)) => self.received(&buffer[..len]),
                Event::Read(Err(error)) => self.lost(error),
                Event::Dialed(link) => {
                    dialing = None;
                    self.dialed(link);
                }
                Event::Woken => {}
                Event::Time => self.timed_out(),
            }
        }
    }

    fn now(&self) -> Now {
        self.start.elapsed()
    }

    fn poll_timeout(&self) -> Option<Now> {
        let meter = self.meter.as_ref().map(Meter::poll_timeout);
        self.line.poll_timeout(self.now()).into_iter().chain(meter).min()
    }

    fn submit(&mut self, job: Job) {
        self.shared.taken();
        // Nobody is sorry if nobody waits for the reply.
        if self.link.is_none() && self.redial.is_none() {
            let (outcome, link) = (Outcome::NotConnected, self.error.clone());
            let ended = Ended { outcome, ticket: None, link };
            _ = job.reply.send(Ok(ended));
            return;
        }
        let expires = job.expires.map(|time| time.saturating_duration_since(self.start));
        let terms = Terms { first: job.first, expires };
        match self.line.submit(self.now(), job.address, terms, job.requests) {
            Ok(ticket) => _ = self.waiting.insert(ticket, job.reply),
            Err(full) => _ = job.reply.send(Err(full)),
        }
    }

    /// Whoever dropped its future wants no answer any more.
    fn forget_cancelled(&mut self) {
        let line = &mut self.line;
        self.waiting.retain(|ticket, reply| {
            if reply.is_closed() {
                line.cancel(*ticket);
            }
            !reply.is_closed()
        });
    }

    async fn transmit(&mut self) {
        let now = self.now();
        let Some(bytes) = self.line.poll_transmit(now) else { return };
        let Some(link) = &mut self.link else { return };
        // A peer that does not read must not hold up what is urgent for ever.
        let sent = timeout(self.line.config().timeout, link.send(&bytes)).await;
        if let Err(error) = sent.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into())) {
            self.lost(error);
        }
    }

    fn deliver(&mut self) {
        while let Some((ticket, outcome)) = self.line.poll_outcome() {
            if let Outcome::Answered(_) = outcome {
                self.pause = Duration::ZERO;
            }
            if let Some(reply) = self.waiting.remove(&ticket) {
                let (ticket, link) = (Some(ticket), self.error.clone());
                _ = reply.send(Ok(Ended { outcome, ticket, link }));
            }
        }
        while let Some(traced) = self.line.poll_traced() {
            _ = self.shared.trace.send(traced);
        }
        self.report();
        let mut stats = self.shared.stats.lock().unwrap_or_else(PoisonError::into_inner);
        stats.total = self.line.total();
        for (address, stats) in &mut stats.each {
            *stats = self.line.stats(*address);
        }
    }

    /// The figures of each second, as long as somebody listens.
    fn report(&mut self) {
        if self.shared.events.receiver_count() == 0 {
            self.meter = None;
            return;
        }
        let (now, total) = (self.now(), self.line.total());
        let meter = self.meter.get_or_insert_with(|| Meter::new(now, total));
        if let Some(figures) = meter.poll(now, total) {
            _ = self.shared.events.send(LinkEvent::Statistics(Box::new(figures)));
        }
    }

    fn received(&mut self, bytes: &[u8]) {
        let now = self.now();
        if self.link.as_ref().is_some_and(Link::is_datagram) {
            self.line.handle_datagram(now, bytes);
        } else {
            self.line.handle_bytes(now, bytes);
        }
    }

    fn timed_out(&mut self) {
        self.line.handle_timeout(self.now());
        let can_be_half_open = self.link.as_ref().is_some_and(Link::can_be_half_open);
        if can_be_half_open && self.line.silent_tries() >= SILENT_TRIES_MAX {
            // The silence was pause enough.
            self.pause = Duration::ZERO;
            self.lost(io::ErrorKind::TimedOut.into());
        }
    }

    fn lost(&mut self, error: io::Error) {
        let error = Arc::new(error);
        self.link = None;
        self.error = Some(error.clone());
        self.line.handle_disconnected(self.now());
        let gone = self.redial.is_none();
        self.shared.state.send_modify(|state| {
            *state = LinkState { up: false, gone, losses: state.losses + 1 };
        });
        _ = self.shared.events.send(LinkEvent::Down(error));
    }

    fn dial(&mut self) -> Option<Dialing> {
        let redial = self.redial.clone()?;
        let pause = self.pause;
        self.pause = (pause * 2).clamp(REDIAL_FIRST, REDIAL_LAST);
        Some(Box::pin(async move {
            sleep(pause).await;
            let opening = (lock(&redial.0))();
            opening.await
        }))
    }

    fn dialed(&mut self, link: io::Result<Link>) {
        match link {
            Ok(link) => {
                self.link = Some(link);
                self.line.handle_connected();
                self.shared.state.send_modify(|state| state.up = true);
                _ = self.shared.events.send(LinkEvent::Up);
            }
            Err(error) => self.error = Some(Arc::new(error)),
        }
    }
}

async fn recv(link: &mut Option<Link>, buffer: &mut [u8]) -> io::Result<usize> {
    match link {
        Some(link) => link.recv(buffer).await,
        None => pending().await,
    }
}

async fn dialed(dialing: &mut Option<Dialing>) -> io::Result<Link> {
    match dialing {
        Some(dialing) => dialing.await,
        None => pending().await,
    }
}

async fn until(time: Option<Instant>) {
    match time {
        Some(time) => sleep_until(time).await,
        None => pending().await,
    }
}
