//! §3.17 Setting a limit by position: the monitor takes the present position of the drive as the
//! limit.

use std::time::Duration;

use lafet_proto::answer::Reply;
use lafet_proto::flags::DriveFlags;
use lafet_proto::request::LimitsState;
use lafet_proto::status::Limits;
use lafet_proto::{Status, SubsystemId};
use lafet_texts::{Fixed, client as text};
use tokio::time::sleep;

use crate::error::Error;
use crate::monitor::{Monitor, typed};

/// Pauses within which a remote unit takes a limit.
const TRIES: u32 = 20;
const PAUSE: Duration = Duration::from_millis(150);

/// An end of a drive's travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// MaxLimit of Horizontal.
    Left,
    /// MinLimit of Horizontal.
    Right,
    /// MaxLimit of Vertical.
    Up,
    /// MinLimit of Vertical.
    Down,
    /// MaxLimit of Nozzle.
    Narrow,
    /// MinLimit of Nozzle.
    Wide,
}

/// A limit that was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Taken {
    /// The end of travel.
    pub side: Side,
    /// Present position of the drive: arc-minutes, mm for Nozzle.
    pub position: i16,
    /// Whether the limit is in force. If limits were off before, they stay off, and it comes into
    /// force when they are switched on.
    pub in_force: bool,
    /// The limits of the drive as the monitor now reports them.
    pub limits: Limits,
}

impl Side {
    /// All ends, those of one drive together.
    pub const ALL: [Self; 6] =
        [Self::Left, Self::Right, Self::Up, Self::Down, Self::Narrow, Self::Wide];

    /// The drive that has this limit.
    pub const fn drive(self) -> SubsystemId {
        match self {
            Self::Left | Self::Right => SubsystemId::HORIZONTAL,
            Self::Up | Self::Down => SubsystemId::VERTICAL,
            Self::Narrow | Self::Wide => SubsystemId::NOZZLE,
        }
    }

    /// The name of the parameter of this limit.
    pub const fn param(self) -> &'static str {
        match self {
            Self::Left | Self::Up | Self::Narrow => "MaxLimit",
            Self::Right | Self::Down | Self::Wide => "MinLimit",
        }
    }

    /// The name on a command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
            Self::Up => "up",
            Self::Down => "down",
            Self::Narrow => "narrow",
            Self::Wide => "wide",
        }
    }

    /// The name in a sentence.
    pub const fn text(self) -> Fixed {
        match self {
            Self::Left => text::SideLeft.fixed(),
            Self::Right => text::SideRight.fixed(),
            Self::Up => text::SideUp.fixed(),
            Self::Down => text::SideDown.fixed(),
            Self::Narrow => text::SideNarrow.fixed(),
            Self::Wide => text::SideWide.fixed(),
        }
    }
}

impl Monitor {
    /// Takes the present position of a drive as its limit. Limits that are on are switched off for
    /// this and on again; after an error the previous limits are kept (Reject), unless the new ones
    /// had come into force and only the answer was lost. The drive must be at rest, otherwise the
    /// answer is Busy.
    ///
    /// # Errors
    ///
    /// As [`Monitor::switch_limits`] and [`Monitor::set_param`]: `BUSY` while the drive moves,
    /// `INVALID_VALUE` for a position that has changed meanwhile or limits that cross. If Reject
    /// fails as well, its error is returned instead: the limits may be off then.
    pub async fn take_limit(&self, side: Side) -> Result<Taken, Error> {
        let drive = side.drive();
        let was_off = self.drive_now(drive).await?.1;
        if !was_off {
            self.switch_limits(drive, LimitsState::Off).await?;
        }
        let taken = self.take(side, was_off).await;
        if taken.is_err() && !was_off {
            // Without it the limits may still be off, which is worse than any other error.
            self.switch_limits(drive, LimitsState::Reject).await?;
        }
        taken
    }

    /// Switches limits on, so that new ones come into force. A remote unit that has not taken them
    /// yet answers Busy, and the request is repeated.
    ///
    /// # Errors
    ///
    /// As [`Monitor::switch_limits`]; `BUSY` when the remote unit has not taken a limit within 3 s.
    pub async fn confirm_limits(&self, drive: SubsystemId) -> Result<(), Error> {
        let mut tries = 0;
        loop {
            match self.switch_limits(drive, LimitsState::On).await {
                Err(Error::Refused { status: Status::BUSY, .. }) if tries < TRIES => {
                    tries += 1;
                    sleep(PAUSE).await;
                }
                other => return other.map(|_| ()),
            }
        }
    }

    async fn take(&self, side: Side, was_off: bool) -> Result<Taken, Error> {
        let drive = side.drive();
        let position = self.drive_now(drive).await?.0;
        self.set_param(drive, side.param(), &[position.into()]).await?;
        if !was_off {
            self.confirm_limits(drive).await?;
        }
        let limits = self.limits(drive).await?;
        Ok(Taken { side, position, in_force: !was_off, limits })
    }

    /// Reads the position, and whether limits are off.
    async fn drive_now(&self, drive: SubsystemId) -> Result<(i16, bool), Error> {
        let answer = self.status(drive).await?;
        match typed(&answer)? {
            Reply::Drive(s) => Ok((s.position, s.flags.contains(DriveFlags::LIMITLESS))),
            _ => Err(crate::monitor::wrong_shape(&answer)),
        }
    }
}
