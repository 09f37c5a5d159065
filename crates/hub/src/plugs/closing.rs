//! What a lost client has started: valves that the client of a plug has opened are closed, and drives that a client has sent
//! are stopped, once more each second, until the monitor has confirmed it.
//!
//! Assumed: who begins something later holds the monitor, and may have done all of it between two tries. So a try is made only
//! if no other client has held the monitor since the first one, and that is asked in the moment in which it is sent.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_proto::SubsystemId;
use lafet_texts::{Text as _, hub as text};
use tokio::time::sleep;

use super::orders::{AXES, What, valve_of};
use super::refusal::{Failed, Refusal};
use super::seat::{PlugSeat, results};
use super::sight::Holder;
use crate::command::request::MonitorRequest;
use crate::command::urgent::Joined;
use crate::control::authority::Seat;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::sync::lock;

/// Pause after a try that has failed.
const EACH: Duration = Duration::from_secs(1);
/// So often it is tried.
const TRIES: u32 = 600;

/// A part of a monitor that is to come to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Valve 1 or 2 closes.
    Valve(u16),
    /// A drive stops, by its place in [`AXES`].
    Drive(usize),
}

impl Part {
    const ALL: [Self; 5] =
        [Self::Valve(1), Self::Valve(2), Self::Drive(0), Self::Drive(1), Self::Drive(2)];

    /// What a command begins.
    fn of(what: What) -> impl Iterator<Item = Self> {
        let begins = move |part: &Self| match (what, *part) {
            (What::Open(opens), Self::Valve(valve)) => valve_of(opens) == valve_of(valve),
            (What::GoTo(targets), Self::Drive(axis)) => {
                targets.get(axis).is_some_and(Option::is_some)
            }
            _ => false,
        };
        Self::ALL.into_iter().filter(begins)
    }

    const fn subsystem(self) -> SubsystemId {
        match self {
            Self::Valve(valve) => valve_of(valve),
            Self::Drive(axis) => AXES[axis],
        }
    }

    fn request(self) -> Result<MonitorRequest, ApiError> {
        match self {
            Self::Valve(_) => MonitorRequest::close(self.subsystem()),
            Self::Drive(_) => MonitorRequest::stop(self.subsystem()),
        }
    }

    /// Whether the monitor has done it. A program that runs refuses the Stop of a drive, which is its own.
    fn is_done(self, result: Result<(), Failed>) -> bool {
        match result {
            Ok(()) => true,
            Err(failed) => matches!(self, Self::Drive(_)) && failed.why == Refusal::Refused,
        }
    }
}

/// The parts of a monitor that are to come to rest.
#[derive(Debug, Default)]
pub struct Closing(Mutex<Due>);

#[derive(Debug, Default)]
struct Due {
    /// Of each part the number of the task that ends it.
    parts: Vec<(Part, u64)>,
    tasks: u64,
}

impl Closing {
    /// The number of a new task; that of an earlier one is void.
    fn begin(&self, part: Part) -> u64 {
        let mut due = lock(&self.0);
        due.tasks += 1;
        let number = due.tasks;
        due.parts.retain(|(it, _)| *it != part);
        due.parts.push((part, number));
        number
    }

    fn is_due(&self, part: Part, number: u64) -> bool {
        lock(&self.0).parts.contains(&(part, number))
    }

    /// A command is accepted: what ends its parts for a client that was lost ends. The parts of which something did.
    pub fn begins(&self, what: What) -> Vec<Part> {
        Part::of(what).filter(|part| self.end(*part)).collect()
    }

    /// Nothing ends this part any more; whether something did.
    fn end(&self, part: Part) -> bool {
        lock(&self.0).parts.extract_if(.., |(it, _)| *it == part).count() > 0
    }

    fn done(&self, part: Part, number: u64) {
        lock(&self.0).parts.retain(|it| *it != (part, number));
    }
}

impl PlugSeat<'_> {
    /// Closes a valve that this seat has opened, also one of a monitor that it has released, unless another holds it:
    /// until the monitor has confirmed it, another holds it, or a client of a plug opens the valve.
    pub fn shut(self, station: &Arc<Station>, valve: u16) {
        if self.control(station).holder != Holder::Other {
            self.rest(station, Part::Valve(valve));
        }
    }

    /// Stops a drive that this seat has sent, as long as it holds the monitor: until the monitor has answered, another
    /// holds it, or a client of a plug sends the drive. By its place in [`AXES`].
    pub fn halt(self, station: &Arc<Station>, axis: usize) {
        if self.control(station).holder == Holder::Mine {
            self.rest(station, Part::Drive(axis));
        }
    }

    fn rest(self, station: &Arc<Station>, part: Part) {
        self.rest_for(station, part, &self.caller.seat);
    }

    fn rest_for(self, station: &Arc<Station>, part: Part, lost: &Seat) {
        let Ok(request) = part.request() else { return };
        let number = station.closing.begin(part);
        let given = lock(&station.authority).given();
        // For the wire alone: no hand has said no to the zones. It is under way when this returns.
        let (first, _) = self.hub.overtake(self.caller, station, &request);
        let (hub, caller) = (self.hub.clone(), self.caller.clone());
        let (station, lost) = (station.clone(), lost.clone());
        let task = Task { hub, caller, lost, station, part, number, request, given };
        tokio::spawn(task.run(first));
    }

    /// What has become of a command: if it certainly was not done, what was to come to rest still is.
    pub fn begun(self, station: &Arc<Station>, parts: &[Part], result: Result<(), Failed>) {
        if result.is_err_and(|failed| !failed.why.may_be_done())
            && self.control(station).holder != Holder::Other
        {
            parts.iter().for_each(|part| self.rest(station, *part));
        }
    }
}

impl Hub {
    /// Stops the drives of a monitor whose holder is lost, until the monitor has answered or another holds it: the
    /// link to it may be lost together with the holder. Programs, search and deployment refuse that Stop and go on
    /// (§3.2).
    pub fn halt_for_lost(&self, station: &Arc<Station>, lost: &Seat) {
        let caller = Caller::hub();
        let seat = PlugSeat { hub: self, caller: &caller };
        (0..AXES.len()).for_each(|axis| seat.rest_for(station, Part::Drive(axis), lost));
    }
}

/// Brings a part to rest.
struct Task {
    hub: Hub,
    /// In whose name.
    caller: Caller,
    /// Who started it.
    lost: Seat,
    station: Arc<Station>,
    part: Part,
    number: u64,
    request: MonitorRequest,
    /// How often the monitor had been given to a client when it began.
    given: u64,
}

impl Task {
    async fn run(self, mut sent: Joined) {
        let mut shutdown = self.hub.shutdown();
        for attempt in 1..=TRIES {
            let result = tokio::select! {
                result = results(Ok(vec![sent])) => result,
                () = shutdown.requested() => return,
            };
            if self.part.is_done(result) {
                break;
            }
            if attempt == 1 {
                self.report();
            }
            tokio::select! {
                () = sleep(EACH) => {}
                () = shutdown.requested() => return,
            }
            let goes_on = || self.goes_on();
            match self.hub.overtake_while(&self.station, &self.request, goes_on) {
                Some(again) => sent = again,
                None => break,
            }
        }
        self.station.closing.done(self.part, self.number);
    }

    fn goes_on(&self) -> bool {
        let authority = lock(&self.station.authority);
        let own = &self.caller.seat.seat;
        let is_others = authority.holder().is_some_and(|(seat, _)| seat.seat != *own)
            || authority.had_another_since(own, self.given);
        drop(authority);
        self.station.closing.is_due(self.part, self.number) && !is_others
    }

    fn report(&self) {
        let (client, from) = (&self.lost.user, &self.lost.from);
        let (monitor, part) = (self.station.id(), self.part.subsystem().to_string());
        let what = match self.part {
            Part::Valve(_) => text::PlugNotClosed { client, from, monitor, valve: &part }.words(),
            Part::Drive(_) => text::PlugNotStopped { client, from, monitor, drive: &part }.words(),
        };
        self.hub.event(Some(monitor), &what);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hub::SeatKey;
    use crate::plugs::orders::Command;
    use crate::plugs::seat::tests::client;
    use crate::store::Search;

    /// A hub with a monitor that no connection reaches, and two clients.
    fn bench() -> (Hub, Arc<Station>, [(SeatKey, Caller); 2]) {
        let (hub, station) = Hub::of_one(None);
        let clients = ["one", "other"].map(|name| client(&hub, name));
        (hub, station, clients)
    }

    fn seat<'a>(hub: &'a Hub, client: &'a (SeatKey, Caller)) -> PlugSeat<'a> {
        PlugSeat { hub, caller: &client.1 }
    }

    async fn closes(station: &Station, seconds: u64) -> u64 {
        let before = station.urgent_counts().close;
        sleep(Duration::from_secs(seconds)).await;
        station.urgent_counts().close - before
    }

    #[tokio::test]
    async fn it_is_reported_once_for_each_loss() {
        let (hub, station, clients) = bench();
        let reported = async || {
            let search = Search { limit: 100, ..Search::default() };
            let found = hub.events().find(search).await.unwrap().found;
            let own = found.iter().filter(|it| it.monitor.as_deref() == Some("M1"));
            own.filter(|it| it.what.en.contains("repeated each second")).count()
        };
        for loss in 1..=2 {
            seat(&hub, &clients[0]).shut(&station, 1);
            sleep(EACH * 5 / 2).await;
            assert_eq!(reported().await, loss);
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_close_that_is_not_confirmed_is_repeated_until_another_takes_over() {
        let (hub, station, clients) = bench();
        let (one, other) = (seat(&hub, &clients[0]), seat(&hub, &clients[1]));
        one.authority(&station, Command::Take).unwrap();
        // It opens, releases its authority and is lost.
        one.authority(&station, Command::Release).unwrap();
        one.shut(&station, 1);
        assert_eq!(station.urgent_counts().close, 1, "at once");
        assert!((8..=11).contains(&closes(&station, 10).await));
        // Lost once more: one task, not two.
        one.shut(&station, 1);
        assert!((8..=13).contains(&closes(&station, 10).await));
        other.authority(&station, Command::Take).unwrap();
        closes(&station, 2).await;
        assert_eq!(closes(&station, 60).await, 0, "it is another's water now");
        one.shut(&station, 1);
        assert_eq!(closes(&station, 10).await, 0, "from the beginning too");
    }

    #[tokio::test(start_paused = true)]
    async fn it_ends_after_ten_minutes_and_with_an_opening_that_is_done() {
        let (hub, station, clients) = bench();
        let one = seat(&hub, &clients[0]);
        one.shut(&station, 2);
        assert!((300..=600).contains(&closes(&station, 1300).await));
        assert_eq!(closes(&station, 60).await, 0);
        for (result, goes_on) in [
            (Ok(()), false),
            (Err(Refusal::Unknown.into()), false),
            (Err(Refusal::NotSent.into()), true),
        ] {
            one.shut(&station, 2);
            assert_eq!(station.closing.begins(What::Open(1)), [], "the other valve");
            let due = station.closing.begins(What::Open(2));
            assert_eq!(due, [Part::Valve(2)]);
            closes(&station, 2).await;
            assert_eq!(closes(&station, 10).await, 0, "while it is opened");
            one.begun(&station, &due, result);
            assert_eq!(closes(&station, 10).await > 5, goes_on, "{result:?}");
            station.closing.end(Part::Valve(2));
            closes(&station, 2).await;
        }
    }

    async fn stops(station: &Station, seconds: u64) -> u64 {
        let before = station.urgent_counts().stop;
        sleep(Duration::from_secs(seconds)).await;
        station.urgent_counts().stop - before
    }

    /// Assumed: the link is lost together with the client whose drive moves.
    #[tokio::test(start_paused = true)]
    async fn a_stop_that_is_not_confirmed_is_repeated_until_another_takes_over() {
        let (hub, station, clients) = bench();
        let (one, other) = (seat(&hub, &clients[0]), seat(&hub, &clients[1]));
        one.halt(&station, 1);
        assert_eq!(stops(&station, 10).await, 0, "it does not hold the monitor");
        one.authority(&station, Command::Take).unwrap();
        one.halt(&station, 1);
        assert_eq!(station.urgent_counts().stop, 1, "at once");
        assert!((8..=11).contains(&stops(&station, 10).await));
        // Its authority is lost meanwhile: no other holds the monitor.
        one.authority(&station, Command::Release).unwrap();
        assert!((8..=11).contains(&stops(&station, 10).await));
        other.authority(&station, Command::Take).unwrap();
        stops(&station, 2).await;
        assert_eq!(stops(&station, 60).await, 0, "it is another's drive now");
    }

    /// Assumed: the link comes back, and another client takes the monitor, moves it and releases it, between two tries.
    #[tokio::test(start_paused = true)]
    async fn what_another_has_begun_and_left_between_two_tries_is_not_ended() {
        let (hub, station, clients) = bench();
        let (one, other) = (seat(&hub, &clients[0]), seat(&hub, &clients[1]));
        for (again, goes_on) in [(one, true), (other, false)] {
            for drive in [true, false] {
                one.authority(&station, Command::Take).unwrap();
                match drive {
                    true => one.halt(&station, 1),
                    false => one.shut(&station, 1),
                }
                one.authority(&station, Command::Release).unwrap();
                // The first try is over, and the second one is due within a second.
                sleep(Duration::from_secs(3)).await;
                again.authority(&station, Command::Take).unwrap();
                again.authority(&station, Command::Release).unwrap();
                let before = station.urgent_count();
                sleep(Duration::from_secs(10)).await;
                let tries = station.urgent_count() - before;
                assert_eq!(tries > 5, goes_on, "{tries} tries");
                assert!(goes_on || tries == 0, "{tries} tries");
                station.closing.end(if drive { Part::Drive(1) } else { Part::Valve(1) });
                sleep(Duration::from_secs(5)).await;
            }
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_stop_ends_with_a_command_to_the_drive_and_after_ten_minutes() {
        let (hub, station, clients) = bench();
        let one = seat(&hub, &clients[0]);
        one.authority(&station, Command::Take).unwrap();
        let up = What::GoTo([None, Some(60), None]);
        for (result, goes_on) in [
            (Ok(()), false),
            (Err(Refusal::NoAnswer.into()), false),
            (Err(Refusal::Held.into()), true),
        ] {
            one.halt(&station, 1);
            let aside = What::GoTo([Some(60), None, Some(9)]);
            assert_eq!(station.closing.begins(aside), [], "other drives");
            let due = station.closing.begins(up);
            assert_eq!(due, [Part::Drive(1)]);
            stops(&station, 2).await;
            assert_eq!(stops(&station, 10).await, 0, "while it is sent");
            one.begun(&station, &due, result);
            assert_eq!(stops(&station, 10).await > 5, goes_on, "{result:?}");
            station.closing.end(Part::Drive(1));
            stops(&station, 2).await;
        }
        one.halt(&station, 0);
        assert!((300..=600).contains(&stops(&station, 1300).await));
        assert_eq!(stops(&station, 60).await, 0);
    }

    #[test]
    fn an_answer_ends_the_stop_of_a_drive_and_a_refusal_no_close() {
        let refused = || Err(Failed::from(Refusal::Refused));
        assert!(Part::Drive(0).is_done(Ok(())) && Part::Valve(1).is_done(Ok(())));
        assert!(Part::Drive(0).is_done(refused()), "a program has the drive");
        assert!(!Part::Valve(1).is_done(refused()));
        for why in [Refusal::NoAnswer, Refusal::NotSent, Refusal::Unknown, Refusal::Hub] {
            assert!(!Part::Drive(0).is_done(Err(why.into())), "{why:?}");
        }
    }
}
