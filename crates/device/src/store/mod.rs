//! Non-volatile memory (ЭНОЗУ) on NOR flash that survives a power cut at any moment (ours).
//!
//! A log of entries goes round a ring of pages; the newest entry of a key counts. One page of the
//! ring is always free. To open it for new entries, the live ones of the oldest page are copied
//! there, then its header and a mark are written; from that mark on the oldest page is the free
//! one. Entries, too, count from a mark on. Whatever a power cut leaves half written is
//! behind the last mark, and nothing is ever written behind it again: a page takes entries only
//! until the next start.
//!
//! docs/storage.md has the format, the reasons, and what has been tested and measured.

mod format;
mod mount;
mod write;

use crate::hal::{Key, Storage, StorageError, VALUE_MAX};
use core::num::NonZeroU32;
use embedded_storage::nor_flash::NorFlash;
use format::{CHECK, DAMAGED, ENTRY_HEADER, Entry, PAGE_HEADER, ValueCheck};

/// Keys that a store holds by default: what `Params` needs, and a few more.
pub const KEYS: usize = 40;

/// Bytes read or written at a time.
const CHUNK: usize = 64;
/// A read that fails once, or reads a bit wrongly, must not cost what is stored.
const TRIES: usize = 3;

/// A power-safe `Storage` on the pages of a NOR flash.
///
/// Each value is replaced as a whole or not at all; what was acknowledged by `Ok` is there at
/// every later start. A damaged value is reported by `StorageError::Read`, and costs no other.
#[derive(Clone, Debug)]
pub struct Store<F, const N: usize = KEYS> {
    flash: F,
    geometry: Geometry,
    head: Head,
    slots: [Slot; N],
    /// Values have been lost to damage, so a key that is not found may have been set.
    lost: bool,
}

/// How the flash is divided.
#[derive(Clone, Copy, Debug)]
struct Geometry {
    start: u32,
    pages: NonZeroU32,
    page: usize,
    word: usize,
}

/// The newest page of the log.
#[derive(Clone, Copy, Debug, Default)]
struct Head {
    /// 0 while there is none.
    seq: u32,
    /// The oldest page of the log.
    first: u32,
    /// Where its valid entries end.
    end: usize,
    /// It was opened since the start, so what is behind its end is erased beyond doubt.
    is_open: bool,
}

/// Where the newest entry of a key is.
#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    key: u16,
    len: u16,
    page: u16,
    /// 0 in an unused slot.
    at: u16,
}

impl Slot {
    fn entry(self) -> Entry {
        Entry { key: self.key, len: self.len }
    }
}

impl<F: NorFlash, const N: usize> Store<F, N> {
    /// Starts the store on `pages` pages of the flash from the address `start` on.
    ///
    /// Never fails, and its work is bounded by the size of the flash. It writes only after a power
    /// cut that hit a write; then it erases one page at most.
    pub fn mount(flash: F, start: u32, pages: u16) -> Self {
        const {
            assert!(matches!(F::WRITE_SIZE, 1 | 2 | 4 | 8));
            assert!(F::WRITE_SIZE.is_multiple_of(F::READ_SIZE));
            assert!(F::ERASE_SIZE.is_multiple_of(8) && F::ERASE_SIZE <= 0x8000);
        }
        let pages = NonZeroU32::new(pages.into()).unwrap_or(NonZeroU32::MIN);
        let geometry = Geometry { start, pages, page: F::ERASE_SIZE, word: F::WRITE_SIZE };
        let (head, slots) = (Head::default(), [Slot::default(); N]);
        let mut store = Self { flash, geometry, head, slots, lost: false };
        store.scan();
        store
    }

    /// A flash that could not be read at all at the start is looked at again before anything is
    /// written: whatever is written on top of an unknown log would be lost at the next start.
    fn ready(&mut self) -> Result<(), StorageError> {
        if self.is_unreadable() {
            self.lost = false;
            self.scan();
        }
        if self.is_unreadable() { Err(StorageError::Write) } else { Ok(()) }
    }

    const fn is_unreadable(&self) -> bool {
        self.lost && self.head.seq == 0
    }

    /// Makes room for a value of any size now, so that the next `store` erases nothing.
    ///
    /// For a moment in which nothing moves: it erases one page at most. `false` when there was
    /// nothing to do. It costs one erase in each power-up in which it is called.
    ///
    /// # Errors
    ///
    /// [`StorageError::Write`] when the flash cannot be read or a page cannot be erased.
    pub fn prepare(&mut self) -> Result<bool, StorageError> {
        self.ready()?;
        let need = self.size(Entry { key: 0, len: VALUE_MAX as u16 });
        if self.head_has_room(need) || !self.ring_has_room(need) {
            return Ok(false);
        }
        self.open_page(false).map(|()| true).ok_or(StorageError::Write)
    }

    /// Pages opened since the flash was new: as many erases, spread evenly over the pages.
    pub const fn opened(&self) -> u32 {
        self.head.seq
    }

    /// The flash.
    pub const fn flash(&self) -> &F {
        &self.flash
    }

    /// The flash, for settings of its own. What the store has written there must stay.
    pub const fn flash_mut(&mut self) -> &mut F {
        &mut self.flash
    }

    /// Where a value begins in the flash; `None` when it is unset or empty.
    pub fn address_of(&self, key: Key) -> Option<u32> {
        let slot = self.slot(key.0).filter(|slot| slot.entry().value_len() > 0)?;
        self.address(slot.page.into(), usize::from(slot.at) + ENTRY_HEADER, 0)
    }

    /// Ends the store.
    pub fn into_flash(self) -> F {
        self.flash
    }

    /// Where the marks of a page end and its entries begin.
    const FIRST: usize = PAGE_HEADER + 3 * F::WRITE_SIZE;

    /// Bytes that an entry takes: header, value and checksum, two marks.
    fn size(&self, entry: Entry) -> usize {
        let value = (entry.value_len() + CHECK).next_multiple_of(F::WRITE_SIZE);
        ENTRY_HEADER + value + 2 * F::WRITE_SIZE
    }

    fn head_has_room(&self, need: usize) -> bool {
        self.head.is_open && self.head.end + need <= F::ERASE_SIZE
    }

    /// Whether one of the pages still to be opened will have room after the copies: it takes
    /// over what lives in the oldest page, so what counts is what lives in each page.
    fn ring_has_room(&self, need: usize) -> bool {
        let next = self.place(self.head.seq.wrapping_add(1));
        let live = |page: u32| -> usize {
            let slots = self.slots.iter().filter(|slot| slot.at != 0);
            let here = slots.filter(|slot| u32::from(slot.page) == page);
            here.map(|slot| self.size(slot.entry())).sum()
        };
        let mut pages = (0..self.geometry.pages.get()).filter(|page| *page != next);
        pages.any(|page| Self::FIRST + live(page) + need <= F::ERASE_SIZE)
    }

    /// The page of the flash in which a page of the log is.
    fn place(&self, seq: u32) -> u32 {
        seq % self.geometry.pages
    }

    fn slot(&self, key: u16) -> Option<Slot> {
        self.slots.iter().find(|slot| slot.at != 0 && slot.key == key).copied()
    }

    /// Remembers where the newest entry of a key is; false without a free slot.
    fn note(&mut self, entry: Entry, page: u32, at: usize) -> bool {
        let used = |slot: &&mut Slot| slot.at != 0 && slot.key == entry.key;
        let place = match self.slots.iter_mut().find(used) {
            Some(slot) => Some(slot),
            None => self.slots.iter_mut().find(|slot| slot.at == 0),
        };
        let Some(place) = place else { return false };
        *place = Slot { key: entry.key, len: entry.len, page: page as u16, at: at as u16 };
        true
    }

    /// Reads a value piece by piece, from its beginning again when it is wrong; whether its checksum
    /// is right.
    fn read_value(&mut self, slot: Slot, take: &mut dyn FnMut(usize, &[u8])) -> bool {
        (0..TRIES).any(|_| self.read_value_once(slot, take))
    }

    fn read_value_once(&mut self, slot: Slot, take: &mut dyn FnMut(usize, &[u8])) -> bool {
        let len = slot.entry().value_len();
        let stored = (len + CHECK).next_multiple_of(F::WRITE_SIZE);
        let mut check = ValueCheck::new(slot.entry());
        let mut expected = [0; CHECK];
        for from in (0..stored).step_by(CHUNK) {
            let mut buffer = [0; CHUNK];
            let Some(chunk) = buffer.get_mut(..(stored - from).min(CHUNK)) else { return false };
            let at = usize::from(slot.at) + ENTRY_HEADER + from;
            if self.read(slot.page.into(), at, chunk).is_none() {
                return false;
            }
            let in_value = len.saturating_sub(from).min(chunk.len());
            let (value, rest) = chunk.split_at_checked(in_value).unwrap_or_default();
            check.update(value);
            take(from, value);
            let done = (from + in_value).saturating_sub(len);
            for (byte, read) in expected.iter_mut().skip(done).zip(rest) {
                *byte = *read;
            }
        }
        check.finish() == expected
    }

    fn read(&mut self, page: u32, at: usize, buffer: &mut [u8]) -> Option<()> {
        let address = self.address(page, at, buffer.len())?;
        (0..TRIES).find_map(|_| self.flash.read(address, buffer).ok())
    }

    /// What cannot be read is not erased: a half-written word of a flash that checks its words.
    fn is_erased(&mut self, page: u32, at: usize, len: usize) -> bool {
        (0..len).step_by(CHUNK).all(|from| {
            let mut buffer = [0; CHUNK];
            let Some(chunk) = buffer.get_mut(..(len - from).min(CHUNK)) else { return false };
            self.read(page, at + from, chunk).is_some() && chunk.iter().all(|byte| *byte == 0xFF)
        })
    }

    /// Nothing is read or written across the end of a page.
    fn address(&self, page: u32, at: usize, len: usize) -> Option<u32> {
        if at.checked_add(len)? > F::ERASE_SIZE {
            return None;
        }
        let page = page.checked_mul(F::ERASE_SIZE as u32)?;
        self.geometry.start.checked_add(page)?.checked_add(at as u32)
    }
}

impl<F: NorFlash, const N: usize> Storage for Store<F, N> {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        let Some(slot) = self.slot(key.0) else {
            return if self.lost { Err(StorageError::Read) } else { Ok(None) };
        };
        let value = buffer.get_mut(..slot.entry().value_len()).ok_or(StorageError::Read)?;
        let whole = self.read_value(slot, &mut |from, bytes| {
            for (place, byte) in value.iter_mut().skip(from).zip(bytes) {
                *place = *byte;
            }
        });
        if whole && slot.len != DAMAGED { Ok(Some(value)) } else { Err(StorageError::Read) }
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        if value.len() > VALUE_MAX {
            return Err(StorageError::Write);
        }
        self.ready()?;
        let entry = Entry { key: key.0, len: value.len() as u16 };
        if self.holds(entry, value) {
            return Ok(());
        }
        self.write_entry(entry, value).ok_or(StorageError::Write)
    }

    /// All gone when it returns `Ok`; after a power cut all there or all gone. What has been
    /// erased can still be found in the flash by other means until its page is used again.
    fn erase(&mut self) -> Result<(), StorageError> {
        self.ready()?;
        if !self.lost && self.slots.iter().all(|slot| slot.at == 0) {
            return Ok(());
        }
        self.open_page(true).ok_or(StorageError::Write)
    }
}
