//! Reads recordings.

use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

use lafet_texts::{Argument, Lang, Shown, Text, capture as text};

use crate::{Captured, Format, Piece, mcap, pcapng};

/// Why a file cannot be read.
#[derive(Debug)]
pub enum ReadError {
    /// The file cannot be read.
    Io(io::Error),
    /// Neither MCAP nor pcapng.
    Unknown,
    /// A pcapng capture of a network, which is for Wireshark.
    NoLine,
    /// An MCAP file recorded by another program.
    NoFrames,
    /// The file violates its format: a text of the library that reads it.
    Damaged(String),
    /// The file unpacks to more than the limit.
    TooLarge {
        /// The limit, bytes.
        most: u64,
    },
}

impl Argument for ReadError {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match self {
            Self::Io(error) => text::RecordingUnreadable { error: Shown(error) }.write(lang, out),
            Self::Unknown => text::NotARecording.write(lang, out),
            Self::NoLine => text::RecordingOfNetwork.write(lang, out),
            Self::NoFrames => text::RecordingWithoutFrames.write(lang, out),
            Self::Damaged(why) => text::RecordingDamaged { why }.write(lang, out),
            Self::TooLarge { most } => {
                let most = most >> 20;
                text::RecordingTooLarge { most }.write(lang, out)
            }
        }
    }
}

impl Text for ReadError {}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(Lang::En, f)
    }
}

impl std::error::Error for ReadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io(error) => Some(error),
            _ => None,
        }
    }
}

impl From<io::Error> for ReadError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// In Russian only names of formats and programs, and what a library says, are not Russian.
    #[test]
    fn why_a_file_is_not_read_is_said_in_the_language() {
        let io = || ReadError::Io(io::Error::other("broken"));
        let damaged = || ReadError::Damaged("broken".into());
        let all = [
            io(),
            damaged(),
            ReadError::Unknown,
            ReadError::NoLine,
            ReadError::NoFrames,
            ReadError::TooLarge { most: 5 << 20 },
        ];
        let names = ["MCAP", "pcapng", "lafet", "record", "decode", "dissector", "Wireshark"];
        for error in all {
            let (en, ru) = (error.of(Lang::En), error.of(Lang::Ru));
            assert_eq!(en, error.to_string());
            assert_ne!(en, ru);
            let latin =
                ru.split(|c: char| !c.is_ascii_alphabetic()).filter(|word| !word.is_empty());
            let strange: Vec<_> = latin.filter(|word| !names.contains(word)).collect();
            let quoted = matches!(error, ReadError::Io(_) | ReadError::Damaged(_));
            assert_eq!(strange, if quoted { vec!["broken"] } else { vec![] }, "{ru}");
        }
    }
}
