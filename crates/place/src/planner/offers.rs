//! What each monitor brings to each fire in the wind and with the pressure that is left.

use lafet_texts::place as text;

use super::{Aimed, Fire, Level, Offer, Task};
use crate::FIRES_MAX;
use crate::flown::{Gun, Shot};
use crate::reach::{OF_THROW, passing, pointing, turning_s};
use crate::site::{Direction, Monitor, Site, Wind};
use crate::text::{Problem, counted, within};

/// Length of a footprint over the range, its width at the nozzle and per metre of range for the
/// narrowest jet, and how much wider the widest is per metre. From the table of sprays of docs/physics.md.
const LENGTH_PER_RANGE: f64 = 0.4;
const WIDTH_M: f64 = 0.6;
const WIDTH_PER_RANGE: f64 = 0.035;
const WIDTH_OF_SPRAY: f64 = 1.4;

/// Where a barrel is and whether it can be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turned {
    /// Where it points.
    pub to: Direction,
    /// Whether it works: it is not lost, locked out, or held by a hand.
    pub works: bool,
}

/// What there is to be planned for.
#[derive(Clone, Debug, PartialEq)]
pub struct Situation {
    /// The fires.
    pub fires: Vec<Fire>,
    /// The wind.
    pub wind: Wind,
    /// The monitors, in the order of the site.
    pub monitors: Vec<Turned>,
}

impl Situation {
    /// Refuses what does not belong to the site, is no number or too much.
    pub fn check(&self, site: &Site) -> Result<(), Problem> {
        site.check()?;
        counted(&text::Fires, self.fires.len(), 1..=FIRES_MAX)?;
        self.fires.iter().try_for_each(Fire::check)?;
        self.wind.check()?;
        let all = site.monitors.len();
        counted(&text::MonitorStates, self.monitors.len(), all..=all)?;
        for Direction { bearing, elevation } in self.monitors.iter().map(|it| it.to) {
            for angle in [bearing, elevation] {
                let turn = -std::f64::consts::TAU..=std::f64::consts::TAU;
                within(&text::BarrelDirection, angle, turn)?;
            }
        }
        Ok(())
    }
}

/// Pressure when so many of the working monitors flow, the thirstiest ones, MPa.
pub(super) fn pressure_mpa(site: &Site, situation: &Situation, flowing: usize) -> f64 {
    let working = site.monitors.iter().zip(&situation.monitors).filter(|(_, it)| it.works);
    let mut all: Vec<f64> = working.map(|(monitor, _)| monitor.k_lpm).collect();
    all.sort_by(|a, b| b.total_cmp(a));
    site.supply.left_mpa(all.iter().take(flowing).sum())
}

/// The task of a situation.
pub fn offers(site: &Site, situation: &Situation) -> Result<Task, Problem> {
    situation.check(site)?;
    let working = situation.monitors.iter().filter(|it| it.works).count().max(1);
    let doubled = std::iter::successors(Some(1), |flowing| Some(flowing * 2));
    let counts: Vec<usize> =
        doubled.take_while(|flowing| *flowing < working).chain([working]).collect();
    let fires = situation.fires.len();
    let mut levels: Vec<Level> = counts
        .iter()
        .map(|flowing| Level {
            flowing: *flowing,
            offers: vec![vec![None; fires]; site.monitors.len()],
        })
        .collect();
    let pressures: Vec<f64> =
        counts.iter().map(|flowing| pressure_mpa(site, situation, *flowing)).collect();
    for monitor in (0..site.monitors.len()).filter(|index| situation.monitors[*index].works) {
        for fire in 0..fires {
            let found = of_pair(site, situation, (monitor, fire), &pressures);
            for (level, offer) in levels.iter_mut().zip(found) {
                level.offers[monitor][fire] = Some(offer);
            }
        }
    }
    Ok(Task { needs_lpm: situation.fires.iter().map(Fire::needs_lpm).collect(), levels })
}

/// The offers of a monitor for a fire at falling pressures, as long as it reaches it. A jet that reaches
/// with less pressure reaches with more, so the last that does is found by halving, and its aim
/// serves for all: with more pressure it is corrected before the valve opens.
fn of_pair(
    site: &Site,
    situation: &Situation,
    (monitor, fire): (usize, usize),
    pressures: &[f64],
) -> Vec<Offer> {
    let own = &site.monitors[monitor];
    let Fire { at, area_m2, .. } = situation.fires[fire];
    let (east, north) = (at[0] - own.at[0], at[1] - own.at[1]);
    let (distance, bearing) = (east.hypot(north), east.atan2(north));
    let farthest = |pressure: f64| -> Option<(Gun, Shot)> {
        let gun = Gun::new(own, pressure, situation.wind, at[2])?;
        let shot = gun.beyond(bearing, distance / OF_THROW)?;
        Some((gun, shot))
    };
    let mut reached = None;
    let (mut less, mut more) = (0, pressures.len());
    while less < more {
        let mid = (less + more) / 2;
        match farthest(pressures[mid]) {
            Some(found) => (reached, less) = (Some((mid, found)), mid + 1),
            None => more = mid,
        }
    }
    let Some((last, (gun, beyond))) = reached else { return Vec::new() };
    let clear = |shot: &Shot| {
        pointing(site, monitor, shot.direction).is_ok()
            && passing(site, monitor, &gun.path(shot.direction)).is_ok()
    };
    let aimed = [false, true].into_iter().find_map(|steep| {
        let shot = gun.aim(bearing, distance, &beyond, steep).filter(clear)?;
        Some((shot.direction, steep))
    });
    let Some((direction, steep)) = aimed else { return Vec::new() };
    let Some(turn_s) = turning_s(site, monitor, [situation.monitors[monitor].to, direction]) else {
        return Vec::new();
    };
    let aim = Aimed { direction, steep, distance_m: distance };
    let share = (area_m2 / footprint_m2(own, distance)).min(1.0);
    let offer = |pressure: &f64| Offer {
        brings_lpm: share * own.flow_lpm(*pressure),
        turn_s,
        aim: Some(aim),
    };
    pressures[..=last].iter().map(offer).collect()
}

/// Ground that a jet wets, m². A model of ours: an ellipse.
fn footprint_m2(monitor: &Monitor, range_m: f64) -> f64 {
    let wide = 1.0 - monitor.nozzle_mm / f64::from(lafet_ballistics::NARROWEST_MM);
    let width = WIDTH_M + (WIDTH_PER_RANGE + WIDTH_OF_SPRAY * wide) * range_m;
    0.25 * std::f64::consts::PI * LENGTH_PER_RANGE * range_m.max(1.0) * width
}
