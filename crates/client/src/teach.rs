//! §3.17 Teaching limits: the drive stands at its limit, and the monitor takes that as the limit.

use std::time::Duration;

use lafet_proto::answer::Reply;
use lafet_proto::dictionary::Text;
use lafet_proto::flags::DriveFlags;
use lafet_proto::request::LimitsState;
use lafet_proto::status::Limits;
use lafet_proto::{Status, SubsystemId};
use tokio::time::sleep;

use crate::error::Error;
use crate::monitor::{Monitor, typed};

/// A remote unit takes a limit within this many pauses.
const TRIES: u32 = 20;
const PAUSE: Duration = Duration::from_millis(150);

/// An end of the travel of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Of Horizontal: its MaxLimit.
    Left,
    /// Of Horizontal: its MinLimit.
    Right,
    /// Of Vertical: its MaxLimit.
    Up,
    /// Of Vertical: its MinLimit.
    Down,
    /// Of Nozzle: its MaxLimit.
    Narrow,
    /// Of Nozzle: its MinLimit.
    Wide,
}

/// A limit that was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Taken {
    /// Which.
    pub side: Side,
    /// Where the drive stands: arc-minutes, mm for Nozzle.
    pub position: i16,
    /// It is in force. Otherwise limits were off before, and stay so: it comes into force when they
    /// are switched on.
    pub in_force: bool,
    /// The limits of the drive as the monitor tells them now.
    pub limits: Limits,
}

impl Side {
    /// All of them, those of one drive together.
    pub const ALL: [Self; 6] =
        [Self::Left, Self::Right, Self::Up, Self::Down, Self::Narrow, Self::Wide];

    /// The drive whose limit it is.
    pub const fn drive(self) -> SubsystemId {
        match self {
            Self::Left | Self::Right => SubsystemId::HORIZONTAL,
            Self::Up | Self::Down => SubsystemId::VERTICAL,
            Self::Narrow | Self::Wide => SubsystemId::NOZZLE,
        }
    }

    /// The parameter that holds it.
    pub const fn param(self) -> &'static str {
        match self {
            Self::Left | Self::Up | Self::Narrow => "MaxLimit",
            Self::Right | Self::Down | Self::Wide => "MinLimit",
        }
    }

    /// The word for it on a command line.
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

    /// The word for it in a sentence.
    pub const fn text(self) -> Text {
        match self {
            Self::Left => Text::new("left", "левый"),
            Self::Right => Text::new("right", "правый"),
            Self::Up => Text::new("upper", "верхний"),
            Self::Down => Text::new("lower", "нижний"),
            Self::Narrow => Text::new("narrowest", "самый узкий"),
            Self::Wide => Text::new("widest", "самый широкий"),
        }
    }
}

impl Monitor {
    /// Takes the present position of a drive as its limit. Limits that are on are switched off for
    /// it and on again; when that fails, the old ones stay (Reject). The drive has to stand: Busy
    /// otherwise.
    ///
    /// # Errors
    ///
    /// As [`Monitor::switch_limits`] and [`Monitor::set_param`]: `BUSY` while the drive moves,
    /// `INVALID_VALUE` for a position that has changed meanwhile or limits that cross.
    pub async fn take_limit(&self, side: Side) -> Result<Taken, Error> {
        let drive = side.drive();
        let was_off = self.drive_now(drive).await?.1;
        if !was_off {
            self.switch_limits(drive, LimitsState::Off).await?;
        }
        let taken = self.take(side, was_off).await;
        if taken.is_err() && !was_off {
            // The error that is told is the one that came first.
            let _ = self.switch_limits(drive, LimitsState::Reject).await;
        }
        taken
    }

    /// Switches limits on: those that were taken come into force. A remote unit that has not got them
    /// yet answers Busy, and is asked again.
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

    /// Position, and whether limits are off.
    async fn drive_now(&self, drive: SubsystemId) -> Result<(i16, bool), Error> {
        let answer = self.status(drive).await?;
        match typed(&answer)? {
            Reply::Drive(s) => Ok((s.position, s.flags.contains(DriveFlags::LIMITLESS))),
            _ => Err(crate::monitor::wrong_shape(&answer)),
        }
    }
}
