//! §3.17 SwitchLimits: the limits off, on, or their change rejected.

use super::{Body, exact};
use crate::dictionary::layouts::{Layout, fields};
use crate::dictionary::{Origin, RequestInfo, key};
use crate::record::{Data, NoRoom};
use crate::text::fields::Tokens;
use crate::text::parse::{Parsed, switch};
use crate::{DecodeError, RequestId, SubsystemId};
use core::fmt;

/// Its entry in the dictionary.
pub(crate) const INFO: RequestInfo = RequestInfo {
    id: RequestId::SWITCH_LIMITS,
    name: "SwitchLimits",
    section: "3.17",
    origin: Origin::Read,
    addressees: &[
        SubsystemId::ALL,
        SubsystemId::MOTORS,
        SubsystemId::VERTICAL,
        SubsystemId::HORIZONTAL,
        SubsystemId::NOZZLE,
        SubsystemId::DEPLOYER,
    ],
    title: key!("request-SwitchLimits-title"),
    meaning: key!("request-SwitchLimits-meaning"),
};

/// Its data.
pub(crate) const LAYOUTS: &[Layout] =
    &[Layout::plain("SwitchLimits", fields! { SwitchLimits: new_state U16 Choice; })];

/// §3.17 The states that SwitchLimits can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitsState {
    /// 0: limits off.
    Off,
    /// 1: limits on; new ones set meanwhile take effect.
    On,
    /// 2: limits on; new ones set meanwhile are dropped.
    Reject,
}

impl LimitsState {
    /// The state for a value of the request's data.
    pub const fn from_wire(new_state: u16) -> Option<Self> {
        match new_state {
            0 => Some(Self::Off),
            1 => Some(Self::On),
            2 => Some(Self::Reject),
            _ => None,
        }
    }
}

#[inline(always)]
pub(super) fn decode(data: &[u8]) -> Result<Body<'_>, DecodeError> {
    Ok(Body::SwitchLimits { new_state: u16::from_le_bytes(exact(data)?) })
}

pub(super) fn encode(new_state: u16, data: &mut Data<'_>) -> Result<(), NoRoom> {
    data.put_u16(new_state)
}

pub(crate) fn parse(tokens: &mut Tokens<'_>) -> Parsed<Body<'static>> {
    let new_state = switch(tokens, &["off", "on", "reject", "state="], &[0, 1, 2])?;
    Ok(Body::SwitchLimits { new_state })
}

pub(crate) fn write(f: &mut fmt::Formatter<'_>, new_state: u16) -> fmt::Result {
    match LimitsState::from_wire(new_state) {
        Some(LimitsState::Off) => f.write_str(" off"),
        Some(LimitsState::On) => f.write_str(" on"),
        Some(LimitsState::Reject) => f.write_str(" reject"),
        None => write!(f, " state={new_state}"),
    }
}
