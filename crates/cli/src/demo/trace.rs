//! The trace: every request and answer, and the state of the world every 100 ms.

use lafet_texts::{Shown, Text as _, cli as text};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::lang::current;

/// A trace that goes to a file, or is discarded.
pub struct Trace(Option<(PathBuf, BufWriter<File>)>);

impl Trace {
    /// Opens the file; `None` discards the trace.
    pub fn open(path: Option<&Path>) -> Result<Self, Failure> {
        let Some(path) = path else { return Ok(Self(None)) };
        let file = File::create(path).map_err(|error| cannot_write(path, error))?;
        Ok(Self(Some((path.to_owned(), BufWriter::new(file)))))
    }

    /// Appends text, which contains its own line ends.
    pub fn add(&mut self, text: &str) -> Result<(), Failure> {
        let Some((path, file)) = &mut self.0 else { return Ok(()) };
        file.write_all(text.as_bytes()).map_err(|error| cannot_write(path, error))
    }

    /// Flushes the trace.
    pub fn close(&mut self) -> Result<(), Failure> {
        let Some((path, file)) = &mut self.0 else { return Ok(()) };
        file.flush().map_err(|error| cannot_write(path, error))
    }
}

fn cannot_write(path: &Path, error: std::io::Error) -> Failure {
    let path = path.display();
    Failure::io(text::CannotWritePath { path: Shown(path) }.of(current()), error)
}
