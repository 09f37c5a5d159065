//! What a tuning has put out of force, on disk before the monitor loses it. A program that is killed in the
//! middle of a tuning leaves the values of the measurement in the monitor, and a note of those before; the next
//! start puts them back.

use std::fs::{self, File};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use lafet_proto::SubsystemId;

use super::{Bench, MIN_SPEED, Pair, STOP_LAG};

/// The first line of a note.
const HEAD: &str = "lafet tune 1";
/// No note is longer, bytes.
const LONGEST: u64 = 4096;

/// The values before a tuning, and those that it has set since.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kept {
    /// The drive.
    pub drive: SubsystemId,
    /// The values before.
    pub before: Pair,
    /// What the tuning has set, or is about to.
    pub set: Vec<Pair>,
}

/// A value that was put back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PutBack {
    /// The parameter.
    pub name: &'static str,
    /// What the tuning has left in it.
    pub from: i32,
    /// What was there before.
    pub to: i32,
}

/// The note of one monitor in a folder.
#[derive(Clone, Debug)]
pub struct Note {
    file: PathBuf,
}

impl Note {
    /// The note of the monitor with this name, which may have any characters.
    pub fn new(folder: &Path, monitor: &str) -> Self {
        let plain = |c: u8| c.is_ascii_alphanumeric() || matches!(c, b'-' | b'.');
        let mut name = String::new();
        for c in monitor.bytes() {
            match plain(c) {
                true => name.push(c.into()),
                false => name.push_str(&format!("_{c:02x}")),
            }
        }
        Self { file: folder.join(format!("{name}.tune")) }
    }

    /// Where it is.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// What it says; `None` where no tuning was cut off.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or is no note.
    pub fn read(&self) -> io::Result<Option<Kept>> {
        let file = match File::open(&self.file) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            file => file?,
        };
        let mut text = String::new();
        file.take(LONGEST).read_to_string(&mut text)?;
        Kept::parse(&text).map(Some).ok_or_else(|| io::ErrorKind::InvalidData.into())
    }

    /// Writes it, whole or not at all; it is on the disk then.
    ///
    /// # Errors
    ///
    /// A folder or disk that cannot be written.
    pub fn write(&self, kept: &Kept) -> io::Result<()> {
        if let Some(folder) = self.file.parent() {
            fs::create_dir_all(folder)?;
        }
        let new = self.file.with_extension("new");
        let mut file = File::create(&new)?;
        file.write_all(kept.text().as_bytes())?;
        file.sync_all()?;
        fs::rename(&new, &self.file)?;
        // The name is in the folder.
        #[cfg(unix)]
        if let Some(folder) = self.file.parent() {
            File::open(folder)?.sync_all()?;
        }
        Ok(())
    }

    /// The values are in force again, or others are wanted.
    ///
    /// # Errors
    ///
    /// A file that cannot be removed.
    pub fn remove(&self) -> io::Result<()> {
        match fs::remove_file(&self.file) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

impl Kept {
    fn text(&self) -> String {
        let pair =
            |word: &str, pair: &Pair| format!("{word} {} {}\n", pair.lag_ms, pair.min_tenths);
        let set: String = self.set.iter().map(|it| pair("set", it)).collect();
        format!("{HEAD}\ndrive {}\n{}{set}end\n", self.drive, pair("before", &self.before))
    }

    fn parse(text: &str) -> Option<Self> {
        let pair = |line: &str, word: &str| {
            let mut numbers = line.strip_prefix(word)?.split_whitespace().map(str::parse);
            let (lag_ms, min_tenths) = (numbers.next()?.ok()?, numbers.next()?.ok()?);
            numbers.next().is_none().then_some(Pair { lag_ms, min_tenths })
        };
        let mut lines = text.lines();
        let head = lines.next()? == HEAD;
        let drive = SubsystemId::from_name(lines.next()?.strip_prefix("drive ")?)?;
        let before = pair(lines.next()?, "before ")?;
        let mut set: Vec<&str> = lines.collect();
        let whole = set.pop()? == "end" && head;
        let set = set.into_iter().map(|line| pair(line, "set ")).collect::<Option<_>>()?;
        whole.then_some(Self { drive, before, set })
    }
}

/// Puts back what a tuning that was cut off has left in the monitor. A value that it has not set was set by
/// another client, and stays. One that is in force again is set once more: it may not be stored.
///
/// # Errors
///
/// The first of the bench; then the note must stay.
pub async fn put_back<B: Bench>(bench: &mut B, kept: &Kept) -> Result<Vec<PutBack>, B::Error> {
    let lags = kept.set.iter().map(|set| set.lag_ms).collect();
    let speeds = kept.set.iter().map(|set| set.min_tenths).collect();
    let all: [(_, _, Vec<i32>); 2] =
        [(STOP_LAG, kept.before.lag_ms, lags), (MIN_SPEED, kept.before.min_tenths, speeds)];
    let (mut done, mut all_set) = (Vec::new(), Ok(()));
    for (name, to, set) in all {
        let from = bench.param(kept.drive, name).await?;
        if from != to && !set.contains(&from) {
            continue;
        }
        all_set = all_set.and(bench.set_param(kept.drive, name, to).await);
        if from != to {
            done.push(PutBack { name, from, to });
        }
    }
    all_set.map(|()| done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_is_read_as_written_or_not_at_all() {
        let set = vec![Pair::default(), Pair { lag_ms: -1, min_tenths: 12 }];
        let before = Pair { lag_ms: 300, min_tenths: 7 };
        let kept = Kept { drive: SubsystemId::NOZZLE, before, set };
        let text = kept.text();
        assert_eq!(Kept::parse(&text), Some(kept.clone()));
        for end in 0..text.len() - 1 {
            assert_eq!(Kept::parse(&text[..end]), None, "{end}");
        }
        let folder = std::env::temp_dir().join(format!("lafet-kept-{}", std::process::id()));
        let note = Note::new(&folder, "tcp://[::1]:10485?addr=1/..");
        assert_eq!(note.file().parent(), Some(folder.as_path()));
        assert_eq!(note.read().unwrap(), None);
        note.write(&kept).unwrap();
        assert_eq!(note.read().unwrap(), Some(kept));
        fs::write(note.file(), "lafet tune 2\n").unwrap();
        assert_eq!(note.read().unwrap_err().kind(), io::ErrorKind::InvalidData);
        note.remove().unwrap();
        note.remove().unwrap();
        assert_eq!(note.read().unwrap(), None);
        fs::remove_dir_all(folder).unwrap();
    }
}
