//! The assignment itself: a local search, and the exact optimum of small tasks to compare it with.

use serde::Serialize;

use crate::draw::Draw;
use crate::site::Direction;

/// The fire of each monitor, by index.
pub type Assignment = Vec<Option<usize>>;

/// Shortfalls that differ by less are the same.
pub const SAME: f64 = 1e-6;
/// Improvements of a search; far more than any takes.
const IMPROVEMENTS_MAX: usize = 500;
/// Further starts for small tasks: at most so many, fewer the larger monitors² · fires.
const STARTS_MAX: usize = 12;
const STARTS_SIZE: usize = 4000;
/// Searches for a quicker assignment.
const QUICKER_MAX: usize = 16;

/// How a monitor is to aim at a fire.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Aimed {
    /// Where the barrel points.
    pub direction: Direction,
    /// Whether it is the high one of the two solutions.
    pub steep: bool,
    /// Distance in plan, m; it is within 90 % of the throw in this wind.
    pub distance_m: f64,
}

/// What a monitor brings to a fire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offer {
    /// Flow that falls on the fire, l/min.
    pub brings_lpm: f64,
    /// Time to turn there, s.
    pub turn_s: f64,
    /// How it aims.
    pub aim: Option<Aimed>,
}

/// Offers while at most so many monitors flow.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// At most so many.
    pub flowing: usize,
    /// By monitor and fire.
    pub offers: Vec<Vec<Option<Offer>>>,
}

/// Monitors and fires to be assigned.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// What each fire needs, l/min.
    pub needs_lpm: Vec<f64>,
    /// Offers by the number that flows, ascending; the last serves more.
    pub levels: Vec<Level>,
}

/// What an assignment comes to; less is better, in this order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Score {
    /// Sum over the fires of the part of its need that is missing.
    pub shortfall: f64,
    /// Monitors that flow.
    pub monitors: usize,
    /// Time until the last one has turned, s.
    pub turn_s: f64,
}

impl Task {
    /// The offers that count while so many flow.
    pub fn level(&self, flowing: usize) -> &Level {
        let fitting = self.levels.iter().position(|level| level.flowing >= flowing);
        &self.levels[fitting.unwrap_or(self.levels.len() - 1)]
    }

    fn monitors(&self) -> usize {
        self.levels[0].offers.len()
    }
}

/// Whether a score is better than another.
pub fn better(a: &Score, b: &Score) -> bool {
    if (a.shortfall - b.shortfall).abs() > SAME {
        return a.shortfall < b.shortfall;
    }
    a.monitors < b.monitors || a.monitors == b.monitors && a.turn_s < b.turn_s - SAME
}

/// The score of an assignment; a monitor that cannot flow on its fire brings nothing.
pub fn score(task: &Task, assignment: &Assignment) -> Score {
    let flowing = assignment.iter().flatten().count();
    score_at(task, task.level(flowing), assignment)
}

fn score_at(task: &Task, level: &Level, assignment: &Assignment) -> Score {
    let mut brought = [0.0; crate::FIRES_MAX];
    let (mut monitors, mut turn_s) = (0, 0.0_f64);
    for (offers, fire) in level.offers.iter().zip(assignment) {
        let Some(fire) = *fire else { continue };
        monitors += 1;
        if let Some(offer) = offers[fire] {
            brought[fire] += offer.brings_lpm;
            turn_s = turn_s.max(offer.turn_s);
        }
    }
    let missing = |(need, brought): (&f64, &f64)| (1.0 - brought / need).max(0.0);
    let shortfall = task.needs_lpm.iter().zip(&brought).map(missing).sum();
    Score { shortfall, monitors, turn_s }
}

/// A good assignment. Once it is found it is looked for again without the offers that take as long to
/// turn, as long as that is as good otherwise.
pub fn assign(task: &Task) -> Assignment {
    let mut best = searched(task);
    let mut best_score = score(task, &best);
    for _ in 0..QUICKER_MAX {
        let quicker = searched(&quicker(task, best_score.turn_s));
        let quicker_score = score(task, &quicker);
        if !better(&quicker_score, &best_score) {
            break;
        }
        (best, best_score) = (quicker, quicker_score);
    }
    best
}

/// The task without offers that take so long to turn.
fn quicker(task: &Task, turn_s: f64) -> Task {
    let mut task = task.clone();
    for offer in task.levels.iter_mut().flat_map(|level| level.offers.iter_mut().flatten()) {
        *offer = offer.filter(|offer| offer.turn_s < turn_s - SAME);
    }
    task
}

/// From an empty assignment and for each number of monitors, what improves most is changed until nothing
/// improves; the best of all is taken.
fn searched(task: &Task) -> Assignment {
    let monitors = task.monitors();
    let empty: Assignment = vec![None; monitors];
    let mut best = empty.clone();
    let mut best_score = score(task, &best);
    let mut from = empty;
    let mut draw = Draw::new(1);
    let size = monitors * monitors * task.needs_lpm.len().max(1);
    let more = (STARTS_SIZE / size.max(1)).min(STARTS_MAX);
    for level in &task.levels {
        // What was found with fewer is a start, and so is nothing; small tasks have time for more.
        let mut starts = vec![from.clone(), vec![None; monitors]];
        starts.extend((0..more).map(|_| drawn(&mut draw, level)));
        for start in starts {
            let found = pruned(task, &improved(task, level, start));
            let found_score = score(task, &found);
            if better(&found_score, &best_score) {
                (best, best_score) = (found.clone(), found_score);
            }
            from = found;
        }
    }
    best
}

/// An assignment at random, with as many monitors as the level allows.
fn drawn(draw: &mut Draw, level: &Level) -> Assignment {
    let mut start: Assignment = vec![None; level.offers.len()];
    for _ in 0..level.flowing {
        let monitor = draw.below(start.len());
        let fires =
            (0..level.offers[monitor].len()).filter(|it| level.offers[monitor][*it].is_some());
        let fires: Vec<usize> = fires.collect();
        if !fires.is_empty() {
            start[monitor] = Some(fires[draw.below(fires.len())]);
        }
    }
    start
}

/// Improves an assignment while at most so many flow as the level allows.
fn improved(task: &Task, level: &Level, start: Assignment) -> Assignment {
    let mut now = start;
    for (offers, fire) in level.offers.iter().zip(now.iter_mut()) {
        if fire.is_some_and(|it| offers[it].is_none()) {
            *fire = None;
        }
    }
    let mut now_score = score_at(task, level, &now);
    for _ in 0..IMPROVEMENTS_MAX {
        let Some((next, next_score)) = best_change(task, level, &now, &now_score) else { break };
        (now, now_score) = (next, next_score);
    }
    now
}

/// The best of all changes: one monitor elsewhere, with what becomes superfluous closed; or two swapped.
fn best_change(
    task: &Task,
    level: &Level,
    now: &Assignment,
    now_score: &Score,
) -> Option<(Assignment, Score)> {
    let mut best: Option<(Assignment, Score)> = None;
    let mut look = |changed: &Assignment| {
        let score = score_at(task, level, changed);
        let than = best.as_ref().map_or(now_score, |(_, score)| score);
        if score.monitors <= level.flowing && better(&score, than) {
            best = Some((changed.clone(), score));
        }
    };
    let mut changed = now.clone();
    for monitor in 0..now.len() {
        let own = now[monitor];
        let fires = (0..task.needs_lpm.len()).filter(|fire| level.offers[monitor][*fire].is_some());
        for fire in fires.map(Some).chain([None]).filter(|fire| *fire != own) {
            changed[monitor] = fire;
            look(&changed);
            // In the place of another one, of the same fire or of any.
            for other in (0..now.len()).filter(|other| *other != monitor && now[*other].is_some()) {
                let was = changed[other];
                changed[other] = None;
                look(&changed);
                let swapped = own.filter(|own| level.offers[other][*own].is_some());
                if swapped.is_some() {
                    changed[other] = swapped;
                    look(&changed);
                }
                changed[other] = was;
            }
        }
        changed[monitor] = own;
    }
    best
}

/// Closes monitors whose water is not needed, the one that brings least first, of equal ones the last.
fn pruned(task: &Task, assignment: &Assignment) -> Assignment {
    let mut now = assignment.clone();
    loop {
        let now_score = score(task, &now);
        let without = |monitor: usize| {
            let mut less = now.clone();
            less[monitor] = None;
            let score = score(task, &less);
            (less, score)
        };
        let open = (0..now.len()).filter(|monitor| now[*monitor].is_some());
        let best = open
            .map(without)
            .filter(|(_, score)| better(score, &now_score))
            .reduce(|best, other| if better(&best.1, &other.1) { best } else { other });
        let Some((less, _)) = best else { return now };
        now = less;
    }
}

/// What is left of an assignment, filled with monitors that are free; nothing that flows is moved.
pub(super) fn repaired(task: &Task, before: &Assignment) -> Assignment {
    let mut now: Assignment = vec![None; task.monitors()];
    let level = task.level(before.iter().flatten().count());
    for (monitor, fire) in before.iter().enumerate().take(now.len()) {
        let holds = |fire: &usize| level.offers[monitor].get(*fire).is_some_and(Option::is_some);
        now[monitor] = fire.filter(holds);
    }
    loop {
        let now_score = score(task, &now);
        let mut best: Option<(Assignment, Score)> = None;
        for monitor in (0..now.len()).filter(|monitor| now[*monitor].is_none()) {
            for fire in 0..task.needs_lpm.len() {
                let mut more = now.clone();
                more[monitor] = Some(fire);
                let more_score = score(task, &more);
                let than = best.as_ref().map_or(&now_score, |(_, score)| score);
                if better(&more_score, than) {
                    best = Some((more, more_score));
                }
            }
        }
        let Some((more, _)) = best else { break };
        now = more;
    }
    pruned(task, &now)
}

/// An assignment with jets beyond what is needed, as long as at most so many monitors flow: each on the fire
/// that has fewest, where it was before if that is one of these, else where it brings most. None joins that
/// leaves another one too little pressure.
pub fn filled(task: &Task, assignment: Assignment, before: &Assignment, most: usize) -> Assignment {
    let mut now = assignment;
    while now.iter().flatten().count() < most {
        let level = task.level(now.iter().flatten().count() + 1);
        let flows = |(monitor, fire): (usize, &Option<usize>)| {
            fire.is_none_or(|fire| level.offers[monitor][fire].is_some())
        };
        if !now.iter().enumerate().all(flows) {
            break;
        }
        let jets = |fire: usize| now.iter().filter(|it| **it == Some(fire)).count();
        let free = (0..now.len()).filter(|monitor| now[*monitor].is_none());
        let joins = free.flat_map(|monitor| {
            let offers = level.offers[monitor].iter().enumerate();
            let moved = move |fire| before.get(monitor) != Some(&Some(fire));
            offers.filter_map(move |(fire, offer)| {
                Some((monitor, fire, moved(fire), offer.as_ref()?.brings_lpm))
            })
        });
        let best = joins.min_by(|a, b| {
            let rank = |it: &(usize, usize, bool, f64)| (jets(it.1), it.2);
            rank(a).cmp(&rank(b)).then(b.3.total_cmp(&a.3))
        });
        let Some((monitor, fire, ..)) = best else { break };
        now[monitor] = Some(fire);
    }
    now
}

/// The exact optimum, by trying every assignment: for tests and for tasks of a few monitors. None if
/// there are more than `most` of them.
pub fn exhaustive(task: &Task, most: usize) -> Option<Assignment> {
    let choices = task.needs_lpm.len() + 1;
    let count = choices.checked_pow(u32::try_from(task.monitors()).ok()?)?;
    if count > most {
        return None;
    }
    let mut best: Assignment = vec![None; task.monitors()];
    let mut best_score = score(task, &best);
    let mut now = best.clone();
    for number in 1..count {
        let mut rest = number;
        for fire in &mut now {
            *fire = (rest % choices).checked_sub(1);
            rest /= choices;
        }
        let now_score = score(task, &now);
        if better(&now_score, &best_score) {
            (best, best_score) = (now.clone(), now_score);
        }
    }
    Some(best)
}
