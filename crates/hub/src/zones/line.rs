//! What the hub knows of a monitor, as the machine gets it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use lafet_proto::SubsystemId;
use lafet_proto::flags::{self, Button, ButtonState, ButtonsFlags, Severity};
use lafet_site::{Authority, Event, Hand, MonitorReport, Scope, Valve};
use tokio::task::AbortHandle;

use super::{Machine, ZONES, Zones};
use crate::control::authority::Now;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::monitor::status::Status;
use crate::sync::lock;

/// A state of before this time does not confirm that a valve is closed.
const CONFIRMS: Duration = Duration::from_millis(900);
/// A person who has pressed a button of the post keeps the monitor for this time.
const POST_KEEPS: Duration = Duration::from_secs(30);
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
    /// Counts the orders: those before the latest one are void, and all are that a person's no has met.
    pub latest: Arc<AtomicU64>,
    /// What carries out an order that opens or turns.
    pub task: Option<AbortHandle>,
    /// The zone for which it was ordered to give water.
    pub engaged: Option<String>,
    /// How its last order aims.
    pub order: Option<Aiming>,
    /// The last report.
    pub(super) report: Option<MonitorReport>,
    /// Time of the state as the monitor reported it, and when it was first seen here.
    state: (Option<u64>, Now),
    /// When a button of its post was last seen pressed.
    pressed: Option<Now>,
    /// Its Close button is pressed.
    closes: bool,
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
        self.latest.fetch_add(1, Ordering::SeqCst) + 1
    }

    /// It is not used any more.
    pub fn clear(&mut self) {
        (self.engaged, self.order) = (None, None);
    }

    /// Whether the clients see it at this fire of the plan: at work only at the one that it has accepted.
    pub fn shows(&self, fire: u64) -> bool {
        let order = self.order.as_ref().filter(|_| self.engaged.is_some());
        order.is_none_or(|it| it.fire == Some(fire) && it.accepted.load(Ordering::SeqCst))
    }
}

impl Hub {
    /// Reports to the machine what has changed of the monitors.
    pub(super) fn look_at_lines(&self, zones: &Zones, machine: &mut Machine) {
        let (now, caller) = (self.now(), Caller::zones());
        let mut news = Vec::new();
        for monitor in &zones.config.site.monitors {
            let Some(line) = machine.lines.get_mut(monitor) else { continue };
            let (report, closes) = match self.station(monitor) {
                Ok(station) => line.look(now, &station),
                Err(_) => (line.lost(), false),
            };
            let changed = line.report.replace(report) != Some(report);
            if changed || closes {
                news.push((monitor, changed.then_some(report), closes));
            }
        }
        // Who takes the place of a lost one has to know its fire.
        let changed: Vec<&String> =
            news.iter().filter(|it| it.1.is_some()).map(|it| it.0).collect();
        self.plan_again(zones, machine, &changed);
        for (monitor, report, closes) in news {
            if closes {
                let order = Hand::Close(Scope::Monitor(monitor.clone()));
                let by = format!("buttons of {monitor}");
                self.take(zones, machine, &caller, &Event::Hand { by, order });
            }
            if let Some(report) = report {
                let event = Event::Monitor { monitor: monitor.clone(), report };
                let serves = zones.config.site.zones.iter();
                let of = serves.filter(|it| it.monitors.contains(monitor)).map(|it| it.id.clone());
                self.report(zones, machine, &caller, event, of.collect());
            }
        }
    }
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

    /// What the monitor reports now, and whether a person has just pressed Close at its post.
    fn look(&mut self, now: Now, station: &Station) -> (MonitorReport, bool) {
        let status = station.status();
        if self.state.0 != status.at_ms {
            self.state = (status.at_ms, now);
        }
        if !station.is_up() || status.stale || status.at_ms.is_none() {
            return (self.lost(), false);
        }
        let pressed = |button| POSTS.iter().any(|post| is_pressed(&status, *post, button));
        let closes = pressed(Button::Close);
        if Button::ALL.into_iter().any(pressed) {
            self.pressed = Some(now);
        }
        let news = closes && !std::mem::replace(&mut self.closes, closes);
        self.closes = closes;
        let fresh = now.saturating_sub(self.state.1) < CONFIRMS;
        let seen = valve(&status);
        let valve = if seen == Valve::Closed && !fresh { Valve::Unknown } else { seen };
        let runs = status.is_set(SubsystemId::CONTROL, "Quench")
            || status.is_set(SubsystemId::CONTROL, "Trajectory");
        let report = MonitorReport {
            reachable: true,
            authority: self.authority(now, station),
            lockout: status.is_set(SubsystemId::GENERAL, "LockedOut"),
            valve,
            // A program whose valve stays closed gives no water: the monitor does not act.
            extinguishing: runs && seen != Valve::Closed,
            failure: NEEDED.iter().any(|id| has_failed(&status, *id)),
        };
        (report, news)
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

fn is_pressed(status: &Status, post: SubsystemId, button: Button) -> bool {
    let flags = status.bits(post).map(ButtonsFlags::from_bits_retain);
    flags.is_some_and(|flags| flags.button(button) == ButtonState::Pressed)
}

fn has_failed(status: &Status, id: SubsystemId) -> bool {
    let severity = status.bits(id).map(|bits| flags::flags_of(id).severity(bits));
    severity.is_some_and(|severity| severity >= Severity::Alarm)
}

/// The valves of a monitor as one: open if one is, closed if all are.
fn valve(status: &Status) -> Valve {
    let one = |id: SubsystemId| {
        let is = |flag| status.is_set(id, flag);
        if is("Opening") || is("Closing") {
            Valve::Moving
        } else if is("Open") {
            Valve::Open
        } else if is("Closed") {
            Valve::Closed
        } else if is("OpenSensorFault") || is("CloseSensorFault") {
            Valve::Unknown
        } else {
            Valve::Moving
        }
    };
    let valves: Vec<Valve> = status.valves().into_iter().map(one).collect();
    let any = |wanted| valves.contains(&wanted).then_some(wanted);
    let closed = (!valves.is_empty() && valves.iter().all(|it| *it == Valve::Closed))
        .then_some(Valve::Closed);
    any(Valve::Open).or(any(Valve::Moving)).or(closed).unwrap_or(Valve::Unknown)
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
            subsystem.set_bits(id, bits);
            status.subsystems.insert(*name, Arc::new(subsystem));
        }
        status
    }

    #[test]
    fn valves_are_closed_only_if_all_of_them_say_so() {
        for (first, second, expected) in [
            ("Closed", "Closed", Valve::Closed),
            ("Closed", "Open", Valve::Open),
            ("Closed", "Closing", Valve::Moving),
            ("Closed", "", Valve::Moving),
            ("CloseSensorFault", "Closed", Valve::Unknown),
            ("CloseSensorFault", "Open", Valve::Open),
        ] {
            let found = valve(&status(&[("Valve1", first), ("Valve2", second)]));
            assert_eq!(found, expected, "{first} {second}");
        }
        assert_eq!(valve(&status(&[])), Valve::Unknown);
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
