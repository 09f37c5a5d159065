//! The connection of a command to its monitor.
//!
//! A serial line is listened to before a direct client's first frame ([`undisturbed`]): at a wrong
//! speed it would reach no device and disturb others. Stop, Close and Lockout on wait for nothing, and
//! who listens gives way to them.

use std::io::{self, IsTerminal, Write};
use std::str::FromStr;
use std::sync::Arc;
use std::time::Duration;

use lafet_client::overhear::{CONTROLLER_PAUSE, GLANCE, Overheard, Times, overhear};
use lafet_client::transport::Link;
use lafet_client::transport::door::{self, PATIENCE, VISITS_MAX, unless_wanted};
use lafet_client::transport::memory::Memory;
use lafet_client::transport::port::{Holder, PortError, holders_beside, user_of};
use lafet_client::{
    AnswerBuf, Answers, Client, Config, Endpoint, Error, Framing, LinkEvent, Monitor, RequestBuf,
    Role,
};
use lafet_device::Source;
use lafet_proto::request::Body;
use lafet_proto::{Request, Status, SubsystemId};
use lafet_sim::sim;
use lafet_texts::{Shown, Text as _, cli as text};
use tokio::io::DuplexStream;
use tokio::sync::broadcast;
use tokio::sync::broadcast::error::RecvError;
use tokio::time::timeout;

use crate::cli::Global;
use crate::cmd::bus::called;
use crate::failure::{Asked, Failure};
use crate::insist::insist;
use crate::lang::current;
use crate::out::{complain, complain_aside};
use crate::quiet::Notes;
use crate::serve::{Habits, Shared, Wire, pace, serve_stream};
use crate::simulator;

/// Longest wait of a refusal for the state that explains it.
const EXPLAINED: Duration = Duration::from_secs(1);
/// How long a line that was quiet lately is listened to before its first frame, and if bytes come that
/// are no frames. Then nothing is sent, so the other speeds are tried only to say more.
const TIMES: Times = Times {
    first: Duration::from_millis(100),
    own: CONTROLLER_PAUSE,
    elsewhere: Duration::from_millis(600),
    silent: Duration::ZERO,
};
/// How long a line is listened to of which nothing is known: until a controller would have been heard.
pub const THOROUGH: Times = Times { first: CONTROLLER_PAUSE, silent: GLANCE, ..TIMES };
/// How long a line is listened to by what cannot tell late answers from others: as long as a request
/// or an answer of a program that has ended may still be on its way.
const ALONE: Times = Times { first: Duration::from_secs(5), ..THOROUGH };
/// After this time a user who stops the monitor is shown who has the port.
const SOON: Duration = Duration::from_millis(500);
/// Capacity of a pipe to the simulator in this process, bytes.
const PIPE: usize = 4096;

/// Work of minutes gives way so often, times [`VISITS_MAX`].
const LONG_ROUNDS: u32 = 12;

/// What is done before the first frame on a serial port.
#[derive(Clone, Copy, Debug)]
enum Before {
    /// The line is listened to.
    Listen,
    /// Nothing.
    Nothing,
    /// Who only listens there is asked to give way.
    Knock,
}

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
        Self::with(global, Before::Listen).await
    }

    /// The same for these requests: if the first is Stop, Close or Lockout on, nothing holds it back, a link that cannot
    /// be opened is tried again, and what only reads goes with it.
    pub async fn open_for(global: &Global, requests: &[Request<'_>]) -> Result<Self, Failure> {
        let is = |request: &Request<'_>, wanted: fn(&RequestBuf) -> bool| {
            RequestBuf::new(request).is_ok_and(|request| wanted(&request))
        };
        let urgent = |request| is(request, RequestBuf::is_urgent);
        let goes_along = |request| urgent(request) || is(request, RequestBuf::is_read);
        match requests {
            [first, rest @ ..] if urgent(first) && rest.iter().all(goes_along) => {
                insist(&words_of(requests), || Self::open_urgently(global)).await
            }
            _ => Self::open(global).await,
        }
    }

    /// The same on a line that this command has listened to already.
    pub async fn open_heard(global: &Global) -> Result<Self, Failure> {
        Self::with(global, Before::Nothing).await
    }

    /// The same for Stop, Close and Lockout on: who listens on the port gives way.
    pub async fn open_urgently(global: &Global) -> Result<Self, Failure> {
        Self::with(global, Before::Knock).await
    }

    async fn with(global: &Global, before: Before) -> Result<Self, Failure> {
        match Self::shared(global) {
            Some(open) => Ok(open),
            None => Self::connect(global, before).await,
        }
    }

    fn shared(global: &Global) -> Option<Self> {
        let (url, open) = global.open.as_ref()?;
        (global.connect.as_ref() == Some(url)).then(|| open.clone())
    }

    /// Connects as `--connect` says. `sim:` starts a simulator inside this process.
    pub async fn new(global: &Global) -> Result<Self, Failure> {
        Self::connect(global, Before::Listen).await
    }

    async fn connect(global: &Global, before: Before) -> Result<Self, Failure> {
        let url = url_of(global)?;
        let endpoint = Endpoint::from_str(url).map_err(Error::from)?;
        let timeout = Duration::from_secs_f64(global.timeout);
        let config = Config { timeout, addresses: endpoint.addresses(), ..Config::default() };
        let client = match &endpoint {
            Endpoint::Sim { query, .. } => {
                let stream = simulated(query, config.addresses.monitor)?;
                Client::over(url, stream, config)
            }
            Endpoint::Serial { .. } => {
                let (link, heard) = match before {
                    Before::Listen => undisturbed(url, &endpoint, global).await?,
                    Before::Nothing => (link(url, &endpoint).await?, Overheard::default()),
                    Before::Knock => (urgently(url, &endpoint).await?, Overheard::default()),
                };
                if heard.has_controller() {
                    // On its bus a direct client must not transmit at all.
                    return Err(Failure::Silent(text::ControllerOnLine { url }.of(current())));
                }
                Client::connect_on(&endpoint, link, config)
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
                return complain_aside(move || text::WaitingForLateAnswers { s }.of(current()));
            }
            Ok(_) | Err(RecvError::Lagged(_)) => {}
            Err(RecvError::Closed) => return,
        }
    }
}

/// Requests as text.
pub fn words_of(requests: &[Request<'_>]) -> String {
    requests.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// The URL of the monitor, from `--connect`.
pub fn url_of(global: &Global) -> Result<&str, Failure> {
    global
        .connect
        .as_deref()
        .ok_or_else(|| Failure::Usage(text::WhichMonitor.str(current()).into()))
}

/// What the monitors of a line have in common; `None` where each has a line of its own.
pub fn line_of(endpoint: &Endpoint) -> Option<Endpoint> {
    if endpoint.framing() == Framing::Records {
        return None;
    }
    let mut line = endpoint.clone();
    match &mut line {
        Endpoint::Tcp { addresses, .. }
        | Endpoint::Udp { addresses, .. }
        | Endpoint::Serial { addresses, .. } => addresses.monitor = 1,
        Endpoint::Sim { .. } => return None,
    }
    Some(line)
}

/// Opens the bare link, for commands that work on bytes and listen themselves.
pub async fn link(url: &str, endpoint: &Endpoint) -> Result<Link, Failure> {
    if let Endpoint::Sim { query, .. } = endpoint {
        let stream = simulated(query, endpoint.addresses().monitor)?;
        return Ok(Link::Memory(Memory::new(stream)));
    }
    Ok(Link::open(endpoint).await.map_err(|source| lost(url, source))?)
}

fn lost(url: &str, source: io::Error) -> Error {
    Error::Link { endpoint: url.into(), source: Arc::new(source) }
}

/// Opens the bare link of a command that transmits, and listens first; what was heard is frames, if
/// anything. Fails where bytes arrive that are none, unless the user insists. A console of a bus
/// transmits in its turns alone, so it need not listen.
pub async fn undisturbed(
    url: &str,
    endpoint: &Endpoint,
    global: &Global,
) -> Result<(Link, Overheard), Failure> {
    let console = endpoint.behaviour().role == Role::Active;
    if insists(global, endpoint) || console || !can_be_overheard(endpoint) {
        return Ok((link(url, endpoint).await?, Overheard::default()));
    }
    let Endpoint::Serial { path, line, .. } = endpoint else {
        return unless_disturbing(url, endpoint, listened(url, endpoint, TIMES).await?);
    };
    let notes = Notes::of_user();
    let known = notes.has(path, line.baud);
    if !known && io::stderr().is_terminal() {
        let s = CONTROLLER_PAUSE.as_secs();
        // The command continues even if standard error is closed.
        let _ = writeln!(io::stderr(), "{}", text::ListeningFirst { s }.of(current()));
    }
    let times = if known { TIMES } else { THOROUGH };
    let ready = unless_disturbing(url, endpoint, listened(url, endpoint, times).await?);
    let quiet = ready.as_ref().is_ok_and(|(_, heard)| !heard.has_controller());
    // A note is as old as the last time that a controller would have been heard.
    if !quiet || !known {
        notes.set(path, line.baud, quiet);
    }
    ready
}

fn unless_disturbing(
    url: &str,
    endpoint: &Endpoint,
    (link, heard): (Link, Overheard),
) -> Result<(Link, Overheard), Failure> {
    match disturbs(url, endpoint, &heard) {
        Some(why) => Err(Failure::Silent(why)),
        None => Ok((link, heard)),
    }
}

/// Opens the bare link of a command that needs the line for itself, and listens for as long as a
/// controller may be silent, or an answer late. Fails where anything arrives, unless the user insists.
pub async fn alone(url: &str, endpoint: &Endpoint, global: &Global) -> Result<Link, Failure> {
    if insists(global, endpoint) || !can_be_overheard(endpoint) {
        return link(url, endpoint).await;
    }
    let (link, heard) = listened(url, endpoint, ALONE).await?;
    let others = || {
        let who = who(&heard.speakers());
        (!who.is_empty()).then(|| text::OthersOnLine { url, who }.of(current()))
    };
    match disturbs(url, endpoint, &heard).or_else(others) {
        Some(why) => Err(Failure::Silent(why)),
        None => Ok(link),
    }
}

/// Whether the user, or the URL, wants everything sent, with others on the line too.
const fn insists(global: &Global, endpoint: &Endpoint) -> bool {
    global.insist || matches!(endpoint, Endpoint::Serial { line, .. } if line.insist)
}

/// Whether others can be heard on such a link before anything is sent: on a line, also behind a
/// serial server.
pub const fn can_be_overheard(endpoint: &Endpoint) -> bool {
    let lines = matches!(endpoint, Endpoint::Serial { .. } | Endpoint::Tcp { .. });
    lines && matches!(endpoint.framing(), Framing::Link)
}

/// Opens a link and listens to it. A port that another program has open, though it has not locked it, is not used;
/// to what is urgent it is given, and nothing is sent behind that.
pub async fn listened(
    url: &str,
    endpoint: &Endpoint,
    times: Times,
) -> Result<(Link, Overheard), Failure> {
    if let Endpoint::Serial { path, line, .. } = endpoint
        && !line.shared
        && let Some(by) = holders_beside(path).await.into_iter().next()
    {
        let used = PortError::InUse { path: path.clone(), by: Some(by) };
        return Err(lost(url, used.into()).into());
    }
    let done = unless_wanted(endpoint, overhear(endpoint, times, Link::open)).await;
    match done.map_err(|source| lost(url, source))? {
        Ok(heard) => Ok(heard.map_err(|source| lost(url, source))?),
        Err(Holder { pid, program }) => {
            Err(Failure::Silent(text::PortGiven { url, pid, program }.of(current())))
        }
    }
}

/// Does what only looks at a line, and starts it again when an urgent command has needed the port meanwhile.
/// `answer`: the longest time that it waits for an answer.
pub async fn giving_way<F: Future>(
    url: &str,
    endpoint: &Endpoint,
    answer: Duration,
    work: impl FnMut() -> F,
) -> Result<F::Output, Failure> {
    let gave = |Holder { pid, program }: &Holder| {
        complain(text::PortGivenAway { url, pid, program }.of(current()));
    };
    let done = door::giving_way(endpoint, answer, gave, work).await;
    let times = VISITS_MAX;
    let done = done.map_err(|source| lost(url, source))?;
    done.ok_or_else(|| Failure::Silent(text::PortGivenOften { url, times }.of(current())))
}

/// The same for what goes on for minutes and takes the line for itself: it gives way far more often.
pub async fn giving_way_for_long<F: Future>(
    url: &str,
    endpoint: &Endpoint,
    answer: Duration,
    mut work: impl FnMut() -> F,
) -> Result<F::Output, Failure> {
    for _ in 0..LONG_ROUNDS {
        let gave = |Holder { pid, program }: &Holder| {
            complain_aside({
                let (url, pid, program) = (url.to_owned(), *pid, program.clone());
                move || text::PortGivenAway { url: &url, pid, program: &program }.of(current())
            });
        };
        let done = door::giving_way(endpoint, answer, gave, &mut work).await;
        if let Some(done) = done.map_err(|source| lost(url, source))? {
            return Ok(done);
        }
    }
    let times = LONG_ROUNDS * VISITS_MAX;
    Err(Failure::Silent(text::PortGivenOften { url, times }.of(current())))
}

/// Opens the bare link of what must not wait. Says who has the port when it is not given soon, on a thread of
/// its own: a look at all processes takes up to a second, and a terminal that is held takes no line at all.
async fn urgently(url: &str, endpoint: &Endpoint) -> Result<Link, Failure> {
    let opening = Link::open_urgently(endpoint);
    tokio::pin!(opening);
    if let Ok(opened) = timeout(SOON, &mut opening).await {
        return Ok(opened.map_err(|source| lost(url, source))?);
    }
    if let Endpoint::Serial { path, .. } = endpoint {
        let path = path.clone();
        complain_aside(move || {
            let (port, s) = (Shown(path.display()), PATIENCE.as_secs());
            match user_of(&path) {
                Some(Holder { pid, program }) => {
                    text::PortAwaited { port, pid, program, s }.of(current())
                }
                None => text::PortAwaitedOf { port, s }.of(current()),
            }
        });
    }
    Ok(opening.await.map_err(|source| lost(url, source))?)
}

/// Why a frame would disturb others; `None` where it would not.
pub fn disturbs(url: &str, endpoint: &Endpoint, heard: &Overheard) -> Option<String> {
    if let (Some((baud, _)), Endpoint::Serial { line, .. }) = (&heard.elsewhere, endpoint) {
        let (own, who) = (line.baud, who(&heard.speakers()));
        return Some(text::LineAtOtherSpeed { url, own, baud, who }.of(current()));
    }
    let bytes = heard.here.bytes;
    heard.unreadable.then(|| text::LineNotFrames { url, bytes }.of(current()))
}

/// Devices by their addresses.
pub fn who(addresses: &[u8]) -> String {
    addresses.iter().map(|address| called(*address)).collect::<Vec<_>>().join(", ")
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn monitors_of_a_line_share_it() {
        let line_of = |url: &str| line_of(&url.parse().expect(url));
        let (a, b) = ("serial:///dev/ttyUSB0?addr=1", "serial:///dev/ttyUSB0?addr=2");
        assert!(line_of(a).is_some());
        assert_eq!(line_of(a), line_of(b));
        assert_ne!(line_of(a), line_of("serial:///dev/ttyUSB1?addr=1"));
        // Bare records carry no addresses, and each simulator is separate.
        assert_eq!(line_of("tcp://h:1?framing=records"), None);
        assert_eq!(line_of("sim:"), None);
    }
}
