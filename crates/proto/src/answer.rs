//! §3 «Перечень поддерживаемых запросов»: typed answers and their bytes.

use crate::bus::{Log, NetworkStatus};
use crate::record::{NoRoom, Record, Writer};
use crate::status::{
    ButtonsStatus, ConnStatus, ControlStatus, DeployerStatus, DetectorStatus, DriveStatus,
    FaultInfo, GeneralStatus, Hotbed, Limits, ThermoStatus, ValveStatus,
};
use crate::{DecodeError, Expected, Ints, ParamId, RequestId, Status, SubsystemId};

/// An answer (§2): the subsystem that answers, the request, the result, the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer<'a> {
    /// The subsystem that answers: the addressee, or one that intercepted the request.
    pub from: SubsystemId,
    /// The request that is answered.
    pub request: RequestId,
    /// Result of the request (§2).
    pub status: Status,
    /// Data of the answer.
    pub data: Reply<'a>,
}

/// Data of an answer. An answer that refuses a request mostly has none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reply<'a> {
    /// No data.
    None,
    /// §3.3 General.
    General(GeneralStatus),
    /// §3.3 Climatics.
    Thermo(ThermoStatus),
    /// §3.3 Vertical, Horizontal, Nozzle.
    Drive(DriveStatus),
    /// §3.3 Valve1, Valve2.
    Valve(ValveStatus),
    /// §3.3 Control.
    Control(ControlStatus),
    /// §3.3 Detector.
    Detector(DetectorStatus),
    /// §3.3 Deployer.
    Deployer(DeployerStatus),
    /// §3.3 ExternalConn, Radio.
    Conn(ConnStatus),
    /// §3.3 Buttons, ExtButtons.
    Buttons(ButtonsStatus),
    /// §3.4, §3.21 Values of a parameter.
    Param {
        /// Identifier of the parameter.
        id: ParamId,
        /// Its values; none in the answer to SetParam and in a refusal.
        values: Ints<'a>,
    },
    /// §3.7 Limits of motion.
    Limits(Limits),
    /// §3.20 Crash data.
    Fault(FaultInfo),
    /// Bus (observed): the addresses present.
    Network(NetworkStatus),
    /// Bus (observed): lines of the log.
    Log(Log<'a>),
    /// Data of a request or subsystem that the document does not know.
    Raw(&'a [u8]),
}

impl<'a> Answer<'a> {
    /// An answer without data.
    pub const fn bare(from: SubsystemId, request: RequestId, status: Status) -> Self {
        Self { from, request, status, data: Reply::None }
    }

    /// Reads the answer of a record.
    ///
    /// # Errors
    ///
    /// [`DecodeError`] with `Expected::Size` when the data have a size that an answer of this
    /// subsystem to this request cannot have. Data of unknown requests and subsystems are never
    /// wrong: [`Reply::Raw`].
    // Inlined: a caller that uses one kind of data then links no code of the others.
    #[inline(always)]
    pub fn decode(record: &Record<'a>) -> Result<Self, DecodeError> {
        let Record { request, device, status, data } = *record;
        Ok(Self { from: device, request, status, data: Reply::decode(request, device, data)? })
    }

    /// Appends the answer to a frame's payload.
    ///
    /// # Errors
    ///
    /// [`NoRoom`], and nothing is written, when the data take more than 255 bytes or the record
    /// does not fit what is left of the payload.
    // Inlined: a caller that uses one kind of data then links no code of the others.
    #[inline(always)]
    pub fn encode(&self, out: &mut Writer<'_>) -> Result<(), NoRoom> {
        let Self { from, request, status, data } = self;
        let mut put = |data: &[u8]| out.push_bytes(*request, *from, *status, data);
        match data {
            Reply::None => put(&[]),
            Reply::General(status) => put(&status.to_bytes()),
            Reply::Thermo(status) => put(&status.to_bytes()),
            Reply::Drive(status) => put(&status.to_bytes()),
            Reply::Valve(status) => put(&status.to_bytes()),
            Reply::Control(status) => put(&status.to_bytes()),
            Reply::Detector(status) => put(&status.to_bytes()),
            Reply::Deployer(status) => put(&status.to_bytes()),
            Reply::Conn(status) => put(&status.to_bytes()),
            Reply::Buttons(status) => put(&status.to_bytes()),
            _ => self.encode_other(out),
        }
    }

    /// Kinds of data that are rare, in one function that is not inlined.
    fn encode_other(&self, out: &mut Writer<'_>) -> Result<(), NoRoom> {
        out.push_with(self.request, self.from, self.status, |data| match self.data {
            Reply::Param { id, values } => {
                data.put_u16(id.0)?;
                data.put_ints(values.iter())
            }
            Reply::Limits(limits) => data.put(&limits.to_bytes()),
            Reply::Fault(info) => {
                let words = info.to_words();
                let count = match info.arch {
                    crate::status::FaultArch::CortexM3(_) => 20,
                    crate::status::FaultArch::Arm7Tdmi(_) => 12,
                };
                words.iter().take(count).try_for_each(|word| data.put(&word.to_le_bytes()))
            }
            Reply::Network(status) => data.put(&status.0),
            Reply::Log(log) => {
                data.put_u16(log.first)?;
                data.put_u16(log.count)?;
                data.put(log.lines)
            }
            Reply::Raw(bytes) => data.put(bytes),
            // Encoded by the caller.
            _ => Ok(()),
        })
    }

    /// The hotbeds of an answer to GetHotbed or GetParam Hotbeds (§3.21).
    pub fn hotbeds(&self) -> Option<impl Iterator<Item = Hotbed> + use<'a>> {
        let Reply::Param { id: ParamId::HOTBEDS, values } = self.data else { return None };
        Some(Hotbed::of_values(values))
    }
}

impl<'a> Reply<'a> {
    /// The status word of an answer to GetStatus (§3.3); `None` for other data.
    pub const fn flags_bits(&self) -> Option<u32> {
        Some(match self {
            Self::General(status) => status.flags.bits(),
            Self::Thermo(status) => status.flags.bits(),
            Self::Drive(status) => status.flags.bits(),
            Self::Valve(status) => status.flags.bits(),
            Self::Control(status) => status.flags.bits(),
            Self::Detector(status) => status.flags.bits(),
            Self::Deployer(status) => status.flags.bits(),
            Self::Conn(status) => status.flags.bits(),
            Self::Buttons(status) => status.flags.bits(),
            _ => return None,
        })
    }

    #[inline(always)]
    fn decode(
        request: RequestId,
        device: SubsystemId,
        data: &'a [u8],
    ) -> Result<Self, DecodeError> {
        match request {
            _ if data.is_empty() => Ok(Self::None),
            RequestId::GET_STATUS => Self::decode_status(device, data),
            _ => Self::decode_other(request, data),
        }
    }

    /// Kinds of data that are rare, in one function that is not inlined.
    fn decode_other(request: RequestId, data: &'a [u8]) -> Result<Self, DecodeError> {
        match request {
            RequestId::GET_PARAM | RequestId::SET_PARAM => Self::decode_param(data),
            RequestId::GET_HOTBED => Self::decode_param(data),
            RequestId::RETRIEVE_LIMITS => Ok(Self::Limits(Limits::from_bytes(exact(data)?))),
            RequestId::GET_CRASH_DATA => {
                FaultInfo::decode(data).map(Self::Fault).ok_or(wrong_size(data))
            }
            RequestId::GET_NETWORK_STATUS => Ok(Self::Network(NetworkStatus(exact(data)?))),
            RequestId::GET_LOG => Ok(Self::Log(Log::decode(data)?)),
            _ => Ok(Self::Raw(data)),
        }
    }

    #[inline(always)]
    fn decode_status(device: SubsystemId, data: &'a [u8]) -> Result<Self, DecodeError> {
        Ok(match device {
            SubsystemId::VERTICAL | SubsystemId::HORIZONTAL | SubsystemId::NOZZLE => {
                Self::Drive(DriveStatus::from_bytes(exact(data)?))
            }
            SubsystemId::GENERAL => Self::General(GeneralStatus::from_bytes(exact(data)?)),
            SubsystemId::CLIMATICS => Self::Thermo(ThermoStatus::from_bytes(exact(data)?)),
            SubsystemId::VALVE1 | SubsystemId::VALVE2 => {
                Self::Valve(ValveStatus::from_bytes(exact(data)?))
            }
            SubsystemId::CONTROL => Self::Control(ControlStatus::from_bytes(exact(data)?)),
            SubsystemId::DETECTOR => Self::Detector(DetectorStatus::from_bytes(exact(data)?)),
            SubsystemId::DEPLOYER => Self::Deployer(DeployerStatus::from_bytes(exact(data)?)),
            SubsystemId::EXTERNAL_CONN | SubsystemId::RADIO => {
                Self::Conn(ConnStatus::from_bytes(exact(data)?))
            }
            SubsystemId::BUTTONS | SubsystemId::EXT_BUTTONS => {
                Self::Buttons(ButtonsStatus::from_bytes(exact(data)?))
            }
            _ => Self::Raw(data),
        })
    }

    fn decode_param(data: &'a [u8]) -> Result<Self, DecodeError> {
        let (id, values) = data.split_first_chunk().ok_or(wrong_size(data))?;
        if values.len() % 4 != 0 {
            return Err(wrong_size(data));
        }
        Ok(Self::Param { id: ParamId(u16::from_le_bytes(*id)), values: Ints::Wire(values) })
    }
}

#[inline]
fn exact<const N: usize>(data: &[u8]) -> Result<[u8; N], DecodeError> {
    data.try_into().map_err(|_| wrong_size(data))
}

const fn wrong_size(data: &[u8]) -> DecodeError {
    DecodeError { offset: 0, expected: Expected::Size, got: data.len() }
}
