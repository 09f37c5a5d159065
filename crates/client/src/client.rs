//! Any request to one monitor: a handle on a task that runs a session.

use std::sync::{Arc, Mutex, PoisonError};

use lafet_proto::Request;
use lafet_proto::link::PAYLOAD_MAX;
use lafet_proto::record::HEADER_SIZE;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::{broadcast, mpsc, oneshot};

use crate::answers::{Answers, RequestBuf};
use crate::error::{Cause, Error};
use crate::plan::frame_len;
use crate::session::{
    Config, Outcome, QUEUE_MAX, QueueFull, Slot, Stats, Ticket, Traced, URGENT_MAX,
};
use crate::task::{Ended, Job, Reply, Task};
use crate::transport::Link;
use crate::transport::memory::Memory;
use crate::url::{Endpoint, Framing};

/// Jobs that may wait between handles and task.
const JOBS_MAX: usize = QUEUE_MAX + URGENT_MAX;
/// Frames that a slow listener of [`Client::trace`] may lag behind.
const TRACE_MAX: usize = 1024;
/// Requests that a frame can hold at most.
const FRAME_MAX: usize = PAYLOAD_MAX / HEADER_SIZE;

/// The controlling side of one monitor. Clones share one connection.
///
/// Stop, Close and Lockout on overtake everything that waits, and what would undo them is not sent
/// any more. Dropping a future takes its requests back as far as they have not been sent; an urgent
/// one is sent all the same. When the last clone is dropped, the connection is closed.
#[derive(Clone, Debug)]
pub struct Client {
    endpoint: Arc<str>,
    framing: Framing,
    jobs: mpsc::Sender<Job>,
    shared: Arc<Shared>,
}

/// What the task shows to the handles.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) stats: Mutex<Stats>,
    pub(crate) trace: broadcast::Sender<Traced>,
}

impl Client {
    /// Connects. Call it inside a Tokio runtime: the client's task runs there.
    pub async fn connect(endpoint: &Endpoint) -> Result<Self, Error> {
        Self::connect_with(endpoint, Config::default()).await
    }

    /// Connects with timeouts and bounds of your own; addresses and framing are the endpoint's.
    pub async fn connect_with(endpoint: &Endpoint, config: Config) -> Result<Self, Error> {
        if matches!(endpoint, Endpoint::Sim { .. }) {
            return Err(Error::NeedsStream);
        }
        let name: Arc<str> = endpoint.to_string().into();
        let link = Link::open(endpoint)
            .await
            .map_err(|source| Error::Link { endpoint: name.clone(), source: Arc::new(source) })?;
        let config = Config {
            addresses: endpoint.addresses(),
            framing: endpoint.framing(),
            duplicates: config.duplicates || link.is_datagram(),
            ..config
        };
        Ok(Self::start(name, link, Some(endpoint.clone()), config))
    }

    /// Talks over a stream of yours, which is not opened again when it ends: a simulator in this
    /// process, a tunnel. `name` stands for it in messages.
    pub fn over<S>(name: &str, stream: S, config: Config) -> Self
    where
        S: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        Self::start(name.into(), Link::Memory(Memory::new(stream)), None, config)
    }

    fn start(endpoint: Arc<str>, link: Link, redial: Option<Endpoint>, config: Config) -> Self {
        // One queue for all: a Stop must find what was asked before it, to keep it from being sent.
        let (jobs, jobs_end) = mpsc::channel(JOBS_MAX);
        let trace = broadcast::Sender::new(TRACE_MAX);
        let shared = Arc::new(Shared { stats: Mutex::default(), trace });
        let framing = config.framing;
        let task = Task::new(config, link, redial, shared.clone());
        tokio::spawn(task.run(jobs_end));
        Self { endpoint, framing, jobs, shared }
    }

    /// Where the monitor is, as given.
    pub fn endpoint(&self) -> &str {
        &self.endpoint
    }

    /// What has been sent, received and dropped so far.
    pub fn stats(&self) -> Stats {
        *self.shared.stats.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Every frame from now on that is sent or received.
    pub fn trace(&self) -> broadcast::Receiver<Traced> {
        self.shared.trace.subscribe()
    }

    /// Sends a request and waits for its answers. A refusal is an answer: [`Answers::accepted`]
    /// makes an error of it.
    pub async fn request(&self, request: &Request<'_>) -> Result<Answers, Error> {
        let results = self.run(vec![RequestBuf::new(request)?]).await;
        results.into_iter().next().unwrap_or(Err(Error::Closed))
    }

    /// Sends requests in order, several in a frame, and waits for all their answers: a result for
    /// each. When a frame gets no answer, those behind it are not sent; when a request fits no
    /// record, none is sent.
    pub async fn batch(&self, requests: &[Request<'_>]) -> Vec<Result<Answers, Error>> {
        let encoded: Vec<_> = requests.iter().map(RequestBuf::new).collect();
        if encoded.iter().all(Result::is_ok) {
            return self.run(encoded.into_iter().flatten().collect()).await;
        }
        let refuse = |one: Result<RequestBuf, Error>| {
            Err(one.map_or_else(|error| error, |fine| not_sent(&fine, Cause::EarlierFailed)))
        };
        encoded.into_iter().map(refuse).collect()
    }

    /// Asks whether somebody is there (observed: an empty frame is answered by an empty frame).
    pub async fn probe(&self) -> Result<(), Error> {
        let endpoint = self.endpoint.clone();
        match self.exchange(vec![], None).await {
            None => Err(Error::Closed),
            Some(Ok(Ended { outcome: Outcome::Answered(_), .. })) => Ok(()),
            Some(Ok(Ended { outcome: Outcome::Silence { tries }, .. })) => {
                Err(Error::Absent { endpoint, tries })
            }
            Some(Ok(ended)) => Err(Error::Link { endpoint, source: ended.source() }),
            Some(Err(QueueFull)) => Err(Error::Absent { endpoint, tries: 0 }),
        }
    }

    async fn run(&self, requests: Vec<RequestBuf>) -> Vec<Result<Answers, Error>> {
        let mut results: Vec<_> =
            requests.iter().map(|request| Err(not_sent(request, Cause::EarlierFailed))).collect();
        let mut waiting: Vec<usize> = (0..requests.len()).collect();
        let mut first = None;
        while !waiting.is_empty() {
            let upcoming: Vec<RequestBuf> =
                waiting.iter().take(FRAME_MAX).map(|index| requests[*index].clone()).collect();
            let len = frame_len(&upcoming, self.framing);
            let frame: Vec<usize> = waiting.drain(..len).collect();
            let ended = self.exchange(upcoming.into_iter().take(len).collect(), first).await;
            let Some(Ok(Ended { outcome: Outcome::Answered(slots), ticket, .. })) = ended else {
                for index in frame {
                    results[index] = Err(self.failure(&requests[index], &ended));
                }
                break;
            };
            first = first.or(ticket);
            let mut again = Vec::new();
            for (place, (index, slot)) in frame.into_iter().zip(slots).enumerate() {
                match slot {
                    Slot::Answered(answers) if fits(&answers, &requests[index], place) => {
                        results[index] = well_formed(answers);
                    }
                    _ => again.push(index),
                }
            }
            waiting.splice(..0, again);
        }
        results
    }

    /// `None`: the task has ended.
    async fn exchange(&self, requests: Vec<RequestBuf>, first: Option<Ticket>) -> Option<Reply> {
        let (reply, answer) = oneshot::channel();
        let urgent = !requests.is_empty() && requests.iter().all(RequestBuf::is_urgent);
        let job = Job { requests, first, reply };
        if urgent {
            self.jobs.send(job).await.ok()?;
        } else {
            match self.jobs.try_send(job) {
                Ok(()) => {}
                Err(mpsc::error::TrySendError::Full(_)) => return Some(Err(QueueFull)),
                Err(mpsc::error::TrySendError::Closed(_)) => return None,
            }
        }
        answer.await.ok()
    }

    fn failure(&self, request: &RequestBuf, ended: &Option<Reply>) -> Error {
        let (to, endpoint) = (request.to(), self.endpoint.clone());
        let unknown = |cause| Error::OutcomeUnknown { request: request.id(), to, endpoint, cause };
        match ended {
            None => Error::Closed,
            Some(Err(QueueFull)) => not_sent(request, Cause::QueueFull),
            Some(Ok(ended)) => match ended.outcome {
                Outcome::Silence { tries } if request.is_read() => {
                    let endpoint = self.endpoint.clone();
                    Error::NoAnswer { request: request.id(), to, endpoint, tries }
                }
                Outcome::LinkLost | Outcome::NotConnected if request.is_read() => {
                    Error::Link { endpoint: self.endpoint.clone(), source: ended.source() }
                }
                Outcome::Silence { .. } | Outcome::Answered(_) => unknown(Cause::Silence),
                Outcome::LinkLost => unknown(Cause::Link(ended.source())),
                Outcome::NotConnected => not_sent(request, Cause::Link(ended.source())),
                Outcome::Superseded { by, sent: true } => unknown(Cause::Superseded { by }),
                Outcome::Superseded { by, sent: false } => {
                    not_sent(request, Cause::Superseded { by })
                }
            },
        }
    }
}

fn not_sent(request: &RequestBuf, cause: Cause) -> Error {
    Error::NotSent { request: request.id(), to: request.to(), cause }
}

/// Whether an answer is final. What found no room behind others is asked again by itself (§1, §2:
/// the client repeats what was not processed); what found none alone never will.
fn fits(answers: &Answers, request: &RequestBuf, place: usize) -> bool {
    place == 0 || !answers.lacks_room() || !request.is_read()
}

/// Answers whose data have the shape that their request and sender give them.
fn well_formed(answers: Answers) -> Result<Answers, Error> {
    let wrong = answers.iter().find_map(|answer| answer.decode().err().map(|e| (answer, e)));
    match wrong.map(|(answer, source)| (answer.request(), answer.from(), source)) {
        Some((request, from, source)) => Err(Error::Protocol { request, from, source }),
        None => Ok(answers),
    }
}
