//! What is remembered of the two slots; it is stored as one value, whole or not at all.

use crate::hash::Hash;
use crate::image::{Header, Version};

/// One of the two places for an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// The first.
    A,
    /// The second.
    B,
}

impl Slot {
    /// Both.
    pub const BOTH: [Self; 2] = [Self::A, Self::B];

    /// The other one.
    pub const fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }

    /// 1 or 2, as in headers, records and answers.
    pub const fn code(self) -> u8 {
        match self {
            Self::A => 1,
            Self::B => 2,
        }
    }

    /// The slot of a number.
    pub const fn from_code(code: u8) -> Option<Self> {
        match code {
            1 => Some(Self::A),
            2 => Some(Self::B),
            _ => None,
        }
    }
}

/// What is in the slot that is not active.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Other {
    /// Nothing, or an image that is being received.
    Empty,
    /// An image that was confirmed once: it is started when the active one no longer verifies, on
    /// trial if it may not be able to read the stored parameters.
    Kept,
    /// An image that is to be started once, on trial.
    Committed,
    /// An image that has been started on trial, and not been confirmed.
    Tried,
    /// An image that was not confirmed in its trial, or no longer verified.
    Failed,
}

/// The record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// The slot that is started.
    pub active: Slot,
    /// What is in the other one.
    pub other: Other,
    /// The version that was confirmed last: an image has to be newer.
    pub floor: Version,
    /// The keys that are no longer trusted, a bit each.
    pub revoked: u16,
    /// The layout in which parameters may be stored by now.
    pub layout: u16,
    /// The committed image need not be newer: a press at the board allows it, or it is what was
    /// confirmed last, to be had again.
    pub allowed: bool,
    /// The digest of the word that confirms the committed image.
    pub word: Hash,
}

/// The record as the memory returns it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recorded {
    /// There never was one: the board is as it left the factory.
    Fresh,
    /// There was one, and it cannot be read.
    Lost,
    /// The record.
    Known(Record),
}

/// Bytes of a stored record.
pub(crate) const RECORD_LEN: usize = 48;
const FORMAT: u8 = 1;

impl Record {
    /// What a board starts with: the image that is running, confirmed by its being there.
    pub const fn starting(active: Slot, running: &Header) -> Self {
        Self {
            active,
            other: Other::Empty,
            floor: running.version,
            revoked: running.revokes,
            layout: running.layouts.newest,
            allowed: false,
            word: Hash([0; 32]),
        }
    }

    /// Whether the committed image may be started, by its version.
    pub(crate) fn admits(&self, image: &Header) -> bool {
        self.allowed || image.version > self.floor
    }

    pub(crate) fn encode(&self) -> [u8; RECORD_LEN] {
        let other = match self.other {
            Other::Empty => 0,
            Other::Kept => 1,
            Other::Committed => 2,
            Other::Tried => 3,
            Other::Failed => 4,
        };
        let head = [FORMAT, self.active.code(), other, u8::from(self.allowed)];
        let numbers = [self.revoked, self.layout].into_iter().chain(self.floor.0);
        let numbers = numbers.flat_map(u16::to_le_bytes);
        let values = head.into_iter().chain(numbers).chain(self.word.0);
        let mut bytes = [0; RECORD_LEN];
        for (byte, value) in bytes.iter_mut().zip(values) {
            *byte = value;
        }
        bytes
    }

    pub(crate) fn decode(bytes: &[u8]) -> Option<Self> {
        let bytes: &[u8; RECORD_LEN] = bytes.try_into().ok()?;
        let [format, active, other, allowed, r0, r1, l0, l1, rest @ ..] = bytes;
        if *format != FORMAT {
            return None;
        }
        let (floor, word) = rest.split_first_chunk::<8>()?;
        let mut version = Version::default();
        for (number, bytes) in version.0.iter_mut().zip(floor.chunks_exact(2)) {
            *number = u16::from_le_bytes(bytes.try_into().ok()?);
        }
        Some(Self {
            active: Slot::from_code(*active)?,
            other: match other {
                0 => Other::Empty,
                1 => Other::Kept,
                2 => Other::Committed,
                3 => Other::Tried,
                4 => Other::Failed,
                _ => return None,
            },
            floor: version,
            revoked: u16::from_le_bytes([*r0, *r1]),
            layout: u16::from_le_bytes([*l0, *l1]),
            allowed: match allowed {
                0 => false,
                1 => true,
                _ => return None,
            },
            word: Hash(word.try_into().ok()?),
        })
    }
}
