//! The task of a client: moves bytes between a line and its link, and keeps the link open.

use std::fmt;
use std::future::{Future, pending};
use std::io;
use std::pin::{Pin, pin};
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

/// Consecutive transmissions without answer after which a TCP connection is replaced: it may be
/// half open.
pub const SILENT_TRIES_MAX: u32 = 2;
/// Pause after the first connection that failed; doubled after each further failure.
const REDIAL_FIRST: Duration = Duration::from_millis(100);
/// The longest pause.
const REDIAL_LAST: Duration = Duration::from_secs(2);

/// Requests of one frame, and the receiver of the outcome.
#[derive(Debug)]
pub struct Job {
    pub address: u8,
    pub requests: Vec<RequestBuf>,
    /// The first frame of the same batch.
    pub first: Option<Ticket>,
    /// Time after which it must not be sent.
    pub expires: Option<Instant>,
    pub reply: oneshot::Sender<Reply>,
}

pub type Reply = Result<Ended, QueueFull>;

/// How a job ended, and the latest error of the link.
#[derive(Debug)]
pub struct Ended {
    pub outcome: Outcome,
    /// `None`: it did not reach a session.
    pub ticket: Option<Ticket>,
    link: Option<Arc<io::Error>>,
}

impl Ended {
    /// An outcome with the latest error of the link.
    pub const fn new(
        outcome: Outcome,
        ticket: Option<Ticket>,
        link: Option<Arc<io::Error>>,
    ) -> Self {
        Self { outcome, ticket, link }
    }

    /// The latest error of the link.
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
    /// How to connect again; without it a lost link is not replaced.
    redial: Option<Redial>,
    pause: Duration,
    error: Option<Arc<io::Error>>,
    shared: Arc<Shared>,
    meter: Option<Meter>,
    /// End of the time in which requests are held back, as last reported.
    held: Now,
    waiting: Vec<(Ticket, oneshot::Sender<Reply>)>,
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
        line.handle_connected(Now::ZERO);
        Self {
            line,
            link: Some(link),
            redial,
            pause: Duration::ZERO,
            error: None,
            shared,
            meter: None,
            held: Now::ZERO,
            waiting: Vec::new(),
            start: Instant::now(),
        }
    }

    /// Runs until all handles are dropped and urgent requests are done.
    pub async fn run(mut self, mut jobs: mpsc::UnboundedReceiver<Job>) {
        let mut buffer = [0; 2 * WIRE_MAX];
        let mut dialing: Option<Dialing> = None;
        let mut open = true;
        let shared = self.shared.clone();
        // Both are kept between iterations: creating them costs more than a request.
        let mut woken = pin!(shared.wake.notified());
        let mut alarm = pin!(sleep_until(self.start));
        let mut now = self.now();
        loop {
            while let Ok(job) = jobs.try_recv() {
                self.submit(now, job);
            }
            self.forget_cancelled();
            self.line.set_tracing(self.shared.trace.receiver_count() > 0);
            self.transmit(now).await;
            self.deliver(now);
            if !open && !self.line.is_urgent() {
                return;
            }
            if self.link.is_none() && dialing.is_none() {
                dialing = self.dial();
            }
            let due = self.poll_timeout(now).map(|time| self.start + time);
            // A timer that fires too early is set again: usually the request is answered by then.
            if let Some(due) = due
                && (alarm.is_elapsed() || due < alarm.deadline())
            {
                alarm.as_mut().reset(due);
            }
            let event = tokio::select! {
                job = jobs.recv(), if open => Event::Job(job),
                read = recv(&mut self.link, &mut buffer) => Event::Read(read),
                link = dialed(&mut dialing) => Event::Dialed(link),
                () = &mut woken => Event::Woken,
                () = &mut alarm, if due.is_some() => Event::Time,
            };
            now = self.now();
            match event {
                Event::Job(Some(job)) => self.submit(now, job),
                Event::Job(None) => open = false,
                Event::Read(Ok(len)) => self.received(now, &buffer[..len]),
                Event::Read(Err(error)) => self.lost(error),
                Event::Dialed(link) => {
                    dialing = None;
                    self.dialed(link);
                }
                Event::Woken => woken.set(shared.wake.notified()),
                Event::Time if due.is_some_and(|due| self.start + now < due) => {}
                Event::Time => self.timed_out(now),
            }
        }
    }

    fn now(&self) -> Now {
        self.start.elapsed()
    }

    fn poll_timeout(&self, now: Now) -> Option<Now> {
        let meter = self.meter.as_ref().map(Meter::poll_timeout);
        self.line.poll_timeout(now).into_iter().chain(meter).min()
    }

    fn submit(&mut self, now: Now, job: Job) {
        self.shared.taken();
        // An error means that the caller does not wait any more.
        if self.link.is_none() && self.redial.is_none() {
            let (outcome, link) = (Outcome::NotConnected, self.error.clone());
            let ended = Ended { outcome, ticket: None, link };
            _ = job.reply.send(Ok(ended));
            return;
        }
        let expires = job.expires.map(|time| time.saturating_duration_since(self.start));
        let terms = Terms { first: job.first, expires };
        match self.line.submit(now, job.address, terms, job.requests) {
            Ok(ticket) => self.waiting.push((ticket, job.reply)),
            Err(full) => _ = job.reply.send(Err(full)),
        }
    }

    /// Cancels jobs whose futures were dropped.
    fn forget_cancelled(&mut self) {
        let line = &mut self.line;
        self.waiting.retain(|(ticket, reply)| {
            if reply.is_closed() {
                line.cancel(*ticket);
            }
            !reply.is_closed()
        });
    }

    async fn transmit(&mut self, now: Now) {
        let Some(bytes) = self.line.poll_transmit(now) else { return };
        let Some(link) = &mut self.link else { return };
        let rest = &bytes[link.send_now(&bytes)..];
        if rest.is_empty() {
            return;
        }
        // A peer that does not read must not delay urgent requests without limit.
        let sent = timeout(self.line.config().timeout, link.send(rest)).await;
        if let Err(error) = sent.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into())) {
            self.lost(error);
        }
    }

    fn deliver(&mut self, now: Now) {
        while let Some((ticket, outcome)) = self.line.poll_outcome() {
            if let Outcome::Answered(_) = outcome {
                self.pause = Duration::ZERO;
            }
            if let Some(index) = self.waiting.iter().position(|(other, _)| *other == ticket) {
                let (_, reply) = self.waiting.swap_remove(index);
                let (ticket, link) = (Some(ticket), self.error.clone());
                _ = reply.send(Ok(Ended { outcome, ticket, link }));
            }
        }
        while let Some(traced) = self.line.poll_traced() {
            _ = self.shared.trace.send(traced);
        }
        self.report(now);
        let mut stats = self.shared.stats.lock().unwrap_or_else(PoisonError::into_inner);
        stats.total = self.line.total();
        for (address, stats) in &mut stats.each {
            *stats = self.line.stats(*address);
        }
    }

    /// Publishes the statistics of each second while there are listeners.
    fn report(&mut self, now: Now) {
        if self.shared.events.receiver_count() == 0 {
            self.meter = None;
            return;
        }
        if let Some(until) = self.line.held_until(now).filter(|until| *until > self.held) {
            self.held = until;
            _ = self.shared.events.send(LinkEvent::Held(until - now));
        }
        let total = self.line.total();
        let meter = self.meter.get_or_insert_with(|| Meter::new(now, total));
        if let Some(figures) = meter.poll(now, total) {
            _ = self.shared.events.send(LinkEvent::Statistics(Box::new(figures)));
        }
    }

    fn received(&mut self, now: Now, bytes: &[u8]) {
        if self.link.as_ref().is_some_and(Link::is_datagram) {
            self.line.handle_datagram(now, bytes);
        } else {
            self.line.handle_bytes(now, bytes);
        }
    }

    fn timed_out(&mut self, now: Now) {
        self.line.handle_timeout(now);
        let can_be_half_open = self.link.as_ref().is_some_and(Link::can_be_half_open);
        if can_be_half_open && self.line.silent_tries() >= SILENT_TRIES_MAX {
            // The time without answers was pause enough.
            self.pause = Duration::ZERO;
            self.lost(io::ErrorKind::TimedOut.into());
        }
    }

    fn lost(&mut self, error: io::Error) {
        let error = Arc::new(error);
        self.link = None;
        self.error = Some(error.clone());
        self.line.handle_disconnected(self.now());
        // The next connection may lead to another monitor.
        lock(&self.shared.holds).clear();
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
                self.line.handle_connected(self.now());
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
