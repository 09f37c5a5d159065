//! A monitor as the hub has it: its client, its state, who holds it, what is held in motion.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_client::{Client, Drive, Hold, JogEnd, Monitor, Reason, Toward};
use lafet_proto::SubsystemId;
use lafet_proto::status::DriveStatus;
use serde::Serialize;
use tokio::sync::{Notify, mpsc, watch};
use utoipa::ToSchema;

use crate::authority::Authority;
use crate::command::NUMBERED;
use crate::config::MonitorConfig;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::jogs::{Jogs, Turn};
use crate::link_series;
use crate::messages::Message;
use crate::model::{self, Exchanged, Status};
use crate::program::Programs;
use crate::store::{Act as Noted, JogEnding};
use crate::summary::{self, Summary};
use crate::sync::lock;
use crate::text::{Both, both};
use crate::urgent::Lane;
use crate::view::{Asking, Bounds, Control, Holder, Hotbeds, Info, Link, LinkState, MonitorView};
use crate::words::{MotionEnd, MotionWord};

/// What is published of a monitor.
pub const PARTS: [&str; 11] = [
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
];

/// A monitor.
#[derive(Debug)]
pub struct Station {
    /// What the configuration says of it.
    pub config: MonitorConfig,
    /// Its client, as soon as there was a connection.
    pub client: watch::Sender<Option<Client>>,
    /// Who holds it.
    pub authority: Mutex<Authority>,
    /// What is slow is to be read again.
    pub reread: Notify,
    /// Its parameters.
    pub params: Mutex<Params>,
    /// Held while they are being read.
    pub reading: tokio::sync::Mutex<()>,
    /// What it does by itself.
    pub programs: Mutex<Programs>,
    /// Stop, Close and Lockout on that are under way.
    pub urgent: Lane,
    state: Mutex<State>,
    jogs: Mutex<Jogs>,
}

#[derive(Debug, Default)]
struct State {
    status: Arc<Status>,
    link_up: bool,
    link_since_ms: u64,
    link_error: Option<Both>,
    /// The figures at the last second, and what had come in that.
    exchanged: (Exchanged, Exchanged),
    limits: Option<BTreeMap<String, Bounds>>,
    hotbeds: Option<Hotbeds>,
}

/// Parameters as last read.
#[derive(Clone, Debug, Default, Serialize, ToSchema)]
pub struct Params {
    /// When they were read.
    #[schema(required)]
    pub at_ms: Option<u64>,
    /// They are being read.
    pub reading: bool,
    /// How far.
    #[schema(required)]
    pub progress: Option<Progress>,
    /// The monitor refuses MoveHold: it does not have it.
    #[serde(skip)]
    pub unheld: bool,
    /// By subsystem and name.
    pub values: BTreeMap<String, BTreeMap<String, ParamValue>>,
}

/// How far reading is.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
#[schema(as = ReadingProgress)]
pub struct Progress {
    /// Parameters read.
    pub done: usize,
    /// Parameters in all.
    pub total: usize,
}

/// Values of a parameter, or why they are not known.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ParamValue {
    /// Its values.
    Values(Vec<i32>),
    /// Why not.
    Error(Both),
}

/// A beat.
#[derive(Clone, Copy, Debug)]
pub struct Beat {
    /// Which drive.
    pub drive: SubsystemId,
    /// Which way.
    pub toward: Toward,
    /// The sender's clock, ms.
    pub sent_ms: Option<f64>,
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
            reading: tokio::sync::Mutex::default(),
            programs: Mutex::default(),
            urgent: Lane::default(),
            state: Mutex::default(),
            jogs: Mutex::default(),
        }
    }

    /// Its id.
    pub fn id(&self) -> &str {
        &self.config.id
    }

    /// Its client, if there was a connection.
    pub fn client(&self) -> Result<Client, ApiError> {
        self.client.borrow().clone().ok_or_else(|| ApiError::not_connected(self.id()))
    }

    /// Its state as last heard.
    pub fn status(&self) -> Arc<Status> {
        lock(&self.state).status.clone()
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
        hub.topics.set(&self.topic("info"), &self.info());
        let state = lock(&self.state);
        hub.topics.set(&self.topic("limits"), &state.limits);
        hub.topics.set(&self.topic("hotbeds"), &state.hotbeds);
        let status = state.status.clone();
        hub.topics.set_live(&self.topic("summary"), Summary(status.clone()), true);
        hub.topics.set_live(&self.topic("status"), status, false);
        drop(state);
        self.publish_link(hub, true);
        self.publish_readiness(hub);
        self.publish_authority(hub);
        self.publish_params(hub);
        self.publish_progress(hub, None);
        self.publish_program(hub);
    }

    /// Takes everything back that was published.
    pub fn unpublish(&self, hub: &Hub) {
        for part in PARTS {
            hub.topics.remove(&self.topic(part));
        }
    }

    fn info(&self) -> Info {
        let address = Some(self.config.endpoint.addresses().monitor);
        Info { id: self.id().to_owned(), name: self.config.name.clone(), address }
    }

    /// Everything about it.
    pub fn view(&self, hub: &Hub) -> MonitorView {
        let part = |name| hub.topics.get(&self.topic(name));
        MonitorView {
            info: self.info(),
            status: part("status"),
            link: part("link"),
            authority: part("authority"),
            readiness: part("readiness"),
            limits: part("limits"),
            hotbeds: part("hotbeds"),
            program: part("program"),
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
                status.resumes_ms = programs.observe(hub.clock.now_ms(), &status);
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
            hub.topics.set_live(&self.topic("summary"), Summary(status.clone()), true);
        }
        hub.topics.set_live(&self.topic("status"), status, false);
        if !same_flags {
            self.publish_readiness(hub);
        }
    }

    /// The connection came or went.
    pub fn set_link(&self, hub: &Hub, up: bool, error: Option<Both>) {
        {
            let mut state = lock(&self.state);
            if state.link_up != up || state.link_since_ms == 0 {
                state.link_since_ms = hub.clock.now_ms();
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
        let news =
            round_trip.is_some_and(|it| lock(&hub.alarms).holding(self.id()).set_round_trip(it));
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

    /// Its limits.
    pub fn set_limits(&self, hub: &Hub, limits: BTreeMap<String, Bounds>) {
        hub.topics.set(&self.topic("limits"), &limits);
        lock(&self.state).limits = Some(limits);
    }

    /// What its detector has found.
    pub fn set_hotbeds(&self, hub: &Hub, hotbeds: Hotbeds) {
        hub.topics.set(&self.topic("hotbeds"), &hotbeds);
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
        hub.topics.set_live(&self.topic("link"), link, news);
    }

    /// Publishes whether it is ready.
    pub fn publish_readiness(&self, hub: &Hub) {
        let unheld = lock(&self.params).unheld;
        let state = lock(&self.state);
        let readiness = model::readiness(&state.status, state.link_up, unheld);
        hub.topics.set(&self.topic("readiness"), &readiness);
    }

    /// Publishes the parameters.
    pub fn publish_params(&self, hub: &Hub) {
        hub.topics.set(&self.topic("params"), &*lock(&self.params));
    }

    /// Publishes how far reading them is.
    pub fn publish_progress(&self, hub: &Hub, progress: Option<Progress>) {
        hub.topics.set(&self.topic("params_progress"), &progress);
    }

    /// Publishes what it does by itself.
    pub fn publish_program(&self, hub: &Hub) {
        hub.topics.set(&self.topic("program"), &lock(&self.programs).current());
    }

    /// Publishes who holds it.
    pub fn publish_authority(&self, hub: &Hub) {
        hub.topics.set(&self.topic("authority"), &self.control(hub));
    }

    /// Who holds it.
    pub fn control(&self, hub: &Hub) -> Control {
        let authority = lock(&self.authority);
        // Moments are kept without a date; the hub's start is the bridge.
        let date = |at: Duration| hub.started_ms + u64::try_from(at.as_millis()).unwrap_or(0);
        let holder = authority.holder();
        let request = authority.request();
        Control {
            state: authority.state(),
            holder: holder.map(|(seat, at)| Holder { seat: seat.clone(), since_ms: date(at) }),
            request: request.map(|(seat, at)| Asking { seat: seat.clone(), until_ms: date(at) }),
        }
    }

    /// What a seat holds in motion is let go.
    pub fn let_go(&self, seat: &str) {
        lock(&self.jogs).let_go(seat);
    }

    /// A seat lets go of a drive.
    pub fn end_jog(&self, seat: &str, drive: SubsystemId) {
        lock(&self.jogs).end(&(seat.to_owned(), drive));
    }

    /// A beat of somebody who may command: tells what became of it.
    pub fn beat(
        self: &Arc<Self>,
        hub: &Hub,
        caller: &Caller,
        beat: Beat,
    ) -> Result<MotionWord, ApiError> {
        let monitor = Monitor::new(self.client()?);
        let drive = match beat.drive {
            SubsystemId::VERTICAL => monitor.vertical(),
            SubsystemId::HORIZONTAL => monitor.horizontal(),
            SubsystemId::NOZZLE => monitor.nozzle(),
            _ => {
                return Err(ApiError::bad_request(both(
                    "Only Vertical, Horizontal and Nozzle are moved by hand.",
                    "Вручную ведутся только Vertical, Horizontal и Nozzle.",
                )));
            }
        };
        let key = (caller.seat.seat.clone(), beat.drive);
        let turn = lock(&self.jogs).beat(hub.now(), key, beat.toward, beat.sent_ms);
        match turn {
            Turn::Said(state) => Ok(state),
            Turn::Start(number, beats) => self.start(hub, caller, &drive, beat, (number, beats)),
        }
    }

    fn start(
        self: &Arc<Self>,
        hub: &Hub,
        caller: &Caller,
        drive: &Drive,
        beat: Beat,
        (number, mut beats): (u64, mpsc::Receiver<()>),
    ) -> Result<MotionWord, ApiError> {
        let speed = hub.simulation.get().map_or(1.0, |simulation| simulation.speed());
        let hold = Hold { clock_permille: (speed * 1000.0) as u32, ..Hold::default() };
        let mut jog = drive.jog_with(beat.toward, hold).map_err(|error| ApiError::from(&error))?;
        let way = if beat.toward == Toward::Max { "max" } else { "min" };
        let what = format!("jog {} {way}", beat.drive);
        let drive = beat.drive;
        let act = move |end| Noted::Jog { drive: drive.to_string(), toward: way.into(), end };
        let record = hub.record(caller, self.id(), &what, "asked");
        let asked = hub.audit.note(record.about(&act(None)));
        hub.counts.jogs.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let (hub, caller, station) = (hub.clone(), caller.clone(), self.clone());
        tokio::spawn(async move {
            station.tell_jog(&hub, &caller, beat.drive, MotionWord::Moving, None);
            let end = loop {
                let renewed = tokio::select! {
                    beat = beats.recv() => beat,
                    end = jog.ended() => break end,
                };
                if renewed.is_some() {
                    jog.renew();
                } else {
                    station.tell_jog(&hub, &caller, beat.drive, MotionWord::Stopping, None);
                    break jog.release().await;
                }
            };
            station.jog_ended(&hub, &caller, beat.drive, number, &end);
            let record = hub.record(&caller, station.id(), &what, end_word(&end).name());
            // Long since stored, unless the disk takes nothing: then nobody waits for it.
            let asked = tokio::time::timeout(NUMBERED, asked).await.ok().and_then(Result::ok);
            let record = record.with(&JogDetails { asked });
            drop(hub.audit.note(record.about(&act(Some(ending(&end))))));
        });
        Ok(MotionWord::Moving)
    }

    fn jog_ended(&self, hub: &Hub, caller: &Caller, drive: SubsystemId, number: u64, end: &JogEnd) {
        let key = (caller.seat.seat.clone(), drive);
        lock(&self.jogs).ended(hub.now(), &key, number);
        self.tell_jog(hub, caller, drive, MotionWord::Ended, Some(end));
    }

    fn tell_jog(
        &self,
        hub: &Hub,
        caller: &Caller,
        drive: SubsystemId,
        state: MotionWord,
        end: Option<&JogEnd>,
    ) {
        let message = Message::Jog {
            monitor: self.id().to_owned(),
            drive: drive.to_string(),
            state,
            end: end.map(end_word),
            text: end.and_then(end_text),
        };
        hub.tell(&caller.seat.seat, &message);
    }
}

/// Details of the entry of the end of a motion by hand: the number of that of its beginning.
#[derive(Debug, Serialize)]
struct JogDetails {
    asked: Option<u64>,
}

/// How a motion ended, as the audit log has it.
fn ending(end: &JogEnd) -> JogEnding {
    let at = |status: &DriveStatus| status.position;
    match end {
        JogEnd::Stopped { reason, status } => {
            JogEnding::Stopped { reason: why(reason).into(), position: at(status) }
        }
        JogEnd::Standing(status) => JogEnding::Standing { position: at(status) },
        JogEnd::Refused(error) => JogEnding::Refused { error: error.to_string() },
        JogEnd::Replaced => JogEnding::Replaced,
        JogEnd::TakenOver { by } => JogEnding::TakenOver { by: by.to_string() },
        JogEnd::StillMoving(status) => JogEnding::StillMoving { position: at(status) },
        JogEnd::Unknown(error) => JogEnding::Unknown { error: error.to_string() },
        _ => JogEnding::Unknown { error: String::new() },
    }
}

const fn why(reason: &Reason) -> &'static str {
    match reason {
        Reason::Released => "released",
        Reason::Lapsed => "lapsed",
        Reason::LinkLost => "link_lost",
        Reason::Refused => "refused",
        Reason::StopAsked => "stop_asked",
        _ => "unknown",
    }
}

const fn end_word(end: &JogEnd) -> MotionEnd {
    match end {
        JogEnd::Stopped { .. } => MotionEnd::Stopped,
        JogEnd::Standing(_) => MotionEnd::Standing,
        JogEnd::Refused(_) => MotionEnd::Refused,
        JogEnd::Replaced => MotionEnd::Replaced,
        JogEnd::TakenOver { .. } => MotionEnd::TakenOver,
        JogEnd::StillMoving(_) => MotionEnd::StillMoving,
        JogEnd::Unbounded(_) => MotionEnd::Unbounded,
        _ => MotionEnd::Unknown,
    }
}

/// What people have to know of an end; nothing of the usual one.
fn end_text(end: &JogEnd) -> Option<Both> {
    match end {
        JogEnd::Refused(error) | JogEnd::Unknown(error) => Some(Both::of_error(error)),
        JogEnd::TakenOver { by } => Some(both(
            format!("{by} has taken the drive over."),
            format!("Приводом управляет {by}."),
        )),
        JogEnd::StillMoving(_) => Some(both(
            "The drive goes on in spite of Stop. Use the emergency stop.",
            "Привод движется, несмотря на Stop. Используйте аварийный останов.",
        )),
        JogEnd::Unbounded(_) => Some(both(
            "Limits are off, and this monitor would not end the motion by itself if the connection \
             failed. Switch the limits on, or set MoveTimeout of General, 500 ms for example.",
            "Контроль пределов выключен, и при обрыве связи ствол не прекратит движение сам. Включите \
             пределы или задайте MoveTimeout подсистемы General, например 500 мс.",
        )),
        _ => None,
    }
}
