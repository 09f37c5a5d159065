//! Users, sessions and tokens, in SQLite. Of secrets only digests are kept, of passwords argon2id.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex};

use argon2::{Argon2, PasswordHasher, PasswordVerifier};
use rusqlite::{Connection, OptionalExtension, params};
use serde::Serialize;
use utoipa::ToSchema;

use super::keys::{digest, secret};
use super::known::{Entry, IDLE_MS, Known, Touch};
use super::stored::{read, store_session, token, token_key, write_touches};
use super::{Kind, Principal, Role};
use crate::store::StoreError;
use crate::sync::lock;

/// Shortest password, characters.
pub const PASSWORD_MIN: usize = 10;
/// Longest password, bytes: hashing more is work for nothing.
const PASSWORD_MAX: usize = 1024;
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
  id INTEGER PRIMARY KEY, name TEXT NOT NULL, role TEXT NOT NULL, digest TEXT NOT NULL UNIQUE,
  created_ms INTEGER NOT NULL, last_used_ms INTEGER
) STRICT;
CREATE TABLE IF NOT EXISTS setup (digest TEXT PRIMARY KEY) STRICT;";

/// A user.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct User {
    /// The name.
    pub user: String,
    /// What they may.
    pub role: Role,
    /// Since when.
    pub created_ms: u64,
    /// The last login.
    pub last_login_ms: Option<u64>,
}

/// A token, without its secret.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Token {
    /// Its number.
    pub id: u64,
    /// What it is for.
    pub name: String,
    /// What it may.
    pub role: Role,
    /// Since when.
    pub created_ms: u64,
    /// When it was used last.
    pub last_used_ms: Option<u64>,
}

/// A new session.
#[derive(Clone, Debug)]
pub struct SessionInfo {
    /// The cookie's value.
    pub secret: String,
    /// Whose.
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
    /// There is none.
    #[error("there is none")]
    Missing,
    /// Too short, too long, or no name.
    #[error("not allowed")]
    Unfit,
    /// The database.
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

/// Who is known to the hub.
#[derive(Debug)]
pub struct Access {
    db: Arc<Mutex<Connection>>,
    known: Known,
    empty: AtomicBool,
    touches: SyncSender<Touch>,
}

impl Access {
    /// Opens it in a folder, or in memory.
    pub fn open(folder: Option<&Path>) -> Result<Self, StoreError> {
        let db = crate::store::open(folder, "hub.db", SCHEMA)?;
        let empty = AtomicBool::new(count(&db, "SELECT COUNT(*) FROM user")? == 0);
        let known = read(&db)?;
        let db = Arc::new(Mutex::new(db));
        let (touches, queue) = sync_channel(TOUCHES_MAX);
        let own = db.clone();
        let named = std::thread::Builder::new().name("lafet-access".into());
        named.spawn(move || write_touches(&own, &queue))?;
        Ok(Self { db, known, empty, touches })
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

    /// Makes the first administrator. Slow on purpose.
    pub fn set_up(
        &self,
        now_ms: u64,
        link: &str,
        user: &str,
        password: &str,
    ) -> Result<(), AccessError> {
        check(user, password)?;
        let hash = hash(password)?;
        let mut db = lock(&self.db);
        let transaction = db.transaction()?;
        let known =
            transaction.execute("DELETE FROM setup WHERE digest = ?1", [digest(link)])? == 1;
        if !known || count(&transaction, "SELECT COUNT(*) FROM user")? != 0 {
            return Err(AccessError::Wrong);
        }
        insert(&transaction, now_ms, user, Role::Administrator, &hash)?;
        transaction.commit()?;
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
        let hash = hash(password)?;
        let db = lock(&self.db);
        if role_of(&db, user)?.is_some() {
            return Err(AccessError::Conflict);
        }
        Ok(insert(&db, now_ms, user, role, &hash)?)
    }

    /// Changes role or password, and ends the user's sessions but one. Slow on purpose.
    pub fn change(
        &self,
        user: &str,
        role: Option<Role>,
        password: Option<&str>,
        but: Option<&str>,
    ) -> Result<(), AccessError> {
        let hash = match password {
            Some(password) => {
                check(user, password)?;
                Some(hash(password)?)
            }
            None => None,
        };
        let mut db = lock(&self.db);
        let transaction = db.transaction()?;
        role_of(&transaction, user)?.ok_or(AccessError::Missing)?;
        if let Some(role) = role {
            transaction
                .execute("UPDATE user SET role = ?2 WHERE name = ?1", [user, role.name()])?;
        }
        if let Some(hash) = hash {
            transaction.execute("UPDATE user SET password = ?2 WHERE name = ?1", [user, &hash])?;
        }
        let but = but.unwrap_or_default();
        transaction.execute("DELETE FROM session WHERE user = ?1 AND id <> ?2", [user, but])?;
        keep_an_administrator(&transaction)?;
        transaction.commit()?;
        self.known.keep_sessions(|it| it.user != user || it.key == but);
        if let Some(role) = role {
            self.known.set_role(user, role);
        }
        Ok(())
    }

    /// Removes a user, and the user's sessions.
    pub fn remove(&self, user: &str) -> Result<(), AccessError> {
        let mut db = lock(&self.db);
        let transaction = db.transaction()?;
        if transaction.execute("DELETE FROM user WHERE name = ?1", [user])? == 0 {
            return Err(AccessError::Missing);
        }
        keep_an_administrator(&transaction)?;
        transaction.commit()?;
        self.known.keep_sessions(|it| it.user != user);
        Ok(())
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
        Ok(users.collect::<Result<_, _>>()?)
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
        let role = role_of(&db, user)?.ok_or(AccessError::Wrong)?;
        let entry = Entry {
            key: id,
            user: user.to_owned(),
            role,
            csrf,
            created_ms: now_ms,
            used_ms: now_ms,
        };
        let digest = digest(&secret);
        // A full disk keeps nobody out: such a session lives as long as the hub does.
        if let Err(error) = store_session(&db, &digest, &entry) {
            tracing::warn!(%error, user, "the session is not stored");
        }
        let principal = Principal {
            user: user.to_owned(),
            role,
            kind: Kind::Session,
            key: entry.key.clone(),
            csrf: entry.csrf.clone(),
            expires_ms: now_ms + IDLE_MS,
            stale: false,
        };
        self.known.add_session(digest, entry);
        Ok(SessionInfo { secret, principal })
    }

    /// Checks a password. Slow on purpose.
    pub fn check_password(&self, user: &str, password: &str) -> Result<(), AccessError> {
        if password.len() > PASSWORD_MAX {
            return Err(AccessError::Wrong);
        }
        let find = "SELECT password FROM user WHERE name = ?1";
        let known: Option<String> =
            lock(&self.db).query_row(find, [user], |row| row.get(0)).optional()?;
        let right = match known {
            Some(hash) => {
                Argon2::default().verify_password(password.as_bytes(), hash.as_str()).is_ok()
            }
            None => {
                hash(password)?;
                false
            }
        };
        if right { Ok(()) } else { Err(AccessError::Wrong) }
    }

    /// Who has this cookie.
    pub fn by_session(&self, now_ms: u64, secret: &str) -> Option<Principal> {
        let (principal, touch) = self.known.by_session(now_ms, secret)?;
        self.touch(touch);
        Some(principal)
    }

    /// Who has this token.
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
        if let Some(touch) = touch {
            // One that is left out is repeated in a minute.
            _ = self.touches.try_send(touch);
        }
    }

    /// Ends a session; `false`: there is none.
    pub fn log_out(&self, id: &str) -> Result<bool, AccessError> {
        self.known.keep_sessions(|it| it.key != id);
        Ok(lock(&self.db).execute("DELETE FROM session WHERE id = ?1", [id])? > 0)
    }

    /// The sessions that have not run out, the latest used first.
    pub fn sessions(&self, now_ms: u64) -> Vec<Entry> {
        self.known.sessions(now_ms)
    }

    /// Makes a token; its secret is told this once.
    pub fn add_token(
        &self,
        now_ms: u64,
        name: &str,
        role: Role,
    ) -> Result<(u64, String), AccessError> {
        if name.trim().is_empty() || name.len() > 100 {
            return Err(AccessError::Unfit);
        }
        let secret = format!("{TOKEN_PREFIX}{}", random()?);
        let (db, digest) = (lock(&self.db), digest(&secret));
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
        Ok(tokens.collect::<Result<_, _>>()?)
    }

    /// Takes a token back.
    pub fn remove_token(&self, id: u64) -> Result<(), AccessError> {
        self.known.remove_token(&token_key(id));
        match lock(&self.db).execute("DELETE FROM token WHERE id = ?1", [signed(id)])? {
            0 => Err(AccessError::Missing),
            _ => Ok(()),
        }
    }
}

fn check(user: &str, password: &str) -> Result<(), AccessError> {
    let name = user.chars().count();
    let fine = (1..=64).contains(&name) && user.trim() == user && !user.contains(char::is_control);
    let long = password.chars().count() >= PASSWORD_MIN && password.len() <= PASSWORD_MAX;
    if fine && long { Ok(()) } else { Err(AccessError::Unfit) }
}

/// argon2id with the crate's parameters (19 MiB, 2 passes: OWASP's).
fn hash(password: &str) -> Result<String, AccessError> {
    let hash = Argon2::default().hash_password(password.as_bytes());
    hash.map(|hash| hash.to_string()).map_err(|_| AccessError::Unfit)
}

fn random() -> Result<String, AccessError> {
    secret().map_err(|error| StoreError::Io(std::io::Error::other(error.to_string())).into())
}

fn insert(
    db: &Connection,
    now_ms: u64,
    user: &str,
    role: Role,
    hash: &str,
) -> Result<(), rusqlite::Error> {
    let row = params![user, role.name(), hash, signed(now_ms)];
    db.execute("INSERT INTO user VALUES (?1, ?2, ?3, ?4, NULL)", row).map(|_| ())
}

fn role_of(db: &Connection, user: &str) -> Result<Option<Role>, rusqlite::Error> {
    let name: Option<String> = db
        .query_row("SELECT role FROM user WHERE name = ?1", [user], |row| row.get(0))
        .optional()?;
    Ok(name.map(|name| role(&name)))
}

/// What nobody knows may least.
pub fn role(name: &str) -> Role {
    Role::by_name(name).unwrap_or(Role::Observer)
}

fn keep_an_administrator(db: &Connection) -> Result<(), AccessError> {
    match count(db, "SELECT COUNT(*) FROM user WHERE role = 'administrator'")? {
        0 => Err(AccessError::Conflict),
        _ => Ok(()),
    }
}

fn count(db: &Connection, query: &str) -> Result<i64, rusqlite::Error> {
    db.query_row(query, [], |row| row.get(0))
}

/// As SQLite has numbers.
pub fn signed(number: u64) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}

/// As SQLite had it.
pub fn unsigned(number: i64) -> u64 {
    u64::try_from(number).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::super::known::{SESSION_MS, STALE_MS};
    use super::*;

    const PASSWORD: &str = "correct horse";

    fn set_up() -> Access {
        let access = Access::open(None).unwrap();
        let link = access.setup_link().unwrap().unwrap();
        access.set_up(1, &link, "root", PASSWORD).unwrap();
        assert!(matches!(access.set_up(1, &link, "second", PASSWORD), Err(AccessError::Wrong)));
        access
    }

    #[test]
    fn the_link_makes_one_administrator_once() {
        let access = Access::open(None).unwrap();
        let first = access.setup_link().unwrap().unwrap();
        let link = access.setup_link().unwrap().unwrap();
        assert!(matches!(access.set_up(1, &first, "root", PASSWORD), Err(AccessError::Wrong)));
        assert!(matches!(access.set_up(1, &link, "root", "short"), Err(AccessError::Unfit)));
        access.set_up(1, &link, "root", PASSWORD).unwrap();
        assert_eq!(access.setup_link().unwrap(), None);
        assert_eq!(access.users().unwrap()[0].role, Role::Administrator);
    }

    #[test]
    fn sessions_begin_with_a_password_and_end() {
        let access = set_up();
        assert!(matches!(access.log_in(5, "root", "wrong"), Err(AccessError::Wrong)));
        assert!(matches!(access.log_in(5, "nobody", PASSWORD), Err(AccessError::Wrong)));
        let session = access.log_in(5, "root", PASSWORD).unwrap();
        let at = |ms| access.by_session(ms, &session.secret);
        assert_eq!(at(10).unwrap().user, "root");
        assert!(!at(10 + IDLE_MS - 100).unwrap().stale, "it is used, so it goes on");
        let late = 2 * IDLE_MS + 1;
        assert!(at(late).unwrap().stale);
        assert_eq!(at(late + STALE_MS), None);
        assert_eq!(access.by_session(10, "other"), None);
        access.log_out(&session.principal.key).unwrap();
        assert_eq!(at(10), None);
    }

    #[test]
    fn a_new_password_or_role_ends_other_sessions() {
        let access = set_up();
        let one = access.log_in(5, "root", PASSWORD).unwrap();
        let two = access.log_in(5, "root", PASSWORD).unwrap();
        access.change("root", None, Some("another one"), Some(&one.principal.key)).unwrap();
        assert!(access.is_valid(6, &one.principal) && !access.is_valid(6, &two.principal));
        assert!(access.log_in(6, "root", PASSWORD).is_err());
    }

    #[test]
    fn the_last_administrator_stays() {
        let access = set_up();
        assert!(matches!(access.remove("root"), Err(AccessError::Conflict)));
        let demoted = access.change("root", Some(Role::Observer), None, None);
        assert!(matches!(demoted, Err(AccessError::Conflict)));
        access.add(1, "anna", Role::Administrator, PASSWORD).unwrap();
        assert!(matches!(
            access.add(1, "anna", Role::Observer, PASSWORD),
            Err(AccessError::Conflict)
        ));
        access.remove("root").unwrap();
        assert_eq!(access.users().unwrap().len(), 1);
    }

    #[test]
    fn tokens_are_told_once_and_taken_back() {
        let access = set_up();
        let (id, secret) = access.add_token(1, "scada", Role::Operator).unwrap();
        let principal = access.by_token(2, &secret).unwrap();
        assert_eq!((principal.user.as_str(), principal.role), ("scada", Role::Operator));
        assert!(access.is_valid(3, &principal));
        access.remove_token(id).unwrap();
        assert_eq!(access.by_token(2, &secret), None);
        assert!(!access.is_valid(3, &principal));
    }

    #[test]
    fn a_disk_that_takes_nothing_keeps_nobody_out() {
        let folder = std::env::temp_dir().join(format!("lafet-access-{}", std::process::id()));
        let access = Access::open(Some(&folder)).unwrap();
        let link = access.setup_link().unwrap().unwrap();
        access.set_up(1, &link, "root", PASSWORD).unwrap();
        let session = access.log_in(5, "root", PASSWORD).unwrap();
        let (_, token) = access.add_token(5, "scada", Role::Operator).unwrap();
        lock(&access.db).pragma_update(None, "query_only", true).unwrap();
        let later = 5 + 3_600_000;
        assert!(!access.by_session(later, &session.secret).unwrap().stale);
        assert_eq!(access.by_token(later, &token).unwrap().user, "scada");
        let second = access.log_in(later, "root", PASSWORD).unwrap();
        assert_eq!(access.by_session(later, &second.secret).unwrap().user, "root");
        assert_eq!(access.sessions(later).len(), 2);
        drop(access);

        let access = Access::open(Some(&folder)).unwrap();
        assert!(access.by_session(later, &session.secret).is_some(), "it was stored");
        assert!(access.by_session(later, &second.secret).is_none(), "it was not");
        assert!(access.by_token(later, &token).is_some() && !access.is_empty());
        drop(access);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn an_open_websocket_is_use_and_ends_with_its_session() {
        let access = set_up();
        let session = access.log_in(5, "root", PASSWORD).unwrap();
        let hour = 3_600_000;
        assert!((1..160).all(|n| access.is_valid(n * hour, &session.principal)), "a week");
        assert!(!access.is_valid(5 + SESSION_MS, &session.principal));
        assert!(access.by_session(5 + SESSION_MS, &session.secret).unwrap().stale);
    }
}
