//! §3.11 Wrap: brings the monitor to the standby position. No data.

use super::{Body, none};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::{DecodeError, RequestId, SubsystemId};

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::WRAP,
    name: "Wrap",
    section: "3.11",
    origin: Origin::Read,
    addressees: &[SubsystemId::DEPLOYER],
    title: key!("request-Wrap-title"),
    meaning: key!("request-Wrap-meaning"),
};

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    none(data, Body::Wrap)
}
