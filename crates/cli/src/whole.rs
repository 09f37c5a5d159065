//! Files that are replaced whole: whatever happens meanwhile, the old content or the new one is there.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Most names tried for the new file.
const NAMES: u32 = 100;

/// A file beside the one to be replaced; removed unless it has taken its place.
pub struct Whole {
    file: File,
    beside: PathBuf,
    path: PathBuf,
    placed: bool,
}

impl Whole {
    /// Makes the file beside, under a name that no file has.
    pub fn beside(path: &Path) -> io::Result<Self> {
        let id = std::process::id();
        for number in 0..NAMES {
            let mut name = path.as_os_str().to_owned();
            name.push(format!(".{id}-{number}.new"));
            let beside = PathBuf::from(name);
            match File::create_new(&beside) {
                Ok(file) => return Ok(Self { file, beside, path: path.into(), placed: false }),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    /// Writes the content, and puts it in place once it is on the disk.
    pub fn place(mut self, content: &[u8]) -> io::Result<()> {
        self.file.write_all(content)?;
        self.file.sync_all()?;
        fs::rename(&self.beside, &self.path)?;
        self.placed = true;
        // A power cut may bring the old content back, where a folder cannot be written out.
        let folder = self.path.parent().filter(|it| !it.as_os_str().is_empty());
        let _ = File::open(folder.unwrap_or(Path::new("."))).and_then(|folder| folder.sync_all());
        Ok(())
    }
}

impl Drop for Whole {
    fn drop(&mut self) {
        if !self.placed {
            // It is of no use to anyone.
            let _ = fs::remove_file(&self.beside);
        }
    }
}
