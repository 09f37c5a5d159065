//! Who says no: a person, a contact, a keep-out.
//!
//! A no makes void what waits to be sent before it waits for the machine itself. What the machine keeps for
//! another zone all the same is ordered again once no no is under way.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use lafet_proto::{RequestId, SubsystemId};
use lafet_site::config::{ContactKind, Mode};
use lafet_site::{Cause, Command, Entry, Event, Hand, PathFault, Record, Scope, Why};
use tokio::time::Instant;

use super::{Machine, ZONES, Zones};
use crate::clock::ms;
use crate::command::request::MonitorRequest;
use crate::command::series::Said;
use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::sync::lock;

/// Who closes a monitor whose water goes into a keep-out.
const KEEP_OUTS: &str = "keep-outs";

/// What says no now.
#[derive(Debug, Default)]
pub(super) struct Nos {
    /// Nos that have made orders void and are not with the machine yet.
    under_way: Arc<AtomicUsize>,
    /// The contacts that are pressed: one that is held says no once.
    pressed: Mutex<BTreeMap<String, bool>>,
    /// When the latest came for each zone, and for the site.
    latest: Mutex<BTreeMap<Option<String>, Instant>>,
}

/// A no on its way to the machine.
#[derive(Debug)]
#[must_use]
pub(super) struct No(Arc<AtomicUsize>);

impl Drop for No {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Zones {
    fn begin_no(&self) -> No {
        self.nos.under_way.fetch_add(1, Ordering::SeqCst);
        No(self.nos.under_way.clone())
    }

    /// Makes every order void that opens or turns a monitor of this scope and is not sent yet. A monitor
    /// that gives water to another zone is not of the scope.
    fn void(&self, scope: &Scope) {
        let site = &self.config.site;
        let of = |zone: &String| site.zones.iter().find(|it| it.id == *zone);
        let place = match scope {
            Scope::Site => Some(None),
            // A name that a stranger invents has no place.
            Scope::Zone(zone) => of(zone).map(|it| Some(it.id.clone())),
            Scope::Monitor(_) => None,
        };
        if let Some(place) = place {
            lock(&self.nos.latest).insert(place, Instant::now());
        }
        for (id, latest) in &self.latest {
            let meant = match scope {
                Scope::Site => true,
                Scope::Zone(zone) => {
                    let serves = of(zone).is_some_and(|it| it.monitors.contains(id));
                    serves && lock(&latest.works_for).as_ref().is_none_or(|works| works == zone)
                }
                Scope::Monitor(monitor) => monitor == id,
            };
            if meant {
                latest.number.fetch_add(1, Ordering::SeqCst);
            }
        }
    }

    /// Whether a no has come since that undoes an order of a person: for its zone or the site, and any if the order is
    /// for the whole site.
    pub fn is_undone_since(&self, order: &Hand, since: Instant) -> bool {
        // What ends or holds back is undone by no other no.
        if matches!(
            order,
            Hand::Pump { on: false, .. }
                | Hand::Hold { on: true, .. }
                | Hand::Mode { mode: Mode::Off | Mode::Manual, .. }
        ) {
            return false;
        }
        let zone = match order {
            Hand::Mode { zone, .. }
            | Hand::Hold { zone, .. }
            | Hand::Release { zone }
            | Hand::Reset(Scope::Zone(zone)) => Some(zone),
            _ => None,
        };
        let meant =
            |place: &Option<String>| zone.is_none() || place.is_none() || place.as_ref() == zone;
        lock(&self.nos.latest).iter().any(|(place, at)| meant(place) && *at >= since)
    }

    /// A person's no makes void what waits to be sent, before it waits for the lock itself.
    pub(super) fn void_by_hand(&self, order: &Hand) -> No {
        let no = self.begin_no();
        match order {
            Hand::Stop(scope) | Hand::Close(scope) => self.void(scope),
            Hand::Abort { zone } => self.void(&Scope::Zone(zone.clone())),
            Hand::Lockout { on: true } => self.void(&Scope::Site),
            _ => {}
        }
        no
    }

    /// The same for a contact that begins to say no: it is reported again as long as it is held.
    fn void_by_contact(&self, input: &str, pressed: bool) -> No {
        let no = self.begin_no();
        let before = lock(&self.nos.pressed).insert(input.to_owned(), pressed);
        let begins = pressed && before != Some(true);
        let all = self.config.site.contacts.iter().filter(|it| begins && it.id == input);
        for contact in all {
            match contact.kind {
                ContactKind::Abort | ContactKind::Stop if !contact.zones.is_empty() => {
                    contact.zones.iter().for_each(|zone| self.void(&Scope::Zone(zone.clone())));
                }
                ContactKind::Abort | ContactKind::Stop | ContactKind::Lockout => {
                    self.void(&Scope::Site);
                }
                _ => {}
            }
        }
        no
    }
}

impl Hub {
    /// Takes a contact as it is, or the fault of its path.
    pub(crate) fn contact_reports(
        &self,
        caller: &Caller,
        input: &str,
        pressed: bool,
        fault: Option<PathFault>,
    ) {
        let Some(zones) = self.zones() else { return };
        let no = zones.void_by_contact(input, pressed);
        let mut machine = zones.machine();
        let path = Event::Path { path: input.to_owned(), fault };
        let contact = Event::Contact { input: input.to_owned(), pressed };
        let mut contacts = zones.config.site.contacts.iter().filter(|it| it.id == input);
        let refuses = contacts.any(|it| it.kind.acts_at_once());
        let events = match fault {
            None => vec![path, contact],
            // What says no is heard on a path at fault too.
            Some(_) if pressed && refuses => vec![contact, path],
            Some(_) => vec![path],
        };
        for event in &events {
            self.take(zones, &mut machine, caller, event);
        }
        self.no_is_over(zones, &mut machine, no);
    }

    /// A Stop, Close or Lockout of a person is a no for its monitor. Stop of a drive ends a motion by
    /// hand and is none; nor is Stop by the client that holds the monitor and works with it.
    pub fn refuse_for_zones(
        &self,
        caller: &Caller,
        station: &Station,
        request: &MonitorRequest,
        news: bool,
    ) {
        let Some(zones) = self.zones_of(station) else { return };
        if matches!(caller.via, "hub" | ZONES) {
            return;
        }
        let scope = Scope::Monitor(station.id().to_owned());
        let holds = || {
            let authority = lock(&station.authority);
            authority.holder().is_some_and(|(seat, _)| seat.seat == caller.seat.seat)
        };
        // Closing the foam valve by hand is no word about the water.
        let mut aims = zones.config.aims.values().filter(|aim| aim.monitor == station.id());
        let outlet = aims.any(|aim| aim.outlet() == request.to());
        let whole = outlet || matches!(request.to(), SubsystemId::ALL | SubsystemId::CONTROL);
        let order = match request.id() {
            RequestId::CLOSE if outlet => Hand::Close(scope),
            RequestId::LOCKOUT => Hand::Stop(scope),
            RequestId::STOP if whole && !holds() => Hand::Stop(scope),
            _ => return,
        };
        self.refuse(zones, caller, order, news);
    }

    /// Water of a monitor that goes into a keep-out is shut off, and stays so until a person opens it or
    /// resets the monitor.
    pub fn refuse_by_keep_outs(&self, station: &Station, news: bool) {
        let Some(zones) = self.zones_of(station) else { return };
        let mut caller = Caller::hub();
        caller.principal.user = KEEP_OUTS.into();
        let order = Hand::Close(Scope::Monitor(station.id().to_owned()));
        self.refuse(zones, &caller, order, news);
    }

    /// Whether a client says the no that it has just said. Any other order ends the series.
    pub(super) fn is_repeated_no(&self, caller: &Caller, order: &Hand) -> bool {
        let (said, scope, why) = match order {
            Hand::Abort { zone } => {
                (Said::Abort(zone.clone()), Scope::Zone(zone.clone()), Why::Abort)
            }
            Hand::Lockout { on: true } => (Said::Lockout, Scope::Site, Why::Lockout),
            _ => {
                self.urgent_series().end(self);
                return false;
            }
        };
        let noted = |by: &Caller| {
            let entry = Entry::No { scope: scope.clone(), why };
            let cause = vec![Cause::Hand { by: caller.principal.user.clone() }];
            let no = Record { number: 0, at_ms: ms(self.now()), entry, cause };
            self.record_of(by, &no, "repeated")
        };
        !self.urgent_series().take(self, caller, said, noted)
    }

    /// Gives a no that is repeated to the machine. It is carried out, and noted if more comes of it than that it was said
    /// while it lasts.
    pub(super) fn take_again(
        &self,
        zones: &Zones,
        machine: &mut Machine,
        caller: &Caller,
        event: &Event,
    ) -> Vec<Record> {
        let lasted = match event {
            Event::Hand { order: Hand::Abort { zone }, .. } => {
                machine.site.is_refused(&Scope::Zone(zone.clone()))
            }
            _ => machine.site.is_locked(),
        };
        let mut reaction = self.handle(zones, machine, event);
        let said = |it: &Record| matches!(it.entry, Entry::No { .. } | Entry::Lockout { .. });
        if lasted && reaction.records.iter().all(said) {
            reaction.records.clear();
        }
        self.carry(zones, machine, caller, reaction)
    }

    /// The zones, if a monitor is one of theirs.
    fn zones_of(&self, station: &Station) -> Option<&Zones> {
        self.zones().filter(|it| it.config.site.monitors.iter().any(|id| id == station.id()))
    }

    /// Stop or Lockout of every monitor is a no for the whole site.
    pub fn refuse_everywhere(&self, caller: &Caller, news: bool) {
        if let Some(zones) = self.zones() {
            self.refuse(zones, caller, Hand::Stop(Scope::Site), news);
        }
    }

    /// The machine has taken a no. What it keeps although an order for it was made void is ordered again,
    /// by the last no that is under way.
    pub(super) fn no_is_over(&self, zones: &Zones, machine: &mut Machine, no: No) {
        drop(no);
        if zones.nos.under_way.load(Ordering::SeqCst) > 0 {
            return;
        }
        if machine.lines.values().all(|line| line.voided().is_none()) {
            return;
        }
        let state = machine.site.state();
        let kept = |(id, line): (&String, &super::Line)| -> Option<Command> {
            let command = line.voided()?;
            let of = state.monitors.iter().find(|it| it.monitor == *id)?;
            let works = of.engaged_for.is_some() && of.engaged_for == line.engaged;
            (works && !of.closing && of.withheld.is_none()).then(|| command.clone())
        };
        let again: Vec<Command> = machine.lines.iter().filter_map(kept).collect();
        again.iter().for_each(|command| self.carry_order(zones, machine, command));
    }
}

#[cfg(test)]
mod tests {
    use lafet_site::Order;
    use serde_json::Value;

    use super::super::hall::configured;
    use super::*;
    use crate::Clock;

    /// Two zones that share a monitor; each has its abort contact.
    fn shared() -> Hub {
        let mut text = String::from(
            "[[monitor]]\nid = \"M1\"\nurl = \"tcp://127.0.0.1:1?addr=1\"\n\
             [[modbus]]\nname = \"panel\"\nurl = \"tcp://127.0.0.1:2\"\n",
        );
        for (bit, zone) in ["hall", "store"].iter().enumerate() {
            text += &format!(
                "[[detector]]\nid = \"flame-{zone}\"\nkind = \"flame\"\nzones = [\"{zone}\"]\n\
                 [[aim]]\nzone = \"{zone}\"\nmonitor = \"M1\"\nhorizontal = 600\nvertical = 300\n\
                 nozzle = 60\n\
                 [[zone]]\nid = \"{zone}\"\nvotes = \"1oo1\"\none_detector_releases = true\n\
                 water_max_s = 60\nmonitors = [\"M1\"]\n\
                 [[input]]\nid = \"abort-{zone}\"\nkind = \"abort\"\nzones = [\"{zone}\"]\n\
                 source = {{ modbus = \"panel\", unit = 1, on = \"discrete:{bit}\" }}\n"
            );
        }
        Hub::new(configured(&text), Clock::System, Value::Null).unwrap()
    }

    fn number(hub: &Hub) -> usize {
        let latest = &hub.zones().unwrap().latest["M1"].number;
        usize::try_from(latest.load(Ordering::SeqCst)).unwrap()
    }

    /// The machine orders the monitor to give water to a zone.
    fn engage(hub: &Hub, zone: &str) {
        let order = Order::Engage { monitor: "M1".into(), zone: zone.into(), water_max_ms: None };
        let command = Command { number: 1, at_ms: 0, not_after_ms: None, order, cause: Vec::new() };
        let zones = hub.zones().unwrap();
        hub.carry_order(zones, &mut zones.machine(), &command);
    }

    #[tokio::test]
    async fn the_no_of_one_zone_leaves_the_orders_of_another_alone() {
        let hub = shared();
        engage(&hub, "store");
        let before = number(&hub);
        let zones = hub.zones().unwrap();
        drop(zones.void_by_hand(&Hand::Abort { zone: "hall".into() }));
        drop(zones.void_by_hand(&Hand::Stop(Scope::Zone("hall".into()))));
        drop(zones.void_by_contact("abort-hall", true));
        assert_eq!(number(&hub), before, "it works for the other zone");
        drop(zones.void_by_hand(&Hand::Abort { zone: "store".into() }));
        assert_eq!(number(&hub), before + 1);
        drop(zones.void_by_hand(&Hand::Stop(Scope::Site)));
        drop(zones.void_by_hand(&Hand::Close(Scope::Monitor("M1".into()))));
        assert_eq!(number(&hub), before + 3);
    }

    /// It is reported again each second.
    #[tokio::test]
    async fn a_contact_that_is_held_says_no_once() {
        let hub = shared();
        let before = number(&hub);
        let report = |pressed| hub.contact_reports(&Caller::hub(), "abort-hall", pressed, None);
        for _ in 0..10 {
            report(true);
        }
        let held = number(&hub);
        assert!(held > before, "it was heard");
        report(true);
        assert_eq!(number(&hub), held);
        report(false);
        report(true);
        assert!(number(&hub) > held, "it was pressed again");
    }

    #[tokio::test]
    async fn what_says_no_is_heard_on_a_path_at_fault() {
        let release = |hub: &Hub| {
            let order = Hand::Release { zone: "hall".into() };
            hub.order_zones(&Caller::hub(), order).map(drop).map_err(|error| error.text.en)
        };
        let report = |hub: &Hub, pressed| {
            hub.contact_reports(&Caller::hub(), "abort-hall", pressed, Some(PathFault::Lost));
        };
        let hub = shared();
        report(&hub, false);
        assert_eq!(release(&hub), Ok(()), "that it is not pressed is no no");
        let hub = shared();
        report(&hub, true);
        let pressed = lafet_site::Refusal::AbortPressed.text().en;
        assert_eq!(release(&hub), Err(pressed.clone()));
        // Whether it was released is not known.
        report(&hub, false);
        assert_eq!(release(&hub), Err(pressed));
    }
}
