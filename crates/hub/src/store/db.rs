//! A database on a thread of its own: nothing that must be quick waits for a disk.

use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use lafet_client::SystemError;
use lafet_texts::{Argument, Lang, Shown, Text, hub as text};
use rusqlite::Connection;
use tokio::sync::oneshot;
use tokio::time::timeout;

use super::format::{FORMAT, Newer};
use super::mark::{Loss, StateFile, TABLE};
use crate::text::Both;

/// Work that may wait for the disk; more is refused.
const QUEUE_MAX: usize = 1024;

/// A connection waits so long for another one.
const BUSY_WAIT: Duration = Duration::from_secs(5);
/// Who reads waits so long for the disk.
pub const READ_WAIT: Duration = Duration::from_secs(5);
/// What a connection keeps of a file that only reads, or only appends, KiB: the system keeps the rest, and takes it
/// back when it needs memory.
const LITTLE_KIB: i64 = 512;
/// A checkpoint waits so long for a connection that reads.
const CHECKPOINT_WAIT: Duration = Duration::from_secs(2);

type Work = Box<dyn FnOnce(&mut Connection) + Send>;

/// A database: a connection that writes, and one that reads, each on a thread of its own, so that
/// no question holds up what is to be stored. In memory there is one for both.
#[derive(Clone, Debug)]
pub struct Db {
    work: SyncSender<Work>,
    reading: SyncSender<Work>,
}

/// Why something could not be stored or read.
#[derive(Debug)]
pub enum StoreError {
    /// Error of SQLite.
    Sqlite(rusqlite::Error),
    /// Error of PostgreSQL.
    #[cfg(feature = "postgres")]
    Postgres(tokio_postgres::Error),
    /// PostgreSQL does not answer.
    Away,
    /// The disk is so slow that too much waits.
    Busy,
    /// The disk did not let the file be read when the hub started.
    Unread,
    /// Two hubs with one audit log would lose entries.
    InUse(std::path::PathBuf),
    /// A newer program wrote the state.
    Newer(Newer),
    /// Files of the state are lost or changed, and that is not accepted.
    Lost(Vec<Loss>),
    /// The stored state of the zones does not fit.
    Zones(Both),
    /// Others have business in the folder.
    Shared(std::path::PathBuf),
    /// A new folder on a disk that takes nothing.
    NoRoom(std::path::PathBuf, std::io::Error),
    /// What SQLite says of a file.
    File(std::path::PathBuf, rusqlite::Error),
    /// What the system says of a file that the hub needs.
    Unusable(std::path::PathBuf, std::io::Error),
    /// The folder cannot be used.
    Io(std::io::Error),
}

impl Argument for StoreError {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match self {
            Self::Sqlite(error) => text::StoreEngine { error: Shown(error) }.write(lang, out),
            #[cfg(feature = "postgres")]
            Self::Postgres(error) => out.write_str(&super::postgres::said(error)),
            Self::Away => text::StoreAway.write(lang, out),
            Self::Busy => text::StoreBusy.write(lang, out),
            Self::Unread => text::StoreUnread.write(lang, out),
            Self::InUse(folder) => {
                text::StoreInUse { folder: Shown(folder.display()) }.write(lang, out)
            }
            Self::Newer(newer) => out.write_str(newer.words().of(lang)),
            Self::Lost(losses) => {
                let all: Vec<String> = losses.iter().map(|it| it.both().of(lang).into()).collect();
                out.write_str(&all.join(" "))
            }
            Self::Zones(wrong) => wrong.write(lang, out),
            Self::Shared(folder) => {
                text::StoreShared { folder: Shown(folder.display()) }.write(lang, out)
            }
            Self::NoRoom(folder, error) => {
                let (folder, error) = (Shown(folder.display()), SystemError(error));
                text::StoreNoRoom { folder, error }.write(lang, out)
            }
            Self::File(file, error) => {
                let error = text::StoreEngine { error: Shown(error) };
                text::StoreFile { file: Shown(file.display()), error }.write(lang, out)
            }
            Self::Unusable(file, error) => {
                let error = SystemError(error);
                text::StoreFile { file: Shown(file.display()), error }.write(lang, out)
            }
            Self::Io(error) => SystemError(error).write(lang, out),
        }
    }
}

impl Text for StoreError {}

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(Lang::En, f)
    }
}

impl std::error::Error for StoreError {}

impl From<rusqlite::Error> for StoreError {
    fn from(error: rusqlite::Error) -> Self {
        Self::Sqlite(error)
    }
}

#[cfg(feature = "postgres")]
impl From<tokio_postgres::Error> for StoreError {
    fn from(error: tokio_postgres::Error) -> Self {
        Self::Postgres(error)
    }
}

impl From<std::io::Error> for StoreError {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}

/// Takes a folder for this hub, as long as the file is open; the end of the program, whatever it
/// is, gives it back.
pub fn occupy(folder: &Path) -> Result<std::fs::File, StoreError> {
    make(folder)?;
    close_to_others(folder)?;
    private(&folder.join("lock"))?;
    let file = std::fs::File::create(folder.join("lock"))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(std::fs::TryLockError::WouldBlock) => Err(StoreError::InUse(folder.to_owned())),
        Err(std::fs::TryLockError::Error(error)) => Err(error.into()),
    }
}

/// Makes the folder of the state, readable by its owner alone.
fn make(folder: &Path) -> std::io::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    let mut builder = std::fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.recursive(true).create(folder)
}

/// The folder and the files in it are the hub's alone. A folder that others may enter is closed to
/// them, unless it holds other things, as /tmp does: then its files are, and where others may write,
/// who could replace them, it is refused.
#[cfg(unix)]
fn close_to_others(folder: &Path) -> Result<(), StoreError> {
    use std::os::unix::fs::PermissionsExt;
    let mode = std::fs::metadata(folder)?.permissions().mode();
    if mode & 0o077 != 0 {
        let mut names = std::fs::read_dir(folder)?.filter_map(Result::ok).map(|it| it.file_name());
        let own = names.all(|name| is_ours(&name.to_string_lossy()));
        if !own && mode & 0o022 != 0 {
            return Err(StoreError::Shared(folder.to_owned()));
        }
        let (folder_name, mode_text) = (folder.display(), format!("{:o}", mode & 0o7777));
        tracing::warn!(folder = %folder_name, mode = mode_text, "other users can look into it");
        if own {
            std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o700))?;
        }
    }
    close_files(folder, private)
}

/// Closes the files of the hub to others. A copy of one, which another user may have made, is not needed: if it
/// cannot be closed the hub works all the same.
#[cfg(unix)]
fn close_files(
    folder: &Path,
    close: impl Fn(&Path) -> std::io::Result<()>,
) -> Result<(), StoreError> {
    for entry in std::fs::read_dir(folder)?.filter_map(Result::ok) {
        let (path, name) = (entry.path(), entry.file_name());
        let name = name.to_string_lossy();
        if !is_ours(&name) || !entry.file_type().is_ok_and(|it| it.is_file()) {
            continue;
        }
        match close(&path) {
            Err(error) if is_needed(&name) => return Err(StoreError::Unusable(path, error)),
            Err(error) => tracing::warn!(file = %path.display(), %error, "not closed to others"),
            Ok(()) => {}
        }
    }
    Ok(())
}

/// Other systems have other means.
#[cfg(not(unix))]
fn close_to_others(_: &Path) -> Result<(), StoreError> {
    Ok(())
}

/// What the hub writes into its folder, beside the files of its state.
const BESIDE: [&str; 6] = ["lock", "recordings", "reserve", "reserve.probe", "revoked", "tune"];

/// Whether the hub writes a file of this name into its folder, or has moved one aside.
fn is_ours(name: &str) -> bool {
    let of = |file: &StateFile| name.starts_with(file.name());
    BESIDE.contains(&name) || StateFile::ALL.iter().any(of)
}

/// Whether the hub works with a file of this name, and not with a copy.
#[cfg(unix)]
fn is_needed(name: &str) -> bool {
    let own = ["", "-wal", "-shm", "-journal"];
    let of = |file: &StateFile| name.strip_prefix(file.name()).is_some_and(|it| own.contains(&it));
    BESIDE.contains(&name) || StateFile::ALL.iter().any(of)
}

/// Replaces a file by way of another beside it, whole or not at all: a full disk or a power cut leaves what
/// was there.
pub fn replace(path: &Path, beside: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = std::fs::File::create(beside)?;
    let written = file.write_all(bytes).and_then(|()| file.sync_all());
    let replaced = written.and_then(|()| std::fs::rename(beside, path));
    if replaced.is_err() {
        _ = std::fs::remove_file(beside);
    }
    replaced
}

/// Makes a file, or one that is there, its owner's alone.
pub fn private(path: &Path) -> std::io::Result<()> {
    let mut options = std::fs::OpenOptions::new();
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let file = options.append(true).create(true).open(path)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = file.metadata()?.permissions().mode();
        if mode & 0o077 != 0 {
            file.set_permissions(std::fs::Permissions::from_mode(mode & 0o700))?;
        }
    }
    drop(file);
    Ok(())
}

/// Opens `name` in a folder, or in memory.
pub fn open(folder: Option<&Path>, name: &str, schema: &str) -> Result<Connection, StoreError> {
    let Some(folder) = folder else {
        return Ok(prepare(Connection::open_in_memory()?, schema)?);
    };
    make(folder)?;
    let path = folder.join(name);
    // SQLite gives the files beside it the same mode.
    private(&path)?;
    let opened = Connection::open(&path).and_then(|connection| prepare(connection, schema));
    opened.map_err(|error| StoreError::File(path, error))
}

/// Moves a file of the state aside, with what SQLite has beside it. Nothing is deleted or overwritten: the
/// new name has the time, and a number if there is one of that time.
///
/// # Errors
/// The folder does not let it: nothing was moved, or SQLite's own files alone.
pub fn set_aside(path: &Path) -> std::io::Result<PathBuf> {
    let now = time::OffsetDateTime::now_utc();
    let (date, hour) = (now.date(), now.time());
    let stamp = format!(
        "{}{:02}{:02}T{:02}{:02}{:02}Z",
        date.year(),
        u8::from(date.month()),
        date.day(),
        hour.hour(),
        hour.minute(),
        hour.second()
    );
    let with = |path: &Path, end: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(end);
        PathBuf::from(name)
    };
    let is_free = |it: &PathBuf| ["", "-wal", "-shm"].iter().all(|end| !with(it, end).exists());
    let named = |number: u32| match number {
        1 => with(path, &format!(".spoilt-{stamp}")),
        _ => with(path, &format!(".spoilt-{stamp}-{number}")),
    };
    let aside = (1..).map(named).find(is_free).unwrap_or_default();
    // Last the file itself: as long as it is there the next start finds it and goes on.
    for end in ["-wal", "-shm", ""] {
        match std::fs::rename(with(path, end), with(&aside, end)) {
            Err(error) if end.is_empty() || error.kind() != std::io::ErrorKind::NotFound => {
                return Err(error);
            }
            _ => {}
        }
    }
    tracing::error!(file = %path.display(), aside = %aside.display(), "put aside");
    Ok(aside)
}

/// As [`open`]; a corrupt file is moved aside: the hub works without its contents.
pub fn open_or_begin_anew(
    folder: Option<&Path>,
    name: &str,
    schema: &str,
) -> Result<Connection, StoreError> {
    match (open(folder, name, schema), folder) {
        (Err(StoreError::File(path, error)), Some(_)) if is_corrupt(&error) => {
            tracing::error!(file = %path.display(), %error, "cannot be read");
            set_aside(&path)?;
            open(folder, name, schema)
        }
        (opened, _) => opened,
    }
}

/// The file is no database, or only part of one.
pub fn is_corrupt(error: &rusqlite::Error) -> bool {
    use rusqlite::ErrorCode::{DatabaseCorrupt, NotADatabase};
    matches!(error.sqlite_error_code(), Some(DatabaseCorrupt | NotADatabase))
}

/// The disk, or the way to it, does not let a file be read or written: that says nothing of what the file has.
pub fn is_of_disk(error: &rusqlite::Error) -> bool {
    error.sqlite_error_code() == Some(rusqlite::ErrorCode::SystemIoFailure)
}

impl StoreError {
    /// The disk, or the way to it, does not let a file be read or written.
    pub fn is_of_disk(&self) -> bool {
        matches!(self, Self::Sqlite(error) | Self::File(_, error) if is_of_disk(error))
    }
}

/// As [`is_corrupt`], or it is one of another program: tables, columns or values are not those of the hub.
pub fn is_malformed(error: &rusqlite::Error) -> bool {
    use rusqlite::Error;
    let other = matches!(error.sqlite_error_code(), Some(rusqlite::ErrorCode::Unknown));
    let value = matches!(
        error,
        Error::InvalidColumnType(..)
            | Error::FromSqlConversionFailure(..)
            | Error::IntegralValueOutOfRange(..)
            | Error::InvalidColumnName(_)
            | Error::Utf8Error(..)
            | Error::SqlInputError { .. }
    );
    other || value || is_corrupt(error)
}

/// Moves everything from SQLite's log into the database, so that a copy of the file alone is whole.
///
/// # Errors
/// The disk does not take it, or another connection is reading for longer than [`CHECKPOINT_WAIT`].
pub fn checkpoint(db: &Connection) -> Result<(), rusqlite::Error> {
    db.busy_timeout(CHECKPOINT_WAIT)?;
    let query = "PRAGMA wal_checkpoint(TRUNCATE)";
    let busy = db.query_row(query, [], |row| row.get::<_, i64>(0));
    db.busy_timeout(BUSY_WAIT)?;
    match busy? {
        0 => Ok(()),
        _ => {
            let code = rusqlite::ffi::Error::new(rusqlite::ffi::SQLITE_BUSY);
            Err(rusqlite::Error::SqliteFailure(code, Some("it is being read".to_owned())))
        }
    }
}

/// An error that says so.
pub fn said_corrupt(what: &str) -> rusqlite::Error {
    let code = rusqlite::ffi::Error::new(rusqlite::ffi::SQLITE_CORRUPT);
    rusqlite::Error::SqliteFailure(code, Some(what.to_owned()))
}

fn prepare(connection: Connection, schema: &str) -> Result<Connection, rusqlite::Error> {
    connection.pragma_update(None, "journal_mode", "WAL")?;
    connection.pragma_update(None, "foreign_keys", true)?;
    connection.busy_timeout(BUSY_WAIT)?;
    connection.execute_batch(TABLE)?;
    connection.execute_batch(schema)?;
    let format: u32 = connection.pragma_query_value(None, "user_version", |row| row.get(0))?;
    if format < FORMAT {
        connection.pragma_update(None, "user_version", FORMAT)?;
    }
    Ok(connection)
}

impl Db {
    /// In the place of a file that the disk does not let be read: nothing is taken, nothing is found.
    pub fn unread() -> Self {
        let (work, _) = sync_channel(0);
        Self { reading: work.clone(), work }
    }

    /// Gives a connection its thread, and beside it one to read with.
    pub fn new(name: &str, connection: Connection) -> Result<Self, StoreError> {
        let reader = match connection.path() {
            Some(path) if !path.is_empty() => Some(reader(path)?),
            _ => None,
        };
        let Some(reader) = reader else {
            let (work, _) = serve(format!("lafet-{name}"), connection, None)?;
            return Ok(Self { reading: work.clone(), work });
        };
        let (reading, reader) = serve(format!("lafet-{name}-r"), reader, None)?;
        let (work, _) = serve(format!("lafet-{name}"), connection, Some(reader))?;
        Ok(Self { work, reading })
    }

    /// Does something with the database, and waits for the result.
    pub async fn call<T: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Connection) -> Result<T, rusqlite::Error> + Send + 'static,
    ) -> Result<T, StoreError> {
        ask(&self.work, work).await
    }

    /// Reads, beside what is being written: it sees what was stored before. A disk that hangs is not waited for.
    pub async fn read<T: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Connection) -> Result<T, rusqlite::Error> + Send + 'static,
    ) -> Result<T, StoreError> {
        ask_in_time(&self.reading, work).await
    }

    /// As [`Db::read`], after what was asked before of the connection that writes.
    pub async fn look<T: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Connection) -> Result<T, rusqlite::Error> + Send + 'static,
    ) -> Result<T, StoreError> {
        ask_in_time(&self.work, work).await
    }

    /// As `checkpoint`, after what was asked before.
    pub async fn checkpoint(&self) -> Result<(), StoreError> {
        self.call(|db| checkpoint(db)).await
    }

    /// Keeps its thread busy until what is returned is dropped; nothing of that is in the queue any more.
    #[cfg(test)]
    pub fn hang(&self) -> std::sync::mpsc::Sender<()> {
        let (go, hung) = std::sync::mpsc::channel::<()>();
        let (began, hangs) = std::sync::mpsc::channel();
        assert!(self.post(move |_| _ = began.send(()).map(|()| hung.recv())));
        hangs.recv().unwrap();
        go
    }

    /// Does something, and waits for nothing; `false`: it was not taken.
    pub fn post(&self, work: impl FnOnce(&mut Connection) + Send + 'static) -> bool {
        !matches!(
            self.work.try_send(Box::new(work)),
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_))
        )
    }
}

fn reader(path: &str) -> Result<Connection, rusqlite::Error> {
    let reader = Connection::open(path)?;
    reader.pragma_update(None, "query_only", true)?;
    reader.busy_timeout(BUSY_WAIT)?;
    keep_little(&reader)?;
    Ok(reader)
}

/// Lets a connection that only reads, or only appends, keep little of the file.
pub fn keep_little(connection: &Connection) -> Result<(), rusqlite::Error> {
    connection.pragma_update(None, "cache_size", -LITTLE_KIB)
}

/// The connection's thread ends when nothing can ask it any more. Of two connections that are closed
/// at once neither would remove SQLite's `-wal`, so `other` is closed first.
fn serve(
    name: String,
    mut connection: Connection,
    other: Option<JoinHandle<()>>,
) -> Result<(SyncSender<Work>, JoinHandle<()>), StoreError> {
    let (work, queue) = sync_channel::<Work>(QUEUE_MAX);
    let thread = thread::Builder::new().name(name).spawn(move || {
        while let Ok(work) = queue.recv() {
            work(&mut connection);
        }
        if let Some(other) = other {
            _ = other.join();
        }
    })?;
    Ok((work, thread))
}

async fn ask<T: Send + 'static>(
    queue: &SyncSender<Work>,
    work: impl FnOnce(&mut Connection) -> Result<T, rusqlite::Error> + Send + 'static,
) -> Result<T, StoreError> {
    let result = submit(queue, true, work)?;
    Ok(result.await.map_err(|_| StoreError::Busy)??)
}

/// As [`ask`], for [`READ_WAIT`]; what no one waits for any more is left out.
async fn ask_in_time<T: Send + 'static>(
    queue: &SyncSender<Work>,
    work: impl FnOnce(&mut Connection) -> Result<T, rusqlite::Error> + Send + 'static,
) -> Result<T, StoreError> {
    let result = submit(queue, false, work)?;
    let result = timeout(READ_WAIT, result).await.map_err(|_| StoreError::Busy)?;
    Ok(result.map_err(|_| StoreError::Busy)??)
}

/// Puts work into the queue; it is done `always`, or only if its result is still waited for.
fn submit<T: Send + 'static>(
    queue: &SyncSender<Work>,
    always: bool,
    work: impl FnOnce(&mut Connection) -> Result<T, rusqlite::Error> + Send + 'static,
) -> Result<oneshot::Receiver<Result<T, rusqlite::Error>>, StoreError> {
    let (reply, result) = oneshot::channel();
    let work: Work = Box::new(move |connection| {
        if always || !reply.is_closed() {
            _ = reply.send(work(connection));
        }
    });
    queue.try_send(work).map_err(|error| match error {
        TrySendError::Full(_) => StoreError::Busy,
        TrySendError::Disconnected(_) => StoreError::Unread,
    })?;
    Ok(result)
}

/// How SQLite finds what a statement is about.
#[cfg(test)]
pub fn plan(db: &Connection, sql: &str) -> Result<Vec<String>, rusqlite::Error> {
    let mut query = db.prepare(&format!("EXPLAIN QUERY PLAN {sql}"))?;
    query.raw_query().mapped(|row| row.get(3)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_hub_and_is_nobody_elses_business() {
        let folder = std::env::temp_dir().join(format!("lafet-folder-{}", std::process::id()));
        let first = occupy(&folder).unwrap();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::metadata(&folder).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o700);
        }
        let second = occupy(&folder).unwrap_err();
        assert!(matches!(&second, StoreError::InUse(it) if *it == folder), "{second}");
        drop(first);
        drop(occupy(&folder).unwrap());
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[tokio::test]
    async fn a_question_that_takes_long_holds_up_nothing_that_is_stored() {
        let folder = std::env::temp_dir().join(format!("lafet-readers-{}", std::process::id()));
        let schema = "CREATE TABLE IF NOT EXISTS t (n INTEGER) STRICT;";
        let db = Db::new("test", open(Some(&folder), "a.db", schema).unwrap()).unwrap();
        db.call(|db| db.execute("INSERT INTO t VALUES (1)", [])).await.unwrap();
        let (go, wait) = std::sync::mpsc::channel::<()>();
        let count = |db: &Connection| db.query_row("SELECT COUNT(*) FROM t", [], |row| row.get(0));
        let reader = db.clone();
        let long = tokio::spawn(async move {
            let read = reader.read(move |db| {
                let snapshot = db.transaction()?;
                let before: i64 = count(&snapshot)?;
                // Until the writer has written.
                let written = wait.recv_timeout(std::time::Duration::from_secs(30));
                assert!(written.is_ok(), "writing waits for this");
                Ok((before, count(&snapshot)?))
            });
            read.await.unwrap()
        });
        db.call(|db| db.execute("INSERT INTO t VALUES (2)", [])).await.unwrap();
        db.call(|db| db.execute("INSERT INTO t VALUES (3)", [])).await.unwrap();
        go.send(()).unwrap();
        let (before, after) = long.await.unwrap();
        assert_eq!(before, after);
        assert_eq!(db.read(move |db| count(db)).await.unwrap(), 3);
        let refused = db.read(|db| db.execute("INSERT INTO t VALUES (4)", [])).await;
        assert!(refused.is_err(), "what reads does not write");
        let kept = |db: &mut Connection| {
            db.pragma_query_value(None, "cache_size", |row| row.get::<_, i64>(0))
        };
        assert_eq!(db.read(kept).await.unwrap(), -LITTLE_KIB);
        drop(db);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    /// Assumed: root has copied a file of the state, or it is read-only.
    #[cfg(unix)]
    #[test]
    fn a_copy_that_cannot_be_closed_keeps_no_hub_from_starting() {
        let folder = std::env::temp_dir().join(format!("lafet-copies-{}", std::process::id()));
        let refuse = |_: &Path| Err(std::io::ErrorKind::PermissionDenied.into());
        for (name, needed) in [
            ("audit.db.2026-01", false),
            ("hub.db.spoilt-20261128T115959Z-wal", false),
            ("site.json~", false),
            ("another program's", false),
            ("audit.db", true),
            ("hub.db-wal", true),
            ("lock", true),
        ] {
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join(name), "").unwrap();
            match close_files(&folder, refuse) {
                Ok(()) => assert!(!needed, "{name}"),
                Err(error) => assert!(needed && error.to_string().contains(name), "{error}"),
            }
            std::fs::remove_dir_all(&folder).unwrap();
        }
    }

    /// Assumed: the disk hangs. The time is the test's own.
    #[tokio::test(start_paused = true)]
    async fn who_reads_does_not_wait_for_a_disk_that_hangs() {
        let db = Db::new("test", Connection::open_in_memory().unwrap()).unwrap();
        let go = db.hang();
        let (done, looked) = std::sync::mpsc::channel();
        let again = done.clone();
        let read = db.read(move |_| {
            _ = done.send(());
            Ok(())
        });
        assert!(matches!(read.await, Err(StoreError::Busy)));
        let look = db.look(move |_| {
            _ = again.send(());
            Ok(())
        });
        assert!(matches!(look.await, Err(StoreError::Busy)));
        go.send(()).unwrap();
        db.call(|_| Ok(())).await.unwrap();
        assert!(looked.try_recv().is_err(), "no one waits for it any more");
    }

    #[test]
    fn a_spoilt_file_is_put_aside_where_the_hub_can_work_without_it() {
        let folder = std::env::temp_dir().join(format!("lafet-spoilt-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let schema = "CREATE TABLE IF NOT EXISTS t (n INTEGER) STRICT;";
        for name in ["a.db", "b.db"] {
            std::fs::write(folder.join(name), "no database, and never was".repeat(100)).unwrap();
        }
        let error = open(Some(&folder), "a.db", schema).unwrap_err().to_string();
        assert!(error.contains("a.db: ") && error.contains("not a database"), "{error}");
        let anew = open_or_begin_anew(Some(&folder), "b.db", schema).unwrap();
        anew.execute("INSERT INTO t VALUES (1)", []).unwrap();
        drop(anew);
        // A second time at once: the first one stays.
        std::fs::write(folder.join("b.db"), "corrupt again").unwrap();
        std::fs::write(folder.join("b.db-wal"), "its log").unwrap();
        set_aside(&folder.join("b.db")).unwrap();
        let mut kept: Vec<String> = std::fs::read_dir(&folder)
            .unwrap()
            .map(|it| it.unwrap().path())
            .filter(|it| it.file_name().unwrap().to_string_lossy().starts_with("b.db.spoilt-2"))
            .filter(|it| it.is_file())
            .map(|it| std::fs::read_to_string(it).unwrap())
            .collect();
        kept.sort();
        let first = "no database, and never was".repeat(100);
        assert_eq!(kept, ["corrupt again".to_owned(), "its log".to_owned(), first]);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
