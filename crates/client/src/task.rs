//! The task of a client: moves bytes between a session and its link, and keeps the link open.

use std::collections::HashMap;
use std::future::{Future, pending};
use std::io;
use std::pin::Pin;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use lafet_proto::link::WIRE_MAX;
use tokio::sync::{mpsc, oneshot};
use tokio::time::{Instant, sleep, sleep_until, timeout};

use crate::answers::RequestBuf;
use crate::client::Shared;
use crate::session::{Config, Now, Outcome, QueueFull, Session, Ticket};
use crate::transport::Link;
use crate::url::Endpoint;

/// Tries in a row without answer after which a TCP connection is made anew: it may be half open.
const SILENT_TRIES_MAX: u32 = 2;
/// Pause after the first connection that failed; each next one is twice as long.
const REDIAL_FIRST: Duration = Duration::from_millis(100);
/// The longest pause.
const REDIAL_LAST: Duration = Duration::from_secs(2);

/// Requests for one frame, and who waits for the outcome.
#[derive(Debug)]
pub struct Job {
    pub requests: Vec<RequestBuf>,
    /// The first frame of the same batch.
    pub first: Option<Ticket>,
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

#[derive(Debug)]
pub struct Task {
    session: Session,
    link: Option<Link>,
    /// Where to connect again; without it a lost link stays lost.
    redial: Option<Endpoint>,
    pause: Duration,
    error: Option<Arc<io::Error>>,
    shared: Arc<Shared>,
    waiting: HashMap<Ticket, oneshot::Sender<Reply>>,
    start: Instant,
}

type Dialing = Pin<Box<dyn Future<Output = io::Result<Link>> + Send>>;

enum Event {
    Job(Option<Job>),
    Read(io::Result<usize>),
    Dialed(io::Result<Link>),
    Time,
}

impl Task {
    pub fn new(config: Config, link: Link, redial: Option<Endpoint>, shared: Arc<Shared>) -> Self {
        let mut session = Session::new(config);
        session.handle_connected();
        Self {
            session,
            link: Some(link),
            redial,
            pause: Duration::ZERO,
            error: None,
            shared,
            waiting: HashMap::new(),
            start: Instant::now(),
        }
    }

    /// Runs until nobody has a handle any more, and what is urgent is done.
    pub async fn run(mut self, mut jobs: mpsc::Receiver<Job>) {
        let mut buffer = [0; 2 * WIRE_MAX];
        let mut dialing: Option<Dialing> = None;
        let mut open = true;
        loop {
            while let Ok(job) = jobs.try_recv() {
                self.submit(job);
            }
            self.forget_cancelled();
            self.session.set_tracing(self.shared.trace.receiver_count() > 0);
            self.transmit().await;
            self.deliver();
            if !open && !self.session.is_urgent() {
                return;
            }
            if self.link.is_none() && dialing.is_none() {
                dialing = self.dial();
            }
            let timeout = self.session.poll_timeout(self.now()).map(|time| self.start + time);
            let event = tokio::select! {
                job = jobs.recv(), if open => Event::Job(job),
                read = recv(&mut self.link, &mut buffer) => Event::Read(read),
                link = dialed(&mut dialing) => Event::Dialed(link),
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
                Event::Time => self.timed_out(),
            }
        }
    }

    fn now(&self) -> Now {
        self.start.elapsed()
    }

    fn submit(&mut self, job: Job) {
        // Nobody is sorry if nobody waits for the reply.
        if self.link.is_none() && self.redial.is_none() {
            let (outcome, link) = (Outcome::NotConnected, self.error.clone());
            let ended = Ended { outcome, ticket: None, link };
            _ = job.reply.send(Ok(ended));
            return;
        }
        match self.session.submit_after(self.now(), job.first, job.requests) {
            Ok(ticket) => _ = self.waiting.insert(ticket, job.reply),
            Err(full) => _ = job.reply.send(Err(full)),
        }
    }

    /// Whoever dropped its future wants no answer any more.
    fn forget_cancelled(&mut self) {
        let session = &mut self.session;
        self.waiting.retain(|ticket, reply| {
            if reply.is_closed() {
                session.cancel(*ticket);
            }
            !reply.is_closed()
        });
    }

    async fn transmit(&mut self) {
        let now = self.now();
        let Some(bytes) = self.session.poll_transmit(now) else { return };
        let Some(link) = &mut self.link else { return };
        // A peer that does not read must not hold up what is urgent for ever.
        let sent = timeout(self.session.config().timeout, link.send(&bytes)).await;
        if let Err(error) = sent.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into())) {
            self.lost(error);
        }
    }

    fn deliver(&mut self) {
        while let Some((ticket, outcome)) = self.session.poll_outcome() {
            if let Outcome::Answered(_) = outcome {
                self.pause = Duration::ZERO;
            }
            if let Some(reply) = self.waiting.remove(&ticket) {
                let (ticket, link) = (Some(ticket), self.error.clone());
                _ = reply.send(Ok(Ended { outcome, ticket, link }));
            }
        }
        while let Some(traced) = self.session.poll_traced() {
            _ = self.shared.trace.send(traced);
        }
        *self.shared.stats.lock().unwrap_or_else(PoisonError::into_inner) = self.session.stats();
    }

    fn received(&mut self, bytes: &[u8]) {
        let now = self.now();
        if self.link.as_ref().is_some_and(Link::is_datagram) {
            self.session.handle_datagram(now, bytes);
        } else {
            self.session.handle_bytes(now, bytes);
        }
    }

    fn timed_out(&mut self) {
        self.session.handle_timeout(self.now());
        let can_be_half_open = self.link.as_ref().is_some_and(Link::can_be_half_open);
        if can_be_half_open && self.session.silent_tries() >= SILENT_TRIES_MAX {
            // The silence was pause enough.
            self.pause = Duration::ZERO;
            self.lost(io::ErrorKind::TimedOut.into());
        }
    }

    fn lost(&mut self, error: io::Error) {
        self.link = None;
        self.error = Some(Arc::new(error));
        self.session.handle_disconnected(self.now());
    }

    fn dial(&mut self) -> Option<Dialing> {
        let endpoint = self.redial.clone()?;
        let pause = self.pause;
        self.pause = (pause * 2).clamp(REDIAL_FIRST, REDIAL_LAST);
        Some(Box::pin(async move {
            sleep(pause).await;
            Link::open(&endpoint).await
        }))
    }

    fn dialed(&mut self, link: io::Result<Link>) {
        match link {
            Ok(link) => {
                self.link = Some(link);
                self.session.handle_connected();
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
