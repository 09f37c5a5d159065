//! §3.1 Move: a drive goes to a position.

use super::{Body, exact};
use crate::dictionary::layouts::{Layout, fields};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::record::{Data, NoRoom};
use crate::text::fields::Tokens;
use crate::text::parse::{Parsed, word_i16};
use crate::{DecodeError, RequestId, SubsystemId};
use core::fmt;

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::MOVE,
    name: "Move",
    section: "3.1",
    origin: Origin::Read,
    addressees: &[
        SubsystemId::VERTICAL,
        SubsystemId::HORIZONTAL,
        SubsystemId::NOZZLE,
        SubsystemId::DEPLOYER,
    ],
    title: key!("request-Move-title"),
    meaning: key!("request-Move-meaning"),
};

/// Its data.
pub(crate) const LAYOUTS: &[Layout] =
    &[Layout::plain("Move", fields! { Move: destination I16 None; })];

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    Ok(Body::Move { destination: i16::from_le_bytes(exact(data)?) })
}

pub(super) fn encode(destination: i16, data: &mut Data<'_>) -> Result<(), NoRoom> {
    data.put_i16(destination)
}

pub(crate) fn parse(tokens: &mut Tokens<'_>) -> Parsed<Body<'static>> {
    Ok(Body::Move { destination: word_i16(tokens, "destination")? })
}

pub(crate) fn write(f: &mut fmt::Formatter<'_>, destination: i16) -> fmt::Result {
    write!(f, " {destination}")
}
