//! Recordings back to pieces.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use crate::{Captured, Format, Piece, mcap, pcapng};

/// Why a file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file itself.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// Neither MCAP nor pcapng.
    #[error("neither an MCAP nor a pcapng recording")]
    Unknown,
    /// A pcapng capture of a network: that is for Wireshark.
    #[error("a capture of a network, not of a line: open it in Wireshark with lafet's dissector")]
    NoLine,
    /// An MCAP file that something else has recorded.
    #[error("an MCAP file without the frames that lafet records")]
    NoFrames,
    /// The file breaks its format.
    #[error("damaged: {0}")]
    Damaged(String),
    /// More is packed into the file than is taken.
    #[error("more than {} MiB unpacked", .most >> 20)]
    TooLarge {
        /// Bytes that are taken.
        most: u64,
    },
}

/// The traffic of a recording, in order. One that was not finished is read as far as it goes.
pub fn read(path: &Path) -> Result<Vec<Captured>, ReadError> {
    let of_line = |piece| match piece {
        Piece::Captured(captured) => Some(captured),
        Piece::Note(_) => None,
    };
    Ok(read_pieces(path)?.into_iter().filter_map(of_line).collect())
}

/// Everything in a recording, in the order in which it was written.
pub fn read_pieces(path: &Path) -> Result<Vec<Piece>, ReadError> {
    let mut pieces = Vec::new();
    read_each(path, u64::MAX, |piece| {
        pieces.push(piece);
        true
    })?;
    Ok(pieces)
}

/// The same a piece at a time, so that a long recording does not have to fit into memory. `take`
/// says whether to go on; at most `unpacked_max` bytes are unpacked.
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
