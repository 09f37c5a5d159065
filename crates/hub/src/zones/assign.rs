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
use lafet_place::site::Wind;
use lafet_proto::SubsystemId;
use lafet_site::config::Zone;
use lafet_site::{Authority, Phase, State, Trouble, Withheld};

use super::fires::FirePlace;
use super::{Machine, Zones, planning};
use crate::config::Target;
use crate::control::authority::Now;
use crate::hub::Hub;
use crate::site::planned::{Built, USUAL_MPA, is_plannable};
use crate::site::{Place, jet};
use crate::text::Both;

/// Most fires of a zone that are planned together.
const FIRES_MAX: usize = 4;
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
    pub(super) by: BTreeMap<String, u64>,
    /// The monitors that votes may open; none: all of the zone.
    pub(super) opens: Option<Vec<String>>,
    /// What it was planned for; none: not yet.
    pub(super) basis: Option<Basis>,
    /// When it was planned, and whether it waits to be planned again.
    pub(super) planned: Option<Now>,
    pub(super) waits: bool,
    /// Since when a plan is computed, the number of the latest one, and whether it was computed in vain.
    pub(super) computing: Option<Now>,
    pub(super) computed: u64,
    pub(super) again: bool,
    /// Why the latest one could not be computed.
    pub(super) failed: Option<Both>,
}

/// A fire that is known.
#[derive(Clone, Debug)]
pub struct Known {
    pub(super) number: u64,
    pub(super) place: FirePlace,
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
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Basis {
    fires: Vec<(u64, [f64; 2])>,
    able: BTreeSet<String>,
    pub(super) wind: Wind,
    pub(super) pressure_mpa: f64,
}

/// What has become of a plan.
enum Renewed {
    /// Nothing.
    Same,
    /// It is empty.
    Over,
    /// There is another one to be computed.
    Job(Box<planning::Job>),
}

impl Basis {
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let [a, b] = [self, other].map(|it| {
            let (sin, cos) = it.wind.from.sin_cos();
            [it.wind.speed_mps * sin, it.wind.speed_mps * cos]
        });
        let pressure = (self.pressure_mpa - other.pressure_mpa).abs();
        self.is_for_the_same(other)
            && (a[0] - b[0]).hypot(a[1] - b[1]) < TURNED_MPS
            && pressure <= OTHER_PRESSURE * self.pressure_mpa
    }

    /// The same without wind and pressure.
    pub(super) fn is_for_the_same(&self, other: &Self) -> bool {
        self.fires == other.fires && self.able == other.able
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
        let stays = |it: &Known| it.missed < OUT_AFTER && now.saturating_sub(it.seen) < KNOWN_FOR;
        // While there is water the last one stays: without a plan votes would open what the water does not
        // suffice for, and who takes the place of a lost monitor would not know its fire.
        let counted = || self.fires.iter().filter(|it| it.counts);
        let last = counted().max_by_key(|it| it.seen).map(|it| it.number);
        let last = last.filter(|_| wet && !counted().any(stays));
        self.fires.retain(|it| stays(it) || last == Some(it.number));
        for place in new.into_iter().take(FIRES_MAX.saturating_sub(self.fires.len())) {
            self.latest += 1;
            self.fires.push(Known::new(self.latest, place, now));
        }
        self.fires.iter_mut().filter(|it| it.seen == now).for_each(|it| it.weigh(now, wet, &heard));
    }

    /// There is nothing to plan for, and nothing is left of what was.
    fn is_over(&self) -> bool {
        let idle = self.basis.is_none() && self.computing.is_none() && !self.waits;
        idle && self.fires.is_empty() && self.by.is_empty() && self.opens.is_none()
    }

    /// The fires that are planned for.
    pub(super) fn counted(&self) -> impl Iterator<Item = &Known> {
        self.fires.iter().filter(|it| it.counts)
    }

    /// The monitors that could be used and that votes may not open.
    pub fn left_out(&self) -> impl Iterator<Item = &String> {
        let able = self.basis.iter().flat_map(|it| &it.able);
        able.filter(|id| self.opens.as_ref().is_some_and(|opens| !opens.contains(id)))
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

    /// Whether a plan is computed, or is going to be where there is none: a fire soon after another one waits for
    /// its turn.
    pub(super) const fn is_coming(&self) -> bool {
        self.computing.is_some() || (self.waits && self.basis.is_none())
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
    /// Plans the fires of a zone, if anything has changed.
    pub(super) fn plan_fires(&self, zones: &Zones, machine: &mut Machine, zone: &Zone) {
        let mut plan = machine.plans.remove(&zone.id).unwrap_or_default();
        let renewed = self.renew(zones, machine, zone, &mut plan);
        machine.plans.insert(zone.id.clone(), plan);
        match renewed {
            Renewed::Same => {}
            Renewed::Over => self.prefer(zones, machine, zone, Vec::new()),
            Renewed::Job(job) => self.compute(*job),
        }
    }

    /// Plans again the zones of monitors whose reports have changed.
    pub(super) fn plan_again(
        &self,
        zones: &Zones,
        machine: &mut Machine,
        monitors: impl Iterator<Item = usize>,
    ) {
        let of: BTreeSet<usize> =
            monitors.flat_map(|at| zones.index.zones_of(at)).copied().collect();
        for zone in of {
            self.plan_fires(zones, machine, &zones.config.site.zones[zone]);
        }
    }

    fn renew(&self, zones: &Zones, machine: &Machine, zone: &Zone, plan: &mut Plan) -> Renewed {
        let now = self.now();
        let places = machine.fires.get(&zone.id).map_or(&[][..], |it| &it[..]);
        if places.is_empty() && plan.is_over() {
            return Renewed::Same;
        }
        let heard = |id: &str| machine.reported.get(id).map(|it| it.heard);
        plan.see(places, now, has_water(machine, zone), heard);
        let state = machine.site.state();
        if places.is_empty() && is_quiet(&state, zone) {
            plan.fires.clear();
        }
        plan.waits = false;
        if plan.counted().next().is_none() {
            (plan.basis, plan.computing) = (None, None);
            let limited = plan.opens.take().is_some();
            let assigned = !std::mem::take(&mut plan.by).is_empty();
            return if limited || assigned { Renewed::Over } else { Renewed::Same };
        }
        let able = self.able(zones, machine, &state, zone);
        let basis = self.basis(machine, plan, &able);
        let changes = plan.basis.as_ref().is_none_or(|before| !before.is_like(&basis));
        // One that is computed is looked at when it is there.
        plan.waits = changes && plan.is_recent(now) && plan.computing.is_none();
        if !changes || plan.waits || plan.computing.is_some() {
            return Renewed::Same;
        }
        plan.computed += 1;
        (plan.planned, plan.computing) = (Some(now), Some(now));
        Renewed::Job(self.job(zones, machine, zone, (plan, basis, able)).into())
    }

    /// What a plan for these monitors depends on now.
    pub(super) fn basis(
        &self,
        machine: &Machine,
        plan: &Plan,
        able: &[(String, Place, Built)],
    ) -> Basis {
        Basis {
            fires: plan.counted().map(|it| (it.number, it.at)).collect(),
            able: able.iter().map(|it| it.0.clone()).collect(),
            wind: wind(machine).unwrap_or_default(),
            pressure_mpa: self.pressure_mpa(able),
        }
    }

    /// The monitors that can be used for a zone, the nearest to its fires if there are too many. While it has
    /// as many at work as it uses at once, those alone: who works stays at work.
    pub(super) fn able(
        &self,
        zones: &Zones,
        machine: &Machine,
        state: &State,
        zone: &Zone,
    ) -> Vec<(String, Place, Built)> {
        let of = |id: &String| state.monitors.get(zones.index.monitor(id)?);
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
    pub(super) fn built(&self, id: &str) -> Option<(String, Place, Built)> {
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

    /// Monitors on fires first, of these one for each fire before the second ones; then by rank. Not under the lock
    /// of the machine.
    pub(super) fn planned_order(
        &self,
        monitors: &[String],
        fires: &[Known],
        by: &BTreeMap<String, u64>,
    ) -> Vec<String> {
        let places: Vec<FirePlace> = fires.iter().map(|it| it.place.clone()).collect();
        let ranked = self.preferred(monitors, &places);
        let mut jets: BTreeMap<u64, usize> = BTreeMap::new();
        let mut ordered: Vec<(usize, String)> = Vec::new();
        for id in ranked {
            let nth = by.get(&id).map(|number| {
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
        // The state is not for nothing.
        plan.counted().next()?;
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

/// The wind as it was reported last: without a further word of the anemometer it blows as before.
fn wind(machine: &Machine) -> Option<Wind> {
    let wind = machine.wind.as_ref()?;
    Some(Wind { from: wind.from_deg.to_radians(), speed_mps: wind.speed_mps })
}

/// Whether the machine has engaged a monitor for a zone.
fn has_water(machine: &Machine, zone: &Zone) -> bool {
    let lines = zone.monitors.iter().filter_map(|id| machine.lines.get(id));
    lines.map(|line| &line.engaged).any(|engaged| engaged.as_ref() == Some(&zone.id))
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
