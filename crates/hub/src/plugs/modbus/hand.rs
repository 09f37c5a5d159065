//! Orders of a desk, carried out by the hub: with a seat of its own, through the same entries as a console.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use lafet_proto::SubsystemId;
use lafet_texts::{Text as _, hub as text};
use tokio::sync::mpsc;

use super::desk::{Act, Desk, What};
use super::layout::{AXES, HEADER_LEN, halves, name_words};
use super::refusal::Failed;
use super::sight::{Seen, Sight, Tally};
use crate::command::request::MonitorRequest;
use crate::command::urgent::Joined;
use crate::control::jogs::Heard;
use crate::control::motion::Beat;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::plugs::noted::{Noted, Seldom};
use crate::plugs::orders::valve_of;
use crate::plugs::seat::{PlugSeat, results};

/// A period of the hub's sign of life, ms.
const LIFE_MS: u128 = 100;
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
    said: Seldom,
    noted: Arc<Noted>,
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
            said: Seldom::default(),
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
        self.seat().tallies(&self.ids)
    }

    fn seen(&self, id: &str, alarms: Tally) -> Seen {
        let name = name_words(id);
        self.seat().sees(id, alarms, |known| Seen::new(name, known))
    }

    fn seat(&self) -> PlugSeat<'_> {
        PlugSeat { hub: &self.hub, caller: &self.caller }
    }

    /// Of each monitor how often it was stopped, closed or locked out so far, from wherever.
    pub fn stops(&self) -> Vec<u64> {
        let count = |id: &String| self.hub.station(id).map_or(0, |it| it.urgent_count());
        self.ids.iter().map(count).collect()
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
                        let beat = Beat { drive: AXES[axis], toward, heard: Heard::default() };
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
                Act::Refused { monitor, valve, why } => {
                    let monitor = self.ids.get(monitor).map(String::as_str).unwrap_or_default();
                    self.noted.refused(self.seat(), monitor, valve, (why, why.text().en));
                }
                Act::Lost => {
                    self.each(|it| _ = self.hub.seat_is_silent(it, &self.caller.seat.seat));
                    self.report_lost();
                }
                Act::Back => self.each(|station| {
                    self.hub.seat_is_back(station, &self.caller.seat.seat);
                }),
            }
        }
    }

    fn report_lost(&self) {
        if !self.said.is_due(self.hub.now()) {
            return;
        }
        let (master, from) = (&self.caller.principal.user, &self.caller.seat.from);
        self.hub.event(None, &text::PlugHeartbeatLost { master, from }.words());
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
        self.seat().if_held(&station, &request);
    }

    fn order(&self, ticket: u32, monitor: Option<usize>, what: What) {
        let hand = self.clone();
        match what {
            What::Authority(command) => {
                let station = monitor.ok_or_else(ApiError::not_found);
                let station = station.and_then(|monitor| self.station(monitor));
                let result = station.map_err(|error| Failed::from(&error));
                let result = result.and_then(|it| self.seat().authority(&it, command));
                tokio::spawn(async move { hand.answer(ticket, result).await });
            }
            What::Stop | What::Lockout | What::Close(_) => {
                let joined = self.urgent(monitor, what);
                tokio::spawn(async move { hand.answer(ticket, results(joined).await).await });
            }
            What::GoTo(_) | What::Open(_) | What::Deploy | What::Stow => {
                let own = self.generation.load(Ordering::SeqCst);
                tokio::spawn(async move {
                    let result = hand.commands(monitor.unwrap_or_default(), what, own).await;
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
        self.seat().urgent(&station, what)
    }

    /// Sends requests, as long as nothing has made them void.
    async fn commands(&self, monitor: usize, what: What, own: u64) -> Result<(), Failed> {
        let station = self.station(monitor).map_err(|error| Failed::from(&error))?;
        let generation = self.generation.clone();
        let valid = move || own != VOID && generation.load(Ordering::SeqCst) == own;
        self.seat().commands(&station, (what, None), valid).await
    }
}
