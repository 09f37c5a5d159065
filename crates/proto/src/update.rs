//! Update (ours; docs/update.md): the software of a monitor is updated over its own link.
//!
//! The document makes General responsible for it and defines no request. There is one here for all
//! of it, outside of the document's table: [`RequestId::UPDATE`] to General, whose first byte says
//! which order it is. Names of their own for the orders would have had the numbers of requests that
//! act: that of `UpdateBegin` is that of Move. A monitor without it answers WrongRequest.

mod header;

use crate::hash::{conv8, fnv1a32, fold16};
use crate::{DecodeError, Expected, RequestId};

pub use header::{BOARD_LEN, FORMAT, HeaderError, ImageHeader, KEYS, MAGIC, board_name, is_board};

impl RequestId {
    /// Update (ours); not in the document's table.
    pub const UPDATE: Self = Self(0xD7);
}

/// The key that confirms every order but `State`: the hash of "Update".
pub const KEY: u16 = 0x60B7;

const _: () = assert!(conv8(fnv1a32("Update")) == RequestId::UPDATE.0);
const _: () = assert!(fold16(fnv1a32("Update")) == KEY);

/// Bytes of a signed header.
pub const HEADER_LEN: usize = 160;
/// Bytes of the payload in one order at most; each part is a multiple of [`UNIT`].
pub const PART_MAX: usize = 152;
/// Payloads and their parts are multiples of this, bytes.
pub const UNIT: usize = 8;
/// Bytes of the word that confirms an image.
pub const WORD_LEN: usize = 16;
/// Bytes of its SHA-256.
pub const DIGEST_LEN: usize = 32;
/// Bytes of an order at most.
pub const ORDER_MAX: usize = 3 + HEADER_LEN + DIGEST_LEN;
/// Bytes of a report.
pub const REPORT_LEN: usize = 24;

/// What a request to update asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order<'a> {
    /// How far it is: the answer is a [`Report`], as to every other order.
    State,
    /// Begins to receive the image of this header, or goes on with it.
    Begin {
        /// The header, signed.
        header: &'a [u8; HEADER_LEN],
        /// SHA-256 of the word that will confirm it.
        digest: &'a [u8; DIGEST_LEN],
    },
    /// The next part of the payload.
    Data {
        /// Where it belongs, bytes from the beginning.
        offset: u32,
        /// 8 to [`PART_MAX`] bytes.
        part: &'a [u8],
    },
    /// Verifies what was received.
    Verify,
    /// Restarts the monitor with the image, on trial.
    Commit {
        /// As in `Begin`: what another sender has started since is not committed.
        digest: &'a [u8; DIGEST_LEN],
    },
    /// Keeps the image that is on trial.
    Confirm {
        /// The word.
        word: &'a [u8; WORD_LEN],
    },
    /// Ends the trial that waits for the word of this digest: the monitor restarts, which leads back to
    /// the old image.
    Abandon {
        /// As in `Commit`: the trial of another word is not ended.
        digest: &'a [u8; DIGEST_LEN],
    },
}

impl<'a> Order<'a> {
    /// Whether it changes nothing.
    pub const fn is_read(&self) -> bool {
        matches!(self, Self::State)
    }

    /// Reads the data of a request: an order, and the key that came with it (0 with `State`).
    ///
    /// # Errors
    ///
    /// [`DecodeError`] with `Expected::Size` for data of a size that the order cannot have, with
    /// `Expected::Value` for an order that does not exist.
    pub fn decode(data: &'a [u8]) -> Result<(Self, u16), DecodeError> {
        let size = DecodeError { offset: 0, expected: Expected::Size, got: data.len() };
        let (kind, rest) = data.split_first().ok_or(size)?;
        if *kind == 0 {
            return if rest.is_empty() { Ok((Self::State, 0)) } else { Err(size) };
        }
        let (key, rest) = rest.split_first_chunk().ok_or(size)?;
        let order = match kind {
            1 => {
                let (header, digest) = rest.split_first_chunk().ok_or(size)?;
                Self::Begin { header, digest: digest.try_into().map_err(|_| size)? }
            }
            2 => {
                let (offset, part) = rest.split_first_chunk().ok_or(size)?;
                if part.is_empty() || part.len() > PART_MAX || !part.len().is_multiple_of(UNIT) {
                    return Err(size);
                }
                Self::Data { offset: u32::from_le_bytes(*offset), part }
            }
            3 if rest.is_empty() => Self::Verify,
            3 => return Err(size),
            4 => Self::Commit { digest: rest.try_into().map_err(|_| size)? },
            5 => Self::Confirm { word: rest.try_into().map_err(|_| size)? },
            6 => Self::Abandon { digest: rest.try_into().map_err(|_| size)? },
            other => {
                let got = usize::from(*other);
                return Err(DecodeError { offset: 0, expected: Expected::Value, got });
            }
        };
        Ok((order, u16::from_le_bytes(*key)))
    }

    /// Writes the data of a request, with [`KEY`]; returns them, or `None` when `out` is shorter
    /// than [`ORDER_MAX`] and they do not fit.
    pub fn encode<'b>(&self, out: &'b mut [u8]) -> Option<&'b [u8]> {
        let key = KEY.to_le_bytes();
        let at;
        let (kind, key, middle, rest): (u8, &[u8], &[u8], &[u8]) = match self {
            Self::State => (0, &[], &[], &[]),
            Self::Begin { header, digest } => (1, &key, *header, *digest),
            Self::Data { offset, part } => {
                at = offset.to_le_bytes();
                (2, &key, &at, part)
            }
            Self::Verify => (3, &key, &[], &[]),
            Self::Commit { digest } => (4, &key, &[], *digest),
            Self::Confirm { word } => (5, &key, &[], *word),
            Self::Abandon { digest } => (6, &key, &[], *digest),
        };
        let len = 1 + key.len() + middle.len() + rest.len();
        let bytes = core::iter::once(&kind).chain(key).chain(middle).chain(rest);
        let place = out.get_mut(..len)?;
        for (to, from) in place.iter_mut().zip(bytes) {
            *to = *from;
        }
        Some(place)
    }
}

/// How far an update is; unknown values are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Phase(pub u8);

impl Phase {
    /// None has been started since the start of the program.
    pub const IDLE: Self = Self(0);
    /// Data are awaited.
    pub const RECEIVING: Self = Self(1);
    /// The payload is being hashed.
    pub const VERIFYING: Self = Self(2);
    /// It may be committed.
    pub const VERIFIED: Self = Self(3);
    /// The next start tries it.
    pub const COMMITTED: Self = Self(4);
}

/// The answer to every order.
///
/// ```text
/// phase u8 | slot u8: 1 A, 2 B | bits u8: 0 on trial, 1 the last trial failed, 2 an order waits,
/// 3 a commit is pending, 4 what was confirmed last is lost | reason u8 | received u32 | size u32 | version 4 × u16 | image 4 bytes
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// How far it is.
    pub phase: Phase,
    /// The slot that is running: 1 is A, 2 is B.
    pub slot: u8,
    /// What is running is on trial: unless it is confirmed, the next start goes back.
    pub trial: bool,
    /// The last trial was not confirmed.
    pub failed: bool,
    /// An order has been accepted and not been carried out yet.
    pub waits: bool,
    /// What was committed is not on trial, and a later start may still try it: until that could be
    /// taken back, the lockout is not released.
    pub pending: bool,
    /// An older image runs than the one that was confirmed last, which does not verify any more.
    pub lost: bool,
    /// Why the last order was refused that could not be carried out; 0 after one that was. The
    /// numbers are in docs/update.md.
    pub reason: u8,
    /// Bytes of the payload that are there: the offset of the next part.
    pub received: u32,
    /// Bytes of the payload.
    pub size: u32,
    /// The version that is running, from left to right.
    pub version: [u16; 4],
    /// The first bytes of the SHA-256 of the payload that is being received: a sender sees by them
    /// whether it is its own. In [`Phase::IDLE`] of the one that is running; zeros if that cannot be read.
    pub image: [u8; 4],
}

impl Report {
    /// A `reason`: the monitor was no longer in a state to carry the order out.
    pub const NOT_READY: u8 = 255;

    /// Reads the data of an answer.
    ///
    /// # Errors
    ///
    /// [`DecodeError`] with `Expected::Size` unless there are [`REPORT_LEN`] bytes.
    pub fn decode(data: &[u8]) -> Result<Self, DecodeError> {
        let size = DecodeError { offset: 0, expected: Expected::Size, got: data.len() };
        let data: &[u8; REPORT_LEN] = data.try_into().map_err(|_| size)?;
        let [phase, slot, bits, reason, r0, r1, r2, r3, s0, s1, s2, s3, rest @ ..] = data;
        let mut version = [0; 4];
        let (numbers, image) = rest.split_last_chunk().ok_or(size)?;
        for (number, bytes) in version.iter_mut().zip(numbers.as_chunks().0) {
            *number = u16::from_le_bytes(*bytes);
        }
        Ok(Self {
            phase: Phase(*phase),
            slot: *slot,
            trial: bits & 1 != 0,
            failed: bits & 2 != 0,
            waits: bits & 4 != 0,
            pending: bits & 8 != 0,
            lost: bits & 16 != 0,
            reason: *reason,
            received: u32::from_le_bytes([*r0, *r1, *r2, *r3]),
            size: u32::from_le_bytes([*s0, *s1, *s2, *s3]),
            version,
            image: *image,
        })
    }

    /// Whether a monitor of ours can have said this: another one may answer 24 bytes as well.
    pub const fn is_possible(&self) -> bool {
        matches!(self.slot, 1 | 2)
            && self.phase.0 <= Phase::COMMITTED.0
            && self.received <= self.size
    }

    /// The data of an answer.
    pub fn to_bytes(&self) -> [u8; REPORT_LEN] {
        let bits = [self.trial, self.failed, self.waits, self.pending, self.lost];
        let bits = bits.iter().rev().fold(0, |bits, bit| bits << 1 | u8::from(*bit));
        let [r0, r1, r2, r3] = self.received.to_le_bytes();
        let [s0, s1, s2, s3] = self.size.to_le_bytes();
        let [[v0, v1], [v2, v3], [v4, v5], [v6, v7]] = self.version.map(u16::to_le_bytes);
        let [i0, i1, i2, i3] = self.image;
        [
            self.phase.0,
            self.slot,
            bits,
            self.reason,
            r0,
            r1,
            r2,
            r3,
            s0,
            s1,
            s2,
            s3,
            v0,
            v1,
            v2,
            v3,
            v4,
            v5,
            v6,
            v7,
            i0,
            i1,
            i2,
            i3,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn orders() -> Vec<Order<'static>> {
        let header = &[7; HEADER_LEN];
        std::vec![
            Order::State,
            Order::Begin { header, digest: &[8; DIGEST_LEN] },
            Order::Data { offset: 0x0102_0304, part: &[9; UNIT] },
            Order::Data { offset: 0, part: &[3; PART_MAX] },
            Order::Verify,
            Order::Commit { digest: &[5; DIGEST_LEN] },
            Order::Confirm { word: &[6; WORD_LEN] },
            Order::Abandon { digest: &[4; DIGEST_LEN] },
        ]
    }

    /// What is encoded comes back, and each has one size alone.
    #[test]
    fn orders_come_back() {
        for order in orders() {
            let mut out = [0xEE; ORDER_MAX + 1];
            let len = order.encode(&mut out).unwrap().len();
            let key = if order.is_read() { 0 } else { KEY };
            assert_eq!(Order::decode(&out[..len]), Ok((order, key)));
            for wrong in [&out[..len - 1], &out[..len + 1]] {
                let error = Order::decode(wrong).unwrap_err();
                assert_eq!((error.expected, error.got), (Expected::Size, wrong.len()), "{order:?}");
            }
        }
        assert_eq!(Order::State.encode(&mut []), None);
        assert_eq!(Order::Verify.encode(&mut [0; 2]), None);
    }

    /// The bytes are fixed.
    #[test]
    fn bytes_of_an_order() {
        let mut out = [0; ORDER_MAX];
        let order = Order::Data { offset: 0x0102_0304, part: &[9; UNIT] };
        let bytes = [2, 0xB7, 0x60, 4, 3, 2, 1, 9, 9, 9, 9, 9, 9, 9, 9];
        assert_eq!(order.encode(&mut out), Some(bytes.as_slice()));
    }

    /// Any bytes are an order of that length or refused, never more.
    #[test]
    fn any_kind_and_size() {
        for kind in 0..=255 {
            for len in 0..=255 {
                let mut data = [0xA5; 255];
                data[0] = kind;
                match Order::decode(&data[..len]) {
                    Ok((order, _)) => {
                        let mut out = [0; 255];
                        assert_eq!(order.encode(&mut out).unwrap().len(), len);
                        assert!(kind <= 6);
                    }
                    Err(error) => assert!(
                        error.expected == Expected::Size || kind > 6,
                        "{kind} {len}: {error:?}"
                    ),
                }
            }
        }
    }

    #[test]
    fn reports_come_back() {
        for bits in 0..32_u8 {
            let report = Report {
                phase: Phase(bits),
                slot: 2,
                trial: bits & 1 != 0,
                failed: bits & 2 != 0,
                waits: bits & 4 != 0,
                pending: bits & 8 != 0,
                lost: bits & 16 != 0,
                reason: 16,
                received: 0x0102_0304,
                size: 0xF0F1_F2F3,
                version: [1, 2, 3, 0x1234],
                image: [9, 8, 7, 6],
            };
            let data = report.to_bytes();
            assert_eq!(Report::decode(&data), Ok(report));
            assert_eq!(data[2], bits);
            assert_eq!(data[4..8], [4, 3, 2, 1]);
            assert_eq!(data[18..], [0x34, 0x12, 9, 8, 7, 6]);
        }
        assert!(Report::decode(&[0; REPORT_LEN - 1]).is_err());
    }

    /// Each rule alone.
    #[test]
    fn what_a_report_cannot_say() {
        let well = Report { slot: 1, received: 8, size: 8, ..Report::default() };
        assert!(well.is_possible() && Report { slot: 2, phase: Phase(4), ..well }.is_possible());
        for wrong in [
            Report { slot: 0, ..well },
            Report { slot: 3, ..well },
            Report { phase: Phase(5), ..well },
            Report { received: 9, ..well },
        ] {
            assert!(!wrong.is_possible(), "{wrong:?}");
        }
    }

    /// Its number is that of no request of the document, nor of the controller.
    #[test]
    fn a_number_of_its_own() {
        let known = RequestId::KNOWN.iter().chain(RequestId::BUS);
        assert!(known.clone().all(|(id, _)| *id != RequestId::UPDATE));
        assert_eq!(RequestId::UPDATE.name(), None);
        assert_eq!(conv8(fnv1a32("UpdateBegin")), RequestId::MOVE.0, "why there is one name");
    }
}
