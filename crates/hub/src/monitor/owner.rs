//! The owner of the links: connects, polls what is quick and what is slow, publishes it.
//!
//! The state of a monitor is one frame (GetStatus All), polled at its rate; limits, hotbeds and
//! parameters are read when they can have changed, a few in a frame, so that a command never waits
//! for more than the frame that is on the line.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use futures_util::future::select_all;
use lafet_client::transport::Link;
use lafet_client::{
    Cause, Client, Config as LinkConfig, Endpoint, Error, LinkEvent, Monitor, Update,
};
use lafet_proto::param::Param;
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, SubsystemId};
use lafet_texts::{Shown, Text as _, hub as text};
use tokio::sync::broadcast::error::RecvError;
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use crate::clock::Steps;
use crate::control::tuning;
use crate::hub::{Hub, all_end};
use crate::monitor::station::{ParamValue, Params, Progress, Station};
use crate::monitor::status::{self, Exchanged, Status, Subsystems, Unheld, Withheld};
use crate::monitor::view::Hotbeds;
use crate::sync::lock;

/// Pauses between attempts to connect.
const PAUSE_FIRST: Duration = Duration::from_millis(200);
const PAUSE_LAST: Duration = Duration::from_secs(2);
/// Least pause while something urgent waits for the first connection.
const PAUSE_ASKED: Duration = Duration::from_millis(20);
/// How often slow things are looked at.
const SLOW: Duration = Duration::from_secs(1);
/// Pause until the first state is there.
const SOON: Duration = Duration::from_millis(250);
/// Limits are read again this often, in rounds of [`SLOW`].
const LIMITS_ROUNDS: u64 = 30;
/// What ends a motion by hand when nothing renews it (§D/4).
const MOVE_HOLD: &str = "MoveHold";
/// Parameters in a frame: others have their turn after each.
const PARAMS_AT_ONCE: usize = 8;
/// Periods without an answer after which a state is stale.
const STALE_PERIODS: u64 = 3;
/// A monitor that was not heard for so long may be another one.
const EXCHANGED: Duration = Duration::from_secs(10);
/// The shortest time until then: an answer may take a retry.
const STALE_MS: u64 = 600;
/// What stays as it is goes into the history this often.
const ALL_EVERY_MS: u64 = 1000;

/// Starts everything that goes on by itself.
pub fn start(hub: &Hub) {
    hub.own();
    hub.always("authority", hold(hub.clone()));
    hub.always("upkeep", keep(hub.clone()));
    if hub.zones().is_some() {
        hub.always("zones", crate::zones::run(hub.clone()));
        hub.always("state of the zones", crate::zones::store(hub.clone()));
    }
    crate::field::start(hub);
    crate::plugs::start(hub);
    crate::cameras::start(hub);
    hub.always("integrity", crate::store::integrity::run(hub.clone()));
    hub.always("changes", crate::publish::broadcast::run(hub.clone()));
}

/// Connects to all monitors; dropping the result disconnects them.
pub fn own(hub: &Hub) -> JoinSet<()> {
    let mut links: BTreeMap<String, Vec<Arc<Station>>> = BTreeMap::new();
    for station in hub.stations() {
        links.entry(link_of(&station.config.endpoint)).or_default().push(station);
    }
    let mut owners = JoinSet::new();
    for stations in links.into_values() {
        owners.spawn(connect(hub.clone(), stations));
    }
    owners
}

/// Monitors with the same answer share a link.
pub fn link_of(endpoint: &Endpoint) -> String {
    let mut endpoint = endpoint.clone();
    match &mut endpoint {
        Endpoint::Tcp { addresses, .. }
        | Endpoint::Udp { addresses, .. }
        | Endpoint::Serial { addresses, .. }
        | Endpoint::Sim { addresses, .. } => addresses.monitor = 1,
    }
    endpoint.to_string()
}

/// Keeps a link. If a task of it ends by a panic, all of it is made new: the other links go on.
async fn connect(hub: Hub, stations: Vec<Arc<Station>>) {
    while !talk(&hub, &stations).await {
        for station in &stations {
            tracing::error!(monitor = station.id(), "its link is started again");
            // The port is free for the next client.
            station.client.send_replace(None);
            station.set_link(&hub, false, None);
            hub.observe(station);
        }
        sleep(PAUSE_LAST).await;
    }
}

/// Talks over a link until it ends; `false`: by a panic.
async fn talk(hub: &Hub, stations: &[Arc<Station>]) -> bool {
    let Some(first) = stations.first() else { return true };
    let mut pause = PAUSE_FIRST;
    let client = loop {
        match first_connection(&first.config.endpoint, stations).await {
            Ok(client) => break client,
            Err(error) => {
                let text = error.words();
                for station in stations {
                    station.set_link(hub, false, Some(text.clone()));
                    hub.observe(station);
                }
                sleep(PAUSE_ASKED).await;
                _ = timeout(pause, asked(stations)).await;
                pause = (pause * 2).min(PAUSE_LAST);
            }
        }
    };
    let mut tasks = JoinSet::new();
    for station in stations.iter().cloned() {
        let address = station.config.endpoint.addresses().monitor;
        match client.at(address) {
            Ok(client) => {
                station.client.send_replace(Some(client.clone()));
                station.set_link(hub, true, None);
                tasks.spawn(follow_link(hub.clone(), station.clone(), client.clone()));
                tasks.spawn(record(hub.clone(), station.clone(), client.clone()));
                tasks.spawn(poll(hub.clone(), station.clone(), client.clone()));
                tasks.spawn(read_slow(hub.clone(), station, client));
            }
            Err(error) => station.set_link(hub, false, Some(error.words())),
        }
    }
    drop(client);
    all_end(&mut tasks).await
}

/// Opens the first connection. When something urgent asks for it, who only listens to the port is asked to give
/// way.
async fn first_connection(endpoint: &Endpoint, stations: &[Arc<Station>]) -> Result<Client, Error> {
    tokio::select! {
        client = Client::connect_with(endpoint, link_config()) => return client,
        () = asked(stations) => {}
    }
    let lost =
        |source| Error::Link { endpoint: endpoint.to_string().into(), source: Arc::new(source) };
    let link = Link::open_urgently(endpoint).await.map_err(lost)?;
    Ok(Client::connect_on(endpoint, link, link_config()))
}

/// Waits until something urgent asks for a connection.
async fn asked(stations: &[Arc<Station>]) {
    select_all(stations.iter().map(|station| Box::pin(station.link_is_asked_for()))).await;
}

async fn follow_link(hub: Hub, station: Arc<Station>, client: Client) {
    let mut events = client.events();
    loop {
        match events.recv().await {
            Ok(LinkEvent::Up) => {
                station.set_link(&hub, true, None);
                hub.event(Some(station.id()), &text::LinkConnected.words());
                station.read_again();
            }
            Ok(LinkEvent::Down(error)) => {
                let was_up = station.is_up();
                let text = text::LinkLost { error: Shown(error) }.words();
                station.set_link(&hub, false, Some(text.clone()));
                if was_up {
                    hub.event(Some(station.id()), &text);
                }
            }
            Ok(LinkEvent::Statistics(_)) => station.set_figures(&hub),
            Ok(_) | Err(RecvError::Lagged(_)) => {}
            Err(RecvError::Closed) => return,
        }
    }
}

async fn poll(hub: Hub, station: Arc<Station>, client: Client) {
    let period = Duration::from_millis(station.config.poll_ms);
    let stale = Duration::from_millis((station.config.poll_ms * STALE_PERIODS).max(STALE_MS));
    let request = Request::new(SubsystemId::ALL, Body::GetStatus);
    let Ok(mut feed) = client.subscribe(&request, period) else { return };
    let (mut noted, mut observed, mut heard) = (Noted::default(), None, Exchanged::default());
    let mut silent_since = None;
    let mut patience = stale + link_config().of(&station.config.endpoint).first_listen();
    loop {
        let before = station.status();
        let update = timeout(patience, feed.next()).await;
        patience = stale;
        let mut status = match update {
            Ok(Update::Value(sample)) => {
                hub.counts().polls.fetch_add(1, Ordering::Relaxed);
                heard = station.exchanged();
                station.heard(&hub, sample.age());
                let age_ms = u64::try_from(sample.age().as_millis()).unwrap_or(0);
                Status {
                    at_ms: Some(hub.clock().now_ms().saturating_sub(age_ms)),
                    stale: false,
                    queued: false,
                    withheld: None,
                    error: None,
                    resumes_ms: None,
                    subsystems: status::subsystems(sample.answers().iter(), &before.subsystems),
                }
            }
            Ok(Update::Stale(error)) => {
                let withheld = withheld(&station, Some(&error));
                let error = Some(error.words());
                Status { stale: true, queued: false, withheld, error, ..Status::clone(&before) }
            }
            Ok(_) => continue,
            Err(_) => {
                let since = station.exchanged().since(&heard);
                let queued = since.own.timeouts == 0 && since.line.timeouts > 0;
                // What is reported once may have another reason since.
                let withheld = withheld(&station, feed.error().as_ref());
                Status { stale: true, queued, withheld, ..Status::clone(&before) }
            }
        };
        if status.subsystems.is_empty() && !status.stale {
            // It answers, but not with its state: what it was before is not known any more.
            status.stale = true;
        }
        if status.stale {
            silent_since.get_or_insert(hub.now());
        } else if silent_since.take().is_some_and(|since| hub.now() - since >= EXCHANGED) {
            station.read_again();
        }
        noted.note(&hub, station.id(), &status);
        station.set_status(&hub, status);
        hub.watch_keep_outs(&station);
        observe_news(&hub, &station, &mut observed);
    }
}

/// On a serial line a frame at a wrong speed disturbs others.
fn link_config() -> LinkConfig {
    LinkConfig { heed: true, ..LinkConfig::default() }
}

/// Why the polls of a monitor are not sent, if they are not.
fn withheld(station: &Station, error: Option<&Error>) -> Option<Withheld> {
    let Some(Error::NotSent { cause, .. }) = error else { return None };
    match (cause, &station.config.endpoint) {
        (Cause::Unreadable, Endpoint::Serial { line, .. }) => {
            Some(Withheld::Unreadable { baud: line.baud })
        }
        (Cause::ControllerPresent, _) => Some(Withheld::Controller),
        _ => None,
    }
}

/// Keeps the frames of a monitor for recordings.
async fn record(hub: Hub, station: Arc<Station>, client: Client) {
    let (mut frames, address) = (client.trace(), client.address());
    loop {
        match frames.recv().await {
            Ok(frame) if frame.dst == address || frame.src == address => {
                if frame.dst == address && has_move(&frame.payload) {
                    lock(&station.programs).moved(hub.clock().now_ms());
                }
                hub.recordings().frame(hub.clock().now_ms(), station.id(), &frame);
            }
            Ok(_) | Err(RecvError::Lagged(_)) => {}
            Err(RecvError::Closed) => return,
        }
    }
}

/// A Move pauses a program (§3.1/3), whichever client sends it.
fn has_move(payload: &[u8]) -> bool {
    Records::new(payload).map_while(Result::ok).any(|record| record.request == RequestId::MOVE)
}

/// The states of subsystems that the history has, and when it had all of them last.
#[derive(Default)]
struct Noted {
    subsystems: Subsystems,
    all_ms: u64,
}

impl Noted {
    /// Puts the values of a state into the history: what has changed, and from time to time all. A
    /// value whose sensor is faulty is left out.
    fn note(&mut self, hub: &Hub, monitor: &str, status: &Status) {
        let mut history = hub.history();
        if status.stale {
            self.subsystems.clear();
            return history.lost(hub.clock().now_ms(), monitor);
        }
        let Some(at_ms) = status.at_ms else { return };
        if at_ms.abs_diff(self.all_ms) >= ALL_EVERY_MS {
            self.all_ms = at_ms;
            self.subsystems.clear();
        }
        for (name, state) in &status.subsystems {
            if self.subsystems.get(name).is_some_and(|it| Arc::ptr_eq(it, state)) {
                continue;
            }
            let mut had = history.note(at_ms, monitor, &format!("{name}.bits"), state.bits.into());
            for (field, value) in &state.fields {
                let series = format!("{name}.{field}");
                if state.bad.contains_key(field) {
                    history.lost_series(at_ms, monitor, &series);
                } else {
                    had &= history.note(at_ms, monitor, &series, *value as f64);
                }
            }
            match had {
                true => _ = self.subsystems.insert(name, state.clone()),
                false => _ = self.subsystems.remove(name),
            }
        }
    }
}

/// Raises and clears alarms, if a state has other flags than the last one, or an alarm is about to
/// return.
fn observe_news(hub: &Hub, station: &Station, last: &mut Option<(Arc<Status>, bool)>) {
    let now = (station.status(), station.is_up());
    let same = last.as_ref().is_some_and(|it| it.1 == now.1 && it.0.has_flags_of(&now.0));
    if !same || hub.alarms().is_returning(station.id()) {
        hub.observe(station);
    }
    *last = Some(now);
}

async fn read_slow(hub: Hub, station: Arc<Station>, client: Client) {
    let monitor = Monitor::new(client.clone());
    let (mut round, mut again, mut had) = (0_u64, true, false);
    loop {
        let status = station.status();
        if station.is_up() && !status.stale && status.at_ms.is_some() {
            if again || round.is_multiple_of(LIMITS_ROUNDS) {
                read_limits(&hub, &station, &monitor).await;
            }
            if again {
                tuning::put_back(&hub, &station, &client).await;
                read_params(&hub, &station, &monitor).await;
                again = false;
            }
            let found = status.is_set(SubsystemId::DETECTOR, "Found")
                || status.is_set(SubsystemId::DETECTOR, "Searching");
            if (found || had)
                && let Ok(hotbeds) = monitor.hotbeds().await
            {
                station.set_hotbeds(&hub, Hotbeds::new(hub.clock().now_ms(), &hotbeds));
            }
            had = found;
            round += 1;
        }
        // What a release needs is not read late because the first state was not there yet.
        let pause = if again { SOON } else { SLOW };
        tokio::select! {
            () = sleep(pause) => {}
            () = station.reread.notified() => again = true,
        }
    }
}

async fn read_limits(hub: &Hub, station: &Station, monitor: &Monitor) {
    if let Ok(limits) = monitor.limits_all().await {
        let limits = limits.into_iter().map(|(id, limits)| (id.to_string(), limits.into()));
        station.set_limits(hub, limits.collect());
    }
}

/// Of a monitor that is silent each parameter would be waited for: they stay as they were, and are
/// read when it is heard again.
fn read_later(hub: &Hub, station: &Station) {
    {
        let mut params = lock(&station.params);
        (params.reading, params.progress) = (false, None);
    }
    station.publish_progress(hub, None);
    station.reread.notify_one();
}

/// Reads all parameters of the subsystems that the monitor has; if another task does, waits for it.
pub async fn read_params(hub: &Hub, station: &Station, monitor: &Monitor) {
    let Ok(_reading) = station.reading.try_lock() else {
        drop(station.reading.lock().await);
        // What was read before a change is read again.
        if lock(&station.stored).is_behind() {
            station.reread.notify_one();
        }
        return;
    };
    let status = station.status();
    let has = |param: &Param| status.bits(param.spec().subsystem).is_some();
    let which: Vec<Param> = Param::ALL.iter().copied().filter(has).collect();
    {
        let mut params = lock(&station.params);
        params.reading = true;
        params.progress = Some(Progress { done: 0, total: which.len() });
        station.publish_progress(hub, params.progress);
    }
    let mut has_hold = None;
    let mut read = Params { at_ms: Some(hub.clock().now_ms()), ..Params::default() };
    for (chunk, params) in which.chunks(PARAMS_AT_ONCE).enumerate() {
        if station.status().stale {
            return read_later(hub, station);
        }
        let since = lock(&station.stored).since();
        for (param, values) in params.iter().zip(monitor.params(params).await) {
            if let Ok(values) = &values {
                lock(&station.stored).put(since, *param, values);
            }
            if param.name() == MOVE_HOLD {
                has_hold = knows(&values).or(has_hold);
            }
            let value = match values {
                Ok(values) => ParamValue::Values(values),
                Err(error) => ParamValue::Error(error.words()),
            };
            let subsystem = read.values.entry(param.spec().subsystem.to_string()).or_default();
            subsystem.insert(param.name().to_owned(), value);
        }
        let done = (chunk * PARAMS_AT_ONCE + params.len()).min(which.len());
        let progress = Some(Progress { done, total: which.len() });
        lock(&station.params).progress = progress;
        station.publish_progress(hub, progress);
    }
    let water =
        water_timeout(&read).filter(|it| water_timeout(&lock(&station.params)) != Some(*it));
    let unheld = {
        let mut params = lock(&station.params);
        keep_values(&mut read, &params);
        read.unheld = has_hold.map_or(params.unheld, |has_hold| !has_hold);
        let news = read.unheld && !params.unheld;
        *params = read;
        news
    };
    if let Some(seconds) = water {
        hub.water_timeout_is(station, seconds);
    }
    if unheld {
        hub.event(Some(station.id()), &Unheld::text().what);
    }
    if let Some(has_hold) = has_hold {
        hub.alarms().holding(station.id()).set_hold(has_hold);
        hub.observe(station);
    }
    station.publish_readiness(hub);
    station.publish_params(hub);
    station.publish_progress(hub, None);
}

/// A value that was read is not forgotten because it could not be read again.
fn keep_values(read: &mut Params, before: &Params) {
    for (subsystem, of) in &mut read.values {
        let Some(before) = before.values.get(subsystem) else { continue };
        for (name, value) in of {
            let known = before.get(name).filter(|it| matches!(it, ParamValue::Values(_)));
            if let (ParamValue::Error(_), Some(known)) = (&*value, known) {
                *value = known.clone();
            }
        }
    }
}

/// Reads a stored program that is needed now, if it was not read since it may have changed: reading all parameters
/// takes seconds on a slow line. Who asks bounds the wait.
pub async fn read_ahead(hub: &Hub, station: &Station, param: Param) {
    let since = {
        let stored = lock(&station.stored);
        if stored.of(param).is_some() {
            return;
        }
        stored.since()
    };
    let Ok(client) = station.client() else { return };
    let monitor = Monitor::new(client);
    let Some(Ok(values)) = monitor.params(&[param]).await.pop() else { return };
    lock(&station.stored).put(since, param, &values);
    let mut params = lock(&station.params);
    if params.of(param).is_none() {
        let of = params.values.entry(param.spec().subsystem.to_string()).or_default();
        of.insert(param.name().to_owned(), ParamValue::Values(values));
        drop(params);
        station.publish_params(hub);
    }
}

/// After how long the monitor ends water that no client confirms, s, if it was read.
fn water_timeout(params: &Params) -> Option<u32> {
    u32::try_from(*params.of(Param::GeneralWaterTimeout)?.first()?).ok()
}

/// Whether a monitor knows a parameter; one that did not answer has not said.
const fn knows<T>(result: &Result<T, lafet_client::Error>) -> Option<bool> {
    match result {
        Ok(_) => Some(true),
        Err(lafet_client::Error::Refused { .. }) => Some(false),
        Err(_) => None,
    }
}

/// Holds the times of authority, and touches nothing that may wait for a disk.
async fn hold(hub: Hub) {
    let mut ticks = tokio::time::interval(Duration::from_millis(100));
    ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    let mut shutdown = hub.shutdown();
    loop {
        tokio::select! {
            _ = ticks.tick() => {}
            () = shutdown.requested() => return,
        }
        hub.handle_timeouts();
        hub.tick();
    }
}

/// What the hub does from time to time.
async fn keep(hub: Hub) {
    let mut ticks = tokio::time::interval(Duration::from_millis(100));
    ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    let mut steps = Steps::from_now(hub.clock());
    let mut shutdown = hub.shutdown();
    for tick in 0_u64.. {
        tokio::select! {
            _ = ticks.tick() => {}
            () = shutdown.requested() => break,
        }
        if tick.is_multiple_of(10) {
            hub.look_at_clock(&mut steps);
            hub.look_at_itself();
            hub.history().flush();
            hub.events().flush();
            hub.rates().take(tokio::time::Instant::now(), hub.counts());
            hub.recordings().handle_time(hub.clock().now_ms(), hub.clock().cautious_ms());
        }
        if tick.is_multiple_of(36_000) {
            let history = hub.history();
            let now_ms = hub.clock().cautious_ms();
            history.forget(now_ms, hub.config().raw_days, hub.config().minute_days);
            hub.events().forget(now_ms, hub.config().minute_days);
        }
    }
    // The disk is waited for elsewhere.
    let own = hub.clone();
    _ = tokio::task::spawn_blocking(move || own.recordings().end_all()).await;
    hub.events().flush();
    hub.history().flush();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::Clock;
    use crate::config::Config;
    use crate::monitor::status::Subsystem;

    fn status(at_ms: u64, of: &Arc<Subsystem>) -> Status {
        let subsystems = [("Climatics", of.clone())].into();
        Status { at_ms: Some(at_ms), subsystems, ..Status::default() }
    }

    #[tokio::test]
    async fn a_faulty_sensors_value_is_left_out_of_the_history() {
        let hub = Hub::new(Config::default(), Clock::System, serde_json::json!({})).unwrap();
        let state = |bits, temperature| {
            let mut state = Subsystem::default();
            state.set_bits(SubsystemId::CLIMATICS, bits);
            state.fields = [("housing", temperature)].into();
            Arc::new(state)
        };
        let fault = 1 << flag_bit("BoxSensorFault");
        let (good, faulty, again) = (state(0, 20), state(fault, -128), state(0, 21));
        assert!(faulty.bad.contains_key("housing"), "{faulty:?}");
        let mut noted = Noted::default();
        for (at_ms, state) in [(1000, &good), (1500, &good), (2000, &faulty), (4000, &again)] {
            noted.note(&hub, "M1", &status(at_ms, state));
        }
        let flushed = hub.history().flushed();
        let base = flushed.await;
        let rows = base.values("M1", "Climatics.housing", (0, 9000), None, 100).await.unwrap();
        let expected = serde_json::json!([[1000, 20.0], [2000, null], [4000, 21.0]]);
        assert_eq!(serde_json::json!(rows), expected);
    }

    fn flag_bit(name: &str) -> u32 {
        let info = lafet_proto::flags::flags_of(SubsystemId::CLIMATICS).by_name(name).unwrap();
        info.mask().trailing_zeros()
    }
}
