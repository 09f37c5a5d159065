//! Words of the API that are one of a few.

use lafet_client::Verdict;
use lafet_proto::flags;
use serde::Serialize;
use utoipa::ToSchema;

/// How much a flag matters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Normal operation.
    #[default]
    Info,
    /// Nothing is broken, but the operator should know it.
    Notice,
    /// Something works worse than it should, or is not prepared.
    Warning,
    /// A function is lost, or there is a fire.
    Alarm,
}

/// Whether there is a connection to a monitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum LinkWord {
    /// The link is up.
    Up,
    /// The link is down.
    Down,
}

/// Whether a monitor is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ControlWord {
    /// No client holds it.
    Free,
    /// A client holds it.
    Held,
    /// The holder's connection is lost; it may come back.
    Lost,
}

/// How control of a monitor ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum LossWord {
    /// It was taken over by force.
    Forced,
    /// It was granted to another client.
    Granted,
    /// The holder has released it.
    Released,
    /// The holder's connection did not come back in time.
    Expired,
}

/// The state of a motion by hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum MotionWord {
    /// The next beat starts it.
    Armed,
    /// The drive moves.
    Moving,
    /// It was released and brakes.
    Stopping,
    /// The motion has ended.
    Ended,
}

/// How a motion by hand ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum MotionEnd {
    /// It was stopped.
    Stopped,
    /// The drive stopped by itself.
    Standing,
    /// The monitor, the line or the hub refused it.
    Refused,
    /// Another motion of the same hand took its place.
    Replaced,
    /// Another client moves the drive.
    TakenOver,
    /// The drive goes on in spite of Stop.
    StillMoving,
    /// The monitor would not end the motion by itself.
    Unbounded,
    /// The end is unknown.
    Unknown,
}

/// Direction of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum DirectionWord {
    /// To the monitor.
    Out,
    /// From the monitor.
    In,
}

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum VerdictWord {
    /// Sent by the hub; in a recording, by any client.
    Sent,
    /// The answer to the request before it.
    Believed,
    /// An answer that came too late.
    Late,
    /// A duplicate of an answer.
    Duplicate,
    /// From or to another device.
    Foreign,
    /// From the monitor, but no answer to any request of the hub.
    Unmatched,
    /// In a recording, any other frame: which request it answers is not known.
    Heard,
}

impl From<Verdict> for VerdictWord {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Sent => Self::Sent,
            Verdict::Believed => Self::Believed,
            Verdict::Late => Self::Late,
            Verdict::Duplicate => Self::Duplicate,
            Verdict::Foreign => Self::Foreign,
            // Also what a later version of the client may tell apart.
            _ => Self::Unmatched,
        }
    }
}

/// What has become of a value that is saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SavedWord {
    /// The value is stored.
    Stored,
    /// It is in force, and nothing has said that it is stored.
    Unconfirmed,
    /// It is in force until the next reset: the monitor cannot write it.
    WriteFailed,
}

impl MotionEnd {
    /// As the audit log has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stopped => "stopped",
            Self::Standing => "standing",
            Self::Refused => "refused",
            Self::Replaced => "replaced",
            Self::TakenOver => "taken_over",
            Self::StillMoving => "still_moving",
            Self::Unbounded => "unbounded",
            Self::Unknown => "unknown",
        }
    }
}

impl From<flags::Severity> for Severity {
    fn from(it: flags::Severity) -> Self {
        match it {
            flags::Severity::Info => Self::Info,
            flags::Severity::Notice => Self::Notice,
            flags::Severity::Warning => Self::Warning,
            flags::Severity::Alarm => Self::Alarm,
        }
    }
}

impl From<lafet_client::Saved> for SavedWord {
    fn from(it: lafet_client::Saved) -> Self {
        match it {
            lafet_client::Saved::Stored => Self::Stored,
            lafet_client::Saved::Unconfirmed => Self::Unconfirmed,
            lafet_client::Saved::WriteFailed => Self::WriteFailed,
        }
    }
}
