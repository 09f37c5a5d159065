//! §3.13 StartJustify: measures the angle between barrel and detector. No data.

use super::{Body, none};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::{DecodeError, RequestId, SubsystemId};

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::START_JUSTIFY,
    name: "StartJustify",
    section: "3.13",
    origin: Origin::Read,
    addressees: &[SubsystemId::DETECTOR],
    title: key!("request-StartJustify-title"),
    meaning: key!("request-StartJustify-meaning"),
};

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    none(data, Body::StartJustify)
}
