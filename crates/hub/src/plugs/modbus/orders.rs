//! What a master asks for, and what the hub is to do.

use lafet_client::Toward;

use super::refusal::Refusal;

/// The commands, by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Command {
    /// Takes authority, if it is free.
    Take = 1,
    /// Releases authority.
    Release = 2,
    /// Asks the holder for authority.
    Ask = 3,
    /// Moves drives to positions.
    GoTo = 4,
    /// Opens a valve.
    Open = 5,
    /// Closes a valve, or all of a monitor.
    Close = 6,
    /// Stops a monitor, or all.
    Stop = 7,
    /// Locks a monitor out, or all.
    Lockout = 8,
    /// Deploys.
    Deploy = 9,
    /// Stows.
    Stow = 10,
}

impl Command {
    /// All, by their numbers.
    pub const ALL: [Self; 10] = [
        Self::Take,
        Self::Release,
        Self::Ask,
        Self::GoTo,
        Self::Open,
        Self::Close,
        Self::Stop,
        Self::Lockout,
        Self::Deploy,
        Self::Stow,
    ];

    /// The number in the registers.
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// The command of a number.
    pub fn by_number(number: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.number() == number)
    }

    /// Taken from every master, always.
    pub const fn is_urgent(self) -> bool {
        matches!(self, Self::Close | Self::Stop | Self::Lockout)
    }
}

/// What a command asks the hub for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// Authority is taken, released or asked for.
    Authority(Command),
    /// Targets of the drives that are to move: 0.1°, of the nozzle mm.
    GoTo([Option<i16>; 3]),
    /// Valve 1 or 2 opens.
    Open(u16),
    /// Valve 1 or 2 closes; 0: all.
    Close(u16),
    /// Everything stops.
    Stop,
    /// Everything stops and closes, and stays so.
    Lockout,
    /// The barrel is deployed.
    Deploy,
    /// The barrel is stowed.
    Stow,
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
    /// A valve that the session has opened closes.
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
