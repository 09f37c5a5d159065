//! What the hub says over the WebSocket besides what it publishes.

use std::collections::{BTreeMap, BTreeSet};

use axum::extract::ws::Utf8Bytes;
use serde::Serialize;
use utoipa::ToSchema;

use crate::access::{Kind, Role};
use crate::api::Id;
use crate::command::outcome::{OfOne, Outcome, parted};
use crate::control::authority::Seat;
use crate::error::{ApiError, ErrorBody};
use crate::hub::About;
use crate::monitor::view::Control;
use crate::publish::topics::Change;
use crate::text::Both;
use crate::words::{DirectionWord, LossWord, MotionEnd, MotionWord, VerdictWord};

/// A message of the hub.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Message {
    /// The first one of a connection.
    Hello(Box<Hello>),
    /// An event.
    Event {
        /// Time of the event, ms since 1970.
        at_ms: u64,
        /// Id of the monitor; null if it concerns none.
        #[schema(required)]
        monitor: Option<String>,
        /// The event, in words.
        what: Both,
    },
    /// Another client asks for control of a monitor that this one holds.
    Asked {
        /// Id of the monitor.
        monitor: String,
        /// The client that asks.
        by: Seat,
        /// It is granted then, unless it is denied before.
        until_ms: u64,
    },
    /// Control was granted.
    AuthorityGranted {
        /// Id of the monitor.
        monitor: String,
    },
    /// Control was denied.
    AuthorityDenied {
        /// Id of the monitor.
        monitor: String,
    },
    /// Control is lost.
    AuthorityLost {
        /// Id of the monitor.
        monitor: String,
        /// How control was lost.
        how: LossWord,
        /// The new holder.
        #[schema(required)]
        by: Option<Seat>,
        /// Why it was taken by force.
        #[schema(required)]
        reason: Option<String>,
    },
    /// The state of a motion by hand.
    Jog {
        /// Id of the monitor.
        monitor: String,
        /// Name of the drive.
        drive: String,
        /// State of the motion.
        state: MotionWord,
        /// How the motion ended.
        #[schema(required)]
        end: Option<MotionEnd>,
        /// The end, in words.
        #[schema(required)]
        text: Option<Both>,
    },
    /// A frame of a monitor that is watched.
    Frame(ShownFrame),
    /// The answer to a message of the client.
    Answer(Box<Answer>),
    /// What is known of an urgent request before its answer.
    Progress(Box<Progress>),
    /// All topics as they are.
    State(Published),
    /// Topics that have changed.
    Change(Published),
    /// Messages were left out: the client reads too slowly.
    Missed {
        /// Number of messages dropped.
        count: u64,
    },
}

/// The answer to a message of the client: one of `result`, `results`, `authority`, `subscribed` and
/// `error`.
#[derive(Clone, Debug, Default, Serialize, ToSchema)]
pub struct Answer {
    /// The id of the message.
    #[schema(value_type = Option<String>)]
    pub id: Id,
    /// How the monitor has answered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub result: Option<Outcome>,
    /// How every monitor has answered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub results: Option<BTreeMap<String, OfOne>>,
    /// Who commands the monitor now.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub authority: Option<Control>,
    /// What is sent from now on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub subscribed: Option<Subscribed>,
    /// Why the request was refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<ErrorBody>,
}

/// The monitors of which a client is sent every change.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Subscribed {
    /// Ids of the monitors; null: all.
    #[schema(required)]
    pub monitors: Option<BTreeSet<String>>,
}

/// What is known of an urgent request before its answer.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Progress {
    /// The id of the message.
    #[schema(value_type = Option<String>)]
    pub id: Id,
    /// Id of the monitor.
    pub monitor: String,
    /// `false`: it is sent, and there is no answer yet.
    pub answered: bool,
    /// How the monitor has answered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub result: Option<Outcome>,
    /// Why the request was refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<ErrorBody>,
}

/// Topics and their values.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Published {
    /// Date of the hub, ms since 1970.
    pub now_ms: u64,
    /// Since its start, ms, by a clock that does not jump: a client says by it when it has sent something.
    pub up_ms: u64,
    /// The topics that have changed.
    #[serde(flatten)]
    #[schema(inline)]
    pub change: Change,
}

/// The first message to a client.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Hello {
    /// Date of the hub, ms since 1970.
    pub now_ms: u64,
    /// Since its start, ms, by a clock that does not jump: a client says by it when it has sent something.
    pub up_ms: u64,
    /// What the connection is called.
    pub seat: String,
    /// Gives the seat back to a connection that begins with it.
    #[schema(required)]
    pub resume: Option<String>,
    /// Name of the user.
    pub user: String,
    /// Role of the user.
    pub role: Role,
    /// How the user has authenticated.
    pub kind: Kind,
    /// The hub and its site.
    pub hub: About,
    /// Times of a motion by hand.
    pub jog: JogTimes,
}

/// Times of a motion by hand.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
pub struct JogTimes {
    /// A beat is sent this often.
    pub beat_ms: u64,
    /// The motion ends this long after the last one.
    pub watchdog_ms: u64,
}

/// A frame as text and bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ShownFrame {
    /// Id of the monitor.
    pub monitor: String,
    /// Time of the frame, ms since 1970.
    pub at_ms: u64,
    /// Direction of the frame.
    pub direction: DirectionWord,
    /// What became of it.
    pub verdict: VerdictWord,
    /// Address that it is for.
    pub dst: u8,
    /// Address that it is from.
    pub src: u8,
    /// Its payload, two hexadecimal digits a byte.
    pub bytes: String,
    /// Its records in the text form.
    pub text: String,
}

impl Answer {
    /// Of a message, still empty.
    pub fn to(id: Id) -> Self {
        Self { id, ..Self::default() }
    }

    /// The answer to a request.
    pub fn of(id: Id, result: Result<Outcome, ApiError>) -> Self {
        let (result, error) = parted(result);
        Self { result, error, ..Self::to(id) }
    }

    /// That something cannot be done.
    pub fn refused(id: Id, error: &ApiError) -> Self {
        Self { error: Some(error.body()), ..Self::to(id) }
    }
}

impl Progress {
    /// The request is sent and not answered yet.
    pub fn sent(id: Id, monitor: &str) -> Self {
        Self { id, monitor: monitor.to_owned(), answered: false, result: None, error: None }
    }
}

impl Message {
    /// The message as JSON.
    pub fn written(&self) -> Utf8Bytes {
        serde_json::to_string(self).unwrap_or_default().into()
    }
}
