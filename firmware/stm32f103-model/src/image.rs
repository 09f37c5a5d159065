//! What a new board's flash is given: the factory's record, and the parameters of a new monitor.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use lafet_device::composition::ChainSet;
use lafet_device::store::Store;
use lafet_device::{Composition, Device};
use lafet_stm32f103::board::CHAIN;
use lafet_stm32f103::flash::{PAGE, PAGES};
use lafet_stm32f103::record::{Record, START};

use crate::chip::{FLASH_SIZE, FLASH_START};

/// Bytes of the image.
pub const SIZE: usize = PAGE * (1 + PAGES as usize);

/// Pages in memory that behave as those of the chip.
struct Pages(Vec<u8>);

/// A write to what is not erased, or beyond the end.
#[derive(Clone, Copy, Debug)]
struct Refused;

impl NorFlashError for Refused {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

impl ErrorType for Pages {
    type Error = Refused;
}

impl ReadNorFlash for Pages {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        let at = offset as usize;
        bytes.copy_from_slice(self.0.get(at..at + bytes.len()).ok_or(Refused)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for Pages {
    const WRITE_SIZE: usize = 2;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        self.0.get_mut(from as usize..to as usize).ok_or(Refused)?.fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        let at = offset as usize;
        let place = self.0.get_mut(at..at + bytes.len()).ok_or(Refused)?;
        place.copy_from_slice(bytes);
        Ok(())
    }
}

/// The image for a monitor of this composition, to be written to [`START`]. What the board does not
/// have is not in its chain.
pub fn provision(
    record: &Record,
    composition: &Composition,
    address: u8,
) -> Result<Vec<u8>, String> {
    let bits = composition.chain.bits() & CHAIN.bits();
    let composition = Composition { chain: ChainSet::from_bits(bits), ..*composition };
    let pages = Pages(vec![0xFF; PAGE * usize::from(PAGES)]);
    let mut memory: Store<Pages> = Store::mount(pages, 0, PAGES);
    Device::provision(&mut memory, &composition, address)
        .map_err(|error| format!("the parameters do not fit: {error:?}"))?;
    let mut image = record.encode().to_vec();
    image.resize(PAGE, 0xFF);
    image.extend(memory.into_flash().0);
    Ok(image)
}

/// The flash of a chip with this image, and of one that is blank.
pub fn flash(image: Option<&[u8]>) -> Vec<u8> {
    let mut flash = vec![0xFF; FLASH_SIZE];
    if let Some(image) = image {
        let at = (START - FLASH_START) as usize;
        flash[at..at + image.len()].copy_from_slice(image);
    }
    flash
}
