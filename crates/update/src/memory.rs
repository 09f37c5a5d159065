//! The part of the flash that updating uses: two slots, and the pages of the record.
//!
//! ```text
//! slot    header 160 bytes | a mark for each page of the payload | received | confirmed
//!         payload, from a page of its own on
//! record  a store with the record | another one with the same record
//! ```
//! A mark is a word of zeros. That of a page of the payload: the page is complete. `received`: the
//! image came over the link; `confirmed`: it has been confirmed since.

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
/// What fails may fail but once: a read, a write, a verification.
const TRIES: usize = 3;

/// Where in the flash the slots and the record are: at starts of pages.
#[derive(Clone, Copy, Debug)]
pub struct Partition {
    /// The addresses of slots A and B.
    pub slots: [u32; 2],
    /// Pages of each slot.
    pub slot_pages: u16,
    /// The address of the record.
    pub record: u32,
    /// Pages of the record: four or more, an even number. Each half has a copy of it.
    pub record_pages: u16,
}

/// The slots and the record.
#[derive(Clone, Debug)]
pub struct Memory<F> {
    flash: F,
    partition: Partition,
}

impl<F: NorFlash> Memory<F> {
    /// On a part of the flash. Nothing is read or written yet.
    pub const fn new(flash: F, partition: Partition) -> Self {
        Self { flash, partition }
    }

    /// The flash.
    pub const fn flash(&self) -> &F {
        &self.flash
    }

    /// The flash, for settings of its own.
    pub const fn flash_mut(&mut self) -> &mut F {
        &mut self.flash
    }

    /// Ends it.
    pub fn into_flash(self) -> F {
        self.flash
    }

    /// The record. It writes what a power cut has left unsettled in its pages, and a copy that has
    /// been damaged or is behind.
    pub fn record(&mut self) -> Recorded {
        match [0, 1].map(|half| self.copy(half)) {
            // The first is written first, so where both can be read it is the newer one.
            [Recorded::Known(record), other] | [other, Recorded::Known(record)] => {
                if other != Recorded::Known(record) {
                    let _ = self.keep(&record);
                }
                Recorded::Known(record)
            }
            [Recorded::Fresh, Recorded::Fresh] => Recorded::Fresh,
            _ => Recorded::Lost,
        }
    }

    fn copy(&mut self, half: u16) -> Recorded {
        let mut buffer = [0; RECORD_LEN];
        match self.store(half).load(RECORD, &mut buffer) {
            Ok(None) => Recorded::Fresh,
            Ok(Some(bytes)) => Record::decode(bytes).map_or(Recorded::Lost, Recorded::Known),
            Err(_) => Recorded::Lost,
        }
    }

    /// Half of the pages of the record.
    fn store(&mut self, half: u16) -> Store<&mut F, 1> {
        let pages = self.partition.record_pages / 2;
        let before = u32::from(half * pages).saturating_mul(F::ERASE_SIZE as u32);
        let start = self.partition.record.saturating_add(before);
        Store::mount(&mut self.flash, start, pages)
    }

    /// Stores the record, whole or not at all. It is stored when its first copy is: the next
    /// [`Self::record`] makes up for the second.
    pub(crate) fn keep(&mut self, record: &Record) -> Result<(), Refusal> {
        let bytes = record.encode();
        for half in [0, 1] {
            let kept = (0..TRIES).any(|_| self.store(half).store(RECORD, &bytes).is_ok());
            if half == 0 && !kept {
                return Err(Refusal::Flash);
            }
        }
        Ok(())
    }

    /// Pages of a slot in front of the payload.
    pub const fn header_pages(&self) -> usize {
        let marks = self.confirmed() + 1;
        (HEADER_LEN + marks * F::WRITE_SIZE).div_ceil(F::ERASE_SIZE)
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

    /// Verifies the image in a slot: header, signature, place, payload. What does not verify is
    /// looked at again, since nothing may be given up for a bit that was read wrongly once. `feed` is
    /// called all the while, for a watchdog.
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
        feed: &mut impl FnMut(),
    ) -> Result<Header, Refusal> {
        let mut verified = Err(Refusal::Flash);
        for _ in 0..TRIES {
            verified = self.verify_once(slot, board, revoked, feed);
            if verified.is_ok() {
                break;
            }
        }
        verified
    }

    fn verify_once(
        &mut self,
        slot: Slot,
        board: &Board<'_>,
        revoked: u16,
        feed: &mut impl FnMut(),
    ) -> Result<Header, Refusal> {
        feed();
        let raw = self.header(slot)?;
        let header = Header::check(&raw, board, revoked)?;
        if header.place.is_some_and(|place| place != slot) {
            return Err(Refusal::Place);
        }
        if !self.takes(header.size) {
            return Err(Refusal::Size);
        }
        let mut hasher = Hasher::default();
        for from in (0..header.size).step_by(CHUNK) {
            feed();
            let end = header.size.min(from.saturating_add(CHUNK as u32));
            self.hash(slot, from..end, &mut hasher)?;
        }
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
        (0..pages).take_while(|page| self.is_set(slot, *page) == Ok(true)).count()
    }

    /// An image that has been confirmed, or that did not come over the link.
    pub(crate) fn is_trusted(&mut self, slot: Slot) -> bool {
        let received = self.is_set(slot, self.received());
        received == Ok(false) || self.is_set(slot, self.confirmed()) == Ok(true)
    }

    /// Marks the image of a slot as one that has been confirmed.
    pub(crate) fn trust(&mut self, slot: Slot) -> Result<(), Refusal> {
        if self.is_trusted(slot) { Ok(()) } else { self.set_mark(slot, self.confirmed()) }
    }

    /// Marks behind those of the pages, which are fewer than the pages of a slot.
    const fn received(&self) -> usize {
        (self.partition.slot_pages as usize).saturating_sub(1)
    }

    const fn confirmed(&self) -> usize {
        self.partition.slot_pages as usize
    }

    /// Whether most bits of a mark are: one of them may have flipped.
    fn is_set(&mut self, slot: Slot, mark: usize) -> Result<bool, Refusal> {
        let mut word = [0xFF; WORD_MAX];
        let word = word.get_mut(..F::WRITE_SIZE).ok_or(Refusal::Flash)?;
        self.read(self.mark(slot, mark), word)?;
        let zeros: u32 = word.iter().map(|byte| byte.count_zeros()).sum();
        Ok(zeros as usize > word.len() * 4)
    }

    /// Sets a mark: that of a page of the payload, when it is complete.
    pub(crate) fn set_mark(&mut self, slot: Slot, mark: usize) -> Result<(), Refusal> {
        let zeros = [0; WORD_MAX];
        let word = zeros.get(..F::WRITE_SIZE).ok_or(Refusal::Flash)?;
        self.write(self.mark(slot, mark), word)
    }

    const fn mark(&self, slot: Slot, mark: usize) -> u32 {
        let at = HEADER_LEN + mark.saturating_mul(F::WRITE_SIZE);
        self.start_of(slot).saturating_add(at as u32)
    }

    /// Makes the header of a slot again, with the marks of the first pages. There is no header
    /// without the mark that it was received.
    pub(crate) fn begin(
        &mut self,
        slot: Slot,
        raw: &[u8; HEADER_LEN],
        marked: usize,
    ) -> Result<(), Refusal> {
        self.forget(slot)?;
        self.set_mark(slot, self.received())?;
        self.write(self.start_of(slot), raw)?;
        (0..marked).try_for_each(|page| self.set_mark(slot, page))
    }

    /// Erases the header of a slot, then its marks.
    pub(crate) fn forget(&mut self, slot: Slot) -> Result<(), Refusal> {
        let start = self.start_of(slot);
        let mut pages = 0..self.header_pages() as u32;
        pages.try_for_each(|page| {
            self.erase(start.saturating_add(page.saturating_mul(F::ERASE_SIZE as u32)))
        })
    }

    /// Erases the page that begins at an address.
    pub(crate) fn erase(&mut self, address: u32) -> Result<(), Refusal> {
        let end = address.checked_add(F::ERASE_SIZE as u32).ok_or(Refusal::Flash)?;
        self.flash.erase(address, end).map_err(|_| Refusal::Flash)
    }

    pub(crate) fn write(&mut self, address: u32, bytes: &[u8]) -> Result<(), Refusal> {
        self.flash.write(address, bytes).map_err(|_| Refusal::Flash)
    }

    fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<(), Refusal> {
        let read = (0..TRIES).any(|_| self.flash.read(address, bytes).is_ok());
        if read { Ok(()) } else { Err(Refusal::Flash) }
    }
}
