//! Orders of a desk, carried out by the hub: with a seat of its own, through the same entries as a console.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use lafet_proto::SubsystemId;
use lafet_texts::{Text as _, hub as text};
use tokio::sync::mpsc;

use super::desk::{Act, Desk, Stops, What};
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
use crate::plugs::closing::Part;
use crate::plugs::noted::Reports;
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
    reports: Reports,
}

impl Hand {
    /// The hand of a session with a unit.
    pub fn new(
        (hub, caller): (&Hub, &Caller),
        (unit, version): (u8, u32),
        ids: &[String],
        answers: &mpsc::Sender<Answer>,
        reports: &Reports,
    ) -> Self {
        Self {
            hub: hub.clone(),
            caller: caller.clone(),
            unit,
            version,
            ids: ids.into(),
            answers: answers.clone(),
            generation: Arc::new(AtomicU64::new(VOID)),
            reports: reports.clone(),
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

    /// As many monitors as there are, without their state: what Stop needs.
    pub fn outline(&self) -> Sight {
        Sight { header: [0; HEADER_LEN], monitors: vec![Seen::default(); self.ids.len()] }
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
    pub fn stops(&self) -> Vec<Stops> {
        let count = |station: Arc<Station>| {
            let counts = station.urgent_counts();
            let motion = counts.stop + counts.lockout;
            Stops { all: motion + counts.close, motion }
        };
        self.ids.iter().map(|id| self.hub.station(id).map(count).unwrap_or_default()).collect()
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
                    if let Ok(station) = self.station(monitor) {
                        self.seat().halt(&station, axis);
                    }
                }
                Act::Shut { monitor, valve } => {
                    if let Ok(station) = self.station(monitor) {
                        self.seat().shut(&station, valve);
                    }
                }
                Act::Refused { monitor, valve, why } => {
                    let monitor = self.ids.get(monitor).map(String::as_str).unwrap_or_default();
                    self.reports.refused.refused(self.seat(), monitor, valve, (why, why.text().en));
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
        if !self.reports.lost.is_due(self.hub.now()) {
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
                // From here on: what undoes it before its task begins makes it void as well.
                let since = self.hub.now();
                let station = self.station(monitor.unwrap_or_default());
                let due = station.as_ref().map(|it| it.closing.begins(what)).unwrap_or_default();
                tokio::spawn(async move {
                    let result = hand.commands(station, (what, since), (own, due)).await;
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
    async fn commands(
        &self,
        station: Result<Arc<Station>, ApiError>,
        (what, since): (What, Duration),
        (own, due): (u64, Vec<Part>),
    ) -> Result<(), Failed> {
        let station = station.map_err(|error| Failed::from(&error))?;
        let generation = self.generation.clone();
        let valid = move || own != VOID && generation.load(Ordering::SeqCst) == own;
        let result = self.seat().commands(&station, (what, Some(since)), valid).await;
        self.seat().begun(&station, &due, result);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plugs::orders::Command;
    use crate::plugs::refusal::Refusal;
    use crate::plugs::seat::tests::client;

    /// The task of a command has not started yet when another stops the monitor.
    #[tokio::test]
    async fn a_stop_undoes_what_was_accepted_before_it_and_has_not_started() {
        let (hub, station) = Hub::of_one(None);
        let (_key, caller) = client(&hub, "plc");
        let (answers, mut results) = mpsc::channel(4);
        let ids = ["M1".to_owned()];
        let hand = Hand::new((&hub, &caller), (1, 0), &ids, &answers, &Reports::default());
        hand.seat().authority(&station, Command::Take).unwrap();
        hand.generation.store(1, Ordering::SeqCst);
        for (ticket, what) in [(1, What::GoTo([Some(60), None, None])), (2, What::Open(1))] {
            for (stops, why) in [(true, Refusal::Void), (false, Refusal::NotSent)] {
                hand.order(ticket, Some(0), what);
                if stops {
                    let stop = MonitorRequest::stop(SubsystemId::ALL).unwrap();
                    drop(hub.overtake(&Caller::hub(), &station, &stop));
                }
                let (_, of, result) = results.recv().await.unwrap();
                assert_eq!((of, result), (ticket, Err(Failed::from(why))));
            }
        }
    }
}
