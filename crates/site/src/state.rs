//! The state for a console: everything that a person has to see, in typed form.

use lafet_texts::{Text as _, Words, site as text};
use serde::{Deserialize, Serialize};

use crate::config::Mode;
use crate::event::{Bypass, Condition, Signal};
use crate::output::{Tone, Why};

/// The site as it is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZonesState))]
pub struct State {
    /// When, ms.
    pub at_ms: u64,
    /// Lockout is on.
    pub lockout: bool,
    /// What the sounders of the site sound.
    pub tone: Tone,
    /// Zones, in the configured order.
    pub zones: Vec<ZoneState>,
    /// Detectors.
    pub detectors: Vec<DetectorState>,
    /// Monitors.
    pub monitors: Vec<MonitorState>,
    /// Pumps.
    pub pumps: Vec<PumpState>,
    /// Zone valves, test outlets, sounders, lamps.
    pub outputs: Vec<OutputState>,
    /// Troubles, apart from alarms. They stay until a reset, also when they are over.
    pub troubles: Vec<TroubleState>,
    /// What is disabled.
    pub disablements: Vec<Disablement>,
}

/// A zone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct ZoneState {
    /// Its id.
    pub zone: String,
    /// What it does.
    pub phase: Phase,
    /// Its mode.
    pub mode: Mode,
    /// A switch keeps it in manual.
    pub switch_manual: bool,
    /// It returns to automatic after so long, ms.
    pub returns_in_ms: Option<u64>,
    /// Detectors that vote.
    pub votes: Vec<String>,
    /// Detectors in alarm, with or without a vote.
    pub alarms: Vec<String>,
    /// Votes that release; `None`: too many detectors have failed, an alarm releases nothing.
    pub need: Option<u16>,
    /// Detectors without a vote.
    pub unable: Vec<Voteless>,
    /// It would release by itself if there were votes: with a monitor, its valve and its pumps.
    pub ready: bool,
    /// Until the release, ms, if nothing holds it.
    pub left_ms: Option<u64>,
    /// Hold that is left, ms.
    pub hold_left_ms: u64,
    /// Until automatic water ends, ms.
    pub water_left_ms: Option<u64>,
    /// From the condition to the command, ms, of the last release.
    pub reacted_in_ms: Option<u64>,
    /// Why it is not released.
    pub not_released: Vec<NotReleased>,
    /// Monitors that are engaged for it.
    pub monitors: Vec<String>,
}

/// What a zone does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZonePhase))]
pub enum Phase {
    /// No detector in alarm.
    Quiet,
    /// A detector is in alarm.
    Alarm,
    /// Enough votes coincide, not long enough yet.
    Coincidence,
    /// The delay runs.
    Countdown,
    /// The delay is held.
    Held,
    /// Released.
    Released {
        /// By votes.
        automatic: bool,
        /// With water.
        wet: bool,
    },
    /// Ended, and not ready until a reset.
    Ended(Why),
}

impl Phase {
    /// Enough votes coincide: a release follows, unless something prevents it.
    pub const fn is_pending(self) -> bool {
        matches!(self, Self::Coincidence | Self::Countdown | Self::Held)
    }
}

/// Why a zone with an alarm is not released.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneNotReleased))]
pub enum NotReleased {
    /// Lockout is on.
    Lockout,
    /// An abort contact is pressed.
    AbortPressed,
    /// A stop contact is pressed.
    StopPressed,
    /// It was ended; a reset is needed.
    Ended(Why),
    /// The mode.
    Mode(Mode),
    /// Votes are missing.
    Votes {
        /// There are.
        have: u16,
        /// Are needed.
        need: u16,
    },
    /// The votes are of too few kinds.
    Kinds,
    /// Too many detectors have failed.
    Failed,
    /// Alarms that were there at the start do not vote.
    Stale,
    /// The votes have to coincide for longer.
    Coincidence,
    /// The delay runs.
    Delay,
    /// The delay is held.
    Held,
    /// No monitor can serve it.
    NoMonitor,
}

impl NotReleased {
    /// The text for people.
    pub fn text(&self) -> Words {
        match self {
            Self::Lockout => text::NotReleasedLockout.words(),
            Self::AbortPressed => text::NotReleasedAbortPressed.words(),
            Self::StopPressed => text::NotReleasedStopPressed.words(),
            Self::Ended(_) => text::NotReleasedEnded.words(),
            Self::Mode(_) => text::NotReleasedMode.words(),
            Self::Votes { have, need } => text::NotReleasedVotes { have, need }.words(),
            Self::Kinds => text::NotReleasedKinds.words(),
            Self::Failed => text::NotReleasedFailed.words(),
            Self::Stale => text::NotReleasedStale.words(),
            Self::Coincidence => text::NotReleasedCoincidence.words(),
            Self::Delay => text::NotReleasedDelay.words(),
            Self::Held => text::NotReleasedHeld.words(),
            Self::NoMonitor => text::NotReleasedNoMonitor.words(),
        }
    }
}

/// A detector without a vote.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = DetectorVoteless))]
pub struct Voteless {
    /// Its id.
    pub detector: String,
    /// Why.
    pub why: Unable,
}

/// Why a detector has no vote.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = DetectorUnable))]
pub enum Unable {
    /// It has not been heard since the start.
    NeverHeard,
    /// It is silent.
    Silent,
    /// It says so.
    Condition(Condition),
    /// Its self-test or its start does not end.
    TestStuck,
    /// People masked or disabled it.
    Bypass(Bypass),
}

/// A detector.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct DetectorState {
    /// Its id.
    pub detector: String,
    /// What it sees, if it was heard.
    pub signal: Option<Signal>,
    /// Why it has no vote.
    pub unable: Option<Unable>,
    /// Its alarm was there at the start, so it has no vote until it was quiet once.
    pub stale: bool,
}

/// A monitor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneMonitorState))]
pub struct MonitorState {
    /// Its id.
    pub monitor: String,
    /// The zone that it is engaged for.
    pub engaged_for: Option<String>,
    /// It is being closed: Close is repeated until it is reported closed.
    pub closing: bool,
    /// Why it is not used.
    pub withheld: Option<Withheld>,
    /// Water that was running at the start goes on for so long at most, ms.
    pub found_left_ms: Option<u64>,
}

/// Why a monitor is not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneWithheld))]
pub enum Withheld {
    /// Lockout of the site or its own.
    Lockout,
    /// A person closed or stopped it.
    Refused,
    /// A person controls it.
    Person,
    /// It does not answer.
    Unreachable,
    /// It has failed.
    Failure,
}

/// A pump.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct PumpState {
    /// Its id.
    pub pump: String,
    /// As commanded; `None` before the first command.
    pub on: Option<bool>,
    /// Its pressure is there, if it has a contact for it.
    pub pressure: Option<bool>,
    /// It has failed.
    pub failed: bool,
    /// It reports that it runs.
    pub runs: Option<bool>,
    /// As a hand has ordered it, until a reset; `None`: as the water needs it.
    pub hand: Option<bool>,
}

/// An output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneOutputState))]
pub struct OutputState {
    /// Its id.
    pub output: String,
    /// As commanded: open, on, any tone; `None` before the first command.
    pub on: Option<bool>,
    /// As reported.
    pub reported: Option<bool>,
}

/// A trouble in the list.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneTroubleState))]
pub struct TroubleState {
    /// Which.
    pub trouble: Trouble,
    /// Which detector, monitor, ….
    pub subject: String,
    /// Since, ms.
    pub since_ms: u64,
    /// It is there; else it is over and waits for a reset.
    pub active: bool,
}

/// A trouble.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneTrouble))]
pub enum Trouble {
    /// Fault of a detector.
    DetectorFault,
    /// A detector is silent.
    DetectorSilent,
    /// A window is dirty.
    DetectorDirty,
    /// A self-test or a start of a detector does not end.
    DetectorStuck,
    /// A path is at fault.
    Path,
    /// A release contact was pressed when it was first read, or a hold contact before the alarm or for longer
    /// than a countdown may be held.
    ContactStuck,
    /// A monitor does not answer.
    MonitorUnreachable,
    /// A monitor has failed.
    MonitorFailure,
    /// An engaged monitor does not act.
    MonitorIdle,
    /// A valve of a monitor is not reported closed.
    NotClosed,
    /// An output is not reported as commanded.
    OutputOverdue,
    /// A pump is not reported as commanded.
    PumpOverdue,
    /// A pump gives no pressure.
    PumpFailed,
    /// No pump gives pressure.
    NoPressure,
    /// A released zone has no monitor.
    NoMonitor,
    /// A released zone has fewer monitors at work than its `jets`.
    FewJets,
}

impl Trouble {
    /// The text for people.
    pub fn text(self) -> Words {
        match self {
            Self::DetectorFault => text::TroubleDetectorFault.words(),
            Self::DetectorSilent => text::TroubleDetectorSilent.words(),
            Self::DetectorDirty => text::TroubleDetectorDirty.words(),
            Self::DetectorStuck => text::TroubleDetectorStuck.words(),
            Self::Path => text::TroublePath.words(),
            Self::ContactStuck => text::TroubleContactStuck.words(),
            Self::MonitorUnreachable => text::TroubleMonitorUnreachable.words(),
            Self::MonitorFailure => text::TroubleMonitorFailure.words(),
            Self::MonitorIdle => text::TroubleMonitorIdle.words(),
            Self::NotClosed => text::TroubleNotClosed.words(),
            Self::OutputOverdue => text::TroubleOutputOverdue.words(),
            Self::PumpOverdue => text::TroublePumpOverdue.words(),
            Self::PumpFailed => text::TroublePumpFailed.words(),
            Self::NoPressure => text::TroubleNoPressure.words(),
            Self::NoMonitor => text::TroubleNoMonitor.words(),
            Self::FewJets => text::TroubleFewJets.words(),
        }
    }
}

/// Something that is disabled.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneDisablement))]
pub enum Disablement {
    /// Lockout of the site.
    Lockout,
    /// A detector is masked or disabled.
    Detector {
        /// Which.
        detector: String,
        /// How.
        bypass: Bypass,
    },
    /// A zone is not in automatic.
    Mode {
        /// Which.
        zone: String,
        /// Its mode; manual also by a switch.
        mode: Mode,
        /// It returns after so long, ms.
        returns_in_ms: Option<u64>,
    },
    /// A zone was ended and needs a reset.
    Ended {
        /// Which.
        zone: String,
        /// Why.
        why: Why,
    },
    /// A monitor was closed or stopped and needs a reset.
    Monitor {
        /// Which.
        monitor: String,
        /// Why.
        why: Why,
    },
    /// A pump was stopped by hand and does not start by itself before a reset.
    Pump {
        /// Which.
        pump: String,
    },
    /// A zone has a delay before the release.
    Delay {
        /// Which.
        zone: String,
        /// So long, ms.
        delay_ms: u64,
    },
}
