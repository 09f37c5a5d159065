//! What a master asks for, and what the hub is to do.

use lafet_client::Toward;

use super::refusal::Refusal;
pub use crate::plugs::orders::{Command, What};

/// How often a monitor was stopped, closed or locked out so far, from wherever.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stops {
    /// All of these.
    pub all: u64,
    /// Those that end a motion by hand: what closes does not.
    pub motion: u64,
}

/// What the hub is to do. Monitors are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// A command; its result comes to [`super::desk::Desk::answered`] with the ticket.
    Do {
        /// Number of the command within the session.
        ticket: u32,
        /// The monitor; `None`: all of the site.
        monitor: Option<usize>,
        /// What is asked for.
        what: What,
    },
    /// A beat of a motion by hand; what becomes of it comes to [`super::desk::Desk::jogged`].
    Beat {
        /// The monitor.
        monitor: usize,
        /// 0 traverse, 1 elevation, 2 nozzle.
        axis: usize,
        /// The direction.
        toward: Toward,
    },
    /// A motion by hand is released.
    Release {
        /// The monitor.
        monitor: usize,
        /// The drive.
        axis: usize,
    },
    /// A drive that was sent somewhere stops, if the session holds the monitor still.
    Halt {
        /// The monitor.
        monitor: usize,
        /// The drive.
        axis: usize,
    },
    /// A valve that the session has opened closes, unless another client holds the monitor.
    Shut {
        /// The monitor.
        monitor: usize,
        /// Valve 1 or 2.
        valve: u16,
    },
    /// An opening was refused here, without a question to the monitor: it is noted.
    Refused {
        /// The monitor.
        monitor: usize,
        /// Valve 1 or 2.
        valve: u16,
        /// Why.
        why: Refusal,
    },
    /// The heartbeat is lost: so is the authority, unless it comes back in time.
    Lost,
    /// The heartbeat is back.
    Back,
}
