//! The hub: what all its parts share, and what changes of authority mean to others.

use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::Duration;

use axum::extract::ws::Utf8Bytes;
use lafet_proto::SubsystemId;
use serde::Serialize;
use serde_json::{Map, Value};
use tokio::sync::{mpsc, watch};
use tokio::task::JoinSet;
use tokio::time::Instant;
use utoipa::ToSchema;

use crate::access::{Access, Bucket, Logins, Principal, Turns};
use crate::alarms::Alarms;
use crate::api::{Answering, Lasting, Packing, Places};
use crate::authority::{Notice, Now, REASON_MAX, Refusal, Seat};
use crate::broadcast::Audiences;
use crate::clock::Clock;
use crate::config::{Config, MonitorConfig};
use crate::error::ApiError;
use crate::integrity::Integrity;
use crate::messages::Message;
use crate::owner;
use crate::rates::Rates;
use crate::recording::Recordings;
use crate::request::MonitorRequest;
use crate::simulation::{Scene, Simulation};
use crate::site::Site;
use crate::station::Station;
use crate::store::{self, Act, Audit, Events, Head, History, Record, StoreError};
use crate::sync::lock;
use crate::text::{Both, both};
use crate::topics::Topics;
use crate::view::Control;
use crate::words::LossWord;

/// Messages that a slow connection may lag behind.
pub const EVENTS_MAX: usize = 128;
/// Requests of one user: so many at once, so many a second. Stop, Close, Lockout are not counted.
const REQUESTS: (f64, f64) = (100.0, 50.0);
/// Passwords that are hashed at once: there is memory for one, and commands need the other processor.
const HASHING_MAX: usize = 1;
/// And that only read: a page that opens asks for much at once.
const READS: (f64, f64) = (400.0, 100.0);
/// Users and sessions whose requests are counted.
const BUCKETS_MAX: usize = 10_000;

/// The hub. Clones are the same one.
#[derive(Clone, Debug)]
pub struct Hub(Arc<Inner>);

/// What belongs to the hub.
#[derive(Debug)]
pub struct Inner {
    /// Holds the folder of the state against another hub.
    #[expect(dead_code, reason = "held for its end")]
    lock_file: Option<std::fs::File>,
    /// What it was told.
    pub config: Config,
    /// The date.
    pub clock: Clock,
    /// When it began.
    pub start: Instant,
    /// The same, ms since 1970.
    pub started_ms: u64,
    /// What is published.
    pub topics: Topics,
    /// The audit log.
    pub audit: Audit,
    /// Whether the state is what was written.
    pub integrity: Integrity,
    /// Users, sessions, tokens.
    pub access: Access,
    /// The history.
    pub history: Mutex<History>,
    /// What has happened.
    pub events: Events,
    /// How often things happen.
    pub rates: Rates,
    /// What has changed last, as it is sent to everybody.
    pub changes: Audiences,
    /// Counts changes of users, sessions and tokens.
    pub sessions: watch::Sender<u64>,
    /// The recordings.
    pub recordings: Recordings,
    /// The alarms.
    pub alarms: Mutex<Alarms>,
    /// Logins that failed.
    pub logins: Mutex<Logins>,
    /// The connections that are open.
    pub places: Mutex<Places>,
    /// Who is being sent an answer.
    pub answering: Answering,
    /// Who packs an answer.
    pub packing: Packing,
    /// Who may hash a password now.
    pub hashing: Turns,
    /// The dictionary of the protocol, as JSON.
    pub dictionary: Lasting,
    /// What happens, in figures.
    pub counts: Counts,
    /// `true`: the hub ends.
    pub ending: watch::Sender<bool>,
    /// A simulation that is behind the monitors, if there is one.
    pub simulation: OnceLock<Box<dyn Simulation>>,
    stations: Mutex<Arc<BTreeMap<String, Arc<Station>>>>,
    /// Where things stand.
    site: Mutex<Option<Site>>,
    /// What goes on for each link; dropping it ends that.
    owners: Mutex<Option<JoinSet<()>>>,
    seats: Mutex<HashMap<String, Live>>,
    buckets: Mutex<HashMap<String, Bucket>>,
    next_seat: AtomicU64,
    /// The end of the audit log as it was noted before this start.
    pub noted: Mutex<Head>,
}

/// Figures for the metrics.
#[derive(Debug, Default)]
pub struct Counts {
    /// Connections that are open.
    pub connections: AtomicU64,
    /// WebSockets that are open.
    pub sockets: AtomicU64,
    /// Requests to monitors.
    pub commands: AtomicU64,
    /// Requests that were not accepted.
    pub refused: AtomicU64,
    /// Answers to polls.
    pub polls: AtomicU64,
    /// Requests over HTTP.
    pub requests: AtomicU64,
    /// Messages to WebSockets.
    pub messages: AtomicU64,
    /// Bytes of these.
    pub message_bytes: AtomicU64,
    /// Motions held.
    pub jogs: AtomicU64,
    /// Messages dropped, as a connection was slow.
    pub missed: AtomicU64,
    /// Logins that failed.
    pub logins_failed: AtomicU64,
    /// Longest time from a Stop's arrival to its answer, microseconds.
    pub stop_max_us: AtomicU64,
}

/// A WebSocket.
#[derive(Debug)]
struct Live {
    events: mpsc::Sender<Utf8Bytes>,
    missed: Arc<AtomicU64>,
    /// Which connection this is.
    connection: u64,
    /// What brings it back; `None`: there were no random numbers, and it does not come back.
    resume: Option<String>,
    principal: Principal,
    from: String,
    since_ms: u64,
}

/// Who sits at a WebSocket.
#[derive(Clone, Debug)]
pub struct Seated {
    /// The seat.
    pub seat: String,
    /// Who.
    pub principal: Principal,
    /// From where.
    pub from: String,
    /// Since when.
    pub since_ms: u64,
    /// The connection stands; else it is lost, and may come back.
    pub open: bool,
}

/// What a new WebSocket is given.
#[derive(Debug)]
pub struct SeatKey {
    /// Its seat.
    pub seat: String,
    /// With this, it may come back to it.
    pub resume: Option<String>,
    /// What it is told besides values.
    pub events: mpsc::Receiver<Utf8Bytes>,
    /// How many of these were dropped.
    pub missed: Arc<AtomicU64>,
    connection: u64,
}

/// Who asks for something, and from where.
#[derive(Clone, Debug)]
pub struct Caller {
    /// Who.
    pub principal: Principal,
    /// From where.
    pub seat: Seat,
    /// `ws` or `http`.
    pub via: &'static str,
}

impl std::ops::Deref for Hub {
    type Target = Inner;

    fn deref(&self) -> &Inner {
        &self.0
    }
}

impl Hub {
    /// Opens the storage and builds the hub; nothing runs yet.
    pub fn new(config: Config, clock: Clock, dictionary: Value) -> Result<Self, StoreError> {
        let folder = config.data.clone();
        let folder = folder.as_deref();
        let lock_file = folder.map(store::occupy).transpose()?;
        let integrity = Integrity::examine(&config)?;
        for warning in &config.warnings {
            tracing::warn!("{warning}");
        }
        let stations = stations_of(&config, &config.monitors);
        let (events, alarms) = Events::open_with_alarms(folder)?;
        let alarms = Alarms::restored(&alarms, &stations.keys().cloned().collect());
        let hub = Self(Arc::new(Inner {
            stations: Mutex::new(Arc::new(stations)),
            site: Mutex::new(config.site.clone()),
            simulation: OnceLock::new(),
            owners: Mutex::default(),
            audit: Audit::open(folder)?,
            integrity,
            noted: Mutex::default(),
            access: Access::open(folder, clock.steady_ms())?,
            history: Mutex::new(match config.postgres.clone() {
                Some(address) => History::open_postgres(address)?,
                None => History::open(folder)?,
            }),
            events,
            rates: Rates::default(),
            changes: Audiences::default(),
            sessions: watch::Sender::new(0),
            recordings: Recordings::open(&config.recording)?,
            alarms: Mutex::new(alarms),
            logins: Mutex::default(),
            places: Mutex::default(),
            answering: Answering::default(),
            packing: Packing::default(),
            hashing: Turns::new(HASHING_MAX),
            topics: Topics::default(),
            start: Instant::now(),
            started_ms: clock.now_ms(),
            counts: Counts::default(),
            ending: watch::Sender::new(false),
            seats: Mutex::default(),
            buckets: Mutex::default(),
            next_seat: AtomicU64::new(1),
            lock_file,
            config,
            clock,
            dictionary: Lasting::new(dictionary.to_string()),
        }));
        *lock(&hub.noted) = hub.integrity.mark()?;
        hub.report_losses();
        hub.topics.set("hub", &hub.about());
        for alarm in lock(&hub.alarms).list() {
            hub.topics.set(&format!("alarms/{}", alarm.id), alarm);
        }
        hub.topics.set("fire", &lock(&hub.alarms).fire());
        for station in hub.stations() {
            station.publish_all(&hub);
        }
        Ok(hub)
    }

    /// Time since the start.
    pub fn now(&self) -> Now {
        self.start.elapsed()
    }

    /// What the hub is.
    pub fn about(&self) -> About {
        About {
            name: "lafet",
            version: env!("CARGO_PKG_VERSION"),
            api: 1,
            demo: self.config.demo,
            simulation: self.config.simulation,
            login: self.config.login,
            started_ms: self.started_ms,
            site: lock(&self.site).clone(),
        }
    }

    /// The monitor with this id.
    pub fn station(&self, id: &str) -> Result<Arc<Station>, ApiError> {
        lock(&self.stations).get(id).cloned().ok_or_else(|| ApiError::no_monitor(id))
    }

    /// All monitors.
    pub fn stations(&self) -> Vec<Arc<Station>> {
        lock(&self.stations).values().cloned().collect()
    }

    /// Height of a monitor's nozzle above the ground, cm, if the configuration has it.
    pub fn height_cm(&self, id: &str) -> Option<i32> {
        let height_m = lock(&self.site).as_ref()?.monitors.get(id)?.height;
        Some((height_m * 100.0).round() as i32)
    }

    /// Owns the links from now on.
    pub fn own(&self) {
        *lock(&self.owners) = Some(owner::own(self));
    }

    /// Other monitors instead of these, as a simulation has loaded another site: nobody holds
    /// them, and the alarms of the old ones are gone.
    pub fn replace_monitors(&self, monitors: &[MonitorConfig], site: Option<Site>) {
        let owned = lock(&self.owners).take().is_some();
        let new = Arc::new(stations_of(&self.config, monitors));
        let old = std::mem::replace(&mut *lock(&self.stations), new.clone());
        *lock(&self.site) = site;
        self.recordings.forget();
        for station in old.values() {
            let changes = lock(&self.alarms).forget(station.id());
            self.publish_alarms(changes);
            let (now_ms, mut history) = (self.clock.now_ms(), lock(&self.history));
            history.lost(now_ms, station.id());
            history.lost_link(now_ms, station.id());
            drop(history);
            if !new.contains_key(station.id()) {
                station.unpublish(self);
            }
        }
        new.values().for_each(|station| station.publish_all(self));
        self.topics.set("hub", &self.about());
        if owned {
            self.own();
        }
    }

    /// Requests sent to monitors so far.
    pub fn count_of_commands(&self) -> u64 {
        self.counts.commands.load(Ordering::Relaxed)
    }

    /// Publishes what only a simulation knows.
    pub fn publish_scene(&self, scene: &Scene) {
        self.recordings.scene(self.clock.now_ms(), scene);
        self.topics.set("scene", scene);
    }

    /// A WebSocket has been opened; with the right secret it has its old seat again.
    pub fn sit_down(&self, principal: &Principal, from: &str, resume: Option<&str>) -> SeatKey {
        self.sit_down_with(principal, from, resume, crate::access::secret().ok())
    }

    /// The same with the secret of the new connection, if there is one.
    fn sit_down_with(
        &self,
        principal: &Principal,
        from: &str,
        resume: Option<&str>,
        secret: Option<String>,
    ) -> SeatKey {
        let user = &principal.user;
        let (sender, events) = mpsc::channel(EVENTS_MAX);
        let missed = Arc::new(AtomicU64::new(0));
        let mut seats = lock(&self.seats);
        let old = resume.and_then(|secret| {
            let matches = |live: &&Live| {
                live.resume.as_deref() == Some(secret) && live.principal.user == *user
            };
            seats.iter().find(|(_, live)| matches(live)).map(|(seat, _)| seat.clone())
        });
        let connection = self.next_seat.fetch_add(1, Ordering::Relaxed);
        let seat = old.unwrap_or_else(|| format!("s{connection}"));
        let live = Live {
            events: sender,
            missed: missed.clone(),
            connection,
            resume: secret.clone(),
            principal: principal.clone(),
            from: from.to_owned(),
            since_ms: self.clock.now_ms(),
        };
        seats.insert(seat.clone(), live);
        drop(seats);
        for station in self.stations() {
            lock(&station.authority).back(self.now(), &seat);
            station.publish_authority(self);
        }
        SeatKey { seat, resume: secret, events, missed, connection }
    }

    /// A WebSocket is closed: what it moves stops, what it holds is lost unless it comes back.
    pub fn stand_up(&self, key: &SeatKey) {
        let mut seats = lock(&self.seats);
        if seats.get(&key.seat).is_none_or(|live| live.connection != key.connection) {
            return;
        }
        let mut holds = false;
        for station in self.stations() {
            station.let_go(&key.seat);
            holds |= lock(&station.authority).lost(self.now(), &key.seat);
            station.publish_authority(self);
        }
        if !holds {
            seats.remove(&key.seat);
        }
    }

    /// Who sits at WebSockets.
    pub fn seated(&self) -> Vec<Seated> {
        let seats = lock(&self.seats);
        let one = |(seat, live): (&String, &Live)| Seated {
            seat: seat.clone(),
            principal: live.principal.clone(),
            from: live.from.clone(),
            since_ms: live.since_ms,
            open: !live.events.is_closed(),
        };
        seats.iter().map(one).collect()
    }

    /// Tells a WebSocket something.
    pub fn tell(&self, seat: &str, message: &Message) {
        self.tell_text(seat, message.written());
    }

    /// The same as text: what waits for a slow connection takes little room.
    fn tell_text(&self, seat: &str, message: Utf8Bytes) {
        let seats = lock(&self.seats);
        if let Some(live) = seats.get(seat)
            && live.events.try_send(message).is_err()
        {
            live.missed.fetch_add(1, Ordering::Relaxed);
            self.counts.missed.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Tells everybody what has happened.
    pub fn event(&self, monitor: Option<&str>, what: &Both) {
        tracing::info!(monitor, "{}", what.en);
        self.events.note(self.clock.now_ms(), monitor, what);
        let (at_ms, monitor) = (self.clock.now_ms(), monitor.map(str::to_owned));
        let message = Message::Event { at_ms, monitor, what: what.clone() }.written();
        let seats: Vec<String> = lock(&self.seats).keys().cloned().collect();
        seats.iter().for_each(|seat| self.tell_text(seat, message.clone()));
    }

    /// One request more of this user: there are limits. Stop, Close and Lockout do not ask here.
    pub fn count_request(&self, principal: &Principal) -> Result<(), ApiError> {
        self.count("", principal, REQUESTS)
    }

    /// One more that changes something over HTTP.
    pub fn count_change(&self, principal: &Principal) -> Result<(), ApiError> {
        self.count("changes ", principal, REQUESTS)
    }

    /// One more that reads. What somebody reads takes nothing from what they may command.
    pub fn count_reading(&self, principal: &Principal) -> Result<(), ApiError> {
        self.count("reads ", principal, READS)
    }

    fn count(&self, what: &str, by: &Principal, (most, per_s): (f64, f64)) -> Result<(), ApiError> {
        let now = self.now();
        let mut buckets = lock(&self.buckets);
        if buckets.len() >= BUCKETS_MAX {
            buckets.clear();
        }
        let key = format!("{what}{}/{}", by.user, by.key);
        let bucket = buckets.entry(key).or_insert_with(|| Bucket::new(now, most, per_s));
        bucket.take(now).map_err(ApiError::slow_down)
    }

    /// A record of what somebody does.
    pub fn record(&self, caller: &Caller, monitor: &str, what: &str, outcome: &str) -> Record {
        Record {
            at_ms: self.clock.now_ms(),
            user: caller.principal.user.clone(),
            role: caller.principal.role.name().to_owned(),
            from: caller.seat.from.clone(),
            via: caller.via.to_owned(),
            seat: caller.seat.seat.clone(),
            monitor: monitor.to_owned(),
            what: what.to_owned(),
            outcome: outcome.to_owned(),
            details: Value::Object(Map::new()),
            kind: (caller.via != "hub").then_some(caller.principal.kind),
            act: None,
        }
    }

    /// The record that the hub ends: the last one of a clean end.
    pub fn record_of_end(&self) -> Record {
        self.record(&Caller::hub(), "", "end", "Ok").about(&Act::End)
    }

    /// A change of authority that somebody asks for.
    pub fn change_authority(
        &self,
        caller: &Caller,
        station: &Arc<Station>,
        action: &str,
        reason: Option<&str>,
    ) -> Result<Control, ApiError> {
        use crate::access::Role;
        let needs = if action == "force" { Role::Engineer } else { Role::Operator };
        if caller.principal.role < needs || !caller.principal.is_good() {
            return Err(ApiError::role(needs));
        }
        self.count_request(&caller.principal)?;
        if reason.is_some_and(|reason| reason.chars().count() > REASON_MAX) {
            return Err(ApiError::bad_request(both(
                format!("reason has at most {REASON_MAX} characters."),
                format!("reason — не длиннее {REASON_MAX} символов."),
            )));
        }
        let (now, seat, id) = (self.now(), caller.seat.clone(), station.id());
        let result = {
            let mut authority = lock(&station.authority);
            match action {
                "take" => authority.take(now, seat),
                "release" => authority.release(&seat.seat),
                "request" => authority.ask(now, seat),
                "grant" => authority.grant(now, &seat.seat),
                "deny" => authority.deny(&seat.seat),
                "force" => authority.force(now, seat, reason.unwrap_or_default()),
                _ => {
                    let action = crate::error::shown(action);
                    let list = "take, release, request, grant, deny, force";
                    return Err(ApiError::bad_request(both(
                        format!("`{action}` is none of {list}."),
                        format!("`{action}` — не {list}."),
                    )));
                }
            }
        };
        let outcome = match &result {
            Ok(_) => "Ok",
            Err(Refusal::Held(_) | Refusal::NotHolder(_)) => "held",
            Err(_) => "refused",
        };
        let act = Act::Authority { action: action.into(), reason: reason.map(str::to_owned) };
        let record = self.record(caller, id, &format!("authority {action}"), outcome);
        let record = match reason {
            Some(reason) => record.with(&Forced { reason }),
            None => record,
        };
        drop(self.audit.note(record.about(&act)));
        let notices = result.map_err(|refusal| ApiError::authority(id, refusal))?;
        self.notices(station, notices);
        Ok(station.control(self))
    }

    /// Carries out what changes of authority mean.
    pub fn notices(&self, station: &Arc<Station>, notices: Vec<Notice>) {
        for notice in notices {
            let monitor = station.id().to_owned();
            match notice {
                Notice::Asked { holder, by } => {
                    let until_ms = self.clock.now_ms() + 10_000;
                    self.tell(&holder.seat, &Message::Asked { monitor, by, until_ms });
                }
                Notice::Lost { seat, how, by, reason } => {
                    station.let_go(&seat.seat);
                    if how == LossWord::Expired {
                        lock(&self.seats)
                            .retain(|name, live| *name != seat.seat || !live.events.is_closed());
                        self.expired(station, &seat);
                    }
                    if how != LossWord::Released {
                        let message = Message::AuthorityLost { monitor, how, by, reason };
                        self.tell(&seat.seat, &message);
                    }
                }
                Notice::Granted(seat) => {
                    self.tell(&seat.seat, &Message::AuthorityGranted { monitor });
                }
                Notice::Denied(seat) => {
                    self.tell(&seat.seat, &Message::AuthorityDenied { monitor });
                }
            }
        }
        station.publish_authority(self);
    }

    /// The holder is lost for good: drives that were set in motion by hand are stopped. What the
    /// monitor does by itself (programs, search, deployment) refuses that Stop and goes on (§3.2).
    fn expired(&self, station: &Arc<Station>, seat: &Seat) {
        let text = both(
            format!("{}: control of {} is lost, drives are stopped.", station.id(), seat.user),
            format!("{}: управление {} потеряно, приводы остановлены.", station.id(), seat.user),
        );
        self.event(Some(station.id()), &text);
        let hub = Hub(self.0.clone());
        let (station, caller) = (station.clone(), Caller::hub());
        tokio::spawn(async move {
            for drive in [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL, SubsystemId::NOZZLE] {
                if let Ok(request) = MonitorRequest::stop(drive) {
                    _ = hub.urgent(&caller, &station, &request).result().await;
                }
            }
        });
    }

    /// Releases what nobody holds any more, hands over what was asked for.
    pub fn handle_timeouts(&self) {
        let now = self.now();
        for station in self.stations() {
            let notices = lock(&station.authority).handle_timeout(now);
            if !notices.is_empty() {
                self.notices(&station, notices);
            }
        }
    }
}

/// Details of the entry of a change of authority.
#[derive(Debug, Serialize)]
struct Forced<'a> {
    reason: &'a str,
}

/// What the hub is.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct About {
    /// Always `lafet`.
    pub name: &'static str,
    /// Its version.
    pub version: &'static str,
    /// Version of the API.
    pub api: u32,
    /// It was started by `lafet demo`.
    pub demo: bool,
    /// Its monitors are simulated.
    pub simulation: bool,
    /// Users log in.
    pub login: bool,
    /// Since when it runs.
    pub started_ms: u64,
    /// Where things are, if it is known.
    #[schema(required)]
    pub site: Option<Site>,
}

fn stations_of(config: &Config, monitors: &[MonitorConfig]) -> BTreeMap<String, Arc<Station>> {
    let lost = Duration::from_millis(config.lost_ms);
    let one = |it: &MonitorConfig| (it.id.clone(), Arc::new(Station::new(it.clone(), lost)));
    monitors.iter().map(one).collect()
}

impl Caller {
    /// The hub by itself.
    pub fn hub() -> Self {
        use crate::access::{Kind, Role, Standing};
        let seat = Seat {
            user: "hub".into(),
            role: Role::Administrator,
            seat: "hub".into(),
            from: String::new(),
            live: true,
        };
        let principal = Principal {
            user: "hub".into(),
            role: Role::Administrator,
            kind: Kind::Demo,
            key: "hub".into(),
            csrf: String::new(),
            expires_ms: 0,
            standing: Standing::Good,
        };
        Self { principal, seat, via: "hub" }
    }

    /// Somebody over HTTP: the session or token is the seat.
    pub fn http(principal: Principal, from: IpAddr) -> Self {
        let seat = Seat {
            user: principal.user.clone(),
            role: principal.role,
            seat: principal.key.clone(),
            from: from.to_string(),
            live: false,
        };
        Self { principal, seat, via: "http" }
    }

    /// Somebody on a WebSocket.
    pub fn socket(principal: Principal, from: IpAddr, seat: String) -> Self {
        let (user, role, from) = (principal.user.clone(), principal.role, from.to_string());
        let seat = Seat { user, role, seat, from, live: true };
        Self { principal, seat, via: "ws" }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn without_random_numbers_a_connection_is_closed_like_any_other() {
        let hub = Hub::new(Config::default(), Clock::System, Value::Null).unwrap();
        let principal = Caller::hub().principal;
        let first = hub.sit_down_with(&principal, "", None, None);
        let second = hub.sit_down_with(&principal, "", Some(""), None);
        assert_ne!(first.seat, second.seat, "nothing brings a connection back without a secret");
        assert_eq!((first.resume.clone(), hub.seated().len()), (None, 2));
        hub.stand_up(&first);
        hub.stand_up(&second);
        assert!(hub.seated().is_empty());
    }
}
