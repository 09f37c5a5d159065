//! The connection of a command to its monitor.

use std::io::{self, Write};
use std::str::FromStr;
use std::sync::Arc;
use std::time::Duration;

use lafet_client::transport::Link;
use lafet_client::transport::memory::Memory;
use lafet_client::{AnswerBuf, Answers, Client, Config, Endpoint, Error, LinkEvent, Monitor};
use lafet_device::Source;
use lafet_proto::request::Body;
use lafet_proto::{Request, Status, SubsystemId};
use lafet_sim::sim;
use lafet_texts::{Text as _, cli as text};
use tokio::io::DuplexStream;
use tokio::sync::broadcast;
use tokio::sync::broadcast::error::RecvError;
use tokio::time::timeout;

use crate::cli::Global;
use crate::failure::{Asked, Failure};
use crate::lang::current;
use crate::serve::{Habits, Shared, Wire, pace, serve_stream};
use crate::simulator;

/// Longest wait of a refusal for the state that explains it.
const EXPLAINED: Duration = Duration::from_secs(1);
/// Capacity of a pipe to the simulator in this process, bytes.
const PIPE: usize = 4096;

/// A connection to a monitor; clones share it.
#[derive(Clone, Debug)]
pub struct Connection {
    /// Sends requests of any kind.
    pub client: Client,
    /// Typed interface, a method for each request.
    pub monitor: Monitor,
}

impl Connection {
    /// Connects as `--connect` says, or reuses the connection of the shell.
    pub async fn open(global: &Global) -> Result<Self, Failure> {
        if let Some((url, open)) = &global.open
            && global.connect.as_ref() == Some(url)
        {
            return Ok(open.clone());
        }
        Self::new(global).await
    }

    /// Connects as `--connect` says. `sim:` starts a simulator inside this process.
    pub async fn new(global: &Global) -> Result<Self, Failure> {
        let url = url_of(global)?;
        let endpoint = Endpoint::from_str(url).map_err(Error::from)?;
        let timeout = Duration::from_secs_f64(global.timeout);
        let config = Config { timeout, addresses: endpoint.addresses(), ..Config::default() };
        let client = match &endpoint {
            Endpoint::Sim { query, .. } => {
                let stream = simulated(query, config.addresses.monitor)?;
                Client::over(url, stream, config)
            }
            _ => Client::connect_with(&endpoint, config).await?,
        };
        tokio::spawn(say_why_it_waits(client.events()));
        Ok(Self { monitor: Monitor::new(client.clone()), client })
    }

    /// Sends a request; a refusal is an error.
    pub async fn ask(&self, to: SubsystemId, body: Body<'_>) -> Result<Answers, Failure> {
        self.send(&Request::new(to, body)).await
    }

    /// Sends a request; a refusal is an error that shows the request and the answer.
    pub async fn send(&self, request: &Request<'_>) -> Result<Answers, Failure> {
        let answers = self.client.request(request).await?;
        let refusal = match answers.refusal() {
            Some(refusal) => Some(self.refused(request, refusal).await),
            None => None,
        };
        answers.accepted().map_err(|error| Failure::Client(error).asked(refusal))
    }

    /// A request and its refusal. One that is denied is explained by the state of the monitor.
    pub async fn refused(&self, request: &Request<'_>, refusal: &AnswerBuf) -> Asked {
        let state = match refusal.status() {
            Status::DENIED => {
                timeout(EXPLAINED, self.monitor.status_all()).await.ok().and_then(Result::ok)
            }
            _ => None,
        };
        Asked::new(request, refusal, state.as_ref())
    }
}

/// Reports once why requests take long: the monitor does not answer frame numbers, so the client
/// waits for late answers to pass.
async fn say_why_it_waits(mut events: broadcast::Receiver<LinkEvent>) {
    loop {
        match events.recv().await {
            Ok(LinkEvent::Held(time)) => {
                let s = time.as_secs_f64().ceil();
                // The command continues even if standard error is closed.
                let _ =
                    writeln!(io::stderr(), "{}", text::WaitingForLateAnswers { s }.of(current()));
                return;
            }
            Ok(_) | Err(RecvError::Lagged(_)) => {}
            Err(RecvError::Closed) => return,
        }
    }
}

/// The URL of the monitor, from `--connect`.
pub fn url_of(global: &Global) -> Result<&str, Failure> {
    global
        .connect
        .as_deref()
        .ok_or_else(|| Failure::Usage(text::WhichMonitor.str(current()).into()))
}

/// Opens the bare link, for commands that work on bytes.
pub async fn link(url: &str, endpoint: &Endpoint) -> Result<Link, Failure> {
    if let Endpoint::Sim { query, .. } = endpoint {
        let stream = simulated(query, endpoint.addresses().monitor)?;
        return Ok(Link::Memory(Memory::new(stream)));
    }
    Ok(Link::open(endpoint)
        .await
        .map_err(|source| Error::Link { endpoint: url.into(), source: Arc::new(source) })?)
}

/// Starts a simulator that runs as long as this command; returns its end of the pipe.
fn simulated(query: &[(String, String)], address: u8) -> Result<DuplexStream, Failure> {
    let mut options = sim::Config { address, ..sim::Config::default() };
    let mut speed = 1.0;
    for (key, value) in query {
        let set = match key.as_str() {
            "profile" => options.profile(value),
            "seed" => value.parse().ok().map(|seed| options.seed = seed),
            "fire" => value.parse().ok().map(|fire| options.fires.push(fire)),
            "speed" => simulator::speed(value).ok().map(|value| speed = value),
            _ => None,
        };
        if set.is_none() {
            return Err(Failure::Usage(wrong_option(key, value)));
        }
    }
    let shared = Shared::new(simulator::power_up(options));
    let (ours, theirs) = tokio::io::duplex(PIPE);
    tokio::spawn(pace(shared.clone(), speed));
    tokio::spawn(async move {
        let habits = Habits::default();
        // The pipe ends with the command, which alone uses it.
        let _ =
            serve_stream(theirs, Wire::link(Source::ExternalConn), &shared, habits, || {}).await;
    });
    Ok(ours)
}

fn wrong_option(key: &str, value: &str) -> String {
    let profiles = simulator::profiles();
    text::SimOptions { key, value, profiles }.of(current())
}
