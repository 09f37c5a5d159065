//! The flash (RM §3.3.3, PM0075).

use super::Chip;

/// Where it begins.
pub const FLASH_START: u32 = 0x0800_0000;
/// Bytes of an STM32F103xC.
pub const FLASH_SIZE: usize = 256 * 1024;
pub(super) const CONTROL: u32 = 0x4002_2000;
const PAGE: usize = 2_048;
/// Datasheet, table 47: typical, and the greatest.
const PROGRAM_NS: u64 = 52_500;
const ERASE_NS: u64 = 40_000_000;
const LOCK: u32 = 1 << 7;

impl Chip {
    /// Writes half a word: of RAM, or of the flash where it is unlocked. Returns the ns for which the
    /// processor is stalled.
    pub fn write16(&mut self, address: u32, value: u16) -> u64 {
        let [low, high] = value.to_le_bytes();
        let Some(at) = address.checked_sub(FLASH_START).filter(|at| (*at as usize) < FLASH_SIZE)
        else {
            self.write8(address, low);
            self.write8(address + 1, high);
            return 0;
        };
        let control = self.word(CONTROL + 0x10);
        if control & LOCK != 0 || control & 1 == 0 {
            self.violations.insert("flash written while locked".into());
            return 0;
        }
        let Some(place) = self.flash.get_mut(at as usize..at as usize + 2) else { return 0 };
        // PM0075 §2.3.4: what is not erased takes nothing but 0.
        let flags = match *place == [0xFF, 0xFF] || value == 0 {
            true => {
                place.copy_from_slice(&[low, high]);
                1 << 5
            }
            false => 1 << 2,
        };
        let status = self.word(CONTROL + 0x0C);
        self.store(CONTROL + 0x0C, status | flags);
        PROGRAM_NS
    }

    pub(super) fn write_flash_control(&mut self, address: u32, value: u32) -> u64 {
        match address - CONTROL {
            // PM0075 §2.3.1: two keys in turn; a wrong one locks until the next reset.
            0x04 => {
                let right =
                    [0x4567_0123, 0xCDEF_89AB].get(usize::from(self.flash_keys)) == Some(&value);
                match (right, self.flash_keys) {
                    (true, 0) => self.flash_keys = 1,
                    (true, _) => {
                        self.flash_keys = 0;
                        let control = self.word(CONTROL + 0x10);
                        self.store(CONTROL + 0x10, control & !LOCK);
                    }
                    (false, _) => self.flash_keys = u8::MAX,
                }
            }
            // Flags are cleared by ones.
            0x0C => {
                let status = self.word(address);
                self.store(address, status & !(value & 0x34));
            }
            0x10 if self.word(address) & LOCK == 0 => {
                self.store(address, value & !(1 << 6));
                if value & 1 << 6 != 0 && value & 1 << 1 != 0 {
                    self.erase_page();
                    return ERASE_NS;
                }
            }
            0x10 => {}
            _ => self.store(address, value),
        }
        0
    }

    fn erase_page(&mut self) {
        self.erasures += 1;
        let at = self.word(CONTROL + 0x14).wrapping_sub(FLASH_START) as usize / PAGE * PAGE;
        match self.flash.get_mut(at..at + PAGE) {
            Some(page) => page.fill(0xFF),
            None => _ = self.violations.insert("erased what is no flash".into()),
        }
    }
}
