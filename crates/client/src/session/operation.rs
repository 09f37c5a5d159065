//! An operation: a frame of requests, from the queue to the outcome.

use lafet_proto::RequestId;

use super::check::Forms;
use super::late_answers::Tag;
use super::medium::Framing;
use super::{Now, Outcome, Ticket};
use crate::answers::{RequestBuf, Requests};
use crate::deviation::Deviation;

/// Requests of one frame. None: a presence probe.
#[derive(Debug)]
pub struct Operation {
    pub ticket: Ticket,
    pub requests: Requests,
    haste: Haste,
    repeatable: bool,
    pub submitted: Now,
    /// Number of transmissions whose answers can be accepted.
    pub tries: u32,
    /// It has been transmitted, so it may have been executed.
    pub sent: bool,
    /// Time of the first transmission over this connection whose answer can be accepted.
    pub first_sent: Option<Now>,
    /// Urgent: time of the first transmission over any connection whose answer can be accepted.
    pub began: Option<Now>,
    /// Urgent: start of the time without answer that does not count as silence yet.
    pub silent_from: Option<Now>,
    /// Time after which it must not be sent.
    pub expires: Option<Now>,
    /// The caller does not wait for the outcome any more.
    pub cancelled: bool,
    /// Deviation of an answer of the monitor to it, over any connection.
    pub odd: Option<Box<Deviation>>,
    /// Request of an answer that has neither the tag nor any recent request.
    pub stray: Option<RequestId>,
}

/// Priority of an operation on a line, for any monitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Haste {
    /// Urgent, repeated in vain: the others on the line have their turn first, for a while.
    Again,
    Usual,
    /// Keeps a held motion going: late, the motion would end.
    Held,
    /// Stop, Close and Lockout on.
    Urgent,
}

/// The operation whose frame was sent.
#[derive(Debug)]
pub struct Outstanding {
    pub operation: Operation,
    pub tag: Option<Tag>,
    /// Transmissions of this frame; an answer to any of them answers the operation.
    pub tries: u32,
    pub sent: Now,
    pub deadline: Now,
    /// To be sent (again) by the next poll_transmit.
    pub due: bool,
    /// Until then a matching answer may belong to another frame (urgent, without tag).
    pub believe_from: Now,
    /// An answer without the tag has come.
    pub untagged: bool,
    /// The forms in which it has been sent.
    pub forms: Forms,
}

/// Whether the monitor answers tags.
#[derive(Debug, PartialEq, Eq)]
pub enum Echo {
    Unknown { untagged: u32 },
    Yes,
    No,
}

/// A frame that is no longer outstanding.
#[derive(Debug)]
pub struct Recent {
    pub tag: Option<Tag>,
    pub first: Option<RequestId>,
    pub answered: bool,
}

impl Outstanding {
    /// Whether the tag is at the end of the frame: for bare records, where nothing else marks the
    /// end, and for urgent requests, which a monitor that fails on the tag has executed by then.
    pub fn tag_ends(&self, framing: Framing) -> bool {
        framing == Framing::Records || self.operation.is_urgent()
    }
}

impl Operation {
    pub fn new(ticket: Ticket, requests: Requests, submitted: Now, expires: Option<Now>) -> Self {
        let urgent = !requests.is_empty() && requests.iter().all(RequestBuf::is_urgent);
        let haste = match expires {
            _ if urgent => Haste::Urgent,
            Some(_) => Haste::Held,
            None => Haste::Usual,
        };
        Self {
            ticket,
            haste,
            repeatable: requests.iter().all(RequestBuf::is_repeatable),
            requests,
            submitted,
            tries: 0,
            sent: false,
            first_sent: None,
            began: None,
            silent_from: None,
            expires,
            cancelled: false,
            odd: None,
            stray: None,
        }
    }

    /// The outcome without an acceptable answer.
    pub fn unanswered(&self) -> Outcome {
        let odd = self.odd.as_deref().cloned().map(|what| Outcome::Odd { what });
        odd.unwrap_or(Outcome::Silence { tries: self.tries, stray: self.stray })
    }

    /// Whether the caller has waited since then for an answer.
    pub fn waits_since(&self, time: Now) -> bool {
        self.submitted <= time
    }

    pub fn first(&self) -> Option<RequestId> {
        self.requests.first().map(RequestBuf::id)
    }

    /// Whether it belongs to a held motion.
    pub const fn is_held(&self) -> bool {
        self.expires.is_some()
    }

    pub const fn haste(&self) -> Haste {
        self.haste
    }

    pub fn is_urgent(&self) -> bool {
        self.haste == Haste::Urgent
    }

    /// A frame with only a tag, to find out whether the monitor answers it.
    pub fn question(now: Now) -> Self {
        Self::new(Ticket::QUESTION, Requests::new(), now, None)
    }

    pub const fn is_repeatable(&self) -> bool {
        self.repeatable
    }
}
