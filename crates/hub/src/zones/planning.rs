//! Plans are computed on a thread of their own, without the lock: a no, a hold and a deadline never wait for one.
//!
//! ```text
//!  something has changed ─▶ Job, what is known now ─▶ Chosen ─▶ does that still hold? ─▶ the plan
//!                             reports of its zone wait, WAITS at most ─────────────────▶ the machine
//! ```
//!
//! The fires that they are for are located before, on the same thread ([`super::locating`]). A vote or the loss of a
//! monitor that is reported meanwhile reaches the machine after the plan: what follows from it aims by the plan.
//! Everything else does not wait: a vote that is withdrawn, a hand, a contact, a time.

use std::collections::BTreeMap;
use std::time::Duration;

use lafet_place::Problem;
use lafet_place::planner::{
    Assignment, Fire, Level, Situation, Task, Turned, filled, offers, renewed,
};
use lafet_place::site::Direction;
use lafet_place::supply::Supply;
use lafet_place::wrapped;
use lafet_proto::SubsystemId;
use lafet_site::config::Zone;
use lafet_site::{Authority, Condition, Event, MonitorReport, Signal};

use super::assign::{Basis, Known, Plan};
use super::fires::FirePlace;
use super::line::Line;
use super::locating::Locating;
use super::{Machine, Zones, notes};
use crate::control::authority::Now;
use crate::hub::{Caller, Hub};
use crate::site::Place;
use crate::site::keep_out::Span;
use crate::site::planned::{Built, USUAL_MPA, planned};
use crate::sync::lock;
use crate::text::Both;

/// What a fire is taken to be: its size is not measured.
const AREA_M2: f64 = 30.0;
const DENSITY_LPM_M2: f64 = 20.0;
/// Most monitors of a zone that are planned together: each pair takes about a millisecond.
const MONITORS_MAX: usize = 16;
/// A report waits for a plan for so long at most, and so many do: a zone that was planned just now is planned again a second
/// later, and that takes its time.
const WAITS: Duration = Duration::from_secs(3);
const HELD_MAX: usize = 1024;
/// A plan, or where a fire is, that is not there after so long is not waited for any more.
pub(super) const LOST: Duration = Duration::from_secs(10);

/// What a plan is computed from.
#[derive(Debug)]
pub struct Job {
    zone: String,
    number: u64,
    basis: Basis,
    fires: Vec<Known>,
    able: Vec<(String, Place, Built)>,
    water: Vec<Water>,
    before: Assignment,
    jets: usize,
    /// Monitors of the zone that are not planned with, and all of them.
    others: Vec<String>,
    monitors: Vec<String>,
}

/// What a monitor does already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Water {
    /// The fire where its water stays, by its index.
    stays: Option<usize>,
    flows: bool,
}

/// A plan that was computed.
#[derive(Debug)]
pub struct Chosen {
    job: Job,
    /// The fire of each monitor, by its number.
    by: BTreeMap<String, u64>,
    /// Those that votes may open; none: the water is not known.
    opens: Option<Vec<String>>,
    /// Its monitors, those that are used first in front.
    order: Vec<String>,
    /// Why nothing could be planned.
    failed: Option<Both>,
}

/// A report that waits for a plan.
#[derive(Debug)]
pub struct Held {
    since: Now,
    caller: Caller,
    event: Event,
    /// Its zones, and the report of each up to which fires have to be located.
    zones: Vec<(String, u64)>,
}

impl Hub {
    /// What there is to plan with for a zone, so that it can be computed without the lock.
    pub(super) fn job(
        &self,
        zones: &Zones,
        machine: &Machine,
        zone: &Zone,
        (plan, basis, mut able): (&Plan, Basis, Vec<(String, Place, Built)>),
    ) -> Job {
        let nearest = |place: &Place| {
            let ways = plan.counted().map(|it| it.place.distance_m(place));
            ways.fold(f64::INFINITY, f64::min)
        };
        able.sort_by(|a, b| nearest(&a.1).total_cmp(&nearest(&b.1)));
        able.truncate(MONITORS_MAX);
        for (id, _, built) in &mut able {
            let aim = zones.config.aims.get(&(zone.id.clone(), id.clone()));
            let narrowest = lafet_ballistics::NARROWEST_MM;
            built.nozzle_mm = aim.map_or(narrowest, |aim| aim.nozzle.into()).clamp(0, narrowest);
        }
        let fires: Vec<Known> = plan.counted().cloned().collect();
        let water = water(machine, &fires, &able);
        let before = able.iter().map(|(id, ..)| {
            let at = machine.lines.get(id).and_then(Line::at);
            plan.by.get(id).copied().or(at).and_then(|number| index(&fires, number))
        });
        let before = before.collect();
        let jets = zone.jets.map_or(usize::MAX, usize::from);
        let others = zone.monitors.iter().filter(|id| able.iter().all(|it| it.0 != **id));
        let others = others.cloned().collect();
        let (monitors, number) = (zone.monitors.clone(), plan.computed);
        let zone = zone.id.clone();
        Job { zone, number, basis, fires, able, water, before, jets, others, monitors }
    }

    /// Computes a plan, one at a time, and takes it.
    pub(super) fn compute(&self, job: Job) {
        let hub = self.clone();
        tokio::task::spawn_blocking(move || {
            let Some(zones) = hub.zones() else { return };
            let chosen = {
                let _one = lock(&zones.planning);
                if !is_latest(&zones.machine(), &job) {
                    return;
                }
                hub.chosen(job)
            };
            hub.accept(zones, &mut zones.machine(), chosen);
        });
    }

    /// Takes a plan if what it was computed from still holds; else there is another one to be computed.
    pub(super) fn accept(&self, zones: &Zones, machine: &mut Machine, chosen: Chosen) {
        let Chosen { job, by, opens, order, failed } = chosen;
        let Some(zone) = zones.config.site.zones.iter().find(|it| it.id == job.zone) else {
            return;
        };
        let Some(plan) = machine.plans.get(&zone.id) else { return };
        if plan.computing.is_none() || plan.computed != job.number {
            return;
        }
        let able = self.able(zones, machine, &machine.site.state(), zone);
        let now = self.basis(machine, plan, &able);
        // What changes all the time would keep each plan from being taken.
        let is_like = job.basis.is_like(&now) || (plan.again && job.basis.is_for_the_same(&now));
        let holds = is_like && job.water == water(machine, &job.fires, &job.able);
        let Some(plan) = machine.plans.get_mut(&zone.id) else { return };
        plan.computing = None;
        if plan.failed != failed {
            self.event(None, &notes::planning(&zone.id, failed.as_ref()));
            plan.failed = failed;
        }
        if holds {
            (plan.by, plan.opens, plan.basis, plan.again) = (by, opens, Some(job.basis), false);
            self.prefer(zones, machine, zone, order);
        } else {
            // Once at once; what changes all the time waits for its turn.
            plan.basis = None;
            plan.waits = true;
            if !std::mem::replace(&mut plan.again, true) {
                plan.planned = None;
            }
            self.plan_fires(zones, machine, zone);
        }
        self.release_held(zones, machine);
    }

    /// Gives the machine the order of the monitors of a zone, and those that votes may open.
    pub(super) fn prefer(
        &self,
        zones: &Zones,
        machine: &mut Machine,
        zone: &Zone,
        monitors: Vec<String>,
    ) {
        machine.news = true;
        let opens = machine.plans.get(&zone.id).and_then(|plan| plan.opens.clone());
        let new = (monitors, opens);
        if machine.preferred.get(&zone.id) == Some(&new) {
            return;
        }
        machine.preferred.insert(zone.id.clone(), new.clone());
        let (monitors, opens) = new;
        let event = Event::Prefer { zone: zone.id.clone(), monitors, opens };
        self.take(zones, machine, &Caller::zones(), &event);
    }

    /// Gives the machine what was reported; while fires that it shows are located, or the plan of one of its zones is
    /// computed, after that.
    pub(super) fn report(
        &self,
        zones: &Zones,
        machine: &mut Machine,
        caller: &Caller,
        event: Event,
        of: Vec<String>,
    ) {
        // What was reported before goes first.
        self.release_held(zones, machine);
        let of = machine.up_to_now(of);
        if !may_wait(&event) || !machine.is_planning(&of) {
            self.take_held(zones, machine, |_, it| subject(&it.event) == subject(&event));
            self.take(zones, machine, caller, &event);
            return;
        }
        if machine.held.len() >= HELD_MAX {
            self.take_held(zones, machine, |_, _| true);
        }
        let held = Held { since: self.now(), caller: caller.clone(), event, zones: of };
        machine.held.push_back(held);
    }

    /// Gives the machine the reports whose plan is there, or is not there in time.
    pub(super) fn release_held(&self, zones: &Zones, machine: &mut Machine) {
        let now = self.now();
        machine.locating.values_mut().for_each(|it| it.end_lost(now));
        for plan in machine.plans.values_mut() {
            if plan.computing.is_some_and(|at| now.saturating_sub(at) >= LOST) {
                (plan.computing, plan.basis, plan.waits) = (None, None, true);
            }
        }
        self.take_held(zones, machine, |machine, it| {
            now.saturating_sub(it.since) >= WAITS || !machine.is_planning(&it.zones)
        });
    }

    /// Gives the machine these of the reports that wait, in their order.
    fn take_held(
        &self,
        zones: &Zones,
        machine: &mut Machine,
        goes: impl Fn(&Machine, &Held) -> bool,
    ) {
        let held = std::mem::take(&mut machine.held).into_iter();
        let (go, stay): (Vec<Held>, Vec<Held>) = held.partition(|it| goes(machine, it));
        machine.held = stay.into();
        for held in go {
            self.take(zones, machine, &held.caller, &held.event);
        }
    }

    /// The fire of each monitor that the planner chooses, and the order in which they are used.
    fn chosen(&self, job: Job) -> Chosen {
        let mut chosen = self.assigned(job);
        chosen.order = self.planned_order(&chosen.job.monitors, &chosen.job.fires, &chosen.by);
        chosen
    }

    fn assigned(&self, job: Job) -> Chosen {
        let mut task = match self.task(&job) {
            Ok(Some(task)) => task,
            other => {
                let failed = other.err().map(|problem| problem.0);
                let (by, order) = (BTreeMap::new(), Vec::new());
                return Chosen { job, by, opens: None, order, failed };
            }
        };
        for (monitor, (id, place, _)) in job.able.iter().enumerate() {
            for (fire, known) in job.fires.iter().enumerate() {
                let leaves = job.water[monitor].stays.is_some_and(|at| at != fire);
                let never = leaves || !self.may_turn(id, place, &known.place);
                for offer in task.levels.iter_mut().map(|level| &mut level.offers[monitor][fire]) {
                    // The request has a distance alone: the monitor takes its flat solution.
                    *offer = offer.filter(|it| !never && it.aim.is_none_or(|aim| !aim.steep));
                }
            }
        }
        let jets = job.jets.min(job.able.len());
        let chosen = filled(&task, renewed(&task, &job.before), &job.before, jets);
        let limited = self.config().plan.supply.is_some();
        let opens = limited.then(|| opens(&task, &chosen, &job));
        let by = job.able.iter().zip(&chosen);
        let by = by.filter_map(|((id, ..), fire)| Some((id.clone(), job.fires[(*fire)?].number)));
        Chosen { by: by.collect(), job, opens, order: Vec::new(), failed: None }
    }

    /// What each monitor brings to each fire. The others of the site follow those that can be used: jets keep
    /// clear of them too.
    fn task(&self, job: &Job) -> Result<Option<Task>, Problem> {
        let able = &job.able;
        let Some(map) = self.map().filter(|_| !able.is_empty()) else { return Ok(None) };
        let fire = |known: &Known| {
            let ([east, north], up) = (known.place.at, self.height_of(&known.place));
            Fire { at: [east, north, up], area_m2: AREA_M2, density_lpm_m2: DENSITY_LPM_M2 }
        };
        let supply = Supply::constant(job.basis.pressure_mpa);
        let supply = supply.or_else(|_| Supply::constant(USUAL_MPA))?;
        let supply = self.config().plan.supply.clone().unwrap_or(supply);
        let ids = map.monitors.keys().filter(|id| able.iter().all(|it| it.0 != **id));
        let others =
            ids.filter_map(|id| self.built(id)).take(lafet_place::MONITORS_MAX - able.len());
        let all: Vec<_> = able.iter().cloned().chain(others).collect();
        let turned = |(index, it)| Turned { works: index < able.len(), ..self.turned(it) };
        let situation = Situation {
            fires: job.fires.iter().map(fire).collect(),
            wind: job.basis.wind,
            monitors: all.iter().enumerate().map(turned).collect(),
        };
        offers(&planned(&map, &all, supply), &situation).map(Some)
    }

    /// Where a barrel is, within its limits.
    fn turned(&self, (id, place, built): &(String, Place, Built)) -> Turned {
        let status = self.station(id).ok().map(|station| station.status());
        let position = |drive| status.as_ref().and_then(|it| it.position(drive)).unwrap_or(0);
        let radians = |arcmin: i64, [least, most]: [i32; 2]| {
            let arcmin = arcmin.max(least.into()).min(most.into());
            (arcmin as f64 / 60.0).to_radians()
        };
        let azimuth = radians(position(SubsystemId::HORIZONTAL), built.azimuths);
        let elevation = radians(position(SubsystemId::VERTICAL), built.elevations);
        let bearing = wrapped(place.heading.to_radians() - azimuth);
        Turned { to: Direction { bearing, elevation }, works: true }
    }

    /// Whether a monitor may point at a fire, and turn to it with the water that it has.
    fn may_turn(&self, id: &str, place: &Place, fire: &FirePlace) -> bool {
        let Ok(station) = self.station(id) else { return false };
        let target = fire.target(place, self.height_of(fire));
        if target.is_none() || !self.may_aim(&station, place, fire) {
            return false;
        }
        let status = station.status();
        let at = status.position(SubsystemId::HORIZONTAL).map(|it| Span::at(it as f64));
        let to = Span::at(fire.azimuth_arcmin(place));
        !status.flows() || at.is_some_and(|at| self.is_clear(id, at.with(to)))
    }
}

impl Machine {
    /// These zones, with what their detectors have reported so far.
    fn up_to_now(&self, zones: Vec<String>) -> Vec<(String, u64)> {
        let with = |zone: String| {
            let report = self.locating.get(&zone).map_or(0, Locating::reported);
            (zone, report)
        };
        zones.into_iter().map(with).collect()
    }

    /// Whether what these zones show up to a report is not located yet, or not planned for.
    fn is_planning(&self, zones: &[(String, u64)]) -> bool {
        zones.iter().any(|(zone, report)| {
            let located = self.locating.get(zone).is_none_or(|it| it.has(*report));
            !located || self.plans.get(zone).is_some_and(Plan::is_coming)
        })
    }
}

fn is_latest(machine: &Machine, job: &Job) -> bool {
    machine.plans.get(&job.zone).is_some_and(|plan| plan.computed == job.number)
}

/// Whether a report is one of which water may follow, and that is the better for a plan.
fn may_wait(event: &Event) -> bool {
    match event {
        Event::Detector { signal, condition, .. } => {
            *signal == Signal::Alarm && *condition == Condition::Ready
        }
        Event::Monitor { report, .. } => {
            let MonitorReport { reachable, authority, lockout, failure, .. } = *report;
            (!reachable || failure) && authority != Authority::Person && !lockout
        }
        _ => false,
    }
}

/// Whose report it is.
fn subject(event: &Event) -> Option<(&str, bool)> {
    match event {
        Event::Detector { detector, .. } => Some((detector, true)),
        Event::Monitor { monitor, .. } => Some((monitor, false)),
        _ => None,
    }
}

fn index(fires: &[Known], number: u64) -> Option<usize> {
    fires.iter().position(|it| it.number == number)
}

/// What these monitors do: water stays where it is.
fn water(machine: &Machine, fires: &[Known], able: &[(String, Place, Built)]) -> Vec<Water> {
    let of = |(id, ..): &(String, Place, Built)| {
        let line = machine.lines.get(id).filter(|it| it.engaged.is_some());
        let stays = line.and_then(Line::at).and_then(|number| index(fires, number));
        Water { stays, flows: line.is_some_and(acts) }
    };
    able.iter().map(of).collect()
}

/// Whether a monitor gives water, or is about to.
fn acts(line: &Line) -> bool {
    line.report().is_some_and(MonitorReport::acts)
}

/// The monitors that votes may open: those on fires, and further ones as long as no jet that is chosen falls
/// short by it. One that would reach a fire and was not given one falls short itself.
fn opens(task: &Task, chosen: &Assignment, job: &Job) -> Vec<String> {
    let flows = |index: usize| chosen[index].is_some() || job.water[index].flows;
    let mut flowing = (0..job.able.len()).filter(|index| flows(*index)).count();
    let most = task.levels.last().map_or(0, |level| level.flowing);
    let suffices = |count: usize| {
        let mut each = chosen.iter().zip(&task.level(count).offers);
        count <= most && each.all(|(fire, offers)| fire.is_none_or(|fire| offers[fire].is_some()))
    };
    let reaches = |index: usize, level: &Level| level.offers[index].iter().any(Option::is_some);
    let spare = flowing >= job.jets;
    let mut opens = Vec::new();
    for (index, (id, ..)) in job.able.iter().enumerate() {
        let alone = reaches(index, task.level(1));
        let may = match (flows(index), spare) {
            (true, _) => true,
            // In place of another one.
            (false, true) => !alone || reaches(index, task.level(flowing)),
            (false, false) => !alone && suffices(flowing + 1),
        };
        if may {
            flowing += usize::from(!flows(index) && !spare);
            opens.push(id.clone());
        }
    }
    // Those that are not planned with count like those that reach no fire.
    for id in &job.others {
        if spare || suffices(flowing + 1) {
            flowing += usize::from(!spare);
            opens.push(id.clone());
        }
    }
    opens
}

#[cfg(test)]
#[path = "planning_tests.rs"]
mod tests;
