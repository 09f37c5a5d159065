//! A file that is complete at any moment, for a recorder that may be killed and a disk that may be
//! full.
//!
//! Only whole records reach the file. In MCAP they are always followed by the end of a file without
//! summary, which the next records overwrite:
//!
//! ```text
//! magic, header, chunk, chunk, …, data end, footer, magic
//!                              └── overwritten by the next flush ──┘
//! ```
//!
//! What the disk takes in part is cut off again, and the end that was there is put back: it was
//! overwritten, so its place is on the disk already.

use std::fs::File;
use std::io::{self, Cursor, Seek, SeekFrom, Write};

use ::mcap::MAGIC;

/// The end of data, without its checksum.
const DATA_END: [u8; 13] = [0x0F, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
/// A footer that points to no summary.
const FOOTER: [u8; 29] = {
    let mut footer = [0; 29];
    footer[0] = 0x02;
    footer[1] = 20;
    footer
};

/// What a recording is written to: without a buffer of its own, so that it can be cut off.
pub trait Medium: Write + Seek {
    /// Cuts everything behind this length off.
    ///
    /// # Errors
    ///
    /// Those of the medium.
    fn cut(&mut self, len: u64) -> io::Result<()>;
}

impl Medium for File {
    fn cut(&mut self, len: u64) -> io::Result<()> {
        self.set_len(len)
    }
}

impl Medium for Cursor<Vec<u8>> {
    fn cut(&mut self, len: u64) -> io::Result<()> {
        self.get_mut().truncate(usize::try_from(len).unwrap_or(usize::MAX));
        Ok(())
    }
}

impl<M: Medium + ?Sized> Medium for &mut M {
    fn cut(&mut self, len: u64) -> io::Result<()> {
        (**self).cut(len)
    }
}

/// What a file ends with while it is being written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Nothing: it may end behind any record.
    Anywhere,
    /// The end of an MCAP file without summary.
    Mcap,
}

/// Buffers what is written until it is flushed, which happens where records end.
pub struct Whole<W> {
    out: W,
    end: End,
    /// Length of the file that will not be overwritten, bytes.
    kept: u64,
    /// Bytes written since the last flush.
    tail: Vec<u8>,
    /// What could not be written is missing, so that nothing may follow it.
    broken: Option<io::ErrorKind>,
}

impl<W: Medium> Whole<W> {
    pub const fn new(out: W, end: End) -> Self {
        Self { out, end, kept: 0, tail: Vec::new(), broken: None }
    }

    /// Bytes that wait for the next flush.
    pub const fn waiting(&self) -> usize {
        self.tail.len()
    }

    fn put(&mut self) -> io::Result<()> {
        self.out.seek(SeekFrom::Start(self.kept))?;
        // In one write, so that a program that is killed has written all of it or nothing.
        self.out.write_all(&self.tail)?;
        self.out.flush()
    }

    /// The file as it was before what could not be written whole.
    fn put_back(&mut self) -> io::Result<()> {
        if self.kept == 0 || self.end == End::Anywhere {
            return self.out.cut(self.kept);
        }
        let end = [&DATA_END[..], &FOOTER, MAGIC].concat();
        self.out.seek(SeekFrom::Start(self.kept))?;
        self.out.write_all(&end)?;
        self.out.flush()?;
        self.out.cut(self.kept + end.len() as u64)
    }
}

impl<W: Medium> Write for Whole<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.tail.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if let Some(kind) = self.broken {
            return Err(kind.into());
        }
        if self.tail.is_empty() {
            return self.out.flush();
        }
        let len = self.tail.len();
        // A recording that is finished has its own end.
        if self.end == End::Mcap && (self.kept == 0 || !self.tail.ends_with(MAGIC)) {
            self.tail.extend([&DATA_END[..], &FOOTER, MAGIC].concat());
        }
        let put = self.put();
        self.tail.clear();
        match &put {
            Ok(()) => self.kept += len as u64,
            Err(error) => {
                self.broken = Some(error.kind());
                // The error that is reported is the first.
                _ = self.put_back();
            }
        }
        put
    }
}

impl<W> Seek for Whole<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) | SeekFrom::End(0) => Ok(self.kept + self.tail.len() as u64),
            _ => Err(io::ErrorKind::Unsupported.into()),
        }
    }
}
