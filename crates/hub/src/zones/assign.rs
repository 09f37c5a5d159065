//! Which monitor on which fire: the planner of [`lafet_place`], for the fires of a zone.
//!
//! It plans when the places of fires are known, and again when a monitor is lost or back, the wind turns, the
//! pressure changes, a fire is out or new. The machine gets the order of monitors that follows from it; the
//! fire of each is known here. A monitor at work that gets another fire is ordered again.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use lafet_place::planner::{Assignment, Fire, Situation, Task, Turned, filled, offers, renewed};
use lafet_place::site::{Direction, Wind};
use lafet_place::supply::Supply;
use lafet_place::wrapped;
use lafet_proto::SubsystemId;
use lafet_site::config::Zone;
use lafet_site::{Authority, Event, Order, Phase, Withheld};

use super::fires::FirePlace;
use super::view::Assigned;
use super::{Machine, Zones};
use crate::clock::ms;
use crate::config::Target;
use crate::control::authority::Now;
use crate::hub::{Caller, Hub};
use crate::site::keep_out::Span;
use crate::site::planned::{Built, USUAL_MPA, planned};
use crate::site::{Place, jet};

/// What a fire is taken to be: its size is not measured.
const AREA_M2: f64 = 30.0;
const DENSITY_LPM_M2: f64 = 20.0;
/// Most fires and monitors of a zone that are planned together: each pair takes about a millisecond.
const FIRES_MAX: usize = 4;
const MONITORS_MAX: usize = 16;
/// A place no farther away than this, and its ellipse, is the same fire, m; moved by so much it is planned
/// again.
const SAME_M: f64 = 5.0;
const MOVED_M: f64 = 2.0;
/// A fire that was not seen for so long, while others are, is out.
const OUT_AFTER: Duration = Duration::from_secs(5);
/// A wind counts for so long after it was reported, and is another one by this difference, m/s.
const WIND_COUNTS: Duration = Duration::from_secs(600);
const TURNED_MPS: f64 = 1.5;
/// A pressure is another one by this part of it.
const OTHER_PRESSURE: f64 = 0.1;
/// 0.1 atm, MPa, and the least pressure with a jet.
const DATM_MPA: f64 = 0.010_132_5;
const LEAST_DATM: i64 = 10;
/// Bearings and wind that change all the time are planned for this often.
const SOON: Duration = Duration::from_secs(1);
/// What is ordered again is not started later than this.
const IN_TIME: Duration = Duration::from_secs(2);

/// The fires of a zone, and who is on them.
#[derive(Debug, Default)]
pub struct Plan {
    fires: Vec<Known>,
    /// Number of the latest fire.
    latest: u64,
    /// The fire of each monitor, by its number.
    by: BTreeMap<String, u64>,
    /// What it was planned for, and when; none: not yet.
    basis: Option<(Basis, Now)>,
}

/// A fire that is known.
#[derive(Clone, Debug)]
struct Known {
    number: u64,
    place: FirePlace,
    /// Where it was planned for, m.
    at: [f64; 2],
    seen: Now,
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
    /// Whether fires and monitors are others, not only where and in which wind.
    fn has_others(&self, other: &Self) -> bool {
        let numbers = |it: &Self| it.fires.iter().map(|it| it.0).collect::<Vec<_>>();
        self.able != other.able || numbers(self) != numbers(other)
    }

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

impl Plan {
    /// Takes the places that are sure. Without any, those that were known stay: smoke and water hide fires.
    fn see(&mut self, places: &[FirePlace], now: Now) {
        let mut seen = BTreeSet::new();
        for place in places.iter().filter(|it| it.is_sure()) {
            let room = self.fires.len() < FIRES_MAX;
            let away =
                |it: &Known| (it.place.at[0] - place.at[0]).hypot(it.place.at[1] - place.at[1]);
            let same = self.fires.iter_mut().filter(|it| !seen.contains(&it.number));
            let same = same.map(|it| (away(it), it)).min_by(|a, b| a.0.total_cmp(&b.0));
            match same.filter(|it| it.0 <= SAME_M + place.major_m) {
                Some((_, known)) => {
                    let moved = (known.at[0] - place.at[0]).hypot(known.at[1] - place.at[1]);
                    if moved > MOVED_M {
                        known.at = place.at;
                    }
                    (known.place, known.seen) = (place.clone(), now);
                    seen.insert(known.number);
                }
                None if room => {
                    self.latest += 1;
                    let number = self.latest;
                    let known = Known { number, place: place.clone(), at: place.at, seen: now };
                    self.fires.push(known);
                    seen.insert(number);
                }
                None => {}
            }
        }
        if !seen.is_empty() {
            self.fires.retain(|it| now.saturating_sub(it.seen) < OUT_AFTER);
        }
    }

    fn places(&self) -> Vec<FirePlace> {
        self.fires.iter().map(|it| it.place.clone()).collect()
    }

    fn fire(&self, number: u64) -> Option<&FirePlace> {
        self.fires.iter().find(|it| it.number == number).map(|it| &it.place)
    }

    /// As clients see it.
    pub fn view(&self, zone: &str) -> impl Iterator<Item = Assigned> {
        self.by.iter().filter_map(move |(monitor, number)| {
            let at = self.fire(*number)?.at;
            Some(Assigned { zone: zone.to_owned(), monitor: monitor.clone(), at })
        })
    }
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
            let event = Event::Prefer { zone: zone.id.clone(), monitors: order };
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
        let now = self.now();
        let mut plan = machine.plans.remove(&zone.id).unwrap_or_default();
        let places = machine.fires.get(&zone.id).map_or(&[][..], |it| &it[..]);
        plan.see(places, now);
        if places.is_empty() && is_quiet(machine, zone) {
            let had = !plan.fires.is_empty();
            machine.plans.insert(zone.id.clone(), Plan::default());
            return had;
        }
        let able = self.able(machine, zone);
        let basis = Basis {
            fires: plan.fires.iter().map(|it| (it.number, it.at)).collect(),
            able: able.iter().map(|it| it.0.clone()).collect(),
            wind: self.wind(machine),
            pressure_mpa: self.pressure_mpa(&able),
        };
        let changes = plan.basis.as_ref().is_none_or(|(before, planned)| {
            let soon = now.saturating_sub(*planned) < SOON;
            before.has_others(&basis) || !soon && !before.is_like(&basis)
        });
        let changes = changes && !plan.fires.is_empty();
        if changes {
            plan.by = self.chosen(zones, machine, zone, (&plan, &basis, able));
            plan.basis = Some((basis, now));
        }
        machine.plans.insert(zone.id.clone(), plan);
        changes
    }

    /// The monitors that can be used for a zone, the nearest to its fires if there are too many. While it has
    /// as many at work as it uses at once, those alone: who works stays at work.
    fn able(&self, machine: &Machine, zone: &Zone) -> Vec<(String, Place, Built)> {
        let state = machine.site.state();
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
            reported && free
        };
        let all: Vec<&String> = zone.monitors.iter().filter(works).collect();
        let engaged = |id: &&String| of(id).is_some_and(|it| it.engaged_for.is_some());
        let jets = zone.jets.map_or(usize::MAX, usize::from);
        let full = all.iter().filter(|id| engaged(id)).count() >= jets;
        let used = all.into_iter().filter(|id| !full || engaged(id));
        used.filter_map(|id| {
            let (station, place) = (self.station(id).ok()?, self.place_of(id)?);
            Some((id.clone(), place, Built::by(|param| jet::parameter(&station, param))))
        })
        .collect()
    }

    /// The wind as it was reported last; still air without.
    fn wind(&self, machine: &Machine) -> Wind {
        let counts =
            |it: &&super::view::WindReported| self.now().saturating_sub(it.heard) < WIND_COUNTS;
        let wind = machine.wind.as_ref().filter(counts);
        wind.map_or_else(Wind::default, |it| Wind {
            from: it.from_deg.to_radians(),
            speed_mps: it.speed_mps,
        })
    }

    /// The greatest pressure that a monitor measures.
    fn pressure_mpa(&self, able: &[(String, Place, Built)]) -> f64 {
        let measured = able.iter().filter_map(|(id, ..)| {
            let status = self.station(id).ok()?.status();
            status.valid(SubsystemId::GENERAL, "pressure")
        });
        let most = measured.max().filter(|datm| *datm >= LEAST_DATM);
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
            let ways = plan.fires.iter().map(|it| it.place.distance_m(place));
            ways.fold(f64::INFINITY, f64::min)
        };
        able.sort_by(|a, b| nearest(&a.1).total_cmp(&nearest(&b.1)));
        able.truncate(MONITORS_MAX);
        for (id, _, built) in &mut able {
            let aim = zones.config.aims.get(&(zone.id.clone(), id.clone()));
            let narrowest = lafet_ballistics::NARROWEST_MM;
            built.nozzle_mm = aim.map_or(narrowest, |aim| aim.nozzle.into()).clamp(0, narrowest);
        }
        let Some(mut task) = self.task(plan, basis, &able) else { return BTreeMap::new() };
        for (monitor, (id, place, _)) in able.iter().enumerate() {
            for (fire, known) in plan.fires.iter().enumerate() {
                if !self.may_turn(id, place, &known.place) {
                    task.levels.iter_mut().for_each(|level| level.offers[monitor][fire] = None);
                }
            }
        }
        let index = |number: &u64| plan.fires.iter().position(|it| it.number == *number);
        let of = |id: &String| {
            let aimed = machine.lines.get(id).and_then(|line| line.aimed);
            plan.by.get(id).copied().or(aimed).as_ref().and_then(index)
        };
        let before: Assignment = able.iter().map(|(id, ..)| of(id)).collect();
        let jets = zone.jets.map_or(able.len(), usize::from);
        let chosen = filled(&task, renewed(&task, &before), &before, jets);
        let chosen = able.into_iter().zip(chosen);
        chosen.filter_map(|((id, ..), fire)| Some((id, plan.fires[fire?].number))).collect()
    }

    /// What each monitor brings to each fire.
    fn task(&self, plan: &Plan, basis: &Basis, able: &[(String, Place, Built)]) -> Option<Task> {
        let map = self.map()?;
        let fire = |known: &Known| {
            let tank = map.tanks.iter().find(|tank| tank.has(known.place.at));
            // The jet comes down on its roof, not within it.
            let roof = tank.map(|tank| tank.height + 0.1);
            let [east, north] = known.place.at;
            let up = roof.or(known.place.height_m).unwrap_or_default();
            Fire { at: [east, north, up], area_m2: AREA_M2, density_lpm_m2: DENSITY_LPM_M2 }
        };
        let supply = Supply::constant(basis.pressure_mpa);
        let supply = supply.or_else(|_| Supply::constant(USUAL_MPA)).ok()?;
        let supply = self.config().plan.supply.clone().unwrap_or(supply);
        let situation = Situation {
            fires: plan.fires.iter().map(fire).collect(),
            wind: basis.wind,
            monitors: able.iter().map(|it| self.turned(it)).collect(),
        };
        if able.is_empty() {
            return None;
        }
        let task = offers(&planned(&map, able, supply), &situation);
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
        if fire.target(place).is_none() || !self.may_aim(&station, place, fire) {
            return false;
        }
        let status = station.status();
        let at = status.position(SubsystemId::HORIZONTAL).map(|it| Span::at(it as f64));
        let to = Span::at(fire.azimuth_arcmin(place));
        !status.flows() || at.is_none_or(|at| self.is_clear(id, at.with(to)))
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
        let mut taken: BTreeMap<u64, usize> = BTreeMap::new();
        plan.by.values().for_each(|number| *taken.entry(*number).or_default() += 1);
        let place = self.place_of(monitor)?;
        if let Some(number) = plan.by.get(monitor) {
            return Some((*number, plan.fire(*number)?.target(&place)?));
        }
        // One without a fire of the plan takes that which fewest have before it, the nearest of these.
        for id in zone.monitors.iter().filter(|id| !plan.by.contains_key(*id)) {
            let (Some(place), Ok(station)) = (self.place_of(id), self.station(id)) else {
                continue;
            };
            let able = plan.fires.iter().filter(|it| self.may_aim(&station, &place, &it.place));
            let rank = |it: &&Known| {
                let taken = taken.get(&it.number).copied().unwrap_or_default();
                (taken, it.place.distance_m(&place) as u32)
            };
            let Some(fire) = able.min_by_key(rank) else { continue };
            *taken.entry(fire.number).or_default() += 1;
            if id == monitor {
                return Some((fire.number, fire.place.target(&place)?));
            }
        }
        None
    }

    /// Orders again what is at work on another fire than it was ordered to.
    pub(super) fn aim_again(&self, zones: &Zones, machine: &mut Machine) {
        let mut again = Vec::new();
        for (monitor, line) in &machine.lines {
            let (Some(command), Some(aimed)) = (&line.engaged, line.aimed) else { continue };
            let Order::Engage { zone, .. } = &command.order else { continue };
            let plan = machine.plans.get(zone);
            let to = plan.and_then(|plan| plan.by.get(monitor));
            if to.is_some_and(|to| *to != aimed) {
                let not_after_ms = Some(ms(self.now() + IN_TIME));
                again.push(lafet_site::Command { not_after_ms, ..command.clone() });
            }
        }
        // One that the machine does not use any more is left alone.
        let state = (!again.is_empty()).then(|| machine.site.state());
        again.retain(|command| {
            let Order::Engage { monitor, zone, .. } = &command.order else { return false };
            let monitors = state.iter().flat_map(|state| &state.monitors);
            let mut of = monitors.filter(|it| it.monitor == *monitor && !it.closing);
            of.any(|it| it.engaged_for.as_ref() == Some(zone))
        });
        for command in again {
            self.carry_order(zones, machine, &command);
            self.note_order(&command);
        }
    }
}

fn is_quiet(machine: &Machine, zone: &Zone) -> bool {
    let state = machine.site.state();
    state.zones.iter().any(|it| it.zone == zone.id && it.phase == Phase::Quiet)
}

#[cfg(test)]
mod tests {
    use super::super::fires::FireStanding;
    use super::*;

    fn place(standing: FireStanding, at: [f64; 2]) -> FirePlace {
        FirePlace {
            zone: "hall".into(),
            standing,
            at,
            height_m: None,
            major_m: 0.5,
            minor_m: 0.3,
            direction_deg: 0.0,
            detectors: Vec::new(),
        }
    }

    fn sure(at: [f64; 2]) -> FirePlace {
        place(FireStanding::Sure, at)
    }

    fn known(plan: &Plan) -> Vec<(u64, [f64; 2])> {
        plan.fires.iter().map(|it| (it.number, it.at)).collect()
    }

    #[test]
    fn a_fire_is_out_when_it_is_not_seen_while_another_one_is() {
        let at = |after: u64| Now::from_secs(100 + after);
        let mut plan = Plan::default();
        plan.see(&[sure([0.0, 20.0]), sure([30.0, 20.0])], at(0));
        assert_eq!(known(&plan), [(1, [0.0, 20.0]), (2, [30.0, 20.0])]);
        plan.see(&[place(FireStanding::Doubtful, [0.0, 20.0])], at(60));
        assert_eq!(plan.fires.len(), 2, "steam hides both");
        plan.see(&[sure([0.0, 20.0]), sure([30.0, 20.0])], at(60));
        plan.see(&[sure([30.0, 20.0])], at(64));
        assert_eq!(plan.fires.len(), 2);
        plan.see(&[sure([30.0, 20.0])], at(65));
        assert_eq!(known(&plan), [(2, [30.0, 20.0])]);
        plan.see(&[sure([0.0, 20.0])], at(66));
        assert_eq!(plan.fires[1].number, 3, "a new one");
    }

    #[test]
    fn a_fire_that_moves_is_the_same_one_and_there_is_a_greatest_number() {
        let mut plan = Plan::default();
        plan.see(&[sure([0.0, 20.0])], Now::ZERO);
        plan.see(&[sure([1.5, 20.0])], Now::ZERO);
        assert_eq!(known(&plan), [(1, [0.0, 20.0])], "not far enough for another plan");
        assert_eq!(plan.fires[0].place.at, [1.5, 20.0], "but aimed at where it is");
        plan.see(&[sure([4.0, 20.0])], Now::ZERO);
        assert_eq!(known(&plan), [(1, [4.0, 20.0])]);
        let many: Vec<_> = (0..9).map(|n| sure([20.0 * f64::from(n), 50.0])).collect();
        plan.see(&many, Now::ZERO);
        assert_eq!(plan.fires.len(), FIRES_MAX);
    }

    #[test]
    fn a_plan_is_for_its_fires_monitors_wind_and_pressure() {
        let wind = |from: f64, speed_mps| Wind { from: from.to_radians(), speed_mps };
        let able: BTreeSet<String> = ["M1".to_owned(), "M2".to_owned()].into();
        let (fires, wind_now) = (vec![(1, [0.0, 20.0])], wind(350.0, 6.0));
        let basis = Basis { fires, able, wind: wind_now, pressure_mpa: 0.8 };
        let like = |change: &dyn Fn(&mut Basis)| {
            let mut other = basis.clone();
            change(&mut other);
            (basis.has_others(&other), basis.is_like(&other))
        };
        assert_eq!(like(&|_| {}), (false, true));
        assert_eq!(like(&|it| it.wind = wind(2.0, 6.0)), (false, true));
        assert_eq!(like(&|it| it.wind = wind(10.0, 6.0)), (false, false));
        assert_eq!(like(&|it| it.wind = wind(350.0, 8.0)), (false, false));
        assert_eq!(like(&|it| it.pressure_mpa = 0.74), (false, true));
        assert_eq!(like(&|it| it.pressure_mpa = 0.7), (false, false));
        assert_eq!(like(&|it| it.fires[0].1 = [0.0, 22.5]), (false, false));
        assert_eq!(like(&|it| it.fires[0].0 = 2), (true, false));
        assert_eq!(like(&|it| _ = it.able.remove("M2")), (true, false));
    }
}
