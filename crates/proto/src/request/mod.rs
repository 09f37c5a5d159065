//! §3 «Перечень поддерживаемых запросов»: typed requests and their bytes.
//!
//! Each request has a file with the number of its section: entry of the dictionary, layout of the
//! data, bytes, and text. The monitor's part of it and its scenarios have the same number.

pub(crate) mod bus;
pub(crate) mod s3_01_move;
pub(crate) mod s3_02_stop;
pub(crate) mod s3_03_getstatus;
pub(crate) mod s3_04_getparam;
pub(crate) mod s3_05_setparam;
pub(crate) mod s3_06_correction_table;
pub(crate) mod s3_07_retrieve_limits;
pub(crate) mod s3_08_open;
pub(crate) mod s3_09_close;
pub(crate) mod s3_10_deploy;
pub(crate) mod s3_11_wrap;
pub(crate) mod s3_12_restart;
pub(crate) mod s3_13_justify;
pub(crate) mod s3_14_quench;
pub(crate) mod s3_15_trajectory;
pub(crate) mod s3_16_seek;
pub(crate) mod s3_17_switch_limits;
pub(crate) mod s3_18_lockout;
pub(crate) mod s3_19_clean_flash;
pub(crate) mod s3_20_crash_data;
pub(crate) mod s3_21_hotbeds;

pub use s3_14_quench::{Quench, Sector};
pub use s3_15_trajectory::{Path, Points, Trajectory, TrajectoryPoint};
pub use s3_16_seek::Seek;
pub use s3_17_switch_limits::LimitsState;

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
    // What it calls in the files of the sections is inlined: one function is smaller on a chip.
    pub fn decode(request: RequestId, data: &'a [u8]) -> Result<Self, DecodeError> {
        match request {
            RequestId::MOVE => s3_01_move::decode(data),
            RequestId::STOP => s3_02_stop::decode(data),
            RequestId::GET_STATUS => s3_03_getstatus::decode(data),
            RequestId::GET_PARAM => s3_04_getparam::decode(data),
            RequestId::SET_PARAM => s3_05_setparam::decode(data),
            RequestId::SETUP_CORRECTION_TABLE => s3_06_correction_table::decode(data),
            RequestId::RETRIEVE_LIMITS => s3_07_retrieve_limits::decode(data),
            RequestId::OPEN => s3_08_open::decode(data),
            RequestId::CLOSE => s3_09_close::decode(data),
            RequestId::DEPLOY => s3_10_deploy::decode(data),
            RequestId::WRAP => s3_11_wrap::decode(data),
            RequestId::RESTART => s3_12_restart::decode(data),
            RequestId::START_JUSTIFY => s3_13_justify::decode(data),
            RequestId::START_QUENCH => Ok(Self::StartQuench(Quench::decode(data)?)),
            RequestId::START_TRAJECTORY => Ok(Self::StartTrajectory(Trajectory::decode(data)?)),
            RequestId::START_SEEK => Ok(Self::StartSeek(Seek::decode(data)?)),
            RequestId::SWITCH_LIMITS => s3_17_switch_limits::decode(data),
            RequestId::LOCKOUT => s3_18_lockout::decode(data),
            RequestId::CLEAN_FLASH => s3_19_clean_flash::decode(data),
            RequestId::GET_CRASH_DATA => s3_20_crash_data::decode(data),
            RequestId::GET_HOTBED => s3_21_hotbeds::decode(data),
            RequestId::ACCESS_GRANTED => none(data, Self::AccessGranted),
            RequestId::GET_NETWORK_STATUS => none(data, Self::GetNetworkStatus),
            RequestId::GET_LOG => bus::decode_log(data),
            request => Ok(Self::Unknown { request, data }),
        }
    }

    fn encode(&self, to: SubsystemId, out: &mut Writer<'_>) -> Result<(), NoRoom> {
        out.push_with(self.id(), to, Status::OK, |data| match self {
            Self::Move { destination } => s3_01_move::encode(*destination, data),
            Self::GetParam { id } => s3_04_getparam::encode(*id, data),
            Self::SetParam { id, values } => s3_05_setparam::encode(*id, *values, data),
            Self::SetupCorrectionTable { first, corrections } => {
                s3_06_correction_table::encode(*first, *corrections, data)
            }
            Self::Open { key } => s3_08_open::encode(*key, data),
            Self::Close { key } => s3_09_close::encode(*key, data),
            Self::StartQuench(quench) => quench.encode(data),
            Self::StartTrajectory(trajectory) => trajectory.encode(data),
            Self::StartSeek(seek) => seek.encode(data),
            Self::SwitchLimits { new_state } => s3_17_switch_limits::encode(*new_state, data),
            Self::Lockout { key } => s3_18_lockout::encode(*key, data),
            Self::CleanFlash { key } => s3_19_clean_flash::encode(*key, data),
            Self::GetLog { first, count } => bus::encode_log(*first, *count, data),
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
