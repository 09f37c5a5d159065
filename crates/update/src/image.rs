//! The header of an image: 96 bytes that are signed, and their signature. [`ImageHeader`] has its layout.

use crate::hash::Hash;
use crate::record::Slot;
use crate::refusal::Refusal;
use core::fmt;
use core::str::FromStr;
use lafet_proto::update::{
    BOARD_LEN, FORMAT, HeaderError, ImageHeader, MAGIC, board_name, is_board,
};

/// Bytes of a header with its signature.
pub const HEADER_LEN: usize = 160;
/// Bytes of a header that are signed.
pub(crate) const SIGNED_LEN: usize = 96;
/// The size of a payload and of each part of it is a multiple of this, bytes.
pub const UNIT: usize = 8;

/// A version, compared from left to right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Version(pub [u16; 4]);

/// `major.minor.patch.build`.
impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [major, minor, patch, build] = self.0;
        write!(f, "{major}.{minor}.{patch}.{build}")
    }
}

/// A version is one to four numbers of 0 to 65535 with dots between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VersionError;

impl fmt::Display for VersionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a version is one to four numbers of 0 to 65535 with dots between them")
    }
}

impl core::error::Error for VersionError {}

impl FromStr for Version {
    type Err = VersionError;

    fn from_str(text: &str) -> Result<Self, VersionError> {
        let mut version = Self::default();
        let mut places = version.0.iter_mut();
        for part in text.split('.') {
            let digits = !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
            match (places.next(), part.parse()) {
                (Some(place), Ok(number)) if digits => *place = number,
                _ => return Err(VersionError),
            }
        }
        Ok(version)
    }
}

/// The name of a board: 1 to 16 visible ASCII characters.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct BoardName([u8; BOARD_LEN]);

impl BoardName {
    /// `None` when it is empty, longer, or has other characters.
    pub fn new(name: &str) -> Option<Self> {
        let mut bytes = [0; BOARD_LEN];
        bytes.get_mut(..name.len())?.copy_from_slice(name.as_bytes());
        is_board(&bytes).then_some(Self(bytes))
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        board_name(&self.0)
    }
}

impl fmt::Debug for BoardName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A key that a board knows, by its number in headers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PublicKey {
    /// 0 to 15.
    pub id: u8,
    /// The ed25519 public key.
    pub bytes: [u8; 32],
}

/// What is compiled into a board's bootloader and program.
#[derive(Clone, Copy, Debug)]
pub struct Board<'a> {
    /// Its name.
    pub name: BoardName,
    /// The keys that its maker signs with, spare ones included.
    pub keys: &'a [PublicKey],
}

/// Layouts of the stored parameters that a program can do with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layouts {
    /// The oldest that it reads.
    pub oldest: u16,
    /// The one that it writes; it reads those in between as well.
    pub newest: u16,
}

impl Layouts {
    /// Whether parameters that are stored in this layout can be read.
    pub const fn reads(self, layout: u16) -> bool {
        self.oldest <= layout && layout <= self.newest
    }
}

/// What a header says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Bytes of the payload.
    pub size: u32,
    /// The version of the program.
    pub version: Version,
    /// The board that it is for.
    pub board: BoardName,
    /// The slot that it is linked for; `None` for one that runs in either.
    pub place: Option<Slot>,
    /// The key that it is signed with, 0 to 15.
    pub key: u8,
    /// The keys that are revoked with its confirmation, a bit each.
    pub revokes: u16,
    /// The layouts of stored parameters that it can do with.
    pub layouts: Layouts,
    /// The payload.
    pub hash: Hash,
}

impl Header {
    /// Reads a header; only what it says by itself is checked, not the signature.
    ///
    /// # Errors
    ///
    /// [`Refusal::NotAnImage`], [`Refusal::Format`], [`Refusal::Malformed`],
    /// [`Refusal::RevokesItself`].
    pub fn parse(raw: &[u8; HEADER_LEN]) -> Result<Self, Refusal> {
        let says = ImageHeader::parse(raw).map_err(|error| match error {
            HeaderError::Foreign => Refusal::NotAnImage,
            HeaderError::Format { .. } => Refusal::Format,
            HeaderError::RevokesItself { .. } => Refusal::RevokesItself,
            _ => Refusal::Malformed,
        })?;
        let [oldest, newest] = says.layouts;
        Ok(Self {
            size: says.size,
            version: Version(says.version),
            board: BoardName(says.board),
            // 0: either.
            place: Slot::from_code(says.slot),
            key: says.key,
            revokes: says.revokes,
            layouts: Layouts { oldest, newest },
            hash: Hash(says.digest),
        })
    }

    /// Reads a header and checks what can be checked without the payload: form, board, key and
    /// signature. `revoked` has a bit for each key that is no longer trusted.
    ///
    /// # Errors
    ///
    /// Those of [`Header::parse`], [`Refusal::Board`], [`Refusal::UnknownKey`],
    /// [`Refusal::RevokedKey`], [`Refusal::Signature`].
    pub fn check(raw: &[u8; HEADER_LEN], board: &Board<'_>, revoked: u16) -> Result<Self, Refusal> {
        let header = Self::parse(raw)?;
        if header.board != board.name {
            return Err(Refusal::Board);
        }
        let known = board.keys.iter().find(|key| key.id == header.key);
        let key = known.ok_or(Refusal::UnknownKey)?;
        if revoked & (1 << header.key) != 0 {
            return Err(Refusal::RevokedKey);
        }
        crate::sign::check(raw, &key.bytes).then_some(header).ok_or(Refusal::Signature)
    }

    /// The bytes that are signed.
    pub(crate) fn bytes(&self) -> [u8; SIGNED_LEN] {
        let mut bytes = [0; SIGNED_LEN];
        let place = self.place.map_or(0, Slot::code);
        let [major, minor, patch, build] = self.version.0.map(u16::to_le_bytes);
        let (layouts, revokes) = (self.layouts, self.revokes.to_le_bytes());
        let parts: [(usize, &[u8]); 13] = [
            (0, &MAGIC),
            (8, &FORMAT.to_le_bytes()),
            (12, &self.size.to_le_bytes()),
            (16, &major),
            (18, &minor),
            (20, &patch),
            (22, &build),
            (24, &self.board.0),
            (40, &[place, self.key]),
            (42, &revokes),
            (44, &layouts.oldest.to_le_bytes()),
            (46, &layouts.newest.to_le_bytes()),
            (64, &self.hash.0),
        ];
        for (from, part) in parts {
            for (byte, value) in bytes.iter_mut().skip(from).zip(part) {
                *byte = *value;
            }
        }
        bytes
    }
}
