//! What was revoked, and is not in the database yet, as the disk is full: it is in effect at once, is
//! tried again, and is kept in a preallocated file for a restart.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rusqlite::Connection;
use serde::{Deserialize, Serialize};

use super::Role;
use super::known::Entry;
use super::stored::change;
use super::users::signed;
use crate::store::{StoreError, private};

/// The file beside the database.
const JOURNAL: &str = "revoked";
/// Its room, which is taken while the disk has some: a full disk does not keep it from being
/// written.
const JOURNAL_BYTES: usize = 32 * 1024;
/// What waits for the disk; more is refused.
const WAITING_MAX: usize = 1000;

/// A revocation, kept in memory until the disk has it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "revoked", rename_all = "snake_case")]
pub enum Revocation {
    /// A user is removed.
    User { user: String },
    /// Role or password of a user change, and the user's sessions end, but for one.
    Change {
        user: String,
        role: Option<Role>,
        /// Hash of the new password.
        password: Option<String>,
        but: Option<String>,
    },
    /// A session ends.
    Session { id: String },
    /// A token is taken back.
    Token { id: u64 },
}

/// What waits for the disk.
#[derive(Debug, Default)]
pub struct Revoked {
    waiting: Vec<Revocation>,
    journal: Option<File>,
    /// Something waits. Who asks does not wait for the disk, as who holds the lock of this may.
    waits: Arc<AtomicBool>,
}

impl Revocation {
    /// Whether another one is of the same user, session or token.
    fn is_of_same(&self, other: &Self) -> bool {
        match (self.user(), other.user()) {
            (None, None) => self == other,
            (user, of) => user == of,
        }
    }

    fn user(&self) -> Option<&str> {
        match self {
            Self::User { user } | Self::Change { user, .. } => Some(user),
            Self::Session { .. } | Self::Token { .. } => None,
        }
    }

    fn apply(&self, db: &Connection) -> Result<(), rusqlite::Error> {
        let done = match self {
            Self::User { user } => db.execute("DELETE FROM user WHERE name = ?1", [user]),
            Self::Change { user, role, password, but } => {
                return change(db, user, *role, password.as_deref(), but.as_deref());
            }
            Self::Session { id } => db.execute("DELETE FROM session WHERE id = ?1", [id]),
            Self::Token { id } => db.execute("DELETE FROM token WHERE id = ?1", [signed(*id)]),
        };
        done.map(drop)
    }
}

impl Revoked {
    /// Opens the file, and takes its room.
    pub fn open(folder: Option<&Path>) -> Result<Self, StoreError> {
        let Some(folder) = folder else { return Ok(Self::default()) };
        let path = folder.join(JOURNAL);
        private(&path)?;
        let mut file = File::options().read(true).write(true).open(path)?;
        let mut text = String::new();
        // What no revocation can be read from is none.
        _ = file.read_to_string(&mut text);
        let waiting = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
        let waits = Arc::default();
        let mut revoked = Self { waiting, journal: Some(file), waits };
        revoked.say();
        if text.len() < JOURNAL_BYTES
            && let Err(error) = revoked.write()
        {
            tracing::warn!(%error, "no room is taken for revocations");
        }
        Ok(revoked)
    }

    /// Whether a revocation is not stored yet, to be asked without a lock.
    pub fn waits(&self) -> Arc<AtomicBool> {
        self.waits.clone()
    }

    fn say(&self) {
        self.waits.store(!self.waiting.is_empty(), Ordering::Relaxed);
    }

    /// Whether a revocation is not stored yet.
    pub fn is_waiting(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// Whether this user is removed.
    pub fn has_user(&self, name: &str) -> bool {
        self.waiting.iter().any(|it| matches!(it, Revocation::User { user } if user == name))
    }

    /// The role that a user has got.
    pub fn role_of(&self, name: &str) -> Option<Role> {
        self.changes(name).filter_map(|(role, _)| role).last()
    }

    /// The hash of the password that a user has got.
    pub fn password_of(&self, name: &str) -> Option<&str> {
        self.changes(name).filter_map(|(_, password)| password).last()
    }

    fn changes(&self, name: &str) -> impl Iterator<Item = (Option<Role>, Option<&str>)> {
        self.waiting.iter().filter_map(move |it| match it {
            Revocation::Change { user, role, password, .. } if user == name => {
                Some((*role, password.as_deref()))
            }
            _ => None,
        })
    }

    /// This token is taken back.
    pub fn has_token(&self, number: u64) -> bool {
        self.waiting.iter().any(|it| matches!(it, Revocation::Token { id } if *id == number))
    }

    /// Whether this session is ended.
    pub fn has_session(&self, entry: &Entry) -> bool {
        self.waiting.iter().any(|it| match it {
            Revocation::Session { id } => *id == entry.key,
            Revocation::User { user } => *user == entry.user,
            Revocation::Change { user, but, .. } => {
                *user == entry.user && but.as_ref() != Some(&entry.key)
            }
            Revocation::Token { .. } => false,
        })
    }

    /// Takes what the database did not take; `false`: too much waits.
    pub fn note(&mut self, revocation: Revocation) -> bool {
        // What a user has got in between is not what the user had then.
        let last = self.waiting.iter().rfind(|it| it.is_of_same(&revocation));
        if last == Some(&revocation) {
            return true;
        }
        if self.waiting.len() == WAITING_MAX {
            return false;
        }
        self.waiting.push(revocation);
        self.say();
        if let Err(error) = self.write() {
            tracing::error!(%error, "a revocation is in effect, but would not survive a restart");
        }
        true
    }

    /// Stores what waits.
    pub fn flush(&mut self, db: &Connection) -> Result<(), rusqlite::Error> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        let transaction = db.unchecked_transaction()?;
        for revocation in &self.waiting {
            revocation.apply(&transaction)?;
        }
        transaction.commit()?;
        self.waiting.clear();
        self.say();
        if let Err(error) = self.write() {
            // At the next start the same is removed again, of which nothing is left.
            tracing::warn!(%error, "the list of revocations is not emptied");
        }
        Ok(())
    }

    /// Writes the list over the old one, in the room that the file has.
    fn write(&mut self) -> std::io::Result<()> {
        let Some(file) = &mut self.journal else { return Ok(()) };
        let lines = self.waiting.iter().filter_map(|it| serde_json::to_string(it).ok());
        let mut text: String = lines.map(|line| line + "\n").collect();
        if text.len() > JOURNAL_BYTES {
            return Err(std::io::Error::other("the list of revocations is too long"));
        }
        text.push_str(&"\n".repeat(JOURNAL_BYTES - text.len()));
        file.seek(SeekFrom::Start(0))?;
        file.write_all(text.as_bytes())?;
        file.sync_data()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The disk is full while a user is made operator, administrator, and operator again.
    #[test]
    fn what_a_user_got_last_counts() {
        let mut revoked = Revoked::default();
        let change = |role| Revocation::Change {
            user: "anna".into(),
            role: Some(role),
            password: None,
            but: None,
        };
        for role in [Role::Operator, Role::Administrator, Role::Operator] {
            assert!(revoked.note(change(role)));
            assert_eq!(revoked.role_of("anna"), Some(role));
        }
        let other = Revocation::User { user: "boris".into() };
        assert!(revoked.note(other) && revoked.note(change(Role::Operator)));
        assert_eq!(revoked.waiting.len(), 4, "the same once more is known");
    }
}
