//! Where things are on the site: metres east and north of its origin, bearings clockwise from north.

pub mod jet;
pub mod keep_out;
pub mod planned;
pub mod struck;
pub mod thrown;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use keep_out::KeepOut;

/// The map of a site.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct Site {
    /// Monitors by id.
    pub monitors: BTreeMap<String, Place>,
    /// Tanks.
    pub tanks: Vec<Tank>,
    /// Walls.
    pub walls: Vec<Wall>,
    /// Sectors that no water goes into.
    pub keep_outs: Vec<KeepOut>,
}

/// Position and bearing of a monitor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct Place {
    /// East and north of the origin, m.
    #[schema(min_items = 2, max_items = 2)]
    pub at: [f64; 2],
    /// Bearing of its zero, degrees.
    pub heading: f64,
    /// Height of the nozzle above the ground, m.
    pub height: f64,
}

/// A round tank.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Tank {
    /// Name of the tank.
    pub name: String,
    /// Centre, m east and north.
    #[schema(min_items = 2, max_items = 2)]
    pub at: [f64; 2],
    /// Diameter, m.
    pub diameter: f64,
    /// Height, m.
    pub height: f64,
}

/// A wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Name of the wall.
    pub name: String,
    /// First end, m east and north.
    #[schema(min_items = 2, max_items = 2)]
    pub from: [f64; 2],
    /// Second end, m east and north.
    #[schema(min_items = 2, max_items = 2)]
    pub to: [f64; 2],
    /// Height, m.
    pub height: f64,
}
