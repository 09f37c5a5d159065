//! The flash of the emulated board whose software can be updated, as chip and host both see it (ours).
//!
//! Places are bytes from its beginning. Words are written once, pages are erased.

/// The name of the board in the headers of images.
pub const BOARD: &str = "lafet-mps2";
/// Where the chip has its beginning.
pub const ADDRESS: u32 = 0x2100_0000;
/// Bytes of a page.
pub const PAGE: usize = 2048;
/// Bytes of a word.
pub const WORD: usize = 8;
/// Pages of the parameters, which are the first ones.
pub const PARAMS_PAGES: u16 = 8;
/// Where the record of the slots begins.
pub const RECORD: u32 = 0x4000;
/// Pages of the record.
pub const RECORD_PAGES: u16 = 4;
/// Where the slots A and B begin.
pub const SLOTS: [u32; 2] = [0x8000, 0x3_8000];
/// Pages of each slot.
pub const SLOT_PAGES: u16 = 96;
/// Bytes of the flash.
pub const LEN: usize = 0x6_8000;
/// Bytes of the file of the host that holds it: as the emulator asks for. Those behind the flash are not
/// used.
pub const FILE_LEN: u64 = 16 << 20;

const SLOT_LEN: u32 = SLOT_PAGES as u32 * PAGE as u32;
const _: () = assert!(PARAMS_PAGES as u32 * PAGE as u32 <= RECORD);
const _: () = assert!(RECORD + RECORD_PAGES as u32 * PAGE as u32 <= SLOTS[0]);
const _: () = assert!(SLOTS[0] + SLOT_LEN <= SLOTS[1]);
const _: () = assert!(SLOTS[1] as usize + SLOT_LEN as usize == LEN);
