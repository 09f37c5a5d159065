//! Coverage: how many jets reach each cell of a grid, in still air and in each wind, after the rules.

use lafet_texts::place as text;
use serde::Serialize;

use crate::obstacle::Body;
use crate::reach::Reach;
use crate::site::{Site, Wind};
use crate::text::{Problem, counted, within};
use crate::throws::Cache;
use crate::{CELLS_MAX, FARTHEST_M, WINDS_MAX};

/// Count of a cell that an obstacle covers: nothing is to be protected there.
pub const COVERED: u8 = u8::MAX;
/// Most of the weakest points that are named, and how far they lie apart, m.
pub const WEAKEST_MAX: usize = 8;
const WEAKEST_APART_M: f64 = 5.0;

/// After which rule a jet counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Rule {
    /// It comes down there.
    Reached,
    /// And within 90 % of its throw in this wind.
    Within90,
    /// And within 75 % of its throw in still air.
    Within75,
}

impl Rule {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Reached, Self::Within90, Self::Within75];
}

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// South-west corner, east and north, m.
    pub corner: [f64; 2],
    /// Extent to the east and to the north, m.
    pub size: [f64; 2],
    /// Side of a cell, m.
    pub cell_m: f64,
    /// Height of what is protected above the ground, m.
    pub plane_m: f64,
    /// The winds besides still air.
    pub winds: Vec<Wind>,
    /// How many monitors flow together: it determines the pressure that is left.
    pub flowing: usize,
}

/// How many jets reach each cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// Cells to the east and to the north.
    pub cells: [usize; 2],
    /// Pressure that was computed with, MPa.
    pub pressure_mpa: f64,
    /// Of still air and each wind, of each rule: counts by cell, row by row from the south-west corner.
    counts: Vec<[Vec<u8>; 3]>,
    /// See [`Summary`].
    pub summary: Summary,
}

/// What a coverage comes to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Cells to be protected: those that no obstacle covers.
    pub protected: usize,
    /// Still air first, then the winds in their order.
    pub winds: Vec<InWind>,
    /// The weakest points, worst first.
    pub weakest: Vec<Weak>,
    /// What the loss of each monitor costs, in their order.
    pub lost: Vec<Lost>,
}

/// A coverage in one wind, by rule as in [`Rule::ALL`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InWind {
    /// The wind.
    pub wind: Wind,
    /// Share of the cells with a jet or more.
    pub one: [f64; 3],
    /// Share with two or more.
    pub two: [f64; 3],
    /// Fewest jets on a cell.
    pub fewest: [u8; 3],
}

/// A point that few jets reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Weak {
    /// Its centre, m.
    pub at: [f64; 2],
    /// Fewest jets within 90 % of their throw, of still air and all winds.
    pub fewest: u8,
    /// Jets within 90 % of their throw in still air.
    pub still: u8,
}

/// What remains without one monitor, within 90 % of the throw: the worst of still air and all winds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lost {
    /// Name of the monitor.
    pub monitor: String,
    /// Share of the cells that no jet reaches any more.
    pub none_left: f64,
    /// Share of the cells that fall from two jets to one.
    pub one_left: f64,
}

impl Area {
    /// Refuses what is no number or too much.
    pub fn check(&self, monitors: usize) -> Result<(), Problem> {
        for value in self.corner {
            let what = &text::AreaCorner;
            within(what, value, -FARTHEST_M..=FARTHEST_M)?;
        }
        for value in self.size {
            within(&text::AreaExtent, value, 0.1..=5000.0)?;
        }
        within(&text::CellSide, self.cell_m, 0.05..=100.0)?;
        let what = &text::PlaneHeight;
        within(what, self.plane_m, -100.0..=200.0)?;
        let [east, north] = self.size.map(|size| (size / self.cell_m).ceil().max(1.0));
        let cells = east * north;
        if cells > CELLS_MAX as f64 {
            return Err(Problem::new(text::TooManyCells { cells, most: CELLS_MAX }));
        }
        counted(&text::Winds, self.winds.len(), 0..=WINDS_MAX)?;
        self.winds.iter().try_for_each(Wind::check)?;
        let what = &text::FlowingMonitors;
        counted(what, self.flowing, 1..=monitors.max(1))
    }

    /// Cells to the east and to the north.
    fn cells(&self) -> [usize; 2] {
        self.size.map(|size| (size / self.cell_m).ceil().max(1.0) as usize)
    }

    /// The centre of a cell.
    fn centre(&self, index: usize) -> [f64; 2] {
        let [east, _] = self.cells();
        let (column, row) = (index % east, index / east);
        let at = |corner: f64, number: usize| corner + (number as f64 + 0.5) * self.cell_m;
        [at(self.corner[0], column), at(self.corner[1], row)]
    }
}

impl Coverage {
    /// Computes the coverage of an area.
    pub fn of(site: &Site, area: &Area) -> Result<Self, Problem> {
        site.check()?;
        area.check(site.monitors.len())?;
        let cells = area.cells();
        let pressure_mpa = site.pressure_mpa(area.flowing);
        let covered: Vec<bool> = (0..cells[0] * cells[1])
            .map(|index| is_covered(&site.obstacles, area.centre(index), area.plane_m))
            .collect();
        let protected = covered.iter().filter(|it| !**it).count();
        let mut cache = Cache::default();
        let mut counts = Vec::new();
        let mut winds = Vec::new();
        let mut lost = vec![[0_usize; 2]; site.monitors.len()];
        let mut sets = vec![[0_u64; 3]; covered.len()];
        for wind in std::iter::once(Wind::default()).chain(area.winds.iter().copied()) {
            sets.fill([0; 3]);
            for index in 0..site.monitors.len() {
                let setting = (wind, pressure_mpa, area.plane_m);
                let Ok(reach) = Reach::new(site, index, setting, &mut cache) else { continue };
                mark(&reach, index, area, &covered, &mut sets);
            }
            let by_rule = [0, 1, 2].map(|rule| count(&sets, &covered, rule));
            winds.push(in_wind(wind, &by_rule, protected));
            worsen(&mut lost, &sets);
            counts.push(by_rule);
        }
        let of_all = |count: usize| share(count, protected);
        let lost = site.monitors.iter().zip(lost).map(|(monitor, [none, one])| Lost {
            monitor: monitor.name.clone(),
            none_left: of_all(none),
            one_left: of_all(one),
        });
        let summary =
            Summary { protected, winds, weakest: weakest(area, &counts), lost: lost.collect() };
        Ok(Self { cells, pressure_mpa, counts, summary })
    }

    /// Counts by cell, row by row from the south-west corner, in still air (0) or a wind (from 1) after a
    /// rule; [`COVERED`] where an obstacle is. Empty if there is no such wind.
    pub fn counts(&self, wind: usize, rule: Rule) -> &[u8] {
        self.counts.get(wind).map_or(&[], |by_rule| &by_rule[rule as usize])
    }
}

/// Whether an obstacle is on a place and rises above the plane.
fn is_covered(obstacles: &[Body], [east, north]: [f64; 2], plane_m: f64) -> bool {
    obstacles.iter().any(|body| body.holds([east, north, plane_m + 0.01]))
}

/// Marks the cells that a monitor reaches, a bit in each rule's set.
fn mark(reach: &Reach<'_>, index: usize, area: &Area, covered: &[bool], sets: &mut [[u64; 3]]) {
    let bit = 1 << index;
    for (cell, set) in sets.iter_mut().enumerate() {
        if covered[cell] {
            continue;
        }
        let Ok(aim) = reach.aim(area.centre(cell)) else { continue };
        set[0] |= bit;
        if aim.is_within_90() {
            set[1] |= bit;
        }
        if aim.is_within_75() {
            set[2] |= bit;
        }
    }
}

fn count(sets: &[[u64; 3]], covered: &[bool], rule: usize) -> Vec<u8> {
    let jets = |(set, covered): (&[u64; 3], &bool)| {
        if *covered { COVERED } else { set[rule].count_ones() as u8 }
    };
    sets.iter().zip(covered).map(jets).collect()
}

fn share(count: usize, all: usize) -> f64 {
    if all == 0 { 0.0 } else { count as f64 / all as f64 }
}

fn in_wind(wind: Wind, by_rule: &[Vec<u8>; 3], protected: usize) -> InWind {
    let at_least = |least: u8| {
        [0, 1, 2].map(|rule: usize| {
            let cells = by_rule[rule].iter().filter(|jets| **jets != COVERED && **jets >= least);
            share(cells.count(), protected)
        })
    };
    let fewest = |counts: &Vec<u8>| {
        counts.iter().copied().filter(|jets| *jets != COVERED).min().unwrap_or_default()
    };
    InWind {
        wind,
        one: at_least(1),
        two: at_least(2),
        fewest: [0, 1, 2].map(|it: usize| fewest(&by_rule[it])),
    }
}

/// What each lost monitor would cost in this wind, if it is worse than in those before.
fn worsen(lost: &mut [[usize; 2]], sets: &[[u64; 3]]) {
    for (index, worst) in lost.iter_mut().enumerate() {
        let with = sets.iter().map(|set| set[1]).filter(|set| set >> index & 1 == 1);
        let (mut none, mut one) = (0, 0);
        for set in with {
            match set.count_ones() {
                1 => none += 1,
                2 => one += 1,
                _ => {}
            }
        }
        *worst = [worst[0].max(none), worst[1].max(one)];
    }
}

/// The cells with the fewest jets within 90 % in any wind, apart from each other.
fn weakest(area: &Area, counts: &[[Vec<u8>; 3]]) -> Vec<Weak> {
    let Some(still) = counts.first() else { return Vec::new() };
    let fewest = |cell: usize| counts.iter().map(|by_rule| by_rule[1][cell]).min().unwrap_or(0);
    let all = |cell: usize| counts.iter().map(|by_rule| u32::from(by_rule[1][cell])).sum::<u32>();
    let protected = (0..still[1].len()).filter(|cell| still[1][*cell] != COVERED);
    let mut order: Vec<(u8, u32, usize)> =
        protected.map(|cell| (fewest(cell), all(cell), cell)).collect();
    order.sort_unstable();
    let mut weakest: Vec<Weak> = Vec::new();
    for (fewest, _, cell) in order {
        let at = area.centre(cell);
        let apart =
            |other: &Weak| (other.at[0] - at[0]).hypot(other.at[1] - at[1]) >= WEAKEST_APART_M;
        if weakest.iter().all(apart) {
            weakest.push(Weak { at, fewest, still: still[1][cell] });
        }
        if weakest.len() == WEAKEST_MAX {
            break;
        }
    }
    weakest
}

#[cfg(test)]
#[path = "coverage_tests.rs"]
mod tests;
