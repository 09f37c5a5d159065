//! Where things are on the site: metres east and north of its origin, bearings clockwise from north.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A site.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct Site {
    /// Monitors by id.
    pub monitors: BTreeMap<String, Place>,
    /// Tanks.
    pub tanks: Vec<Tank>,
    /// Walls.
    pub walls: Vec<Wall>,
}

/// Where a monitor is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct Place {
    /// East and north, m.
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
    /// Its name.
    pub name: String,
    /// Its middle, m.
    #[schema(min_items = 2, max_items = 2)]
    pub at: [f64; 2],
    /// Its diameter, m.
    pub diameter: f64,
    /// Its height, m.
    pub height: f64,
}

/// A wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Its name.
    pub name: String,
    /// One end, m.
    #[schema(min_items = 2, max_items = 2)]
    pub from: [f64; 2],
    /// The other end, m.
    #[schema(min_items = 2, max_items = 2)]
    pub to: [f64; 2],
    /// Its height, m.
    pub height: f64,
}
