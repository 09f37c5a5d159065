//! §3.4 GetParam: reads a parameter; [`crate::param`] has the table of them.

use super::{Body, exact};
use crate::dictionary::layouts::{Layout, fields};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::record::{Data, NoRoom};
use crate::text::fields::Tokens;
use crate::text::parse::{Parsed, param};
use crate::text::request::write_values;
use crate::{DecodeError, Ints, ParamId, RequestId, SubsystemId};
use core::fmt;

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::GET_PARAM,
    name: "GetParam",
    section: "3.4",
    origin: Origin::Read,
    addressees: &[],
    title: key!("request-GetParam-title"),
    meaning: key!("request-GetParam-meaning"),
};

/// Its data.
pub(crate) const LAYOUTS: &[Layout] = &[PARAM_ID];

pub(crate) const PARAM_ID: Layout =
    Layout::plain("ParamId", fields! { GetParam: id ParamId None; });

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    Ok(Body::GetParam { id: ParamId(u16::from_le_bytes(exact(data)?)) })
}

pub(super) fn encode(id: ParamId, data: &mut Data<'_>) -> Result<(), NoRoom> {
    data.put_u16(id.0)
}

pub(crate) fn parse(tokens: &mut Tokens<'_>, to: SubsystemId) -> Parsed<Body<'static>> {
    Ok(Body::GetParam { id: param(tokens, to)? })
}

pub(crate) fn write(f: &mut fmt::Formatter<'_>, to: SubsystemId, id: ParamId) -> fmt::Result {
    write_values(f, to, id, Ints::Values(&[]))
}
