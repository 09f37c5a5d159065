//! The links of the dashboard: connected and kept open in the background.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use lafet_client::{
    Answers, Client, Endpoint, LinkEvent, LinkStatistics, Monitor, Subscription, os_text,
};
use lafet_proto::answer::Reply;
use lafet_proto::request::Body;
use lafet_proto::{ParamId, Request, SubsystemId};
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinSet;
use tokio::time::sleep;

use super::scene::{Connected, Seen};
use crate::cli::Global;
use crate::connect::{Connection, line_of};
use crate::failure::Failure;
use crate::lang::current;

/// Pause before a failed link is tried again.
const AGAIN: Duration = Duration::from_secs(2);
/// Polling interval of limits and hotbeds, which change seldom.
const SELDOM: Duration = Duration::from_secs(3);
/// Most round trips kept: one per column.
const ROUND_TRIPS_MAX: usize = 400;

/// A monitor, and what keeps its state up to date.
pub struct Feed {
    name: String,
    url: String,
    slot: Arc<Mutex<Slot>>,
    /// Takes a Stop while a serial line is not in use yet.
    stops: Option<mpsc::Sender<Urgent>>,
}

/// The address of the monitor to stop, and where the outcome goes.
type Urgent = (u8, oneshot::Sender<Result<Answers, Failure>>);
/// Most Stops that wait for the same line: a further one would say nothing more.
const STOPS_MAX: usize = 16;

/// A monitor of a line, and the slot for its state.
type Member = (Endpoint, Arc<Mutex<Slot>>);

/// Where Stops for a line are sent, and where they arrive.
type Stops = (mpsc::Sender<Urgent>, mpsc::Receiver<Urgent>);

/// State of a monitor, as the background task knows it.
#[derive(Default)]
struct Slot {
    connected: Connected,
    /// Why the link will never be made: the URL is not valid.
    hopeless: Option<Failure>,
    open: Option<Open>,
    figures: Option<LinkStatistics>,
    round_trips: VecDeque<u64>,
}

struct Open {
    monitor: Monitor,
    state: Subscription,
    /// Subscriptions to limits and hotbeds, while they are shown.
    details: Option<(Subscription, Subscription)>,
}

impl Feed {
    /// Starts feeds of several monitors. Those on the same line share its connection.
    pub fn start(urls: &[Endpoint], global: &Global, period: Duration) -> Vec<Self> {
        let mut groups: Vec<(Option<Endpoint>, Vec<Member>, Stops)> = Vec::new();
        let mut feeds = Vec::new();
        for endpoint in urls {
            let slot = Arc::new(Mutex::new(Slot::default()));
            let (name, url) = (name(endpoint), endpoint.to_string());
            let line = line_of(endpoint);
            let member = (endpoint.clone(), slot.clone());
            let known = |(known, ..): &&mut (_, _, _)| line.is_some() && *known == line;
            let stops = match groups.iter_mut().find(known) {
                Some((_, members, (stops, _))) => {
                    members.push(member);
                    stops.clone()
                }
                None => {
                    let (stops, asked) = mpsc::channel(STOPS_MAX);
                    groups.push((line, vec![member], (stops.clone(), asked)));
                    stops
                }
            };
            let stops = matches!(endpoint, Endpoint::Serial { .. }).then_some(stops);
            feeds.push(Self { name, url, slot, stops });
        }
        for (_, members, (_, asked)) in groups {
            tokio::spawn(keep(members, global.clone(), period, asked));
        }
        feeds
    }

    /// A feed over an existing connection.
    pub fn over(connection: &Connection, period: Duration) -> Result<Self, Failure> {
        let client = connection.client.clone();
        let url = client.endpoint().to_owned();
        let name = url.parse().map_or_else(|_| url.clone(), |endpoint| name(&endpoint));
        let slot = Arc::new(Mutex::new(Slot::default()));
        tokio::spawn(listen(client.clone(), vec![slot.clone()]));
        subscribe(client, &slot, period)?;
        Ok(Self { name, url, slot, stops: None })
    }

    /// A copy of the current state.
    pub fn seen(&self) -> Seen {
        let slot = lock(&self.slot);
        let mut seen = Seen {
            name: self.name.clone(),
            url: self.url.clone(),
            connected: slot.connected.clone(),
            figures: slot.figures,
            round_trips: slot.round_trips.iter().copied().collect(),
            ..Seen::default()
        };
        let Some(open) = &slot.open else { return seen };
        seen.own = open.monitor.client().stats();
        seen.error = open.state.error().map(|error| error.localized(current()));
        if let Some(sample) = open.state.latest() {
            // A single refusal applies to the whole request.
            match sample.answers().clone().accepted() {
                Err(error) if sample.answers().len() == 1 => {
                    seen.error = Some(error.localized(current()));
                }
                _ => seen.answers = sample.answers().to_vec(),
            }
            (seen.age, seen.stale) = (sample.age(), sample.is_stale());
        }
        if let Some((limits, hotbeds)) = &open.details {
            seen.limits = limits.latest().map(|of| all_limits(of.answers())).unwrap_or_default();
            seen.hotbeds = hotbeds.latest().map(|of| all_hotbeds(of.answers())).unwrap_or_default();
        }
        seen
    }

    /// Starts or stops polling limits and hotbeds.
    pub fn look_closer(&self, closer: bool) {
        let mut slot = lock(&self.slot);
        let Some(open) = &mut slot.open else { return };
        match (closer, &open.details) {
            (true, None) => open.details = details(open.monitor.client()).ok(),
            (false, Some(_)) => open.details = None,
            _ => {}
        }
    }

    /// Whether everything requested has arrived, or will not.
    pub fn is_settled(&self, closer: bool, figures: bool) -> bool {
        let slot = lock(&self.slot);
        if matches!(slot.connected, Connected::Down(_)) {
            return true;
        }
        let Some(open) = &slot.open else { return false };
        let come = |of: &Subscription| of.latest().is_some() || of.error().is_some();
        let silent = open.state.error().is_some();
        let details = open.details.as_ref().is_some_and(|(a, b)| come(a) && come(b));
        let is_there = come(&open.state);
        is_there && (silent || ((details || !closer) && (slot.figures.is_some() || !figures)))
    }

    /// Why there will never be a link.
    pub fn hopeless(&self) -> Option<Failure> {
        lock(&self.slot).hopeless.take()
    }

    /// The monitor, once there was a link.
    pub fn monitor(&self) -> Option<Monitor> {
        lock(&self.slot).open.as_ref().map(|open| open.monitor.clone())
    }

    /// Sends Stop All; `None` where there is no link. It does not wait until a serial line was listened
    /// to.
    pub fn stop(&self) -> Option<impl Future<Output = Result<Answers, Failure>> + Send + use<>> {
        let mut monitor = self.monitor();
        let (ended, waits) = oneshot::channel();
        if monitor.is_none() {
            let address = self.url.parse::<Endpoint>().ok()?.addresses().monitor;
            if self.stops.as_ref()?.try_send((address, ended)).is_err() {
                // The link was made meanwhile, or enough Stops wait for it.
                monitor = Some(self.monitor()?);
            }
        }
        Some(async move {
            match monitor {
                Some(monitor) => Ok(monitor.client().request(&stop_all()).await?),
                // The task ends only with the program.
                None => waits.await.unwrap_or(Err(Failure::Interrupted)),
            }
        })
    }

    /// Short name of the monitor.
    pub fn name(&self) -> &str {
        &self.name
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

const fn stop_all() -> Request<'static> {
    Request { to: SubsystemId::ALL, body: Body::Stop }
}

/// Sends Stops on a line that was not listened to, until none is left; each at once, whether the one
/// before is answered or not.
async fn stop_unheard(global: &Global, first: Urgent, asked: &mut mpsc::Receiver<Urgent>) {
    let connection = match Connection::open_urgently(global).await {
        Ok(connection) => connection,
        Err(failure) => {
            // The page that asked may be gone.
            let _ = first.1.send(Err(failure));
            return;
        }
    };
    let mut stopping = JoinSet::new();
    stopping.spawn(stop_at(connection.clone(), first));
    loop {
        tokio::select! {
            Some(more) = asked.recv(), if stopping.len() < STOPS_MAX => {
                stopping.spawn(stop_at(connection.clone(), more));
            }
            ended = stopping.join_next() => {
                if ended.is_none() {
                    return;
                }
            }
        }
    }
}

async fn stop_at(connection: Connection, (address, ended): Urgent) {
    let stopped = async { Ok(connection.client.at(address)?.request(&stop_all()).await?) };
    // The page that asked may be gone.
    let _ = ended.send(stopped.await);
}

/// Connects, retrying until it succeeds; afterwards the client keeps the link itself.
async fn keep(
    members: Vec<Member>,
    global: Global,
    period: Duration,
    mut asked: mpsc::Receiver<Urgent>,
) {
    let Some((first, _)) = members.first() else { return };
    let global = Global { connect: Some(first.to_string()), open: None, ..global };
    let connection = loop {
        let opening = async {
            tokio::select! {
                biased;
                // The listening ends: the port is opened again only after it is closed.
                Some(urgent) = asked.recv() => Err(urgent),
                opened = Connection::new(&global) => Ok(opened),
            }
        };
        let opened = match opening.await {
            Ok(opened) => opened,
            Err(urgent) => {
                stop_unheard(&global, urgent, &mut asked).await;
                continue;
            }
        };
        match opened {
            Ok(connection) => break connection,
            Err(failure) => {
                let hopeless = failure.exit_code() == 2;
                for (_, slot) in &members {
                    lock(slot).connected = Connected::Down(failure.message());
                }
                if hopeless {
                    lock(&members[0].1).hopeless = Some(failure);
                    return;
                }
                tokio::select! {
                    () = sleep(AGAIN) => {}
                    Some(urgent) = asked.recv() => {
                        stop_unheard(&global, urgent, &mut asked).await;
                    }
                }
            }
        }
    };
    for (endpoint, slot) in &members {
        let client = connection.client.at(endpoint.addresses().monitor);
        let started = client.map_err(Failure::from);
        if let Err(failure) = started.and_then(|client| subscribe(client, slot, period)) {
            lock(slot).connected = Connected::Down(failure.message());
        }
    }
    // Stops that came while the link was made.
    asked.close();
    while let Some(urgent) = asked.recv().await {
        stop_at(connection.clone(), urgent).await;
    }
    let slots = members.into_iter().map(|(_, slot)| slot).collect();
    listen(connection.client, slots).await;
}

fn subscribe(client: Client, slot: &Mutex<Slot>, period: Duration) -> Result<(), Failure> {
    let request = Request::new(SubsystemId::ALL, Body::GetStatus);
    let state = client.subscribe(&request, period)?;
    let mut slot = lock(slot);
    slot.open = Some(Open { monitor: Monitor::new(client), state, details: None });
    slot.connected = Connected::Up;
    Ok(())
}

fn details(client: &Client) -> Result<(Subscription, Subscription), lafet_client::Error> {
    let limits = Request::new(SubsystemId::ALL, Body::RetrieveLimits);
    let hotbeds = Request::new(SubsystemId::DETECTOR, Body::GetParam { id: ParamId::HOTBEDS });
    Ok((client.subscribe(&limits, SELDOM)?, client.subscribe(&hotbeds, SELDOM)?))
}

/// Follows the events of the link: lost, restored, and its statistics.
async fn listen(client: Client, slots: Vec<Arc<Mutex<Slot>>>) {
    let mut events = client.events();
    // The monitors shown keep the link open; this task must not.
    drop(client);
    loop {
        let event = match events.recv().await {
            Ok(event) => event,
            Err(RecvError::Lagged(_)) => continue,
            Err(RecvError::Closed) => return,
        };
        for slot in &slots {
            note(&mut lock(slot), &event);
        }
    }
}

fn note(slot: &mut Slot, event: &LinkEvent) {
    match event {
        LinkEvent::Up => slot.connected = Connected::Up,
        LinkEvent::Down(error) => {
            slot.connected = Connected::Down(os_text(error, current()));
        }
        LinkEvent::Statistics(figures) => {
            slot.figures = Some(**figures);
            let trip = match figures.last.believed {
                0 => None,
                _ => figures.last.rtt_last,
            };
            let trip_us = trip.and_then(|trip| u64::try_from(trip.as_micros()).ok()).unwrap_or(0);
            slot.round_trips.push_back(trip_us);
            if slot.round_trips.len() > ROUND_TRIPS_MAX {
                slot.round_trips.pop_front();
            }
        }
        _ => {}
    }
}

fn all_limits(answers: &Answers) -> Vec<(SubsystemId, lafet_proto::status::Limits)> {
    let limits = answers.iter().filter_map(|answer| match answer.decode().ok()?.data {
        Reply::Limits(limits) => Some((answer.from(), limits)),
        _ => None,
    });
    limits.collect()
}

fn all_hotbeds(answers: &Answers) -> Vec<lafet_proto::status::Hotbed> {
    let decoded = answers.first().decode().ok();
    decoded.and_then(|answer| Some(answer.hotbeds()?.collect())).unwrap_or_default()
}

/// A name as short as it remains unambiguous: `10.0.0.5:10485/1`, `ttyUSB0/12`, `sim/1`.
fn name(endpoint: &Endpoint) -> String {
    let place = match endpoint {
        Endpoint::Tcp { host, port, .. } | Endpoint::Udp { host, port, .. } => {
            if host.contains(':') { format!("[{host}]:{port}") } else { format!("{host}:{port}") }
        }
        Endpoint::Serial { path, .. } => {
            path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
        }
        Endpoint::Sim { .. } => "sim".into(),
    };
    format!("{place}/{}", endpoint.addresses().monitor)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn endpoint(url: &str) -> Endpoint {
        url.parse().expect(url)
    }

    #[test]
    fn names_are_short() {
        for (url, short) in [
            ("tcp://10.0.0.5:10485?addr=3", "10.0.0.5:10485/3"),
            ("tcp://[::1]:7", "[::1]:7/1"),
            ("serial:///dev/ttyUSB0?addr=12", "ttyUSB0/12"),
            ("sim:?seed=4", "sim/1"),
        ] {
            assert_eq!(name(&endpoint(url)), short);
        }
    }
}
