//! Orders of the machine: to monitors on the way of every other request, to outputs and pumps on their bus.
//!
//! What closes goes at once, as a person's Stop does. What opens or turns takes the authority of the monitor
//! first, and is asked again right before each request is sent whether it still holds: a later order for the
//! monitor makes it void, and so does the time that the machine gave it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};
use lafet_site::{Cause, Command, MonitorReport, Order, Phase, State, Tone, Withheld};
use tokio::time::sleep;

use super::index::Beside;
use super::line::{Aiming, Asked};
use super::{Machine, Valid, ZONES, Zones};
use crate::access::{Kind, Principal, Role, Standing};
use crate::command::request::MonitorRequest;
use crate::command::urgent::REPEATS_NOTED;
use crate::config::{Aim, Target};
use crate::control::authority::Seat;
use crate::error::ApiError;
use crate::field::drive;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::store::Act;
use crate::sync::lock;

/// Pause before a request that was not accepted is sent again.
const AGAIN: Duration = Duration::from_secs(1);
/// Pause between two looks at a monitor that is being deployed.
const LOOK: Duration = Duration::from_millis(50);
/// What was started in time goes on for so long at most: a monitor deploys meanwhile.
const GOES_ON: Duration = Duration::from_secs(60);

impl Caller {
    /// The zone controller.
    pub fn zones() -> Self {
        let seat = Seat {
            user: ZONES.into(),
            role: Role::Operator,
            seat: ZONES.into(),
            from: String::new(),
            // It gives authority back by itself.
            live: true,
        };
        let principal = Principal {
            user: ZONES.into(),
            role: Role::Operator,
            kind: Kind::Demo,
            key: ZONES.into(),
            csrf: String::new(),
            expires_ms: 0,
            standing: Standing::Good,
        };
        Self { principal, seat, via: ZONES }
    }
}

impl Hub {
    /// Carries out an order of the machine.
    pub(super) fn carry_order(&self, zones: &Zones, machine: &mut Machine, command: &Command) {
        let (Order::Prepare { monitor, .. }
        | Order::Engage { monitor, .. }
        | Order::Close { monitor }
        | Order::Stop { monitor }) = &command.order
        else {
            self.drive_output(command);
            return;
        };
        let Some(line) = machine.lines.get_mut(monitor) else { return };
        let number = line.void();
        let Ok(station) = self.station(monitor) else { return line.clear() };
        match &command.order {
            Order::Close { .. } => {
                line.clear();
                self.send_urgent_orders(&station, &closing(&station), command);
            }
            Order::Stop { .. } => {
                line.clear();
                let stop = [MonitorRequest::stop(SubsystemId::ALL)];
                self.send_urgent_orders(&station, &stop, command);
            }
            Order::Prepare { zone, .. } | Order::Engage { zone, .. } => {
                line.clear();
                self.aim(zones, machine, command, (station, number, monitor, zone));
            }
            _ => {}
        }
    }

    /// Orders a monitor to its fire, by this number; without one, as configured.
    fn aim(
        &self,
        zones: &Zones,
        machine: &mut Machine,
        command: &Command,
        (station, number, monitor, zone): (Arc<Station>, u64, &String, &String),
    ) {
        let Some(aim) = zones.config.aims.get(&(zone.clone(), monitor.clone())).cloned() else {
            return;
        };
        let of = zones.config.site.zones.iter().find(|it| it.id == *zone);
        let fire = of.and_then(|of| self.fire_of(machine, of, monitor));
        let Some(line) = machine.lines.get_mut(monitor) else { return };
        let accepted = Arc::new(AtomicBool::new(false));
        let opens = matches!(command.order, Order::Engage { .. });
        let opening = Opening {
            hub: self.clone(),
            fire: fire.map(|it| it.1),
            station,
            aim,
            opens,
            latest: line.latest.number.clone(),
            number,
            accepted: accepted.clone(),
            not_after: command.not_after_ms.map(Duration::from_millis),
        };
        line.order = Some(Aiming { fire: fire.map(|it| it.0), accepted });
        if opens {
            line.engage(zone, command, number);
        }
        line.task = Some(tokio::spawn(opening.run()).abort_handle());
    }

    fn drive_output(&self, command: &Command) {
        let (id, on) = match &command.order {
            Order::Pump { pump, on } => (pump, *on),
            Order::Valve { output, open } => (output, *open),
            Order::Sound { output, tone } => (output, *tone != Tone::Off),
            Order::Lamp { output, lit } => (output, *lit),
            _ => return,
        };
        let not_after = command.not_after_ms.map(Duration::from_millis);
        self.field().order(id, drive::Order { on, number: command.number, not_after });
    }

    fn send_urgent_orders(
        &self,
        station: &Arc<Station>,
        requests: &[Result<MonitorRequest, ApiError>],
        command: &Command,
    ) {
        for request in requests.iter().flatten() {
            match command.cause.last() {
                // Repeated each second until it is confirmed: the log has the first one.
                Some(Cause::Repeated) => drop(self.overtake_again(station, request)),
                _ => drop(self.overtake(&Caller::zones(), station, request)),
            }
        }
    }

    /// Gives monitors back that no zone needs, and to who asks for them.
    pub(super) fn give_back(&self, zones: &Zones, machine: &Machine, state: &State) {
        let counting = state.zones.iter().any(|zone| zone.phase.is_pending());
        let stations = self.all_stations();
        let mut stations = Beside::new(&stations);
        for ((id, line), at) in machine.lines.iter().zip(zones.index.by_id()) {
            let (Some(station), monitor) = (stations.of(id), &state.monitors[at]) else {
                continue;
            };
            let (holds, asked) = {
                let authority = lock(&station.authority);
                let holds = authority.holder().is_some_and(|(seat, _)| seat.seat == ZONES);
                (holds, authority.request().is_some())
            };
            let busy = line.task.as_ref().is_some_and(|task| !task.is_finished());
            let needs = monitor.engaged_for.is_some() || monitor.closing || counting || busy;
            let action = match (holds, asked, needs) {
                (true, true, _) => "grant",
                (true, false, false) => "release",
                _ => continue,
            };
            _ = self.change_authority(&Caller::zones(), station, action, None);
        }
    }

    /// A monitor that turns to a fire which is no cause any more, as the votes were withdrawn or the zone was
    /// switched to another mode, is sent nothing further. Nor is one that a person or a lockout has taken from its
    /// order: no order of the machine follows.
    pub(super) fn end_turning(&self, zones: &Zones, machine: &mut Machine, state: &State) {
        for (line, at) in machine.lines.values_mut().zip(zones.index.by_id()) {
            let monitor = &state.monitors[at];
            if line.order.is_none() {
                continue;
            }
            let mut own = zones.index.zones_of(at).iter().map(|zone| state.zones[*zone].phase);
            let mut wanted =
                || own.any(|phase| phase.is_pending() || matches!(phase, Phase::Released { .. }));
            let goes_on = match &line.engaged {
                Some(_) => line.engaged == monitor.engaged_for,
                None => monitor.engaged_for.is_some() || monitor.closing || wanted(),
            };
            let taken = matches!(
                monitor.withheld,
                Some(Withheld::Person | Withheld::Lockout | Withheld::Refused)
            );
            if taken || !goes_on {
                line.void();
                line.clear();
            }
        }
    }

    /// Asks who holds a monitor that votes or a release need, as another operator would: who does not
    /// answer and commands nothing gives way after the usual time, who answers decides. Each is asked once for
    /// the votes and once for the release; who has water at work is left alone, and so is everyone in a test.
    pub(super) fn ask_holders(&self, zones: &Zones, machine: &mut Machine, state: &State) {
        let stations = self.all_stations();
        let mut stations = Beside::new(&stations);
        for ((id, line), at) in machine.lines.iter_mut().zip(zones.index.by_id()) {
            let withheld = state.monitors[at].withheld == Some(Withheld::Person);
            let Some(station) = stations.of(id).filter(|_| withheld || line.asked.is_some()) else {
                continue;
            };
            let wants = wanted(zones, state, at);
            let works = line.report().is_none_or(MonitorReport::acts);
            let Some(wants) = wants.filter(|_| withheld && !works) else {
                if line.asked.take_if(|_| wants.is_none()).is_some()
                    && lock(&station.authority).withdraw(ZONES)
                {
                    station.publish_authority(self);
                }
                continue;
            };
            let free = {
                let authority = lock(&station.authority);
                let other = authority.holder().is_some_and(|(seat, _)| seat.seat != ZONES);
                other && authority.request().is_none()
            };
            if free && line.asked != Some(wants) {
                line.asked = Some(wants);
                _ = self.change_authority(&Caller::zones(), station, "request", None);
            }
        }
    }

    /// Whether this Close or Stop was noted for its monitor lately, and nothing else was ordered since.
    fn is_repeated(&self, machine: &mut Machine, order: &Order) -> bool {
        let key = |monitor: &String, stops| (monitor.clone(), stops);
        let key = match order {
            Order::Close { monitor } => key(monitor, false),
            Order::Stop { monitor } => key(monitor, true),
            Order::Prepare { monitor, .. } | Order::Engage { monitor, .. } => {
                for stops in [false, true] {
                    machine.ordered.remove(&key(monitor, stops));
                }
                return false;
            }
            _ => return false,
        };
        let now = self.now();
        let repeated = machine.ordered.get(&key).is_some_and(|at| now < *at + REPEATS_NOTED);
        if !repeated {
            machine.ordered.insert(key, now);
        }
        repeated
    }

    /// Notes an order with its causes; the request to the monitor has its own entries. Close and Stop that are
    /// repeated, as a no is, are noted once in a while.
    pub(super) fn note_order(&self, machine: &mut Machine, command: &Command) {
        let monitor = match &command.order {
            Order::Prepare { monitor, .. }
            | Order::Engage { monitor, .. }
            | Order::Close { monitor }
            | Order::Stop { monitor } => monitor,
            Order::Pump { .. } | Order::Valve { .. } => "",
            Order::Sound { .. } | Order::Lamp { .. } => return,
        };
        if command.cause.last() == Some(&Cause::Repeated) {
            return;
        }
        if self.is_repeated(machine, &command.order) {
            return;
        }
        let what = format!("zones: {}", super::notes::word_of(&command.order));
        let act = Act::ZoneOrder { order: command.order.clone(), cause: command.cause.clone() };
        let record = self.record(&Caller::zones(), monitor, &what, "ordered");
        drop(self.audit().note(record.about(&act)));
    }
}

/// Why a zone needs this monitor, if one does.
fn wanted(zones: &Zones, state: &State, monitor: usize) -> Option<Asked> {
    let of = zones.index.zones_of(monitor).iter().map(|zone| &state.zones[*zone]);
    let of = of.filter(|it| !it.mode.is_test());
    of.filter_map(|it| match it.phase {
        phase if phase.is_pending() => Some(Asked::Votes),
        Phase::Released { wet: true, .. } => Some(Asked::Released),
        _ => None,
    })
    .max_by_key(|it| *it == Asked::Released)
}

/// The requests that end water: valves, and the program that aims.
pub fn closing(station: &Station) -> Vec<Result<MonitorRequest, ApiError>> {
    let valves = station.status().valves_to_close();
    let mut requests: Vec<_> = valves.into_iter().map(MonitorRequest::close).collect();
    requests.push(MonitorRequest::stop(SubsystemId::CONTROL));
    requests
}

/// An order that opens or turns, while it is carried out.
struct Opening {
    hub: Hub,
    station: Arc<Station>,
    aim: Aim,
    /// Where the fire is, if that is known.
    fire: Option<Target>,
    /// With water.
    opens: bool,
    /// Its number among the orders of the line.
    latest: Arc<AtomicU64>,
    number: u64,
    /// Set when the monitor has accepted to aim.
    accepted: Arc<AtomicBool>,
    /// Time of the hub after which it is not started any more.
    not_after: Option<Duration>,
}

impl Opening {
    async fn run(self) {
        let caller = Caller::zones();
        if self.hub.change_authority(&caller, &self.station, "take", None).is_err() {
            // A person holds it: the machine hears so.
            return;
        }
        let accepted = match (self.opens, self.is_deployed()) {
            (true, _) => self.insist(self.aim.quench(self.fire), self.in_time()).await,
            (false, false) => {
                let deploy = Request::new(SubsystemId::DEPLOYER, Body::Deploy);
                self.insist(MonitorRequest::new(&deploy), self.in_time()).await
            }
            (false, true) => true,
        };
        if !accepted {
            return;
        }
        self.accepted.store(true, Ordering::SeqCst);
        let goes_on = self.goes_on();
        while !self.is_deployed() {
            if !goes_on() {
                return;
            }
            sleep(LOOK).await;
        }
        if self.opens {
            self.insist(self.aim.open(), goes_on).await;
            return;
        }
        for request in self.aim.turn(self.fire) {
            if !self.insist(request, goes_on.clone()).await {
                return;
            }
        }
    }

    /// Sends a request until it is accepted, or the order is void; whether it was accepted.
    async fn insist(&self, request: Result<MonitorRequest, ApiError>, valid: Valid) -> bool {
        let Ok(request) = request else { return false };
        while valid() {
            let (caller, request) = (Caller::zones(), request.clone());
            let sent = self.hub.command_while(&caller, &self.station, request, valid.clone()).await;
            match sent {
                Ok(outcome) if outcome.ok => return true,
                Ok(_) => {}
                Err(error) => {
                    let monitor = self.station.id();
                    tracing::warn!(monitor, code = error.code, "an order of the zones");
                    // A person has the monitor now.
                    if error.code == "no_authority" {
                        return false;
                    }
                }
            }
            sleep(AGAIN).await;
        }
        false
    }

    /// While it may be started.
    fn in_time(&self) -> Valid {
        let (hub, not_after) = (self.hub.clone(), self.not_after);
        self.while_latest(move || not_after.is_none_or(|until| hub.now() <= until))
    }

    /// While what was started may go on: the monitor answers, and the time is not over.
    fn goes_on(&self) -> Valid {
        let (hub, station) = (self.hub.clone(), self.station.clone());
        let until = hub.now() + GOES_ON;
        self.while_latest(move || hub.now() <= until && station.health() == "up")
    }

    fn while_latest(&self, more: impl Fn() -> bool + Send + Sync + 'static) -> Valid {
        let (latest, number) = (self.latest.clone(), self.number);
        Arc::new(move || latest.load(Ordering::SeqCst) == number && more())
    }

    fn is_deployed(&self) -> bool {
        let status = self.station.status();
        let has = status.bits(SubsystemId::DEPLOYER).is_some();
        !has || status.is_set(SubsystemId::DEPLOYER, "Deployed")
    }
}

#[cfg(test)]
mod tests {
    use lafet_site::{Authority, Event, Hand, Valve};

    use super::super::hall::hall;
    use super::*;

    #[tokio::test]
    async fn an_order_that_is_void_is_not_sent() {
        let (hub, station) = Hub::of_one(None);
        for (is_valid, code) in [(false, "void"), (true, "not_connected")] {
            let request = MonitorRequest::parse("Open Valve1").unwrap();
            let valid: Valid = Arc::new(move || is_valid);
            let sent = hub.command_while(&Caller::hub(), &station, request, valid).await;
            assert_eq!(sent.unwrap_err().code, code);
        }
    }

    #[tokio::test]
    async fn the_zone_controller_commands_nothing_that_it_does_not_hold() {
        let (hub, station) = Hub::of_one(None);
        let open = || MonitorRequest::parse("Open Valve1").unwrap();
        let refused = hub.command(&Caller::zones(), &station, open(), None).await;
        assert_eq!(refused.unwrap_err().code, "no_authority");
        hub.change_authority(&Caller::zones(), &station, "take", None).unwrap();
        let sent = hub.command(&Caller::zones(), &station, open(), None).await;
        assert_eq!(sent.unwrap_err().code, "not_connected");
    }

    /// The machine orders M1 to give water to the hall.
    fn engages() -> Command {
        let (monitor, zone) = ("M1".into(), "hall".into());
        let order = Order::Engage { monitor, zone, water_max_ms: None };
        Command { number: 7, at_ms: 0, not_after_ms: None, order, cause: Vec::new() }
    }

    /// What waits for the audit log is asked then whether it is the latest.
    #[tokio::test]
    async fn an_order_by_the_same_command_makes_the_one_before_void() {
        let (hub, command) = (hall(), engages());
        let zones = hub.zones().unwrap();
        let mut machine = zones.machine();
        hub.carry_order(zones, &mut machine, &command);
        let latest = machine.lines["M1"].latest.number.clone();
        let first = latest.load(Ordering::SeqCst);
        hub.carry_order(zones, &mut machine, &command);
        assert_ne!(latest.load(Ordering::SeqCst), first);
        let close = Order::Close { monitor: "M1".into() };
        let second = latest.load(Ordering::SeqCst);
        hub.carry_order(zones, &mut machine, &Command { order: close, ..command });
        assert_ne!(latest.load(Ordering::SeqCst), second);
        assert!(machine.lines["M1"].engaged.is_none());
    }

    fn number(machine: &Machine, monitor: &str) -> u64 {
        machine.lines[monitor].latest.number.load(Ordering::SeqCst)
    }

    /// A button of its post is pressed while M1 is about to open: the machine orders nothing then.
    #[tokio::test]
    async fn an_order_is_void_when_a_person_has_taken_its_monitor() {
        let hub = hall();
        hub.order_zones(&Caller::hub(), Hand::Release { zone: "hall".into() }).unwrap();
        let zones = hub.zones().unwrap();
        let mut machine = zones.machine();
        let before = ["M1", "M2"].map(|id| number(&machine, id));
        assert!(machine.lines.values().all(|line| line.engaged.is_some()));
        let state = machine.site.state();
        hub.end_turning(zones, &mut machine, &state);
        assert_eq!(["M1", "M2"].map(|id| number(&machine, id)), before, "they go on");
        let (valve, authority) = (Valve::Closed, Authority::Person);
        let report = MonitorReport { reachable: true, valve, authority, ..Default::default() };
        let event = Event::Monitor { monitor: "M1".into(), report };
        hub.take(zones, &mut machine, &Caller::zones(), &event);
        let state = machine.site.state();
        hub.end_turning(zones, &mut machine, &state);
        assert_ne!(number(&machine, "M1"), before[0], "it is void");
        assert_eq!(number(&machine, "M2"), before[1], "it goes on");
        let line = &machine.lines["M1"];
        assert!(line.engaged.is_none() && line.order.is_none() && line.task.is_none());
    }

    #[tokio::test]
    async fn a_monitor_does_not_turn_on_when_it_is_withheld_nor_open_for_no_zone() {
        let hub = hall();
        let zones = hub.zones().unwrap();
        let mut machine = zones.machine();
        let mut state = machine.site.state();
        state.zones[0].phase = Phase::Countdown;
        let prepare = Order::Prepare { monitor: "M1".into(), zone: "hall".into() };
        let prepare = Command { order: prepare, ..engages() };
        let taken = [Withheld::Person, Withheld::Lockout, Withheld::Refused].map(Some);
        for withheld in taken.into_iter().chain([None, Some(Withheld::Unreachable)]) {
            hub.carry_order(zones, &mut machine, &prepare);
            let before = number(&machine, "M1");
            state.monitors[0].withheld = withheld;
            hub.end_turning(zones, &mut machine, &state);
            let is_void = number(&machine, "M1") != before;
            assert_eq!(is_void, taken.contains(&withheld), "{withheld:?}");
        }
        state.monitors[0].withheld = None;
        for (engaged_for, is_void) in [(Some("hall".to_owned()), false), (None, true)] {
            hub.carry_order(zones, &mut machine, &engages());
            let before = number(&machine, "M1");
            state.monitors[0].engaged_for = engaged_for;
            hub.end_turning(zones, &mut machine, &state);
            assert_eq!(number(&machine, "M1") != before, is_void);
        }
    }

    #[tokio::test]
    async fn a_no_makes_orders_void_before_it_waits_for_the_machine() {
        let hub = hall();
        let latest = hub.zones().unwrap().machine().lines["M1"].latest.number.clone();
        let before = latest.load(Ordering::SeqCst);
        let busy = hub.clone();
        let refuse = {
            let machine = busy.zones().unwrap().machine();
            let hub = hub.clone();
            let refuse = tokio::task::spawn_blocking(move || {
                let station = hub.station("M1").unwrap();
                let stop = MonitorRequest::stop(SubsystemId::ALL).unwrap();
                let anna = Caller { via: "http", ..Caller::hub() };
                hub.refuse_for_zones(&anna, &station, &stop, true);
            });
            let began = std::time::Instant::now();
            while latest.load(Ordering::SeqCst) == before {
                assert!(began.elapsed() < Duration::from_secs(10), "it waits for the lock");
                std::thread::yield_now();
            }
            drop(machine);
            refuse
        };
        refuse.await.unwrap();
    }
}
