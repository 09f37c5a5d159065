//! Notes on disk, one for each monitor: what a program that is cut off leaves to its next start.

use std::fs::{self, File};
use std::io::{self, Read as _, Write as _};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use crate::url::Endpoint;

/// No note is longer, bytes.
const LONGEST: u64 = 4096;

/// A monitor by its link and address, whatever the other options of its URL. It may have any characters.
pub fn monitor(endpoint: &Endpoint) -> String {
    let address = endpoint.addresses().monitor;
    let link = match endpoint {
        Endpoint::Tcp { host, port, .. } => format!("tcp-{host}-{port}"),
        Endpoint::Udp { host, port, .. } => format!("udp-{host}-{port}"),
        Endpoint::Serial { path, .. } => format!("serial-{}", path.display()),
        Endpoint::Sim { .. } => "sim".to_owned(),
    };
    format!("{link}-{address}")
}

/// What is noted, as the text of a file.
pub trait Noted: Sized {
    /// How the names of such files end.
    const ENDING: &'static str;
    /// Whether a file is made for its owner alone, where the system has that.
    const SECRET: bool;

    /// The text.
    fn text(&self) -> String;

    /// Reads the text; `None` unless it is a whole one.
    fn parse(text: &str) -> Option<Self>;
}

/// The note of one monitor in a folder.
#[derive(Clone, Debug)]
pub struct Note<T> {
    file: PathBuf,
    of: PhantomData<T>,
}

impl<T: Noted> Note<T> {
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
        Self { file: folder.join(format!("{name}.{}", T::ENDING)), of: PhantomData }
    }

    /// Where it is.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// What it says; `None` where there is none.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or is no note.
    pub fn read(&self) -> io::Result<Option<T>> {
        let file = match File::open(&self.file) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            file => file?,
        };
        let mut text = String::new();
        file.take(LONGEST).read_to_string(&mut text)?;
        T::parse(&text).map(Some).ok_or_else(|| io::ErrorKind::InvalidData.into())
    }

    /// Writes it, whole or not at all; it is on the disk then.
    ///
    /// # Errors
    ///
    /// A folder or disk that cannot be written.
    pub fn write(&self, noted: &T) -> io::Result<()> {
        if let Some(folder) = self.file.parent() {
            fs::create_dir_all(folder)?;
        }
        let new = self.file.with_extension("new");
        let mut options = File::options();
        options.write(true).create(true).truncate(true);
        #[cfg(unix)]
        if T::SECRET {
            std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        }
        let mut file = options.open(&new)?;
        file.write_all(noted.text().as_bytes())?;
        file.sync_all()?;
        fs::rename(&new, &self.file)?;
        // The name is in the folder.
        #[cfg(unix)]
        if let Some(folder) = self.file.parent() {
            File::open(folder)?.sync_all()?;
        }
        Ok(())
    }

    /// It is of no further use.
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
