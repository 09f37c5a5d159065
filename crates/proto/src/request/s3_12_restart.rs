//! §3.12 Restart: ends all operations and starts the program again. No data.

use super::{Body, none};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::{DecodeError, RequestId, SubsystemId};

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::RESTART,
    name: "Restart",
    section: "3.12",
    origin: Origin::Read,
    addressees: &[SubsystemId::ALL],
    title: key!("request-Restart-title"),
    meaning: key!("request-Restart-meaning"),
};

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    none(data, Body::Restart)
}
