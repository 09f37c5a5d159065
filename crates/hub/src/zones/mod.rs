//! The zone controller of the installation, [`lafet_site::Site`], run for real.
//!
//! ```text
//!  reports, hands ─▶ take ───┐                    ┌─▶ orders: monitors, under a session of its own
//!  a person's Stop ─▶ refuse ─┼─▶ Site ─▶ Reaction ─┼─▶ notes: audit log, events
//!  each 50 ms ─▶ turn ───────┘                    └─▶ stored, published
//! ```
//!
//! The machine is behind one lock. What is reported, and a no, is carried out in the same call, if the machine is
//! free; how clients wait for it is in `waiting`. One task looks at the monitors and steps the machine at its
//! deadlines; another one stores what has to survive.

mod assign;
pub mod fires;
mod gone;
#[cfg(test)]
mod hall;
mod index;
mod line;
mod locating;
mod no;
mod notes;
pub mod orders;
mod planning;
mod served;
mod stored;
pub mod view;
mod waiting;

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use lafet_site::config::{Problem, Zone};
use lafet_site::{
    Event, Hand, PathFault, Persisted, Phase, Reaction, Record, Site, State, ZoneState,
};
use tokio::sync::{Notify, watch};
use tokio::time::{sleep, timeout};

use crate::clock::ms;
use crate::config::{Config, ZonesConfig};
use crate::control::authority::Now;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};
use crate::store::StoreError;
use crate::sync::lock_aside;
use crate::text::Both;
#[cfg(test)]
pub(crate) use hall::configured;
use index::Index;
use line::Line;
use stored::Stored;
use view::Reported;
use waiting::Waiting;

/// User, session and way of the zone controller in the audit log and in authorities.
pub const ZONES: &str = "zones";
/// Topic of what belongs to each zone.
const CONFIGURED: &str = "zones/configured";
/// The monitors are looked at this often.
const LOOK: Duration = Duration::from_millis(50);
/// A state in which a time runs is published this often, and news not more often than this.
const PUBLISH: Duration = Duration::from_secs(1);
const PUBLISH_NEWS: Duration = Duration::from_millis(100);
/// Without a turn for so long the machine is not at work.
const WORKS: Duration = Duration::from_secs(2);
/// What is left of times is stored this often.
const STORE: Duration = Duration::from_secs(5);
/// An answer waits so long for the disk, as a command does for the audit log.
const STORED: Duration = Duration::from_millis(50);
/// Pause before what the disk did not take is tried again.
const AGAIN: Duration = Duration::from_secs(1);
/// A wind counts for so long after it was reported.
const WIND_COUNTS: Duration = Duration::from_secs(600);
/// What was not stored before the hub ends is waited for so long.
const FAREWELL: Duration = Duration::from_secs(2);

/// The zones of a hub.
#[derive(Debug)]
pub struct Zones {
    config: ZonesConfig,
    index: Index,
    machine: Mutex<Machine>,
    /// Counts the orders of each monitor, outside the lock: a no does not wait for it.
    latest: BTreeMap<String, line::Latest>,
    /// What says no now.
    nos: no::Nos,
    waiting: Waiting,
    stored: Stored,
    /// Held while fires are located or a plan is computed.
    planning: Mutex<()>,
    /// A deadline may have changed.
    wake: Notify,
    /// What survives has changed.
    changed: Notify,
    /// Changes so far that have to survive, and those that are on the disk.
    wanted: AtomicU64,
    kept: watch::Sender<u64>,
    /// The disk takes nothing.
    failing: AtomicBool,
    /// The machine was last looked at, ms of the hub.
    turned_ms: AtomicU64,
}

/// The machine, and what the hub keeps for it.
#[derive(Debug)]
struct Machine {
    site: Site,
    lines: BTreeMap<String, Line>,
    /// Holds by zone: until when each counts unless it is renewed.
    holds: BTreeMap<String, Now>,
    /// When a Close (false) or Stop (true) for each monitor was noted, since what was ordered else.
    ordered: BTreeMap<(String, bool), Now>,
    /// The latest report of each detector.
    reported: BTreeMap<String, Reported>,
    /// Where the fires of each zone are, by the bearings of its detectors, and how far these were looked at.
    fires: BTreeMap<String, Vec<fires::FirePlace>>,
    locating: BTreeMap<String, locating::Locating>,
    /// Who is on which of them.
    plans: BTreeMap<String, assign::Plan>,
    /// The wind as it was reported last.
    wind: Option<view::WindReported>,
    /// That was said to be long ago.
    wind_is_old: bool,
    /// When those that were known were computed again: bearings age.
    located: Now,
    /// The order of monitors that the machine was given for each zone, and those that votes may open.
    preferred: BTreeMap<String, (Vec<String>, Option<Vec<String>>)>,
    /// What waits for a plan.
    held: VecDeque<planning::Held>,
    /// What the start has recorded, until the hub is there to note it.
    first: Option<(Reaction, Vec<Both>)>,
    looked: Now,
    /// More has changed than the machine took then; the monitor from which it goes on.
    hurries: bool,
    next_line: usize,
    published: Now,
    /// Something has happened since it was published.
    news: bool,
}

impl Zones {
    /// The zones that are configured, with what was stored of them.
    pub fn open(config: &Config) -> Result<Option<Self>, StoreError> {
        let Some((mut zones, stored, persisted)) = gone::open(config)? else { return Ok(None) };
        let mut said = Vec::new();
        if let Some(stored) = &persisted {
            said.extend(notes::of_stored(&zones.site, stored));
            said.extend(gone::watch(&mut zones, config, stored));
        }
        let (site, first) =
            Site::new(zones.site.clone(), 0, persisted.as_ref()).map_err(|problems| {
                StoreError::Zones(Both::each(|lang| {
                    let text = |it: &Problem| {
                        format!("{}: {} {}", it.place, it.what.of(lang), it.remedy.of(lang))
                    };
                    problems.iter().map(text).collect::<Vec<_>>().join(" ")
                }))
            })?;
        let lines = zones.site.monitors.iter().map(|id| (id.clone(), Line::default()));
        let lines: BTreeMap<String, Line> = lines.collect();
        let latest = lines.iter().map(|(id, line)| (id.clone(), line.latest.clone())).collect();
        let nos = no::Nos::default();
        let machine = Machine {
            site,
            lines,
            holds: BTreeMap::new(),
            ordered: BTreeMap::new(),
            reported: BTreeMap::new(),
            fires: BTreeMap::new(),
            locating: BTreeMap::new(),
            plans: BTreeMap::new(),
            wind: None,
            wind_is_old: false,
            located: Now::ZERO,
            preferred: BTreeMap::new(),
            held: VecDeque::new(),
            first: Some((first, said)),
            looked: Now::ZERO,
            hurries: false,
            next_line: 0,
            published: Now::ZERO,
            news: true,
        };
        let machine = Mutex::new(machine);
        let (wake, changed) = (Notify::new(), Notify::new());
        let (wanted, kept) = (AtomicU64::new(0), watch::Sender::new(0));
        let turned_ms = AtomicU64::new(0);
        let planning = Mutex::new(());
        let index = Index::new(&zones.site);
        Ok(Some(Self {
            config: zones,
            index,
            machine,
            latest,
            nos,
            waiting: Waiting::default(),
            stored,
            planning,
            wake,
            changed,
            wanted,
            kept,
            failing: AtomicBool::new(false),
            turned_ms,
        }))
    }

    /// The machine. Fires are located and plans computed without it.
    fn machine(&self) -> MutexGuard<'_, Machine> {
        lock_aside(&self.machine)
    }

    fn is_failing(&self) -> bool {
        self.failing.load(Ordering::SeqCst)
    }

    fn persisted(&self) -> Persisted {
        self.machine().site.persisted()
    }
}

/// Steps the machine until the hub ends.
pub async fn run(hub: Hub) {
    let Some(zones) = hub.zones() else { return };
    let mut shutdown = hub.shutdown();
    loop {
        let (pause, hurries) = hub.turn(zones);
        tokio::select! {
            () = sleep(pause) => {}
            // The pause is for those that wait for the lock.
            () = zones.wake.notified(), if !hurries => {}
            () = shutdown.requested() => break,
        }
    }
    hub.carry_nos(zones, &mut zones.machine(), true);
}

/// Stores what has to survive until the hub ends.
pub async fn store(hub: Hub) {
    let Some(zones) = hub.zones() else { return };
    let mut last = None;
    let mut shutdown = hub.shutdown();
    loop {
        // Before the state: what is counted is in it.
        let wanted = zones.wanted.load(Ordering::SeqCst);
        let now = zones.persisted();
        if last.as_ref() != Some(&now) {
            let written = zones.stored.write(&now).await;
            let failing = written.is_err();
            if zones.failing.swap(failing, Ordering::SeqCst) != failing {
                zones.machine().news = true;
                hub.event(None, &notes::storing(failing));
            }
            match written {
                Ok(()) => last = Some(now.clone()),
                Err(error) => tracing::error!(%error, "the state of the zones is not stored"),
            }
        }
        if last.as_ref() == Some(&now) {
            zones.kept.send_replace(wanted);
        }
        let failing = zones.is_failing();
        tokio::select! {
            () = sleep(if failing { AGAIN } else { STORE }) => {}
            () = zones.changed.notified(), if !failing => {}
            () = shutdown.requested() => break,
        }
    }
    _ = timeout(FAREWELL, zones.stored.write(&zones.persisted())).await;
}

impl Hub {
    /// The zones, for a request that needs them.
    ///
    /// # Errors
    ///
    /// 404 without zones in the configuration.
    pub fn known_zones(&self) -> Result<&Zones, ApiError> {
        self.zones().ok_or_else(ApiError::no_zones)
    }

    /// The zones as they are.
    ///
    /// # Errors
    ///
    /// 404 without zones in the configuration.
    pub fn zones_view(&self) -> Result<view::ZonesView, ApiError> {
        let zones = self.known_zones()?;
        Ok(zones.machine().view(self.now(), !zones.is_failing()))
    }

    /// What belongs to each zone.
    ///
    /// # Errors
    ///
    /// 404 without zones in the configuration.
    pub fn zones_configured(&self) -> Result<view::ZonesConfigured, ApiError> {
        Ok(view::ZonesConfigured::from(&self.known_zones()?.config))
    }

    /// What a detector senses.
    ///
    /// # Errors
    ///
    /// 404 without zones, or without such a detector in the configuration.
    pub fn detector_kind(&self, id: &str) -> Result<lafet_site::config::Kind, ApiError> {
        let detectors = &self.known_zones()?.config.site.detectors;
        let found = detectors.iter().find(|it| it.id == id);
        found.map(|it| it.kind).ok_or_else(|| ApiError::no_detector(id))
    }

    /// Carries out a person's order.
    ///
    /// # Errors
    ///
    /// 404 without zones or for a name that is not configured, 409 with the reason of the machine.
    pub fn order_zones(&self, caller: &Caller, order: Hand) -> Result<view::ZonesView, ApiError> {
        let zones = self.known_zones()?;
        let no = zones.void_by_hand(&order);
        let first = !self.is_repeated_no(caller, &order);
        let mut machine = zones.machine();
        self.carry_nos(zones, &mut machine, true);
        let done = self.carry_hand(zones, &mut machine, caller, &order, first);
        self.no_is_over(zones, &mut machine, no);
        done.map(|()| machine.view(self.now(), !zones.is_failing()))
    }

    /// Whether what was ordered so far is on the disk, or gets there soon.
    pub async fn zones_are_stored(&self) -> bool {
        let Some(zones) = self.zones() else { return true };
        let wanted = zones.wanted.load(Ordering::SeqCst);
        let patience = if zones.is_failing() { Duration::ZERO } else { STORED };
        let mut kept = zones.kept.subscribe();
        timeout(patience, kept.wait_for(|it| *it >= wanted)).await.is_ok_and(|it| it.is_ok())
    }

    /// Whether the disk takes nothing of the zones.
    pub fn zones_fail_to_be_stored(&self) -> bool {
        self.zones().is_some_and(Zones::is_failing)
    }

    /// Takes the report of a detector.
    pub(crate) fn detector_reports(
        &self,
        caller: &Caller,
        detector: &str,
        reported: Reported,
    ) -> Result<(), ApiError> {
        let zones = self.known_zones()?;
        let event = Event::Detector {
            detector: detector.to_owned(),
            signal: reported.signal,
            condition: reported.condition,
        };
        let mut machine = zones.machine();
        machine.reported.insert(detector.to_owned(), reported);
        // What follows from this report aims at what it shows.
        let detectors = &zones.config.site.detectors;
        let of = detectors.iter().find(|it| it.id == detector).map(|it| &it.zones[..]);
        let placed = zones.config.stations.contains_key(detector);
        let sees = |zone: &&Zone| placed && of.unwrap_or_default().contains(&zone.id);
        for zone in zones.config.site.zones.iter().filter(sees) {
            self.locate_fires(zones, &mut machine, zone);
        }
        let of = of.unwrap_or_default().to_vec();
        self.report(zones, &mut machine, caller, event, of);
        Ok(())
    }

    /// Takes the wind of the site; within a second monitors are assigned by it.
    ///
    /// # Errors
    ///
    /// 404 without zones in the configuration.
    pub(crate) fn wind_reports(&self, wind: view::WindReported) -> Result<(), ApiError> {
        let mut machine = self.known_zones()?.machine();
        (machine.wind, machine.wind_is_old) = (Some(wind), false);
        machine.news = true;
        Ok(())
    }

    /// Takes what is read of an output or a pump, or the fault of its path; `None`: no news.
    pub(crate) fn output_reports(
        &self,
        caller: &Caller,
        id: &str,
        is_pump: bool,
        on: Option<bool>,
        fault: Option<Option<PathFault>>,
    ) {
        let Some(zones) = self.zones() else { return };
        let mut machine = zones.machine();
        let path = fault.map(|fault| Event::Path { path: id.to_owned(), fault });
        let state = on.map(|on| match is_pump {
            true => Event::Pump { pump: id.to_owned(), on },
            false => Event::Output { output: id.to_owned(), on },
        });
        for event in path.iter().chain(&state) {
            self.take(zones, &mut machine, caller, event);
        }
    }

    /// Whether the zone controller, if there is one, is at work.
    pub fn zones_work(&self) -> bool {
        let turned = |zones: &Zones| {
            let turned = Duration::from_millis(zones.turned_ms.load(Ordering::Relaxed));
            self.now().saturating_sub(turned) < WORKS
        };
        self.zones().is_none_or(turned)
    }

    /// Gives an event to the machine and carries out what follows from it.
    fn take(
        &self,
        zones: &Zones,
        machine: &mut Machine,
        caller: &Caller,
        event: &Event,
    ) -> Vec<Record> {
        let reaction = self.handle(zones, machine, event);
        machine.news = true;
        self.carry(zones, machine, caller, reaction)
    }

    /// Gives an event to the machine; its deadlines may have changed.
    fn handle(&self, zones: &Zones, machine: &mut Machine, event: &Event) -> Reaction {
        zones.wake.notify_one();
        machine.site.handle(ms(self.now()), event)
    }

    /// Carries out a reaction: what closes first, then what is noted of it.
    fn carry(
        &self,
        zones: &Zones,
        machine: &mut Machine,
        caller: &Caller,
        reaction: Reaction,
    ) -> Vec<Record> {
        let Reaction { commands, records, persist } = reaction;
        for command in &commands {
            self.carry_order(zones, machine, command);
        }
        commands.iter().for_each(|command| self.note_order(machine, command));
        records.iter().for_each(|record| self.note_entry(caller, record));
        machine.news |= !commands.is_empty() || !records.is_empty();
        if persist {
            zones.wanted.fetch_add(1, Ordering::SeqCst);
            zones.changed.notify_one();
        }
        records
    }

    /// Looks at the monitors, lets time pass, publishes; returns how long nothing is due, and whether more was to be
    /// done than was done.
    fn turn(&self, zones: &Zones) -> (Duration, bool) {
        let (pause, hurries, view) = {
            let mut machine = zones.machine();
            let (pause, view) = self.turn_machine(zones, &mut machine);
            (pause, machine.hurries, view)
        };
        // A view of many monitors takes its time.
        if let Some(view) = view {
            self.topics().set(ZONES, &view);
        }
        (pause, hurries)
    }

    fn turn_machine(
        &self,
        zones: &Zones,
        machine: &mut Machine,
    ) -> (Duration, Option<view::ZonesView>) {
        let caller = Caller::zones();
        if let Some((first, said)) = machine.first.take() {
            said.iter().for_each(|text| self.event(None, text));
            self.topics().set(CONFIGURED, &view::ZonesConfigured::from(&zones.config));
            self.carry(zones, machine, &caller, first);
        }
        let now = self.now();
        let looks = machine.hurries || now >= machine.looked + LOOK;
        self.carry_nos(zones, machine, looks);
        if looks {
            machine.looked = now;
            machine.hurries = self.look_at_lines(zones, machine);
            self.end_holds(zones, machine, now);
            self.end_wind(machine, now);
            self.look_at_fires(zones, machine, now);
        }
        let reaction = machine.site.step(ms(self.now()));
        self.carry(zones, machine, &caller, reaction);
        if looks {
            let state = machine.site.state();
            self.end_turning(zones, machine, &state);
            self.give_back(zones, machine, &state);
            self.ask_holders(zones, machine, &state);
        }
        let view = machine.due_view(now, !zones.is_failing());
        zones.turned_ms.store(ms(now), Ordering::Relaxed);
        let due = machine.site.next_deadline().map(Duration::from_millis);
        let due = due.map_or(LOOK, |due| due.saturating_sub(self.now()));
        let due = if machine.hurries { Duration::ZERO } else { due };
        // A millisecond is the grain of the machine.
        (due.clamp(Duration::from_millis(1), LOOK), view)
    }

    /// Plans what is due. Bearings age: once a second fires that are known are located again.
    fn look_at_fires(&self, zones: &Zones, machine: &mut Machine, now: Now) {
        for zone in &zones.config.site.zones {
            if machine.plans.get(&zone.id).is_some_and(|plan| plan.is_due(now)) {
                self.plan_fires(zones, machine, zone);
            }
        }
        self.release_held(zones, machine);
        if now < machine.located + AGAIN {
            return;
        }
        machine.located = now;
        for zone in &zones.config.site.zones {
            if machine.fires.get(&zone.id).is_some_and(|fires| !fires.is_empty()) {
                self.locate_fires(zones, machine, zone);
            } else {
                self.plan_fires(zones, machine, zone);
            }
        }
    }

    /// A hold that its holder has not renewed is over.
    fn end_holds(&self, zones: &Zones, machine: &mut Machine, now: Now) {
        let over = |until: &Now| *until <= now;
        let gone: Vec<String> =
            machine.holds.iter().filter(|it| over(it.1)).map(|it| it.0.clone()).collect();
        for zone in gone {
            machine.holds.remove(&zone);
            let event = Event::Hand { by: ZONES.into(), order: Hand::Hold { zone, on: false } };
            self.take(zones, machine, &Caller::zones(), &event);
        }
    }

    /// A wind that is not reported any more is not shown as the wind; monitors are assigned by it still.
    fn end_wind(&self, machine: &mut Machine, now: Now) {
        let over =
            machine.wind.as_ref().is_some_and(|it| now.saturating_sub(it.heard) >= WIND_COUNTS);
        if over && !std::mem::replace(&mut machine.wind_is_old, over) {
            machine.news = true;
            self.event(None, &notes::no_wind(WIND_COUNTS));
        }
    }
}

impl Machine {
    /// What is to be published now, if anything.
    fn due_view(&mut self, now: Now, stored: bool) -> Option<view::ZonesView> {
        let pause = if self.news { PUBLISH_NEWS } else { PUBLISH };
        if now < self.published + pause {
            return None;
        }
        self.published = now;
        let view = self.view(now, stored);
        let runs = runs(&view.state);
        (std::mem::take(&mut self.news) || runs).then_some(view)
    }
}

/// A time runs in this state, towards its end or as the age of a trouble.
fn runs(state: &State) -> bool {
    let zone = |it: &ZoneState| it.phase != Phase::Quiet || it.returns_in_ms.is_some();
    let found = state.monitors.iter().any(|it| it.found_left_ms.is_some());
    found || !state.troubles.is_empty() || state.zones.iter().any(zone)
}

/// Asked right before an order is sent.
type Valid = Arc<dyn Fn() -> bool + Send + Sync>;

#[cfg(test)]
#[path = "turn_tests.rs"]
mod tests;
