//! A NOR flash with words of 8 bytes and pages of 2 KiB, and the rules of one: a word is written when it is
//! erased, or becomes zeros. What breaks them is refused.
//!
//! A power cut leaves a word or a page half written, as that of a chip does. A word of ones that is written
//! still counts as erased here, which a chip may see differently.

use crate::register::{read, write};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};
use lafet_plant::flash::{ADDRESS, LEN, PAGE, WORD};

const ERASED: u32 = u32::MAX;
const CELL: usize = size_of::<u32>();

/// The memory below the flash, in cells of four bytes. Places are multiples of four, inside of the flash.
pub trait Cells {
    /// What is in a cell.
    fn load(&self, at: u32) -> u32;

    /// Changes a cell.
    fn store(&mut self, at: u32, value: u32);
}

/// The memory of the chip that is a file of the host.
#[derive(Clone, Debug)]
pub struct Psram(());

impl Cells for Psram {
    fn load(&self, at: u32) -> u32 {
        read(ADDRESS as usize + at as usize)
    }

    fn store(&mut self, at: u32, value: u32) {
        write(ADDRESS as usize + at as usize, value);
    }
}

/// The flash.
#[derive(Clone, Debug)]
pub struct Flash<C>(C);

impl Flash<Psram> {
    /// The flash of the chip. Its parts have different users: the parameters, the record and the slots.
    pub const fn of_chip() -> Self {
        Self(Psram(()))
    }
}

impl<C: Cells> Flash<C> {
    /// A word becomes what it is to be, half by half.
    fn program(&mut self, at: u32, halves: [u32; 2]) -> Result<(), NorFlashErrorKind> {
        let places = [at, at + CELL as u32];
        let erased = places.iter().all(|place| self.0.load(*place) == ERASED);
        if !erased && halves != [0; 2] {
            return Err(NorFlashErrorKind::Other);
        }
        for (place, half) in places.into_iter().zip(halves) {
            self.0.store(place, half);
        }
        Ok(())
    }
}

/// Why the flash refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused(NorFlashErrorKind);

impl NorFlashError for Refused {
    fn kind(&self) -> NorFlashErrorKind {
        self.0
    }
}

impl<C> ErrorType for Flash<C> {
    type Error = Refused;
}

impl<C: Cells> ReadNorFlash for Flash<C> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        check_read(self, offset, bytes.len()).map_err(Refused)?;
        for (at, byte) in (offset..).zip(bytes) {
            *byte = (self.0.load(at & !3) >> (8 * (at & 3))) as u8;
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        LEN
    }
}

impl<C: Cells> NorFlash for Flash<C> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        check_erase(self, from, to).map_err(Refused)?;
        for at in (from..to).step_by(CELL) {
            self.0.store(at, ERASED);
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        check_write(self, offset, bytes.len()).map_err(Refused)?;
        let (words, _) = bytes.as_chunks::<WORD>();
        for (at, [b0, b1, b2, b3, b4, b5, b6, b7]) in (offset..).step_by(WORD).zip(words) {
            let low = u32::from_le_bytes([*b0, *b1, *b2, *b3]);
            let high = u32::from_le_bytes([*b4, *b5, *b6, *b7]);
            self.program(at, [low, high]).map_err(Refused)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Ram(Vec<u32>);

    impl Cells for Ram {
        fn load(&self, at: u32) -> u32 {
            self.0[at as usize / CELL]
        }

        fn store(&mut self, at: u32, value: u32) {
            self.0[at as usize / CELL] = value;
        }
    }

    fn flash() -> Flash<Ram> {
        Flash(Ram(vec![0x1234_5678; LEN / CELL]))
    }

    fn kind<T: std::fmt::Debug>(result: Result<T, Refused>) -> NorFlashErrorKind {
        result.unwrap_err().kind()
    }

    #[test]
    fn what_is_written_is_read_byte_by_byte() {
        let mut flash = flash();
        flash.erase(0, PAGE as u32).unwrap();
        let text = *b"0123456789abcdef";
        flash.write(16, &text).unwrap();
        let mut read = [0; 18];
        flash.read(15, &mut read).unwrap();
        assert_eq!((read[0], &read[1..17], read[17]), (0xFF, &text[..], 0xFF));
    }

    #[test]
    fn a_word_is_written_once_and_then_only_to_zeros() {
        let mut flash = flash();
        assert_eq!(kind(flash.write(0, &[1; 8])), NorFlashErrorKind::Other, "not erased");
        flash.erase(0, PAGE as u32).unwrap();
        flash.write(0, &[0xF0; 8]).unwrap();
        for over in [[0xF0; 8], [0x10; 8], [0xFF; 8], [0, 0, 0, 0, 0, 0, 0, 1]] {
            assert_eq!(kind(flash.write(0, &over)), NorFlashErrorKind::Other, "{over:?}");
        }
        let mut read = [0; 8];
        flash.read(0, &mut read).unwrap();
        assert_eq!(read, [0xF0; 8], "a refusal changes nothing");
        flash.write(0, &[0; 8]).unwrap();
        flash.write(0, &[0; 8]).unwrap();
        flash.read(0, &mut read).unwrap();
        assert_eq!(read, [0; 8]);
        // A half that a power cut has left.
        flash.0.store(8, 0);
        assert_eq!(kind(flash.write(8, &[1; 8])), NorFlashErrorKind::Other);
        flash.write(8, &[0; 8]).unwrap();
    }

    #[test]
    fn an_erase_is_of_whole_pages_and_of_those_alone() {
        let mut flash = flash();
        flash.erase(PAGE as u32, 2 * PAGE as u32).unwrap();
        let mut around = vec![0; PAGE + 2];
        flash.read(PAGE as u32 - 1, &mut around).unwrap();
        let (first, last) = (around[0], around[PAGE + 1]);
        assert_eq!((first, last), (0x12, 0x78));
        assert!(around[1..=PAGE].iter().all(|byte| *byte == 0xFF));
    }

    #[test]
    fn what_is_no_word_or_page_or_outside_is_refused() {
        let (mut flash, page, end) = (flash(), PAGE as u32, LEN as u32);
        assert_eq!(kind(flash.write(4, &[0; 8])), NorFlashErrorKind::NotAligned);
        assert_eq!(kind(flash.write(0, &[0; 4])), NorFlashErrorKind::NotAligned);
        assert_eq!(kind(flash.erase(8, page)), NorFlashErrorKind::NotAligned);
        assert_eq!(kind(flash.erase(0, page + 8)), NorFlashErrorKind::NotAligned);
        assert_eq!(kind(flash.write(end, &[0; 8])), NorFlashErrorKind::OutOfBounds);
        assert_eq!(kind(flash.erase(end, end + page)), NorFlashErrorKind::OutOfBounds);
        assert_eq!(kind(flash.read(end - 1, &mut [0; 2])), NorFlashErrorKind::OutOfBounds);
        flash.read(end - 1, &mut [0]).unwrap();
    }
}
