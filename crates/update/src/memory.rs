//! The part of the flash that updating uses: two slots, and the pages of the record.
//!
//! ```text
//! slot    header 160 bytes | a mark for each page of the payload | to the end of the page
//!         payload, from a page of its own on
//! ```
//! A mark is a word of zeros: the page of the payload is complete.

use crate::hash::Hasher;
use crate::image::{Board, HEADER_LEN, Header, UNIT};
use crate::record::{RECORD_LEN, Record, Recorded, Slot};
use crate::refusal::Refusal;
use embedded_storage::nor_flash::NorFlash;
use lafet_device::hal::{Key, Storage};
use lafet_device::store::Store;

/// Bytes read or written at a time.
pub(crate) const CHUNK: usize = 64;
/// Longest word of a flash, bytes.
const WORD_MAX: usize = 8;
const RECORD: Key = Key(1);

/// Where in the flash the slots and the record are: at starts of pages.
#[derive(Clone, Copy, Debug)]
pub struct Partition {
    /// The addresses of slots A and B.
    pub slots: [u32; 2],
    /// Pages of each slot.
    pub slot_pages: u16,
    /// The address of the record.
    pub record: u32,
    /// Pages of the record: two or more.
    pub record_pages: u16,
}

/// The slots and the record.
#[derive(Clone, Debug)]
pub struct Memory<F> {
    store: Store<F, 1>,
    partition: Partition,
}

impl<F: NorFlash> Memory<F> {
    /// Starts on a part of the flash. It writes only what a power cut has left unsettled in the
    /// pages of the record.
    pub fn mount(flash: F, partition: Partition) -> Self {
        let store = Store::mount(flash, partition.record, partition.record_pages);
        Self { store, partition }
    }

    /// The flash.
    pub const fn flash(&self) -> &F {
        self.store.flash()
    }

    /// The flash, for settings of its own.
    pub const fn flash_mut(&mut self) -> &mut F {
        self.store.flash_mut()
    }

    /// Ends it.
    pub fn into_flash(self) -> F {
        self.store.into_flash()
    }

    /// The record.
    pub fn record(&mut self) -> Recorded {
        let mut buffer = [0; RECORD_LEN];
        match self.store.load(RECORD, &mut buffer) {
            Ok(None) => Recorded::Fresh,
            Ok(Some(bytes)) => Record::decode(bytes).map_or(Recorded::Lost, Recorded::Known),
            Err(_) => Recorded::Lost,
        }
    }

    /// Stores the record, whole or not at all.
    pub(crate) fn keep(&mut self, record: &Record) -> Result<(), Refusal> {
        self.store.store(RECORD, &record.encode()).map_err(|_| Refusal::Flash)
    }

    /// Pages of a slot in front of the payload.
    pub const fn header_pages(&self) -> usize {
        let all = self.partition.slot_pages as usize;
        (HEADER_LEN + all * F::WRITE_SIZE).div_ceil(F::ERASE_SIZE)
    }

    /// Bytes of the largest payload.
    pub const fn capacity(&self) -> usize {
        let all = self.partition.slot_pages as usize;
        all.saturating_sub(self.header_pages()).saturating_mul(F::ERASE_SIZE)
    }

    /// The address of a slot.
    pub const fn start_of(&self, slot: Slot) -> u32 {
        let [a, b] = self.partition.slots;
        match slot {
            Slot::A => a,
            Slot::B => b,
        }
    }

    /// The address at which the payload of a slot begins.
    pub const fn payload_of(&self, slot: Slot) -> u32 {
        self.start_of(slot).saturating_add((self.header_pages() * F::ERASE_SIZE) as u32)
    }

    /// Whether a payload has a size that a slot can take.
    pub const fn takes(&self, size: u32) -> bool {
        let size = size as usize;
        size > 0 && size <= self.capacity() && size.is_multiple_of(UNIT)
    }

    /// Verifies the image in a slot: header, signature, place, payload.
    ///
    /// # Errors
    ///
    /// Those of [`Header::check`], [`Refusal::Place`], [`Refusal::Size`], [`Refusal::Hash`],
    /// [`Refusal::Flash`].
    pub fn verify(
        &mut self,
        slot: Slot,
        board: &Board<'_>,
        revoked: u16,
    ) -> Result<Header, Refusal> {
        let raw = self.header(slot)?;
        let header = Header::check(&raw, board, revoked)?;
        if header.place.is_some_and(|place| place != slot) {
            return Err(Refusal::Place);
        }
        if !self.takes(header.size) {
            return Err(Refusal::Size);
        }
        let mut hasher = Hasher::default();
        self.hash(slot, 0..header.size, &mut hasher)?;
        if hasher.finish() == header.hash { Ok(header) } else { Err(Refusal::Hash) }
    }

    /// The header of a slot, whatever it is.
    pub(crate) fn header(&mut self, slot: Slot) -> Result<[u8; HEADER_LEN], Refusal> {
        let mut raw = [0; HEADER_LEN];
        self.read(self.start_of(slot), &mut raw)?;
        Ok(raw)
    }

    /// Hashes a part of the payload of a slot; it begins and ends at multiples of [`UNIT`].
    pub(crate) fn hash(
        &mut self,
        slot: Slot,
        part: core::ops::Range<u32>,
        hasher: &mut Hasher,
    ) -> Result<(), Refusal> {
        let start = self.payload_of(slot);
        for from in part.clone().step_by(CHUNK) {
            let mut buffer = [0; CHUNK];
            let len = (part.end - from).min(CHUNK as u32) as usize;
            let chunk = buffer.get_mut(..len).ok_or(Refusal::Flash)?;
            self.read(start.saturating_add(from), chunk)?;
            hasher.update(chunk);
        }
        Ok(())
    }

    /// How many pages of the payload, from the first on, are marked as complete.
    pub(crate) fn marked(&mut self, slot: Slot) -> usize {
        let pages = self.capacity() / F::ERASE_SIZE;
        let is_set = |page: &usize| {
            let mut word = [0xFF; WORD_MAX];
            let word = word.get_mut(..F::WRITE_SIZE).ok_or(Refusal::Flash);
            let read = word.and_then(|word| {
                self.read(self.mark(slot, *page), word).map(|()| word.iter().all(|byte| *byte == 0))
            });
            read == Ok(true)
        };
        (0..pages).take_while(is_set).count()
    }

    /// Marks a page of the payload as complete.
    pub(crate) fn set_mark(&mut self, slot: Slot, page: usize) -> Result<(), Refusal> {
        let zeros = [0; WORD_MAX];
        let word = zeros.get(..F::WRITE_SIZE).ok_or(Refusal::Flash)?;
        self.write(self.mark(slot, page), word)
    }

    const fn mark(&self, slot: Slot, page: usize) -> u32 {
        let at = HEADER_LEN + page.saturating_mul(F::WRITE_SIZE);
        self.start_of(slot).saturating_add(at as u32)
    }

    /// Makes the header of a slot again, with the marks of the first pages.
    pub(crate) fn begin(
        &mut self,
        slot: Slot,
        raw: &[u8; HEADER_LEN],
        marked: usize,
    ) -> Result<(), Refusal> {
        self.forget(slot)?;
        self.write(self.start_of(slot), raw)?;
        (0..marked).try_for_each(|page| self.set_mark(slot, page))
    }

    /// Erases the header of a slot.
    pub(crate) fn forget(&mut self, slot: Slot) -> Result<(), Refusal> {
        let start = self.start_of(slot);
        let pages = 0..self.header_pages() as u32;
        pages.rev().try_for_each(|page| {
            self.erase(start.saturating_add(page.saturating_mul(F::ERASE_SIZE as u32)))
        })
    }

    /// Erases the page that begins at an address.
    pub(crate) fn erase(&mut self, address: u32) -> Result<(), Refusal> {
        let end = address.checked_add(F::ERASE_SIZE as u32).ok_or(Refusal::Flash)?;
        self.flash_mut().erase(address, end).map_err(|_| Refusal::Flash)
    }

    pub(crate) fn write(&mut self, address: u32, bytes: &[u8]) -> Result<(), Refusal> {
        self.flash_mut().write(address, bytes).map_err(|_| Refusal::Flash)
    }

    fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<(), Refusal> {
        self.flash_mut().read(address, bytes).map_err(|_| Refusal::Flash)
    }
}
