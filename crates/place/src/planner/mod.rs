//! Which monitors on which fire: the best density on the fires, then the fewest monitors, then the time
//! to turn.
//!
//! ```text
//! Situation (site, fires, wind, what is lost) ─▶ offers: what each monitor brings to each fire
//!                                              └▶ assign: local search over assignments ─▶ Plan
//! ```
//!
//! The more monitors flow the less pressure is left, so offers depend on the number that flows. They are
//! computed for 1, 2, 4, 8 … of them; in between, those of the next larger number count.

mod assign;
mod offers;

pub use assign::{
    Aimed, Assignment, Level, Offer, Score, Task, assign, better, exhaustive, filled, score,
};
pub use offers::{Situation, Turned, offers};

use lafet_texts::place as text;
use serde::Serialize;

use crate::site::Site;
use crate::text::{Problem, within};
use crate::{FARTHEST_M, Place};

/// A new plan takes over only if it brings this much more of what a fire needs, unless it needs fewer
/// monitors for the same.
pub const GAIN: f64 = 0.05;

/// A fire.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fire {
    /// Its place.
    pub at: Place,
    /// Area, m².
    pub area_m2: f64,
    /// Density that it needs, l/min/m².
    pub density_lpm_m2: f64,
}

impl Fire {
    /// Refuses what is no number or no fire.
    pub fn check(&self) -> Result<(), Problem> {
        for value in self.at {
            let what = &text::FirePlace;
            within(what, value, -FARTHEST_M..=FARTHEST_M)?;
        }
        within(&text::FireArea, self.area_m2, 0.1..=100_000.0)?;
        let what = &text::FireDensity;
        within(what, self.density_lpm_m2, 0.1..=1000.0)
    }

    /// Flow that it needs, l/min.
    pub fn needs_lpm(&self) -> f64 {
        self.area_m2 * self.density_lpm_m2
    }
}

/// What to do.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// The fire of each monitor, by index; none where it stays closed.
    pub assignment: Assignment,
    /// How each assigned monitor aims at its fire.
    pub aims: Vec<Option<Aimed>>,
    /// What it comes to.
    pub score: Score,
    /// Density on each fire, l/min/m².
    pub densities: Vec<f64>,
    /// Pressure that is left, MPa.
    pub pressure_mpa: f64,
}

/// Plans from nothing.
pub fn plan(site: &Site, situation: &Situation) -> Result<Plan, Problem> {
    let task = offers(site, situation)?;
    Ok(finished(site, situation, &task, assign(&task)))
}

/// Plans again after something has changed: a monitor lost, another wind, a fire out or new. What is
/// assigned stays where it is unless a change brings [`GAIN`].
pub fn again(site: &Site, situation: &Situation, before: &Assignment) -> Result<Plan, Problem> {
    let task = offers(site, situation)?;
    let chosen = renewed(&task, before);
    Ok(finished(site, situation, &task, chosen))
}

/// The same for a task whose offers are known.
pub fn renewed(task: &Task, before: &Assignment) -> Assignment {
    let kept = assign::repaired(task, before);
    let fresh = assign(task);
    let (old, new) = (score(task, &kept), score(task, &fresh));
    let gain = old.shortfall - new.shortfall;
    let fewer = gain.abs() <= assign::SAME && new.monitors < old.monitors;
    if gain > GAIN || fewer { fresh } else { kept }
}

fn finished(site: &Site, situation: &Situation, task: &Task, assignment: Assignment) -> Plan {
    let flowing = assignment.iter().flatten().count();
    let level = task.level(flowing);
    let mut densities = vec![0.0; situation.fires.len()];
    let mut aims = vec![None; assignment.len()];
    for (monitor, fire) in assignment.iter().enumerate() {
        let Some(fire) = *fire else { continue };
        let Some(offer) = level.offers[monitor][fire] else { continue };
        densities[fire] += offer.brings_lpm / situation.fires[fire].area_m2;
        aims[monitor] = offer.aim;
    }
    let score = score(task, &assignment);
    let pressure_mpa = offers::pressure_mpa(site, situation, flowing);
    Plan { aims, score, densities, pressure_mpa, assignment }
}

#[cfg(test)]
mod tests;
