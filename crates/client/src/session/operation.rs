//! What a session sends: an operation is a frame of requests, from its queue to its outcome.

use lafet_proto::RequestId;

use super::check::Forms;
use super::doubt::Tag;
use super::medium::Framing;
use super::{Now, Ticket};
use crate::answers::RequestBuf;
use crate::deviation::Deviation;

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
    /// When it was sent first over this connection such that an answer can be believed.
    pub first_sent: Option<Now>,
    /// Not to be sent after this moment.
    pub expires: Option<Now>,
    /// Nobody waits for the outcome any more.
    pub cancelled: bool,
    /// The monitor answered with something that is no answer to it, over whatever connection.
    pub odd: Option<Deviation>,
    /// What came of the monitor instead has neither the tag nor anything that was asked lately.
    pub stray: Option<RequestId>,
}

/// What goes first on a line, whichever monitor it is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Haste {
    Usual,
    /// What keeps a motion by hand going: late, it ends.
    Held,
    /// Stop, Close and Lockout on.
    Urgent,
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

impl Outstanding {
    /// The tag is the end of the frame: of bare records, where nothing else marks it, and of what
    /// is urgent, which a monitor that stumbles over the tag has executed by then.
    pub fn tag_ends(&self, framing: Framing) -> bool {
        framing == Framing::Records || self.operation.is_urgent()
    }
}

impl Operation {
    pub const fn new(
        ticket: Ticket,
        requests: Vec<RequestBuf>,
        submitted: Now,
        expires: Option<Now>,
    ) -> Self {
        Self {
            ticket,
            requests,
            submitted,
            tries: 0,
            sent: false,
            first_sent: None,
            expires,
            cancelled: false,
            odd: None,
            stray: None,
        }
    }

    pub fn first(&self) -> Option<RequestId> {
        self.requests.first().map(RequestBuf::id)
    }

    /// It belongs to a motion that is held.
    pub const fn is_held(&self) -> bool {
        self.expires.is_some()
    }

    pub fn haste(&self) -> Haste {
        match () {
            () if self.is_urgent() => Haste::Urgent,
            () if self.is_held() => Haste::Held,
            () => Haste::Usual,
        }
    }

    pub fn is_urgent(&self) -> bool {
        !self.requests.is_empty() && self.requests.iter().all(RequestBuf::is_urgent)
    }

    /// A frame that has only a tag: does the monitor answer it?
    pub const fn question(now: Now) -> Self {
        Self::new(Ticket::QUESTION, Vec::new(), now, None)
    }

    pub fn is_repeatable(&self) -> bool {
        self.requests.iter().all(RequestBuf::is_repeatable)
    }
}
