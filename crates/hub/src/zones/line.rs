//! What the hub knows of a monitor, as the machine gets it.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_proto::SubsystemId;
use lafet_proto::flags::{self, Button, ButtonState, ButtonsFlags, Severity};
use lafet_site::{Authority, Command, Event, Hand, MonitorReport, Scope, Valve};
use tokio::task::AbortHandle;

use super::index::Beside;
use super::{Machine, ZONES, Zones};
use crate::config::Aim;
use crate::control::authority::Now;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::monitor::status::Status;
use crate::sync::lock;

/// A state of before this time does not confirm that a valve is closed.
const CONFIRMS: Duration = Duration::from_millis(900);
/// A person who has pressed a button of the post keeps the monitor for this time.
const POST_KEEPS: Duration = Duration::from_secs(30);
/// So many monitors report to the machine before others get its lock.
const CHANGES_MAX: usize = 16;
/// Posts of a monitor.
const POSTS: [SubsystemId; 2] = [SubsystemId::BUTTONS, SubsystemId::EXT_BUTTONS];
/// Subsystems without which a monitor neither aims nor opens.
const NEEDED: [SubsystemId; 7] = [
    SubsystemId::GENERAL,
    SubsystemId::HORIZONTAL,
    SubsystemId::VERTICAL,
    SubsystemId::NOZZLE,
    SubsystemId::DEPLOYER,
    SubsystemId::VALVE1,
    SubsystemId::CONTROL,
];

/// A monitor of the zones.
#[derive(Debug, Default)]
pub struct Line {
    /// Its latest order.
    pub latest: Latest,
    /// What carries out an order that opens or turns.
    pub task: Option<AbortHandle>,
    /// The zone for which it was ordered to give water.
    pub engaged: Option<String>,
    /// The order to give water, and its number.
    ordered: Option<(Command, u64)>,
    /// How its last order aims.
    pub order: Option<Aiming>,
    /// Its holder was asked for it: for votes, or for a release that followed.
    pub asked: Option<Asked>,
    /// The last report.
    pub(super) report: Option<MonitorReport>,
    /// Time of the state as the monitor reported it, and when it was first seen here.
    state: (Option<u64>, Now),
    /// When a button of its post was last seen pressed.
    pressed: Option<Now>,
    /// Its Close button is pressed.
    closes: bool,
    /// What its state said when it was looked at last.
    seen: Option<Sight>,
}

/// What a state says for an order with this outlet.
#[derive(Debug)]
struct Sight {
    of: Arc<Status>,
    outlet: Option<SubsystemId>,
    seen: Seen,
}

/// What the flags of a state say.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// A button of a post is pressed; Close is.
    pressed: bool,
    closes: bool,
    lockout: bool,
    valve: Valve,
    extinguishing: bool,
    failure: bool,
}

/// For what the holder of a monitor was asked to give it up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// Votes are enough: water is about to come.
    Votes,
    /// Its zone is released.
    Released,
}

/// The latest order of a monitor, for who says no without waiting for the machine.
#[derive(Clone, Debug, Default)]
pub struct Latest {
    /// Counts the orders: those before the latest one are void, and all are that a person's no has met.
    pub number: Arc<AtomicU64>,
    /// The zone to which it was ordered to give water.
    pub works_for: Arc<Mutex<Option<String>>>,
}

/// How an order aims.
#[derive(Clone, Debug)]
pub struct Aiming {
    /// The fire, by its number in the plan of the zone; none: as configured.
    pub fire: Option<u64>,
    /// The monitor has accepted it.
    pub accepted: Arc<AtomicBool>,
}

impl Line {
    /// The fire that it was ordered to.
    pub fn at(&self) -> Option<u64> {
        self.order.as_ref()?.fire
    }

    /// Makes all orders so far void; returns the number of the one that may follow.
    pub fn void(&mut self) -> u64 {
        if let Some(task) = self.task.take() {
            task.abort();
        }
        self.latest.number.fetch_add(1, Ordering::SeqCst) + 1
    }

    /// It was ordered to give water to this zone, by an order of this number.
    pub fn engage(&mut self, zone: &str, command: &Command, number: u64) {
        *lock(&self.latest.works_for) = Some(zone.to_owned());
        self.engaged = Some(zone.to_owned());
        self.ordered = Some((command.clone(), number));
    }

    /// The order to give water that was made void, if none has followed.
    pub fn voided(&self) -> Option<&Command> {
        let (command, number) = self.ordered.as_ref()?;
        (self.latest.number.load(Ordering::SeqCst) != *number).then_some(command)
    }

    /// It is not used any more.
    pub fn clear(&mut self) {
        *lock(&self.latest.works_for) = None;
        (self.engaged, self.order, self.ordered) = (None, None, None);
    }

    /// Whether the clients see it at this fire of the plan: at work only at the one that it has accepted.
    pub fn shows(&self, fire: u64) -> bool {
        let order = self.order.as_ref().filter(|_| self.engaged.is_some());
        order.is_none_or(|it| it.fire == Some(fire) && it.accepted.load(Ordering::SeqCst))
    }
}

impl Hub {
    /// Reports to the machine what has changed of the monitors; whether there is more. Each report takes the machine
    /// its time, and a line that is lost may change all of them at once: what waits for the lock gets it in between.
    pub(super) fn look_at_lines(&self, zones: &Zones, machine: &mut Machine) -> bool {
        let (now, caller) = (self.now(), Caller::zones());
        let configured = &zones.config.site;
        let mut news = self.news_of_lines(zones, machine, now);
        let more = limit(&mut news, &mut machine.next_line);
        for (at, report, _) in &news {
            if let Some(line) = machine.lines.get_mut(&configured.monitors[*at]) {
                line.report = report.or(line.report);
            }
        }
        // Who takes the place of a lost one has to know its fire.
        let changed = news.iter().filter(|it| it.1.is_some()).map(|it| it.0);
        self.plan_again(zones, machine, changed);
        for (at, report, closes) in news {
            let monitor = &configured.monitors[at];
            if closes {
                let order = Hand::Close(Scope::Monitor(monitor.clone()));
                let by = format!("buttons of {monitor}");
                self.take(zones, machine, &caller, &Event::Hand { by, order });
            }
            if let Some(report) = report {
                let event = Event::Monitor { monitor: monitor.clone(), report };
                let of = zones.index.zones_of(at).iter();
                let of = of.map(|zone| configured.zones[*zone].id.clone()).collect();
                self.report(zones, machine, &caller, event, of);
            }
        }
        more
    }

    /// Monitors of which something has changed, in their configured order.
    fn news_of_lines(&self, zones: &Zones, machine: &mut Machine, now: Now) -> Vec<News> {
        let stations = self.all_stations();
        let mut stations = Beside::new(&stations);
        let mut news = Vec::new();
        for ((monitor, line), at) in machine.lines.iter_mut().zip(zones.index.by_id()) {
            let (report, closes) = match stations.of(monitor) {
                Some(station) => {
                    let aim = line.engaged.clone().map(|zone| (zone, monitor.clone()));
                    let outlet = aim.and_then(|it| zones.config.aims.get(&it)).map(Aim::outlet);
                    line.look(now, station, outlet)
                }
                None => (line.lost(), false),
            };
            let changed = line.report != Some(report);
            if changed || closes {
                news.push((at, changed.then_some(report), closes));
            }
        }
        news.sort_unstable_by_key(|it| it.0);
        news
    }
}

/// The position of a monitor, what it reports now if that has changed, and whether Close was pressed at its post.
type News = (usize, Option<MonitorReport>, bool);

/// Leaves so much that the machine takes at once, from this monitor on and around; whether that was not all. Close
/// is never left for later.
fn limit(news: &mut Vec<News>, next: &mut usize) -> bool {
    let all = news.len();
    if all <= CHANGES_MAX {
        return false;
    }
    let first = news.partition_point(|it| it.0 < *next);
    news.rotate_left(first);
    let mut reports = 0;
    news.retain(|(at, _, closes)| {
        let taken = *closes || reports < CHANGES_MAX;
        if taken && !closes {
            (reports, *next) = (reports + 1, at + 1);
        }
        taken
    });
    news.len() < all
}

impl Line {
    /// The last report.
    pub const fn report(&self) -> Option<&MonitorReport> {
        self.report.as_ref()
    }

    /// What is known when there is no such monitor any more.
    fn lost(&self) -> MonitorReport {
        MonitorReport { reachable: false, ..self.report.unwrap_or_default() }
    }

    /// What the monitor reports now, and whether a person has just pressed Close at its post. `outlet`: the
    /// valve of the water of its order.
    fn look(
        &mut self,
        now: Now,
        station: &Station,
        outlet: Option<SubsystemId>,
    ) -> (MonitorReport, bool) {
        let status = station.status();
        if self.state.0 != status.at_ms {
            self.state = (status.at_ms, now);
        }
        if !station.is_up() || status.stale || status.at_ms.is_none() {
            return (self.lost(), false);
        }
        let seen = self.see(&status, outlet);
        if seen.pressed {
            self.pressed = Some(now);
        }
        let news = seen.closes && !std::mem::replace(&mut self.closes, seen.closes);
        self.closes = seen.closes;
        let fresh = now.saturating_sub(self.state.1) < CONFIRMS;
        let valve = if seen.valve == Valve::Closed && !fresh { Valve::Unknown } else { seen.valve };
        let report = MonitorReport {
            reachable: true,
            authority: self.authority(now, station),
            lockout: seen.lockout,
            valve,
            extinguishing: seen.extinguishing,
            failure: seen.failure,
        };
        (report, news)
    }

    /// What the flags of a state say: most states have those of the one before.
    fn see(&mut self, status: &Arc<Status>, outlet: Option<SubsystemId>) -> Seen {
        let before = self.seen.as_mut().filter(|it| it.outlet == outlet);
        if let Some(Sight { of, seen, .. }) = before
            && (Arc::ptr_eq(of, status) || of.has_flags_of(status))
        {
            of.clone_from(status);
            return *seen;
        }
        let seen = Seen::of(status, outlet);
        self.seen = Some(Sight { of: status.clone(), outlet, seen });
        seen
    }

    fn authority(&self, now: Now, station: &Station) -> Authority {
        if self.pressed.is_some_and(|at| now.saturating_sub(at) < POST_KEEPS) {
            return Authority::Person;
        }
        match lock(&station.authority).holder() {
            None => Authority::Free,
            Some((seat, _)) if seat.seat == ZONES => Authority::Site,
            Some(_) => Authority::Person,
        }
    }
}

impl Seen {
    fn of(status: &Status, outlet: Option<SubsystemId>) -> Self {
        let pressed = |button| POSTS.iter().any(|post| is_pressed(status, *post, button));
        let valve = valve(status, outlet);
        let runs = status.is_set(SubsystemId::CONTROL, "Quench")
            || status.is_set(SubsystemId::CONTROL, "Trajectory");
        Self {
            pressed: Button::ALL.into_iter().any(pressed),
            closes: pressed(Button::Close),
            lockout: status.is_set(SubsystemId::GENERAL, "LockedOut"),
            valve,
            // A program whose valve stays closed gives no water: the monitor does not act.
            extinguishing: runs && may_flow(status, outlet, valve),
            failure: NEEDED.iter().any(|id| has_failed(status, *id)),
        }
    }
}

fn is_pressed(status: &Status, post: SubsystemId, button: Button) -> bool {
    let flags = status.bits(post).map(ButtonsFlags::from_bits_retain);
    flags.is_some_and(|flags| flags.button(button) == ButtonState::Pressed)
}

fn has_failed(status: &Status, id: SubsystemId) -> bool {
    let severity = status.bits(id).map(|bits| flags::flags_of(id).severity(bits));
    severity.is_some_and(|severity| severity >= Severity::Alarm)
}

/// The valves of a monitor as one: closed if all are. It gives water if one is open; while it is ordered
/// to give water, only if the valve of that order, `outlet`, is.
fn valve(status: &Status, outlet: Option<SubsystemId>) -> Valve {
    let all = status.valves();
    if !all.is_empty() && all.iter().all(|it| one(status, *it) == Valve::Closed) {
        return Valve::Closed;
    }
    let counts = all.into_iter().filter(|it| outlet.is_none_or(|outlet| outlet == *it));
    let counts: Vec<Valve> = counts.map(|it| one(status, it)).collect();
    let any = |wanted| counts.contains(&wanted).then_some(wanted);
    let best = any(Valve::Open).or(any(Valve::Opening)).or(any(Valve::Moving));
    best.unwrap_or(Valve::Unknown)
}

fn one(status: &Status, id: SubsystemId) -> Valve {
    let is = |flag| status.is_set(id, flag);
    if is("Opening") {
        Valve::Opening
    } else if is("Closing") {
        Valve::Moving
    } else if is("Open") {
        Valve::Open
    } else if is("CloseSensorFault") {
        // Also of one that says Closed: its word does not count.
        Valve::Unknown
    } else if is("Closed") {
        Valve::Closed
    } else if is("OpenSensorFault") {
        Valve::Unknown
    } else {
        Valve::Moving
    }
}

/// Whether a program that runs may give water: its valve is not closed. While water is ordered, a valve of
/// which nothing is known gives none.
fn may_flow(status: &Status, outlet: Option<SubsystemId>, seen: Valve) -> bool {
    match outlet {
        None => seen != Valve::Closed,
        Some(outlet) => status.bits(outlet).is_some() && one(status, outlet) != Valve::Closed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::status::Subsystem;

    fn status(flags: &[(&'static str, &str)]) -> Status {
        let mut status = Status { at_ms: Some(1), ..Status::default() };
        for (name, flag) in flags {
            let id = SubsystemId::from_name(name).unwrap();
            let bits = match *flag {
                "" => 0,
                "close pressed" => {
                    ButtonsFlags::empty().with_button(Button::Close, ButtonState::Pressed).bits()
                }
                flag => flags::flags_of(id).by_name(flag).unwrap().mask(),
            };
            let mut subsystem = Subsystem::default();
            let before = status.bits(id).unwrap_or_default();
            subsystem.set_bits(id, before | bits);
            status.subsystems.insert(*name, Arc::new(subsystem));
        }
        status
    }

    #[test]
    fn what_changes_at_once_is_taken_in_parts_and_close_with_the_first() {
        let report = Some(MonitorReport::default());
        let changed = |from: usize| (from..40).map(|at| (at, report, at == 30)).collect::<Vec<_>>();
        let mut next = 0;
        let mut taken = |news: &mut Vec<News>| {
            let more = limit(news, &mut next);
            (news.iter().map(|it| it.0).collect::<Vec<_>>(), more)
        };
        assert_eq!(taken(&mut changed(0)), ((0..16).chain([30]).collect(), true));
        // The first ones change all the time.
        let without_close = |news: Vec<News>| news.into_iter().map(|it| (it.0, it.1, false));
        let mut news: Vec<News> = without_close(changed(0)).collect();
        assert_eq!(taken(&mut news), ((16..32).collect(), true));
        let mut news: Vec<News> = without_close(changed(0)).collect();
        assert_eq!(taken(&mut news), ((32..40).chain(0..8).collect(), true));
        assert_eq!(taken(&mut changed(24)), ((24..40).collect(), false));
    }

    #[test]
    fn valves_are_closed_only_if_all_of_them_say_so() {
        for (first, second, expected) in [
            ("Closed", "Closed", Valve::Closed),
            ("Closed", "Open", Valve::Open),
            ("Closed", "Closing", Valve::Moving),
            ("Closed", "Opening", Valve::Opening),
            ("Closing", "Opening", Valve::Opening),
            ("Closed", "", Valve::Moving),
            ("CloseSensorFault", "Closed", Valve::Unknown),
            ("CloseSensorFault", "Open", Valve::Open),
        ] {
            let found = valve(&status(&[("Valve1", first), ("Valve2", second)]), None);
            assert_eq!(found, expected, "{first} {second}");
        }
        assert_eq!(valve(&status(&[]), None), Valve::Unknown);
    }

    /// Its sensor may say Closed with water running.
    #[test]
    fn a_valve_whose_sensor_is_at_fault_is_not_closed() {
        let both = status(&[("Valve1", "Closed"), ("Valve1", "CloseSensorFault")]);
        assert_eq!(valve(&both, None), Valve::Unknown);
        assert_eq!(valve(&both, Some(SubsystemId::VALVE1)), Valve::Unknown);
        assert!(both.flows(), "as for everything else");
    }

    #[test]
    fn an_order_for_water_is_met_by_its_own_valve_alone() {
        let (water, foam) = (SubsystemId::VALVE1, SubsystemId::VALVE2);
        for (first, second, of_water, of_any) in [
            ("Closed", "Open", Valve::Unknown, Valve::Open),
            ("Open", "Closed", Valve::Open, Valve::Open),
            ("Opening", "Open", Valve::Opening, Valve::Open),
            ("Closed", "Closed", Valve::Closed, Valve::Closed),
            ("CloseSensorFault", "Open", Valve::Unknown, Valve::Open),
        ] {
            let status = status(&[("Valve1", first), ("Valve2", second)]);
            let found = (valve(&status, Some(water)), valve(&status, None));
            assert_eq!(found, (of_water, of_any), "{first} {second}");
            let flows = may_flow(&status, Some(water), found.0);
            assert_eq!(flows, first != "Closed", "{first} {second}");
        }
        let foam_only = status(&[("Valve2", "Open")]);
        assert_eq!(valve(&foam_only, Some(water)), Valve::Unknown);
        assert_eq!(valve(&foam_only, Some(foam)), Valve::Open);
        assert!(!may_flow(&foam_only, Some(water), Valve::Unknown), "none that is known");
    }

    #[test]
    fn faults_of_what_is_needed_are_failures_and_buttons_are_seen() {
        let failed = |name, flag| {
            let status = status(&[(name, flag)]);
            NEEDED.iter().any(|id| has_failed(&status, *id))
        };
        assert!(failed("Vertical", "MotorBroken") && failed("Valve1", "AmperageOverload"));
        assert!(!failed("Detector", "Found") && !failed("Vertical", "Move"));
        let pressed = status(&[("ExtButtons", "close pressed")]);
        assert!(is_pressed(&pressed, SubsystemId::EXT_BUTTONS, Button::Close));
        assert!(!is_pressed(&pressed, SubsystemId::EXT_BUTTONS, Button::Open));
        assert!(!is_pressed(&pressed, SubsystemId::BUTTONS, Button::Close));
    }
}
