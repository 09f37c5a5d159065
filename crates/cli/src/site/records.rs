//! Records that are kept: one file for each test in a folder, with its page and its signature beside it.

use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use lafet_acceptance::calendar::Kept;
use lafet_acceptance::html::html;
use lafet_acceptance::record::Record;
use lafet_acceptance::sign::{Key, Signed};
use lafet_texts::{Shown, Text as _, cli as text};

use crate::cmd::exercise::write;
use crate::failure::{Failure, Outcome};
use crate::lang::current;

/// Most records of a folder: one a day for decades.
const RECORDS_MAX: usize = 10_000;
/// Longest file that is read, bytes.
const FILE_MAX: u64 = 8 << 20;

/// What is written of a record.
pub struct Keeping {
    /// The record, JSON.
    pub record: Option<PathBuf>,
    /// The page.
    pub page: Option<PathBuf>,
    /// A folder: both, by the date.
    pub records: Option<PathBuf>,
    /// Signs them.
    pub key: Option<Key>,
}

impl Keeping {
    /// Writes all that is asked for; the signature, if there is a key.
    pub fn keep(&self, record: &Record) -> Result<Option<Signed>, Failure> {
        let json = record.json();
        let signed = self.key.as_ref().map(|key| key.sign(&json));
        let (mut records, mut pages) = (Vec::new(), Vec::new());
        records.extend(self.record.clone());
        pages.extend(self.page.clone());
        if let Some(folder) = &self.records {
            let name = record.began.replace(':', "");
            records.push(folder.join(format!("{name}.json")));
            pages.push(folder.join(format!("{name}.html")));
        }
        for path in records {
            write(&path, &String::from_utf8_lossy(&json))?;
            if let Some(signed) = &signed {
                write(&signature_of(&path), &signed.line())?;
            }
        }
        for path in pages {
            write(&path, &html(record, signed.as_ref(), current()))?;
        }
        Ok(signed)
    }

    /// Whether it can be written: before a test that takes an hour.
    pub fn is_possible(&self) -> Outcome {
        let Some(folder) = &self.records else { return Ok(()) };
        let shown = folder.display();
        let failed = |error| {
            let what = text::CannotWritePath { path: Shown(&shown) }.of(current());
            Failure::io(what, error)
        };
        fs::create_dir_all(folder).map_err(failed)
    }
}

/// The file of the signature of a record.
pub fn signature_of(record: &Path) -> PathBuf {
    let mut name = record.as_os_str().to_owned();
    name.push(".sig");
    name.into()
}

/// A file, if it is not too long.
pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let shown = path.display();
    let failed = |error| {
        let what = text::CannotReadSite { shown: Shown(&shown) }.of(current());
        Failure::io(what, error)
    };
    let mut bytes = Vec::new();
    let file = fs::File::open(path).map_err(failed)?;
    file.take(FILE_MAX + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 <= FILE_MAX {
        return Ok(bytes);
    }
    let words = text::SiteFileTooLong { shown: Shown(shown), most: FILE_MAX >> 20 };
    Err(Failure::Usage(words.of(current())))
}

/// The records of a folder, the latest first. What is no record is left out.
pub fn kept(folder: &Path) -> Result<Vec<Kept>, Failure> {
    let shown = folder.display();
    let failed = |error| {
        let what = text::CannotReadSite { shown: Shown(&shown) }.of(current());
        Failure::io(what, error)
    };
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.extension().is_none_or(|it| it != "json") {
            continue;
        }
        if all.len() == RECORDS_MAX {
            let words = text::SiteTooMany { shown: Shown(&shown), most: RECORDS_MAX };
            return Err(Failure::Usage(words.of(current())));
        }
        all.extend(Kept::read(&read(&path)?));
    }
    all.sort_by_key(|it| std::cmp::Reverse(it.began_ms()));
    Ok(all)
}
