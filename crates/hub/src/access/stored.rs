//! Users, sessions and tokens between the disk and memory.

use std::collections::{BTreeMap, HashMap};
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use rusqlite::{Connection, OptionalExtension, params};

use super::known::{Entry, Known, SESSION_MS, STALE_MS, Touch};
use super::revoked::Revoked;
use super::users::{role, signed, unsigned};
use super::{Kind, Role};
use crate::sync::lock;

/// What the disk has not taken is tried again this often.
const AGAIN: Duration = Duration::from_secs(2);

/// Sessions and tokens as they are stored.
pub fn read(db: &Connection, now_ms: u64, revoked: &Revoked) -> Result<Known, rusqlite::Error> {
    let known = Known::default();
    let mut query = db.prepare(
        "SELECT digest, session.id, session.user, user.role, csrf, session.created_ms, used_ms
         FROM session JOIN user ON user.name = session.user",
    )?;
    let mut rows = query.query([])?;
    while let Some(row) = rows.next()? {
        let user: String = row.get(2)?;
        let new_role = revoked.role_of(&user);
        let entry = Entry {
            key: row.get(1)?,
            user,
            role: new_role.unwrap_or(role(&row.get::<_, String>(3)?)),
            csrf: row.get(4)?,
            // The clock may have been set back in the meantime: nothing lasts longer for that.
            created_ms: unsigned(row.get(5)?).min(now_ms),
            used_ms: unsigned(row.get(6)?).min(now_ms),
        };
        if revoked.has_session(&entry) {
            continue;
        }
        known.add_session(row.get(0)?, entry);
    }
    let mut query =
        db.prepare("SELECT digest, id, name, role, created_ms, last_used_ms FROM token")?;
    let mut rows = query.query([])?;
    while let Some(row) = rows.next()? {
        if revoked.has_token(unsigned(row.get(1)?)) {
            continue;
        }
        let (name, role_name): (String, String) = (row.get(2)?, row.get(3)?);
        let (created_ms, used_ms) = (unsigned(row.get(4)?), row.get::<_, Option<i64>>(5)?);
        let used_ms = used_ms.map_or(0, unsigned);
        let entry = token(unsigned(row.get(1)?), &name, role(&role_name), created_ms, used_ms);
        known.add_token(row.get(0)?, entry);
    }
    Ok(known)
}

/// The roles of the users, with what is not stored yet.
pub fn read_roles(
    db: &Connection,
    revoked: &Revoked,
) -> Result<BTreeMap<String, Role>, rusqlite::Error> {
    let mut query = db.prepare("SELECT name, role FROM user")?;
    let rows = query.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
    let mut roles = BTreeMap::new();
    for row in rows {
        let (user, stored): (String, String) = row?;
        if !revoked.has_user(&user) {
            let role = revoked.role_of(&user).unwrap_or(role(&stored));
            roles.insert(user, role);
        }
    }
    Ok(roles)
}

/// The id of a token among seats.
pub fn token_key(id: u64) -> String {
    format!("k{id}")
}

/// A token, to be known.
pub fn token(id: u64, name: &str, role: Role, created_ms: u64, used_ms: u64) -> Entry {
    let (key, user) = (token_key(id), name.to_owned());
    Entry { key, user, role, csrf: String::new(), created_ms, used_ms }
}

/// Writes a new session down.
pub fn store_session(
    db: &Connection,
    digest: &str,
    entry: &Entry,
    now_ms: u64,
) -> Result<(), rusqlite::Error> {
    let row = params![entry.user, signed(now_ms)];
    db.execute("UPDATE user SET last_login_ms = ?2 WHERE name = ?1", row)?;
    let old = signed(now_ms.saturating_sub(SESSION_MS + STALE_MS));
    db.execute("DELETE FROM session WHERE created_ms < ?1", [old])?;
    let row = params![digest, entry.key, entry.user, entry.csrf, signed(now_ms)];
    db.execute("INSERT INTO session VALUES (?1, ?2, ?3, ?4, ?5, ?5)", row).map(|_| ())
}

/// Writes down what was used, and what was revoked and has to wait for the disk, until the hub ends.
pub fn write_touches(db: &Mutex<Connection>, revoked: &Mutex<Revoked>, queue: &Receiver<Touch>) {
    loop {
        let touch = queue.recv_timeout(AGAIN);
        if lock(revoked).is_waiting() {
            let db = lock(db);
            if let Err(error) = lock(revoked).flush(&db) {
                tracing::debug!(%error, "revocations are not stored yet");
            }
        }
        let Touch { kind, key, used_ms } = match touch {
            Ok(touch) => touch,
            Err(RecvTimeoutError::Timeout) => continue,
            Err(RecvTimeoutError::Disconnected) => return,
        };
        let query = match kind {
            Kind::Session => "UPDATE session SET used_ms = ?2 WHERE id = ?1",
            _ => "UPDATE token SET last_used_ms = ?2 WHERE 'k' || id = ?1",
        };
        if let Err(error) = lock(db).execute(query, params![key, signed(used_ms)]) {
            tracing::debug!(%error, "the use of a session is not stored");
        }
    }
}

/// Names of users and tokens: one of the ones may not look like one of the others.
pub fn names(db: &Connection) -> Result<Vec<String>, rusqlite::Error> {
    let mut query = db.prepare("SELECT name FROM user UNION SELECT name FROM token")?;
    query.query_map([], |row| row.get(0))?.collect()
}

pub fn store_change(
    db: &mut Connection,
    user: &str,
    role: Option<Role>,
    hash: Option<&str>,
    but: Option<&str>,
) -> Result<(), rusqlite::Error> {
    let transaction = db.transaction()?;
    change(&transaction, user, role, hash, but)?;
    transaction.commit()
}

/// Changes a user, within a transaction.
pub fn change(
    transaction: &Connection,
    user: &str,
    role: Option<Role>,
    hash: Option<&str>,
    but: Option<&str>,
) -> Result<(), rusqlite::Error> {
    if let Some(role) = role {
        transaction.execute("UPDATE user SET role = ?2 WHERE name = ?1", [user, role.name()])?;
    }
    if let Some(hash) = hash {
        transaction.execute("UPDATE user SET password = ?2 WHERE name = ?1", [user, hash])?;
        transaction.execute("DELETE FROM device WHERE user = ?1", [user])?;
    }
    let but = but.unwrap_or_default();
    let end = "DELETE FROM session WHERE user = ?1 AND id <> ?2";
    transaction.execute(end, [user, but]).map(drop)
}

pub fn read_devices(db: &Connection) -> Result<HashMap<String, String>, rusqlite::Error> {
    let mut query = db.prepare("SELECT digest, user FROM device")?;
    query.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?.collect()
}

pub fn insert(
    db: &Connection,
    now_ms: u64,
    user: &str,
    role: Role,
    hash: &str,
) -> Result<(), rusqlite::Error> {
    let row = params![user, role.name(), hash, signed(now_ms)];
    db.execute("INSERT INTO user VALUES (?1, ?2, ?3, ?4, NULL)", row).map(|_| ())
}

pub fn role_of(db: &Connection, user: &str) -> Result<Option<Role>, rusqlite::Error> {
    let name: Option<String> = db
        .query_row("SELECT role FROM user WHERE name = ?1", [user], |row| row.get(0))
        .optional()?;
    Ok(name.map(|name| role(&name)))
}

pub fn count(db: &Connection, query: &str) -> Result<i64, rusqlite::Error> {
    db.query_row(query, [], |row| row.get(0))
}
