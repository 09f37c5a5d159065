//! Which monitor on which fire: the planner of [`lafet_place`], for the fires of a zone.
//!
//! It plans when the places of fires are known, and again when a monitor is lost or back, the wind turns, the
//! pressure changes, a fire is out or new; once a second at most. The machine gets the order of monitors that
//! follows from it; the fire of each is known here.
//!
//! Water that flows is not aimed again: while a fire goes out another one may begin, and of detectors that have
//! one bearing each the crossing is then a place where nothing burns.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use lafet_ballistics::{DATM_MPA, PRESSURE_DATM};
use lafet_place::planner::{Assignment, Fire, Situation, Task, Turned, filled, offers, renewed};
use lafet_place::site::{Direction, Wind};
use lafet_place::supply::Supply;
use lafet_place::wrapped;
use lafet_proto::SubsystemId;
use lafet_site::config::Zone;
use lafet_site::{Authority, Event, Phase, State, Trouble, Withheld};

use super::fires::FirePlace;
use super::line::Line;
use super::{Machine, Zones};
use crate::config::Target;
use crate::control::authority::Now;
use crate::hub::{Caller, Hub};
use crate::site::keep_out::Span;
use crate::site::planned::{Built, USUAL_MPA, is_plannable, planned};
use crate::site::{Place, jet};

/// What a fire is taken to be: its size is not measured.
const AREA_M2: f64 = 30.0;
const DENSITY_LPM_M2: f64 = 20.0;
/// Most fires and monitors of a zone that are planned together: each pair takes about a millisecond.
const FIRES_MAX: usize = 4;
const MONITORS_MAX: usize = 16;
/// A place no farther away than this, and its ellipse up to as much again, is the same fire, m; moved by so much
/// it is planned again. One that has moved that far from where it got its number gets another: no jet scans it.
const SAME_M: f64 = 5.0;
const MOVED_M: f64 = 2.0;
/// A fire that was not seen for so long, while others are, is out; and after so long without a sight of it its
/// place does not count any more.
const OUT_AFTER: Duration = Duration::from_secs(5);
const KNOWN_FOR: Duration = Duration::from_secs(60);
/// While a zone has water a fire counts after it was seen for so long.
const SURE_AFTER: Duration = Duration::from_secs(2);
/// A wind is another one by this difference, m/s.
const TURNED_MPS: f64 = 1.5;
/// A pressure is another one by this part of it.
const OTHER_PRESSURE: f64 = 0.1;
/// A zone is planned this often, whatever is reported.
const SOON: Duration = Duration::from_secs(1);

/// The fires of a zone, and who is on them.
#[derive(Debug, Default)]
pub struct Plan {
    fires: Vec<Known>,
    /// Number of the latest fire.
    latest: u64,
    /// The fire of each monitor, by its number.
    by: BTreeMap<String, u64>,
    /// What it was planned for; none: not yet.
    basis: Option<Basis>,
    /// When it was planned, and whether it waits to be planned again.
    planned: Option<Now>,
    waits: bool,
}

/// A fire that is known.
#[derive(Clone, Debug)]
struct Known {
    number: u64,
    place: FirePlace,
    /// Where it was planned for, m.
    at: [f64; 2],
    /// Where it got its number, m.
    from: [f64; 2],
    /// Since when it is seen, and when it was last.
    since: Now,
    seen: Now,
    /// How long others are seen and it is not, and since when they are.
    missed: Duration,
    alone: Option<Now>,
    /// It is planned for.
    counts: bool,
}

/// What a plan depends on.
#[derive(Clone, Debug, PartialEq)]
struct Basis {
    fires: Vec<(u64, [f64; 2])>,
    able: BTreeSet<String>,
    wind: Wind,
    pressure_mpa: f64,
}

impl Basis {
    fn is_like(&self, other: &Self) -> bool {
        let [a, b] = [self, other].map(|it| {
            let (sin, cos) = it.wind.from.sin_cos();
            [it.wind.speed_mps * sin, it.wind.speed_mps * cos]
        });
        let pressure = (self.pressure_mpa - other.pressure_mpa).abs();
        self.fires == other.fires
            && self.able == other.able
            && (a[0] - b[0]).hypot(a[1] - b[1]) < TURNED_MPS
            && pressure <= OTHER_PRESSURE * self.pressure_mpa
    }
}

impl Known {
    fn new(number: u64, place: &FirePlace, now: Now) -> Self {
        Self {
            number,
            place: place.clone(),
            at: place.at,
            from: place.at,
            since: now,
            seen: now,
            missed: Duration::ZERO,
            alone: None,
            counts: false,
        }
    }

    /// It is seen here.
    fn see(&mut self, place: &FirePlace, now: Now) {
        if away(self.at, place.at) > MOVED_M {
            self.at = place.at;
        }
        if (!self.missed.is_zero() || self.alone.is_some()) && !self.counts {
            self.since = now;
        }
        (self.missed, self.alone) = (Duration::ZERO, None);
        (self.place, self.seen) = (place.clone(), now);
    }

    /// It is not seen; `others` are. While nothing is, no time passes: smoke and water hide fires.
    fn miss(&mut self, others: bool, now: Now) {
        let since = self.alone.take().unwrap_or(now);
        self.missed += now.saturating_sub(since);
        self.alone = others.then_some(now);
    }

    /// Whether it counts from now on. While the zone has water it has to be seen for long enough, and reported
    /// again by each detector that shows it.
    fn weigh(&mut self, now: Now, wet: bool, heard: &impl Fn(&str) -> Option<Now>) {
        let again = |id: &String| heard(id).is_some_and(|at| at > self.since);
        let long = now.saturating_sub(self.since) >= SURE_AFTER;
        self.counts |= !wet || (long && self.place.detectors.iter().all(again));
    }
}

impl Plan {
    /// Takes the places that are sure. Without any, those that were known stay for a while: smoke and water hide
    /// fires. `wet`: the zone has water; `heard`: when a detector was last heard.
    fn see(
        &mut self,
        places: &[FirePlace],
        now: Now,
        wet: bool,
        heard: impl Fn(&str) -> Option<Now>,
    ) {
        let (mut seen, mut new) = (BTreeSet::new(), Vec::new());
        for place in places.iter().filter(|it| it.is_sure()) {
            let others = self.fires.iter_mut().filter(|it| !seen.contains(&it.number));
            let near = others.map(|it| (away(it.place.at, place.at), it));
            let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, known)) = nearest.filter(|it| it.0 <= same_m(place)) else {
                new.push(place);
                continue;
            };
            known.see(place, now);
            if away(known.from, place.at) > same_m(place) {
                self.latest += 1;
                for number in self.by.values_mut().filter(|it| **it == known.number) {
                    *number = self.latest;
                }
                (known.number, known.from) = (self.latest, place.at);
            }
            seen.insert(known.number);
        }
        let hidden = seen.is_empty() && new.is_empty();
        for known in self.fires.iter_mut().filter(|it| !seen.contains(&it.number)) {
            known.miss(!hidden, now);
        }
        let out = |it: &Known| it.missed >= OUT_AFTER;
        self.fires.retain(|it| !out(it) && now.saturating_sub(it.seen) < KNOWN_FOR);
        for place in new.into_iter().take(FIRES_MAX.saturating_sub(self.fires.len())) {
            self.latest += 1;
            self.fires.push(Known::new(self.latest, place, now));
        }
        self.fires.iter_mut().filter(|it| it.seen == now).for_each(|it| it.weigh(now, wet, &heard));
    }

    /// The fires that are planned for.
    fn counted(&self) -> impl Iterator<Item = &Known> {
        self.fires.iter().filter(|it| it.counts)
    }

    fn places(&self) -> Vec<FirePlace> {
        self.counted().map(|it| it.place.clone()).collect()
    }

    fn known(&self, number: u64) -> Option<&Known> {
        self.fires.iter().find(|it| it.number == number)
    }

    /// Each monitor, the number of its fire, and where that is.
    pub fn assigned(&self) -> impl Iterator<Item = (&String, u64, [f64; 2])> {
        self.by
            .iter()
            .filter_map(|(monitor, number)| Some((monitor, *number, self.known(*number)?.at)))
    }

    /// Whether it waits to be planned, and may be.
    pub fn is_due(&self, now: Now) -> bool {
        self.waits && !self.is_recent(now)
    }

    fn is_recent(&self, now: Now) -> bool {
        self.planned.is_some_and(|at| now.saturating_sub(at) < SOON)
    }
}

fn away(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn same_m(place: &FirePlace) -> f64 {
    SAME_M + place.major_m.min(SAME_M)
}

impl Hub {
    /// Plans the fires of a zone, and gives the machine the order of its monitors.
    pub(super) fn plan_fires(
        &self,
        zones: &Zones,
        machine: &mut Machine,
        caller: &Caller,
        zone: &Zone,
    ) {
        if !self.assign(zones, machine, zone) {
            return;
        }
        machine.news = true;
        let order = self.planned_order(machine, zone);
        let known = machine.preferred.entry(zone.id.clone()).or_default();
        if *known != order {
            known.clone_from(&order);
            let event = Event::Prefer { zone: zone.id.clone(), monitors: order, opens: None };
            self.take(zones, machine, caller, &event);
        }
    }

    /// Plans again the zones of monitors whose reports have changed.
    pub(super) fn plan_again(&self, zones: &Zones, machine: &mut Machine, monitors: &[&String]) {
        let serves = |zone: &&Zone| zone.monitors.iter().any(|id| monitors.contains(&id));
        for zone in zones.config.site.zones.iter().filter(serves) {
            self.plan_fires(zones, machine, &Caller::zones(), zone);
        }
    }

    /// Assigns the monitors of a zone to its fires, if anything has changed; whether it did.
    fn assign(&self, zones: &Zones, machine: &mut Machine, zone: &Zone) -> bool {
        let mut plan = machine.plans.remove(&zone.id).unwrap_or_default();
        let changes = self.renew(zones, machine, zone, &mut plan);
        machine.plans.insert(zone.id.clone(), plan);
        changes
    }

    fn renew(&self, zones: &Zones, machine: &Machine, zone: &Zone, plan: &mut Plan) -> bool {
        let now = self.now();
        let places = machine.fires.get(&zone.id).map_or(&[][..], |it| &it[..]);
        let heard = |id: &str| machine.reported.get(id).map(|it| it.heard);
        plan.see(places, now, has_water(machine, zone), heard);
        let state = machine.site.state();
        if places.is_empty() && is_quiet(&state, zone) {
            plan.fires.clear();
        }
        plan.waits = false;
        if plan.counted().next().is_none() {
            plan.basis = None;
            return !std::mem::take(&mut plan.by).is_empty();
        }
        let able = self.able(machine, &state, zone);
        // Without a word of the anemometer it blows as before.
        let before = plan.basis.as_ref().map(|it| it.wind);
        let basis = Basis {
            fires: plan.counted().map(|it| (it.number, it.at)).collect(),
            able: able.iter().map(|it| it.0.clone()).collect(),
            wind: wind(machine).or(before).unwrap_or_default(),
            pressure_mpa: self.pressure_mpa(&able),
        };
        let changes = plan.basis.as_ref().is_none_or(|before| !before.is_like(&basis));
        plan.waits = changes && plan.is_recent(now);
        if !changes || plan.waits {
            return false;
        }
        plan.by = self.chosen(zones, machine, zone, (plan, &basis, able));
        (plan.basis, plan.planned) = (Some(basis), Some(now));
        true
    }

    /// The monitors that can be used for a zone, the nearest to its fires if there are too many. While it has
    /// as many at work as it uses at once, those alone: who works stays at work.
    fn able(&self, machine: &Machine, state: &State, zone: &Zone) -> Vec<(String, Place, Built)> {
        let of = |id: &String| state.monitors.iter().find(|it| it.monitor == *id);
        let works = |id: &&String| {
            let report = machine.lines.get(*id).and_then(|line| line.report());
            let reported = report.is_some_and(|it| {
                it.reachable && !it.failure && !it.lockout && it.authority != Authority::Person
            });
            let free = of(id).is_some_and(|it| {
                let engaged = it.engaged_for.as_ref().is_none_or(|other| *other == zone.id);
                let refused = matches!(it.withheld, Some(Withheld::Refused | Withheld::Lockout));
                engaged && !refused && !it.closing
            });
            reported && free && !is_idle(state, id)
        };
        let all: Vec<&String> = zone.monitors.iter().filter(works).collect();
        let engaged = |id: &&String| of(id).is_some_and(|it| it.engaged_for.is_some());
        let jets = zone.jets.map_or(usize::MAX, usize::from);
        let full = all.iter().filter(|id| engaged(id)).count() >= jets;
        let used = all.into_iter().filter(|id| !full || engaged(id));
        used.filter_map(|id| self.built(id)).collect()
    }

    /// A monitor with a place, as the planner knows it; none where it could not compute with it.
    fn built(&self, id: &str) -> Option<(String, Place, Built)> {
        let (station, place) = (self.station(id).ok()?, self.place_of(id)?);
        let built = Built::by(|param| jet::parameter(&station, param));
        Some((id.to_owned(), place, built)).filter(is_plannable)
    }

    /// The greatest pressure that a monitor measures.
    fn pressure_mpa(&self, able: &[(String, Place, Built)]) -> f64 {
        let measured = able.iter().filter_map(|(id, ..)| {
            let status = self.station(id).ok()?.status();
            status.valid(SubsystemId::GENERAL, "pressure")
        });
        let most = measured.max().filter(|datm| *datm >= i64::from(*PRESSURE_DATM.start()));
        most.map_or(USUAL_MPA, |datm| datm as f64 * DATM_MPA)
    }

    /// The fire of each monitor that the planner chooses.
    fn chosen(
        &self,
        zones: &Zones,
        machine: &Machine,
        zone: &Zone,
        (plan, basis, mut able): (&Plan, &Basis, Vec<(String, Place, Built)>),
    ) -> BTreeMap<String, u64> {
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
        let fires: Vec<&Known> = plan.counted().collect();
        let Some(mut task) = self.task(&fires, basis, &able) else { return BTreeMap::new() };
        let index = |number: u64| fires.iter().position(|it| it.number == number);
        for (monitor, (id, place, _)) in able.iter().enumerate() {
            let line = machine.lines.get(id);
            // Its water stays where it is.
            let stays = line.filter(|it| it.engaged.is_some()).and_then(Line::at).and_then(index);
            for (fire, known) in fires.iter().enumerate() {
                let leaves = stays.is_some_and(|at| at != fire);
                let never = leaves || !self.may_turn(id, place, &known.place);
                for offer in task.levels.iter_mut().map(|level| &mut level.offers[monitor][fire]) {
                    // The request has a distance alone: the monitor takes its flat solution.
                    *offer = offer.filter(|it| !never && it.aim.is_none_or(|aim| !aim.steep));
                }
            }
        }
        let of = |id: &String| {
            let at = machine.lines.get(id).and_then(Line::at);
            plan.by.get(id).copied().or(at).and_then(index)
        };
        let before: Assignment = able.iter().map(|(id, ..)| of(id)).collect();
        let jets = zone.jets.map_or(able.len(), usize::from);
        let chosen = filled(&task, renewed(&task, &before), &before, jets);
        let chosen = able.into_iter().zip(chosen);
        chosen.filter_map(|((id, ..), fire)| Some((id, fires[fire?].number))).collect()
    }

    /// What each monitor brings to each fire. The others of the site follow those that can be used: jets keep
    /// clear of them too.
    fn task(
        &self,
        fires: &[&Known],
        basis: &Basis,
        able: &[(String, Place, Built)],
    ) -> Option<Task> {
        let map = self.map()?;
        if able.is_empty() {
            return None;
        }
        let fire = |known: &&Known| {
            let ([east, north], up) = (known.place.at, self.height_of(&known.place));
            Fire { at: [east, north, up], area_m2: AREA_M2, density_lpm_m2: DENSITY_LPM_M2 }
        };
        let supply = Supply::constant(basis.pressure_mpa);
        let supply = supply.or_else(|_| Supply::constant(USUAL_MPA)).ok()?;
        let supply = self.config().plan.supply.clone().unwrap_or(supply);
        let ids = map.monitors.keys().filter(|id| able.iter().all(|it| it.0 != **id));
        let others =
            ids.filter_map(|id| self.built(id)).take(lafet_place::MONITORS_MAX - able.len());
        let all: Vec<_> = able.iter().cloned().chain(others).collect();
        let turned = |(index, it)| Turned { works: index < able.len(), ..self.turned(it) };
        let situation = Situation {
            fires: fires.iter().map(fire).collect(),
            wind: basis.wind,
            monitors: all.iter().enumerate().map(turned).collect(),
        };
        let task = offers(&planned(&map, &all, supply), &situation);
        task.inspect_err(|error| tracing::warn!(%error, "monitors are not planned")).ok()
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

    /// Monitors on fires first, of these one for each fire before the second ones; then by rank.
    fn planned_order(&self, machine: &Machine, zone: &Zone) -> Vec<String> {
        let Some(plan) = machine.plans.get(&zone.id) else { return Vec::new() };
        let ranked = self.preferred(&zone.monitors, &plan.places());
        let mut jets: BTreeMap<u64, usize> = BTreeMap::new();
        let mut ordered: Vec<(usize, String)> = Vec::new();
        for id in ranked {
            let nth = plan.by.get(&id).map(|number| {
                let count = jets.entry(*number).or_default();
                *count += 1;
                *count
            });
            ordered.push((nth.unwrap_or(usize::MAX), id));
        }
        ordered.sort_by_key(|it| it.0);
        ordered.into_iter().map(|it| it.1).collect()
    }

    /// The fire that a monitor of a zone aims at, and how; none: it aims as configured.
    pub(super) fn fire_of(
        &self,
        machine: &Machine,
        zone: &Zone,
        monitor: &str,
    ) -> Option<(u64, Target)> {
        let plan = machine.plans.get(&zone.id)?;
        let place = self.place_of(monitor)?;
        let target = |known: &Known, place: &Place| {
            let target = known.place.target(place, self.height_of(&known.place))?;
            Some((known.number, target))
        };
        if let Some(number) = plan.by.get(monitor) {
            return target(plan.known(*number)?, &place);
        }
        let mut taken: BTreeMap<u64, usize> = BTreeMap::new();
        let present = present(&machine.site.state(), zone, monitor);
        let by = present.iter().filter_map(|id| plan.by.get(*id));
        by.for_each(|number| *taken.entry(*number).or_default() += 1);
        // One without a fire of the plan takes that which fewest have before it, the nearest of these.
        for id in present.into_iter().filter(|id| !plan.by.contains_key(*id)) {
            let (Some(place), Ok(station)) = (self.place_of(id), self.station(id)) else {
                continue;
            };
            let able = plan.counted().filter(|it| self.may_aim(&station, &place, &it.place));
            let rank = |it: &&Known| {
                let taken = taken.get(&it.number).copied().unwrap_or_default();
                (taken, it.place.distance_m(&place) as u32)
            };
            let Some(fire) = able.min_by_key(rank) else { continue };
            *taken.entry(fire.number).or_default() += 1;
            if id == monitor {
                return target(fire, &place);
            }
        }
        None
    }
}

/// The wind as it was reported last.
fn wind(machine: &Machine) -> Option<Wind> {
    let wind = machine.wind.as_ref()?;
    Some(Wind { from: wind.from_deg.to_radians(), speed_mps: wind.speed_mps })
}

/// Whether the machine has engaged a monitor for a zone.
fn has_water(machine: &Machine, zone: &Zone) -> bool {
    machine.lines.values().any(|line| line.engaged.as_ref() == Some(&zone.id))
}

/// Whether a monitor was ordered to act and does not.
fn is_idle(state: &State, monitor: &str) -> bool {
    let idle = |trouble| trouble == Trouble::MonitorIdle;
    state.troubles.iter().any(|it| it.active && idle(it.trouble) && it.subject == monitor)
}

/// The monitors that a zone uses or, while it uses none, can use; and this one. In the order of the zone.
fn present<'a>(state: &State, zone: &'a Zone, monitor: &str) -> Vec<&'a String> {
    let of = |id: &&String| state.monitors.iter().find(|it| it.monitor == **id);
    let engaged = |id: &&String| {
        of(id).is_some_and(|it| it.engaged_for.as_ref() == Some(&zone.id) && !it.closing)
    };
    let any = zone.monitors.iter().any(|id| engaged(&id));
    let works = |id: &&String| {
        of(id).is_some_and(|it| it.withheld.is_none() && !it.closing) && !is_idle(state, id)
    };
    let all = zone.monitors.iter();
    all.filter(|id| **id == monitor || works(id) && (!any || engaged(id))).collect()
}

fn is_quiet(state: &State, zone: &Zone) -> bool {
    state.zones.iter().any(|it| it.zone == zone.id && it.phase == Phase::Quiet)
}

#[cfg(test)]
#[path = "assign_tests.rs"]
mod tests;
