//! The file of an image: a header and the payload behind it (docs/update.md). What can be checked without the
//! maker's key is checked before anything is sent; signature, board and version are checked by the monitor.

use std::fmt;

use lafet_proto::update::{
    DIGEST_LEN, FORMAT, HEADER_LEN, HeaderError, ImageHeader, MAGIC, Report, UNIT,
};
use lafet_texts::{Argument, Lang, Text, client as text};
use sha2::{Digest as _, Sha256};

/// No file is longer, bytes: 16 MiB.
pub const FILE_MAX: usize = 16 << 20;

/// An image file, whole.
#[derive(Clone, PartialEq, Eq)]
pub struct Image {
    header: [u8; HEADER_LEN],
    says: ImageHeader,
    payload: Vec<u8>,
}

impl Image {
    /// Reads the bytes of a file.
    ///
    /// # Errors
    ///
    /// [`ImageError`] for any other file, and for one that is not whole.
    pub fn read(bytes: &[u8]) -> Result<Self, ImageError> {
        if !bytes.starts_with(&MAGIC) {
            return Err(ImageError::Foreign);
        }
        let there = bytes.len() as u64;
        if bytes.len() > FILE_MAX {
            return Err(ImageError::TooLarge { there });
        }
        let Some((header, payload)) = bytes.split_first_chunk::<HEADER_LEN>() else {
            return Err(ImageError::Cut { there, wanted: HEADER_LEN as u64 });
        };
        let says = ImageHeader::parse(header)?;
        let size = says.size;
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
        if sha256(payload) != says.digest {
            return Err(ImageError::Digest);
        }
        Ok(Self { header: *header, says, payload: payload.to_vec() })
    }

    /// What the header says.
    pub const fn says(&self) -> &ImageHeader {
        &self.says
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
    pub const fn version(&self) -> [u16; 4] {
        self.says.version
    }

    /// The name of the board that it is for.
    pub fn board(&self) -> &str {
        self.says.board_name()
    }

    /// The slot that it is linked for: 1 A, 2 B; `None`: either.
    pub const fn slot(&self) -> Option<u8> {
        match self.says.slot {
            0 => None,
            slot => Some(slot),
        }
    }

    /// The number of the key that it is signed with, 0 to 15.
    pub const fn key(&self) -> u8 {
        self.says.key
    }

    /// SHA-256 of the payload.
    pub const fn digest(&self) -> [u8; DIGEST_LEN] {
        self.says.digest
    }

    /// Bytes of the payload.
    pub const fn size(&self) -> u32 {
        self.says.size
    }

    /// Whether it fits a slot.
    pub(super) fn fits(&self, slot: u8) -> bool {
        self.slot().is_none_or(|own| own == slot)
    }

    /// Whether it is the one that the monitor receives.
    pub(super) fn is_received(&self, report: &Report) -> bool {
        self.says.digest.starts_with(&report.image) && report.size == self.size()
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

/// Whether these can be sent together: one image, or two of one version for one board, one for either slot. The
/// one for the slot that is not running is sent.
pub fn are_a_set(images: &[Image]) -> bool {
    match images {
        [_] => true,
        [one, other] => {
            let slots =
                matches!((one.slot(), other.slot()), (Some(1), Some(2)) | (Some(2), Some(1)));
            slots && one.version() == other.version() && one.board() == other.board()
        }
        _ => false,
    }
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

impl From<HeaderError> for ImageError {
    fn from(error: HeaderError) -> Self {
        match error {
            HeaderError::Foreign => Self::Foreign,
            HeaderError::Format { format } => Self::Format { format },
            HeaderError::Board => Self::Board,
            HeaderError::Slot { slot } => Self::Slot { slot },
            HeaderError::Key { key } => Self::Key { key },
            HeaderError::Layouts { oldest, newest } => Self::Layouts { oldest, newest },
            HeaderError::Reserved => Self::Reserved,
            HeaderError::RevokesItself { key } => Self::RevokesItself { key },
        }
    }
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
