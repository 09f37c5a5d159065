//! What survives a loss of power: disablements, modes, refusals, and how long water may still run.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::config::Mode;
use crate::event::Bypass;
use crate::output::Why;

/// The version that this crate writes and reads.
pub const VERSION: u32 = 1;

/// What is stored. Times are what was left when it was made: a machine has no clock that survives.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Persisted {
    /// [`VERSION`].
    pub version: u32,
    /// Lockout by command.
    pub lockout: bool,
    /// Zones by id.
    pub zones: BTreeMap<String, StoredZone>,
    /// Detectors that are masked or disabled.
    pub detectors: BTreeMap<String, Bypass>,
    /// Monitors by id.
    pub monitors: BTreeMap<String, StoredMonitor>,
    /// Contacts that say no, or switch to manual, and were pressed: until they are read again.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub pressed: BTreeSet<String>,
    /// Pumps that a person keeps off.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub pumps_off: BTreeSet<String>,
}

/// A zone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredZone {
    /// Its mode.
    pub mode: Mode,
    /// It returns to automatic after so long, ms.
    pub returns_in_ms: Option<u64>,
    /// It was ended and needs a reset.
    pub ended: Option<Why>,
}

/// A monitor.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredMonitor {
    /// A person closed or stopped it.
    pub refused: Option<Why>,
    /// Automatic water may run for so long, ms; 0 if its end was ordered and is not confirmed.
    pub water_left_ms: Option<u64>,
    /// The zone for which its water was ordered, by its id.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<String>,
    /// A person began the water that runs, no order did, and no no has come since.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub by_person: bool,
}
