//! Recordings of the traffic between monitors and their clients, and tools to inspect them: MCAP,
//! pcapng, a Wireshark dissector.
//!
//! ```text
//! bytes → Splitter → Captured ─┬→ pcapng        ─┐
//!                              └→ mcap (decoded) ┴→ Reader → Captured
//! ```
#![forbid(unsafe_code)]

pub mod dissector;
mod mcap;
mod messages;
mod pcapng;
mod read;
mod splitter;
mod whole;

use std::io;
use std::path::Path;

pub use read::{ReadError, read, read_each, read_pieces};
pub use splitter::Splitter;
pub use whole::Medium;

/// A piece of a line's traffic: usually one frame, preceded by any noise before it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Captured {
    /// Time of its last byte, nanoseconds since 1970 (UTC).
    pub at_ns: u64,
    /// Direction of the bytes.
    pub direction: Direction,
    /// The bytes as on the wire.
    pub bytes: Vec<u8>,
}

/// A remark beside the traffic, as JSON: the scene of a simulation, for example.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// Time, nanoseconds since 1970 (UTC).
    pub at_ns: u64,
    /// Subject; in MCAP its topic is `/note/` followed by this.
    pub topic: String,
    /// The remark, a JSON document.
    pub json: String,
}

/// Part of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    /// Bytes of the line.
    Captured(Captured),
    /// A remark beside them.
    Note(Note),
}

impl Piece {
    /// Time, nanoseconds since 1970 (UTC).
    pub const fn at_ns(&self) -> u64 {
        match self {
            Self::Captured(Captured { at_ns, .. }) | Self::Note(Note { at_ns, .. }) => *at_ns,
        }
    }
}

/// Direction of bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From a client to the monitors.
    ToMonitor = 1,
    /// From the monitors.
    FromMonitor = 2,
    /// Received from a shared line; the direction is not known.
    Heard = 0,
}

/// File format of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Frames and decoded values, for Foxglove, Lichtblick and other robotics tools.
    Mcap,
    /// Frames, for Wireshark.
    Pcapng,
}

impl Format {
    /// The format for the extension of a file name; `None` if it is neither.
    pub fn of_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "mcap" => Some(Self::Mcap),
            "pcapng" => Some(Self::Pcapng),
            _ => None,
        }
    }

    /// The format for the first bytes of a file; `None` if it is neither.
    pub fn of_bytes(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'M', b'C', b'A', b'P', ..] => Some(Self::Mcap),
            [b'\n', b'\r', b'\r', b'\n', ..] => Some(Self::Pcapng),
            _ => None,
        }
    }
}

/// Writes a recording. Without [`Recorder::finish`], and when the disk is full, it is still complete
/// up to the last flush.
pub struct Recorder<W: Medium> {
    form: Form<W>,
}

enum Form<W: Medium> {
    Mcap(Box<mcap::Writer<W>>),
    Pcapng(pcapng::Writer<W>),
}

impl<W: Medium> Recorder<W> {
    /// Starts a recording.
    pub fn new(format: Format, out: W) -> io::Result<Self> {
        let form = match format {
            Format::Mcap => Form::Mcap(Box::new(mcap::Writer::new(out)?)),
            Format::Pcapng => Form::Pcapng(pcapng::Writer::new(out)?),
        };
        Ok(Self { form })
    }

    /// Writes a piece.
    pub fn write(&mut self, captured: &Captured) -> io::Result<()> {
        match &mut self.form {
            Form::Mcap(writer) => writer.write(captured),
            Form::Pcapng(writer) => writer.write(captured),
        }
    }

    /// Writes a note. In pcapng, which holds only lines, it is left out.
    pub fn note(&mut self, note: &Note) -> io::Result<()> {
        match &mut self.form {
            Form::Mcap(writer) => writer.note(note),
            Form::Pcapng(_) => Ok(()),
        }
    }

    /// Writes what is buffered to the file.
    pub fn flush(&mut self) -> io::Result<()> {
        match &mut self.form {
            Form::Mcap(writer) => writer.flush(),
            Form::Pcapng(writer) => writer.flush(),
        }
    }

    /// Ends the recording.
    pub fn finish(self) -> io::Result<()> {
        match self.form {
            Form::Mcap(writer) => writer.finish(),
            Form::Pcapng(mut writer) => writer.flush(),
        }
    }
}

/// The examples of the README are compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
