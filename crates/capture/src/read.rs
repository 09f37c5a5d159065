//! Recordings back to pieces.

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
    let bytes = std::fs::read(path)?;
    let mut pieces = Vec::new();
    match Format::of_bytes(&bytes).ok_or(ReadError::Unknown)? {
        Format::Mcap => mcap::read(&bytes, |piece| pieces.push(piece))?,
        Format::Pcapng => {
            pcapng::read(&bytes, |captured| pieces.push(Piece::Captured(captured)))?;
        }
    }
    Ok(pieces)
}
