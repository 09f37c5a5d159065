//! §3.10 Deploy: brings the monitor to the working position. No data.

use super::{Body, none};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::{DecodeError, RequestId, SubsystemId};

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::DEPLOY,
    name: "Deploy",
    section: "3.10",
    origin: Origin::Read,
    addressees: &[SubsystemId::DEPLOYER],
    title: key!("request-Deploy-title"),
    meaning: key!("request-Deploy-meaning"),
};

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    none(data, Body::Deploy)
}
