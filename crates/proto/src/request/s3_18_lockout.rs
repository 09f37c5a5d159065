//! §3.18 Lockout: stops everything and closes the valves until it is released.

use super::{Body, exact};
use crate::dictionary::layouts::{KEY, Layout};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::id::key;
use crate::record::{Data, NoRoom};
use crate::text::fields::Tokens;
use crate::text::parse::{Parsed, switch};
use crate::{DecodeError, RequestId, SubsystemId};
use core::fmt;

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::LOCKOUT,
    name: "Lockout",
    section: "3.18",
    origin: Origin::Read,
    addressees: &[SubsystemId::ALL],
    title: key!("request-Lockout-title"),
    meaning: key!("request-Lockout-meaning"),
};

/// Its data.
pub(crate) const LAYOUTS: &[Layout] = &[KEY];

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    Ok(Body::Lockout { key: u16::from_le_bytes(exact(data)?) })
}

pub(super) fn encode(key: u16, data: &mut Data<'_>) -> Result<(), NoRoom> {
    data.put_u16(key)
}

pub(crate) fn parse(tokens: &mut Tokens<'_>) -> Parsed<Body<'static>> {
    let key = switch(tokens, &["on", "off", "key="], &[key::ENABLE, key::DISABLE])?;
    Ok(Body::Lockout { key })
}

pub(crate) fn write(f: &mut fmt::Formatter<'_>, key: u16) -> fmt::Result {
    match key {
        key::ENABLE => f.write_str(" on"),
        key::DISABLE => f.write_str(" off"),
        key => write!(f, " key={key:#06x}"),
    }
}
