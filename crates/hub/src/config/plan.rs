//! What the planner and `lafet coverage` know besides the map: water, winds, what is protected.

use lafet_place::site::Wind;
use lafet_place::supply::Supply;
use lafet_place::{MONITORS_MAX, WINDS_MAX};
use lafet_texts::{Text as _, hub as text};
use serde::Deserialize;

use super::check::Check;
use super::file::File;
use crate::text::Both;

/// What is known besides the map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanConfig {
    /// The water; without it that of the pressure that monitors measure.
    pub supply: Option<Supply>,
    /// How many monitors flow together.
    pub flowing: Option<usize>,
    /// Winds of the site, besides still air.
    pub winds: Vec<Wind>,
    /// What is protected.
    pub area: Option<Area>,
}

/// What is protected, as a file has it. Metres.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Area {
    /// South-west corner, east and north.
    pub corner: [f64; 2],
    /// Extent to the east and to the north.
    pub size: [f64; 2],
    /// Side of a cell.
    #[serde(default = "cell")]
    pub cell: f64,
    /// Height above the ground.
    #[serde(default)]
    pub plane: f64,
}

const fn cell() -> f64 {
    1.0
}

/// The water as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Water {
    pressure: Option<f64>,
    #[serde(rename = "static")]
    without_flow: Option<f64>,
    flow: Option<f64>,
    curve: Option<Vec<[f64; 2]>>,
    flowing: Option<usize>,
}

/// A wind as written.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Blowing {
    from: f64,
    speed: f64,
}

impl Check<'_> {
    /// Water, winds and what is protected.
    pub fn plan(&mut self, read: &File) -> PlanConfig {
        let mut plan = PlanConfig::default();
        if let Some(water) = &read.supply {
            let at = water.span().start;
            let water = water.get_ref();
            plan.flowing = water.flowing;
            match water.supply() {
                Ok(supply) => plan.supply = Some(supply),
                Err(what) => self.say(at, what, text::CheckPlannedRemedy.words()),
            }
            if water.flowing.is_some_and(|it| !(1..=MONITORS_MAX).contains(&it)) {
                let what = text::CheckFlowing { most: MONITORS_MAX }.words();
                self.say(at, what, text::CheckPlannedRemedy.words());
            }
        }
        if let Some(first) = read.wind.get(WINDS_MAX) {
            let what = text::CheckWindsTooMany { most: WINDS_MAX }.words();
            self.say(first.span().start, what, text::CheckPlannedRemedy.words());
        }
        for wind in &read.wind {
            let Blowing { from, speed } = *wind.get_ref();
            let known = Wind { from: from.to_radians(), speed_mps: speed };
            if let Err(problem) = known.check() {
                self.say(wind.span().start, problem.0, text::CheckPlannedRemedy.words());
            }
            plan.winds.push(known);
        }
        if let Some(area) = &read.coverage {
            plan.area = Some(*area.get_ref());
            let Area { corner, size, cell, plane } = *area.get_ref();
            let known = lafet_place::coverage::Area {
                corner,
                size,
                cell_m: cell,
                plane_m: plane,
                winds: Vec::new(),
                flowing: 1,
            };
            if let Err(problem) = known.check(1) {
                self.say(area.span().start, problem.0, text::CheckPlannedRemedy.words());
            }
        }
        plan
    }
}

impl Water {
    fn supply(&self) -> Result<Supply, Both> {
        let supply = match (&self.curve, self.without_flow, self.pressure, self.flow) {
            (Some(points), None, None, None) => Supply::curve(points),
            (None, Some(least), Some(pressure), Some(flow)) => {
                Supply::parabola(least, flow, pressure)
            }
            (None, None, Some(pressure), None) => Supply::constant(pressure),
            _ => return Err(text::CheckSupply.words()),
        };
        supply.map_err(|problem| problem.0)
    }
}
