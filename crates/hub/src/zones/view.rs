//! The zones as clients see them.

use std::collections::BTreeMap;

use lafet_place::reach::OF_THROW;
use lafet_site::config::Kind;
use lafet_site::{Condition, Signal, State};
use lafet_texts::{Decimal, Text as _, hub as text};
use serde::Serialize;
use utoipa::ToSchema;

use super::fires::FirePlace;
use super::{Machine, WIND_COUNTS};
use crate::config::ZonesConfig;
use crate::control::authority::Now;
use crate::text::Both;

/// The zones, their detectors and monitors. Times of `state` count from the start of the hub.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct ZonesView {
    /// As the zone controller has it.
    pub state: State,
    /// The latest report of each detector since the start.
    pub reported: BTreeMap<String, Reported>,
    /// Places where bearings of detectors that report fire cross, by zone, those that are sure first.
    pub fires: Vec<FirePlace>,
    /// Which monitor is assigned to which fire, by zone.
    pub assigned: Vec<Assigned>,
    /// Monitors that votes do not open, by zone: the water would not suffice. By hand they may be opened.
    pub left_out: Vec<LeftOut>,
    /// The wind that was reported last, unless that is 10 min ago.
    #[schema(required)]
    pub wind: Option<WindReported>,
    /// The wind by which monitors are assigned.
    pub planned_wind: PlannedWind,
    /// On the disk; false in the answer to an order: a restart would lose it.
    pub stored: bool,
}

/// A monitor that votes do not open.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct LeftOut {
    /// The zone.
    pub zone: String,
    /// The monitor.
    pub monitor: String,
}

/// The wind by which monitors are assigned: the last one that was reported, however long ago, else none.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PlannedWind {
    /// When it was reported, ms since 1970; null: none was since the start.
    #[schema(required)]
    pub at_ms: Option<u64>,
    /// Bearing that it blows from, degrees clockwise from north.
    pub from_deg: f64,
    /// Speed 10 m above the ground, m/s.
    pub speed_mps: f64,
    /// The same in words.
    pub text: Both,
}

impl PlannedWind {
    fn new(reported: Option<&WindReported>) -> Self {
        let Some(WindReported { at_ms, from_deg, speed_mps, .. }) = reported else {
            let percent = (OF_THROW * 100.0).round() as u64;
            let text = text::ZonesWindUnknown { percent }.words();
            return Self { at_ms: None, from_deg: 0.0, speed_mps: 0.0, text };
        };
        let (speed, from) = (Decimal(*speed_mps, 1), from_deg.round() as i64);
        let text = text::ZonesWindKnown { speed, from }.words();
        Self { at_ms: Some(*at_ms), from_deg: *from_deg, speed_mps: *speed_mps, text }
    }
}

/// A monitor that is assigned to a fire.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = FireAssigned)]
pub struct Assigned {
    /// The zone.
    pub zone: String,
    /// The monitor.
    pub monitor: String,
    /// Where the fire is, east and north of the origin of the site, m.
    #[schema(min_items = 2, max_items = 2)]
    pub at: [f64; 2],
}

/// A wind as it was reported.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct WindReported {
    /// When, by the clock of the hub that does not jump.
    #[serde(skip)]
    pub heard: Now,
    /// When, ms since 1970.
    pub at_ms: u64,
    /// User or token that reported it.
    pub by: String,
    /// Bearing that it blows from, degrees clockwise from north.
    pub from_deg: f64,
    /// Speed 10 m above the ground, m/s.
    pub speed_mps: f64,
}

/// What a detector has reported last.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[schema(as = DetectorReported)]
pub struct Reported {
    /// When, by the clock of the hub that does not jump.
    #[serde(skip)]
    pub heard: Now,
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

/// What belongs to each zone. It does not change while the hub runs.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct ZonesConfigured {
    /// Zones, in the configured order.
    pub zones: Vec<ZoneConfigured>,
    /// What each detector senses.
    pub detectors: BTreeMap<String, Kind>,
}

/// A zone as it is configured.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct ZoneConfigured {
    /// Its id.
    pub zone: String,
    /// Detectors that vote for it.
    pub detectors: Vec<String>,
    /// Monitors that serve it, in order of preference.
    pub monitors: Vec<String>,
    /// Votes that release, of all its detectors: `2oo3`.
    pub votes: String,
    /// Different kinds of detectors among the votes.
    pub kinds: u16,
    /// Votes coincide for so long before the delay, s.
    pub coincidence_s: u32,
    /// Delay before the release, s.
    pub delay_s: u32,
    /// All holds of one countdown together, s; null: the delay cannot be held.
    #[schema(required)]
    pub hold_max_s: Option<u32>,
    /// Greatest duration of automatic water, s.
    pub water_max_s: u32,
    /// Manual and off return to automatic after so long, s; null: they stay.
    #[schema(required)]
    pub return_after_s: Option<u32>,
}

impl From<&ZonesConfig> for ZonesConfigured {
    fn from(config: &ZonesConfig) -> Self {
        let site = &config.site;
        let zones = site.zones.iter().map(|zone| {
            let votes_for = site.detectors.iter().filter(|it| it.zones.contains(&zone.id));
            ZoneConfigured {
                zone: zone.id.clone(),
                detectors: votes_for.map(|it| it.id.clone()).collect(),
                monitors: zone.monitors.clone(),
                votes: zone.votes.to_string(),
                kinds: zone.kinds,
                coincidence_s: zone.coincidence_s,
                delay_s: zone.delay_s,
                hold_max_s: zone.hold.then_some(zone.hold_max_s),
                water_max_s: zone.water_max_s,
                return_after_s: zone.return_after_s,
            }
        });
        let detectors = site.detectors.iter().map(|it| (it.id.clone(), it.kind));
        Self { zones: zones.collect(), detectors: detectors.collect() }
    }
}

impl Machine {
    /// Monitors at work are shown at the fire that they have accepted.
    fn assigned(&self) -> Vec<Assigned> {
        let plans = self.plans.iter();
        let all = plans.flat_map(|(zone, plan)| plan.assigned().map(move |it| (zone, it)));
        all.filter(|(_, (monitor, number, _))| {
            self.lines.get(*monitor).is_none_or(|line| line.shows(*number))
        })
        .map(|(zone, (monitor, _, at))| Assigned {
            zone: zone.clone(),
            monitor: monitor.clone(),
            at,
        })
        .collect()
    }

    fn left_out(&self) -> Vec<LeftOut> {
        let all =
            self.plans.iter().flat_map(|(zone, plan)| plan.left_out().map(move |it| (zone, it)));
        all.map(|(zone, monitor)| LeftOut { zone: zone.clone(), monitor: monitor.clone() })
            .collect()
    }

    pub(super) fn view(&self, now: Now, stored: bool) -> ZonesView {
        ZonesView {
            state: self.site.state(),
            reported: self.reported.clone(),
            fires: self.fires.values().flatten().cloned().collect(),
            assigned: self.assigned(),
            left_out: self.left_out(),
            wind: self.wind.clone().filter(|it| now.saturating_sub(it.heard) < WIND_COUNTS),
            planned_wind: PlannedWind::new(self.wind.as_ref()),
            stored,
        }
    }
}
