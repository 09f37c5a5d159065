//! Valves that a lost client has opened: they are closed once more each second, until the monitor has confirmed it.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_texts::{Text as _, hub as text};
use tokio::time::sleep;

use super::orders::{What, valve_of};
use super::refusal::Failed;
use super::seat::{PlugSeat, results};
use super::sight::Holder;
use crate::command::request::MonitorRequest;
use crate::command::urgent::Joined;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::sync::lock;

/// Pause after a try that has failed.
const EACH: Duration = Duration::from_secs(1);
/// So often it is tried.
const TRIES: u32 = 600;

/// The valves of a monitor that are to close.
#[derive(Debug, Default)]
pub struct Closing(Mutex<Due>);

#[derive(Debug, Default)]
struct Due {
    /// Of each valve the number of the task that closes it.
    valves: [Option<u64>; 2],
    tasks: u64,
}

impl Closing {
    /// The number of a new task; that of an earlier one is void.
    fn begin(&self, valve: u16) -> u64 {
        let mut due = lock(&self.0);
        due.tasks += 1;
        let number = due.tasks;
        due.valves[place(valve)] = Some(number);
        number
    }

    fn is_due(&self, valve: u16, number: u64) -> bool {
        lock(&self.0).valves[place(valve)] == Some(number)
    }

    /// An opening is accepted: what closes the valve for a client that was lost ends. The valve, if something did.
    pub fn opens(&self, what: What) -> Option<u16> {
        match what {
            What::Open(valve) => self.end(valve).then_some(valve),
            _ => None,
        }
    }

    /// Nothing closes this valve any more; whether something did.
    fn end(&self, valve: u16) -> bool {
        lock(&self.0).valves[place(valve)].take().is_some()
    }

    fn done(&self, valve: u16, number: u64) {
        lock(&self.0).valves[place(valve)].take_if(|it| *it == number);
    }
}

fn place(valve: u16) -> usize {
    usize::from(valve == 2)
}

impl PlugSeat<'_> {
    /// Closes a valve that this seat has opened, also one of a monitor that it has released, unless another holds it:
    /// until the monitor has confirmed it, another holds it, or a client of a plug opens the valve.
    pub fn shut(self, station: &Arc<Station>, valve: u16) {
        let Ok(request) = MonitorRequest::close(valve_of(valve)) else { return };
        if self.control(station).holder == Holder::Other {
            return;
        }
        let number = station.closing.begin(valve);
        // For the wire alone: no hand has said no to the zones. It is under way when this returns.
        let (first, _) = self.hub.overtake(self.caller, station, &request);
        let (hub, caller) = (self.hub.clone(), self.caller.clone());
        let task = Task { hub, caller, station: station.clone(), valve, number, request };
        tokio::spawn(task.run(first));
    }

    /// What has become of the opening: if it certainly was not done, what was to close still is.
    pub fn opened(self, station: &Arc<Station>, valve: Option<u16>, result: Result<(), Failed>) {
        let closes = result.is_err_and(|failed| !failed.why.may_be_done());
        if let Some(valve) = valve.filter(|_| closes) {
            self.shut(station, valve);
        }
    }
}

/// Closes a valve.
struct Task {
    hub: Hub,
    caller: Caller,
    station: Arc<Station>,
    valve: u16,
    number: u64,
    request: MonitorRequest,
}

impl Task {
    async fn run(self, mut sent: Joined) {
        let mut shutdown = self.hub.shutdown();
        for attempt in 1..=TRIES {
            let result = tokio::select! {
                result = results(Ok(vec![sent])) => result,
                () = shutdown.requested() => return,
            };
            if result.is_ok() {
                break;
            }
            if attempt == 1 {
                self.report();
            }
            tokio::select! {
                () = sleep(EACH) => {}
                () = shutdown.requested() => return,
            }
            if !self.goes_on() {
                break;
            }
            sent = self.hub.overtake_again(&self.station, &self.request);
        }
        self.station.closing.done(self.valve, self.number);
    }

    fn goes_on(&self) -> bool {
        let seat = PlugSeat { hub: &self.hub, caller: &self.caller };
        let is_others = seat.control(&self.station).holder == Holder::Other;
        self.station.closing.is_due(self.valve, self.number) && !is_others
    }

    fn report(&self) {
        let (client, from) = (&self.caller.principal.user, &self.caller.seat.from);
        let (monitor, valve) = (self.station.id(), valve_of(self.valve).to_string());
        let what = text::PlugNotClosed { client, from, monitor, valve: &valve }.words();
        self.hub.event(Some(monitor), &what);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hub::SeatKey;
    use crate::plugs::orders::Command;
    use crate::plugs::refusal::Refusal;
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
            assert_eq!(station.closing.opens(What::Open(1)), None, "the other valve");
            let due = station.closing.opens(What::Open(2));
            assert_eq!(due, Some(2));
            closes(&station, 2).await;
            assert_eq!(closes(&station, 10).await, 0, "while it is opened");
            one.opened(&station, due, result);
            assert_eq!(closes(&station, 10).await > 5, goes_on, "{result:?}");
            station.closing.end(2);
            closes(&station, 2).await;
        }
    }
}
