//! What each request needs. Stop, Close and Lockout on are open to every role, always.

use lafet_proto::RequestId;
use lafet_proto::id::key;
use lafet_proto::request::Body;

use super::Role;

/// What a request needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// Least role that may send the request.
    pub role: Role,
    /// The monitor has to be held by who asks.
    pub authority: bool,
    /// Never refused, delayed or limited: Stop, Close, Lockout on.
    pub urgent: bool,
    /// The client repeats the monitor's id, so that it is not done by mistake.
    pub confirm: bool,
}

const READ: Need = Need { role: Role::Observer, authority: false, urgent: false, confirm: false };
const STOP: Need = Need { urgent: true, ..READ };
const OPERATE: Need = Need { role: Role::Operator, authority: true, ..READ };
const SET_UP: Need = Need { role: Role::Engineer, ..OPERATE };
const ERASE: Need = Need { role: Role::Administrator, confirm: true, ..OPERATE };

/// What a request needs; `None`: it is not the hub's to send.
pub fn need(request: RequestId, body: &Body<'_>) -> Option<Need> {
    Some(match request {
        request if request.is_read() => READ,
        RequestId::STOP | RequestId::CLOSE => STOP,
        RequestId::LOCKOUT if *body == (Body::Lockout { key: key::ENABLE }) => STOP,
        RequestId::LOCKOUT => Need { confirm: true, ..OPERATE },
        RequestId::MOVE
        | RequestId::OPEN
        | RequestId::DEPLOY
        | RequestId::WRAP
        | RequestId::START_SEEK
        | RequestId::START_QUENCH
        | RequestId::START_TRAJECTORY => OPERATE,
        RequestId::RESTART => Need { confirm: true, ..SET_UP },
        RequestId::CLEAN_FLASH => ERASE,
        // The bus controller's own (observed): who sends it speaks for the bus.
        RequestId::ACCESS_GRANTED => return None,
        // SetParam, SwitchLimits, StartJustify, SetupCorrectionTable, and unknown requests.
        _ => SET_UP,
    })
}
