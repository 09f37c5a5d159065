//! What is in the flash: pages with a header, entries behind it, and marks, which say nothing
//! but "written". docs/storage.md draws it.

use super::Geometry;
use crate::hal::VALUE_MAX;
use lafet_proto::crc::Crc32c;

/// Bytes of a page's header; its marks follow.
pub(super) const PAGE_HEADER: usize = 16;
/// Bytes of an entry's header; its value follows.
pub(super) const ENTRY_HEADER: usize = 8;
/// Bytes of the checksum behind a value.
pub(super) const CHECK: usize = 4;
/// The length of an entry in place of a value which could not be read any more.
pub(super) const DAMAGED: u16 = 0x8000;

const VERSION: u16 = 0x4C01;
const LOST: u16 = 1;

/// The checksum of a value: the same wherever the value is copied to. Castagnoli's polynomial detects
/// any five flipped bits in up to 5,243 (655 bytes).
pub(super) struct ValueCheck(Crc32c);

impl ValueCheck {
    pub(super) fn new(entry: Entry) -> Self {
        let mut crc = Crc32c::new();
        crc.update(&entry.key.to_le_bytes());
        crc.update(&entry.len.to_le_bytes());
        Self(crc)
    }

    pub(super) fn update(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    pub(super) fn finish(self) -> [u8; CHECK] {
        self.0.finish().to_le_bytes()
    }
}

/// The header of a page: it makes the page part of the log, and says what came before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PageHeader {
    /// Counts the pages ever opened; page `seq % pages` of the flash.
    pub(super) seq: u32,
    /// Older pages that belong to the log too.
    pub(super) span: u16,
    /// Where the valid entries of the page before this one end.
    pub(super) previous_end: u16,
    /// Values have been lost to damage; which ones is unknown.
    pub(super) lost: bool,
}

impl PageHeader {
    pub(super) fn encode(self, geometry: Geometry) -> [u8; PAGE_HEADER] {
        let [s0, s1, s2, s3] = self.seq.to_le_bytes();
        let [n0, n1] = self.span.to_le_bytes();
        let [e0, e1] = self.previous_end.to_le_bytes();
        let [v0, v1] = VERSION.to_le_bytes();
        let [f0, f1] = (if self.lost { LOST } else { 0 }).to_le_bytes();
        let [c0, c1, c2, c3] =
            check(geometry, &[s0, s1, s2, s3, n0, n1, e0, e1, v0, v1, f0, f1]).to_le_bytes();
        [s0, s1, s2, s3, n0, n1, e0, e1, v0, v1, f0, f1, c0, c1, c2, c3]
    }

    /// Decodes a header, also one with a flipped bit.
    pub(super) fn decode(bytes: [u8; PAGE_HEADER], geometry: Geometry) -> Option<Self> {
        let [_, _, _, _, _, _, _, _, v0, v1, ..] = bytes;
        // Not one bit away from a header: an erased page need not be tried 128 times.
        if (u16::from_le_bytes([v0, v1]) ^ VERSION).count_ones() > 1 {
            return None;
        }
        let read = |bytes: &[u8; PAGE_HEADER]| {
            let [s0, s1, s2, s3, n0, n1, e0, e1, _, _, f0, ..] = *bytes;
            let header = Self {
                seq: u32::from_le_bytes([s0, s1, s2, s3]),
                span: u16::from_le_bytes([n0, n1]),
                previous_end: u16::from_le_bytes([e0, e1]),
                lost: u16::from(f0) == LOST,
            };
            (header.encode(geometry) == *bytes).then_some(header)
        };
        repaired(bytes, read)
    }
}

/// The header of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) key: u16,
    /// Bytes of the value, or `DAMAGED`.
    pub(super) len: u16,
}

impl Entry {
    /// Bytes of the value that stand in the flash.
    pub(super) fn value_len(self) -> usize {
        if self.len == DAMAGED { 0 } else { usize::from(self.len) }
    }

    /// The checksum is that of this place in this page: an old header there, or a value that
    /// looks like a header, is none.
    pub(super) fn encode(self, geometry: Geometry, seq: u32, at: usize) -> [u8; ENTRY_HEADER] {
        let [k0, k1] = self.key.to_le_bytes();
        let [l0, l1] = self.len.to_le_bytes();
        let [s0, s1, s2, s3] = seq.to_le_bytes();
        let [a0, a1] = (at as u16).to_le_bytes();
        let [c0, c1, c2, c3] =
            check(geometry, &[s0, s1, s2, s3, a0, a1, k0, k1, l0, l1]).to_le_bytes();
        [k0, k1, l0, l1, c0, c1, c2, c3]
    }

    /// Decodes a header, also one with a flipped bit: else all entries behind it would be lost.
    pub(super) fn decode(
        bytes: [u8; ENTRY_HEADER],
        geometry: Geometry,
        seq: u32,
        at: usize,
    ) -> Option<Self> {
        let read = |bytes: &[u8; ENTRY_HEADER]| {
            let [k0, k1, l0, l1, ..] = *bytes;
            let entry =
                Self { key: u16::from_le_bytes([k0, k1]), len: u16::from_le_bytes([l0, l1]) };
            let fits = entry.len == DAMAGED || entry.value_len() <= VALUE_MAX;
            (fits && entry.encode(geometry, seq, at) == *bytes).then_some(entry)
        };
        repaired(bytes, read)
    }
}

/// What `read` makes of the bytes, or of the bytes with one bit flipped.
fn repaired<const N: usize, T>(bytes: [u8; N], read: impl Fn(&[u8; N]) -> Option<T>) -> Option<T> {
    let flipped = |bit: usize| {
        let mut bytes = bytes;
        if let Some(byte) = bytes.get_mut(bit / 8) {
            *byte ^= 1 << (bit % 8);
        }
        read(&bytes)
    };
    read(&bytes).or_else(|| (0..N * 8).find_map(flipped))
}

/// A flash that was divided in another way holds nothing that could be read.
fn check(geometry: Geometry, bytes: &[u8]) -> u32 {
    let mut crc = Crc32c::new();
    for word in [geometry.pages.get(), geometry.page as u32, geometry.word as u32] {
        crc.update(&word.to_le_bytes());
    }
    crc.update(bytes);
    crc.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::num::NonZeroU32;

    const GEOMETRY: Geometry =
        Geometry { start: 0, pages: NonZeroU32::new(4).unwrap(), page: 1024, word: 2 };

    #[test]
    fn page_header_survives_any_flipped_bit() {
        let header = PageHeader { seq: 77, span: 2, previous_end: 1000, lost: true };
        let bytes = header.encode(GEOMETRY);
        assert_eq!(PageHeader::decode(bytes, GEOMETRY), Some(header));
        for bit in 0..PAGE_HEADER * 8 {
            let mut bytes = bytes;
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(PageHeader::decode(bytes, GEOMETRY), Some(header), "bit {bit}");
            bytes[(bit / 8 + 5) % PAGE_HEADER] ^= 0x10;
            assert_eq!(PageHeader::decode(bytes, GEOMETRY), None, "bit {bit} and another");
        }
        assert_eq!(PageHeader::decode([0xFF; PAGE_HEADER], GEOMETRY), None);
        assert_eq!(PageHeader::decode([0; PAGE_HEADER], GEOMETRY), None);
        let other = Geometry { word: 4, ..GEOMETRY };
        assert_eq!(PageHeader::decode(bytes, other), None);
    }

    #[test]
    fn entry_header_is_bound_to_its_place() {
        let entry = Entry { key: 9, len: 264 };
        let bytes = entry.encode(GEOMETRY, 5, 40);
        assert_eq!(Entry::decode(bytes, GEOMETRY, 5, 40), Some(entry));
        assert_eq!(Entry::decode(bytes, GEOMETRY, 6, 40), None);
        assert_eq!(Entry::decode(bytes, GEOMETRY, 5, 48), None);
        for bit in 0..ENTRY_HEADER * 8 {
            let mut bytes = bytes;
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Entry::decode(bytes, GEOMETRY, 5, 40), Some(entry), "bit {bit}");
        }
        assert_eq!(Entry::decode([0xFF; ENTRY_HEADER], GEOMETRY, 5, 40), None);
        let long = Entry { key: 9, len: 265 };
        assert_eq!(Entry::decode(long.encode(GEOMETRY, 5, 40), GEOMETRY, 5, 40), None);
    }
}
