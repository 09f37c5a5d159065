//! The plan: what was designed and surveyed, written by people. The site is held against it.
//!
//! What the plan leaves out is not tried. Metres east, north and up of the origin of the site; degrees, bearings
//! clockwise from north; arc-minutes where the wire has them.

use std::collections::{BTreeMap, BTreeSet};

use lafet_texts::{Text as _, Words, acceptance as text};
use serde::Deserialize;

use crate::check::Stage;

/// Most entries of a list of the plan.
pub const ENTRIES_MAX: usize = 256;
/// Longest name, characters.
pub const NAME_MAX: usize = 64;
/// No place is farther than this from the origin of the site, m.
const FAR_M: f64 = 10_000.0;

/// The plan of an installation.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Name of the site, for the record.
    #[serde(default)]
    pub name: String,
    /// Surveyed places.
    #[serde(default, rename = "target")]
    pub targets: Vec<Target>,
    /// Monitors.
    #[serde(default, rename = "monitor")]
    pub monitors: Vec<Monitor>,
    /// Detectors.
    #[serde(default, rename = "detector")]
    pub detectors: Vec<Detector>,
    /// Zones.
    #[serde(default, rename = "zone")]
    pub zones: Vec<Zone>,
    /// How each monitor aims at its zones.
    #[serde(default, rename = "aim")]
    pub aims: Vec<Aim>,
    /// Contacts.
    #[serde(default, rename = "input")]
    pub inputs: Vec<Input>,
    /// Outputs.
    #[serde(default, rename = "output")]
    pub outputs: Vec<Output>,
    /// Pumps, in the order in which they start.
    #[serde(default, rename = "pump")]
    pub pumps: Vec<Pump>,
    /// Sectors kept clear of water.
    #[serde(default, rename = "keep_out")]
    pub keep_outs: Vec<KeepOut>,
    /// How often each step is wanted.
    #[serde(default)]
    pub calendar: Calendar,
}

/// A place that was surveyed: a mark on a wall, a cone.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// Its name.
    pub name: String,
    /// East, north and up, m.
    pub at: [f64; 3],
}

/// A monitor.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Monitor {
    /// Its id in the hub.
    pub id: String,
    /// East and north, m.
    #[serde(default)]
    pub at: Option<[f64; 2]>,
    /// Bearing of its zero, degrees.
    #[serde(default)]
    pub heading: Option<f64>,
    /// Height of the nozzle, m.
    #[serde(default)]
    pub height: Option<f64>,
    /// The target that its heading is tried with.
    #[serde(default)]
    pub target: Option<String>,
    /// Least and greatest pressure at rest, 0.1 atm.
    #[serde(default)]
    pub rest_datm: Option<[f64; 2]>,
    /// Parameters: `"Control.NozzleDiameter" = [280]`.
    #[serde(default)]
    pub params: BTreeMap<String, Vec<i64>>,
}

/// A detector.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Detector {
    /// Its id in the hub.
    pub id: String,
    /// What it senses, as in hub.toml.
    #[serde(default)]
    pub kind: Option<String>,
    /// East, north and up, m.
    #[serde(default)]
    pub at: Option<[f64; 3]>,
    /// The target at which a test source is held in front of it: its bearing is tried with it.
    #[serde(default)]
    pub target: Option<String>,
}

/// A zone.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Zone {
    /// Its id in the hub.
    pub id: String,
    /// Its monitors, the preferred first.
    #[serde(default)]
    pub monitors: Vec<String>,
    /// Its detectors.
    #[serde(default)]
    pub detectors: Vec<String>,
    /// `2oo3`.
    #[serde(default)]
    pub votes: Option<String>,
    /// Kinds among the votes.
    #[serde(default)]
    pub kinds: Option<u16>,
    /// Votes with one failed detector, with two, ….
    #[serde(default)]
    pub when_failed: Option<Vec<String>>,
    /// Coincidence, s.
    #[serde(default)]
    pub coincidence_s: Option<u32>,
    /// Delay, s.
    #[serde(default)]
    pub delay_s: Option<u32>,
    /// All holds of a countdown together, s; 0: it cannot be held.
    #[serde(default)]
    pub hold_max_s: Option<u32>,
    /// Greatest duration of water, s.
    #[serde(default)]
    pub water_max_s: Option<u32>,
    /// Return to automatic, s.
    #[serde(default)]
    pub return_after_s: Option<u32>,
    /// Monitors at once.
    #[serde(default)]
    pub jets: Option<u16>,
    /// Output of its valve.
    #[serde(default)]
    pub valve: Option<String>,
    /// Output of its test outlet.
    #[serde(default)]
    pub test_outlet: Option<String>,
    /// Least and greatest pressure at the gauge of the test outlet while it runs, 0.1 atm.
    #[serde(default)]
    pub outlet_datm: Option<[f64; 2]>,
    /// The mode that it is in; automatic without it.
    #[serde(default)]
    pub mode: Option<String>,
}

/// How often each step is wanted, days.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Calendar {
    /// Reading.
    pub read_days: Option<u32>,
    /// Dry.
    pub dry_days: Option<u32>,
    /// The test outlets.
    pub outlet_days: Option<u32>,
}

/// How a monitor aims at a zone, as in hub.toml.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Aim {
    /// The zone.
    pub zone: String,
    /// The monitor.
    pub monitor: String,
    /// Stored program.
    #[serde(default)]
    pub program: i16,
    /// Centre, arc-minutes.
    pub horizontal: i16,
    /// Centre, arc-minutes.
    pub vertical: i16,
    /// Nozzle, mm.
    pub nozzle: i16,
    /// Valve of the water.
    #[serde(default = "first_valve")]
    pub valve: String,
}

/// A contact.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// Its id in the hub.
    pub id: String,
    /// What it is for, as in hub.toml.
    pub kind: String,
    /// Its zones; none: all.
    #[serde(default)]
    pub zones: Vec<String>,
}

/// An output.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Its id in the hub.
    pub id: String,
    /// What it drives, as in hub.toml.
    pub kind: String,
    /// Its zone; none: the site.
    #[serde(default)]
    pub zone: Option<String>,
}

/// A pump.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pump {
    /// Its id in the hub.
    pub id: String,
    /// It starts so long after the one before, s.
    #[serde(default)]
    pub start_delay_s: u32,
    /// It starts in place of one that has failed.
    #[serde(default)]
    pub standby: bool,
}

/// A sector kept clear of water, as in hub.toml.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeepOut {
    /// Its name.
    pub name: String,
    /// The monitor that it counts for; none: all.
    #[serde(default)]
    pub monitor: Option<String>,
    /// From and to, degrees.
    pub bearings: [f64; 2],
    /// From and to, degrees.
    #[serde(default)]
    pub elevations: Option<[f64; 2]>,
}

/// Questions quote it: nothing in it moves the cursor, or turns the direction of the line.
fn is_plain(name: &str) -> bool {
    let turns = |it: char| matches!(it, '\u{200e}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    !name.chars().any(|it| it.is_control() || turns(it))
}

fn first_valve() -> String {
    "Valve1".to_owned()
}

impl Plan {
    /// What is wrong with it, in words; empty: nothing.
    pub fn check(&self) -> Vec<Words> {
        let mut wrong = self.sizes();
        if !wrong.is_empty() {
            return wrong;
        }
        let targets: BTreeSet<&str> = self.targets.iter().map(|it| it.name.as_str()).collect();
        let monitors: BTreeSet<&str> = self.monitors.iter().map(|it| it.id.as_str()).collect();
        let detectors: BTreeSet<&str> = self.detectors.iter().map(|it| it.id.as_str()).collect();
        let zones: BTreeSet<&str> = self.zones.iter().map(|it| it.id.as_str()).collect();
        let outputs: BTreeSet<&str> = self.outputs.iter().map(|it| it.id.as_str()).collect();
        let mut known = |table: &str, name: &str, among: &BTreeSet<&str>| {
            if !among.contains(name) {
                wrong.push(text::PlanUnknown { table, name }.words());
            }
        };
        let of_monitors = self.monitors.iter().filter_map(|it| it.target.as_ref());
        let of_detectors = self.detectors.iter().filter_map(|it| it.target.as_ref());
        of_monitors.chain(of_detectors).for_each(|it| known("target", it, &targets));
        for zone in &self.zones {
            zone.monitors.iter().for_each(|it| known("monitor", it, &monitors));
            zone.detectors.iter().for_each(|it| known("detector", it, &detectors));
            let of_zone = [&zone.valve, &zone.test_outlet];
            of_zone.into_iter().flatten().for_each(|it| known("output", it, &outputs));
        }
        for aim in &self.aims {
            known("zone", &aim.zone, &zones);
            known("monitor", &aim.monitor, &monitors);
        }
        let of_inputs = self.inputs.iter().flat_map(|it| &it.zones);
        let of_outputs = self.outputs.iter().filter_map(|it| it.zone.as_ref());
        of_inputs.chain(of_outputs).for_each(|it| known("zone", it, &zones));
        self.keep_outs
            .iter()
            .filter_map(|it| it.monitor.as_ref())
            .for_each(|it| known("monitor", it, &monitors));
        let both: BTreeSet<&str> = ["Valve1", "Valve2"].into();
        self.aims.iter().for_each(|it| known("valve", &it.valve, &both));
        wrong.extend(self.numbers());
        wrong
    }

    /// Lists have a greatest length, names are there and unique.
    fn sizes(&self) -> Vec<Words> {
        let mut wrong = Vec::new();
        let lists: [(&str, Vec<&str>); 7] = [
            ("target", self.targets.iter().map(|it| it.name.as_str()).collect()),
            ("monitor", self.monitors.iter().map(|it| it.id.as_str()).collect()),
            ("detector", self.detectors.iter().map(|it| it.id.as_str()).collect()),
            ("zone", self.zones.iter().map(|it| it.id.as_str()).collect()),
            ("input", self.inputs.iter().map(|it| it.id.as_str()).collect()),
            ("output", self.outputs.iter().map(|it| it.id.as_str()).collect()),
            ("pump", self.pumps.iter().map(|it| it.id.as_str()).collect()),
        ];
        for (table, names) in lists {
            if names.len() > ENTRIES_MAX {
                wrong.push(text::PlanTooMany { table, most: ENTRIES_MAX }.words());
            }
            let mut seen = BTreeSet::new();
            for name in names {
                let long = name.chars().count() > NAME_MAX;
                if name.is_empty() || long || !is_plain(name) || !seen.insert(name) {
                    wrong.push(text::PlanName { table, name, most: NAME_MAX }.words());
                }
            }
        }
        for (table, count) in [("aim", self.aims.len()), ("keep_out", self.keep_outs.len())] {
            if count > ENTRIES_MAX * 4 {
                wrong.push(text::PlanTooMany { table, most: ENTRIES_MAX * 4 }.words());
            }
        }
        wrong
    }

    /// Figures with which nothing can be computed.
    fn numbers(&self) -> Vec<Words> {
        let mut wrong = Vec::new();
        let mut within = |what: &str, value: f64, least: f64, most: f64| {
            if !(least..=most).contains(&value) {
                wrong.push(text::PlanRange { what, value, least, most }.words());
            }
        };
        for target in &self.targets {
            target.at.iter().for_each(|it| within(&target.name, *it, -FAR_M, FAR_M));
        }
        for it in &self.monitors {
            it.at.iter().flatten().for_each(|at| within(&it.id, *at, -FAR_M, FAR_M));
            it.heading.iter().for_each(|at| within(&it.id, *at, -360.0, 360.0));
            it.height.iter().for_each(|at| within(&it.id, *at, -100.0, 200.0));
            it.rest_datm.iter().flatten().for_each(|at| within(&it.id, *at, 0.0, 10_000.0));
            // The greater one has to come last.
            it.rest_datm.iter().for_each(|[least, most]| within(&it.id, *most, *least, 10_000.0));
        }
        for it in &self.detectors {
            it.at.iter().flatten().for_each(|at| within(&it.id, *at, -FAR_M, FAR_M));
        }
        for every in Stage::ALL.into_iter().filter_map(|it| self.every(it)) {
            within("calendar", f64::from(every), 1.0, 3660.0);
        }
        for it in &self.zones {
            let whole = |at: &u32| f64::from(*at);
            it.coincidence_s.iter().for_each(|at| within(&it.id, whole(at), 0.0, 60.0));
            it.delay_s.iter().for_each(|at| within(&it.id, whole(at), 0.0, 60.0));
            it.hold_max_s.iter().for_each(|at| within(&it.id, whole(at), 0.0, 600.0));
            it.water_max_s.iter().for_each(|at| within(&it.id, whole(at), 1.0, 7200.0));
            it.outlet_datm.iter().flatten().for_each(|at| within(&it.id, *at, 0.0, 10_000.0));
            it.outlet_datm.iter().for_each(|[least, most]| within(&it.id, *most, *least, 10_000.0));
        }
        for it in &self.pumps {
            within(&it.id, f64::from(it.start_delay_s), 0.0, 120.0);
        }
        for it in &self.keep_outs {
            it.bearings.iter().for_each(|at| within(&it.name, *at, -360.0, 360.0));
            let elevations = it.elevations.iter().flatten();
            elevations.for_each(|at| within(&it.name, *at, -90.0, 90.0));
        }
        wrong
    }

    /// How often a step is wanted, days.
    pub const fn every(&self, stage: Stage) -> Option<u32> {
        let it = self.calendar;
        match stage {
            Stage::Read => it.read_days,
            Stage::Dry => it.dry_days,
            Stage::Outlet => it.outlet_days,
        }
    }

    /// A target by its name.
    pub fn target(&self, name: Option<&String>) -> Option<&Target> {
        self.targets.iter().find(|it| Some(&it.name) == name)
    }

    /// A detector by its id.
    pub fn detector(&self, id: &str) -> Option<&Detector> {
        self.detectors.iter().find(|it| it.id == id)
    }
}
