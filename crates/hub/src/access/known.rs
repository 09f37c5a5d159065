//! Who is logged in, in memory: whoever wants to stop something must not wait for a disk, and must
//! not be turned away because one is full.

use std::collections::HashMap;
use std::sync::Mutex;

use super::keys::digest;
use super::{Kind, Principal, Role};
use crate::sync::lock;

/// A session ends when it was not used for so long.
pub const IDLE_MS: u64 = 12 * 3_600_000;
/// And so long after it began.
pub const SESSION_MS: u64 = 7 * 24 * 3_600_000;
/// After its end it still serves for Stop, Close and Lockout.
pub const STALE_MS: u64 = 24 * 3_600_000;
/// A session or token is noted as used this often.
const TOUCH_MS: u64 = 60_000;

/// A session or a token.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Its id, which is no secret.
    pub key: String,
    /// Whose it is.
    pub user: String,
    /// What they may.
    pub role: Role,
    /// What a browser has to send along; a token has none.
    pub csrf: String,
    /// Since when.
    pub created_ms: u64,
    /// When it was used last, to the minute.
    pub used_ms: u64,
}

/// Something was used, which is to be written down some time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Touch {
    /// A session or a token.
    pub kind: Kind,
    /// Its id.
    pub key: String,
    /// When.
    pub used_ms: u64,
}

/// Sessions and tokens by the digest of their secret.
#[derive(Debug, Default)]
pub struct Known {
    sessions: Mutex<HashMap<String, Entry>>,
    tokens: Mutex<HashMap<String, Entry>>,
}

impl Entry {
    /// When a session runs out.
    pub fn expires_ms(&self) -> u64 {
        (self.used_ms + IDLE_MS).min(self.created_ms + SESSION_MS)
    }

    fn principal(&self, kind: Kind, expires_ms: u64, stale: bool) -> Principal {
        Principal {
            user: self.user.clone(),
            role: self.role,
            kind,
            key: self.key.clone(),
            csrf: self.csrf.clone(),
            expires_ms,
            stale,
        }
    }

    fn touch(&mut self, kind: Kind, now_ms: u64) -> Option<Touch> {
        (now_ms >= self.used_ms + TOUCH_MS).then(|| {
            self.used_ms = now_ms;
            Touch { kind, key: self.key.clone(), used_ms: now_ms }
        })
    }
}

impl Known {
    /// Adds a session.
    pub fn add_session(&self, digest: String, entry: Entry) {
        let mut sessions = lock(&self.sessions);
        let old = entry.created_ms.saturating_sub(SESSION_MS + STALE_MS);
        sessions.retain(|_, it| it.created_ms >= old);
        sessions.insert(digest, entry);
    }

    /// Adds a token.
    pub fn add_token(&self, digest: String, entry: Entry) {
        lock(&self.tokens).insert(digest, entry);
    }

    /// Keeps the sessions for which this is so.
    pub fn keep_sessions(&self, keep: impl Fn(&Entry) -> bool) {
        lock(&self.sessions).retain(|_, entry| keep(entry));
    }

    /// Gives the sessions of a user another role.
    pub fn set_role(&self, user: &str, role: Role) {
        for entry in lock(&self.sessions).values_mut().filter(|it| it.user == user) {
            entry.role = role;
        }
    }

    /// Forgets a token.
    pub fn remove_token(&self, key: &str) {
        lock(&self.tokens).retain(|_, entry| entry.key != key);
    }

    /// Sessions that have not run out, the latest used first.
    pub fn sessions(&self, now_ms: u64) -> Vec<Entry> {
        let mut all: Vec<Entry> = lock(&self.sessions).values().cloned().collect();
        all.retain(|it| it.expires_ms() > now_ms);
        all.sort_by(|a, b| b.used_ms.cmp(&a.used_ms).then_with(|| a.key.cmp(&b.key)));
        all
    }

    /// When a token was used last.
    pub fn token_used_ms(&self, key: &str) -> Option<u64> {
        let tokens = lock(&self.tokens);
        let used_ms = tokens.values().find(|it| it.key == key)?.used_ms;
        (used_ms != 0).then_some(used_ms)
    }

    /// Whose cookie this is.
    pub fn by_session(&self, now_ms: u64, secret: &str) -> Option<(Principal, Option<Touch>)> {
        let mut sessions = lock(&self.sessions);
        let entry = sessions.get_mut(&digest(secret))?;
        let end_ms = entry.expires_ms();
        if now_ms >= end_ms + STALE_MS {
            return None;
        }
        let stale = now_ms >= end_ms;
        let touch = if stale { None } else { entry.touch(Kind::Session, now_ms) };
        Some((entry.principal(Kind::Session, entry.expires_ms(), stale), touch))
    }

    /// Whose token this is.
    pub fn by_token(&self, now_ms: u64, secret: &str) -> Option<(Principal, Option<Touch>)> {
        let mut tokens = lock(&self.tokens);
        let entry = tokens.get_mut(&digest(secret))?;
        let touch = entry.touch(Kind::Token, now_ms);
        Some((entry.principal(Kind::Token, 0, false), touch))
    }

    /// Whether somebody who came in is still welcome: neither ended nor run out. Being here is
    /// use.
    pub fn is_valid(&self, now_ms: u64, principal: &Principal) -> (bool, Option<Touch>) {
        let of = match principal.kind {
            Kind::Session => &self.sessions,
            Kind::Token => &self.tokens,
            Kind::Certificate | Kind::Demo => return (true, None),
        };
        let mut entries = lock(of);
        let Some(entry) = entries.values_mut().find(|it| it.key == principal.key) else {
            return (false, None);
        };
        if principal.kind == Kind::Session && now_ms >= entry.expires_ms() {
            return (false, None);
        }
        (true, entry.touch(principal.kind, now_ms))
    }
}
