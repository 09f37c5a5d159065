//! Who is logged in, in memory, by the steady time: a Stop must not wait for a disk, and must
//! not be turned away because one is full.

use std::collections::HashMap;
use std::sync::Mutex;

use super::keys::digest;
use super::{Kind, Principal, Role, Standing};
use crate::sync::lock;

/// A session ends when it has not been used for this time.
pub const IDLE_MS: u64 = 12 * 3_600_000;
/// A session ends this long after it began.
pub const SESSION_MS: u64 = 7 * 24 * 3_600_000;
/// After its end it still serves for Stop, Close and Lockout.
pub const STALE_MS: u64 = 24 * 3_600_000;
/// One that was ended before still serves for Stop for this time: see [`Known::end`].
pub const ENDED_MS: u64 = 10 * 60_000;
/// Sessions that were ended and are remembered for that.
const ENDED_MAX: usize = 1000;
/// Sessions of a user: a client that logs in for each request and never out keeps no more, and ends none that is in
/// use.
pub const SESSIONS_MAX: usize = 64;
/// A session or token is noted as used this often.
const TOUCH_MS: u64 = 60_000;

/// A session or a token.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Its id, which is no secret.
    pub key: String,
    /// Name of the user or token.
    pub user: String,
    /// Role of the user or token.
    pub role: Role,
    /// What a browser has to send along; a token has none.
    pub csrf: String,
    /// When it was made, steady time, ms.
    pub created_ms: u64,
    /// When it was used last, to the minute.
    pub used_ms: u64,
}

/// Something was used, which is to be written down some time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Touch {
    /// A session or a token.
    pub kind: Kind,
    /// Key of the session or token.
    pub key: String,
    /// Time of use, steady time, ms.
    pub used_ms: u64,
}

/// Sessions or tokens.
#[derive(Debug, Default)]
struct Table {
    /// By the digest of their secret.
    entries: HashMap<String, Entry>,
    /// That digest, by their key.
    digests: HashMap<String, String>,
}

impl Table {
    fn add(&mut self, digest: String, entry: Entry) {
        self.digests.insert(entry.key.clone(), digest.clone());
        self.entries.insert(digest, entry);
    }

    fn has(&self, key: &str) -> bool {
        self.digests.contains_key(key)
    }

    fn of(&mut self, key: &str) -> Option<&mut Entry> {
        self.entries.get_mut(self.digests.get(key)?)
    }

    fn remove(&mut self, key: &str) -> Option<(String, Entry)> {
        let digest = self.digests.remove(key)?;
        let entry = self.entries.remove(&digest)?;
        Some((digest, entry))
    }

    /// The keys of those that are so.
    fn keys(&self, are: impl Fn(&Entry) -> bool) -> Vec<String> {
        self.entries.values().filter(|it| are(it)).map(|it| it.key.clone()).collect()
    }
}

/// Sessions and tokens.
#[derive(Debug, Default)]
pub struct Known {
    sessions: Mutex<Table>,
    tokens: Mutex<Table>,
    ended: Mutex<HashMap<String, (Entry, u64)>>,
}

impl Entry {
    /// When a session runs out.
    pub fn expires_ms(&self) -> u64 {
        (self.used_ms + IDLE_MS).min(self.created_ms + SESSION_MS)
    }

    fn principal(&self, kind: Kind, expires_ms: u64, standing: Standing) -> Principal {
        Principal {
            user: self.user.clone(),
            role: self.role,
            kind,
            key: self.key.clone(),
            csrf: self.csrf.clone(),
            expires_ms,
            standing,
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
        for key in sessions.keys(|it| it.created_ms < old) {
            sessions.remove(&key);
        }
        sessions.add(digest, entry);
    }

    /// Adds a token.
    pub fn add_token(&self, digest: String, entry: Entry) {
        lock(&self.tokens).add(digest, entry);
    }

    /// Ends sessions that their users have not ended themselves. The page of one of them is open
    /// somewhere, and its user watches a monitor: Stop goes on to work there for a
    /// while. Close and Lockout, which shut the water of a fire, do not.
    pub fn end(&self, now_ms: u64, ends: impl Fn(&Entry) -> bool) {
        let keys = lock(&self.sessions).keys(ends);
        self.end_these(now_ms, &keys);
    }

    fn end_these(&self, now_ms: u64, keys: &[String]) {
        let mut ended = lock(&self.ended);
        ended.retain(|_, (_, at_ms)| now_ms < *at_ms + ENDED_MS);
        let mut sessions = lock(&self.sessions);
        for (digest, entry) in keys.iter().filter_map(|key| sessions.remove(key)) {
            if ended.len() < ENDED_MAX && now_ms < entry.expires_ms() {
                ended.insert(digest, (entry, now_ms));
            }
        }
    }

    /// Makes room for a session of a user among [`SESSIONS_MAX`]. Ends others, and returns their keys: those first that
    /// rest, from the longest rest on, then those that were used for the shortest time.
    pub fn make_room(&self, now_ms: u64, user: &str) -> Vec<String> {
        let rank = |it: &Entry| match now_ms.saturating_sub(it.used_ms) > 2 * TOUCH_MS {
            true => (0, it.used_ms, it.created_ms),
            // The date may have been set back in between.
            false => (1, it.used_ms.saturating_sub(it.created_ms), it.created_ms),
        };
        let mut its: Vec<_> = {
            let sessions = lock(&self.sessions);
            let its = sessions.entries.values().filter(|it| it.user == user);
            its.map(|it| (rank(it), it.key.clone())).collect()
        };
        its.sort_unstable();
        its.truncate((its.len() + 1).saturating_sub(SESSIONS_MAX));
        let keys: Vec<String> = its.into_iter().map(|(_, key)| key).collect();
        self.end_these(now_ms, &keys);
        keys
    }

    /// Ends the session of a user who logs out.
    pub fn log_out(&self, key: &str) {
        lock(&self.sessions).remove(key);
    }

    /// Whether there is such a session.
    pub fn has_session(&self, key: &str) -> bool {
        lock(&self.sessions).has(key)
    }

    /// Whether there is such a token.
    pub fn has_token(&self, key: &str) -> bool {
        lock(&self.tokens).has(key)
    }

    /// Gives the sessions of a user another role.
    pub fn set_role(&self, user: &str, role: Role) {
        for entry in lock(&self.sessions).entries.values_mut().filter(|it| it.user == user) {
            entry.role = role;
        }
    }

    /// Forgets a token.
    pub fn remove_token(&self, key: &str) {
        lock(&self.tokens).remove(key);
    }

    /// Sessions that have not run out, the latest used first.
    pub fn sessions(&self, now_ms: u64) -> Vec<Entry> {
        let mut all: Vec<Entry> = lock(&self.sessions).entries.values().cloned().collect();
        all.retain(|it| it.expires_ms() > now_ms);
        all.sort_by(|a, b| b.used_ms.cmp(&a.used_ms).then_with(|| a.key.cmp(&b.key)));
        all
    }

    /// When a token was used last.
    pub fn token_used_ms(&self, key: &str) -> Option<u64> {
        let used_ms = lock(&self.tokens).of(key)?.used_ms;
        (used_ms != 0).then_some(used_ms)
    }

    /// The user of a session cookie, and what to store of this use.
    pub fn by_session(&self, now_ms: u64, secret: &str) -> Option<(Principal, Option<Touch>)> {
        let digest = digest(secret);
        if let Some((entry, at_ms)) = lock(&self.ended).get(&digest) {
            let until_ms = at_ms + ENDED_MS;
            let principal = entry.principal(Kind::Session, until_ms, Standing::Ended);
            return (now_ms < until_ms).then_some((principal, None));
        }
        let mut sessions = lock(&self.sessions);
        let entry = sessions.entries.get_mut(&digest)?;
        let end_ms = entry.expires_ms();
        if now_ms >= end_ms + STALE_MS {
            return None;
        }
        if now_ms >= end_ms {
            let until_ms = end_ms + STALE_MS;
            return Some((entry.principal(Kind::Session, until_ms, Standing::Expired), None));
        }
        let touch = entry.touch(Kind::Session, now_ms);
        Some((entry.principal(Kind::Session, entry.expires_ms(), Standing::Good), touch))
    }

    /// The owner of a token, and what to store of this use.
    pub fn by_token(&self, now_ms: u64, secret: &str) -> Option<(Principal, Option<Touch>)> {
        let mut tokens = lock(&self.tokens);
        let entry = tokens.entries.get_mut(&digest(secret))?;
        let touch = entry.touch(Kind::Token, now_ms);
        Some((entry.principal(Kind::Token, 0, Standing::Good), touch))
    }

    /// Whether a session or token is there no more: it did not just run out.
    pub fn was_ended(&self, principal: &Principal) -> bool {
        match principal.kind {
            Kind::Session => !self.has_session(&principal.key),
            Kind::Token => !self.has_token(&principal.key),
            Kind::Certificate | Kind::Demo | Kind::Modbus | Kind::Mqtt | Kind::Opcua => false,
        }
    }

    /// Whether a session or token is still valid: neither ended nor expired. The question counts
    /// as use. Of a certificate the time is the date.
    pub fn is_valid(&self, now_ms: u64, principal: &Principal) -> (bool, Option<Touch>) {
        let of = match principal.kind {
            Kind::Session => &self.sessions,
            Kind::Token => &self.tokens,
            Kind::Certificate => return (now_ms < principal.expires_ms, None),
            Kind::Demo | Kind::Modbus | Kind::Mqtt | Kind::Opcua => return (true, None),
        };
        let mut entries = lock(of);
        let Some(entry) = entries.of(&principal.key) else {
            return (false, None);
        };
        if principal.kind == Kind::Session && now_ms >= entry.expires_ms() {
            return (false, None);
        }
        (true, entry.touch(principal.kind, now_ms))
    }
}
