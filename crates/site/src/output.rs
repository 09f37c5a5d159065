//! What the machine answers: commands, and the record of what happened and why.

use lafet_texts::{Text as _, Words, site as text};
use serde::{Deserialize, Serialize};

use crate::config::Mode;
use crate::event::{Bypass, Condition, Hand, Scope, Signal};
use crate::state::{Trouble, Unable};

/// The answer to an event or a step.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reaction {
    /// What to do, in this order.
    pub commands: Vec<Command>,
    /// What happened.
    pub records: Vec<Record>,
    /// [`Persisted`](crate::Persisted) changed and has to be stored.
    pub persist: bool,
}

/// A command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Command {
    /// Counts commands and records together. A command makes those before it void that are for the same
    /// monitor, pump or output and were not delivered yet.
    pub number: u64,
    /// When, ms.
    pub at_ms: u64,
    /// It is void if it could not be delivered by then: what opens or starts. What closes is never void.
    pub not_after_ms: Option<u64>,
    /// What.
    pub order: Order,
    /// Why, from the first cause to the last.
    pub cause: Vec<Cause>,
}

/// What a command orders.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneOrder))]
pub enum Order {
    /// Deploy and turn towards the fire of a zone, without water.
    Prepare {
        /// The monitor.
        monitor: String,
        /// The zone.
        zone: String,
    },
    /// Aim at the fire of a zone and open.
    Engage {
        /// The monitor.
        monitor: String,
        /// The zone.
        zone: String,
        /// The monitor closes after so long by itself, ms; `None`: a hand ends it.
        water_max_ms: Option<u64>,
    },
    /// Close the valve; an Engage that waits is void.
    Close {
        /// The monitor.
        monitor: String,
    },
    /// Stop all motion and programs.
    Stop {
        /// The monitor.
        monitor: String,
    },
    /// Start or stop.
    Pump {
        /// The pump.
        pump: String,
        /// Start.
        on: bool,
    },
    /// Open or shut.
    Valve {
        /// The output.
        output: String,
        /// Open.
        open: bool,
    },
    /// Sound.
    Sound {
        /// The output.
        output: String,
        /// What.
        tone: Tone,
    },
    /// Light.
    Lamp {
        /// The output.
        output: String,
        /// Lit.
        lit: bool,
    },
}

/// What a sounder sounds, the most urgent last.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize,
)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneTone))]
pub enum Tone {
    /// Nothing.
    #[default]
    Off,
    /// Trouble.
    Trouble,
    /// A detector sees fire.
    Alarm,
    /// Water is released.
    Released,
    /// Water comes when the delay is over. Cannot be silenced.
    Countdown,
    /// The delay is held. Cannot be silenced.
    Held,
}

/// A link of the chain of causes.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneCause))]
pub enum Cause {
    /// A detector voted, since this time.
    Vote {
        /// The detector.
        detector: String,
        /// Since, ms.
        since_ms: u64,
    },
    /// So many votes were enough, since this time.
    Enough {
        /// Votes that were needed.
        need: u16,
        /// Since, ms.
        since_ms: u64,
    },
    /// The delay, and how long it was held.
    Delay {
        /// Delay, ms.
        delay_ms: u64,
        /// Held, ms.
        held_ms: u64,
    },
    /// A person's command.
    Hand {
        /// Who.
        by: String,
    },
    /// A contact.
    Contact {
        /// Which.
        input: String,
    },
    /// A release that was under way.
    Release {
        /// Number of its record.
        record: u64,
    },
    /// The end of something.
    End(Why),
    /// Repeated, because the answer is missing.
    Repeated,
    /// In place of a monitor or a pump that is lost.
    InPlaceOf {
        /// Its id.
        lost: String,
    },
    /// Water of a person at this monitor.
    WaterByHand {
        /// The monitor.
        monitor: String,
    },
    /// Water that was running at the start.
    Found {
        /// The monitor.
        monitor: String,
    },
    /// What is to be seen or heard changed.
    Shown,
}

/// Why water or a countdown ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneEnd))]
pub enum Why {
    /// Lockout.
    Lockout,
    /// Stop.
    Stop,
    /// Close.
    Close,
    /// Abort.
    Abort,
    /// Greatest duration.
    Duration,
    /// No detector was in alarm any more.
    Quiet,
    /// The test is over.
    TestOver,
    /// Too few votes.
    Votes,
    /// Not in automatic any more.
    Mode,
}

impl Why {
    /// A person said it.
    pub(crate) fn is_said(self) -> bool {
        matches!(self, Self::Lockout | Self::Stop | Self::Close | Self::Abort)
    }
}

/// A record for the audit log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Counts commands and records together.
    pub number: u64,
    /// When, ms.
    pub at_ms: u64,
    /// What.
    pub entry: Entry,
    /// Why; empty where the entry says it.
    pub cause: Vec<Cause>,
}

/// What happened.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneEntry))]
pub enum Entry {
    /// The machine started.
    Started {
        /// Things of the stored state that are not configured any more.
        dropped: Vec<String>,
    },
    /// A detector changed.
    Detector {
        /// Which.
        detector: String,
        /// What it sees.
        signal: Signal,
        /// Whether it can.
        condition: Condition,
        /// Its vote does not count, because of this.
        unable: Option<Unable>,
    },
    /// The votes of a zone are enough.
    Enough {
        /// The zone.
        zone: String,
    },
    /// The delay runs.
    Countdown {
        /// The zone.
        zone: String,
        /// Delay, ms.
        delay_ms: u64,
    },
    /// A countdown, or the time before it, ended without water.
    Cancelled {
        /// The zone.
        zone: String,
        /// Why.
        why: Why,
    },
    /// The delay is held or goes on.
    Held {
        /// The zone.
        zone: String,
        /// Held.
        on: bool,
        /// Hold that is left, ms.
        left_ms: u64,
    },
    /// A zone is released.
    Released {
        /// The zone.
        zone: String,
        /// By votes.
        automatic: bool,
        /// With water.
        wet: bool,
        /// When the condition was met: votes and times, or the hand; ms.
        condition_at_ms: u64,
    },
    /// The release ended.
    Ended {
        /// The zone.
        zone: String,
        /// Why.
        why: Why,
    },
    /// A no.
    No {
        /// What it is for.
        scope: Scope,
        /// Which.
        why: Why,
    },
    /// A no lapsed, because its zones were quiet long enough.
    Lapsed {
        /// What it was for.
        scope: Scope,
    },
    /// A person's command was refused.
    Refused {
        /// The command.
        order: Hand,
        /// Why.
        why: Refusal,
    },
    /// A release station was refused.
    StationRefused {
        /// The contact.
        input: String,
        /// The zone.
        zone: String,
        /// Why.
        why: Refusal,
    },
    /// A zone has another mode.
    Mode {
        /// The zone.
        zone: String,
        /// The mode.
        mode: Mode,
        /// It returns to automatic after so long, ms.
        returns_in_ms: Option<u64>,
    },
    /// Lockout.
    Lockout {
        /// On.
        on: bool,
    },
    /// A detector is masked, disabled or neither.
    Bypass {
        /// The detector.
        detector: String,
        /// How.
        bypass: Bypass,
    },
    /// A reset.
    Reset(Scope),
    /// The sounders are silenced.
    Silenced,
    /// A trouble began or is over.
    Trouble {
        /// Which.
        trouble: Trouble,
        /// Which one of them.
        subject: String,
        /// It is there.
        active: bool,
    },
    /// Water was running when the hub started.
    WaterFound {
        /// The monitor.
        monitor: String,
        /// It goes on for so long at most, ms.
        left_ms: u64,
    },
    /// A monitor is used in place of another.
    Replaced {
        /// The zone.
        zone: String,
        /// The monitor that is used now.
        monitor: String,
    },
    /// An event named something that is not configured.
    Unknown {
        /// The name.
        name: String,
    },
}

/// Why a command of a hand was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = ZoneRefusal))]
pub enum Refusal {
    /// Lockout is on.
    Lockout,
    /// The zone is switched off.
    Off,
    /// An abort contact is pressed.
    AbortPressed,
    /// A no came at the same time.
    JustRefused,
    /// Water is released: end it first.
    Released,
    /// It is too late: water is released already.
    TooLate,
    /// The zone has no hold.
    NoHold,
    /// The name is not configured.
    Unknown,
    /// The value is out of range.
    Range,
    /// A contact that says the opposite is still pressed.
    StillPressed,
}

impl Refusal {
    /// The text for people.
    pub fn text(self) -> Words {
        match self {
            Self::Lockout => text::RefusalLockout.words(),
            Self::Off => text::RefusalOff.words(),
            Self::AbortPressed => text::RefusalAbortPressed.words(),
            Self::JustRefused => text::RefusalJustRefused.words(),
            Self::Released => text::RefusalReleased.words(),
            Self::TooLate => text::RefusalTooLate.words(),
            Self::NoHold => text::RefusalNoHold.words(),
            Self::Unknown => text::RefusalUnknown.words(),
            Self::Range => text::RefusalRange.words(),
            Self::StillPressed => text::RefusalStillPressed.words(),
        }
    }
}
