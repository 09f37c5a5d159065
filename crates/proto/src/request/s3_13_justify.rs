//! §3.13 StartJustify: measures the angle between barrel and detector. No data.

use super::{Body, none};
use crate::dictionary::{Origin, RequestInfo, Text};
use crate::{DecodeError, RequestId, SubsystemId};

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::START_JUSTIFY,
    name: "StartJustify",
    section: "3.13",
    origin: Origin::Read,
    addressees: &[SubsystemId::DETECTOR],
    title: Text::new("Align barrel and detector", "Юстировка ствола и датчика"),
    meaning: Text::new(
        "Measures the angle between the barrel and the detector.",
        "Измеряет угол между стволом и датчиком.",
    ),
};

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    none(data, Body::StartJustify)
}
