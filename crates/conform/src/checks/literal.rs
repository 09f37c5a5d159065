//! Requests as the document writes them, byte by byte: the tester must not use the constants of the
//! code that it may be testing.

/// §2, §3.3
pub const GET_STATUS_GENERAL: [u8; 4] = [0xD4, 0xC2, 0x00, 0x00];
/// §3.20; an id without bit 7.
pub const GET_CRASH_DATA_GENERAL: [u8; 4] = [0x06, 0xC2, 0x00, 0x00];
/// §3.21/1
pub const GET_HOTBEDS: [u8; 6] = [0x9D, 0xC8, 0x00, 0x02, 0xFE, 0x23];
