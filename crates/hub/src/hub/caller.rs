//! The author of a request.

use std::net::IpAddr;

use crate::access::{Kind, Principal, Role, Standing};
use crate::control::authority::Seat;

/// The author of a request, and where it comes from.
#[derive(Clone, Debug)]
pub struct Caller {
    /// User, role and session.
    pub principal: Principal,
    /// What holds authority and motions: a WebSocket, or over HTTP the session or token.
    pub seat: Seat,
    /// `ws`, `http`, `hub`, `zones`, `modbus`, `mqtt`, `opcua`, `tune` or `update`.
    pub via: &'static str,
}

impl Caller {
    /// The hub itself.
    pub fn hub() -> Self {
        let seat = Seat {
            user: "hub".into(),
            role: Role::Administrator,
            seat: "hub".into(),
            from: String::new(),
            live: true,
        };
        let principal = Principal {
            user: "hub".into(),
            role: Role::Administrator,
            kind: Kind::Demo,
            key: "hub".into(),
            csrf: String::new(),
            expires_ms: 0,
            standing: Standing::Good,
        };
        Self { principal, seat, via: "hub" }
    }

    /// An HTTP client: its session or token is the seat.
    pub fn http(principal: Principal, from: IpAddr) -> Self {
        let seat = Seat {
            user: principal.user.clone(),
            role: principal.role,
            seat: principal.key.clone(),
            from: from.to_string(),
            live: false,
        };
        Self { principal, seat, via: "http" }
    }

    /// A client of a plug, on a connection of its own.
    pub fn plug(principal: Principal, from: String, seat: String, via: &'static str) -> Self {
        let (user, role) = (principal.user.clone(), principal.role);
        let seat = Seat { user, role, seat, from, live: true };
        Self { principal, seat, via }
    }

    /// A WebSocket client.
    pub fn socket(principal: Principal, from: IpAddr, seat: String) -> Self {
        let (user, role, from) = (principal.user.clone(), principal.role, from.to_string());
        let seat = Seat { user, role, seat, from, live: true };
        Self { principal, seat, via: "ws" }
    }
}
