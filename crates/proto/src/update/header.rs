//! The header of an image: 96 bytes that are signed, and their signature (docs/update.md).
//!
//! ```text
//!  0  "LAFETIMG"                        24  board, ASCII, zeros behind it   16 bytes
//!  8  format u16 = 1                    40  slot u8: 0 either, 1 A, 2 B
//! 10  zero u16                          41  key u8, 0…15
//! 12  size of the payload u32           42  keys that it revokes u16, a bit each
//! 16  version 4 × u16                   44  layouts of stored parameters: oldest that it
//!                                           reads u16, that it writes u16
//! 48  zeros                             64  SHA-256 of the payload          32 bytes
//! 96  ed25519 signature of the bytes 0…95                                   64 bytes
//! ```

use super::{DIGEST_LEN, HEADER_LEN};

/// The first bytes of each image.
pub const MAGIC: [u8; 8] = *b"LAFETIMG";
/// The format of the header.
pub const FORMAT: u16 = 1;
/// Keys have numbers below this.
pub const KEYS: u8 = 16;
/// Bytes of the name of a board.
pub const BOARD_LEN: usize = 16;

/// What the header of an image says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageHeader {
    /// Bytes of the payload.
    pub size: u32,
    /// The version, compared from left to right.
    pub version: [u16; 4],
    /// The board that it is for: see [`is_board`].
    pub board: [u8; BOARD_LEN],
    /// The slot that it is linked for: 1 A, 2 B, 0 either.
    pub slot: u8,
    /// The key that it is signed with, 0 to 15.
    pub key: u8,
    /// The keys that are revoked with its confirmation, a bit each.
    pub revokes: u16,
    /// Layouts of stored parameters: the oldest that it reads, the one that it writes.
    pub layouts: [u16; 2],
    /// SHA-256 of the payload.
    pub digest: [u8; DIGEST_LEN],
}

/// Why bytes are no header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeaderError {
    /// They do not begin as an image does.
    Foreign,
    /// Another format than [`FORMAT`].
    Format {
        /// Its number.
        format: u16,
    },
    /// No name of a board.
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
    /// The oldest layout that it reads is newer than the one that it writes.
    Layouts {
        /// The oldest one that it reads.
        oldest: u16,
        /// The one that it writes.
        newest: u16,
    },
    /// Bytes that have to be zero are not.
    Reserved,
    /// It would revoke the key that it is signed with.
    RevokesItself {
        /// The key.
        key: u8,
    },
}

impl ImageHeader {
    /// Reads a header; only what it says by itself is checked: not the size, the payload or the signature.
    ///
    /// # Errors
    ///
    /// [`HeaderError`]; of several, the first in its order.
    pub fn parse(raw: &[u8; HEADER_LEN]) -> Result<Self, HeaderError> {
        let mut rest = raw.as_slice();
        if take(&mut rest) != MAGIC {
            return Err(HeaderError::Foreign);
        }
        let format = u16::from_le_bytes(take(&mut rest));
        if format != FORMAT {
            return Err(HeaderError::Format { format });
        }
        let zero: [u8; 2] = take(&mut rest);
        let size = u32::from_le_bytes(take(&mut rest));
        let mut version = [0; 4];
        for number in &mut version {
            *number = u16::from_le_bytes(take(&mut rest));
        }
        let board = take(&mut rest);
        let [slot, key] = take(&mut rest);
        let revokes = u16::from_le_bytes(take(&mut rest));
        let oldest = u16::from_le_bytes(take(&mut rest));
        let newest = u16::from_le_bytes(take(&mut rest));
        let zeros: [u8; 16] = take(&mut rest);
        let digest = take(&mut rest);
        match () {
            () if !is_board(&board) => Err(HeaderError::Board),
            () if slot > 2 => Err(HeaderError::Slot { slot }),
            () if key >= KEYS => Err(HeaderError::Key { key }),
            () if oldest > newest => Err(HeaderError::Layouts { oldest, newest }),
            () if zero != [0; 2] || zeros != [0; 16] => Err(HeaderError::Reserved),
            () if revokes & (1 << key) != 0 => Err(HeaderError::RevokesItself { key }),
            () => {
                let layouts = [oldest, newest];
                Ok(Self { size, version, board, slot, key, revokes, layouts, digest })
            }
        }
    }

    /// The name of the board.
    pub fn board_name(&self) -> &str {
        board_name(&self.board)
    }
}

/// Whether it is the name of a board: 1 to 16 visible ASCII characters, zeros behind them.
pub fn is_board(bytes: &[u8; BOARD_LEN]) -> bool {
    let mut rest = bytes.iter().skip_while(|byte| byte.is_ascii_graphic());
    bytes.first().is_some_and(u8::is_ascii_graphic) && rest.all(|byte| *byte == 0)
}

/// The name of a board as text; empty where it is none.
pub fn board_name(bytes: &[u8; BOARD_LEN]) -> &str {
    let len = bytes.iter().take_while(|byte| **byte != 0).count();
    bytes.get(..len).and_then(|name| core::str::from_utf8(name).ok()).unwrap_or_default()
}

/// The next bytes; a header is long enough for all that is taken from it.
fn take<const N: usize>(rest: &mut &[u8]) -> [u8; N] {
    let Some((head, tail)) = rest.split_first_chunk() else { return [0; N] };
    *rest = tail;
    *head
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A header with all fields different.
    fn header() -> [u8; HEADER_LEN] {
        let mut raw = [0; HEADER_LEN];
        let parts: [(usize, &[u8]); 9] = [
            (0, &MAGIC),
            (8, &FORMAT.to_le_bytes()),
            (12, &0x0102_0308_u32.to_le_bytes()),
            (16, &[1, 0, 2, 0, 3, 0, 0x34, 0x12]),
            (24, b"a-board"),
            (40, &[2, 3]),
            (42, &[0x81, 0x10]),
            (44, &[4, 0, 5, 0]),
            (64, &[0xD1; DIGEST_LEN]),
        ];
        for (from, part) in parts {
            raw[from..from + part.len()].copy_from_slice(part);
        }
        raw[96..].fill(0x5A);
        raw
    }

    #[test]
    fn each_field_is_read_from_its_place() {
        let read = ImageHeader::parse(&header()).unwrap();
        assert_eq!(read.board_name(), "a-board");
        let expected = ImageHeader {
            size: 0x0102_0308,
            version: [1, 2, 3, 0x1234],
            board: *b"a-board\0\0\0\0\0\0\0\0\0",
            slot: 2,
            key: 3,
            revokes: 0x1081,
            layouts: [4, 5],
            digest: [0xD1; DIGEST_LEN],
        };
        assert_eq!(read, expected);
    }

    /// One byte that is not right, and what is said of it.
    #[test]
    fn what_is_no_header_says_why() {
        for (at, byte, error) in [
            (7, b'g', HeaderError::Foreign),
            (8, 2, HeaderError::Format { format: 2 }),
            (9, 1, HeaderError::Format { format: 0x0101 }),
            (24, 0, HeaderError::Board),
            (25, b' ', HeaderError::Board),
            (39, b'x', HeaderError::Board),
            (40, 3, HeaderError::Slot { slot: 3 }),
            (41, 16, HeaderError::Key { key: 16 }),
            (44, 6, HeaderError::Layouts { oldest: 6, newest: 5 }),
            (10, 1, HeaderError::Reserved),
            (11, 1, HeaderError::Reserved),
            (48, 1, HeaderError::Reserved),
            (63, 1, HeaderError::Reserved),
            (42, 0x08, HeaderError::RevokesItself { key: 3 }),
        ] {
            let mut raw = header();
            raw[at] = byte;
            assert_eq!(ImageHeader::parse(&raw), Err(error), "byte {at}");
        }
        // The signature is for who has the key.
        let mut raw = header();
        raw[96..].fill(0);
        assert!(ImageHeader::parse(&raw).is_ok());
    }

    #[test]
    fn names_of_boards() {
        for (name, is_name) in [
            (b"stm32f103-board1", true),
            (b"x\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0", true),
            (b"\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0", false),
            (b"a\0b\0\0\0\0\0\0\0\0\0\0\0\0\0", false),
            (b"a b\0\0\0\0\0\0\0\0\0\0\0\0\0", false),
            (b"\xD0\x96\0\0\0\0\0\0\0\0\0\0\0\0\0\0", false),
        ] {
            assert_eq!(is_board(name), is_name, "{name:?}");
        }
        assert_eq!(board_name(b"stm32f103-board1"), "stm32f103-board1");
        assert_eq!(board_name(b"\xFF\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"), "");
    }
}
