//! §3 «Перечень поддерживаемых запросов»: typed requests and their bytes.

use crate::id::key;
use crate::record::{NoRoom, Record, Writer};
use crate::{Bytes, DecodeError, Expected, Ints, ParamId, RequestId, Status, SubsystemId};

/// A request: the addressee, and the request itself with its data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request<'a> {
    /// The addressee.
    pub to: SubsystemId,
    /// The request and its data.
    pub body: Body<'a>,
}

/// What a request asks for (§3.1–§3.21), or one of the bus controller's services (observed).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Body<'a> {
    /// §3.1 Move a drive.
    Move {
        /// Arc-minutes (nozzle: mm); beyond the limits means "as far as it goes".
        destination: i16,
    },
    /// §3.2 Stop.
    Stop,
    /// §3.3 State.
    GetStatus,
    /// §3.4, §3.21 Read a parameter.
    GetParam {
        /// Identifier of the parameter.
        id: ParamId,
    },
    /// §3.5 Set a parameter.
    SetParam {
        /// Identifier of the parameter.
        id: ParamId,
        /// Its new values.
        values: Ints<'a>,
    },
    /// §3.6 Store corrections of elevation by pressure (data: ours).
    SetupCorrectionTable {
        /// Index of the first correction, 0.1 atm.
        first: u8,
        /// Degrees to add to the elevation, one for each 0.1 atm.
        corrections: Bytes<'a>,
    },
    /// §3.7 Limits of motion.
    RetrieveLimits,
    /// §3.8 Open a valve.
    Open {
        /// [`key::OPEN`] confirms.
        key: u16,
    },
    /// §3.9 Close a valve.
    Close {
        /// [`key::CLOSE`] confirms.
        key: u16,
    },
    /// §3.10 Deploy.
    Deploy,
    /// §3.11 Wrap.
    Wrap,
    /// §3.12 Restart.
    Restart,
    /// §3.13 Align detector and barrel.
    StartJustify,
    /// §3.14 Extinguish.
    StartQuench(Quench<'a>),
    /// §3.15 Extinguish along trajectories (data: ours).
    StartTrajectory(Trajectory<'a>),
    /// §3.16 Search.
    StartSeek(Seek),
    /// §3.17 Limits off, on, or reject.
    SwitchLimits {
        /// 0 off, 1 on, 2 reject: see [`LimitsState`].
        new_state: u16,
    },
    /// §3 Hotbeds, as §3.21.
    GetHotbed,
    /// §3.18 Lockout on or off.
    Lockout {
        /// [`key::ENABLE`] or [`key::DISABLE`].
        key: u16,
    },
    /// §3.19 Erase the memory.
    CleanFlash {
        /// [`key::CLEAN_FLASH`] confirms.
        key: u16,
    },
    /// §3.20 Crash data.
    GetCrashData,
    /// Bus (observed): the controller lets an active device send one frame.
    AccessGranted,
    /// Bus (observed): which addresses are on the bus.
    GetNetworkStatus,
    /// Bus (observed): lines of the controller's log.
    GetLog {
        /// First line.
        first: u16,
        /// Number of lines.
        count: u16,
    },
    /// A request that is not in the document; its data are kept.
    Unknown {
        /// Identifier of the request.
        request: RequestId,
        /// Data of the request.
        data: &'a [u8],
    },
}

/// §3.14 StartQuench: data_size selects the variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quench<'a> {
    /// 8 bytes: a stored program, moved to a centre.
    Program {
        /// Number of the program, 0–7.
        program: i16,
        /// Centre, horizontal, arc-minutes.
        centre_h: i16,
        /// Centre, vertical, arc-minutes.
        centre_v: i16,
        /// Nozzle position, mm.
        nozzle: i16,
    },
    /// 12 bytes: all given; the elevation follows from the distance by ballistics.
    Full {
        /// The sector to extinguish.
        sector: Sector,
        /// Distance to the fire, m.
        distance: i8,
    },
    /// 13…255 bytes: with corrections of elevation by pressure from index 0.
    Corrected {
        /// The sector to extinguish.
        sector: Sector,
        /// Degrees, one for each 0.1 atm, at least two.
        corrections: Bytes<'a>,
    },
}

/// The sector that the jet scans.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sector {
    /// Centre, horizontal, arc-minutes.
    pub centre_h: i16,
    /// Centre, vertical, arc-minutes.
    pub centre_v: i16,
    /// Nozzle position, mm.
    pub nozzle: i16,
    /// Width, arc-minutes.
    pub width: i16,
    /// Height, arc-minutes.
    pub height: i16,
    /// Step between lines, degrees; 0 = aim at the centre.
    pub step: i8,
}

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

/// §3.16 StartSeek: the sector to search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seek {
    /// One end, horizontal, arc-minutes; may exceed the other.
    pub start_h: i16,
    /// Other end, horizontal, arc-minutes.
    pub end_h: i16,
    /// One end, vertical, arc-minutes.
    pub start_v: i16,
    /// Other end, vertical, arc-minutes.
    pub end_v: i16,
    /// 1: measure each hotbed precisely in a second pass; 0: do not.
    pub analyse: i16,
}

/// §3.17 The states that SwitchLimits can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitsState {
    /// 0: limits off.
    Off,
    /// 1: limits on; new ones set meanwhile take effect.
    On,
    /// 2: limits on; new ones set meanwhile are dropped.
    Reject,
}

impl LimitsState {
    /// The state for a value of the request's data.
    pub const fn from_wire(new_state: u16) -> Option<Self> {
        match new_state {
            0 => Some(Self::Off),
            1 => Some(Self::On),
            2 => Some(Self::Reject),
            _ => None,
        }
    }
}

impl<'a> Request<'a> {
    /// A request to one addressee.
    pub const fn new(to: SubsystemId, body: Body<'a>) -> Self {
        Self { to, body }
    }

    /// §3.8 Open with its key.
    pub const fn open(valve: SubsystemId) -> Self {
        Self::new(valve, Body::Open { key: key::OPEN })
    }

    /// §3.9 Close with its key.
    pub const fn close(valve: SubsystemId) -> Self {
        Self::new(valve, Body::Close { key: key::CLOSE })
    }

    /// §3.18 Lockout on or off with its key.
    pub const fn lockout(on: bool) -> Self {
        let key = if on { key::ENABLE } else { key::DISABLE };
        Self::new(SubsystemId::ALL, Body::Lockout { key })
    }

    /// Reads the request of a record. `status` is ignored: a request has none (§2).
    ///
    /// # Errors
    ///
    /// [`DecodeError`] with `Expected::Size` when the data have a size that the request cannot
    /// have: see [`Body::decode`].
    #[inline]
    pub fn decode(record: &Record<'a>) -> Result<Self, DecodeError> {
        Ok(Self { to: record.device, body: Body::decode(record.request, record.data)? })
    }

    /// Appends the request to a frame's payload.
    ///
    /// # Errors
    ///
    /// [`NoRoom`], and nothing is written, when the data take more than 255 bytes or the record
    /// does not fit what is left of the payload.
    pub fn encode(&self, out: &mut Writer<'_>) -> Result<(), NoRoom> {
        self.body.encode(self.to, out)
    }
}

impl<'a> Body<'a> {
    /// The request identifier.
    pub const fn id(&self) -> RequestId {
        match self {
            Self::Move { .. } => RequestId::MOVE,
            Self::Stop => RequestId::STOP,
            Self::GetStatus => RequestId::GET_STATUS,
            Self::GetParam { .. } => RequestId::GET_PARAM,
            Self::SetParam { .. } => RequestId::SET_PARAM,
            Self::SetupCorrectionTable { .. } => RequestId::SETUP_CORRECTION_TABLE,
            Self::RetrieveLimits => RequestId::RETRIEVE_LIMITS,
            Self::Open { .. } => RequestId::OPEN,
            Self::Close { .. } => RequestId::CLOSE,
            Self::Deploy => RequestId::DEPLOY,
            Self::Wrap => RequestId::WRAP,
            Self::Restart => RequestId::RESTART,
            Self::StartJustify => RequestId::START_JUSTIFY,
            Self::StartQuench(_) => RequestId::START_QUENCH,
            Self::StartTrajectory(_) => RequestId::START_TRAJECTORY,
            Self::StartSeek(_) => RequestId::START_SEEK,
            Self::SwitchLimits { .. } => RequestId::SWITCH_LIMITS,
            Self::GetHotbed => RequestId::GET_HOTBED,
            Self::Lockout { .. } => RequestId::LOCKOUT,
            Self::CleanFlash { .. } => RequestId::CLEAN_FLASH,
            Self::GetCrashData => RequestId::GET_CRASH_DATA,
            Self::AccessGranted => RequestId::ACCESS_GRANTED,
            Self::GetNetworkStatus => RequestId::GET_NETWORK_STATUS,
            Self::GetLog { .. } => RequestId::GET_LOG,
            Self::Unknown { request, .. } => *request,
        }
    }

    /// Reads the data of a request. Only the size is checked; ranges are checked by the addressee.
    ///
    /// # Errors
    ///
    /// [`DecodeError`] with `Expected::Size` when the data have a size that this request cannot
    /// have. Unknown requests are accepted as [`Body::Unknown`].
    pub fn decode(request: RequestId, data: &'a [u8]) -> Result<Self, DecodeError> {
        Ok(match request {
            RequestId::MOVE => Self::Move { destination: i16::from_le_bytes(exact(data)?) },
            RequestId::STOP => none(data, Self::Stop)?,
            RequestId::GET_STATUS => none(data, Self::GetStatus)?,
            RequestId::GET_PARAM => {
                Self::GetParam { id: ParamId(u16::from_le_bytes(exact(data)?)) }
            }
            RequestId::SET_PARAM => Self::decode_set_param(data)?,
            RequestId::SETUP_CORRECTION_TABLE => match data {
                [first, corrections @ ..] if !corrections.is_empty() => {
                    Self::SetupCorrectionTable { first: *first, corrections: Bytes(corrections) }
                }
                _ => return Err(wrong_size(data)),
            },
            RequestId::RETRIEVE_LIMITS => none(data, Self::RetrieveLimits)?,
            RequestId::OPEN => Self::Open { key: u16::from_le_bytes(exact(data)?) },
            RequestId::CLOSE => Self::Close { key: u16::from_le_bytes(exact(data)?) },
            RequestId::DEPLOY => none(data, Self::Deploy)?,
            RequestId::WRAP => none(data, Self::Wrap)?,
            RequestId::RESTART => none(data, Self::Restart)?,
            RequestId::START_JUSTIFY => none(data, Self::StartJustify)?,
            RequestId::START_QUENCH => Self::StartQuench(Quench::decode(data)?),
            RequestId::START_TRAJECTORY => Self::StartTrajectory(Trajectory::decode(data)?),
            RequestId::START_SEEK => Self::StartSeek(Seek::decode(data)?),
            RequestId::SWITCH_LIMITS => {
                Self::SwitchLimits { new_state: u16::from_le_bytes(exact(data)?) }
            }
            RequestId::GET_HOTBED => none(data, Self::GetHotbed)?,
            RequestId::LOCKOUT => Self::Lockout { key: u16::from_le_bytes(exact(data)?) },
            RequestId::CLEAN_FLASH => Self::CleanFlash { key: u16::from_le_bytes(exact(data)?) },
            RequestId::GET_CRASH_DATA => none(data, Self::GetCrashData)?,
            RequestId::ACCESS_GRANTED => none(data, Self::AccessGranted)?,
            RequestId::GET_NETWORK_STATUS => none(data, Self::GetNetworkStatus)?,
            RequestId::GET_LOG => {
                let [a, b, c, d] = exact(data)?;
                let (first, count) = (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
                Self::GetLog { first, count }
            }
            request => Self::Unknown { request, data },
        })
    }

    fn decode_set_param(data: &'a [u8]) -> Result<Self, DecodeError> {
        let (id, values) = data.split_first_chunk().ok_or(wrong_size(data))?;
        if values.len() % 4 != 0 {
            return Err(wrong_size(data));
        }
        Ok(Self::SetParam { id: ParamId(u16::from_le_bytes(*id)), values: Ints::Wire(values) })
    }

    fn encode(&self, to: SubsystemId, out: &mut Writer<'_>) -> Result<(), NoRoom> {
        out.push_with(self.id(), to, Status::OK, |data| match self {
            Self::Move { destination } => data.put_i16(*destination),
            Self::GetParam { id } => data.put_u16(id.0),
            Self::SetParam { id, values } => {
                data.put_u16(id.0)?;
                data.put_ints(values.iter())
            }
            Self::SetupCorrectionTable { first, corrections } => {
                data.put(&[*first])?;
                data.put(corrections.0)
            }
            Self::Open { key }
            | Self::Close { key }
            | Self::Lockout { key }
            | Self::CleanFlash { key } => data.put_u16(*key),
            Self::StartQuench(quench) => quench.encode(data),
            Self::StartTrajectory(trajectory) => trajectory.encode(data),
            Self::StartSeek(seek) => {
                [seek.start_h, seek.end_h, seek.start_v, seek.end_v, seek.analyse]
                    .into_iter()
                    .try_for_each(|value| data.put_i16(value))
            }
            Self::SwitchLimits { new_state } => data.put_u16(*new_state),
            Self::GetLog { first, count } => {
                data.put_u16(*first)?;
                data.put_u16(*count)
            }
            Self::Unknown { data: bytes, .. } => data.put(bytes),
            Self::Stop
            | Self::GetStatus
            | Self::RetrieveLimits
            | Self::Deploy
            | Self::Wrap
            | Self::Restart
            | Self::StartJustify
            | Self::GetHotbed
            | Self::GetCrashData
            | Self::AccessGranted
            | Self::GetNetworkStatus => Ok(()),
        })
    }
}

impl<'a> Quench<'a> {
    const FULL_SIZE: usize = 12;

    fn decode(data: &'a [u8]) -> Result<Self, DecodeError> {
        if let Ok([p0, p1, h0, h1, v0, v1, n0, n1]) = exact(data) {
            return Ok(Self::Program {
                program: i16::from_le_bytes([p0, p1]),
                centre_h: i16::from_le_bytes([h0, h1]),
                centre_v: i16::from_le_bytes([v0, v1]),
                nozzle: i16::from_le_bytes([n0, n1]),
            });
        }
        let (sector, rest) = data.split_first_chunk().ok_or(wrong_size(data))?;
        let sector = Sector::from_bytes(*sector);
        match rest {
            [] => Err(wrong_size(data)),
            [distance] => Ok(Self::Full { sector, distance: i8::from_le_bytes([*distance]) }),
            corrections => Ok(Self::Corrected { sector, corrections: Bytes(corrections) }),
        }
    }

    fn encode(&self, data: &mut crate::record::Data<'_>) -> Result<(), NoRoom> {
        match self {
            Self::Program { program, centre_h, centre_v, nozzle } => {
                [*program, *centre_h, *centre_v, *nozzle]
                    .into_iter()
                    .try_for_each(|value| data.put_i16(value))
            }
            Self::Full { sector, distance } => {
                data.put(&sector.to_bytes())?;
                data.put(&distance.to_le_bytes())
            }
            Self::Corrected { sector, corrections } => {
                // Fewer than two corrections would be read as another variant.
                if corrections.0.len() + Sector::SIZE <= Self::FULL_SIZE {
                    return Err(NoRoom);
                }
                data.put(&sector.to_bytes())?;
                data.put(corrections.0)
            }
        }
    }
}

impl Sector {
    const SIZE: usize = 11;

    const fn from_bytes([a, b, c, d, e, f, g, h, i, j, step]: [u8; Self::SIZE]) -> Self {
        Self {
            centre_h: i16::from_le_bytes([a, b]),
            centre_v: i16::from_le_bytes([c, d]),
            nozzle: i16::from_le_bytes([e, f]),
            width: i16::from_le_bytes([g, h]),
            height: i16::from_le_bytes([i, j]),
            step: i8::from_le_bytes([step]),
        }
    }

    const fn to_bytes(self) -> [u8; Self::SIZE] {
        let [a, b] = self.centre_h.to_le_bytes();
        let [c, d] = self.centre_v.to_le_bytes();
        let [e, f] = self.nozzle.to_le_bytes();
        let [g, h] = self.width.to_le_bytes();
        let [i, j] = self.height.to_le_bytes();
        let [step] = self.step.to_le_bytes();
        [a, b, c, d, e, f, g, h, i, j, step]
    }
}

impl<'a> Trajectory<'a> {
    const BALLISTICS: u8 = 1;
    const REPEAT: u8 = 2;

    fn decode(data: &'a [u8]) -> Result<Self, DecodeError> {
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

    fn encode(&self, data: &mut crate::record::Data<'_>) -> Result<(), NoRoom> {
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

impl Seek {
    fn decode(data: &[u8]) -> Result<Self, DecodeError> {
        let [a, b, c, d, e, f, g, h, i, j] = exact(data)?;
        Ok(Self {
            start_h: i16::from_le_bytes([a, b]),
            end_h: i16::from_le_bytes([c, d]),
            start_v: i16::from_le_bytes([e, f]),
            end_v: i16::from_le_bytes([g, h]),
            analyse: i16::from_le_bytes([i, j]),
        })
    }
}

fn exact<const N: usize>(data: &[u8]) -> Result<[u8; N], DecodeError> {
    data.try_into().map_err(|_| wrong_size(data))
}

fn none<'a>(data: &[u8], body: Body<'a>) -> Result<Body<'a>, DecodeError> {
    if data.is_empty() { Ok(body) } else { Err(wrong_size(data)) }
}

const fn wrong_size(data: &[u8]) -> DecodeError {
    DecodeError { offset: 0, expected: Expected::Size, got: data.len() }
}

fn value_at(offset: usize, got: u8) -> DecodeError {
    DecodeError { offset, expected: Expected::Value, got: usize::from(got) }
}
