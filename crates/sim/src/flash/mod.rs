//! The non-volatile memory: the monitor's own power-safe store on a simulated flash chip, which
//! outlives resets and power cycles.

mod chip;

use lafet_device::hal::{Key, Storage, StorageError};
use lafet_device::store::Store;
use lafet_proto::link::crc16;

pub use chip::{Chip, ChipError, Cut, ERASE_US, PAGE, PAGES, Torn, WORD, WRITE_US};

use crate::fault::{Faults, SingleFault};

/// The memory. It does no I/O: `to_bytes` and `from_bytes` let a caller keep it in a file.
#[derive(Clone, Debug)]
pub struct Flash(Store<Chip>);

/// The bytes are not a memory that `to_bytes` made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damaged;

impl core::fmt::Display for Damaged {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("not the memory of a simulated monitor, or damaged")
    }
}

impl core::error::Error for Damaged {}

const MAGIC: &[u8] = b"lafet flash 2\n";

impl Flash {
    /// Nothing has ever been stored: a new chip.
    pub fn new(seed: u64) -> Self {
        Self::on(Chip::new(seed))
    }

    fn on(chip: Chip) -> Self {
        Self(Store::mount(chip, 0, PAGES as u16))
    }

    /// The chip.
    pub const fn chip(&self) -> &Chip {
        self.0.flash()
    }

    /// The chip: bits to flip.
    pub const fn chip_mut(&mut self) -> &mut Chip {
        self.0.flash_mut()
    }

    /// Flips a bit of a stored value, as a worn cell would; false when nothing is stored there.
    pub fn damage(&mut self, key: Key) -> bool {
        let Some(address) = self.0.address_of(key) else { return false };
        self.chip_mut().flip(address as usize, 0);
        true
    }

    /// Cuts the power in a word or erase to come; takes that back without one.
    pub const fn cut(&mut self, cut: Option<Cut>) {
        self.chip_mut().arm(cut);
    }

    /// From here on `Chip::busy_us` counts.
    pub(crate) fn begin(&mut self) {
        self.chip_mut().begin();
    }

    /// Power fails while the chip is busy, this long after `begin`.
    pub(crate) fn interrupt(&mut self, at_us: u64) {
        self.chip_mut().interrupt(at_us);
    }

    /// The program starts: it mounts the store again.
    pub(crate) fn start(&mut self, faults: &Faults) {
        self.broken(faults);
        self.chip_mut().power_on();
        let chip = core::mem::replace(self.chip_mut(), Chip::new(0));
        *self = Self::on(chip);
    }

    fn broken(&mut self, faults: &Faults) -> &mut Store<Chip> {
        let chip = self.0.flash_mut();
        chip.unreadable = faults.single(SingleFault::FlashRead);
        chip.unwritable = faults.single(SingleFault::FlashWrite);
        &mut self.0
    }

    pub(crate) fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
        faults: &Faults,
    ) -> Result<Option<&'b [u8]>, StorageError> {
        self.broken(faults).load(key, buffer)
    }

    pub(crate) fn store(
        &mut self,
        key: Key,
        value: &[u8],
        faults: &Faults,
    ) -> Result<(), StorageError> {
        self.broken(faults).store(key, value)
    }

    pub(crate) fn erase(&mut self, faults: &Faults) -> Result<(), StorageError> {
        self.broken(faults).erase()
    }

    /// The whole chip: a line of text, the erases of each page (u32), its bytes, a CRC-16 of all.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(self.chip().erases().iter().flat_map(|erases| erases.to_le_bytes()));
        bytes.extend_from_slice(self.chip().bytes());
        bytes.extend_from_slice(&crc16(&bytes).to_le_bytes());
        bytes
    }

    /// Reads what `to_bytes` wrote.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Damaged> {
        let (bytes, crc) = bytes.split_last_chunk().ok_or(Damaged)?;
        let rest = bytes.strip_prefix(MAGIC).ok_or(Damaged)?;
        if crc16(bytes) != u16::from_le_bytes(*crc) {
            return Err(Damaged);
        }
        let (counts, image) = rest.split_at_checked(4 * PAGES).ok_or(Damaged)?;
        let counts = counts.as_chunks::<4>().0.iter();
        let erases = counts.map(|count| u32::from_le_bytes(*count)).collect();
        Chip::of(image, erases).map(Self::on).ok_or(Damaged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;

    #[test]
    fn keeps_replaces_erases() {
        let mut flash = Flash::new(1);
        let faults = Faults::default();
        let mut buffer = [0; 16];
        assert_eq!(flash.load(Key(7), &mut buffer, &faults), Ok(None));
        flash.store(Key(7), &[1, 2, 3], &faults).unwrap();
        flash.store(Key(7), &[4, 5], &faults).unwrap();
        flash.start(&faults);
        assert_eq!(flash.load(Key(7), &mut buffer, &faults), Ok(Some(&[4, 5][..])));
        assert!(flash.damage(Key(7)) && !flash.damage(Key(8)));
        assert_eq!(flash.load(Key(7), &mut buffer, &faults), Err(StorageError::Read));
        flash.erase(&faults).unwrap();
        flash.start(&faults);
        assert_eq!(flash.load(Key(7), &mut buffer, &faults), Ok(None));
    }

    #[test]
    fn image() {
        let faults = Faults::default();
        let mut flash = Flash::new(1);
        flash.store(Key(7), &[4, 5], &faults).unwrap();
        let image = flash.to_bytes();
        let mut again = Flash::from_bytes(&image).unwrap();
        assert_eq!(again.load(Key(7), &mut [0; 4], &faults), Ok(Some(&[4, 5][..])));
        assert_eq!(again.chip().erases(), flash.chip().erases());
        let mut flipped = image.clone();
        flipped[5000] ^= 4;
        for damaged in [&image[..17], &image[..image.len() - 1], &flipped, b"something", b""] {
            assert_eq!(Flash::from_bytes(damaged).err(), Some(Damaged));
        }
    }

    /// A fault that passes costs nothing: not what was stored, and not what is stored afterwards.
    #[test]
    fn faults() {
        let mut flash = Flash::new(1);
        let (good, mut faults) = (Faults::default(), Faults::default());
        flash.store(Key(1), &[7], &good).unwrap();
        faults.inject(Fault::Single(SingleFault::FlashWrite));
        assert_eq!(flash.store(Key(1), &[1], &faults), Err(StorageError::Write));
        assert_eq!(flash.erase(&faults), Err(StorageError::Write));
        assert_eq!(flash.load(Key(1), &mut [0; 4], &faults), Ok(Some(&[7][..])));
        faults.inject(Fault::Single(SingleFault::FlashRead));
        flash.start(&faults);
        for key in [1, 2] {
            assert_eq!(flash.load(Key(key), &mut [0; 4], &faults), Err(StorageError::Read));
        }
        assert_eq!(flash.store(Key(2), &[1], &faults), Err(StorageError::Write));
        flash.store(Key(2), &[2], &good).unwrap();
        flash.start(&good);
        assert_eq!(flash.load(Key(1), &mut [0; 4], &good), Ok(Some(&[7][..])));
        assert_eq!(flash.load(Key(2), &mut [0; 4], &good), Ok(Some(&[2][..])));
    }
}
