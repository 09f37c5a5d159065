//! The zones as clients see them.

use std::collections::BTreeMap;

use lafet_site::{Condition, Signal, State};
use serde::Serialize;
use utoipa::ToSchema;

use super::Machine;

/// The zones, their detectors and monitors. Times of `state` count from the start of the hub.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct ZonesView {
    /// As the zone controller has it.
    pub state: State,
    /// The latest report of each detector since the start.
    pub reported: BTreeMap<String, Reported>,
}

/// What a detector has reported last.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[schema(as = DetectorReported)]
pub struct Reported {
    /// When, ms since 1970.
    pub at_ms: u64,
    /// User or token that reported it.
    pub by: String,
    /// What it sees.
    pub signal: Signal,
    /// Whether it can see.
    pub condition: Condition,
    /// Bearing of what it sees, degrees clockwise from north.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bearing_deg: Option<f64>,
    /// Elevation of what it sees, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elevation_deg: Option<f64>,
    /// How sure it is, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quality: Option<f64>,
}

impl Machine {
    pub(super) fn view(&self) -> ZonesView {
        ZonesView { state: self.site.state(), reported: self.reported.clone() }
    }
}
