//! Records that are kept: one file for each test in a folder, with its page and its signature beside it.

use std::fs;
use std::io::{self, Read as _, Write as _};
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
/// Most records of one second.
const NAMES_MAX: u32 = 1000;
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
        let line = signed.as_ref().map(Signed::line);
        let page = html(record, signed.as_ref(), current());
        if let Some(path) = &self.record {
            write(path, &String::from_utf8_lossy(&json))?;
            if let Some(line) = &line {
                write(&signature_of(path), line)?;
            }
        }
        if let Some(path) = &self.page {
            write(path, &page)?;
        }
        if let Some(folder) = &self.records {
            let mut files = vec![(".json", &json[..]), (".html", page.as_bytes())];
            files.extend(line.as_ref().map(|it| (".json.sig", it.as_bytes())));
            let name = record.began.replace(':', "");
            add(folder, &name, &files).map_err(|error| cannot_write(folder, error))?;
        }
        Ok(signed)
    }

    /// Whether it can be written: before a test that takes an hour.
    pub fn is_possible(&self) -> Outcome {
        let Some(folder) = &self.records else { return Ok(()) };
        fs::create_dir_all(folder).map_err(|error| cannot_write(folder, error))
    }
}

fn cannot_write(folder: &Path, error: io::Error) -> Failure {
    let what = text::CannotWritePath { path: Shown(folder.display()) }.of(current());
    Failure::io(what, error)
}

/// Writes files that belong together, by a name that none of them has yet: two tests may begin in one second. If one of them
/// cannot be written, none is there.
fn add(folder: &Path, name: &str, files: &[(&str, &[u8])]) -> io::Result<()> {
    for number in 1..=NAMES_MAX {
        let name = if number == 1 { name.to_owned() } else { format!("{name}-{number}") };
        let mut made = Vec::new();
        let written = files.iter().try_for_each(|(ending, bytes)| {
            let path = folder.join(format!("{name}{ending}"));
            let mut file = fs::File::create_new(&path)?;
            made.push(path);
            file.write_all(bytes)?;
            file.sync_all()
        });
        let Err(error) = written else { return Ok(()) };
        for path in made {
            _ = fs::remove_file(path);
        }
        if error.kind() != io::ErrorKind::AlreadyExists {
            return Err(error);
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder of its own.
    fn folder(name: &str) -> PathBuf {
        let path =
            std::env::temp_dir().join(format!("lafet-records-{name}-{}", std::process::id()));
        _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        path
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap().map(|it| it.unwrap().file_name());
        let mut all: Vec<_> = entries.map(|it| it.into_string().unwrap()).collect();
        all.sort();
        all
    }

    fn text(folder: &Path, name: &str) -> String {
        fs::read_to_string(folder.join(name)).unwrap()
    }

    #[test]
    fn records_of_one_second_are_kept_beside_one_another() {
        let folder = folder("second");
        // A page that a person has put there belongs to no record.
        fs::write(folder.join("t-3.html"), "another").unwrap();
        for number in 1..=3 {
            let record = format!("record {number}");
            let files = [(".json", record.as_bytes()), (".html", b"page"), (".json.sig", b"line")];
            add(&folder, "t", &files).unwrap();
        }
        for (name, number) in [("t", 1), ("t-2", 2), ("t-4", 3)] {
            assert_eq!(text(&folder, &format!("{name}.json")), format!("record {number}"));
            for ending in [".html", ".json.sig"] {
                assert!(folder.join(format!("{name}{ending}")).is_file(), "{name}{ending}");
            }
        }
        assert_eq!((text(&folder, "t-3.html").as_str(), names(&folder).len()), ("another", 10));
        fs::remove_dir_all(folder).unwrap();
    }

    /// Programs that test at the same time, as in a nightly run of two sites.
    #[test]
    fn records_that_are_written_at_once_are_all_kept() {
        const WRITERS: usize = 16;
        let folder = folder("once");
        std::thread::scope(|scope| {
            for number in 0..WRITERS {
                let (folder, record) = (&folder, number.to_string());
                scope.spawn(move || {
                    add(folder, "t", &[(".json", record.as_bytes()), (".html", b"page")]).unwrap();
                });
            }
        });
        let all = names(&folder);
        let mut kept: Vec<usize> = all
            .iter()
            .filter(|it| it.ends_with(".json"))
            .map(|it| text(&folder, it).parse().unwrap())
            .collect();
        kept.sort_unstable();
        assert!(kept.iter().copied().eq(0..WRITERS), "{all:?}");
        assert_eq!(all.len(), 2 * WRITERS);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_record_that_cannot_be_written_leaves_nothing() {
        let folder = folder("none");
        let files = [(".json", &b"record"[..]), ("/none/t.html", b"page")];
        assert_eq!(add(&folder, "t", &files).unwrap_err().kind(), io::ErrorKind::NotFound);
        assert_eq!(names(&folder), [""; 0]);
        fs::remove_dir_all(folder).unwrap();
    }
}
