//! Reads recordings.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use crate::{Captured, Format, Piece, mcap, pcapng};

/// Why a file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// Neither MCAP nor pcapng.
    #[error("neither an MCAP nor a pcapng recording")]
    Unknown,
    /// A pcapng capture of a network, which is for Wireshark.
    #[error("a capture of a network, not of a line: open it in Wireshark with lafet's dissector")]
    NoLine,
    /// An MCAP file recorded by another program.
    #[error("an MCAP file without the frames that lafet records")]
    NoFrames,
    /// The file violates its format.
    #[error("damaged: {0}")]
    Damaged(String),
    /// The file unpacks to more than the limit.
    #[error("more than {} MiB unpacked", .most >> 20)]
    TooLarge {
        /// The limit, bytes.
        most: u64,
    },
}

/// Reads the traffic of a recording, in order. An unfinished one is read as far as it goes.
pub fn read(path: &Path) -> Result<Vec<Captured>, ReadError> {
    let of_line = |piece| match piece {
        Piece::Captured(captured) => Some(captured),
        Piece::Note(_) => None,
    };
    Ok(read_pieces(path)?.into_iter().filter_map(of_line).collect())
}

/// Reads everything in a recording, in the order of writing.
pub fn read_pieces(path: &Path) -> Result<Vec<Piece>, ReadError> {
    let mut pieces = Vec::new();
    read_each(path, u64::MAX, |piece| {
        pieces.push(piece);
        true
    })?;
    Ok(pieces)
}

/// Reads one piece at a time, so that a long recording does not have to fit into memory. `take`
/// returns whether to continue; at most `unpacked_max` bytes are unpacked.
pub fn read_each(
    path: &Path,
    unpacked_max: u64,
    mut take: impl FnMut(Piece) -> bool,
) -> Result<(), ReadError> {
    let mut file = BufReader::new(File::open(path)?);
    let format = Format::of_bytes(file.fill_buf()?).ok_or(ReadError::Unknown)?;
    match format {
        Format::Mcap => mcap::read(file, unpacked_max, take),
        Format::Pcapng => pcapng::read(file, |captured| take(Piece::Captured(captured))),
    }
}
