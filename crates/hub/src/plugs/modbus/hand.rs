//! Orders of a desk, carried out by the hub: with a seat of its own, through the same entries as a console.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use lafet_texts::{Text as _, hub as text};
use serde::Serialize;
use tokio::sync::mpsc;

use super::desk::{Act, Command, Desk, What};
use super::layout::{AXES, HEADER_LEN, halves, name_words};
use super::refusal::{Failed, Refusal};
use super::sight::{Control, Holder, Known, Seen, Sight, Tally};
use crate::command::request::MonitorRequest;
use crate::command::urgent::Joined;
use crate::control::motion::Beat;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::sync::lock;

/// A period of the hub's sign of life, ms.
const LIFE_MS: u128 = 100;
/// The heartbeat that comes and goes is reported once in this time.
const SAID_EACH: Duration = Duration::from_secs(10);
/// A generation that no command has.
const VOID: u64 = u64::MAX;

/// The result of a command: unit, ticket, result.
pub type Answer = (u8, u32, Result<(), Failed>);

/// What carries out the orders of a session with a unit.
#[derive(Clone, Debug)]
pub struct Hand {
    hub: Hub,
    caller: Caller,
    unit: u8,
    version: u32,
    /// The monitors of the unit.
    ids: Arc<[String]>,
    answers: mpsc::Sender<Answer>,
    /// The generation of the desk, as commands that wait are compared with.
    generation: Arc<AtomicU64>,
    /// When the loss of the heartbeat was reported.
    said: Arc<Mutex<Option<Duration>>>,
    noted: Arc<Mutex<Noted>>,
}

/// Openings refused here.
#[derive(Debug, Default)]
struct Noted {
    /// The latest entry.
    at: Option<Duration>,
    /// Since that entry.
    count: u32,
}

/// Details of the entry of an opening refused here.
#[derive(Debug, Serialize)]
struct RefusedDetails {
    /// The number in the registers.
    code: u16,
    text: String,
    /// With those since the entry before it.
    count: u32,
}

impl Hand {
    /// The hand of a session with a unit.
    pub fn new(
        (hub, caller): (&Hub, &Caller),
        (unit, version): (u8, u32),
        ids: &[String],
        answers: &mpsc::Sender<Answer>,
    ) -> Self {
        Self {
            hub: hub.clone(),
            caller: caller.clone(),
            unit,
            version,
            ids: ids.into(),
            answers: answers.clone(),
            generation: Arc::new(AtomicU64::new(VOID)),
            said: Arc::default(),
            noted: Arc::default(),
        }
    }

    /// What the session sees now.
    pub fn sight(&self) -> Sight {
        let tallies = self.tallies();
        let each = self.ids.iter().zip(tallies).map(|(id, tally)| self.seen(id, tally));
        let monitors: Vec<Seen> = each.collect();
        let [high, low] = halves(self.version);
        let life = u16::try_from(self.hub.now().as_millis() / LIFE_MS % 65_536).unwrap_or_default();
        let fire = self.hub.alarms().fire();
        let waits = !self.hub.alarms().unacknowledged().is_empty();
        let site = u16::from(fire.active) | u16::from(fire.waiting) << 1 | u16::from(waits) << 2;
        let count = u16::try_from(monitors.len()).unwrap_or_default();
        let header: [u16; HEADER_LEN] = [high, low, life, count, site];
        Sight { header, monitors }
    }

    fn tallies(&self) -> Vec<Tally> {
        let mut tallies = vec![Tally::default(); self.ids.len()];
        for alarm in self.hub.alarms().list() {
            let at = self.ids.iter().position(|id| *id == alarm.monitor);
            if let Some(tally) = at.and_then(|at| tallies.get_mut(at)) {
                tally.add(alarm.priority, alarm.state);
            }
        }
        tallies
    }

    fn seen(&self, id: &str, alarms: Tally) -> Seen {
        let name = name_words(id);
        let Ok(station) = self.hub.station(id) else {
            let status = Default::default();
            let control = Control::default();
            let known =
                Known { status: &status, age: None, up: false, ready: false, control, alarms };
            return Seen::new(name, &known);
        };
        let status = station.status();
        let up = station.is_up();
        let ready = status.is_ready(up);
        let control = self.control(&station);
        let age = station.age(&self.hub);
        Seen::new(name, &Known { status: &status, age, up, ready, control, alarms })
    }

    fn control(&self, station: &Station) -> Control {
        let authority = lock(&station.authority);
        let own = &self.caller.seat.seat;
        let holder = match authority.holder() {
            None => Holder::Free,
            Some((seat, _)) if seat.seat == *own => Holder::Mine,
            Some(_) => Holder::Other,
        };
        let asking = authority.request();
        Control {
            holder,
            lost: authority.state() == crate::words::ControlWord::Lost,
            asked: asking.is_some(),
            asks: asking.is_some_and(|(seat, _)| seat.seat == *own),
        }
    }

    /// Carries out what a desk orders.
    pub fn carry_out(&self, desk: &mut Desk, acts: Vec<Act>) {
        let generation = desk.generation().map_or(VOID, u64::from);
        self.generation.store(generation, Ordering::SeqCst);
        for act in acts {
            match act {
                Act::Do { ticket, monitor, what } => self.order(ticket, monitor, what),
                Act::Beat { monitor, axis, toward } => {
                    let said = self.station(monitor).and_then(|station| {
                        self.hub.may_jog(&self.caller, &station)?;
                        let beat = Beat { drive: AXES[axis], toward, sent_ms: None };
                        station.beat(&self.hub, &self.caller, beat)
                    });
                    desk.jogged(monitor, axis, said.map_err(|error| Failed::from(&error)));
                }
                Act::Release { monitor, axis } => {
                    if let Ok(station) = self.station(monitor) {
                        station.end_jog(&self.caller.seat.seat, AXES[axis]);
                    }
                }
                Act::Halt { monitor, axis } => {
                    self.if_held(monitor, MonitorRequest::stop(AXES[axis]));
                }
                Act::Shut { monitor, valve } => {
                    self.if_held(monitor, MonitorRequest::close(valve_of(valve)));
                }
                Act::Refused { monitor, valve, why } => self.note_refused(monitor, valve, why),
                Act::Lost => {
                    self.each(|it| self.hub.seat_is_silent(it, &self.caller.seat.seat));
                    self.report_lost();
                }
                Act::Back => self.each(|station| {
                    self.hub.seat_is_back(station, &self.caller.seat.seat);
                }),
            }
        }
    }

    fn report_lost(&self) {
        let (now, mut said) = (self.hub.now(), lock(&self.said));
        if said.is_some_and(|at| now.saturating_sub(at) < SAID_EACH) {
            return;
        }
        *said = Some(now);
        let (master, from) = (&self.caller.principal.user, &self.caller.seat.from);
        self.hub.event(None, &text::PlugHeartbeatLost { master, from }.words());
    }

    /// Openings that were refused are in the audit log; of a master that tries again and again, with their number.
    fn note_refused(&self, monitor: usize, valve: u16, why: Refusal) {
        let Some(id) = self.ids.get(monitor) else { return };
        let Ok(request) = MonitorRequest::new(&Request::open(valve_of(valve))) else { return };
        let now = self.hub.now();
        let mut noted = lock(&self.noted);
        noted.count = noted.count.saturating_add(1);
        if noted.at.is_some_and(|at| now.saturating_sub(at) < SAID_EACH) {
            return;
        }
        let details =
            RefusedDetails { code: why.number(), text: why.text().en, count: noted.count };
        *noted = Noted { at: Some(now), count: 0 };
        let record = self.hub.record(&self.caller, id, request.text(), "not allowed");
        drop(self.hub.audit().note(record.with(&details).about(&request.act())));
    }

    fn station(&self, monitor: usize) -> Result<Arc<Station>, ApiError> {
        let id = self.ids.get(monitor).map(String::as_str).unwrap_or_default();
        self.hub.station(id)
    }

    fn each(&self, what: impl Fn(&Station)) {
        self.ids.iter().filter_map(|id| self.hub.station(id).ok()).for_each(|it| what(&it));
    }

    /// An urgent request that is this session's to send only as long as it holds the monitor.
    fn if_held(&self, monitor: usize, request: Result<MonitorRequest, ApiError>) {
        let (Ok(station), Ok(request)) = (self.station(monitor), request) else { return };
        if self.control(&station).holder == Holder::Mine {
            // For the wire alone: no hand has said no to the zones. It is carried out without a wait.
            drop(self.hub.overtake(&self.caller, &station, &request));
        }
    }

    fn order(&self, ticket: u32, monitor: Option<usize>, what: What) {
        let hand = self.clone();
        match what {
            What::Authority(command) => {
                let result = monitor.ok_or_else(ApiError::not_found).and_then(|monitor| {
                    let station = self.station(monitor)?;
                    let action = match command {
                        Command::Take => "take",
                        Command::Ask => "request",
                        _ => "release",
                    };
                    self.hub.change_authority(&self.caller, &station, action, None)
                });
                let result = result.map(drop).map_err(|error| match (command, error.code) {
                    (Command::Ask, "held") => Failed::from(Refusal::Asked),
                    _ => Failed::from(&error),
                });
                tokio::spawn(async move { hand.answer(ticket, result).await });
            }
            What::Stop | What::Lockout | What::Close(_) => {
                let joined = self.urgent(monitor, what);
                tokio::spawn(async move { hand.answer(ticket, results(joined).await).await });
            }
            What::GoTo(_) | What::Open(_) | What::Deploy | What::Stow => {
                let own = self.generation.load(Ordering::SeqCst);
                let requests = requests(what);
                tokio::spawn(async move {
                    let result = hand.commands(monitor.unwrap_or_default(), requests, own).await;
                    hand.answer(ticket, result).await;
                });
            }
        }
    }

    async fn answer(&self, ticket: u32, result: Result<(), Failed>) {
        // Without a reader the session has ended.
        _ = self.answers.send((self.unit, ticket, result)).await;
    }

    /// Sends urgent requests; they are under way when this returns.
    fn urgent(&self, monitor: Option<usize>, what: What) -> Result<Vec<Joined>, ApiError> {
        let Some(monitor) = monitor else {
            let request = match what {
                What::Lockout => MonitorRequest::lockout(),
                _ => MonitorRequest::stop(SubsystemId::ALL),
            }?;
            let all = self.hub.overtake_everywhere(&self.caller, &request);
            return Ok(all.into_iter().map(|(_, joined)| joined).collect());
        };
        let station = self.station(monitor)?;
        let requests = match what {
            What::Lockout => vec![MonitorRequest::lockout()?],
            What::Close(0) => {
                let valves = station.status().valves_to_close();
                valves.into_iter().map(MonitorRequest::close).collect::<Result<_, _>>()?
            }
            What::Close(valve) => vec![MonitorRequest::close(valve_of(valve))?],
            _ => vec![MonitorRequest::stop(SubsystemId::ALL)?],
        };
        Ok(requests.iter().map(|it| self.hub.urgent(&self.caller, &station, it)).collect())
    }

    /// Sends requests, as long as nothing has made them void.
    async fn commands(
        &self,
        monitor: usize,
        requests: Vec<Request<'static>>,
        own: u64,
    ) -> Result<(), Failed> {
        let failed = |error: ApiError| Failed::from(&error);
        let station = self.station(monitor).map_err(failed)?;
        let generation = self.generation.clone();
        let (holder, seat) = (station.clone(), self.caller.seat.seat.clone());
        let valid = move || {
            let same = own != VOID && generation.load(Ordering::SeqCst) == own;
            same && lock(&holder.authority).is_present(&seat)
        };
        let valid: Arc<dyn Fn() -> bool + Send + Sync> = Arc::new(valid);
        let mut sent = Vec::new();
        for request in &requests {
            let request = MonitorRequest::new(request).map_err(failed)?;
            sent.push(self.hub.command_while(&self.caller, &station, request, valid.clone()));
        }
        let (mut result, mut done) = (Ok(()), Vec::new());
        for (request, outcome) in requests.iter().zip(futures_util::future::join_all(sent).await) {
            let outcome = outcome.map_err(failed).and_then(|outcome| {
                let refused = outcome.answers.iter().find(|it| !it.success);
                refused.map_or(Ok(()), |it| {
                    Err(Failed { why: Refusal::Refused, status: it.code.into() })
                })
            });
            if outcome.is_ok() {
                done.push(request.to);
            }
            result = result.and(outcome);
        }
        // What is reported refused does not go on with a part of its drives.
        for axis in done.into_iter().filter(|it| result.is_err() && it.is_drive()) {
            self.if_held(monitor, MonitorRequest::stop(axis));
        }
        result
    }
}

/// The worst of several results.
async fn results(joined: Result<Vec<Joined>, ApiError>) -> Result<(), Failed> {
    let mut joined = joined.map_err(|error| Failed::from(&error))?;
    let each = futures_util::future::join_all(joined.iter_mut().map(Joined::result)).await;
    let failed = |result: Result<crate::command::outcome::Outcome, ApiError>| match result {
        Err(error) => Some(Failed::from(&error)),
        Ok(outcome) => outcome
            .answers
            .iter()
            .find(|it| !it.success)
            .map(|it| Failed { why: Refusal::Refused, status: it.code.into() }),
    };
    each.into_iter().find_map(failed).map_or(Ok(()), Err)
}

fn requests(what: What) -> Vec<Request<'static>> {
    match what {
        What::GoTo(targets) => {
            let moved = AXES.into_iter().zip(targets);
            let moved = moved.filter_map(|(axis, target)| Some((axis, target?)));
            let one = |(axis, target): (SubsystemId, i16)| {
                // Tenths of a degree to arc-minutes; the nozzle is in mm.
                let scale = if axis == SubsystemId::NOZZLE { 1 } else { 6 };
                let destination = target.saturating_mul(scale);
                Request::new(axis, Body::Move { destination })
            };
            moved.map(one).collect()
        }
        What::Open(valve) => vec![Request::open(valve_of(valve))],
        What::Deploy => vec![Request::new(SubsystemId::DEPLOYER, Body::Deploy)],
        What::Stow => vec![Request::new(SubsystemId::DEPLOYER, Body::Wrap)],
        What::Authority(_) | What::Stop | What::Close(_) | What::Lockout => Vec::new(),
    }
}

const fn valve_of(number: u16) -> SubsystemId {
    if number == 2 { SubsystemId::VALVE2 } else { SubsystemId::VALVE1 }
}
