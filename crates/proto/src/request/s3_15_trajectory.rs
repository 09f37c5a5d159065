//! §3.15 StartTrajectory: the jet follows points (data: ours).

use super::{value_at, wrong_size};
use crate::dictionary::layouts::{Field, Layout, fields};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::record::{DATA_MAX, Data, NoRoom};
use crate::text::error::Wanted;
use crate::text::fields::{Buffer, Token, Tokens};
use crate::text::parse::{I16, Parsed, U8};
use crate::text::write_list;
use crate::{DecodeError, RequestId, SubsystemId};
use core::fmt;

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::START_TRAJECTORY,
    name: "StartTrajectory",
    section: "3.15",
    origin: Origin::Ours,
    addressees: &[SubsystemId::CONTROL],
    title: key!("request-StartTrajectory-title"),
    meaning: key!("request-StartTrajectory-meaning"),
};

/// Its data.
pub(crate) const LAYOUTS: &[Layout] = &[TRAJECTORY_POINTS, TRAJECTORY_STORED];

const TRAJECTORY: &[Field] = fields! { Trajectory:
    mode U8 Choice;
    flags U8 Bits;
    count U8 None;
};
const TRAJECTORY_POINTS: Layout = Layout {
    name: "TrajectoryPoints",
    fields: TRAJECTORY,
    repeated: fields! { Trajectory:
        horizontal I16 Arcmin;
        vertical I16 Arcmin;
        distance U8 Metre;
        dwell U8 DeciSecond;
    },
    times: (1, usize::MAX),
    prefix: &[0],
};
const TRAJECTORY_STORED: Layout = Layout {
    name: "TrajectoryStored",
    fields: TRAJECTORY,
    repeated: fields! { Trajectory: trajectory U8 None; },
    times: (1, usize::MAX),
    prefix: &[1],
};

/// §3.15 StartTrajectory (data: ours).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trajectory<'a> {
    /// Correct the elevation by ballistics.
    pub ballistics: bool,
    /// Start again after the last point.
    pub repeat: bool,
    /// The points to follow.
    pub path: Path<'a>,
}

/// The points of a trajectory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path<'a> {
    /// Mode 0: given in the request.
    Points(Points<'a>),
    /// Mode 1: numbers of stored trajectories, 0–7.
    Stored(&'a [u8]),
}

/// Points of a trajectory: bytes of a record, or points to encode.
#[derive(Clone, Copy, Debug)]
pub enum Points<'a> {
    /// Bytes of a record, [`TrajectoryPoint::SIZE`] for each point.
    Wire(&'a [u8]),
    /// Points to encode.
    Values(&'a [TrajectoryPoint]),
}

/// A point of a trajectory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TrajectoryPoint {
    /// Line of sight, horizontal, arc-minutes.
    pub horizontal: i16,
    /// Line of sight, vertical, arc-minutes.
    pub vertical: i16,
    /// Distance, m.
    pub distance: u8,
    /// Time to stay, 0.1 s.
    pub dwell: u8,
}

impl TrajectoryPoint {
    /// Bytes on the wire.
    pub const SIZE: usize = 6;

    /// The bytes of the point.
    pub const fn to_bytes(self) -> [u8; Self::SIZE] {
        let [h0, h1] = self.horizontal.to_le_bytes();
        let [v0, v1] = self.vertical.to_le_bytes();
        [h0, h1, v0, v1, self.distance, self.dwell]
    }

    /// The point that these bytes hold.
    pub const fn from_bytes([h0, h1, v0, v1, distance, dwell]: [u8; Self::SIZE]) -> Self {
        Self {
            horizontal: i16::from_le_bytes([h0, h1]),
            vertical: i16::from_le_bytes([v0, v1]),
            distance,
            dwell,
        }
    }
}

impl<'a> Points<'a> {
    /// Number of whole points.
    pub const fn len(self) -> usize {
        match self {
            Self::Wire(bytes) => bytes.len() / TrajectoryPoint::SIZE,
            Self::Values(values) => values.len(),
        }
    }

    /// Whether there is no whole point.
    pub const fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The points in order.
    pub fn iter(self) -> impl Iterator<Item = TrajectoryPoint> + Clone + 'a {
        (0..self.len()).map_while(move |index| match self {
            Self::Wire(bytes) => {
                bytes.as_chunks().0.get(index).map(|b| TrajectoryPoint::from_bytes(*b))
            }
            Self::Values(values) => values.get(index).copied(),
        })
    }
}

impl PartialEq for Points<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}

impl Eq for Points<'_> {}

impl<'a> Trajectory<'a> {
    const BALLISTICS: u8 = 1;
    const REPEAT: u8 = 2;

    pub(super) fn decode(data: &'a [u8]) -> Result<Self, DecodeError> {
        let Some((&[mode, flags, count], rest)) = data.split_first_chunk() else {
            return Err(wrong_size(data));
        };
        let count = usize::from(count);
        let path = match mode {
            0 if rest.len() == count * TrajectoryPoint::SIZE => Path::Points(Points::Wire(rest)),
            1 if rest.len() == count => Path::Stored(rest),
            0 | 1 => return Err(wrong_size(data)),
            _ => return Err(value_at(0, mode)),
        };
        if flags & !(Self::BALLISTICS | Self::REPEAT) != 0 {
            return Err(value_at(1, flags));
        }
        if count == 0 {
            return Err(value_at(2, 0));
        }
        let (ballistics, repeat) = (flags & Self::BALLISTICS != 0, flags & Self::REPEAT != 0);
        Ok(Self { ballistics, repeat, path })
    }

    pub(super) fn encode(&self, data: &mut Data<'_>) -> Result<(), NoRoom> {
        let flags = if self.ballistics { Self::BALLISTICS } else { 0 }
            | if self.repeat { Self::REPEAT } else { 0 };
        let (mode, count) = match self.path {
            Path::Points(points) => (0, points.len()),
            Path::Stored(numbers) => (1, numbers.len()),
        };
        data.put(&[mode, flags, u8::try_from(count).map_err(|_| NoRoom)?])?;
        match self.path {
            Path::Points(points) => points.iter().try_for_each(|point| data.put(&point.to_bytes())),
            Path::Stored(numbers) => data.put(numbers),
        }
    }
}

pub(crate) fn parse<'b>(tokens: &mut Tokens<'_>, buf: &'b mut [u8]) -> Parsed<Trajectory<'b>> {
    const KEYS: &[&str] = &["ballistics", "repeat", "point=", "stored="];
    let (mut ballistics, mut repeat) = (None, None);
    let (mut first_point, mut stored) = (None, None);
    let mut buffer = Buffer::new(buf, DATA_MAX - 3);
    while let Some(token) = tokens.next() {
        match token.pair() {
            None if token.text.eq_ignore_ascii_case("ballistics") => {
                token.set(&mut ballistics, ())?;
            }
            None if token.text.eq_ignore_ascii_case("repeat") => token.set(&mut repeat, ())?,
            Some(("point", value)) => {
                first_point.get_or_insert(token);
                buffer.push(&point(value)?.to_bytes(), token)?;
            }
            Some(("stored", value)) => {
                token.set(&mut stored, ())?;
                value.items().try_for_each(|item| {
                    buffer.push(&[item.number::<u8>("trajectory", U8)?], item)
                })?;
            }
            _ => return Err(token.error(Wanted::Word(KEYS))),
        }
    }
    let path = match (first_point, stored) {
        (Some(_), Some((_, token))) => {
            return Err(token.error(Wanted::NotTogether("point=", "stored=")));
        }
        (Some(_), None) => Path::Points(Points::Wire(buffer.finish())),
        (None, Some(_)) => Path::Stored(buffer.finish()),
        (None, None) => return Err(tokens.missing("point= or stored=")),
    };
    Ok(Trajectory { ballistics: ballistics.is_some(), repeat: repeat.is_some(), path })
}

fn point(list: Token<'_>) -> Parsed<TrajectoryPoint> {
    let what = "point h,v,distance,dwell";
    let [horizontal, vertical, distance, dwell] = list.split::<4>(what)?;
    Ok(TrajectoryPoint {
        horizontal: horizontal.number("horizontal", I16)?,
        vertical: vertical.number("vertical", I16)?,
        distance: distance.number("distance", U8)?,
        dwell: dwell.number("dwell", U8)?,
    })
}

pub(crate) fn write(f: &mut fmt::Formatter<'_>, trajectory: &Trajectory<'_>) -> fmt::Result {
    if trajectory.ballistics {
        f.write_str(" ballistics")?;
    }
    if trajectory.repeat {
        f.write_str(" repeat")?;
    }
    match trajectory.path {
        Path::Stored(numbers) => {
            f.write_str(" stored=")?;
            write_list(f, ",", numbers)
        }
        Path::Points(points) => points.iter().try_for_each(|p| {
            write!(f, " point={},{},{},{}", p.horizontal, p.vertical, p.distance, p.dwell)
        }),
    }
}
