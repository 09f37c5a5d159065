//! Several fires: which bearings belong together, and which crossings are ghosts.
//!
//! Two fires and two stations give four crossings, and azimuths alone cannot tell which two are the
//! fires. Every set of bearings that meets in a place is a candidate. An explanation gives each bearing to one
//! candidate or leaves it alone; the best ones need the fewest sources, a bearing left alone being one.
//! A candidate is [`Standing::Sure`] if it is part of every best explanation, [`Standing::Ghost`] if it is
//! part of none, else [`Standing::Doubtful`]. Only sure ones may be aimed at.

use serde::Serialize;

use crate::locate::{Fix, Solved, check, solve};
use crate::station::{Bearing, Station};
use crate::text::Problem;

/// Most candidates, and most steps of the search; beyond, nothing is sure.
const CANDIDATES_MAX: usize = 512;
const STEPS_MAX: usize = 200_000;
/// Most explanations that are kept.
const EXPLANATIONS_MAX: usize = 4096;
/// By how much χ² may exceed that of the best explanation: 1 in 1000.
const MISFIT_MARGIN: f64 = 10.83;

/// What a place is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// Part of every explanation of the bearings: a fire.
    Sure,
    /// Part of some explanations: it may be a fire or a ghost. A third station or an elevation decides.
    Doubtful,
    /// Lines of sight that cross without a fire.
    Ghost,
}

/// A place where lines of sight cross.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// The place.
    pub fix: Fix,
    /// What it is worth.
    pub standing: Standing,
}

impl Candidate {
    /// The place to aim at; none unless it is sure.
    pub fn aim(&self) -> Option<&Fix> {
        (self.standing == Standing::Sure).then_some(&self.fix)
    }
}

/// The area in which there can be fires: least and greatest east and north, m.
pub type Area = [[f64; 2]; 2];

/// Every place where bearings cross, sure ones first. `level_m` as for [`crate::locate::locate`].
pub fn fires(
    stations: &[Station],
    bearings: &[Bearing],
    level_m: f64,
    area: Option<Area>,
) -> Result<Vec<Candidate>, Problem> {
    check(stations, bearings, level_m)?;
    let crossings = Crossings::find(stations, bearings, level_m, area);
    let best = if crossings.complete { explanations(&crossings, bearings.len()) } else { None };
    let standing = |bearings: u64| {
        let Some(best) = &best else { return Standing::Doubtful };
        // A set of fewer bearings is the same fire, if it leaves the others to another one.
        let same = |set: &usize| {
            let other = crossings.sets[*set].bearings;
            [bearings, other].contains(&(bearings & other))
        };
        let has = |explanation: &&Vec<usize>| explanation.iter().any(same);
        match best.iter().filter(has).count() {
            0 => Standing::Ghost,
            count if count == best.len() => Standing::Sure,
            _ => Standing::Doubtful,
        }
    };
    let mut candidates: Vec<Candidate> = crossings
        .widest()
        .map(|set| Candidate { fix: set.fix(), standing: standing(set.bearings) })
        .collect();
    doubt_rivals(&mut candidates);
    let ghosts = crossings.refuted.iter();
    candidates.extend(ghosts.map(|set| Candidate { fix: set.fix(), standing: Standing::Ghost }));
    candidates.sort_by_key(|candidate| (candidate.standing as u8, candidate.fix.used.clone()));
    Ok(candidates)
}

/// Two places that claim the same bearing are not both sure.
fn doubt_rivals(candidates: &mut [Candidate]) {
    let sure = |candidate: &Candidate| candidate.standing == Standing::Sure;
    let claims = candidates.iter().filter(|it| sure(it)).flat_map(|it| it.fix.used.clone());
    let mut claimed = [0_usize; 64];
    claims.for_each(|bearing| claimed[bearing] += 1);
    for candidate in candidates.iter_mut().filter(|it| sure(it)) {
        if candidate.fix.used.iter().any(|bearing| claimed[*bearing] > 1) {
            candidate.standing = Standing::Doubtful;
        }
    }
}

/// Bearings that meet, a bit each, and where.
#[derive(Clone, Copy, Debug)]
struct Set {
    bearings: u64,
    solved: Solved,
}

impl Set {
    fn fix(&self) -> Fix {
        self.solved.fix(indices(self.bearings).collect(), Vec::new())
    }
}

struct Crossings {
    sets: Vec<Set>,
    /// Pairs that cross in plan, but whose elevations contradict each other or which are outside.
    refuted: Vec<Set>,
    /// Whether all of them fitted.
    complete: bool,
}

impl Crossings {
    fn find(stations: &[Station], bearings: &[Bearing], level_m: f64, area: Option<Area>) -> Self {
        let mut found = Self { sets: Vec::new(), refuted: Vec::new(), complete: true };
        let outside = |at: [f64; 3]| {
            area.is_some_and(|[least, most]| {
                (0..2).any(|axis| !(least[axis]..=most[axis]).contains(&at[axis]))
            })
        };
        for first in 0..bearings.len() {
            for second in first + 1..bearings.len() {
                if bearings[first].station == bearings[second].station {
                    continue;
                }
                let pair = 1 << first | 1 << second;
                let Some(solved) = solve(stations, bearings, &[first, second], level_m) else {
                    continue;
                };
                if found.sets.len() + found.refuted.len() >= CANDIDATES_MAX {
                    found.complete = false;
                    return found;
                }
                let set = Set { bearings: pair, solved };
                if !solved.is_likely() || outside(solved.at) {
                    found.refuted.push(set);
                    continue;
                }
                found.extend(stations, bearings, level_m, set);
            }
        }
        found
    }

    /// Adds a pair, and it with a bearing of each further station that meets it.
    fn extend(&mut self, stations: &[Station], bearings: &[Bearing], level_m: f64, pair: Set) {
        let mut seen: u64 = 0;
        for index in indices(pair.bearings) {
            seen |= 1 << bearings[index].station;
        }
        let mut set = pair;
        self.add(set);
        for station in 0..stations.len() {
            if seen >> station & 1 == 1 {
                continue;
            }
            let own = (0..bearings.len()).filter(|index| bearings[*index].station == station);
            let with = own.filter_map(|index| {
                let bits = set.bearings | 1 << index;
                let all: Vec<usize> = indices(bits).collect();
                let solved = solve(stations, bearings, &all, level_m)?;
                solved.is_likely().then_some(Set { bearings: bits, solved })
            });
            if let Some(wider) = with.min_by(|a, b| a.solved.misfit.total_cmp(&b.solved.misfit)) {
                set = wider;
                self.add(set);
            }
        }
    }

    fn add(&mut self, set: Set) {
        if !self.sets.iter().any(|known| known.bearings == set.bearings) {
            self.sets.push(set);
        }
    }

    /// Sets that are not part of a wider one.
    fn widest(&self) -> impl Iterator<Item = &Set> {
        let wider = |set: &Set, other: &Set| {
            other.bearings != set.bearings && other.bearings & set.bearings == set.bearings
        };
        self.sets.iter().filter(move |set| !self.sets.iter().any(|other| wider(set, other)))
    }
}

fn indices(bits: u64) -> impl Iterator<Item = usize> {
    (0..64).filter(move |index| bits >> index & 1 == 1)
}

/// The best explanations, each a list of sets; none when there are too many to go through.
fn explanations(crossings: &Crossings, bearings: usize) -> Option<Vec<Vec<usize>>> {
    let all = if bearings == 64 { u64::MAX } else { (1 << bearings) - 1 };
    let mut search =
        Search { crossings, sources: bearings, kept: Vec::new(), steps: 0, chosen: Vec::new() };
    search.go(all, 0, 0.0)?;
    let least = search.kept.iter().map(|(_, misfit)| *misfit).fold(f64::INFINITY, f64::min);
    let likely = search.kept.into_iter().filter(|(_, misfit)| *misfit <= least + MISFIT_MARGIN);
    Some(likely.map(|(sets, _)| sets).collect())
}

struct Search<'a> {
    crossings: &'a Crossings,
    /// Fewest sources so far.
    sources: usize,
    /// Explanations with so many sources, and their χ².
    kept: Vec<(Vec<usize>, f64)>,
    steps: usize,
    chosen: Vec<usize>,
}

impl Search<'_> {
    /// Explains the bearings that are left; none when it takes too long.
    fn go(&mut self, left: u64, sources: usize, misfit: f64) -> Option<()> {
        self.steps += 1;
        if self.steps > STEPS_MAX || self.kept.len() > EXPLANATIONS_MAX {
            return None;
        }
        if left == 0 {
            if sources < self.sources {
                self.kept.clear();
                self.sources = sources;
            }
            self.kept.push((self.chosen.clone(), misfit));
            return Some(());
        }
        if sources >= self.sources {
            return Some(());
        }
        let first = 1 << left.trailing_zeros();
        for index in 0..self.crossings.sets.len() {
            let Set { bearings, solved } = self.crossings.sets[index];
            if bearings & first != 0 && bearings & left == bearings {
                self.chosen.push(index);
                self.go(left & !bearings, sources + 1, misfit + solved.misfit)?;
                self.chosen.pop();
            }
        }
        self.go(left & !first, sources + 1, misfit)
    }
}

#[cfg(test)]
#[path = "fires_tests.rs"]
mod tests;
