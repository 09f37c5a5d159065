//! The file of an image: a header and the payload behind it (docs/update.md). What can be checked without the
//! maker's key is checked before anything is sent; signature, board and version are checked by the monitor.

use std::fmt;

use lafet_proto::update::{DIGEST_LEN, HEADER_LEN, Report, UNIT};
use lafet_texts::{Argument, Lang, Text, client as text};
use sha2::{Digest as _, Sha256};

/// No file is longer, bytes: 16 MiB.
pub const FILE_MAX: usize = 16 << 20;

const MAGIC: &[u8] = b"LAFETIMG";
const FORMAT: u16 = 1;
const KEYS: u8 = 16;
/// Where the name of the board begins and ends.
const BOARD: (usize, usize) = (24, 40);

/// An image file, whole.
#[derive(Clone, PartialEq, Eq)]
pub struct Image {
    header: [u8; HEADER_LEN],
    payload: Vec<u8>,
    board: String,
}

impl Image {
    /// Reads the bytes of a file.
    ///
    /// # Errors
    ///
    /// [`ImageError`] for any other file, and for one that is not whole.
    pub fn read(bytes: &[u8]) -> Result<Self, ImageError> {
        if !bytes.starts_with(MAGIC) {
            return Err(ImageError::Foreign);
        }
        let there = bytes.len() as u64;
        if bytes.len() > FILE_MAX {
            return Err(ImageError::TooLarge { there });
        }
        let Some((header, payload)) = bytes.split_first_chunk::<HEADER_LEN>() else {
            return Err(ImageError::Cut { there, wanted: HEADER_LEN as u64 });
        };
        let board = fields(header)?;
        let size = u32::from_le_bytes([header[12], header[13], header[14], header[15]]);
        if size == 0 || !size.is_multiple_of(UNIT as u32) {
            return Err(ImageError::Unit { size });
        }
        let wanted = HEADER_LEN as u64 + u64::from(size);
        if there < wanted {
            return Err(ImageError::Cut { there, wanted });
        }
        if there > wanted {
            return Err(ImageError::Longer { there, wanted });
        }
        let image = Self { header: *header, payload: payload.to_vec(), board };
        if sha256(payload) != image.digest() {
            return Err(ImageError::Digest);
        }
        Ok(image)
    }

    /// The header, with its signature.
    pub const fn header(&self) -> &[u8; HEADER_LEN] {
        &self.header
    }

    /// The payload: 8 bytes or more, a multiple of 8.
    pub fn payload(&self) -> &[u8] {
        &self.payload
    }

    /// The version, compared from left to right.
    pub fn version(&self) -> [u16; 4] {
        [16, 18, 20, 22].map(|at| u16_at(&self.header, at))
    }

    /// The name of the board that it is for.
    pub fn board(&self) -> &str {
        &self.board
    }

    /// The slot that it is linked for: 1 A, 2 B; `None`: either.
    pub const fn slot(&self) -> Option<u8> {
        match self.header[40] {
            0 => None,
            slot => Some(slot),
        }
    }

    /// The number of the key that it is signed with, 0 to 15.
    pub const fn key(&self) -> u8 {
        self.header[41]
    }

    /// SHA-256 of the payload.
    pub fn digest(&self) -> [u8; DIGEST_LEN] {
        std::array::from_fn(|index| self.header[64 + index])
    }

    /// Bytes of the payload.
    pub(super) fn size(&self) -> u32 {
        // A file has 16 MiB at most.
        self.payload.len() as u32
    }

    /// Whether it fits a slot.
    pub(super) fn fits(&self, slot: u8) -> bool {
        self.slot().is_none_or(|own| own == slot)
    }

    /// Whether it is the one that the monitor receives.
    pub(super) fn is_received(&self, report: &Report) -> bool {
        self.header[64..].starts_with(&report.image) && report.size == self.size()
    }

    /// Whether it is, by slot and version, the one that the monitor runs.
    pub(super) fn is_running(&self, report: &Report) -> bool {
        self.fits(report.slot) && self.version() == report.version
    }
}

impl fmt::Debug for Image {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (board, version, slot) = (self.board(), self.version(), self.slot());
        f.debug_struct("Image")
            .field("board", &board)
            .field("version", &version)
            .field("slot", &slot)
            .field("size", &self.size())
            .finish_non_exhaustive()
    }
}

/// SHA-256 of bytes that are at hand.
pub(super) fn sha256(bytes: &[u8]) -> [u8; DIGEST_LEN] {
    Sha256::digest(bytes).into()
}

fn u16_at(header: &[u8; HEADER_LEN], at: usize) -> u16 {
    u16::from_le_bytes([header[at], header[at + 1]])
}

/// Checks what a header says by itself; returns the name of the board.
fn fields(header: &[u8; HEADER_LEN]) -> Result<String, ImageError> {
    let format = u16_at(header, 8);
    if format != FORMAT {
        return Err(ImageError::Format { format });
    }
    let board = &header[BOARD.0..BOARD.1];
    let end = board.iter().position(|byte| *byte == 0).unwrap_or(board.len());
    let (name, rest) = board.split_at(end);
    let named = !name.is_empty() && name.iter().all(u8::is_ascii_graphic);
    if !named || rest.iter().any(|byte| *byte != 0) {
        return Err(ImageError::Board);
    }
    let (slot, key) = (header[40], header[41]);
    if slot > 2 {
        return Err(ImageError::Slot { slot });
    }
    if key >= KEYS {
        return Err(ImageError::Key { key });
    }
    if u16_at(header, 42) & (1 << key) != 0 {
        return Err(ImageError::RevokesItself { key });
    }
    let (oldest, newest) = (u16_at(header, 44), u16_at(header, 46));
    if oldest > newest {
        return Err(ImageError::Layouts { oldest, newest });
    }
    let zeros = |from: usize, to: usize| header[from..to].iter().all(|byte| *byte == 0);
    if !zeros(10, 12) || !zeros(48, 64) {
        return Err(ImageError::Reserved);
    }
    Ok(String::from_utf8_lossy(name).into_owned())
}

/// Why a file is no image that could be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ImageError {
    /// It does not begin as an image does.
    Foreign,
    /// Longer than [`FILE_MAX`].
    TooLarge {
        /// Bytes of the file.
        there: u64,
    },
    /// Only a part of it is there.
    Cut {
        /// Bytes of the file.
        there: u64,
        /// Bytes that it should have.
        wanted: u64,
    },
    /// There is something behind its end.
    Longer {
        /// Bytes of the file.
        there: u64,
        /// Bytes that it should have.
        wanted: u64,
    },
    /// A format of a later lafet.
    Format {
        /// Its number.
        format: u16,
    },
    /// The size of the payload is zero or no multiple of 8.
    Unit {
        /// The size that the header names.
        size: u32,
    },
    /// The name of the board has other characters than visible ASCII, or there is none.
    Board,
    /// A slot that no board has.
    Slot {
        /// Its number.
        slot: u8,
    },
    /// A key beyond 15.
    Key {
        /// Its number.
        key: u8,
    },
    /// It would revoke the key that it is signed with.
    RevokesItself {
        /// The key.
        key: u8,
    },
    /// The oldest layout of parameters that it reads is newer than the one that it writes.
    Layouts {
        /// The oldest one that it reads.
        oldest: u16,
        /// The one that it writes.
        newest: u16,
    },
    /// Bytes that have to be zero are not.
    Reserved,
    /// The payload is not the one that was signed.
    Digest,
}

impl ImageError {
    /// The message in a language.
    pub fn localized(&self, lang: Lang) -> String {
        self.of(lang)
    }
}

impl Argument for ImageError {
    fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {
        match *self {
            Self::Foreign => text::ImageForeign.write(lang, out),
            Self::TooLarge { there } => {
                text::ImageTooLarge { there, most: FILE_MAX >> 20 }.write(lang, out)
            }
            Self::Cut { there, wanted } => text::ImageCut { there, wanted }.write(lang, out),
            Self::Longer { there, wanted } => text::ImageLonger { there, wanted }.write(lang, out),
            Self::Format { format } => text::ImageFormat { format, known: FORMAT }.write(lang, out),
            Self::Unit { size } => text::ImageUnit { size }.write(lang, out),
            Self::Board => text::ImageBoard.write(lang, out),
            Self::Slot { slot } => text::ImageSlot { slot }.write(lang, out),
            Self::Key { key } => text::ImageKey { key }.write(lang, out),
            Self::RevokesItself { key } => text::ImageRevokesItself { key }.write(lang, out),
            Self::Layouts { oldest, newest } => {
                text::ImageLayouts { oldest, newest }.write(lang, out)
            }
            Self::Reserved => text::ImageReserved.write(lang, out),
            Self::Digest => text::ImageDigest.write(lang, out),
        }
    }
}

impl Text for ImageError {}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Argument::write(self, Lang::En, f)
    }
}

impl std::error::Error for ImageError {}
