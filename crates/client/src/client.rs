//! Any request to one monitor: a handle on a task that runs a session.

use std::sync::{Arc, Mutex, PoisonError};

use lafet_proto::Request;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::{broadcast, mpsc, oneshot};

use crate::answers::{Answers, RequestBuf};
use crate::error::{Cause, Error};
use crate::plan::frame_len;
use crate::session::matching::Slot;
use crate::session::{Config, Outcome, Stats, Traced};
use crate::task::{Job, Task};
use crate::transport::Link;
use crate::transport::memory::Memory;
use crate::url::{Endpoint, Framing};

/// Jobs that may wait between handles and task.
const JOBS_MAX: usize = 64;
/// Frames that a slow listener of [`Client::trace`] may lag behind.
const TRACE_MAX: usize = 1024;

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
    urgent: mpsc::Sender<Job>,
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
        let link = Link::open(endpoint).await.map_err(|source| Error::Link {
            endpoint: name.clone(),
            source: Arc::new(source),
        })?;
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
        let (jobs, jobs_end) = mpsc::channel(JOBS_MAX);
        let (urgent, urgent_end) = mpsc::channel(JOBS_MAX);
        let trace = broadcast::Sender::new(TRACE_MAX);
        let shared = Arc::new(Shared { stats: Mutex::default(), trace });
        let framing = config.framing;
        let task = Task::new(config, link, redial, shared.clone());
        tokio::spawn(task.run(jobs_end, urgent_end));
        Self { endpoint, framing, jobs, urgent, shared }
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
        let [result] = self.batch_of([RequestBuf::new(request)?]).await;
        result
    }

    /// Sends requests in order, several in a frame, and waits for all their answers: a result for
    /// each. When a frame gets no answer, those behind it are not sent.
    pub async fn batch(&self, requests: &[Request<'_>]) -> Vec<Result<Answers, Error>> {
        let encoded: Result<Vec<_>, _> = requests.iter().map(RequestBuf::new).collect();
        match encoded {
            Ok(encoded) => self.run(encoded).await,
            // Half a batch is worse than none.
            Err(_) => requests
                .iter()
                .map(|request| match RequestBuf::new(request) {
                    Err(error) => Err(error),
                    Ok(fine) => Err(not_sent(&fine, Cause::EarlierFailed)),
                })
                .collect(),
        }
    }

    /// Asks whether somebody is there: an empty frame, or bare records' end mark (observed, ours).
    pub async fn probe(&self) -> Result<(), Error> {
        match self.exchange(vec![]).await? {
            Outcome::Answered(_) => Ok(()),
            Outcome::Silence { tries } => {
                Err(Error::Absent { endpoint: self.endpoint.clone(), tries })
            }
            Outcome::LinkLost(source) | Outcome::NotConnected(source) => {
                Err(Error::Link { endpoint: self.endpoint.clone(), source })
            }
            Outcome::Superseded { .. } | Outcome::QueueFull => {
                Err(Error::Absent { endpoint: self.endpoint.clone(), tries: 0 })
            }
        }
    }
}
