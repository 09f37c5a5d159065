//! §3.2 Stop: a subsystem breaks off what it does. No data.

use super::{Body, none};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::{DecodeError, RequestId, SubsystemId};

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::STOP,
    name: "Stop",
    section: "3.2",
    origin: Origin::Read,
    addressees: &[
        SubsystemId::ALL,
        SubsystemId::VALVE1,
        SubsystemId::VALVE2,
        SubsystemId::VERTICAL,
        SubsystemId::HORIZONTAL,
        SubsystemId::NOZZLE,
        SubsystemId::DEPLOYER,
        SubsystemId::DETECTOR,
        SubsystemId::CONTROL,
    ],
    title: key!("request-Stop-title"),
    meaning: key!("request-Stop-meaning"),
};

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    none(data, Body::Stop)
}
