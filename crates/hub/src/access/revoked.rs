//! What was revoked, and is not in the database yet, as the disk is full: it is in effect at once, is
//! tried again, and is kept in a preallocated file for a restart.

use std::fs::File;
use std::io::ErrorKind::{QuotaExceeded, StorageFull};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rusqlite::Connection;
use serde::{Deserialize, Serialize};

use super::Role;
use super::keys::digest;
use super::known::Entry;
use super::stored::change;
use super::users::signed;
use crate::store::{StoreError, private};

/// The file beside the database.
const JOURNAL: &str = "revoked";
/// Room of each of its two halves, which is taken while the disk has some: a full disk does not keep it from
/// being written. They are written in turn, so a power cut spoils the list that was being written and
/// leaves the one before it.
const HALF_BYTES: usize = 32 * 1024;
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
    /// Number of the list that was written last.
    number: u64,
    /// What a start found that cannot be read.
    spoilt: Option<String>,
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
        let mut bytes = Vec::new();
        let unread = file.read_to_end(&mut bytes).err();
        let mut spoilt = unread.as_ref().map(ToString::to_string);
        let mut lists = Vec::new();
        for (index, half) in bytes.chunks(HALF_BYTES).enumerate() {
            match List::read(half, index == 0) {
                Ok(list) => lists.extend(list),
                Err(error) => spoilt = Some(error.to_string()),
            }
        }
        if lists.iter().any(|list| list.torn) {
            spoilt = Some(NOT_WHOLE.to_owned());
        }
        let number = lists.iter().filter_map(|list| list.number).max().unwrap_or_default();
        let last = lists.into_iter().max_by_key(|list| list.number.unwrap_or(u64::MAX));
        let waiting = last.unwrap_or_default().waiting;
        let mut revoked =
            Self { waiting, journal: Some(file), number, spoilt, waits: Arc::default() };
        revoked.say();
        // Both halves are good after two. What could not be read is not written over before it has to be.
        let is_whole = bytes.len() >= 2 * HALF_BYTES && revoked.spoilt.is_none();
        if !is_whole
            && unread.is_none()
            && let Err(error) = revoked.write().and_then(|()| revoked.write())
        {
            tracing::warn!(%error, "no room is taken for revocations");
        }
        Ok(revoked)
    }

    /// Why a list that was found cannot be read, if one cannot.
    pub fn spoilt(&self) -> Option<&str> {
        self.spoilt.as_deref()
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

    /// Writes the list over the one before the last, in the room that the file has.
    fn write(&mut self) -> std::io::Result<()> {
        let (next, other) = (self.number + 1, self.number + 2);
        match self.write_as(next) {
            // A file of earlier versions has room for one list, on a full disk too.
            Err(error) if matches!(error.kind(), StorageFull | QuotaExceeded) => {
                self.write_as(other)
            }
            written => written,
        }
    }

    fn write_as(&mut self, number: u64) -> std::io::Result<()> {
        let Some(file) = &mut self.journal else { return Ok(()) };
        let half = written(number, &self.waiting)?;
        file.seek(SeekFrom::Start(number % 2 * HALF_BYTES as u64))?;
        file.write_all(&half)?;
        file.sync_data()?;
        self.number = number;
        Ok(())
    }
}

/// What one half of the file has.
#[derive(Debug, Default)]
struct List {
    /// The higher one counts. Lines alone have none and count before all: earlier versions wrote them, before
    /// these lists or after an upgrade was taken back.
    number: Option<u64>,
    waiting: Vec<Revocation>,
    /// Some of its lines cannot be read.
    torn: bool,
}

/// The first line of a half.
#[derive(Debug, Serialize, Deserialize)]
struct Heading {
    /// Number of the list: the higher one counts.
    list: u64,
    /// SHA-256 of the number and of everything behind this line: half a heading is none.
    sha256: String,
}

/// What is wrong with a list.
const NOT_WHOLE: &str = "a list of revocations is not whole";

impl List {
    /// Reads a half; `None`: it was never written. `alone`: earlier versions have written this one alone.
    fn read(half: &[u8], alone: bool) -> Result<Option<Self>, std::io::Error> {
        let wrong = || std::io::Error::other(NOT_WHOLE);
        if half.iter().all(|byte| *byte == 0) {
            return Ok(None);
        }
        let text = std::str::from_utf8(half).map_err(|_| wrong())?;
        let (first, rest) = text.split_once('\n').ok_or_else(wrong)?;
        let (number, lines) = match serde_json::from_str::<Heading>(first) {
            Ok(heading) if heading.sha256 == sum(heading.list, rest) => (Some(heading.list), rest),
            Ok(_) => return Err(wrong()),
            Err(_) if alone && !text.contains('\0') => (None, text),
            Err(_) => return Err(wrong()),
        };
        let lines = lines.lines().filter(|line| !line.is_empty());
        // A power cut may have torn one of those that stand alone: the others count.
        let count = lines.clone().count();
        let waiting: Vec<_> = lines.filter_map(|line| serde_json::from_str(line).ok()).collect();
        let torn = waiting.len() < count;
        Ok(Some(Self { number, waiting, torn }))
    }
}

/// A half of the file with this list.
fn written(number: u64, waiting: &[Revocation]) -> std::io::Result<Vec<u8>> {
    let mut lines = String::new();
    for revocation in waiting {
        lines += &serde_json::to_string(revocation)?;
        lines.push('\n');
    }
    // The digest is as long as another one, so the heading is as long as this one.
    let heading =
        |lines: &str| serde_json::to_string(&Heading { list: number, sha256: sum(number, lines) });
    let room = HALF_BYTES.checked_sub(heading("")?.len() + 1 + lines.len());
    let room = room.ok_or_else(|| std::io::Error::other("the list of revocations is too long"))?;
    lines.push_str(&"\n".repeat(room));
    Ok(format!("{}\n{lines}", heading(&lines)?).into_bytes())
}

fn sum(number: u64, lines: &str) -> String {
    digest(&format!("{number}\n{lines}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(user: &str) -> Revocation {
        Revocation::User { user: user.into() }
    }

    fn opened(folder: &Path) -> (Vec<Revocation>, bool) {
        let revoked = Revoked::open(Some(folder)).unwrap();
        (revoked.waiting.clone(), revoked.spoilt().is_some())
    }

    /// A power cut at any byte of a list that is being written leaves the one before it, and is reported.
    #[test]
    fn a_list_that_is_cut_off_spoils_no_other() {
        let folder = std::env::temp_dir().join(format!("lafet-halves-{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir(&folder).unwrap();
        let path = folder.join(JOURNAL);
        let mut revoked = Revoked::open(Some(&folder)).unwrap();
        assert!(revoked.note(of("anna")) && revoked.note(of("boris")));
        let before = std::fs::read(&path).unwrap();
        assert!(revoked.note(of("viktor")));
        let after = std::fs::read(&path).unwrap();
        assert_eq!((before.len(), after.len()), (2 * HALF_BYTES, 2 * HALF_BYTES));
        let changed: Vec<usize> = (0..after.len()).filter(|at| before[*at] != after[*at]).collect();
        let (two, three) = (vec![of("anna"), of("boris")], revoked.waiting.clone());
        let (first, last) = (changed[0], *changed.last().unwrap());
        for cut in (first..=last + 1).step_by(7).chain([first + 1, last, last + 1]) {
            let mut torn = after.clone();
            torn[cut..].copy_from_slice(&before[cut..]);
            std::fs::write(&path, &torn).unwrap();
            let expected = match () {
                () if torn == after => (three.clone(), false),
                () if torn == before => (two.clone(), false),
                () => (two.clone(), true),
            };
            assert_eq!(opened(&folder), expected, "cut at {cut}");
            assert_eq!(opened(&folder), (expected.0, false), "cut at {cut}: reported once");
        }
        // What is there and no list is reported as well.
        std::fs::write(&path, "no list").unwrap();
        assert_eq!(opened(&folder), (vec![], true));
        // Lines alone, as earlier versions wrote them.
        let mut lines = serde_json::to_string(&of("anna")).unwrap();
        lines.push_str(&"\n".repeat(HALF_BYTES - lines.len()));
        std::fs::write(&path, lines).unwrap();
        assert_eq!(opened(&folder), (vec![of("anna")], false));
        assert_eq!(opened(&folder), (vec![of("anna")], false));
        // And as one writes them after an upgrade was taken back: over the first half alone.
        let mut both = std::fs::read(&path).unwrap();
        let mut lines = serde_json::to_string(&of("boris")).unwrap();
        lines.push_str(&"\n".repeat(HALF_BYTES - lines.len()));
        both[..HALF_BYTES].copy_from_slice(lines.as_bytes());
        std::fs::write(&path, both).unwrap();
        assert_eq!(opened(&folder), (vec![of("boris")], false));
        assert_eq!(opened(&folder), (vec![of("boris")], false));
        // Of which nothing was left: the second half is out of date.
        let mut both = std::fs::read(&path).unwrap();
        both[..HALF_BYTES].fill(b'\n');
        std::fs::write(&path, both).unwrap();
        assert_eq!(opened(&folder), (vec![], false));
        assert_eq!(opened(&folder), (vec![], false));
        // The second half without its first page, as a power cut leaves its first writing: no list, and reported.
        let mut both = written(0, &[of("anna")]).unwrap();
        both.extend(written(1, &[of("anna")]).unwrap());
        both[HALF_BYTES..HALF_BYTES + 4096].fill(0);
        std::fs::write(&path, both).unwrap();
        assert_eq!(opened(&folder), (vec![of("anna")], true));
        std::fs::remove_dir_all(&folder).unwrap();
    }

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
