//! Why an image, a part of it or a request is refused.

use core::fmt;

/// Why something was refused. The number of each is fixed: it travels in answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u8)]
pub enum Refusal {
    /// The header does not begin as an image does.
    NotAnImage = 1,
    /// The header is of a format that this program does not read.
    Format = 2,
    /// A field of the header has a value that it cannot have.
    Malformed = 3,
    /// The image is for another board.
    Board = 4,
    /// The image runs in the other slot.
    Place = 5,
    /// The image is empty, larger than a slot, or not a multiple of [`crate::UNIT`].
    Size = 6,
    /// No key of this number is known to the board.
    UnknownKey = 7,
    /// The key has been revoked.
    RevokedKey = 8,
    /// The image would revoke the key that it is signed with.
    RevokesItself = 9,
    /// The signature is not that of the key.
    Signature = 10,
    /// Not newer than what was confirmed last; a press at the board allows it.
    NotNewer = 11,
    /// The image cannot read the stored parameters, or writes them as older ones do.
    Layout = 12,
    /// No image has been started to be received.
    NotBegun = 13,
    /// Data that do not follow the last ones, go beyond the end, or have a size that is no multiple
    /// of [`crate::UNIT`].
    Misplaced = 14,
    /// Not all data are there.
    Incomplete = 15,
    /// The data are not those that were signed.
    Hash = 16,
    /// Not verified since the last start.
    NotVerified = 17,
    /// An image on trial must be confirmed first.
    OnTrial = 18,
    /// No image is on trial.
    NotOnTrial = 19,
    /// Not the word that the image was committed with, or not the digest that it was started with.
    Word = 20,
    /// The flash cannot be read or written.
    Flash = 21,
}

impl Refusal {
    /// Every reason, by its number.
    pub const ALL: [Self; 21] = [
        Self::NotAnImage,
        Self::Format,
        Self::Malformed,
        Self::Board,
        Self::Place,
        Self::Size,
        Self::UnknownKey,
        Self::RevokedKey,
        Self::RevokesItself,
        Self::Signature,
        Self::NotNewer,
        Self::Layout,
        Self::NotBegun,
        Self::Misplaced,
        Self::Incomplete,
        Self::Hash,
        Self::NotVerified,
        Self::OnTrial,
        Self::NotOnTrial,
        Self::Word,
        Self::Flash,
    ];

    /// The number in answers, 1 and up.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The reason of a number; `None` for one that this version does not know.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.iter().copied().find(|refusal| refusal.code() == code)
    }
}

/// The name of the reason, for logs.
impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

impl core::error::Error for Refusal {}
