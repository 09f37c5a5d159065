//! Users, sessions and tokens, in SQLite. Of secrets only digests are kept, of passwords argon2id.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex};

use rusqlite::{Connection, OptionalExtension, params};
use serde::Serialize;
use utoipa::ToSchema;

use super::hasher::Hasher;
use super::keys::{digest, secret};
use super::known::{Entry, IDLE_MS, Known, Touch};
use super::names::problem;
use super::password::{PASSWORD_MAX, check};
use super::revoked::{Revocation, Revoked};
use super::stored::{
    count, insert, names, read, read_devices, read_roles, role_of, store_change, store_session,
    token, token_key, write_touches,
};
use super::{Kind, Principal, Role, Standing};
use crate::clock::shifted;
use crate::store::{Head, StoreError, Users};
use crate::sync::lock;
use crate::text::Both;

/// What a token begins with.
const TOKEN_PREFIX: &str = "lafet_";

const SCHEMA: &str = "
CREATE TABLE IF NOT EXISTS user (
  name TEXT PRIMARY KEY, role TEXT NOT NULL, password TEXT NOT NULL, created_ms INTEGER NOT NULL,
  last_login_ms INTEGER
) STRICT;
CREATE TABLE IF NOT EXISTS session (
  digest TEXT PRIMARY KEY, id TEXT NOT NULL, user TEXT NOT NULL REFERENCES user ON DELETE CASCADE,
  csrf TEXT NOT NULL, created_ms INTEGER NOT NULL, used_ms INTEGER NOT NULL
) STRICT;
CREATE TABLE IF NOT EXISTS token (
  id INTEGER PRIMARY KEY AUTOINCREMENT, name TEXT NOT NULL, role TEXT NOT NULL,
  digest TEXT NOT NULL UNIQUE, created_ms INTEGER NOT NULL, last_used_ms INTEGER
) STRICT;
CREATE TABLE IF NOT EXISTS setup (digest TEXT PRIMARY KEY) STRICT;
CREATE TABLE IF NOT EXISTS device (
  digest TEXT PRIMARY KEY, user TEXT NOT NULL REFERENCES user ON DELETE CASCADE,
  used_ms INTEGER NOT NULL
) STRICT;
CREATE TRIGGER IF NOT EXISTS user_added AFTER INSERT ON user
  BEGIN UPDATE site SET users = users + 1, set_up = 1; END;
CREATE TRIGGER IF NOT EXISTS user_changed AFTER UPDATE OF role, password ON user
  BEGIN UPDATE site SET users = users + 1; END;
CREATE TRIGGER IF NOT EXISTS user_removed AFTER DELETE ON user
  BEGIN UPDATE site SET users = users + 1; END;
CREATE TRIGGER IF NOT EXISTS token_added AFTER INSERT ON token
  BEGIN UPDATE site SET users = users + 1; END;
CREATE TRIGGER IF NOT EXISTS token_removed AFTER DELETE ON token
  BEGIN UPDATE site SET users = users + 1; END;";

/// The table of tokens of an earlier version gives the number of one that was removed to the next.
const RENUMBER: &str = "
BEGIN IMMEDIATE;
DROP TRIGGER IF EXISTS token_added;
DROP TRIGGER IF EXISTS token_removed;
ALTER TABLE token RENAME TO token_before;
CREATE TABLE token (
  id INTEGER PRIMARY KEY AUTOINCREMENT, name TEXT NOT NULL, role TEXT NOT NULL,
  digest TEXT NOT NULL UNIQUE, created_ms INTEGER NOT NULL, last_used_ms INTEGER
) STRICT;
INSERT INTO token (id, name, role, digest, created_ms, last_used_ms)
  SELECT id, name, role, digest, created_ms, last_used_ms FROM token_before;
DROP TABLE token_before;
CREATE TRIGGER token_added AFTER INSERT ON token
  BEGIN UPDATE site SET users = users + 1; END;
CREATE TRIGGER token_removed AFTER DELETE ON token
  BEGIN UPDATE site SET users = users + 1; END;
COMMIT;";

/// A user, as the API lists it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct User {
    /// Name, unique without regard to case.
    pub user: String,
    /// Role of the user.
    pub role: Role,
    /// When the user was added, ms since 1970.
    pub created_ms: u64,
    /// Last login, ms since 1970.
    #[schema(required)]
    pub last_login_ms: Option<u64>,
}

/// A token, without its secret.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Token {
    /// Number with which it is revoked.
    pub id: u64,
    /// Name given by the administrator, shown in logs.
    pub name: String,
    /// Role of the program that uses it.
    pub role: Role,
    /// When it was made, ms since 1970.
    pub created_ms: u64,
    /// When it was used last.
    #[schema(required)]
    pub last_used_ms: Option<u64>,
}

/// A new session.
#[derive(Clone, Debug)]
pub struct SessionInfo {
    /// Value of the cookie.
    pub secret: String,
    /// The user who has logged in.
    pub principal: Principal,
}

/// Why something is not done.
#[derive(Debug, thiserror::Error)]
pub enum AccessError {
    /// Wrong user or password, or link.
    #[error("wrong user or password")]
    Wrong,
    /// There is a user of this name, or the last administrator would go.
    #[error("there is one already, or it is the last one")]
    Conflict,
    /// No such user, session or token.
    #[error("there is none")]
    Missing,
    /// A name that is none, or can be taken for another one.
    #[error("{}", .0.en)]
    Name(Both),
    /// A password that is short or easily guessed.
    #[error("{}", .0.en)]
    Weak(Both),
    /// The session or token has ended meanwhile.
    #[error("the session has ended")]
    Ended,
    /// Too much is being done at once.
    #[error("too much is being done at once")]
    Busy,
    /// The database failed.
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl From<rusqlite::Error> for AccessError {
    fn from(error: rusqlite::Error) -> Self {
        Self::Store(error.into())
    }
}

/// Touches that wait for the disk; more are left out.
const TOUCHES_MAX: usize = 1024;
/// Devices of a user that are known; then the one that was used first is forgotten.
const DEVICES_MAX: i64 = 16;

/// Who is known to the hub. Times are those of the steady clock.
#[derive(Debug)]
pub struct Access {
    db: Arc<Mutex<Connection>>,
    known: Known,
    /// The users, with what is not stored yet: whose sessions end is known without the disk. Changed under the lock of
    /// the database.
    roles: Mutex<BTreeMap<String, Role>>,
    revoked: Arc<Mutex<Revoked>>,
    /// A revocation waits for the disk.
    waits: Arc<AtomicBool>,
    /// Users by the digest of what their devices were given.
    devices: Mutex<HashMap<String, String>>,
    /// How far the date is ahead of the steady time, ms.
    ahead_ms: AtomicI64,
    empty: AtomicBool,
    hasher: Hasher,
    touches: SyncSender<Touch>,
}

impl Access {
    /// Opens it in a folder, or in memory.
    pub fn open(folder: Option<&Path>, now_ms: u64) -> Result<Self, StoreError> {
        let db = crate::store::open(folder, "hub.db", SCHEMA)?;
        if let Err(error) = renumber(&db) {
            // With a full disk it is done at a later start.
            tracing::warn!(%error, "numbers of tokens that were removed are given again");
        }
        let mut revoked = Revoked::open(folder)?;
        if let Err(error) = revoked.flush(&db) {
            tracing::warn!(%error, "revocations are not stored yet");
        }
        let empty = AtomicBool::new(count(&db, "SELECT COUNT(*) FROM user")? == 0);
        let known = read(&db, now_ms, &revoked)?;
        let devices = Mutex::new(read_devices(&db)?);
        let roles = Mutex::new(read_roles(&db, &revoked)?);
        let waits = revoked.waits();
        let (db, revoked) = (Arc::new(Mutex::new(db)), Arc::new(Mutex::new(revoked)));
        let (touches, queue) = sync_channel(TOUCHES_MAX);
        let own = (db.clone(), revoked.clone());
        let named = std::thread::Builder::new().name("lafet-access".into());
        named.spawn(move || write_touches(&own.0, &own.1, &queue))?;
        let ahead_ms = AtomicI64::new(0);
        let hasher = Hasher::default();
        Ok(Self { db, known, roles, revoked, waits, devices, ahead_ms, empty, hasher, touches })
    }

    /// Why the list of revocations that this start found cannot be read, if it cannot.
    pub fn revocations_spoilt(&self) -> Option<String> {
        lock(&self.revoked).spoilt().map(str::to_owned)
    }

    /// What was revoked is not on the disk yet. Answered at once, whatever the disk does.
    pub fn revocations_wait(&self) -> bool {
        self.waits.load(Ordering::Relaxed)
    }

    /// How often users and tokens were changed.
    pub fn changes(&self) -> Result<Users, StoreError> {
        Ok(crate::store::users(&lock(&self.db))?)
    }

    /// The same, and the digest of users and tokens.
    pub fn people(&self) -> Result<(Users, String), StoreError> {
        let db = lock(&self.db);
        Ok((crate::store::users(&db)?, crate::store::people(&db)?))
    }

    /// Moves what is stored into `hub.db` itself. Blocks.
    pub fn checkpoint(&self) -> Result<(), StoreError> {
        Ok(crate::store::checkpoint(&lock(&self.db))?)
    }

    /// Notes the end of the audit log.
    pub fn note_audit(&self, head: &Head) -> Result<(), StoreError> {
        Ok(crate::store::note_audit(&lock(&self.db), head)?)
    }

    /// The date has stepped: what is stored of sessions goes with it, for a restart.
    pub fn stepped(&self, by_ms: i64) {
        self.ahead_ms.fetch_add(by_ms, Ordering::Relaxed);
        let step = "UPDATE session SET created_ms = created_ms + ?1, used_ms = used_ms + ?1";
        if let Err(error) = lock(&self.db).execute(step, [by_ms]) {
            tracing::warn!(%error, "after a restart sessions are as old as the clock says");
        }
    }

    /// A steady time as a date.
    pub fn date_ms(&self, steady_ms: u64) -> u64 {
        shifted(steady_ms, self.ahead_ms.load(Ordering::Relaxed))
    }

    /// There is no user yet.
    pub fn is_empty(&self) -> bool {
        self.empty.load(Ordering::Relaxed)
    }

    /// A one-time secret with which the first administrator is made; `None`: there are users. It
    /// takes the place of an earlier one.
    pub fn setup_link(&self) -> Result<Option<String>, AccessError> {
        if !self.is_empty() {
            return Ok(None);
        }
        let secret = random()?;
        let db = lock(&self.db);
        db.execute("DELETE FROM setup", [])?;
        db.execute("INSERT INTO setup VALUES (?1)", [digest(&secret)])?;
        Ok(Some(secret))
    }

    /// Whether this is the link with which the first administrator is made. Digests are compared: how long that takes
    /// says nothing of the link.
    pub fn is_setup_link(&self, link: &str) -> Result<bool, AccessError> {
        if !self.is_empty() {
            return Ok(false);
        }
        let find = "SELECT COUNT(*) FROM setup WHERE digest = ?1";
        let links: i64 = lock(&self.db).query_row(find, [digest(link)], |row| row.get(0))?;
        Ok(links != 0)
    }

    /// Makes the first administrator. Slow on purpose.
    pub fn set_up(
        &self,
        now_ms: u64,
        link: &str,
        user: &str,
        password: &str,
    ) -> Result<(), AccessError> {
        // Without the link no password is hashed.
        if !self.is_setup_link(link)? {
            return Err(AccessError::Wrong);
        }
        check_name(user, &[])?;
        check(user, password)?;
        let hash = self.hash(password)?;
        let mut db = lock(&self.db);
        let transaction = db.transaction()?;
        let known =
            transaction.execute("DELETE FROM setup WHERE digest = ?1", [digest(link)])? == 1;
        if !known || count(&transaction, "SELECT COUNT(*) FROM user")? != 0 {
            return Err(AccessError::Wrong);
        }
        insert(&transaction, now_ms, user, Role::Administrator, &hash)?;
        transaction.commit()?;
        lock(&self.roles).insert(user.to_owned(), Role::Administrator);
        self.empty.store(false, Ordering::Relaxed);
        Ok(())
    }

    /// Adds a user. Slow on purpose.
    pub fn add(
        &self,
        now_ms: u64,
        user: &str,
        role: Role,
        password: &str,
    ) -> Result<(), AccessError> {
        check(user, password)?;
        let hash = self.hash(password)?;
        let db = lock(&self.db);
        lock(&self.revoked).flush(&db)?;
        let taken = names(&db)?;
        check_name(user, &taken)?;
        if taken.iter().any(|it| it == user) {
            return Err(AccessError::Conflict);
        }
        insert(&db, now_ms, user, role, &hash)?;
        lock(&self.roles).insert(user.to_owned(), role);
        Ok(())
    }

    /// Changes role or password, and ends the user's sessions but one: at once, whatever the disk does, also one that
    /// does not answer. Slow on purpose.
    pub fn change(
        &self,
        now_ms: u64,
        user: &str,
        role: Option<Role>,
        password: Option<&str>,
        but: Option<&str>,
    ) -> Result<(), AccessError> {
        let hash = match password {
            Some(password) => {
                check(user, password)?;
                Some(self.hash(password)?)
            }
            None => None,
        };
        let goes = role.is_some_and(|role| role != Role::Administrator);
        let end = || {
            self.may_change(user, goes)?;
            self.known.end(now_ms, |it| it.user == user && Some(it.key.as_str()) != but);
            if hash.is_some() {
                lock(&self.devices).retain(|_, of| of != user);
            }
            Ok::<_, AccessError>(())
        };
        end()?;
        let mut db = lock(&self.db);
        // What waits is older than this.
        if let Err(error) = lock(&self.revoked).flush(&db) {
            tracing::warn!(%error, "revocations are not stored yet");
        }
        // While the disk was waited for, others may have been removed, and a login may have been under way.
        end()?;
        let stored = store_change(&mut db, user, role, hash.as_deref(), but);
        let (user_name, but) = (user.to_owned(), but.map(str::to_owned));
        let change = Revocation::Change { user: user_name, role, password: hash.clone(), but };
        self.settle(stored, change)?;
        if let Some(role) = role {
            lock(&self.roles).insert(user.to_owned(), role);
            self.known.set_role(user, role);
        }
        Ok(())
    }

    /// Removes a user, and ends the user's sessions: at once, whatever the disk does, also one that does not answer.
    pub fn remove(&self, now_ms: u64, user: &str) -> Result<(), AccessError> {
        let end = || {
            self.may_change(user, true)?;
            self.known.end(now_ms, |it| it.user == user);
            lock(&self.devices).retain(|_, of| of != user);
            Ok::<_, AccessError>(())
        };
        end()?;
        let db = lock(&self.db);
        // As in `change`.
        end()?;
        let stored = db.execute("DELETE FROM user WHERE name = ?1", [user]);
        self.settle(stored, Revocation::User { user: user.to_owned() })?;
        lock(&self.roles).remove(user);
        Ok(())
    }

    /// There has to be such a user, and, if that one goes or is an administrator no more, another administrator.
    fn may_change(&self, user: &str, goes: bool) -> Result<(), AccessError> {
        let roles = lock(&self.roles);
        if !roles.contains_key(user) {
            return Err(AccessError::Missing);
        }
        let is_other =
            |(name, role): (&String, &Role)| name != user && *role == Role::Administrator;
        match !goes || roles.iter().any(is_other) {
            true => Ok(()),
            false => Err(AccessError::Conflict),
        }
    }

    /// What the disk has not taken of a revocation waits for it.
    fn settle(
        &self,
        stored: Result<impl Sized, rusqlite::Error>,
        revocation: Revocation,
    ) -> Result<(), AccessError> {
        match stored {
            Ok(_) => Ok(()),
            Err(error) => {
                tracing::error!(%error, "a revocation is in effect, but not in hub.db yet");
                match lock(&self.revoked).note(revocation) {
                    true => Ok(()),
                    false => Err(error.into()),
                }
            }
        }
    }

    /// All users.
    pub fn users(&self) -> Result<Vec<User>, AccessError> {
        let db = lock(&self.db);
        let mut query =
            db.prepare("SELECT name, role, created_ms, last_login_ms FROM user ORDER BY name")?;
        let users = query.query_map([], |row| {
            Ok(User {
                user: row.get(0)?,
                role: role(&row.get::<_, String>(1)?),
                created_ms: unsigned(row.get(2)?),
                last_login_ms: row.get::<_, Option<i64>>(3)?.map(unsigned),
            })
        })?;
        let mut users: Vec<User> = users.collect::<Result<_, _>>()?;
        let revoked = lock(&self.revoked);
        users.retain(|it| !revoked.has_user(&it.user));
        for user in &mut users {
            user.role = revoked.role_of(&user.user).unwrap_or(user.role);
        }
        Ok(users)
    }

    /// Logs in: takes as long for a user that does not exist. Slow on purpose.
    pub fn log_in(
        &self,
        now_ms: u64,
        user: &str,
        password: &str,
    ) -> Result<SessionInfo, AccessError> {
        self.check_password(user, password)?;
        let secret = random()?;
        let (id, csrf) = (format!("h{}", &random()?[..12]), random()?);
        let db = lock(&self.db);
        let role = lock(&self.roles).get(user).copied().ok_or(AccessError::Wrong)?;
        let entry = Entry {
            key: id,
            user: user.to_owned(),
            role,
            csrf,
            created_ms: now_ms,
            used_ms: now_ms,
        };
        let digest = digest(&secret);
        // A full disk does not prevent a login: such a session lasts as long as the hub runs.
        if let Err(error) = store_session(&db, &digest, &entry, self.date_ms(now_ms)) {
            tracing::warn!(%error, user, "the session is not stored");
        }
        let principal = Principal {
            user: user.to_owned(),
            role,
            kind: Kind::Session,
            key: entry.key.clone(),
            csrf: entry.csrf.clone(),
            expires_ms: now_ms + IDLE_MS,
            standing: Standing::Good,
        };
        for ended in self.known.make_room(now_ms, user) {
            // A disk that takes nothing brings it back at the next start: the next login ends it again.
            if let Err(error) = db.execute("DELETE FROM session WHERE id = ?1", [ended]) {
                tracing::warn!(%error, user, "the end of a session is not stored");
            }
        }
        self.known.add_session(digest, entry);
        Ok(SessionInfo { secret, principal })
    }

    fn hash(&self, password: &str) -> Result<String, AccessError> {
        self.hasher.hash(password).ok_or(AccessError::Busy)
    }

    /// Checks a password. Slow on purpose.
    pub fn check_password(&self, user: &str, password: &str) -> Result<(), AccessError> {
        if password.len() > PASSWORD_MAX {
            return Err(AccessError::Wrong);
        }
        let find = "SELECT password FROM user WHERE name = ?1";
        let known: Option<String> =
            lock(&self.db).query_row(find, [user], |row| row.get(0)).optional()?;
        let known = {
            let revoked = lock(&self.revoked);
            let new = revoked.password_of(user).map(str::to_owned);
            known.filter(|_| !revoked.has_user(user)).map(|stored| new.unwrap_or(stored))
        };
        let right = match known {
            Some(hash) => self.hasher.verify(password, &hash),
            None => {
                self.hash(password)?;
                false
            }
        };
        if right { Ok(()) } else { Err(AccessError::Wrong) }
    }

    /// The role of a user, and the digest of what is stored of the password: another one after each change of it.
    pub fn standing(&self, user: &str) -> Option<(Role, String)> {
        let find = "SELECT password FROM user WHERE name = ?1";
        let stored: Option<String> =
            lock(&self.db).query_row(find, [user], |row| row.get(0)).optional().ok()?;
        let new = {
            let revoked = lock(&self.revoked);
            let new = revoked.password_of(user).map(str::to_owned);
            stored.filter(|_| !revoked.has_user(user)).map(|stored| new.unwrap_or(stored))
        }?;
        let role = lock(&self.roles).get(user).copied()?;
        Some((role, digest(&new)))
    }

    /// Whether a session or token was ended by others or by its user: it did not just run out.
    pub fn was_ended(&self, principal: &Principal) -> bool {
        self.known.was_ended(principal)
    }

    /// The user of a session cookie.
    pub fn by_session(&self, now_ms: u64, secret: &str) -> Option<Principal> {
        let (principal, touch) = self.known.by_session(now_ms, secret)?;
        self.touch(touch);
        Some(principal)
    }

    /// The owner of a token.
    pub fn by_token(&self, now_ms: u64, secret: &str) -> Option<Principal> {
        let (principal, touch) = self.known.by_token(now_ms, secret)?;
        self.touch(touch);
        Some(principal)
    }

    /// Whether a session or token that has a WebSocket open is still good; that counts as use.
    pub fn is_valid(&self, now_ms: u64, principal: &Principal) -> bool {
        let (valid, touch) = self.known.is_valid(now_ms, principal);
        self.touch(touch);
        valid
    }

    fn touch(&self, touch: Option<Touch>) {
        if let Some(mut touch) = touch {
            touch.used_ms = self.date_ms(touch.used_ms);
            // One that is left out is repeated in a minute.
            _ = self.touches.try_send(touch);
        }
    }

    /// Ends the session of a user who logs out.
    pub fn log_out(&self, id: &str) -> Result<(), AccessError> {
        self.known.log_out(id);
        let stored = lock(&self.db).execute("DELETE FROM session WHERE id = ?1", [id]);
        self.settle(stored, Revocation::Session { id: id.to_owned() })
    }

    /// Ends a session: at once, whether or not the disk takes it.
    pub fn end_session(&self, now_ms: u64, id: &str) -> Result<(), AccessError> {
        if !self.known.has_session(id) {
            return Err(AccessError::Missing);
        }
        self.known.end(now_ms, |it| it.key == id);
        let stored = lock(&self.db).execute("DELETE FROM session WHERE id = ?1", [id]);
        self.settle(stored, Revocation::Session { id: id.to_owned() })
    }

    /// Whether a user has logged in on this device before.
    pub fn is_device(&self, user: &str, secret: &str) -> bool {
        lock(&self.devices).get(&digest(secret)).is_some_and(|of| of == user)
    }

    /// Remembers a device on which a user has logged in; its secret is for its browser.
    pub fn add_device(&self, now_ms: u64, user: &str) -> Result<String, AccessError> {
        let secret = random()?;
        let digest = digest(&secret);
        let db = lock(&self.db);
        let used_ms = signed(self.date_ms(now_ms));
        let stored =
            db.execute("INSERT INTO device VALUES (?1, ?2, ?3)", params![digest, user, used_ms]);
        let trimmed = stored.and_then(|_| {
            let old = "DELETE FROM device WHERE user = ?1 AND digest NOT IN
                       (SELECT digest FROM device WHERE user = ?1 ORDER BY used_ms DESC LIMIT ?2)";
            db.execute(old, params![user, DEVICES_MAX])?;
            read_devices(&db)
        });
        match trimmed {
            Ok(devices) => *lock(&self.devices) = devices,
            // A disk that takes nothing: the device is asked to wait the next time.
            Err(error) => tracing::warn!(%error, user, "the device is not stored"),
        }
        Ok(secret)
    }

    /// The sessions that have not run out, the latest used first.
    pub fn sessions(&self, now_ms: u64) -> Vec<Entry> {
        self.known.sessions(now_ms)
    }

    /// Makes a token; its secret is returned this once.
    pub fn add_token(
        &self,
        now_ms: u64,
        name: &str,
        role: Role,
    ) -> Result<(u64, String), AccessError> {
        let secret = format!("{TOKEN_PREFIX}{}", random()?);
        let (db, digest) = (lock(&self.db), digest(&secret));
        lock(&self.revoked).flush(&db)?;
        check_name(name, &names(&db)?)?;
        // In the audit log it would pass for the user.
        if role_of(&db, name)?.is_some() {
            return Err(AccessError::Conflict);
        }
        db.execute(
            "INSERT INTO token (name, role, digest, created_ms) VALUES (?1, ?2, ?3, ?4)",
            params![name, role.name(), digest, signed(now_ms)],
        )?;
        let id = unsigned(db.last_insert_rowid());
        self.known.add_token(digest, token(id, name, role, now_ms, 0));
        Ok((id, secret))
    }

    /// All tokens.
    pub fn tokens(&self) -> Result<Vec<Token>, AccessError> {
        let db = lock(&self.db);
        let mut query =
            db.prepare("SELECT id, name, role, created_ms, last_used_ms FROM token ORDER BY id")?;
        let tokens = query.query_map([], |row| {
            let id = unsigned(row.get(0)?);
            let stored = row.get::<_, Option<i64>>(4)?.map(unsigned);
            Ok(Token {
                id,
                name: row.get(1)?,
                role: role(&row.get::<_, String>(2)?),
                created_ms: unsigned(row.get(3)?),
                last_used_ms: self.known.token_used_ms(&token_key(id)).or(stored),
            })
        })?;
        let mut tokens: Vec<Token> = tokens.collect::<Result<_, _>>()?;
        let revoked = lock(&self.revoked);
        tokens.retain(|it| !revoked.has_token(it.id));
        Ok(tokens)
    }

    /// Takes a token back: at once, whatever the disk does.
    pub fn remove_token(&self, id: u64) -> Result<(), AccessError> {
        let key = token_key(id);
        if !self.known.has_token(&key) {
            return Err(AccessError::Missing);
        }
        self.known.remove_token(&key);
        let stored = lock(&self.db).execute("DELETE FROM token WHERE id = ?1", [signed(id)]);
        self.settle(stored, Revocation::Token { id })
    }
}

fn renumber(db: &Connection) -> Result<(), rusqlite::Error> {
    let find =
        "SELECT COUNT(*) FROM sqlite_master WHERE name = 'token' AND sql LIKE '%AUTOINCREMENT%'";
    if count(db, find)? > 0 {
        return Ok(());
    }
    db.execute_batch(RENUMBER).inspect_err(|_| _ = db.execute_batch("ROLLBACK"))
}

fn check_name(name: &str, taken: &[String]) -> Result<(), AccessError> {
    match problem(name, taken.iter().map(String::as_str)) {
        None => Ok(()),
        Some(what) => Err(AccessError::Name(what)),
    }
}

fn random() -> Result<String, AccessError> {
    secret().map_err(|error| StoreError::Io(std::io::Error::other(error.to_string())).into())
}

/// An unknown role has the least rights.
pub fn role(name: &str) -> Role {
    Role::by_name(name).unwrap_or(Role::Observer)
}

/// A number as SQLite stores it.
pub fn signed(number: u64) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}

/// A number that SQLite has stored.
pub fn unsigned(number: i64) -> u64 {
    u64::try_from(number).unwrap_or(0)
}

#[cfg(test)]
#[path = "users_tests.rs"]
mod tests;
