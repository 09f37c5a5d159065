//! The chip's own flash: its last four pages keep the parameters (RM §3.3.3, and PM0075).

use crate::bus::{Bus, Registers};
use crate::drives::may_move;
use crate::line;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use stm32_metapac::FLASH;
use stm32_metapac::flash::regs::{Ar, Sr};

/// Pages of the parameters.
pub const PAGES: u16 = 4;
/// Where they begin.
pub const START: u32 = 0x0803_E000;
/// Bytes of a page.
pub const PAGE: usize = 2_048;
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
/// Looks until an operation must be over: a page takes 40 ms at most (datasheet, table 47).
const LOOKS: u32 = 2_000_000;
/// Cycles of 72 MHz for which the processor is stalled at most: 40 ms, and 70 µs for half a word.
const ERASING: u32 = 3_000_000;
const PROGRAMMING: u32 = 5_040;

/// The pages of the parameters.
#[derive(Clone, Debug)]
pub struct InternalFlash<B> {
    bus: B,
}

/// The flash has reported an error, or something may move that a busy flash could not stop.
#[derive(Clone, Copy, Debug)]
pub struct Refused;

impl NorFlashError for Refused {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl<B: Bus> InternalFlash<B> {
    /// The pages.
    pub const fn new(bus: B) -> Self {
        Self { bus }
    }

    /// The processor is stalled while its flash is busy, so nothing may be driven meanwhile.
    fn unlock(&self) -> Result<(), Refused> {
        if may_move(&self.bus) {
            return Err(Refused);
        }
        for key in KEYS {
            self.bus.put(FLASH.keyr(), key);
        }
        Ok(())
    }

    fn lock(&self) {
        self.bus.set(FLASH.cr(), |cr| cr.set_lock(true));
    }

    /// Waits for the operation.
    fn finish(&self) -> Result<(), Refused> {
        let over = self.bus.wait(FLASH.sr(), LOOKS, |sr| !sr.bsy());
        let status = self.bus.get(FLASH.sr());
        // Flags are cleared by writing ones.
        self.bus.put(FLASH.sr(), Sr(status.0));
        if over && !status.pgerr() && !status.wrprterr() { Ok(()) } else { Err(Refused) }
    }

    fn erase_page(&self, page: u32) -> Result<(), Refused> {
        line::end_before(&self.bus, ERASING);
        self.bus.set(FLASH.cr(), |cr| cr.set_per(true));
        self.bus.put(FLASH.ar(), Ar(START + page));
        self.bus.set(FLASH.cr(), |cr| {
            cr.set_per(true);
            cr.set_strt(true);
        });
        self.finish()
    }
}

impl<B> ErrorType for InternalFlash<B> {
    type Error = Refused;
}

impl<B: Bus> ReadNorFlash for InternalFlash<B> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        for (address, byte) in (START + offset..).zip(bytes) {
            *byte = self.bus.read8(address);
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        usize::from(PAGES) * PAGE
    }
}

impl<B: Bus> NorFlash for InternalFlash<B> {
    const WRITE_SIZE: usize = 2;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        self.unlock()?;
        let mut result = Ok(());
        for page in (from..to).step_by(PAGE) {
            result = result.and(self.erase_page(page));
        }
        self.lock();
        result
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        self.unlock()?;
        self.bus.set(FLASH.cr(), |cr| cr.set_pg(true));
        let mut result = Ok(());
        for (address, pair) in (START + offset..).step_by(2).zip(bytes.as_chunks::<2>().0) {
            line::end_before(&self.bus, PROGRAMMING);
            self.bus.write16(address, u16::from_le_bytes(*pair));
            result = result.and(self.finish());
        }
        self.lock();
        result
    }
}
