//! Writing: entries, and pages with the copies they begin with.
//!
//! Only this order makes it power-safe: what is written in one step is whole before the next
//! begins, and what must not be half written is followed by a mark in a step of its own.

use super::format::{CHECK, DAMAGED, ENTRY_HEADER, Entry, PAGE_HEADER, PageHeader, ValueCheck};
use super::{CHUNK, Head, Slot, Store};
use embedded_storage::nor_flash::NorFlash;

/// A word behind the header of a page; all zeros when it is set.
#[derive(Clone, Copy)]
pub(super) enum Mark {
    /// The page belongs to the log.
    Sealed,
    /// And the mark before this one is whole.
    Sure,
    /// The page is about to be erased; means nothing once `Sure` is set.
    Void,
}

/// Where the bytes of an entry come from.
#[derive(Clone, Copy)]
enum Source<'a> {
    Value(&'a [u8]),
    Flash { page: u32, at: usize },
}

const ZEROS: [u8; PAGE_HEADER] = [0; PAGE_HEADER];

impl<F: NorFlash, const N: usize> Store<F, N> {
    /// Whether a value is stored already: writing it again would only wear the flash.
    pub(super) fn holds(&mut self, entry: Entry, value: &[u8]) -> bool {
        let Some(slot) = self.slot(entry.key).filter(|slot| slot.len == entry.len) else {
            return false;
        };
        let mut same = true;
        let whole = self.read_value(slot, &mut |from, bytes| {
            same &= value.get(from..from + bytes.len()) == Some(bytes);
        });
        whole && same
    }

    /// Opens pages until the entry fits, and writes it. A page in which writing fails is left,
    /// and the entry tried once more in the next one.
    pub(super) fn write_entry(&mut self, entry: Entry, value: &[u8]) -> Option<()> {
        let need = self.size(entry);
        let has_slot = self.slots.iter().any(|slot| slot.at == 0) || self.slot(entry.key).is_some();
        if !has_slot || !(self.head_has_room(need) || self.ring_has_room(need)) {
            return None;
        }
        let mut tries = 2;
        for _ in 0..=self.geometry.pages.get().saturating_add(1) {
            if self.head_has_room(need) {
                let Head { seq, end, .. } = self.head;
                let page = self.place(seq);
                if self.append(seq, end, entry, Source::Value(value)).is_some() {
                    self.head.end = end + need;
                    self.note(entry, page, end);
                    return Some(());
                }
                self.head.is_open = false;
                tries -= 1;
                if tries == 0 {
                    return None;
                }
            }
            self.open_page(false)?;
        }
        None
    }

    /// Makes the free page the newest of the log. `fresh`: of a log that begins there.
    ///
    /// Until the mark it is not part of the log, and from then on the oldest page is the free
    /// one, since all that lived there is here too.
    pub(super) fn open_page(&mut self, fresh: bool) -> Option<()> {
        // Whatever happens, a later start may find the new page valid: nothing may be added to
        // the present one.
        self.head.is_open = false;
        let seq = self.head.seq.checked_add(1)?;
        let page = self.place(seq);
        self.retire(page)?;
        let oldest = self.place(seq.wrapping_add(1));
        let end = if fresh { Self::FIRST } else { self.copy_entries(oldest, seq)? };

        let ring = self.geometry.pages.get().saturating_sub(2);
        let first = if fresh || self.head.seq == 0 {
            seq
        } else {
            self.head.first.max(seq.saturating_sub(ring))
        };
        let header = PageHeader {
            seq,
            span: (seq - first) as u16,
            previous_end: self.head.end as u16,
            lost: self.lost && !fresh,
        };
        let bytes = header.encode(self.geometry);
        self.write_checked(page, 0, bytes)?;
        self.mark(page, Mark::Sealed)?;
        self.mark(page, Mark::Sure)?;

        self.lost = header.lost;
        self.head = Head { seq, first, end, is_open: true };
        if fresh {
            self.slots = [Slot::default(); N];
        } else {
            self.move_slots(oldest, page);
        }
        Some(())
    }

    /// Erases the free page.
    ///
    /// An interrupted erase leaves anything, also a part of the old content, so first the page is
    /// made one that never counts: a half-opened page has the header of the next one. The `Void`
    /// mark covers the time while the header is half overwritten.
    pub(super) fn retire(&mut self, page: u32) -> Option<()> {
        let _ = self.mark(page, Mark::Void);
        let _ = self.write(page, 0, &ZEROS);
        let from = self.address(page, 0, 0)?;
        let to = from.checked_add(F::ERASE_SIZE as u32)?;
        self.flash.erase(from, to).ok()?;
        self.is_erased(page, 0, F::ERASE_SIZE).then_some(())
    }

    /// Copies what lives in a page to the page `seq`; where the copies end.
    fn copy_entries(&mut self, from: u32, seq: u32) -> Option<usize> {
        let mut end = Self::FIRST;
        for index in 0..N {
            let Some(slot) = self.slots.get(index).copied() else { break };
            if slot.at == 0 || u32::from(slot.page) != from {
                continue;
            }
            let mut entry = slot.entry();
            // That a value is damaged must be known as long as it is not replaced.
            if entry.len != DAMAGED && !self.read_value(slot, &mut |_, _| {}) {
                entry.len = DAMAGED;
                if let Some(slot) = self.slots.get_mut(index) {
                    slot.len = DAMAGED;
                }
            }
            let source = match entry.len {
                DAMAGED => Source::Value(&[]),
                _ => Source::Flash { page: from, at: slot.at.into() },
            };
            self.append(seq, end, entry, source)?;
            end += self.size(entry);
        }
        Some(end)
    }

    /// The slots follow the copies, which stand in the order of the slots.
    fn move_slots(&mut self, from: u32, to: u32) {
        let mut end = Self::FIRST;
        for index in 0..N {
            let Some(slot) = self.slots.get(index).copied() else { break };
            if slot.at != 0 && u32::from(slot.page) == from {
                let moved = Slot { page: to as u16, at: end as u16, ..slot };
                end += self.size(slot.entry());
                if let Some(slot) = self.slots.get_mut(index) {
                    *slot = moved;
                }
            }
        }
    }

    /// Writes an entry, reads it back, and marks it twice: the second mark shows a later start
    /// that the first is whole.
    fn append(&mut self, seq: u32, at: usize, entry: Entry, source: Source<'_>) -> Option<()> {
        let page = self.place(seq);
        self.write_checked(page, at, entry.encode(self.geometry, seq, at))?;
        match source {
            Source::Value(value) => self.write_value(page, at, entry, value)?,
            Source::Flash { page: from, at: from_at } => {
                self.copy_value(entry, (from, from_at), (page, at))?;
            }
        }
        let slot = Slot { key: entry.key, len: entry.len, page: page as u16, at: at as u16 };
        if !self.read_value(slot, &mut |_, _| {}) {
            return None;
        }
        let marks = at + self.size(entry) - 2 * F::WRITE_SIZE;
        let word = ZEROS.get(..F::WRITE_SIZE)?;
        self.write(page, marks, word)?;
        self.write(page, marks + F::WRITE_SIZE, word)
    }

    /// The value, its checksum, and zeros up to a whole word.
    fn write_value(&mut self, page: u32, at: usize, entry: Entry, value: &[u8]) -> Option<()> {
        let mut check = ValueCheck::new(entry);
        check.update(value);
        let whole = value.len() - value.len() % F::WRITE_SIZE;
        let (words, rest) = value.split_at_checked(whole)?;
        let at = at + ENTRY_HEADER;
        if !words.is_empty() {
            self.write(page, at, words)?;
        }
        let mut tail = ZEROS;
        let check = check.finish();
        for (place, byte) in tail.iter_mut().zip(rest.iter().chain(&check)) {
            *place = *byte;
        }
        let end = rest.len() + CHECK;
        self.write(page, at + whole, tail.get(..end.next_multiple_of(F::WRITE_SIZE))?)
    }

    /// The checksum is copied with the value, so it covers the copying too.
    fn copy_value(
        &mut self,
        entry: Entry,
        (from, from_at): (u32, usize),
        (to, to_at): (u32, usize),
    ) -> Option<()> {
        let stored = (entry.value_len() + CHECK).next_multiple_of(F::WRITE_SIZE);
        for done in (0..stored).step_by(CHUNK) {
            let mut buffer = [0; CHUNK];
            let chunk = buffer.get_mut(..(stored - done).min(CHUNK))?;
            self.read(from, from_at + ENTRY_HEADER + done, chunk)?;
            self.write(to, to_at + ENTRY_HEADER + done, chunk)?;
        }
        Some(())
    }

    pub(super) fn mark(&mut self, page: u32, mark: Mark) -> Option<()> {
        self.write(page, Self::place_of(mark), ZEROS.get(..F::WRITE_SIZE)?)
    }

    pub(super) fn is_marked(&mut self, page: u32, mark: Mark) -> bool {
        !self.is_erased(page, Self::place_of(mark), F::WRITE_SIZE)
    }

    const fn place_of(mark: Mark) -> usize {
        PAGE_HEADER + mark as usize * F::WRITE_SIZE
    }

    fn write_checked<const L: usize>(
        &mut self,
        page: u32,
        at: usize,
        bytes: [u8; L],
    ) -> Option<()> {
        self.write(page, at, &bytes)?;
        let mut read = [0; L];
        self.read(page, at, &mut read)?;
        (read == bytes).then_some(())
    }

    fn write(&mut self, page: u32, at: usize, bytes: &[u8]) -> Option<()> {
        let address = self.address(page, at, bytes.len())?;
        self.flash.write(address, bytes).ok()
    }
}
