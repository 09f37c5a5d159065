//! A database on a thread of its own: nothing that must be quick waits for a disk.

use std::path::Path;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread;

use rusqlite::Connection;
use tokio::sync::oneshot;

/// Work that may wait for the disk; more is refused.
const QUEUE_MAX: usize = 1024;

type Work = Box<dyn FnOnce(&mut Connection) + Send>;

/// A database.
#[derive(Clone, Debug)]
pub struct Db {
    work: SyncSender<Work>,
}

/// Why something could not be stored or read.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// What SQLite says.
    #[error("{0}")]
    Sqlite(#[from] rusqlite::Error),
    /// What PostgreSQL says.
    #[error("{}", said(.0))]
    Postgres(#[from] tokio_postgres::Error),
    /// PostgreSQL does not answer.
    #[error("PostgreSQL does not answer")]
    Away,
    /// The disk is so slow that too much waits.
    #[error("too much waits for the disk")]
    Busy,
    /// Two hubs with one audit log would lose entries.
    #[error("another hub uses {}", .0.display())]
    InUse(std::path::PathBuf),
    /// What SQLite says of a file.
    #[error("{}: {}", .0.display(), .1)]
    File(std::path::PathBuf, rusqlite::Error),
    /// The folder cannot be used.
    #[error("{0}")]
    Io(#[from] std::io::Error),
}

/// Takes a folder for this hub, as long as the file is open; the end of the program, whatever it
/// is, gives it back.
pub fn occupy(folder: &Path) -> Result<std::fs::File, StoreError> {
    make(folder)?;
    let file = std::fs::File::create(folder.join("lock"))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(std::fs::TryLockError::WouldBlock) => Err(StoreError::InUse(folder.to_owned())),
        Err(std::fs::TryLockError::Error(error)) => Err(error.into()),
    }
}

/// Makes the folder of the state: who is nobody's user here has no business in it.
fn make(folder: &Path) -> std::io::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    let mut builder = std::fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    let made = builder.recursive(true).create(folder);
    made.map_err(|error| {
        std::io::Error::new(error.kind(), format!("{}: {error}", folder.display()))
    })
}

/// What PostgreSQL says, with its reasons: an error of its own names the kind alone.
pub fn said(error: &tokio_postgres::Error) -> String {
    let mut text = error.to_string();
    let mut reason = std::error::Error::source(error);
    while let Some(why) = reason {
        text = format!("{text}: {why}");
        reason = why.source();
    }
    text
}

/// Opens `name` in a folder, or in memory.
pub fn open(folder: Option<&Path>, name: &str, schema: &str) -> Result<Connection, StoreError> {
    let Some(folder) = folder else {
        return Ok(prepare(Connection::open_in_memory()?, schema)?);
    };
    make(folder)?;
    let path = folder.join(name);
    let opened = Connection::open(&path).and_then(|connection| prepare(connection, schema));
    opened.map_err(|error| StoreError::File(path, error))
}

/// As [`open`]; a file that a disk has spoilt is put aside, for without what is in it the hub can
/// work, and without the hub nobody can.
pub fn open_or_begin_anew(
    folder: Option<&Path>,
    name: &str,
    schema: &str,
) -> Result<Connection, StoreError> {
    use rusqlite::ErrorCode::{DatabaseCorrupt, NotADatabase};
    match (open(folder, name, schema), folder) {
        (Err(StoreError::File(path, error)), Some(_))
            if matches!(error.sqlite_error_code(), Some(DatabaseCorrupt | NotADatabase)) =>
        {
            let aside = path.with_extension("db.spoilt");
            tracing::error!(file = %path.display(), aside = %aside.display(), %error, "put aside");
            std::fs::rename(&path, &aside)?;
            for rest in ["db-wal", "db-shm"] {
                _ = std::fs::remove_file(path.with_extension(rest));
            }
            open(folder, name, schema)
        }
        (opened, _) => opened,
    }
}

fn prepare(connection: Connection, schema: &str) -> Result<Connection, rusqlite::Error> {
    connection.pragma_update(None, "journal_mode", "WAL")?;
    connection.pragma_update(None, "foreign_keys", true)?;
    connection.busy_timeout(std::time::Duration::from_secs(5))?;
    connection.execute_batch(schema)?;
    Ok(connection)
}

impl Db {
    /// Gives a connection its thread.
    pub fn new(name: &str, mut connection: Connection) -> Result<Self, StoreError> {
        let (work, queue) = sync_channel::<Work>(QUEUE_MAX);
        thread::Builder::new().name(format!("lafet-{name}")).spawn(move || {
            while let Ok(work) = queue.recv() {
                work(&mut connection);
            }
        })?;
        Ok(Self { work })
    }

    /// Does something with the database, and waits for the result.
    pub async fn call<T: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Connection) -> Result<T, rusqlite::Error> + Send + 'static,
    ) -> Result<T, StoreError> {
        let (reply, result) = oneshot::channel();
        let work: Work = Box::new(move |connection| _ = reply.send(work(connection)));
        self.work.try_send(work).map_err(|_| StoreError::Busy)?;
        Ok(result.await.map_err(|_| StoreError::Busy)??)
    }

    /// Does something, and waits for nothing; `false`: it was not taken.
    pub fn post(&self, work: impl FnOnce(&mut Connection) + Send + 'static) -> bool {
        !matches!(
            self.work.try_send(Box::new(work)),
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_))
        )
    }
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
        assert!(folder.join("b.db.spoilt").is_file());
        drop(anew);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
