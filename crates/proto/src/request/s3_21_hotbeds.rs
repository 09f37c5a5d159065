//! §3.21 Hotbeds: GetHotbed, and the parameter of this name. No data.

use super::s3_04_getparam::PARAM_ID;
use super::{Body, none};
use crate::dictionary::layouts::Layout;
use crate::dictionary::{Origin, RequestInfo, key};
use crate::status::structure;
use crate::{DecodeError, Ints, ParamId, RequestId, SubsystemId};

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::GET_HOTBED,
    name: "GetHotbed",
    section: "3.21",
    origin: Origin::Read,
    addressees: &[SubsystemId::DETECTOR],
    title: key!("request-GetHotbed-title"),
    meaning: key!("request-GetHotbed-meaning"),
};

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    none(data, Body::GetHotbed)
}

/// The data of the answer.
pub(crate) const HOTBEDS: Layout = Layout {
    name: "Hotbeds",
    fields: PARAM_ID.fields,
    repeated: Hotbed::LAYOUT.fields,
    times: (0, Hotbed::MAX),
    prefix: &ParamId::HOTBEDS.0.to_le_bytes(),
};

structure! {
    /// A fire that the detector has found (§3.21), 20 bytes.
    #[derive(Default)]
    Hotbed {
        /// Left edge.
        x1 i32 Arcmin;
        /// Right edge.
        x2 i32 Arcmin;
        /// Lower edge.
        y1 i32 Arcmin;
        /// Upper edge.
        y2 i32 Arcmin;
        /// Brightness.
        brightness i32 None;
    }
}

impl Hotbed {
    /// Most hotbeds in one answer.
    pub const MAX: usize = 4;

    /// The hotbeds in the values of the parameter Hotbeds, five values each.
    pub fn of_values(values: Ints<'_>) -> impl Iterator<Item = Self> + use<'_> {
        let mut values = values.iter();
        core::iter::from_fn(move || {
            let mut next = || values.next();
            Some(Self::from_values([next()?, next()?, next()?, next()?, next()?]))
        })
    }

    /// The values of the parameter Hotbeds for this hotbed.
    pub const fn to_values(self) -> [i32; 5] {
        [self.x1, self.x2, self.y1, self.y2, self.brightness]
    }

    /// A hotbed from values of the parameter Hotbeds.
    pub const fn from_values([x1, x2, y1, y2, brightness]: [i32; 5]) -> Self {
        Self { x1, x2, y1, y2, brightness }
    }
}
