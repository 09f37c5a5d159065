//! The format of the state, and the program that wrote it: a state that a newer program wrote is
//! refused before anything of it is opened, so that nothing is changed.
//!
//! The number is `user_version` of each database and `version` of `site.json`. It is read from the bytes of
//! the files, because SQLite writes beside a database even to read it.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use lafet_texts::{Shown, Text as _, hub as text};
use serde_json::Value;

use super::db::StoreError;
use super::mark::StateFile;
use crate::text::Both;

/// The format that this program writes. One that programs before it would misread gets the next
/// number. 0 is that of programs which wrote no number; its tables are those of 1.
pub const FORMAT: u32 = 1;
/// This program, as it is written into `site.json`.
pub const PROGRAM: &str = env!("CARGO_PKG_VERSION");

/// Most bytes of `site.json` that are read: it has a few hundred.
const MANIFEST_MAX: u64 = 64 << 10;
/// Most characters of a program's version that are shown.
const PROGRAM_MAX: usize = 32;
/// Start of a database, and where its first page has `user_version`.
const MAGIC: &[u8] = b"SQLite format 3\0";
const USER_VERSION: usize = 60;
/// Lengths of the headers of a write-ahead log and of each page in it.
const LOG_HEADER: u64 = 32;
const FRAME_HEADER: u64 = 24;

/// A state that a newer program wrote.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Newer {
    /// The folder.
    pub folder: PathBuf,
    /// Its format.
    pub format: u32,
    /// The version of the program that wrote it, if `site.json` has it.
    pub program: Option<String>,
}

impl Newer {
    /// Who wrote it, and what to do.
    pub fn words(&self) -> Both {
        let (folder, format, known, own) = (self.folder.display(), self.format, FORMAT, PROGRAM);
        let folder = Shown(folder);
        match &self.program {
            Some(program) => text::StoreNewer { folder, program, format, known, own }.words(),
            None => text::StoreNewerUnknown { folder, format, known, own }.words(),
        }
    }
}

/// Fails on a state that a newer program wrote; a folder that is not there has none.
pub fn refuse_newer(folder: &Path) -> Result<(), StoreError> {
    match newer(folder)? {
        None => Ok(()),
        Some(newer) => Err(StoreError::Newer(newer)),
    }
}

/// Whether a newer program wrote the state in a folder. Nothing is written or locked.
pub fn newer(folder: &Path) -> io::Result<Option<Newer>> {
    let (mut format, program) = of_manifest(&folder.join(StateFile::Site.name()))?;
    for file in StateFile::ALL.into_iter().filter(|it| *it != StateFile::Site) {
        format = format.max(of_database(&folder.join(file.name()))?);
    }
    Ok((format > FORMAT).then(|| Newer { folder: folder.to_owned(), format, program }))
}

/// What `site.json` says; nothing where it says nothing that can be read.
fn of_manifest(path: &Path) -> io::Result<(u32, Option<String>)> {
    let Some(file) = open(path)? else { return Ok((0, None)) };
    let mut bytes = Vec::new();
    file.take(MANIFEST_MAX).read_to_end(&mut bytes)?;
    let read: Value = serde_json::from_slice(&bytes).unwrap_or_default();
    let format = read["version"].as_u64().unwrap_or(0);
    let program = read["program"].as_str().map(|it| it.chars().take(PROGRAM_MAX).collect());
    Ok((u32::try_from(format).unwrap_or(u32::MAX), program))
}

/// `user_version` of a database: the higher of those in the file and in its log. A log may be older than
/// the file, but the number never falls.
fn of_database(path: &Path) -> io::Result<u32> {
    let Some(mut file) = open(path)? else { return Ok(0) };
    let mut first = [0; USER_VERSION + 4];
    let found = match file.read_exact(&mut first) {
        Ok(()) if first.starts_with(MAGIC) => in_page(&first),
        // What is cut or no database at all is reported where it is opened.
        Ok(()) => 0,
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => 0,
        Err(error) => return Err(error),
    };
    let mut log = path.as_os_str().to_owned();
    log.push("-wal");
    Ok(found.max(of_log(Path::new(&log))?))
}

/// The highest `user_version` of the first pages in a write-ahead log.
fn of_log(path: &Path) -> io::Result<u32> {
    let Some(mut file) = open(path)? else { return Ok(0) };
    let length = file.metadata()?.len();
    let mut header = [0; LOG_HEADER as usize];
    if length < LOG_HEADER {
        return Ok(0);
    }
    file.read_exact(&mut header)?;
    let page = u64::from(big_endian(&header, 8));
    if !(512..=65_536).contains(&page) {
        return Ok(0);
    }
    let (mut at, mut found) = (LOG_HEADER, 0);
    while at + FRAME_HEADER + page <= length {
        let mut frame = [0; FRAME_HEADER as usize + USER_VERSION + 4];
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(&mut frame)?;
        let (head, start) = frame.split_at(FRAME_HEADER as usize);
        if big_endian(head, 0) == 1 && start.starts_with(MAGIC) {
            found = in_page(start).max(found);
        }
        at += FRAME_HEADER + page;
    }
    Ok(found)
}

fn in_page(page: &[u8]) -> u32 {
    big_endian(page, USER_VERSION)
}

fn big_endian(bytes: &[u8], at: usize) -> u32 {
    let four = bytes.get(at..at + 4).and_then(|it| it.try_into().ok());
    four.map_or(0, u32::from_be_bytes)
}

fn open(path: &Path) -> io::Result<Option<File>> {
    match File::open(path) {
        Ok(file) => Ok(Some(file)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use rusqlite::Connection;

    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder =
            std::env::temp_dir().join(format!("lafet-format-{name}-{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir(&folder).unwrap();
        folder
    }

    #[test]
    fn the_number_is_found_in_the_file_and_in_its_log() {
        let folder = folder("log");
        let path = folder.join("audit.db");
        assert_eq!(of_database(&path).unwrap(), 0, "there is no file");
        let db = Connection::open(&path).unwrap();
        db.execute_batch("CREATE TABLE t (n INTEGER); PRAGMA user_version = 7;").unwrap();
        assert_eq!(of_database(&path).unwrap(), 7);
        db.pragma_update(None, "journal_mode", "WAL").unwrap();
        db.execute_batch("PRAGMA wal_autocheckpoint = 0; PRAGMA user_version = 9;").unwrap();
        // SQLite has it in the log alone, as after a kill.
        let mut bytes = [0; USER_VERSION + 4];
        File::open(&path).unwrap().read_exact(&mut bytes).unwrap();
        assert_eq!((in_page(&bytes), of_database(&path).unwrap()), (7, 9));
        drop(db);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn bytes_that_are_no_state_have_no_number() {
        let folder = folder("odd");
        let (db, log, site) =
            (folder.join("hub.db"), folder.join("hub.db-wal"), folder.join("site.json"));
        let mut header = [0xff_u8; 32];
        header[8..12].copy_from_slice(&[0, 0, 2, 0]);
        for bytes in [&[][..], b"SQLite format 3\0", &[0xff; 5000], &header] {
            for path in [&db, &log, &site] {
                std::fs::write(path, bytes).unwrap();
            }
            assert_eq!(newer(&folder).unwrap(), None, "{bytes:?}");
        }
        std::fs::write(&site, r#"{"version": 99999999999, "program": 3}"#).unwrap();
        let found = newer(&folder).unwrap().unwrap();
        assert_eq!((found.format, found.program), (u32::MAX, None));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
