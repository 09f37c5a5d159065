//! What a client of a plug asks for.

use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};

/// The drives, in the order of their targets.
pub const AXES: [SubsystemId; 3] =
    [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL, SubsystemId::NOZZLE];

/// The commands, by their numbers in registers.
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

    /// Its name in texts.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Take => "take",
            Self::Release => "release",
            Self::Ask => "ask",
            Self::GoTo => "goto",
            Self::Open => "open",
            Self::Close => "close",
            Self::Stop => "stop",
            Self::Lockout => "lockout",
            Self::Deploy => "deploy",
            Self::Stow => "stow",
        }
    }

    /// The command of a name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }

    /// Taken from every client, always.
    pub const fn is_urgent(self) -> bool {
        matches!(self, Self::Close | Self::Stop | Self::Lockout)
    }
}

/// What a command asks the hub for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// Authority is taken, released or asked for.
    Authority(Command),
    /// Targets of the drives that are to move: arc-minutes, of the nozzle mm.
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

impl What {
    /// The requests that it is, one for each drive.
    pub fn requests(self) -> Vec<Request<'static>> {
        match self {
            Self::GoTo(targets) => {
                let moved = AXES.into_iter().zip(targets);
                let one = |(axis, target): (SubsystemId, Option<i16>)| {
                    let destination = target?;
                    Some(Request::new(axis, Body::Move { destination }))
                };
                moved.filter_map(one).collect()
            }
            Self::Open(valve) => vec![Request::open(valve_of(valve))],
            Self::Deploy => vec![Request::new(SubsystemId::DEPLOYER, Body::Deploy)],
            Self::Stow => vec![Request::new(SubsystemId::DEPLOYER, Body::Wrap)],
            Self::Authority(_) | Self::Stop | Self::Close(_) | Self::Lockout => Vec::new(),
        }
    }
}

/// Whether the number of a command is from before that of another; they wrap.
pub const fn is_earlier(number: u32, other: u32) -> bool {
    number.wrapping_sub(other).cast_signed() < 0
}

/// Valve 1 or 2.
pub const fn valve_of(number: u16) -> SubsystemId {
    if number == 2 { SubsystemId::VALVE2 } else { SubsystemId::VALVE1 }
}
