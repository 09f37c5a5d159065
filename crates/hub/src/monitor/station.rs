//! A monitor as the hub has it: its client, its state, its authority, and what is published of them.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_client::{Client, Endpoint};
use lafet_proto::param::Param;
use serde::Serialize;
use tokio::sync::{Notify, watch};
use tokio::time::timeout;
use utoipa::ToSchema;

use crate::command::keep_out::Barrel;
use crate::command::urgent::Lane;
use crate::command::withdrawn::Withdrawn;
use crate::config::MonitorConfig;
use crate::control::authority::Authority;
use crate::control::jogs::Jogs;
use crate::control::tuning::{Begun, Running, TuneView};
use crate::error::ApiError;
use crate::hub::Hub;
use crate::monitor::link_series;
use crate::monitor::program::Programs;
use crate::monitor::status::{self, Exchanged, Status};
use crate::monitor::stored::Stored;
use crate::monitor::summary::{self, Summary};
use crate::monitor::view::{
    Asking, Bounds, Control, Holder, Hotbeds, Info, Link, LinkState, MonitorView,
};
use crate::plugs::closing::Closing;
use crate::sync::lock;
use crate::text::Both;

/// How long what is urgent waits for the first connection: as long as for any other (its tries).
const FIRST_LINK: Duration = Duration::from_secs(3);

/// What is published of a monitor.
pub const PARTS: [&str; 13] = [
    "info",
    "status",
    "summary",
    "link",
    "authority",
    "readiness",
    "limits",
    "hotbeds",
    "params",
    "params_progress",
    "program",
    "tune",
    "urgent",
];

/// A monitor: its client, state and authority.
#[derive(Debug)]
pub struct Station {
    /// What the configuration says of it.
    pub config: MonitorConfig,
    /// Its client, as soon as there was a connection.
    pub client: watch::Sender<Option<Client>>,
    /// The authority over it.
    pub authority: Mutex<Authority>,
    /// What is slow is to be read again.
    pub reread: Notify,
    /// Parameters as last read.
    pub params: Mutex<Params>,
    /// The stored programs, for what they sweep.
    pub stored: Mutex<Stored>,
    /// Held while they are being read.
    pub reading: tokio::sync::Mutex<()>,
    /// What it does by itself.
    pub programs: Mutex<Programs>,
    /// Stop, Close and Lockout on that are under way.
    pub urgent: Lane,
    /// What these undo that is not sent yet.
    pub withdrawn: Withdrawn,
    /// Valves that close because their client was lost.
    pub closing: Closing,
    state: Mutex<State>,
    /// Where its barrel was sent.
    pub barrel: Mutex<Barrel>,
    /// Held from when a request is let pass until the client has it. A motion by hand is handed over later, and
    /// counts in the keep-outs from the pass.
    pub sending: Mutex<()>,
    /// Its motions by hand.
    pub jogs: Mutex<Jogs>,
    /// The tuning that runs.
    pub tuning: Mutex<Option<Running>>,
    /// Commands and motions so far that end a tuning.
    pub interrupted: AtomicU64,
    /// Motions of its drives so far that others than a tuning have started.
    pub begun: Begun,
    /// Its software is being updated.
    pub updated: AtomicBool,
    /// How much of what is urgent waits for the first connection.
    asking: watch::Sender<usize>,
}

#[derive(Debug, Default)]
struct State {
    status: Arc<Status>,
    link_up: bool,
    link_since_ms: u64,
    link_error: Option<Both>,
    /// When the state was true, by the hub's own time.
    heard: Option<Duration>,
    /// The figures at the last second, and what had come in that.
    exchanged: (Exchanged, Exchanged),
    limits: Option<BTreeMap<String, Bounds>>,
    hotbeds: Option<Hotbeds>,
}

/// Parameters as last read.
#[derive(Clone, Debug, Default, Serialize, ToSchema)]
pub struct Params {
    /// When they were read, ms since 1970.
    #[schema(required)]
    pub at_ms: Option<u64>,
    /// Whether they are being read.
    pub reading: bool,
    /// Progress of the reading.
    #[schema(required)]
    pub progress: Option<Progress>,
    /// The monitor refuses MoveHold: it does not have it.
    #[serde(skip)]
    pub unheld: bool,
    /// Values by subsystem and name.
    pub values: BTreeMap<String, BTreeMap<String, ParamValue>>,
}

/// How far reading is.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
#[schema(as = ReadingProgress)]
pub struct Progress {
    /// Number of parameters read.
    pub done: usize,
    /// Number of parameters to read.
    pub total: usize,
}

/// Values of a parameter, or why they are not known.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ParamValue {
    /// The values.
    Values(Vec<i32>),
    /// Why the values are unknown.
    Error(Both),
}

impl Params {
    /// The values of a parameter, if they were read.
    pub fn of(&self, param: Param) -> Option<&[i32]> {
        let spec = param.spec();
        match self.values.get(spec.subsystem.name()?)?.get(param.name())? {
            ParamValue::Values(values) => Some(values),
            ParamValue::Error(_) => None,
        }
    }
}

impl Station {
    /// A monitor without connection.
    pub fn new(config: MonitorConfig, lost: Duration) -> Self {
        Self {
            config,
            client: watch::Sender::new(None),
            authority: Mutex::new(Authority::new(lost)),
            reread: Notify::new(),
            params: Mutex::default(),
            stored: Mutex::default(),
            reading: tokio::sync::Mutex::default(),
            programs: Mutex::default(),
            urgent: Lane::default(),
            withdrawn: Withdrawn::default(),
            closing: Closing::default(),
            state: Mutex::default(),
            barrel: Mutex::default(),
            sending: Mutex::default(),
            jogs: Mutex::default(),
            tuning: Mutex::default(),
            interrupted: AtomicU64::new(0),
            begun: Begun::default(),
            updated: AtomicBool::new(false),
            asking: watch::Sender::new(0),
        }
    }

    /// Id from the configuration.
    pub fn id(&self) -> &str {
        &self.config.id
    }

    /// Waits for the first connection, for what is urgent, if it is over a serial port: who only listens there
    /// is asked to give way.
    pub async fn ask_for_link(&self) {
        let mut client = self.client.subscribe();
        let serial = matches!(self.config.endpoint, Endpoint::Serial { .. });
        if !serial || client.borrow_and_update().is_some() {
            return;
        }
        self.asking.send_modify(|asking| *asking += 1);
        // Without a connection the request fails as such.
        _ = timeout(FIRST_LINK, client.wait_for(Option::is_some)).await;
        self.asking.send_modify(|asking| *asking -= 1);
    }

    /// Waits until something urgent waits for the first connection.
    pub async fn link_is_asked_for(&self) {
        // The sender is the station's own.
        _ = self.asking.subscribe().wait_for(|asking| *asking > 0).await;
    }

    /// Its client, if there was a connection.
    pub fn client(&self) -> Result<Client, ApiError> {
        self.client.borrow().clone().ok_or_else(|| ApiError::not_connected(self.id()))
    }

    /// Its state as last heard.
    pub fn status(&self) -> Arc<Status> {
        lock(&self.state).status.clone()
    }

    /// The age of its state, by a clock that does not jump; `None` before the first answer.
    pub fn age(&self, hub: &Hub) -> Option<Duration> {
        lock(&self.state).heard.map(|heard| hub.now().saturating_sub(heard))
    }

    /// Notes when its state was true.
    pub fn heard(&self, hub: &Hub, age: Duration) {
        lock(&self.state).heard = Some(hub.now().saturating_sub(age));
    }

    /// Whether there is a connection.
    pub fn is_up(&self) -> bool {
        lock(&self.state).link_up
    }

    /// `up`, `stale` or `down`.
    pub fn health(&self) -> &'static str {
        let state = lock(&self.state);
        match (state.link_up, state.status.stale || state.status.at_ms.is_none()) {
            (false, _) => "down",
            (true, true) => "stale",
            (true, false) => "up",
        }
    }

    fn topic(&self, part: &str) -> String {
        format!("monitors/{}/{part}", self.id())
    }

    /// Publishes everything, so that no topic is missing.
    pub fn publish_all(&self, hub: &Hub) {
        hub.topics().set(&self.topic("info"), &self.info());
        let state = lock(&self.state);
        hub.topics().set(&self.topic("limits"), &state.limits);
        hub.topics().set(&self.topic("hotbeds"), &state.hotbeds);
        let status = state.status.clone();
        hub.topics().set_live(&self.topic("summary"), Summary(status.clone()), true);
        hub.topics().set_live(&self.topic("status"), status, false);
        drop(state);
        self.publish_link(hub, true);
        self.publish_readiness(hub);
        self.publish_authority(hub);
        self.publish_params(hub);
        self.publish_progress(hub, None);
        self.publish_program(hub);
        self.publish_urgent(hub);
    }

    /// Publishes how many urgent requests there were.
    pub fn publish_urgent(&self, hub: &Hub) {
        hub.topics().set(&self.topic("urgent"), &self.urgent_counts());
    }

    /// Takes everything back that was published.
    pub fn unpublish(&self, hub: &Hub) {
        for part in PARTS {
            hub.topics().remove(&self.topic(part));
        }
    }

    fn info(&self) -> Info {
        let address = Some(self.config.endpoint.addresses().monitor);
        Info { id: self.id().to_owned(), name: self.config.name.clone(), address }
    }

    /// The monitor as the API returns it.
    pub fn view(&self, hub: &Hub) -> MonitorView {
        let part = |name| hub.topics().get(&self.topic(name));
        MonitorView {
            info: self.info(),
            status: part("status"),
            link: part("link"),
            authority: part("authority"),
            readiness: part("readiness"),
            limits: part("limits"),
            hotbeds: part("hotbeds"),
            program: part("program"),
            tune: part("tune"),
            urgent: part("urgent"),
            params_at_ms: lock(&self.params).at_ms,
        }
    }

    /// A new state, or that the old one has become stale.
    pub fn set_status(&self, hub: &Hub, mut status: Status) {
        let old = self.status();
        let same_flags = status.has_flags_of(&old);
        status.resumes_ms = None;
        if !status.stale {
            let mut programs = lock(&self.programs);
            if !(same_flags && programs.are_idle()) {
                let before = programs.current().cloned();
                status.resumes_ms = programs.observe(hub.clock().now_ms(), &status);
                let news = programs.current() != before.as_ref();
                drop(programs);
                if news {
                    self.publish_program(hub);
                }
            }
        }
        if status == *old {
            return;
        }
        let status = Arc::new(status);
        lock(&self.state).status = status.clone();
        if !summary::is_same(&status, &old) {
            hub.topics().set_live(&self.topic("summary"), Summary(status.clone()), true);
        }
        hub.topics().set_live(&self.topic("status"), status, false);
        if !same_flags {
            self.publish_readiness(hub);
        }
    }

    /// The connection came or went.
    pub fn set_link(&self, hub: &Hub, up: bool, error: Option<Both>) {
        {
            let mut state = lock(&self.state);
            if state.link_up != up || state.link_since_ms == 0 {
                state.link_since_ms = hub.clock().now_ms();
            }
            (state.link_up, state.link_error) = (up, error);
        }
        self.publish_link(hub, true);
        self.publish_readiness(hub);
    }

    /// The figures of the last second.
    pub fn set_figures(&self, hub: &Hub) {
        let now = self.exchanged();
        let last = {
            let mut state = lock(&self.state);
            let last = now.since(&state.exchanged.0);
            state.exchanged = (now, last);
            last
        };
        self.publish_link(hub, false);
        let round_trip = now.own.rtt_average;
        let news = round_trip.is_some_and(|it| hub.alarms().holding(self.id()).set_round_trip(it));
        if news {
            hub.observe(self);
        }
        let up = self.is_up();
        link_series::note(hub, self.id(), &last.own, up);
    }

    /// What was exchanged with it so far, and on its line.
    pub fn exchanged(&self) -> Exchanged {
        let of = |client: &Client| Exchanged { own: client.stats(), line: client.link_stats() };
        self.client.borrow().as_ref().map(of).unwrap_or_default()
    }

    /// Sets and publishes the limits.
    pub fn set_limits(&self, hub: &Hub, limits: BTreeMap<String, Bounds>) {
        hub.topics().set(&self.topic("limits"), &limits);
        lock(&self.state).limits = Some(limits);
    }

    /// What its detector has found.
    pub fn set_hotbeds(&self, hub: &Hub, hotbeds: Hotbeds) {
        hub.topics().set(&self.topic("hotbeds"), &hotbeds);
        lock(&self.state).hotbeds = Some(hotbeds);
    }

    fn publish_link(&self, hub: &Hub, news: bool) {
        let state = lock(&self.state);
        let last = state.exchanged.1;
        let link = LinkState {
            up: state.link_up,
            since_ms: state.link_since_ms,
            error: state.link_error.clone(),
            endpoint: self.config.endpoint.to_string(),
            poll_ms: self.config.poll_ms,
        };
        drop(state);
        let link = Link::new(link, &self.exchanged(), &last);
        hub.topics().set_live(&self.topic("link"), link, news);
    }

    /// Publishes whether it is ready.
    pub fn publish_readiness(&self, hub: &Hub) {
        let unheld = lock(&self.params).unheld;
        let state = lock(&self.state);
        let readiness = status::readiness(&state.status, state.link_up, unheld);
        hub.topics().set(&self.topic("readiness"), &readiness);
    }

    /// Another monitor may have its address now: what is read seldom is read again.
    pub fn read_again(&self) {
        lock(&self.stored).doubt();
        self.reread.notify_one();
    }

    /// Publishes the parameters.
    pub fn publish_params(&self, hub: &Hub) {
        hub.topics().set(&self.topic("params"), &*lock(&self.params));
    }

    /// Publishes how far reading them is.
    pub fn publish_progress(&self, hub: &Hub, progress: Option<Progress>) {
        hub.topics().set(&self.topic("params_progress"), &progress);
    }

    /// Publishes what it does by itself.
    pub fn publish_program(&self, hub: &Hub) {
        hub.topics().set(&self.topic("program"), &lock(&self.programs).current());
    }

    /// Publishes a tuning.
    pub fn publish_tune(&self, hub: &Hub, tune: &TuneView) {
        hub.topics().set(&self.topic("tune"), tune);
    }

    /// Publishes the authority.
    pub fn publish_authority(&self, hub: &Hub) {
        let mut control = self.control(hub);
        loop {
            hub.topics().set(&self.topic("authority"), &control);
            // Of two changes at once the later one is published last.
            let now = self.control(hub);
            if now == control {
                return;
            }
            control = now;
        }
    }

    /// The authority as clients see it.
    pub fn control(&self, hub: &Hub) -> Control {
        let authority = lock(&self.authority);
        // Moments are kept without a date; the hub's start is the bridge.
        let date = |at: Duration| hub.started_ms() + u64::try_from(at.as_millis()).unwrap_or(0);
        let holder = authority.holder();
        let request = authority.request();
        Control {
            state: authority.state(),
            holder: holder.map(|(seat, at)| Holder { seat: seat.clone(), since_ms: date(at) }),
            request: request.map(|(seat, at)| Asking { seat: seat.clone(), until_ms: date(at) }),
        }
    }
}
