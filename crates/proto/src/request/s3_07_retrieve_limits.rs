//! §3.7 RetrieveLimits: the limits of travel of a drive. No data.

use super::{Body, none};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::status::structure;
use crate::{DecodeError, RequestId, SubsystemId};

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::RETRIEVE_LIMITS,
    name: "RetrieveLimits",
    section: "3.7",
    origin: Origin::Read,
    addressees: &[
        SubsystemId::ALL,
        SubsystemId::MOTORS,
        SubsystemId::VERTICAL,
        SubsystemId::HORIZONTAL,
        SubsystemId::NOZZLE,
        SubsystemId::DEPLOYER,
    ],
    title: key!("request-RetrieveLimits-title"),
    meaning: key!("request-RetrieveLimits-meaning"),
};

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    none(data, Body::RetrieveLimits)
}

structure! {
    /// Limits of motion (§3.7), 8 bytes, in the unit of the drive: arc-minutes or mm.
    Limits {
        /// Lower, right or wider limit.
        min i32 None;
        /// Upper, left or narrower limit.
        max i32 None;
    }
}
