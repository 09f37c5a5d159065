//! What a site consists of: detectors, zones, contacts, outputs, pumps.

mod check;
mod votes;

use serde::{Deserialize, Serialize};

pub use check::Problem;
pub use votes::{Reduced, Votes};

/// The installation. In TOML: `monitors`, `[[detector]]`, `[[zone]]`, `[[input]]`, `[[output]]`, `[[pump]]`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Ids of the monitors.
    #[serde(default)]
    pub monitors: Vec<String>,
    /// Detectors.
    #[serde(default, rename = "detector")]
    pub detectors: Vec<Detector>,
    /// Zones.
    #[serde(default, rename = "zone")]
    pub zones: Vec<Zone>,
    /// Contacts: buttons, keys, switches.
    #[serde(default, rename = "input")]
    pub contacts: Vec<Contact>,
    /// Outputs.
    #[serde(default, rename = "output")]
    pub outputs: Vec<Output>,
    /// Pumps, in the order in which they start.
    #[serde(default, rename = "pump")]
    pub pumps: Vec<Pump>,
    /// Further supervised paths: supplies, earth, panels.
    #[serde(default)]
    pub paths: Vec<String>,
    /// Pumps run on for so long after the water, s (0 to 3600).
    #[serde(default)]
    pub run_on_s: u32,
}

/// A detector.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Detector {
    /// Its id.
    pub id: String,
    /// What it senses.
    pub kind: Kind,
    /// The zones for which it votes.
    pub zones: Vec<String>,
    /// It is silent if nothing was heard for so long, s (1 to 3600).
    #[serde(default = "ten")]
    pub silent_after_s: u32,
    /// A self-test or a start that lasts longer is a fault, s (1 to 3600).
    #[serde(default = "two_minutes")]
    pub self_test_max_s: u32,
    /// It votes with a dirty window too.
    #[serde(default)]
    pub dirty_votes: bool,
}

/// What a detector senses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = DetectorKind))]
pub enum Kind {
    /// Flame: UV, IR.
    Flame,
    /// Heat, at a point.
    Heat,
    /// Heat, along a line.
    LineHeat,
    /// Smoke.
    Smoke,
    /// A picture: visible light or heat.
    Picture,
    /// Gas.
    Gas,
    /// A contact of a fire panel.
    Panel,
    /// Anything else.
    Other,
}

/// A zone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Zone {
    /// Its id.
    pub id: String,
    /// Votes that release by themselves, of all detectors of the zone.
    pub votes: Votes,
    /// So many different kinds have to be among the votes.
    #[serde(default = "one")]
    pub kinds: u16,
    /// The word of the owner that one detector may release.
    #[serde(default)]
    pub one_detector_releases: bool,
    /// What the votes become with one failed detector, with two, …; beyond the list: alarm.
    #[serde(default)]
    pub when_failed: Vec<Reduced>,
    /// Votes have to coincide for so long, s (0 to 60).
    #[serde(default = "five")]
    pub coincidence_s: u32,
    /// Delay before the release, s (0 to 60).
    #[serde(default)]
    pub delay_s: u32,
    /// The delay may be held.
    #[serde(default = "yes")]
    pub hold: bool,
    /// All holds of one countdown together, s (1 to 600).
    #[serde(default = "minute")]
    pub hold_max_s: u32,
    /// Greatest duration of automatic water, s (1 to 7200).
    pub water_max_s: u32,
    /// Automatic water ends when no detector of the zone was in alarm for so long, s (1 to 3600).
    #[serde(default)]
    pub quiet_ends_s: Option<u32>,
    /// Mode at the first start.
    #[serde(default)]
    pub mode: Mode,
    /// Manual and off return to automatic after so long; a no lapses after so long without any
    /// detector in alarm, s (1 to 604 800). Without it they stay.
    #[serde(default)]
    pub return_after_s: Option<u32>,
    /// The monitors that serve it, the preferred first.
    pub monitors: Vec<String>,
    /// So many of them at once; without it all.
    #[serde(default)]
    pub jets: Option<u16>,
    /// A monitor that does not act on an order within this time is replaced, s (1 to 300).
    #[serde(default = "thirty")]
    pub act_within_s: u32,
    /// Output that opens the zone valve.
    #[serde(default)]
    pub valve: Option<String>,
    /// Output that opens the test outlet.
    #[serde(default)]
    pub test_outlet: Option<String>,
    /// Its water needs the pumps.
    #[serde(default = "yes")]
    pub pumps: bool,
}

/// Mode of a zone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneMode))]
pub enum Mode {
    /// Votes and hands release.
    #[default]
    Automatic,
    /// Votes alarm, hands release.
    Manual,
    /// Out of service: nothing releases the zone.
    Off,
    /// Votes as in automatic, but without water. A release by hand ends the test and gives water.
    TestDry,
    /// As a dry test, with pumps and the test outlet.
    TestOutlet,
}

impl Mode {
    /// Nothing gets wet.
    pub fn is_test(self) -> bool {
        matches!(self, Self::TestDry | Self::TestOutlet)
    }

    /// Votes release.
    pub(crate) fn votes_release(self) -> bool {
        self == Self::Automatic || self.is_test()
    }
}

/// A contact.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Its id.
    pub id: String,
    /// What it is for.
    pub kind: ContactKind,
    /// The zones that it is for; none named: all.
    #[serde(default)]
    pub zones: Vec<String>,
    /// Time for which a change has to be stable, ms (0 to 1000). The press of a contact that stops or
    /// holds counts at once.
    #[serde(default = "fifty")]
    pub debounce_ms: u32,
}

/// What a contact is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub enum ContactKind {
    /// Manual release station: all monitors of its zones.
    Release,
    /// Abort, and as long as it is pressed no release.
    Abort,
    /// Stop: motion too.
    Stop,
    /// Holds the delay.
    Hold,
    /// Key of the lockout of the whole site.
    Lockout,
    /// Manual as long as it is on.
    ManualSwitch,
    /// Pressure is there.
    Pressure,
}

impl ContactKind {
    /// Its press counts at once, without waiting for the contact to come to rest.
    pub fn acts_at_once(self) -> bool {
        matches!(self, Self::Abort | Self::Stop | Self::Hold | Self::Lockout | Self::ManualSwitch)
    }

    /// It keeps something back as long as it is pressed: over a restart too, until it is read again.
    pub(crate) fn is_kept(self) -> bool {
        matches!(self, Self::Abort | Self::Stop | Self::Lockout | Self::ManualSwitch)
    }
}

/// An output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Its id.
    pub id: String,
    /// What it drives.
    pub kind: OutputKind,
    /// Sounders and lamps: the zone that they are for; without it the site.
    #[serde(default)]
    pub zone: Option<String>,
    /// Its state is reported: a command is repeated until it is reported, and its absence is a trouble.
    #[serde(default)]
    pub feedback: bool,
}

/// What an output drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub enum OutputKind {
    /// A zone valve or a test outlet.
    Valve,
    /// A sounder.
    Sounder,
    /// Lamp: alarm.
    AlarmLamp,
    /// Lamp: trouble.
    TroubleLamp,
    /// Lamp: something is disabled.
    DisabledLamp,
}

/// A pump.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pump {
    /// Its id.
    pub id: String,
    /// It starts so long after the one before it, the first after the release, s (0 to 120).
    #[serde(default)]
    pub start_delay_s: u32,
    /// Contact that reports its pressure.
    #[serde(default)]
    pub pressure: Option<String>,
    /// Without pressure for so long it has failed, s (1 to 300).
    #[serde(default = "ten")]
    pub start_timeout_s: u32,
    /// It starts only in place of one that has failed.
    #[serde(default)]
    pub standby: bool,
    /// It reports whether it runs: a command is repeated until it is reported, and its absence is a
    /// trouble.
    #[serde(default)]
    pub feedback: bool,
}

fn one() -> u16 {
    1
}
fn five() -> u32 {
    5
}
fn ten() -> u32 {
    10
}
fn thirty() -> u32 {
    30
}
fn fifty() -> u32 {
    50
}
fn minute() -> u32 {
    60
}
fn two_minutes() -> u32 {
    120
}
fn yes() -> bool {
    true
}
