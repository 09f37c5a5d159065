//! Buses, and what is on them, as a file has them.

use lafet_site::Condition;
use lafet_site::config::{ContactKind, Kind, OutputKind};
use serde::Deserialize;
use toml::Spanned;

use crate::site::keep_out::KeptFor;

/// A keep-out as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeepOut {
    pub name: Spanned<String>,
    #[serde(rename = "for")]
    pub of: KeptFor,
    pub monitor: Option<Spanned<String>>,
    pub bearings: [f64; 2],
    #[serde(default = "every_elevation")]
    pub elevations: [f64; 2],
}

const fn every_elevation() -> [f64; 2] {
    [-90.0, 90.0]
}

/// A bus as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bus {
    pub name: Spanned<String>,
    pub url: Spanned<String>,
    pub poll_ms: Option<Spanned<u64>>,
    pub timeout_ms: Option<Spanned<u64>>,
    pub settle_s: Option<Spanned<u32>>,
    #[serde(default)]
    pub heartbeat: Vec<Beat>,
}

/// A sign of life for a device, as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Beat {
    pub unit: Spanned<u32>,
    pub set: Spanned<String>,
}

/// An output as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Output {
    pub id: String,
    pub kind: OutputKind,
    pub zone: Option<String>,
    pub target: Option<Spanned<Target>>,
}

/// A pump as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pump {
    pub id: String,
    #[serde(default)]
    pub start_delay_s: u32,
    pub pressure: Option<String>,
    #[serde(default = "start_timeout")]
    pub start_timeout_s: u32,
    #[serde(default)]
    pub standby: bool,
    pub target: Option<Spanned<Target>>,
}

/// Where an output is written, and what is read of it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    pub modbus: Spanned<String>,
    pub unit: Spanned<u32>,
    pub set: Spanned<String>,
    pub on: Option<Spanned<String>>,
    pub fault: Option<Spanned<String>>,
    #[serde(default = "yes")]
    pub read_back: bool,
}

impl Target {
    /// Whether the output reports itself, to be commanded again until it does.
    fn reports(target: Option<&Spanned<Self>>) -> bool {
        target.is_some_and(|it| it.get_ref().read_back || it.get_ref().on.is_some())
    }
}

/// A detector as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Detector {
    pub id: String,
    pub kind: Kind,
    pub zones: Vec<String>,
    #[serde(default = "silent_after")]
    pub silent_after_s: u32,
    #[serde(default = "self_test_max")]
    pub self_test_max_s: u32,
    #[serde(default)]
    pub dirty_votes: bool,
    /// East, north and up, m.
    pub at: Option<Spanned<[f64; 3]>>,
    /// Standard error of its bearings, mounting included, degrees.
    pub error_deg: Option<Spanned<f64>>,
    pub source: Option<Spanned<Source>>,
}

/// A contact as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    pub id: String,
    pub kind: ContactKind,
    #[serde(default)]
    pub zones: Vec<String>,
    #[serde(default = "debounce")]
    pub debounce_ms: u32,
    pub source: Option<Spanned<ContactSource>>,
}

/// Where a contact is read.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactSource {
    pub modbus: Spanned<String>,
    pub unit: Spanned<u32>,
    pub on: Spanned<String>,
    pub fault: Option<Spanned<String>>,
    pub heartbeat: Option<Spanned<String>>,
    pub heartbeat_s: Option<Spanned<u32>>,
}

fn yes() -> bool {
    true
}

fn start_timeout() -> u32 {
    10
}

fn debounce() -> u32 {
    50
}

fn silent_after() -> u32 {
    10
}

fn self_test_max() -> u32 {
    120
}

impl From<&Detector> for lafet_site::config::Detector {
    fn from(written: &Detector) -> Self {
        Self {
            id: written.id.clone(),
            kind: written.kind,
            zones: written.zones.clone(),
            silent_after_s: written.silent_after_s,
            self_test_max_s: written.self_test_max_s,
            dirty_votes: written.dirty_votes,
        }
    }
}

impl From<&Output> for lafet_site::config::Output {
    fn from(written: &Output) -> Self {
        let Output { id, kind, zone, target } = written;
        let feedback = Target::reports(target.as_ref());
        Self { id: id.clone(), kind: *kind, zone: zone.clone(), feedback }
    }
}

impl From<&Pump> for lafet_site::config::Pump {
    fn from(written: &Pump) -> Self {
        Self {
            id: written.id.clone(),
            start_delay_s: written.start_delay_s,
            pressure: written.pressure.clone(),
            start_timeout_s: written.start_timeout_s,
            standby: written.standby,
            feedback: Target::reports(written.target.as_ref()),
        }
    }
}

impl From<&Contact> for lafet_site::config::Contact {
    fn from(written: &Contact) -> Self {
        let Contact { id, kind, zones, debounce_ms, .. } = written;
        Self { id: id.clone(), kind: *kind, zones: zones.clone(), debounce_ms: *debounce_ms }
    }
}

/// Where a detector is read.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    pub modbus: Spanned<String>,
    pub unit: Spanned<u32>,
    pub map: Option<Named>,
    pub register: Option<Spanned<u32>>,
    pub axis: Option<Spanned<[f64; 2]>>,
    pub field: Option<Spanned<[f64; 2]>>,
    pub alarm: Option<Spanned<String>>,
    pub pre_alarm: Option<Spanned<String>>,
    pub fault: Option<Spanned<String>>,
    pub dirty: Option<Spanned<String>>,
    pub masked: Option<Spanned<String>>,
    pub self_test: Option<Spanned<String>>,
    pub starting: Option<Spanned<String>>,
    pub heartbeat: Option<Spanned<String>>,
    pub heartbeat_s: Option<Spanned<u32>>,
}

/// A register map that has a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Named {
    Fv300,
    Notifier,
}

/// A contact is read like a detector of which only some bits are known.
impl From<ContactSource> for Source {
    fn from(written: ContactSource) -> Self {
        let ContactSource { modbus, unit, on, fault, heartbeat, heartbeat_s } = written;
        Self {
            modbus,
            unit,
            map: None,
            register: None,
            axis: None,
            field: None,
            alarm: Some(on),
            pre_alarm: None,
            fault,
            dirty: None,
            masked: None,
            self_test: None,
            starting: None,
            heartbeat,
            heartbeat_s,
        }
    }
}

impl Source {
    /// The bits that are named, the worst condition first.
    pub fn conditions(&self) -> [(&Option<Spanned<String>>, Condition); 5] {
        [
            (&self.fault, Condition::Fault),
            (&self.masked, Condition::Masked),
            (&self.self_test, Condition::SelfTest),
            (&self.starting, Condition::Starting),
            (&self.dirty, Condition::Dirty),
        ]
    }

    /// Where something is that a map of this name has no use for.
    pub fn stray(&self, map: Option<Named>) -> Option<(&'static str, usize)> {
        let bits = [
            ("alarm", &self.alarm),
            ("pre_alarm", &self.pre_alarm),
            ("fault", &self.fault),
            ("dirty", &self.dirty),
            ("masked", &self.masked),
            ("self_test", &self.self_test),
            ("starting", &self.starting),
            ("heartbeat", &self.heartbeat),
        ];
        let bits = bits
            .into_iter()
            .map(|(key, it)| (key, it.as_ref().map(|it| it.span().start), map.is_some()));
        let view = map != Some(Named::Fv300);
        let at = |it: &Option<Spanned<[f64; 2]>>| it.as_ref().map(|it| it.span().start);
        let beats = map.is_none() && self.heartbeat.is_some();
        let others = [
            ("register", self.register.as_ref().map(|it| it.span().start), map.is_none()),
            ("axis", at(&self.axis), view),
            ("field", at(&self.field), view),
            ("heartbeat_s", self.heartbeat_s.as_ref().map(|it| it.span().start), !beats),
        ];
        bits.chain(others).find_map(|(key, at, stray)| at.filter(|_| stray).map(|at| (key, at)))
    }
}
