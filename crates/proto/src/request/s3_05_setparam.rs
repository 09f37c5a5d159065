//! §3.5 SetParam: sets a parameter; [`crate::param`] has the table of them.

use super::s3_04_getparam::PARAM_ID;
use super::{Body, wrong_size};
use crate::dictionary::layouts::{Layout, fields};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::record::{DATA_MAX, Data, NoRoom};
use crate::text::fields::{Buffer, Tokens};
use crate::text::parse::{Parsed, param};
use crate::text::request::write_values;
use crate::{DecodeError, Ints, ParamId, RequestId, SubsystemId};
use core::fmt;

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::SET_PARAM,
    name: "SetParam",
    section: "3.5",
    origin: Origin::Read,
    addressees: &[],
    title: key!("request-SetParam-title"),
    meaning: key!("request-SetParam-meaning"),
};

/// Its data.
pub(crate) const LAYOUTS: &[Layout] = &[PARAM];

/// A parameter and its values: the data of the request, and of the answers to GetParam and SetParam.
pub(crate) const PARAM: Layout = Layout {
    name: "Param",
    fields: PARAM_ID.fields,
    repeated: fields! { SetParam: value I32 None; },
    times: (0, usize::MAX),
    prefix: &[],
};

pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    let (id, values) = data.split_first_chunk().ok_or(wrong_size(data))?;
    if values.len() % 4 != 0 {
        return Err(wrong_size(data));
    }
    Ok(Body::SetParam { id: ParamId(u16::from_le_bytes(*id)), values: Ints::Wire(values) })
}

pub(super) fn encode(id: ParamId, values: Ints<'_>, data: &mut Data<'_>) -> Result<(), NoRoom> {
    data.put_u16(id.0)?;
    data.put_ints(values.iter())
}

pub(crate) fn parse<'b>(
    tokens: &mut Tokens<'_>,
    to: SubsystemId,
    buf: &'b mut [u8],
) -> Parsed<Body<'b>> {
    let id = param(tokens, to)?;
    let mut buffer = Buffer::new(buf, DATA_MAX - 2);
    while let Some(token) = tokens.next() {
        buffer.push(&token.int32("value")?.to_le_bytes(), token)?;
    }
    Ok(Body::SetParam { id, values: Ints::Wire(buffer.finish()) })
}

pub(crate) fn write(
    f: &mut fmt::Formatter<'_>,
    to: SubsystemId,
    id: ParamId,
    values: Ints<'_>,
) -> fmt::Result {
    write_values(f, to, id, values)
}
