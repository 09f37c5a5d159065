//! What is kept of a run for its pictures: time lines, bars, and where the water fell.

use std::collections::BTreeMap;

use lafet_device::Source;
use lafet_device::image::{Axis, Place};
use lafet_proto::SubsystemId;
use lafet_proto::answer::Reply;
use lafet_proto::flags::Severity;
use lafet_proto::request::Body;
use lafet_texts::{Text as _, Words, sim as text};

use super::director::{Director, interface_name};
use super::plan::{Exercise, Link};
use crate::jet::Jet;
use crate::obstacle::Shape;
use crate::sim::Sim;
use crate::site::{Site, Splash};
use crate::water::NOMINAL_MPA;

/// Cells of the map of water, m.
pub const CELL_M: f64 = 0.5;
/// Space around what is on the site, m.
const MARGIN_M: f64 = 6.0;
/// Samples of a time line at most.
const SAMPLES: u64 = 900;

/// A part of the site: x and y of two corners, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// West, south.
    pub low: (f64, f64),
    /// East, north.
    pub high: (f64, f64),
}

/// A moment of a monitor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// True positions: azimuth, elevation, deployer in degrees, nozzle in mm.
    pub azimuth_deg: f64,
    /// Elevation, degrees.
    pub elevation_deg: f64,
    /// Nozzle, mm.
    pub nozzle_mm: f64,
    /// Deployer, degrees.
    pub deployer_deg: f64,
    /// Pressure at the nozzle, atm.
    pub pressure_atm: f64,
    /// Flow, l/s.
    pub flow_lps: f64,
    /// Temperature of the vertical drive, °C.
    pub drive_c: f64,
}

/// What a bar of the time line shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum BarKind {
    /// What was broken: a fault, a link, power, the pump.
    Cause,
    /// What the monitor reported of it.
    Told,
}

/// Something that lasted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bar {
    /// Which monitor; `None` is the site.
    pub monitor: Option<usize>,
    /// What it shows.
    pub kind: BarKind,
    /// Its name.
    pub label: Words,
    /// From, ms.
    pub from_ms: u64,
    /// Until, ms.
    pub until_ms: u64,
}

/// A fire over time: heat 0 … 1, and its diameter.
pub type FireSample = (f64, f64);

/// What is kept of a run.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Time between two samples, ms.
    pub step_ms: u64,
    /// By monitor, then by time.
    pub monitors: Vec<Vec<Sample>>,
    /// By fire, then by time.
    pub fires: Vec<Vec<FireSample>>,
    /// Limits of the azimuth, degrees, and how far the jet goes in still air, m; by monitor.
    pub sectors: Vec<(f64, f64, f64)>,
    /// Bars, in the order of their beginning.
    pub bars: Vec<Bar>,
    /// What the map of water covers.
    pub bounds: Bounds,
    /// Water that fell on each cell, l/m²; row by row from the south-west.
    pub water: Vec<f64>,
    /// Cells in a row.
    pub columns: usize,
    open: BTreeMap<(Option<usize>, BarKind, String), usize>,
}

impl Recording {
    /// Nothing yet.
    pub fn new(exercise: &Exercise, site: &mut Site) -> Self {
        let bounds = bounds(exercise);
        let cells = |low: f64, high: f64| libm::ceil((high - low) / CELL_M) as usize;
        let columns = cells(bounds.low.0, bounds.high.0);
        let rows = cells(bounds.low.1, bounds.high.1);
        let step_ms = (exercise.duration_ms / SAMPLES).div_ceil(200).max(1) * 200;
        Self {
            step_ms,
            monitors: vec![Vec::new(); exercise.monitors.len()],
            fires: vec![Vec::new(); exercise.fires.len()],
            sectors: site.members.iter_mut().map(|member| sector(&mut member.sim)).collect(),
            bars: Vec::new(),
            bounds,
            water: vec![0.0; columns * rows],
            columns,
            open: BTreeMap::new(),
        }
    }

    /// Another fire was lit.
    pub fn add_fire(&mut self) {
        let before = self.fires.first().map_or(0, Vec::len);
        self.fires.push(vec![(0.0, 0.0); before]);
    }

    /// Keeps the present moment; called each 100 ms.
    pub fn keep(&mut self, director: &Director, told: &[(usize, String, Severity)]) {
        for splash in director.site.splashes() {
            self.fall(splash);
        }
        self.bars(director, told);
        if !director.now_ms().is_multiple_of(self.step_ms) {
            return;
        }
        for (series, member) in self.monitors.iter_mut().zip(&director.site.members) {
            let world = member.sim.world();
            let degrees = |axis: Axis| world.drives[axis as usize].position / 60.0;
            series.push(Sample {
                azimuth_deg: degrees(Axis::Horizontal),
                elevation_deg: degrees(Axis::Vertical),
                nozzle_mm: world.drives[Axis::Nozzle as usize].position,
                deployer_deg: degrees(Axis::Deployer),
                pressure_atm: world.water.pressure_atm(),
                flow_lps: world.water.flow_lps,
                drive_c: world.climate.places_c[Place::Vertical as usize],
            });
        }
        for (series, fire) in self.fires.iter_mut().zip(director.site.fires.iter()) {
            series.push((fire.heat, fire.size_m));
        }
    }

    /// Spreads a portion evenly over the cells of its footprint.
    fn fall(&mut self, splash: &Splash) {
        let landing = &splash.portion.landing;
        let reach_m = landing.along_m.max(landing.across_m);
        let index = |value: f64| libm::floor(value / CELL_M) as i64;
        let (x, y) = (landing.at.0 - self.bounds.low.0, landing.at.1 - self.bounds.low.1);
        let rows = (self.water.len() / self.columns.max(1)) as i64;
        let mut cells = Vec::new();
        for row in index(y - reach_m)..=index(y + reach_m) {
            for column in index(x - reach_m)..=index(x + reach_m) {
                let middle = (column as f64 + 0.5, row as f64 + 0.5);
                let place =
                    (self.bounds.low.0 + middle.0 * CELL_M, self.bounds.low.1 + middle.1 * CELL_M);
                let inside = (0..self.columns as i64).contains(&column) && (0..rows).contains(&row);
                if landing.covers(place) {
                    cells.push(inside.then_some(row as usize * self.columns + column as usize));
                }
            }
        }
        let each = splash.portion.litres / (cells.len().max(1) as f64 * CELL_M * CELL_M);
        for cell in cells.into_iter().flatten() {
            self.water[cell] += each;
        }
    }

    fn bars(&mut self, director: &Director, told: &[(usize, String, Severity)]) {
        let now_ms = director.now_ms();
        let mut on: Vec<(Option<usize>, BarKind, Words)> = Vec::new();
        for (index, member) in director.site.members.iter().enumerate() {
            let mut cause = |label: Words| on.push((Some(index), BarKind::Cause, label));
            for fault in member.sim.world().faults.active() {
                cause(Words::same(fault.name()));
            }
            if !member.sim.is_powered() {
                cause(text::NoPower.words());
            }
            for over in [Source::ExternalConn, Source::Radio] {
                let interface = interface_name(over);
                match director.link(index, over) {
                    Link::Up => {}
                    Link::Lost => cause(text::InterfaceLost { interface }.words()),
                    Link::AnswersLost => cause(text::InterfaceAnswersLost { interface }.words()),
                }
            }
        }
        for (index, supply) in director.site.supplies.iter().enumerate() {
            if supply.share < 1.0 {
                let name = &director.exercise().supplies[index];
                let percent = supply.share * 100.0;
                let label = text::PumpAt { name, percent: format_args!("{percent:.0}") }.words();
                on.push((None, BarKind::Cause, label));
            }
        }
        // A fire found is no trouble of the monitor's.
        let serious = told.iter().filter(|(_, flag, severity)| {
            *severity >= Severity::Warning && flag != "Detector Found"
        });
        on.extend(
            serious.map(|(monitor, flag, _)| {
                (Some(*monitor), BarKind::Told, Words::same(flag.clone()))
            }),
        );
        let mut open = BTreeMap::new();
        for (monitor, kind, label) in on {
            let key = (monitor, kind, label.en.clone());
            let bar = self.open.get(&key).copied().unwrap_or_else(|| {
                self.bars.push(Bar { monitor, kind, label, from_ms: now_ms, until_ms: now_ms });
                self.bars.len() - 1
            });
            self.bars[bar].until_ms = now_ms;
            open.insert(key, bar);
        }
        self.open = open;
    }
}

/// Limits of the azimuth, degrees, and the reach of a full jet at 30°, m.
fn sector(sim: &mut Sim) -> (f64, f64, f64) {
    let mut limits = (-180.0, 180.0);
    sim.ask(SubsystemId::HORIZONTAL, Body::RetrieveLimits, |answer| {
        if let Reply::Limits(told) = answer.data {
            limits = (f64::from(told.min) / 60.0, f64::from(told.max) / 60.0);
        }
    });
    let world = sim.world();
    let jet = Jet::solid(NOMINAL_MPA, world.water.nozzle_mm, 30_f64.to_radians());
    let reach_m = Jet { height_m: world.height_m, ..jet }.landing().range_m();
    (limits.0, limits.1, reach_m)
}

/// What a picture of the site has to show.
fn bounds(exercise: &Exercise) -> Bounds {
    if let Some([x1, y1, x2, y2]) = exercise.view {
        let low = (x1.min(x2), y1.min(y2));
        return Bounds { low, high: (x1.max(x2).max(low.0 + 5.0), y1.max(y2).max(low.1 + 5.0)) };
    }
    let monitors = exercise.site.monitors.iter().map(|it| (it.pose.at, 2.0));
    let fires = exercise.site.fires.iter().map(|fire| (fire.at, fire.spec.size_m));
    let obstacles = exercise.site.obstacles.iter().flat_map(|it| match it.shape {
        Shape::Wall(a, b) => [(a, 0.0), (b, 0.0)],
        Shape::Tank(middle, diameter_m) => [(middle, diameter_m / 2.0); 2],
    });
    let mut all = Bounds {
        low: (f64::INFINITY, f64::INFINITY),
        high: (f64::NEG_INFINITY, f64::NEG_INFINITY),
    };
    for ((x, y), around) in monitors.chain(fires).chain(obstacles) {
        let around = around + MARGIN_M;
        all.low = (all.low.0.min(x - around), all.low.1.min(y - around));
        all.high = (all.high.0.max(x + around), all.high.1.max(y + around));
    }
    all
}
