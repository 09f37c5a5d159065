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

use lafet_texts::{Text as _, hub as text};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::text::Both;
pub(crate) use keys::digest;
pub use keys::secret;
pub use known::{Entry, SESSION_MS, STALE_MS};
pub use rules::{Need, need};
pub use throttle::{Bucket, Logins, Place};
pub use turns::{Turn, Turns};
pub use users::{Access, AccessError, SessionInfo, Token, User};

/// What a client may do; each role includes the permissions of the ones before it.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Looks on. Stop, Close and Lockout are open to every role.
    Observer,
    /// May command monitors.
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

    /// The name in the API and in files.
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

    /// The name for people.
    pub fn text(self) -> Both {
        match self {
            Self::Observer => text::RoleObserver.words(),
            Self::Operator => text::RoleOperator.words(),
            Self::Engineer => text::RoleEngineer.words(),
            Self::Administrator => text::RoleAdministrator.words(),
        }
    }
}

/// How a client has identified itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Cookie of a browser.
    Session,
    /// Token of a program.
    Token,
    /// TLS client certificate.
    Certificate,
    /// Loopback connection to a hub without login.
    Demo,
    /// Master of a Modbus server, by its address.
    Modbus,
    /// Clients of an MQTT broker.
    Mqtt,
    /// Client of an OPC UA server.
    Opcua,
}

impl Kind {
    /// The name in the API and in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Session => "session",
            Self::Token => "token",
            Self::Certificate => "certificate",
            Self::Demo => "demo",
            Self::Modbus => "modbus",
            Self::Mqtt => "mqtt",
            Self::Opcua => "opcua",
        }
    }

    /// The kind of a name.
    pub fn by_name(name: &str) -> Option<Self> {
        let named = [Self::Session, Self::Token, Self::Certificate];
        let others = [Self::Demo, Self::Modbus, Self::Mqtt, Self::Opcua];
        named.into_iter().chain(others).find(|it| it.name() == name)
    }
}

/// A client whose identity is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Principal {
    /// Name of the user or token.
    pub user: String,
    /// What the client is allowed to do.
    pub role: Role,
    /// How the client has identified itself.
    pub kind: Kind,
    /// The session, or the token: what commands without a WebSocket belong to.
    pub key: String,
    /// What a browser has to send along.
    pub csrf: String,
    /// When the session ends, or what is left of it, by the steady time, ms; of a certificate, by the date, ms since
    /// 1970; 0: never.
    pub expires_ms: u64,
    /// Whether the session is valid.
    pub standing: Standing,
}

/// Whether a session still holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Standing {
    /// Valid.
    Good,
    /// It has run out, but not long ago: Stop, Close and Lockout still pass.
    Expired,
    /// It was ended by an administrator or by a new password, but not long ago: Stop still passes.
    Ended,
}

impl Principal {
    /// Whether the session is valid.
    pub fn is_good(&self) -> bool {
        self.standing == Standing::Good
    }

    /// What a connection has left that outlasts the certificate of its client: it is as good as a session that has run
    /// out. By the date.
    pub fn outlasted(&self, now_ms: u64) -> Option<Self> {
        let until_ms = self.expires_ms.saturating_add(STALE_MS);
        let outlasts = self.kind == Kind::Certificate && now_ms < until_ms;
        outlasts.then(|| Self { standing: Standing::Expired, expires_ms: until_ms, ..self.clone() })
    }
}
