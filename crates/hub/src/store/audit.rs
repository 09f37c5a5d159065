//! The audit log: who commanded what, from where, what was answered. Each entry holds the hash of
//! the one before, so that none can be changed or taken out unseen.
//!
//! A thread writes what has come together in one transaction that is on the disk when it is
//! reported as stored. What cannot be stored waits in memory, is tried again each second, and the
//! hub goes on: a full disk must not prevent extinguishing.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

use rusqlite::{Connection, OptionalExtension, Row, params};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tokio::sync::{oneshot, watch};
use tokio::time::{sleep, timeout};
use utoipa::ToSchema;

use super::act::Act;
use super::chain::{Chain, GENESIS, Verified, hash};
use super::db::{Db, StoreError, keep_little, open, said_corrupt};
use super::events::{Page, Search};
use super::mark::{self, Mark, StateFile, Users};
use crate::access::Kind;
use crate::hub::Caller;
use crate::sync::lock;

/// The file in the folder of the state.
const FILE: &str = StateFile::Audit.name();
/// Entries in one transaction.
const BATCH_MAX: usize = 256;
/// Entries that wait in memory for a disk that takes none, and how much of it they take; what comes then is given up.
const WAITING_MAX: u64 = 20_000;
const WAITING_BYTES: u64 = 24 << 20;
/// A disk that has taken none of what waits for this time fails.
const HANGS: Duration = Duration::from_secs(2);
/// Who reads waits so long for entries that are on their way to the disk.
const CATCH_UP: Duration = Duration::from_millis(250);
/// Entries that are looked at for one page of a search: the rest is for the next.
const SCAN_MAX: i64 = 50_000;
/// Entries that are verified before others read.
const VERIFY_MAX: u32 = 200;
/// A piece of an export has so many bytes, and the rest of its last line.
const PIECE_BYTES: usize = 64 * 1024;
/// Characters of a text that an entry has.
const TEXT_MAX: usize = 4096;
/// Pause before what could not be stored is tried again.
const AGAIN: Duration = Duration::from_secs(1);
const SCHEMA: &str = "
CREATE TABLE IF NOT EXISTS audit (
  n INTEGER PRIMARY KEY, at_ms INTEGER NOT NULL, user TEXT NOT NULL, role TEXT NOT NULL,
  origin TEXT NOT NULL, via TEXT NOT NULL, seat TEXT NOT NULL, monitor TEXT NOT NULL,
  what TEXT NOT NULL, outcome TEXT NOT NULL, details TEXT NOT NULL,
  prev TEXT NOT NULL, hash TEXT NOT NULL, kind TEXT, act TEXT
) STRICT;
CREATE TRIGGER IF NOT EXISTS audit_stays BEFORE DELETE ON audit
  BEGIN SELECT RAISE(ABORT, 'the audit log is not deleted from'); END;
CREATE TRIGGER IF NOT EXISTS audit_is_fixed BEFORE UPDATE ON audit
  BEGIN SELECT RAISE(ABORT, 'the audit log is not changed'); END;
PRAGMA synchronous = FULL;";

/// What is to be noted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AuditRecord)]
pub struct Record {
    /// Time, ms since 1970.
    pub at_ms: u64,
    /// Name of the user.
    pub user: String,
    /// Role of the user.
    pub role: String,
    /// IP address of the client.
    pub from: String,
    /// `ws`, `http`, or `hub` or its `zones` by itself.
    pub via: String,
    /// Id of the seat.
    pub seat: String,
    /// To which monitor; empty: to the hub; `*`: to every monitor.
    pub monitor: String,
    /// The action, in words.
    pub what: String,
    /// Result of the action.
    pub outcome: String,
    /// Further data.
    #[schema(value_type = Object)]
    pub details: Value,
    /// How the caller has authenticated: a token may have the name of a user. Entries of earlier
    /// versions have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<Kind>,
    /// The same as `what`, typed: an [`Act`] with its version. Entries of earlier versions have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Act>)]
    pub act: Option<Value>,
}

impl Record {
    /// The same with what it is about.
    #[must_use]
    pub fn about(self, act: &Act) -> Self {
        Self { act: Some(act.to_value()), ..self }
    }

    /// The same with what else is known.
    #[must_use]
    pub fn with(self, details: &impl Serialize) -> Self {
        Self { details: serde_json::to_value(details).unwrap_or_default(), ..self }
    }
}

/// An entry of the log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Entry {
    /// Its number, from 1.
    pub n: u64,
    /// The record.
    #[serde(flatten)]
    pub record: Record,
    /// Hash of the entry before.
    pub prev: String,
    /// Hash of this entry.
    pub hash: String,
}

/// The audit log.
#[derive(Clone, Debug)]
pub struct Audit {
    notes: Sender<Note>,
    /// Empty until the file can be read.
    reads: Arc<OnceLock<Db>>,
    state: Arc<State>,
    checks: Arc<Checks>,
}

/// Checks of the whole chain.
#[derive(Debug, Default)]
struct Checks {
    started: AtomicU64,
    /// Held while the chain is checked.
    last: Arc<tokio::sync::Mutex<Option<Checked>>>,
}

/// The check of this number.
#[derive(Debug)]
struct Checked {
    number: u64,
    took: Duration,
    ended: Instant,
    result: Verified,
}

#[derive(Debug, Default)]
struct State {
    failing: AtomicBool,
    waiting: AtomicU64,
    /// Memory that those take, bytes.
    bytes: AtomicU64,
    /// Entries that were handed to the thread that writes.
    noted: AtomicU64,
    /// Of those, how many are on the disk.
    stored: watch::Sender<u64>,
    lost: AtomicU64,
    /// Since when the disk takes nothing of what waits; `None`: nothing waits.
    since: Mutex<Option<Instant>>,
    /// What was given up, and is not in the log yet.
    given_up: Mutex<Option<GivenUp>>,
}

/// Entries that were given up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct GivenUp {
    entries: u64,
    from_ms: u64,
    to_ms: u64,
}

impl State {
    /// One more waits, of this size; how many and how much there were before.
    fn enter(&self, bytes: u64) -> (u64, u64) {
        let entries = self.waiting.fetch_add(1, Ordering::Relaxed);
        (entries, self.bytes.fetch_add(bytes, Ordering::Relaxed))
    }

    /// Takes an entry of this size among those that wait, if there is room.
    fn admit(&self, bytes: u64) -> bool {
        let (entries, before) = self.enter(bytes);
        let fits = entries < WAITING_MAX && before.saturating_add(bytes) <= WAITING_BYTES;
        if !fits {
            self.release(bytes);
        }
        fits
    }

    /// One of them waits no more.
    fn release(&self, bytes: u64) {
        self.waiting.fetch_sub(1, Ordering::Relaxed);
        self.bytes.fetch_sub(bytes, Ordering::Relaxed);
    }

    /// An entry is given up.
    fn give_up(&self, at_ms: u64) {
        self.lost.fetch_add(1, Ordering::Relaxed);
        let mut given_up = lock(&self.given_up);
        let before = given_up.unwrap_or(GivenUp { entries: 0, from_ms: at_ms, to_ms: at_ms });
        *given_up = Some(GivenUp {
            entries: before.entries + 1,
            from_ms: before.from_ms.min(at_ms),
            to_ms: before.to_ms.max(at_ms),
        });
    }

    /// The entry that says what was given up.
    fn gap(&self) -> Option<Record> {
        let GivenUp { entries, from_ms, to_ms } = lock(&self.given_up).take()?;
        let Caller { principal, via, .. } = Caller::hub();
        let record = Record {
            at_ms: to_ms,
            user: principal.user,
            role: principal.role.name().to_owned(),
            via: via.to_owned(),
            what: format!("{entries} entries were given up"),
            outcome: "lost".into(),
            details: Value::Object(serde_json::Map::new()),
            ..Record::default()
        };
        Some(record.about(&Act::EntriesLost { entries, from_ms, to_ms }))
    }
}

/// What is to be noted, as it waits: as JSON, details and act take a fraction of the memory.
#[derive(Debug)]
struct Note {
    /// Without details and act.
    record: Record,
    details: Box<str>,
    act: Option<Box<str>>,
    stored: Option<oneshot::Sender<u64>>,
}

impl Note {
    fn new(mut record: Record, stored: Option<oneshot::Sender<u64>>) -> Self {
        for text in [&mut record.what, &mut record.user, &mut record.outcome] {
            text.truncate(text.floor_char_boundary(TEXT_MAX));
            text.shrink_to_fit();
        }
        let details = std::mem::take(&mut record.details).to_string().into();
        let act = record.act.take().map(|act| act.to_string().into());
        Self { record, details, act, stored }
    }

    /// Memory that it takes, bytes.
    fn bytes(&self) -> u64 {
        let it = &self.record;
        let texts =
            [&it.user, &it.role, &it.from, &it.via, &it.seat, &it.monitor, &it.what, &it.outcome];
        let texts: usize = texts.into_iter().map(String::len).sum();
        let values = self.details.len() + self.act.as_ref().map_or(0, |act| act.len());
        (size_of::<Self>() + texts + values) as u64
    }

    /// The record as it was noted.
    fn record(&self) -> Record {
        // What was written as JSON is read back as it was.
        let value = |text: &str| -> Value { serde_json::from_str(text).unwrap_or_default() };
        let act = self.act.as_deref().map(value);
        Record { details: value(&self.details), act, ..self.record.clone() }
    }
}

impl Audit {
    /// Opens the log in a folder, or in memory.
    pub fn open(folder: Option<&Path>) -> Result<Self, StoreError> {
        let (write, read) = match folder {
            Some(_) => (open(folder, FILE, SCHEMA)?, open(folder, FILE, SCHEMA)?),
            None => {
                // Two connections to the same database in memory, which has a name for that.
                static NEXT: AtomicU64 = AtomicU64::new(0);
                let number = NEXT.fetch_add(1, Ordering::Relaxed);
                let uri = format!("file:/audit{number}?vfs=memdb");
                let one = || -> Result<Connection, StoreError> {
                    let connection = Connection::open(&uri)?;
                    connection.execute_batch(mark::TABLE)?;
                    connection.execute_batch(SCHEMA)?;
                    Ok(connection)
                };
                (one()?, one()?)
            }
        };
        bring_up_to_date(&write)?;
        [&write, &read].into_iter().try_for_each(keep_little)?;
        let head = head(&write)?;
        let reads = OnceLock::from(Db::new("audit-read", read)?);
        Self::start(reads, |reads, state| Writer::new(write, head, reads, state))
    }

    /// A log whose file the disk did not let be read when the hub started: entries wait in memory, are in the program's
    /// log meanwhile, and the file is tried again each second. It has to be the one that was noted.
    ///
    /// # Errors
    ///
    /// There is no thread.
    pub fn unread(folder: PathBuf, noted: Mark) -> Result<Self, StoreError> {
        let nothing = Connection::open_in_memory()?;
        let audit = Self::start(OnceLock::new(), |reads, state| {
            let late = Some(Late { folder, noted });
            Writer { late, ..Writer::new(nothing, (0, GENESIS.into()), reads, state) }
        })?;
        audit.state.failing.store(true, Ordering::Relaxed);
        Ok(audit)
    }

    fn start(
        reads: OnceLock<Db>,
        writer: impl FnOnce(Arc<OnceLock<Db>>, Arc<State>) -> Writer,
    ) -> Result<Self, StoreError> {
        let (notes, queue) = channel();
        let (reads, state) = (Arc::new(reads), Arc::new(State::default()));
        let writer = writer(reads.clone(), state.clone());
        thread::Builder::new().name("lafet-audit".into()).spawn(move || writer.run(&queue))?;
        Ok(Self { notes, reads, state, checks: Arc::default() })
    }

    fn reads(&self) -> Result<&Db, StoreError> {
        self.reads.get().ok_or(StoreError::Unread)
    }

    /// Notes something. The number of the entry comes when it is on the disk; who does not wait
    /// for it loses nothing.
    pub fn note(&self, record: Record) -> oneshot::Receiver<u64> {
        let (stored, number) = oneshot::channel();
        let note = Note::new(record, Some(stored));
        if !self.state.admit(note.bytes()) {
            self.state.give_up(note.record.at_ms);
            return number;
        }
        lock(&self.state.since).get_or_insert_with(Instant::now);
        match self.notes.send(note) {
            Ok(()) => _ = self.state.noted.fetch_add(1, Ordering::Relaxed),
            // The thread has ended.
            Err(lost) => self.state.give_up(lost.0.record.at_ms),
        }
        number
    }

    /// Waits until what was noted before is on the disk: who was answered finds it in the log. Not for long, and
    /// not for a disk that takes nothing.
    async fn catch_up(&self) {
        if self.is_failing() {
            return;
        }
        let noted = self.state.noted.load(Ordering::Relaxed);
        let mut stored = self.state.stored.subscribe();
        let _ = timeout(CATCH_UP, stored.wait_for(|stored| *stored >= noted)).await;
    }

    /// The disk does not take entries just now: it refuses them, does not answer, or some were given up and
    /// that is not in the log yet.
    pub fn is_failing(&self) -> bool {
        let hangs = || lock(&self.state.since).is_some_and(|since| since.elapsed() > HANGS);
        self.state.failing.load(Ordering::Relaxed)
            || hangs()
            || lock(&self.state.given_up).is_some()
    }

    /// The disk takes no more entries, and says nothing.
    #[cfg(test)]
    pub async fn hang(&self) {
        let begin = |db: &mut Connection| db.execute_batch("BEGIN IMMEDIATE");
        self.reads().unwrap().call(begin).await.unwrap();
    }

    /// Entries that are not on the disk yet.
    pub fn waiting(&self) -> u64 {
        self.state.waiting.load(Ordering::Relaxed)
    }

    /// Entries that were given up.
    pub fn lost(&self) -> u64 {
        self.state.lost.load(Ordering::Relaxed)
    }

    /// The latest entries before a number, the latest first.
    pub async fn latest(
        &self,
        before: Option<u64>,
        limit: u32,
        monitor: Option<String>,
        user: Option<String>,
    ) -> Result<Vec<Entry>, StoreError> {
        let limit = limit as usize;
        let search = Search { before, limit, monitor, user, ..Search::default() };
        Ok(self.find(search).await?.found)
    }

    /// Looks entries up, the latest first.
    pub async fn find(&self, search: Search) -> Result<Page<Entry>, StoreError> {
        self.catch_up().await;
        self.reads()?.look(move |db| find(db, &search, SCAN_MAX)).await
    }

    /// Number of the last entry that is stored.
    pub async fn last(&self) -> Result<u64, StoreError> {
        Ok(self.head().await?.0)
    }

    /// Number and hash of the last entry that is stored.
    pub async fn head(&self) -> Result<(u64, String), StoreError> {
        self.catch_up().await;
        self.reads()?.look(|db| head(db)).await
    }

    /// Notes in the file of the log how many changes of users and tokens there were.
    pub async fn note_users(&self, users: Users) -> Result<(), StoreError> {
        self.reads()?.call(move |db| mark::note_users(db, users)).await
    }

    /// Moves what is stored into the file itself.
    pub async fn settle(&self) -> Result<(), StoreError> {
        self.reads()?.checkpoint().await
    }

    /// Entries from a number on.
    #[cfg(test)]
    pub async fn from(&self, n: u64, limit: u32) -> Result<Vec<Entry>, StoreError> {
        self.catch_up().await;
        self.reads()?.look(move |db| from(db, n, limit)).await
    }

    /// Entries from a number on for export, a line of JSON each, and the number of the next one: a piece, written on the
    /// thread that reads. `None`: there are none.
    pub async fn lines(&self, n: u64) -> Result<Option<(String, u64)>, StoreError> {
        self.catch_up().await;
        self.reads()?.look(move |db| lines(db, n, PIECE_BYTES)).await
    }

    /// Checks the whole chain, part by part, so that others can read meanwhile. It is checked once at a time, and not for
    /// more than half of the time: those who ask meanwhile share the check that begins then. One that has started goes on to
    /// its end, also if who has asked for it does not wait: others do, or ask again.
    pub async fn verify(&self) -> Result<Verified, StoreError> {
        let before = self.checks.started.load(Ordering::SeqCst);
        let mut last = self.checks.last.clone().lock_owned().await;
        if let Some(Checked { number, took, ended, result }) = &*last {
            if *number > before {
                return Ok(result.clone());
            }
            sleep(took.saturating_sub(ended.elapsed())).await;
        }
        let number = self.checks.started.fetch_add(1, Ordering::SeqCst) + 1;
        let audit = self.clone();
        let check = tokio::spawn(async move {
            let began = Instant::now();
            let result = audit.check().await?;
            let (took, ended) = (began.elapsed(), Instant::now());
            *last = Some(Checked { number, took, ended, result: result.clone() });
            Ok(result)
        });
        check.await.unwrap_or(Err(StoreError::Busy))
    }

    async fn check(&self) -> Result<Verified, StoreError> {
        let mut chain = Chain::default();
        loop {
            let (so_far, goes_on) = self.walk(chain, VERIFY_MAX).await?;
            if !goes_on {
                return Ok(so_far.result());
            }
            chain = so_far;
        }
    }

    /// Walks on along the chain, by so many entries at most, on the thread that reads: what the hub does
    /// waits for no hash. Then there are more, or this was the end, or an entry is not right.
    pub async fn walk(&self, mut chain: Chain, most: u32) -> Result<(Chain, bool), StoreError> {
        self.reads()?
            .look(move |db| {
                let entries = from(db, chain.next(), most)?;
                let goes_on = !entries.is_empty() && entries.iter().all(|entry| chain.add(entry));
                Ok((chain, goes_on))
            })
            .await
    }
}

struct Writer {
    connection: Connection,
    head: (u64, String),
    waiting: VecDeque<Note>,
    reads: Arc<OnceLock<Db>>,
    state: Arc<State>,
    /// The file that is still to be opened.
    late: Option<Late>,
}

/// A file that the disk did not let be read.
struct Late {
    folder: PathBuf,
    /// What was noted of it.
    noted: Mark,
}

impl Writer {
    fn new(
        connection: Connection,
        head: (u64, String),
        reads: Arc<OnceLock<Db>>,
        state: Arc<State>,
    ) -> Self {
        Self { connection, head, waiting: VecDeque::new(), reads, state, late: None }
    }

    /// Opens the file that could not be read, if it is the one that was noted.
    fn open_late(&mut self) -> Result<(), StoreError> {
        let Some(Late { folder, noted }) = &self.late else { return Ok(()) };
        // One that is not there is not made.
        std::fs::metadata(folder.join(FILE))?;
        let connection = open(Some(folder), FILE, SCHEMA)?;
        if !mark::check_late(&connection, noted)? {
            let other = said_corrupt("it is not the file that was noted before");
            return Err(StoreError::File(folder.join(FILE), other));
        }
        bring_up_to_date(&connection)?;
        let reads = open(Some(folder), FILE, SCHEMA)?;
        [&connection, &reads].into_iter().try_for_each(keep_little)?;
        let reads = Db::new("audit-read", reads)?;
        (self.head, self.connection, self.late) = (head(&connection)?, connection, None);
        _ = self.reads.set(reads);
        tracing::info!(waiting = self.waiting.len(), "the audit log can be read again");
        Ok(())
    }

    /// Takes an entry. What cannot be stored for want of a file is in the program's log as well.
    fn take(&mut self, note: Note) {
        if self.late.is_some() {
            let entry = serde_json::to_string(&note.record()).unwrap_or_default();
            tracing::info!(entry, "entry of the audit log, which cannot be read");
        }
        self.waiting.push_back(note);
    }

    fn run(mut self, notes: &Receiver<Note>) {
        loop {
            let note = if self.waiting.is_empty() && self.late.is_none() {
                notes.recv().map_err(|_| RecvTimeoutError::Disconnected)
            } else {
                notes.recv_timeout(AGAIN)
            };
            match note {
                Ok(note) => self.take(note),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    _ = self.store_all();
                    return;
                }
            }
            notes.try_iter().take(BATCH_MAX).for_each(|note| self.take(note));
            let opened = self.open_late();
            let stored =
                opened.and_then(|()| Ok(self.store_all().and_then(|()| self.store_gap())?));
            let failing = stored.is_err();
            if let Err(error) = stored
                && !self.state.failing.load(Ordering::Relaxed)
            {
                tracing::error!(%error, waiting = self.waiting.len(), "audit log is not stored");
            }
            self.state.failing.store(failing, Ordering::Relaxed);
        }
    }

    /// Stores all that waits: what a disk has not taken for a time does not wait for more to come.
    fn store_all(&mut self) -> Result<(), rusqlite::Error> {
        while !self.waiting.is_empty() {
            self.store()?;
        }
        Ok(())
    }

    /// Stores, in its order, that entries were given up.
    fn store_gap(&mut self) -> Result<(), rusqlite::Error> {
        // What waits came before.
        if !self.waiting.is_empty() {
            return Ok(());
        }
        let Some(record) = self.state.gap() else { return Ok(()) };
        let note = Note::new(record, None);
        self.state.enter(note.bytes());
        self.waiting.push_back(note);
        self.store()
    }

    /// Stores what waits, in one transaction.
    fn store(&mut self) -> Result<(), rusqlite::Error> {
        let count = self.waiting.len().min(BATCH_MAX);
        let (mut n, mut prev) = self.head.clone();
        let transaction = self.connection.transaction()?;
        for note in self.waiting.iter().take(count) {
            n += 1;
            let entry = Entry::new(n, note.record(), prev);
            insert(&transaction, &entry)?;
            prev = entry.hash;
        }
        transaction.commit()?;
        let first = self.head.0;
        self.head = (n, prev);
        let mut noted = 0;
        for (number, note) in (first + 1..).zip(self.waiting.drain(..count)) {
            self.state.release(note.bytes());
            if let Some(stored) = note.stored {
                noted += 1;
                _ = stored.send(number);
            }
        }
        self.state.stored.send_modify(|stored| *stored += noted);
        let mut since = lock(&self.state.since);
        *since = (self.state.waiting.load(Ordering::Relaxed) > 0).then(Instant::now);
        Ok(())
    }
}

impl Entry {
    fn new(n: u64, record: Record, prev: String) -> Self {
        let hash = hash(n, &record, &prev);
        Self { n, record, prev, hash }
    }

    /// As the API shows it: without an act that this version does not know, which `what` has in
    /// words.
    #[must_use]
    pub fn shown(mut self) -> Self {
        self.record.act.take_if(|act| Act::from_value(act).is_none());
        self
    }
}

/// A file of an earlier version has no columns for kind and act.
fn bring_up_to_date(db: &Connection) -> Result<(), rusqlite::Error> {
    let columns = "SELECT COUNT(*) FROM pragma_table_info('audit')";
    if db.query_row(columns, [], |row| row.get::<_, i64>(0))? < 15 {
        db.execute_batch(
            "ALTER TABLE audit ADD COLUMN kind TEXT; ALTER TABLE audit ADD COLUMN act TEXT;",
        )?;
    }
    Ok(())
}

/// Looks entries up among the latest so many before the number of the search.
fn find(db: &Connection, search: &Search, most: i64) -> Result<Page<Entry>, rusqlite::Error> {
    let mut query = db.prepare_cached(
        "SELECT * FROM audit WHERE n < ?1 AND n >= ?6 AND (?2 IS NULL OR monitor = ?2 OR (monitor = '*' AND ?2 <> ''))
         AND (?3 IS NULL OR user = ?3) AND at_ms BETWEEN ?4 AND ?5 ORDER BY n DESC",
    )?;
    let (before, from_ms, to_ms) = search.bounds();
    let before = before.min(signed(head(db)?.0).saturating_add(1));
    let first = before.saturating_sub(most);
    let values = params![before, search.monitor, search.user, from_ms, to_ms, first];
    let rows = query.query_map(values, entry)?;
    let page = search.page(rows, |it| it.n, text)?;
    let rest = (first > 1).then(|| unsigned(first));
    Ok(Page { next: page.next.or(rest), ..page })
}

/// Entries from a number on.
fn from(db: &Connection, n: u64, limit: u32) -> Result<Vec<Entry>, rusqlite::Error> {
    let n = i64::try_from(n).unwrap_or(i64::MAX);
    let mut query = db.prepare_cached("SELECT * FROM audit WHERE n >= ?1 ORDER BY n LIMIT ?2")?;
    query.query_map(params![n, limit], entry)?.collect()
}

/// Entries from a number on, a line each, until they have so many bytes; and the number of the next one.
fn lines(
    db: &Connection,
    n: u64,
    bytes_max: usize,
) -> Result<Option<(String, u64)>, rusqlite::Error> {
    let mut query = db.prepare_cached("SELECT * FROM audit WHERE n >= ?1 ORDER BY n")?;
    let mut entries = query.query_map([signed(n)], entry)?;
    let (mut text, mut next) = (String::new(), None);
    while text.len() < bytes_max
        && let Some(entry) = entries.next().transpose()?
    {
        next = Some(entry.n + 1);
        text += &serde_json::to_string(&entry).unwrap_or_default();
        text.push('\n');
    }
    Ok(next.map(|next| (text, next)))
}

/// Number and hash of the last entry.
pub fn head(db: &Connection) -> Result<(u64, String), rusqlite::Error> {
    let last = db
        .query_row("SELECT n, hash FROM audit ORDER BY n DESC LIMIT 1", [], |row| {
            Ok((unsigned(row.get(0)?), row.get(1)?))
        })
        .optional()?;
    Ok(last.unwrap_or((0, GENESIS.into())))
}

/// What a search looks through.
fn text(entry: &Entry) -> String {
    let it = &entry.record;
    [&it.user, &it.from, &it.monitor, &it.what, &it.outcome, &it.details.to_string()]
        .map(String::as_str)
        .join(" ")
}

fn insert(db: &Connection, entry: &Entry) -> Result<(), rusqlite::Error> {
    let it = &entry.record;
    db.prepare_cached(
        "INSERT INTO audit VALUES (?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11,?12,?13,?14,?15)",
    )?
    .execute(params![
        signed(entry.n),
        signed(it.at_ms),
        it.user,
        it.role,
        it.from,
        it.via,
        it.seat,
        it.monitor,
        it.what,
        it.outcome,
        it.details.to_string(),
        entry.prev,
        entry.hash,
        it.kind.map(Kind::name),
        it.act.as_ref().map(Value::to_string),
    ])
    .map(|_| ())
}

fn entry(row: &Row<'_>) -> Result<Entry, rusqlite::Error> {
    let details: String = row.get(10)?;
    let (kind, act): (Option<String>, Option<String>) = (row.get(13)?, row.get(14)?);
    Ok(Entry {
        n: unsigned(row.get(0)?),
        record: Record {
            at_ms: unsigned(row.get(1)?),
            user: row.get(2)?,
            role: row.get(3)?,
            from: row.get(4)?,
            via: row.get(5)?,
            seat: row.get(6)?,
            monitor: row.get(7)?,
            what: row.get(8)?,
            outcome: row.get(9)?,
            details: serde_json::from_str(&details).unwrap_or(Value::String(details)),
            kind: kind.as_deref().and_then(Kind::by_name),
            act: act.map(|act| serde_json::from_str(&act).unwrap_or(Value::String(act))),
        },
        prev: row.get(11)?,
        hash: row.get(12)?,
    })
}

fn signed(number: u64) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}

fn unsigned(number: i64) -> u64 {
    u64::try_from(number).unwrap_or(0)
}

#[cfg(test)]
#[path = "audit_tests.rs"]
mod tests;
