//! The words of updates that are under way, in the folder of the data: a hub that is killed leaves them to the next one.
//! Each belongs to a line and an address, whatever the monitor there is called. Without a folder they are in memory.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use lafet_client::Endpoint;
use lafet_client::note::monitor;
use lafet_client::update::{Kept, Note};

use crate::sync::lock;

/// Folder of the notes, in that of the data.
const FOLDER: &str = "updates/words";

/// The notes.
#[derive(Debug)]
pub struct Notes {
    folder: Option<PathBuf>,
    /// By line and address: of each monitor that is configured one at most.
    memory: Mutex<BTreeMap<String, Kept>>,
}

impl Notes {
    /// Those of a folder of data.
    pub fn new(data: Option<&Path>) -> Self {
        Self { folder: data.map(|data| data.join(FOLDER)), memory: Mutex::default() }
    }

    fn note(&self, endpoint: &Endpoint) -> Option<Note> {
        Some(Note::new(self.folder.as_deref()?, &monitor(endpoint)))
    }

    /// What is noted of a monitor. Waits for the disk, as what follows does.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or is no note.
    pub fn read(&self, endpoint: &Endpoint) -> io::Result<Option<Kept>> {
        match self.note(endpoint) {
            Some(note) => note.read(),
            None => Ok(lock(&self.memory).get(&monitor(endpoint)).cloned()),
        }
    }

    /// Notes it.
    ///
    /// # Errors
    ///
    /// A disk that cannot be written.
    pub fn write(&self, endpoint: &Endpoint, kept: &Kept) -> io::Result<()> {
        match self.note(endpoint) {
            Some(note) => note.write(kept),
            None => {
                lock(&self.memory).insert(monitor(endpoint), kept.clone());
                Ok(())
            }
        }
    }

    /// It is of no further use.
    ///
    /// # Errors
    ///
    /// A file that cannot be removed.
    pub fn remove(&self, endpoint: &Endpoint) -> io::Result<()> {
        match self.note(endpoint) {
            Some(note) => note.remove(),
            None => {
                lock(&self.memory).remove(&monitor(endpoint));
                Ok(())
            }
        }
    }

    /// Where the note of a monitor is; empty where there is no folder.
    pub fn file(&self, endpoint: &Endpoint) -> String {
        self.note(endpoint).map(|note| note.file().display().to_string()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_belongs_to_a_line_and_an_address() {
        let data = std::env::temp_dir().join(format!("lafet-words-{}", std::process::id()));
        let kept = Kept { word: [7; 16], images: vec![[9; 32]], before: None };
        for data in [Some(data.as_path()), None] {
            let notes = Notes::new(data);
            let one = "tcp://127.0.0.1:10485?addr=1".parse().unwrap();
            // Other options of the same line.
            let same = "tcp://127.0.0.1:10485?addr=1&framing=raw".parse();
            let other = "tcp://127.0.0.1:10485?addr=2".parse().unwrap();
            assert_eq!(notes.read(&one).unwrap(), None);
            notes.write(&one, &kept).unwrap();
            assert_eq!(notes.read(&one).unwrap(), Some(kept.clone()));
            if let Ok(same) = same {
                assert_eq!(notes.read(&same).unwrap(), Some(kept.clone()));
            }
            assert_eq!(notes.read(&other).unwrap(), None);
            notes.remove(&one).unwrap();
            notes.remove(&one).unwrap();
            assert_eq!(notes.read(&one).unwrap(), None);
        }
        std::fs::remove_dir_all(data).unwrap();
    }
}
