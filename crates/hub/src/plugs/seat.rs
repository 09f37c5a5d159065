//! The seat of a plug's client in the hub: what it sees, and what it asks for, through the same entries as a console.

use std::sync::Arc;
use std::time::Duration;

use lafet_proto::SubsystemId;

use super::orders::{AXES, Command, What, valve_of};
use super::refusal::{Failed, Refusal};
use super::sight::{Control, Holder, Known, Tally};
use crate::command::outcome::Outcome;
use crate::command::request::MonitorRequest;
use crate::command::urgent::Joined;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::sync::lock;

/// A client of a plug.
#[derive(Clone, Copy, Debug)]
pub struct PlugSeat<'a> {
    /// The hub.
    pub hub: &'a Hub,
    /// Who asks, and its seat.
    pub caller: &'a Caller,
}

impl PlugSeat<'_> {
    /// The alarms of monitors, in their order.
    pub fn tallies(self, ids: &[String]) -> Vec<Tally> {
        let mut tallies = vec![Tally::default(); ids.len()];
        for alarm in self.hub.alarms().list() {
            let at = ids.iter().position(|id| *id == alarm.monitor);
            if let Some(tally) = at.and_then(|at| tallies.get_mut(at)) {
                tally.add(alarm.priority, alarm.state);
            }
        }
        tallies
    }

    /// Shows what is known of a monitor; of one that there is not, nothing is.
    pub fn sees<T>(self, id: &str, alarms: Tally, show: impl FnOnce(&Known<'_>) -> T) -> T {
        let Ok(station) = self.hub.station(id) else {
            let (status, control) = (Default::default(), Control::default());
            let (age, up, ready) = (None, false, false);
            return show(&Known { status: &status, age, up, ready, control, alarms });
        };
        let status = station.status();
        let up = station.is_up();
        let (ready, age) = (status.is_ready(up), station.age(self.hub));
        let control = self.control(&station);
        show(&Known { status: &status, age, up, ready, control, alarms })
    }

    /// The authority over a monitor, as this seat sees it.
    pub fn control(self, station: &Station) -> Control {
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

    /// Takes, releases or asks for authority.
    pub fn authority(self, station: &Arc<Station>, command: Command) -> Result<(), Failed> {
        let action = match command {
            Command::Take => "take",
            Command::Ask => "request",
            _ => "release",
        };
        let result = self.hub.change_authority(self.caller, station, action, None);
        result.map(drop).map_err(|error| match (command, error.code) {
            (Command::Ask, "held") => Failed::from(Refusal::Asked),
            _ => Failed::from(&error),
        })
    }

    /// Sends urgent requests to a monitor; they are under way when this returns.
    pub fn urgent(self, station: &Arc<Station>, what: What) -> Result<Vec<Joined>, ApiError> {
        let requests = match what {
            What::Lockout => vec![MonitorRequest::lockout()?],
            What::Close(0) => {
                let valves = station.status().valves_to_close();
                valves.into_iter().map(MonitorRequest::close).collect::<Result<_, _>>()?
            }
            What::Close(valve) => vec![MonitorRequest::close(valve_of(valve))?],
            _ => vec![MonitorRequest::stop(SubsystemId::ALL)?],
        };
        Ok(requests.iter().map(|it| self.hub.urgent(self.caller, station, it)).collect())
    }

    /// Sends requests, as long as `valid` and the seat is present. What was on its way `since` a moment after
    /// the start is not sent if something has come since that undoes it.
    pub async fn commands(
        self,
        station: &Arc<Station>,
        (what, since): (What, Option<Duration>),
        valid: impl Fn() -> bool + Send + Sync + 'static,
    ) -> Result<(), Failed> {
        let failed = |error: ApiError| Failed::from(&error);
        let (holder, seat) = (station.clone(), self.caller.seat.seat.clone());
        let valid = move || valid() && lock(&holder.authority).is_present(&seat);
        let valid: Arc<dyn Fn() -> bool + Send + Sync> = Arc::new(valid);
        let (requests, mut sent) = (what.requests(), Vec::new());
        let since = since.map(|since| self.hub.start() + since);
        for request in &requests {
            let request = MonitorRequest::new(request).map_err(failed)?;
            let (of, own, valid) = (station.clone(), request.clone(), valid.clone());
            let undone = move || since.is_some_and(|since| of.is_undone_since(&own, since));
            let valid = Arc::new(move || valid() && !undone());
            sent.push(self.hub.command_while(self.caller, station, request, valid));
        }
        let (mut result, mut done) = (Ok(()), Vec::new());
        for (request, outcome) in requests.iter().zip(futures_util::future::join_all(sent).await) {
            let outcome = outcome.map_err(failed).and_then(|it| refused(&it).map_or(Ok(()), Err));
            if outcome.is_ok() {
                done.push(request.to);
            }
            result = result.and(outcome);
        }
        // What is reported refused does not go on with a part of its drives.
        if result.is_err() {
            let done = AXES.iter().enumerate().filter(|(_, drive)| done.contains(drive));
            done.for_each(|(axis, _)| self.halt(station, axis));
        }
        result
    }
}

/// The worst of several results.
pub async fn results(joined: Result<Vec<Joined>, ApiError>) -> Result<(), Failed> {
    let mut joined = joined.map_err(|error| Failed::from(&error))?;
    let each = futures_util::future::join_all(joined.iter_mut().map(Joined::result)).await;
    let failed = |result: Result<Outcome, ApiError>| match result {
        Err(error) => Some(Failed::from(&error)),
        Ok(outcome) => refused(&outcome),
    };
    each.into_iter().find_map(failed).map_or(Ok(()), Err)
}

fn refused(outcome: &Outcome) -> Option<Failed> {
    let refused = outcome.answers.iter().find(|it| !it.success)?;
    Some(Failed { why: Refusal::Refused, status: refused.code.into() })
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::access::{Kind, Principal, Role, Standing};
    use crate::hub::SeatKey;

    /// A client of a plug, with its place.
    pub fn client(hub: &Hub, name: &str) -> (SeatKey, Caller) {
        let principal = Principal {
            user: name.into(),
            role: Role::Operator,
            kind: Kind::Mqtt,
            key: name.into(),
            csrf: String::new(),
            expires_ms: 0,
            standing: Standing::Good,
        };
        let key = hub.connect(&principal, "broker", None);
        let caller = Caller::plug(principal, "broker".into(), key.seat.clone(), "mqtt");
        (key, caller)
    }

    /// A broker holds a command back; meanwhile Stop is pressed at a console.
    #[tokio::test]
    async fn what_was_sent_before_a_stop_is_not_carried_out_after_it() {
        let (hub, station) = Hub::of_one(None);
        let (_key, caller) = client(&hub, "mqtt");
        let seat = PlugSeat { hub: &hub, caller: &caller };
        seat.authority(&station, Command::Take).unwrap();
        let since = hub.now();
        let why = async |since| {
            let sent = seat.commands(&station, (What::Open(1), Some(since)), || true);
            sent.await.unwrap_err().why
        };
        assert_ne!(why(since).await, Refusal::Void, "no line, and no Stop");
        drop(hub.overtake(
            &Caller::hub(),
            &station,
            &MonitorRequest::stop(SubsystemId::ALL).unwrap(),
        ));
        assert_eq!(why(since).await, Refusal::Void);
        assert_ne!(why(hub.now()).await, Refusal::Void, "asked for after the Stop");
    }
}
