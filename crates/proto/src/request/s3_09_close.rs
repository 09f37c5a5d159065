//! §3.9 Close: closes a valve.

use super::{Body, exact};
use crate::dictionary::layouts::{KEY, Layout};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::id::key;
use crate::record::{Data, NoRoom};
use crate::text::fields::Tokens;
use crate::text::parse::{self, Parsed};
use crate::text::request::write_key;
use crate::{DecodeError, RequestId, SubsystemId};
use core::fmt;

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::CLOSE,
    name: "Close",
    section: "3.9",
    origin: Origin::Read,
    addressees: &[SubsystemId::VALVE1, SubsystemId::VALVE2],
    title: key!("request-Close-title"),
    meaning: key!("request-Close-meaning"),
};

/// Its data.
pub(crate) const LAYOUTS: &[Layout] = &[KEY];

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    Ok(Body::Close { key: u16::from_le_bytes(exact(data)?) })
}

pub(super) fn encode(key: u16, data: &mut Data<'_>) -> Result<(), NoRoom> {
    data.put_u16(key)
}

pub(crate) fn parse(tokens: &mut Tokens<'_>) -> Parsed<Body<'static>> {
    Ok(Body::Close { key: parse::key(tokens, key::CLOSE)? })
}

pub(crate) fn write(f: &mut fmt::Formatter<'_>, key: u16) -> fmt::Result {
    write_key(f, key, key::CLOSE)
}
