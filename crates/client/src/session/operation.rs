//! What a session sends: an operation is a frame of requests, from its queue to its outcome.

use lafet_proto::RequestId;

use super::check::Forms;
use super::doubt::Tag;
use super::{Now, Ticket};
use crate::answers::RequestBuf;

/// Requests that go out in one frame. None at all: a presence probe.
#[derive(Debug)]
pub struct Operation {
    pub ticket: Ticket,
    pub requests: Vec<RequestBuf>,
    pub submitted: Now,
    /// How often it has been sent such that an answer can be believed.
    pub tries: u32,
    /// It has been on the line, so it may have been executed.
    pub sent: bool,
    /// When it was sent first over this connection.
    pub first_sent: Option<Now>,
    /// Not to be sent after this moment.
    pub expires: Option<Now>,
    /// Nobody waits for the outcome any more.
    pub cancelled: bool,
}

/// The operation whose frame is out.
#[derive(Debug)]
pub struct Outstanding {
    pub operation: Operation,
    pub tag: Option<Tag>,
    /// Tries of this stay on the line; answers to any of them are answers to the operation.
    pub tries: u32,
    pub sent: Now,
    pub deadline: Now,
    /// To be sent (again) by the next poll_transmit.
    pub due: bool,
    /// Before this moment a matching answer may still be another frame's (urgent, without tag).
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

impl Operation {
    pub const fn new(
        ticket: Ticket,
        requests: Vec<RequestBuf>,
        submitted: Now,
        expires: Option<Now>,
    ) -> Self {
        let (tries, sent, first_sent, cancelled) = (0, false, None, false);
        Self { ticket, requests, submitted, tries, sent, first_sent, expires, cancelled }
    }

    pub fn first(&self) -> Option<RequestId> {
        self.requests.first().map(RequestBuf::id)
    }

    pub fn is_urgent(&self) -> bool {
        !self.requests.is_empty() && self.requests.iter().all(RequestBuf::is_urgent)
    }

    pub fn is_repeatable(&self) -> bool {
        self.requests.iter().all(RequestBuf::is_repeatable)
    }
}
