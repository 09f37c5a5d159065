//! An alarm as clients see it.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::text::Both;

/// How urgent an alarm is; the most urgent first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Priority {
    /// A detector has found a fire.
    Fire,
    /// A function of the monitor is lost.
    High,
    /// A function is degraded or not prepared.
    Medium,
    /// To be looked at when there is time.
    Low,
}

/// The state of an alarm that is not normal; what waits for an operator first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = AlarmState)]
pub enum State {
    /// Active, not acknowledged.
    Unack,
    /// Its condition is gone; not acknowledged.
    RtnUnack,
    /// Active, acknowledged.
    Ack,
    /// Out of the list until a time, by a user.
    Shelved,
}

impl State {
    /// The word for a state, as API, history and log have it; `None` is normal.
    pub const fn word(state: Option<Self>) -> &'static str {
        match state {
            None => "normal",
            Some(Self::Unack) => "unack",
            Some(Self::RtnUnack) => "rtn_unack",
            Some(Self::Ack) => "ack",
            Some(Self::Shelved) => "shelved",
        }
    }
}

/// An alarm that is not normal.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct Alarm {
    /// Monitor, subsystem and flag: `M1/Vertical/AmperageOverload`.
    pub id: String,
    /// The id of the monitor; empty: the hub itself.
    pub monitor: String,
    /// The name of the subsystem, `Link` or `Hub`.
    pub subsystem: String,
    /// The name of the flag or of the hub's own condition.
    pub flag: String,
    /// How urgent the response is.
    pub priority: Priority,
    /// Whether it is acknowledged or shelved.
    pub state: State,
    /// Whether its condition holds.
    pub active: bool,
    /// When it became active last, ms since 1970.
    pub since_ms: u64,
    /// When its condition ended, ms since 1970; null while it is active.
    #[schema(required)]
    pub returned_ms: Option<u64>,
    /// How often it became active since it was normal.
    pub count: u32,
    /// The last acknowledgement.
    #[schema(required)]
    pub ack: Option<Ack>,
    /// Null unless `state` is `shelved`.
    #[schema(required)]
    pub shelved: Option<Shelf>,
    /// The condition, in words.
    pub what: Both,
    /// What usually leads to it.
    pub cause: Both,
    /// What follows if there is no response.
    pub consequence: Both,
    /// What the operator does.
    pub remedy: Both,
    /// Since when the condition has been absent without the alarm having returned, ms since 1970.
    #[serde(skip)]
    pub(super) gone_ms: Option<u64>,
}

/// An acknowledgement.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct Ack {
    /// The user's name.
    pub user: String,
    /// Time of the acknowledgement, ms since 1970.
    pub at_ms: u64,
}

/// Why and for how long an alarm is shelved.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct Shelf {
    /// The user's name.
    pub user: String,
    /// Until when, ms since 1970.
    pub until_ms: u64,
    /// The reason that the user gave.
    pub reason: String,
}

/// The fire alarm of the site.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct Fire {
    /// A detector sees a fire now.
    pub active: bool,
    /// The alarm of a fire is not acknowledged, be the fire gone or not.
    pub waiting: bool,
    /// Monitors whose detectors see a fire, or whose alarm waits.
    pub monitors: Vec<String>,
    /// When the first of them became active, ms since 1970.
    #[schema(required)]
    pub since_ms: Option<u64>,
}
