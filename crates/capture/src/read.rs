//! Recordings back to pieces.

use std::path::Path;

use crate::{Captured, Format, mcap, pcapng};

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

/// The pieces of a recording, in order. One that was not finished is read as far as it goes.
pub fn read(path: &Path) -> Result<Vec<Captured>, ReadError> {
    let bytes = std::fs::read(path)?;
    let mut pieces = Vec::new();
    let take = |captured| pieces.push(captured);
    match Format::of_bytes(&bytes).ok_or(ReadError::Unknown)? {
        Format::Mcap => mcap::read(&bytes, take)?,
        Format::Pcapng => pcapng::read(&bytes, take)?,
    }
    Ok(pieces)
}
