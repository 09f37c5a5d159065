//! Services of the bus controller (observed): AccessGranted, GetNetworkStatus, GetLog. Their answers
//! are in [`crate::bus`].

use super::{Body, exact};
use crate::dictionary::layouts::{Layout, fields};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::record::{Data, NoRoom};
use crate::text::error::Wanted;
use crate::text::fields::Tokens;
use crate::text::parse::{Parsed, U16};
use crate::{DecodeError, RequestId, SubsystemId};
use core::fmt;

/// AccessGranted in the dictionary.
pub(crate) const ACCESS_GRANTED: RequestInfo = RequestInfo {
    id: RequestId::ACCESS_GRANTED,
    name: "AccessGranted",
    section: "bus",
    origin: Origin::Observed,
    addressees: &[SubsystemId::GENERAL],
    title: key!("request-AccessGranted-title"),
    meaning: key!("request-AccessGranted-meaning"),
};

/// GetNetworkStatus in the dictionary.
pub(crate) const GET_NETWORK_STATUS: RequestInfo = RequestInfo {
    id: RequestId::GET_NETWORK_STATUS,
    name: "GetNetworkStatus",
    section: "bus",
    origin: Origin::Observed,
    addressees: &[SubsystemId::GENERAL],
    title: key!("request-GetNetworkStatus-title"),
    meaning: key!("request-GetNetworkStatus-meaning"),
};

/// GetLog in the dictionary.
pub(crate) const GET_LOG: RequestInfo = RequestInfo {
    id: RequestId::GET_LOG,
    name: "GetLog",
    section: "bus",
    origin: Origin::Observed,
    addressees: &[SubsystemId::GENERAL],
    title: key!("request-GetLog-title"),
    meaning: key!("request-GetLog-meaning"),
};

/// Data of GetLog.
pub(crate) const LOG_RANGE: Layout = Layout::plain(
    "LogRange",
    fields! { Bus:
        first U16 None;
        count U16 None;
    },
);
/// Data of the answer to GetNetworkStatus.
pub(crate) const NETWORK: Layout = Layout {
    name: "NetworkStatus",
    fields: &[],
    repeated: fields! { Bus: present U8 Bits; },
    times: (32, 32),
    prefix: &[],
};
/// Data of the answer to GetLog.
pub(crate) const LOG: Layout = Layout {
    name: "Log",
    fields: LOG_RANGE.fields,
    repeated: fields! { Bus: line U8 Bits; },
    times: (0, usize::MAX),
    prefix: &[],
};

#[inline(always)]
pub(super) fn decode_log(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    let [a, b, c, d] = exact(data)?;
    let (first, count) = (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
    Ok(Body::GetLog { first, count })
}

pub(super) fn encode_log(first: u16, count: u16, data: &mut Data<'_>) -> Result<(), NoRoom> {
    data.put_u16(first)?;
    data.put_u16(count)
}

pub(crate) fn parse_log(tokens: &mut Tokens<'_>) -> Parsed<Body<'static>> {
    let (mut first, mut count) = (None, None);
    while let Some(token) = tokens.next() {
        match token.pair() {
            Some(("first", value)) => token.set(&mut first, value.number("first", U16)?)?,
            Some(("count", value)) => token.set(&mut count, value.number("count", U16)?)?,
            _ => return Err(token.error(Wanted::Word(&["first=", "count="]))),
        }
    }
    let (Some((first, _)), Some((count, _))) = (first, count) else {
        return Err(tokens.missing(if first.is_none() { "first=" } else { "count=" }));
    };
    Ok(Body::GetLog { first, count })
}

pub(crate) fn write_log(f: &mut fmt::Formatter<'_>, first: u16, count: u16) -> fmt::Result {
    write!(f, " first={first} count={count}")
}
