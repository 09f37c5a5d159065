//! The software that can be updated: where the slots are, and whose images are started.

use crate::flash::{Flash, Psram};
use crate::watchdog;
use embedded_storage::nor_flash::NorFlash;
use lafet_plant::flash::{BOARD, RECORD, RECORD_PAGES, SLOT_PAGES, SLOTS};
use lafet_update::{Board, BoardName, Memory, Partition, PublicKey, Receiver, Recorded, Started};

/// The keys that images are signed with. The secret of number 15 is `test.key` beside this crate, for all
/// to read: it is good for this emulated board only, and no other may have it in its list.
pub const KEYS: &[PublicKey] = &[PublicKey {
    id: 15,
    bytes: [
        0xBE, 0x00, 0xDE, 0x0E, 0x95, 0x3A, 0xF9, 0x4E, 0x90, 0xC8, 0x80, 0xA9, 0xB9, 0xA2, 0xCB,
        0xBD, 0x28, 0x2B, 0xF3, 0x49, 0x84, 0x3A, 0xB9, 0x74, 0x14, 0x0B, 0xF4, 0xF1, 0xB5, 0xD9,
        0xE3, 0x4A,
    ],
}];
/// The layout in which parameters are stored.
const LAYOUT: u16 = 1;

/// Slots and record.
pub const PARTITION: Partition =
    Partition { slots: SLOTS, slot_pages: SLOT_PAGES, record: RECORD, record_pages: RECORD_PAGES };

/// Slots and record on a flash.
pub const fn memory<F: NorFlash>(flash: F) -> Memory<F> {
    Memory::new(flash, PARTITION)
}

/// The board, as images name it. Its name is one that a board can have, so there is one.
pub fn board() -> Option<Board<'static>> {
    Some(Board { name: BoardName::new(BOARD)?, keys: KEYS })
}

/// The side of the running program that receives.
pub fn receiver(started: Started) -> Option<Receiver<'static, Flash<Psram>>> {
    let mut memory = memory(Flash::of_chip());
    let layout = match memory.record() {
        Recorded::Known(record) => record.layout,
        Recorded::Fresh | Recorded::Lost => LAYOUT,
    };
    let mut receiver = Receiver::new(memory, board()?, started, layout);
    // An order on trial may verify a slot three times.
    receiver.set_feed(watchdog::feed);
    Some(receiver)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_plant::flash::ADDRESS;
    use lafet_update::{SigningKey, Slot};

    #[test]
    fn the_key_is_that_of_the_file() {
        assert_eq!(KEYS[0], SigningKey::new(15, *include_bytes!("../test.key")).public());
        assert!(board().is_some());
    }

    /// A program is linked for the place at which its image is put.
    #[test]
    fn programs_are_linked_for_their_slots() {
        let memory = memory(Flash::of_chip());
        for (slot, script) in [
            (Slot::A, include_str!("../../memory/mps2-a.x")),
            (Slot::B, include_str!("../../memory/mps2-b.x")),
        ] {
            let place = ADDRESS + memory.payload_of(slot);
            let kib = memory.capacity() / 1024;
            let line =
                format!("FLASH : ORIGIN = {place:#010X}, LENGTH = {kib}K").replace("0X", "0x");
            assert!(script.contains(&line), "{line}");
        }
    }
}
