//! Orders of a desk, carried out by the hub: with a seat of its own, through the same entries as a console.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use tokio::sync::mpsc;

use super::desk::{Act, Desk, Now};
use super::state::{self, State};
use crate::command::urgent::Joined;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::plugs::noted::Reports;
use crate::plugs::orders::What;
use crate::plugs::refusal::{Failed, Refusal};
use crate::plugs::seat::{PlugSeat, results};
use crate::plugs::sight::Holder;
use crate::text::Both;

/// A generation that no command has.
const VOID: u64 = u64::MAX;

/// The result of a command, by its number.
pub type Answer = (u32, Result<(), Failed>);

/// What is said of the clients of a session.
#[derive(Clone, Copy, Debug)]
pub struct Tongue {
    /// They are silent, by name and place.
    pub silent: fn(&str, &str) -> Both,
    /// Why an opening is refused.
    pub refusal: fn(Refusal) -> Both,
    /// Their commands have ids of their own, which are noted.
    pub ids: bool,
}

/// What carries out the orders of a session.
#[derive(Clone, Debug)]
pub struct Hand {
    hub: Hub,
    caller: Caller,
    ids: Arc<[String]>,
    answers: mpsc::Sender<Answer>,
    /// The generations of the desk, as commands that wait are compared with.
    generations: Arc<[AtomicU64]>,
    reports: Reports,
    tongue: Tongue,
}

impl Hand {
    /// The hand of a session.
    pub fn new(
        hub: &Hub,
        caller: &Caller,
        ids: &[String],
        answers: mpsc::Sender<Answer>,
        (reports, tongue): (Reports, Tongue),
    ) -> Self {
        Self {
            hub: hub.clone(),
            caller: caller.clone(),
            ids: ids.into(),
            answers,
            generations: ids.iter().map(|_| AtomicU64::new(VOID)).collect(),
            reports,
            tongue,
        }
    }

    fn seat(&self) -> PlugSeat<'_> {
        PlugSeat { hub: &self.hub, caller: &self.caller }
    }

    /// The states of the monitors.
    pub fn states(&self) -> Vec<State> {
        state::all(self.seat(), &self.ids)
    }

    /// Who has authority over a monitor.
    pub fn holder(&self, monitor: usize) -> Holder {
        self.station(monitor).map_or(Holder::Free, |it| self.seat().control(&it).holder)
    }

    /// Carries out what a desk orders; the rest is for its broker.
    pub fn carry_out(&self, desk: &Desk, acts: Vec<Act>) -> Vec<Act> {
        for (at, generation) in self.generations.iter().enumerate() {
            generation.store(desk.generation(at).map_or(VOID, u64::from), Ordering::SeqCst);
        }
        acts.into_iter().filter_map(|act| self.act(act)).collect()
    }

    fn act(&self, act: Act) -> Option<Act> {
        match act {
            Act::Do { number, monitor, what, id, since } => {
                self.order((number, id), monitor, (what, since));
            }
            Act::Halt { monitor, axis } => {
                if let Ok(station) = self.station(monitor) {
                    self.seat().halt(&station, axis);
                }
            }
            Act::Shut { monitor, valve } => {
                if let Ok(station) = self.station(monitor) {
                    self.seat().shut(&station, valve);
                }
            }
            Act::Refused { monitor, valve, why, id } => {
                let caller = self.caller_of(id);
                let seat = PlugSeat { hub: &self.hub, caller: &caller };
                let monitor = self.ids.get(monitor).map(String::as_str).unwrap_or_default();
                self.reports.refused.refused(
                    seat,
                    monitor,
                    valve,
                    (why, (self.tongue.refusal)(why).en),
                );
            }
            Act::Lost => {
                let seat = &self.caller.seat.seat;
                let held = self.each(|station| {
                    let held = self.seat().control(station).holder == Holder::Mine;
                    self.hub.seat_is_silent(station, seat);
                    held
                });
                if held {
                    self.report_lost();
                }
            }
            Act::Back => {
                self.each(|station| {
                    self.hub.seat_is_back(station, &self.caller.seat.seat);
                    false
                });
            }
            Act::Ticket(_) | Act::Key(_) | Act::Say(_) => return Some(act),
        }
        None
    }

    fn report_lost(&self) {
        if !self.reports.lost.is_due(self.hub.now()) {
            return;
        }
        let (client, from) = (&self.caller.principal.user, &self.caller.seat.from);
        self.hub.event(None, &(self.tongue.silent)(client, from));
    }

    fn station(&self, monitor: usize) -> Result<Arc<Station>, ApiError> {
        let id = self.ids.get(monitor).map(String::as_str).unwrap_or_default();
        self.hub.station(id)
    }

    /// Whether it is so of any monitor, after all were asked.
    fn each(&self, what: impl Fn(&Station) -> bool) -> bool {
        let stations = self.ids.iter().filter_map(|id| self.hub.station(id).ok());
        stations.filter(|it| what(it)).count() > 0
    }

    /// The caller with the id of its command, for the audit log.
    fn caller_of(&self, id: Option<String>) -> Caller {
        let mut caller = self.caller.clone();
        if let Some(id) = id.filter(|_| self.tongue.ids) {
            caller.seat.from = format!("{} id {id}", caller.seat.from);
        }
        caller
    }

    fn order(
        &self,
        (number, id): (u32, Option<String>),
        monitor: Option<usize>,
        (what, since): (What, Option<Now>),
    ) {
        let hand = Self { caller: self.caller_of(id), ..self.clone() };
        match what {
            What::Authority(command) => {
                let station = monitor.ok_or_else(ApiError::not_found);
                let station = station.and_then(|monitor| self.station(monitor));
                let result = station.map_err(|error| Failed::from(&error));
                let result = result.and_then(|it| hand.seat().authority(&it, command));
                tokio::spawn(async move { hand.answer(number, result).await });
            }
            What::Stop | What::Lockout | What::Close(_) => {
                let joined = hand.urgent(monitor, what);
                if number != 0 {
                    tokio::spawn(async move { hand.answer(number, results(joined).await).await });
                }
            }
            What::GoTo(_) | What::Open(_) | What::Deploy | What::Stow => {
                let at = monitor.unwrap_or_default();
                let own = self.generations.get(at).map_or(VOID, |it| it.load(Ordering::SeqCst));
                let station = self.station(at);
                let due = station.as_ref().map(|it| it.closing.begins(what)).unwrap_or_default();
                tokio::spawn(async move {
                    let result = match station {
                        Ok(station) => {
                            let result = hand.commands(&station, at, (what, since), own).await;
                            hand.seat().begun(&station, &due, result);
                            result
                        }
                        Err(error) => Err(Failed::from(&error)),
                    };
                    hand.answer(number, result).await;
                });
            }
        }
    }

    async fn answer(&self, number: u32, result: Result<(), Failed>) {
        // Without a reader the session has ended.
        _ = self.answers.send((number, result)).await;
    }

    /// Sends urgent requests to a monitor or to all; they are under way when this returns.
    fn urgent(&self, monitor: Option<usize>, what: What) -> Result<Vec<Joined>, ApiError> {
        if let Some(monitor) = monitor {
            return self.seat().urgent(&self.station(monitor)?, what);
        }
        let stations = self.ids.iter().filter_map(|id| self.hub.station(id).ok());
        let mut joined = Vec::new();
        for station in stations {
            joined.extend(self.seat().urgent(&station, what)?);
        }
        Ok(joined)
    }

    /// Sends requests, as long as nothing has made them void.
    async fn commands(
        &self,
        station: &Arc<Station>,
        at: usize,
        (what, since): (What, Option<Now>),
        own: u64,
    ) -> Result<(), Failed> {
        let generations = self.generations.clone();
        let now = move || generations.get(at).map_or(VOID, |it| it.load(Ordering::SeqCst));
        if own == VOID {
            return Err(Failed::from(Refusal::Void));
        }
        self.seat().commands(station, (what, since), move || now() == own).await
    }
}
