//! An MCAP file that is complete at any moment, for a recorder that may be killed.
//!
//! Only whole records reach the file, always followed by the end of a file without summary, which
//! the next records overwrite:
//!
//! ```text
//! magic, header, chunk, chunk, …, data end, footer, magic
//!                              └── overwritten by the next flush ──┘
//! ```

use std::io::{self, Seek, SeekFrom, Write};

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

/// Buffers what is written until it is flushed, which happens where records end.
pub struct Whole<W> {
    out: W,
    /// Length of the file that will not be overwritten, bytes.
    kept: u64,
    /// Bytes written since the last flush.
    tail: Vec<u8>,
}

impl<W: Write + Seek> Whole<W> {
    pub const fn new(out: W) -> Self {
        Self { out, kept: 0, tail: Vec::new() }
    }
}

impl<W: Write + Seek> Write for Whole<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.tail.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.tail.is_empty() {
            return self.out.flush();
        }
        let len = self.tail.len();
        // A recording that is finished has its own end.
        if self.kept == 0 || !self.tail.ends_with(MAGIC) {
            self.tail.extend([&DATA_END[..], &FOOTER, MAGIC].concat());
        }
        self.out.seek(SeekFrom::Start(self.kept))?;
        // In one write, so that a program that is killed has written all of it or nothing.
        self.out.write_all(&self.tail)?;
        self.out.flush()?;
        self.kept += len as u64;
        self.tail.clear();
        Ok(())
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
