//! Who may do what: roles, the rules for requests, users, sessions, tokens.

mod hasher;
mod keys;
mod known;
mod names;
mod password;
mod revoked;
mod rules;
mod stored;
mod throttle;
mod turns;
mod users;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::text::{Both, both};
pub use keys::secret;
pub use known::Entry;
pub use rules::{Need, need};
pub use throttle::{Bucket, Logins, Place};
pub use turns::{Turn, Turns};
pub use users::{Access, AccessError, SessionInfo, Token, User};

/// What somebody may do; each role may what the ones before it may.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Looks on. Stop, Close and Lockout are everybody's.
    Observer,
    /// Fights fires.
    Operator,
    /// Sets monitors up, and may take authority over by force.
    Engineer,
    /// Keeps users and tokens, and may erase a monitor's memory.
    Administrator,
}

impl Role {
    /// Every role, the least first.
    pub const ALL: [Self; 4] =
        [Self::Observer, Self::Operator, Self::Engineer, Self::Administrator];

    /// As it is written.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Observer => "observer",
            Self::Operator => "operator",
            Self::Engineer => "engineer",
            Self::Administrator => "administrator",
        }
    }

    /// The role of a name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.name() == name)
    }

    /// What people call it.
    pub fn text(self) -> Both {
        match self {
            Self::Observer => both("observer", "наблюдатель"),
            Self::Operator => both("operator", "оператор"),
            Self::Engineer => both("engineer", "инженер"),
            Self::Administrator => both("administrator", "администратор"),
        }
    }
}

/// How somebody came in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A browser's cookie.
    Session,
    /// A program's token.
    Token,
    /// A client's certificate.
    Certificate,
    /// Loopback without login.
    Demo,
}

impl Kind {
    /// As it is written.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Session => "session",
            Self::Token => "token",
            Self::Certificate => "certificate",
            Self::Demo => "demo",
        }
    }

    /// The kind of a name.
    pub fn by_name(name: &str) -> Option<Self> {
        let all = [Self::Session, Self::Token, Self::Certificate, Self::Demo];
        all.into_iter().find(|it| it.name() == name)
    }
}

/// Somebody who asks for something.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Principal {
    /// The name.
    pub user: String,
    /// What they may.
    pub role: Role,
    /// How they came in.
    pub kind: Kind,
    /// The session, or the token: what commands without a WebSocket belong to.
    pub key: String,
    /// What a browser has to send along.
    pub csrf: String,
    /// When the session ends, or what is left of it, by the steady time, ms; 0: never.
    pub expires_ms: u64,
    /// Whether it still holds.
    pub standing: Standing,
}

/// Whether a session still holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Standing {
    /// It does.
    Good,
    /// It has run out, but not long ago: Stop, Close and Lockout still pass.
    Expired,
    /// It was ended by an administrator or by a new password, but not long ago: Stop still passes.
    Ended,
}

impl Principal {
    /// The session holds.
    pub fn is_good(&self) -> bool {
        self.standing == Standing::Good
    }
}
