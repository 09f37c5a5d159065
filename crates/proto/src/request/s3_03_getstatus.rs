//! §3.3 GetStatus: the state of a subsystem. No data.

use super::{Body, none};
use crate::dictionary::layouts::{Field, Layout};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::param::Unit;
use crate::status::{
    ButtonsStatus, ConnStatus, ControlStatus, DeployerStatus, DetectorStatus, DriveStatus,
    GeneralStatus, ThermoStatus, ValveStatus,
};
use crate::{DecodeError, RequestId, SubsystemId};

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::GET_STATUS,
    name: "GetStatus",
    section: "3.3",
    origin: Origin::Read,
    addressees: &[],
    title: key!("request-GetStatus-title"),
    meaning: key!("request-GetStatus-meaning"),
};

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    none(data, Body::GetStatus)
}

/// The structure that a subsystem answers with.
pub(crate) const fn of_status(from: SubsystemId) -> &'static [Layout] {
    match from {
        SubsystemId::GENERAL => &[GeneralStatus::LAYOUT],
        SubsystemId::CLIMATICS => &[ThermoStatus::LAYOUT],
        SubsystemId::VERTICAL | SubsystemId::HORIZONTAL => &[DriveStatus::LAYOUT],
        SubsystemId::NOZZLE => &[NOZZLE_STATUS],
        SubsystemId::DEPLOYER => &[DeployerStatus::LAYOUT],
        SubsystemId::VALVE1 | SubsystemId::VALVE2 => &[ValveStatus::LAYOUT],
        SubsystemId::CONTROL => &[ControlStatus::LAYOUT],
        SubsystemId::DETECTOR => &[DetectorStatus::LAYOUT],
        SubsystemId::EXTERNAL_CONN | SubsystemId::RADIO => &[ConnStatus::LAYOUT],
        SubsystemId::BUTTONS | SubsystemId::EXT_BUTTONS => &[ButtonsStatus::LAYOUT],
        _ => &[],
    }
}

/// The fields of a drive in the units of the nozzle.
const NOZZLE: [Field; 4] = match DriveStatus::LAYOUT.fields {
    [flags, position, current, speed] => [
        *flags,
        Field { unit: Unit::Millimetre, ..*position },
        *current,
        Field { unit: Unit::MillimetrePerSecond, ..*speed },
    ],
    _ => panic!("the state of a drive has four fields"),
};
const NOZZLE_STATUS: Layout = Layout::plain("NozzleStatus", &NOZZLE);
