//! What a tuning has put out of force, on disk before the monitor loses it. A program that is killed in the
//! middle of a tuning leaves the values of the measurement in the monitor, and a note of those before; the next
//! start puts them back.

use lafet_proto::SubsystemId;

use super::{Bench, MIN_SPEED, Pair, STOP_LAG};
use crate::note::{self, Noted};

/// The first line of a note.
const HEAD: &str = "lafet tune 1";

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

/// The note of one monitor in a folder; none where no tuning was cut off.
pub type Note = note::Note<Kept>;

impl Noted for Kept {
    const ENDING: &'static str = "tune";
    const SECRET: bool = false;

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
    use std::{fs, io};

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
