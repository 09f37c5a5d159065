//! The hub: the parts that everything else uses.

mod accounting;
mod caller;
mod counts;
mod handover;
mod quotas;
mod rates;
mod seats;
mod shutdown;
mod tasks;
mod upkeep;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock};
use std::time::Duration;

use serde::Serialize;
use serde_json::Value;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::Instant;
use utoipa::ToSchema;

use crate::access::{Access, Kind, Logins, Principal, Turns};
use crate::alarms::Alarms;
use crate::api::{Answering, Lasting, Packing, Places};
use crate::clock::{Clock, Sleep, Sleeps};
use crate::command::series::Series;
use crate::config::{Config, MonitorConfig};
use crate::control::authority::Now;
use crate::error::ApiError;
use crate::field::Field;
use crate::monitor::owner;
use crate::monitor::station::Station;
use crate::plugs::modbus::Servers;
use crate::plugs::mqtt::Brokers;
use crate::plugs::opcua;
use crate::publish::broadcast::Audiences;
use crate::publish::topics::Topics;
use crate::recording::Recordings;
use crate::simulation::{Scene, Simulation};
use crate::site::keep_out::KeepOut;
use crate::site::{Place, Site};
use crate::store::integrity::Integrity;
use crate::store::reserve::Room;
use crate::store::{self, Audit, Events, History, StateFile, StoreError};
use crate::sync::lock;
use crate::updates::Updating;
use crate::zones::Zones;

pub use caller::Caller;
pub use counts::Counts;
use quotas::{Delays, Quotas};
pub use rates::{PerSecond, Rates};
use seats::Seats;
pub use seats::{Has, SeatKey, Seated};
pub use shutdown::Shutdown;
pub(crate) use tasks::all_end;
use upkeep::Upkeep;
pub use upkeep::room;

/// Passwords hashed at once: one hash takes tens of MiB, and the other processor is for commands.
const HASHING_MAX: usize = 1;

/// The hub. A clone is a handle to the same hub.
#[derive(Clone, Debug)]
pub struct Hub(Arc<Parts>);

/// The parts of the hub, each with its own lock.
#[derive(Debug)]
struct Parts {
    /// Keeps a second hub out of the state folder.
    #[expect(dead_code, reason = "held until the hub ends")]
    lock_file: Option<std::fs::File>,
    config: Config,
    clock: Clock,
    sleeps: Sleeps,
    start: Instant,
    started_ms: u64,

    audit: Audit,
    events: Events,
    history: Mutex<History>,
    integrity: Integrity,
    recordings: Recordings,

    access: Access,
    logins: Mutex<Logins>,
    hashing: Turns,
    quotas: Quotas,
    delays: Delays,
    seats: Seats,
    /// Incremented when users, sessions or tokens change.
    access_revision: watch::Sender<u64>,

    topics: Topics,
    audiences: Audiences,
    alarms: Mutex<Alarms>,
    counts: Counts,
    rates: Rates,

    series: Series,
    places: Mutex<Places>,
    answering: Answering,
    packing: Packing,
    dictionary: Lasting,

    stations: Mutex<Arc<BTreeMap<String, Arc<Station>>>>,
    site: Mutex<Option<Arc<Site>>>,
    zones: Option<Zones>,
    updating: Updating,
    field: Field,
    modbus_servers: Servers,
    mqtt_brokers: Brokers,
    opcua_servers: opcua::Servers,
    simulation: OnceLock<Box<dyn Simulation>>,
    /// The tasks of each link; dropped, they end.
    owners: Mutex<Option<JoinSet<()>>>,
    shutdown: watch::Sender<bool>,
    /// A part that always runs has ended: the hub is to end as well.
    failed: watch::Sender<bool>,
    /// Rounds of what the hub does from time to time.
    ticks: AtomicU64,
    upkeep: Upkeep,
}

/// The hub and its site, as the API returns them.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct About {
    /// Always `lafet`.
    pub name: &'static str,
    /// Version of the program.
    pub version: &'static str,
    /// Version of the API.
    pub api: u32,
    /// Started by `lafet demo`.
    pub demo: bool,
    /// The monitors are simulated.
    pub simulation: bool,
    /// Users log in.
    pub login: bool,
    /// When the hub started, ms since 1970.
    pub started_ms: u64,
    /// Where things are; null if it is not configured.
    #[schema(required)]
    pub site: Option<Site>,
}

/// The files of the state that the hub goes on without when the disk fails.
struct Stores {
    audit: Audit,
    events: Events,
    /// The alarms that were not normal, as JSON.
    alarms: Vec<String>,
    history: History,
}

impl Stores {
    fn open(config: &Config, integrity: &Integrity) -> Result<Self, StoreError> {
        let folder = config.data.as_deref();
        let unread = || Ok((Events::unread(), Vec::new(), None));
        let open = || Events::open_with_alarms(folder);
        let (events, alarms, loss) = integrity.opened(StateFile::Events, open, unread)?;
        loss.into_iter().for_each(|loss| integrity.lost(loss));
        let unread = || integrity.audit_unread();
        let audit = integrity.opened(StateFile::Audit, || Audit::open(folder), unread)?;
        let history = match config.postgres.clone() {
            Some(address) => History::open_postgres(address)?,
            None => {
                let open = || History::open(folder);
                integrity.opened(StateFile::History, open, || Ok(History::unread()))?
            }
        };
        Ok(Self { audit, events, alarms, history })
    }
}

impl Hub {
    /// Opens the storage and builds the hub; no task runs yet.
    pub fn new(config: Config, clock: Clock, dictionary: Value) -> Result<Self, StoreError> {
        let folder = config.data.clone();
        let folder = folder.as_deref();
        folder.map(store::refuse_newer).transpose()?;
        let lock_file = folder.map(store::occupy).transpose()?;
        let room = folder.map_or(Room::Enough, store::reserve::take);
        let integrity = Integrity::examine(&config, room)?;
        for warning in &config.warnings {
            tracing::warn!("{warning}");
        }
        let stations = stations_of(&config, &config.monitors);
        let Stores { audit, events, alarms, history } = Stores::open(&config, &integrity)?;
        let known = stations.keys().cloned().collect();
        let alarms = Alarms::restored(clock.now_ms(), &alarms, &known);
        let hub = Self(Arc::new(Parts {
            audit,
            events,
            access: Access::open(folder, clock.steady_ms())?,
            history: Mutex::new(history),
            recordings: Recordings::open(&config.recording)?,
            logins: Mutex::default(),
            hashing: Turns::new(HASHING_MAX),
            quotas: Quotas::default(),
            delays: Delays::default(),
            seats: Seats::default(),
            access_revision: watch::Sender::new(0),
            topics: Topics::default(),
            audiences: Audiences::default(),
            alarms: Mutex::new(alarms),
            counts: Counts::default(),
            rates: Rates::default(),
            series: Series::default(),
            places: Mutex::default(),
            answering: Answering::default(),
            packing: Packing::default(),
            dictionary: Lasting::new(dictionary.to_string()),
            stations: Mutex::new(Arc::new(stations)),
            site: Mutex::new(config.site.clone().map(Arc::new)),
            zones: Zones::open(&config)?,
            updating: Updating::open(folder),
            field: Field::new(&config.modbus),
            modbus_servers: Servers::new(&config.modbus_servers),
            mqtt_brokers: Brokers::new(&config.mqtt),
            opcua_servers: opcua::Servers::new(&config.opcua),
            simulation: OnceLock::new(),
            owners: Mutex::default(),
            shutdown: watch::Sender::new(false),
            failed: watch::Sender::new(false),
            ticks: AtomicU64::new(0),
            upkeep: Upkeep::default(),
            sleeps: Sleeps::from_now(&clock),
            start: Instant::now(),
            started_ms: clock.now_ms(),
            integrity,
            lock_file,
            config,
            clock,
        }));
        hub.0.integrity.mark()?;
        hub.report_losses();
        hub.topics().set("hub", &hub.about());
        for alarm in hub.alarms().list() {
            hub.topics().set(&format!("alarms/{}", alarm.id), alarm);
        }
        hub.topics().set("fire", &hub.alarms().fire());
        hub.publish_updates();
        for station in hub.stations() {
            station.publish_all(&hub);
        }
        Ok(hub)
    }

    /// The hub and its site, as the API returns them.
    pub fn about(&self) -> About {
        About {
            name: "lafet",
            version: env!("CARGO_PKG_VERSION"),
            api: 1,
            demo: self.config().demo,
            simulation: self.config().simulation,
            login: self.config().login,
            started_ms: self.started_ms(),
            site: self.map().as_deref().cloned(),
        }
    }

    /// The monitor with this id.
    pub fn station(&self, id: &str) -> Result<Arc<Station>, ApiError> {
        lock(&self.0.stations).get(id).cloned().ok_or_else(|| ApiError::no_monitor(id))
    }

    /// The monitors by id, as they are now.
    pub fn all_stations(&self) -> Arc<BTreeMap<String, Arc<Station>>> {
        lock(&self.0.stations).clone()
    }

    /// All monitors, by id.
    pub fn stations(&self) -> Vec<Arc<Station>> {
        lock(&self.0.stations).values().cloned().collect()
    }

    /// Where a monitor is, if the configuration has it.
    pub fn place_of(&self, id: &str) -> Option<Place> {
        lock(&self.0.site).as_ref()?.monitors.get(id).copied()
    }

    /// The map of the site, if the configuration has one.
    pub fn map(&self) -> Option<Arc<Site>> {
        lock(&self.0.site).clone()
    }

    /// The keep-outs that concern a monitor, if it has a place.
    pub fn keep_outs(&self, id: &str) -> Option<(Place, Vec<KeepOut>)> {
        let site = self.map()?;
        let place = *site.monitors.get(id)?;
        let of: Vec<KeepOut> = site.keep_outs.iter().filter(|it| it.is_of(id)).cloned().collect();
        (!of.is_empty()).then_some((place, of))
    }

    /// Height of a monitor's nozzle above the ground, cm, if the configuration has it.
    pub fn height_cm(&self, id: &str) -> Option<i32> {
        Some((self.place_of(id)?.height * 100.0).round() as i32)
    }

    /// Connects to the monitors and keeps the links.
    pub fn own(&self) {
        *lock(&self.0.owners) = Some(owner::own(self));
    }

    /// Replaces the monitors when a simulation loads another site. The new ones are free, and the
    /// alarms of the old ones are removed.
    pub fn replace_monitors(&self, monitors: &[MonitorConfig], site: Option<Site>) {
        let owned = lock(&self.0.owners).take().is_some();
        let new = Arc::new(stations_of(self.config(), monitors));
        let old = std::mem::replace(&mut *lock(&self.0.stations), new.clone());
        *lock(&self.0.site) = site.map(Arc::new);
        self.recordings().forget();
        for station in old.values() {
            let changes = self.alarms().forget(station.id());
            self.publish_alarms(changes);
            let (now_ms, mut history) = (self.clock().now_ms(), self.history());
            history.lost(now_ms, station.id());
            history.lost_link(now_ms, station.id());
            drop(history);
            if !new.contains_key(station.id()) {
                station.unpublish(self);
            }
        }
        new.values().for_each(|station| station.publish_all(self));
        self.topics().set("hub", &self.about());
        if owned {
            self.own();
        }
    }

    /// Publishes what only a simulation knows.
    pub fn publish_scene(&self, scene: &Scene) {
        self.recordings().scene(self.clock().now_ms(), scene);
        self.topics().set("scene", scene);
    }
}

/// The parts. A guard is held for a few lines at most, and never over an `await`.
impl Hub {
    /// The configuration.
    pub fn config(&self) -> &Config {
        &self.0.config
    }

    /// Dates and steady times.
    pub fn clock(&self) -> &Clock {
        &self.0.clock
    }

    /// Time since the start.
    pub fn now(&self) -> Now {
        self.0.start.elapsed()
    }

    /// The same, ms.
    pub fn up_ms(&self) -> u64 {
        u64::try_from(self.now().as_millis()).unwrap_or(u64::MAX)
    }

    /// The last sleep of the machine, as far as it was noticed.
    pub(crate) fn last_sleep(&self) -> Sleep {
        self.0.sleeps.look(self.now(), self.clock())
    }

    /// Whether a client still has the rights with which it was identified.
    pub fn is_still_good(&self, principal: &Principal) -> bool {
        principal.is_good() && self.access().is_valid(self.now_for(principal), principal)
    }

    /// Now, by the clock by which a client's rights end: those of a certificate at a date, whatever the date is set to
    /// while a connection lasts; all others after a time that no setting changes.
    pub fn now_for(&self, principal: &Principal) -> u64 {
        match principal.kind {
            Kind::Certificate => self.clock().now_ms(),
            _ => self.clock().steady_ms(),
        }
    }

    /// The moment of the start.
    pub fn start(&self) -> Instant {
        self.0.start
    }

    /// The moment of the start, ms since 1970.
    pub fn started_ms(&self) -> u64 {
        self.0.started_ms
    }

    /// The audit log.
    pub fn audit(&self) -> &Audit {
        &self.0.audit
    }

    /// The event log.
    pub fn events(&self) -> &Events {
        &self.0.events
    }

    /// The history of values.
    pub fn history(&self) -> MutexGuard<'_, History> {
        lock(&self.0.history)
    }

    /// Whether the state files are as the hub has written them.
    pub fn integrity(&self) -> &Integrity {
        &self.0.integrity
    }

    /// The recordings.
    pub fn recordings(&self) -> &Recordings {
        &self.0.recordings
    }

    /// Users, sessions and tokens.
    pub fn access(&self) -> &Access {
        &self.0.access
    }

    /// Urgent requests to every monitor that are repeated.
    pub fn urgent_series(&self) -> &Series {
        &self.0.series
    }

    /// Failed logins.
    pub fn logins(&self) -> MutexGuard<'_, Logins> {
        lock(&self.0.logins)
    }

    /// Turns to hash a password.
    pub fn hashing(&self) -> &Turns {
        &self.0.hashing
    }

    /// Users, sessions or tokens have changed: open WebSockets check theirs.
    pub fn access_changed(&self) {
        self.0.access_revision.send_modify(|revision| *revision += 1);
    }

    /// Receives changes of users, sessions and tokens.
    pub fn access_changes(&self) -> watch::Receiver<u64> {
        self.0.access_revision.subscribe()
    }

    /// The published values.
    pub fn topics(&self) -> &Topics {
        &self.0.topics
    }

    /// The latest changes, written once for all clients that look at the same.
    pub fn audiences(&self) -> &Audiences {
        &self.0.audiences
    }

    /// The alarms.
    pub fn alarms(&self) -> MutexGuard<'_, Alarms> {
        lock(&self.0.alarms)
    }

    /// Totals for the metrics.
    pub fn counts(&self) -> &Counts {
        &self.0.counts
    }

    /// The same per second.
    pub fn rates(&self) -> &Rates {
        &self.0.rates
    }

    /// The open connections.
    pub fn places(&self) -> MutexGuard<'_, Places> {
        lock(&self.0.places)
    }

    /// Turns to send a large answer.
    pub fn answering(&self) -> &Answering {
        &self.0.answering
    }

    /// Turns to compress an answer.
    pub fn packing(&self) -> &Packing {
        &self.0.packing
    }

    /// The dictionary of the protocol, as JSON.
    pub fn dictionary(&self) -> &Lasting {
        &self.0.dictionary
    }

    /// The buses of detectors.
    pub(crate) fn field(&self) -> &Field {
        &self.0.field
    }

    /// The Modbus servers.
    pub(crate) fn modbus_servers(&self) -> &Servers {
        &self.0.modbus_servers
    }

    /// The OPC UA servers.
    pub(crate) fn opcua_servers(&self) -> &opcua::Servers {
        &self.0.opcua_servers
    }

    /// The MQTT brokers.
    pub(crate) fn mqtt_brokers(&self) -> &Brokers {
        &self.0.mqtt_brokers
    }

    /// The zones, if there are any.
    pub(crate) fn zones(&self) -> Option<&Zones> {
        self.0.zones.as_ref()
    }

    /// Images, and runs that update the software of monitors.
    pub(crate) fn updating(&self) -> &Updating {
        &self.0.updating
    }

    /// The simulation behind the monitors, if there is one.
    pub fn simulated(&self) -> Option<&dyn Simulation> {
        self.0.simulation.get().map(|it| &**it)
    }

    /// Connects a simulation to the hub. The first one stays.
    pub fn simulate(&self, simulation: Box<dyn Simulation>) {
        _ = self.0.simulation.set(simulation);
        self.publish_simulation();
    }

    /// Ends every task of the hub.
    pub fn begin_shutdown(&self) {
        self.0.shutdown.send_replace(true);
    }

    /// Rounds of the hub's clock, ten a second.
    pub fn ticks(&self) -> u64 {
        self.0.ticks.load(Ordering::Relaxed)
    }

    /// Another round.
    pub(crate) fn tick(&self) {
        self.last_sleep();
        self.0.ticks.fetch_add(1, Ordering::Relaxed);
    }

    /// Whether the hub ends.
    pub fn ends(&self) -> bool {
        *self.0.shutdown.borrow()
    }

    /// Waits for the end of the hub.
    pub fn shutdown(&self) -> Shutdown {
        Shutdown::new(self.0.shutdown.subscribe())
    }
}

fn stations_of(config: &Config, monitors: &[MonitorConfig]) -> BTreeMap<String, Arc<Station>> {
    let lost = Duration::from_millis(config.lost_ms);
    let one = |it: &MonitorConfig| (it.id.clone(), Arc::new(Station::new(it.clone(), lost)));
    monitors.iter().map(one).collect()
}

#[cfg(test)]
impl Hub {
    /// A hub with one monitor, M1, that no connection reaches.
    pub fn of_one(site: Option<Site>) -> (Self, Arc<Station>) {
        Self::of_one_at(site, Clock::System)
    }

    /// The same with a clock.
    pub fn of_one_at(site: Option<Site>, clock: Clock) -> (Self, Arc<Station>) {
        let monitor = MonitorConfig {
            id: "M1".into(),
            name: crate::text::both("M1", "M1"),
            endpoint: "tcp://127.0.0.1:1?addr=1".parse().unwrap(),
            poll_ms: 200,
        };
        let config = Config { monitors: vec![monitor], site, ..Config::default() };
        let hub = Self::new(config, clock, Value::Null).unwrap();
        let station = hub.station("M1").unwrap();
        (hub, station)
    }
}
