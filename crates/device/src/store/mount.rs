//! The start: finds the newest page, reads the log, and settles what a power cut has left open.
//!
//! A word whose writing was interrupted may read differently each time. So before anything is
//! reported, each doubt is settled by a write that a later start cannot read in two ways:
//!
//! - The newest page has its first mark, not the second: the first is written again.
//! - The next page has a header but no mark: it is made invalid and erased.
//! - The last entry of the log has less than both marks: the next page is opened, and its header
//!   says where the log ends.

use super::format::{DAMAGED, ENTRY_HEADER, Entry, PAGE_HEADER, PageHeader};
use super::write::Mark;
use super::{Head, Store};
use embedded_storage::nor_flash::NorFlash;

/// How far a page got.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// Header, no mark: nothing has relied on this page yet.
    Written,
    /// The first mark may be half written.
    Sealed,
    /// The second one is there, so the first is whole.
    Sure,
}

impl<F: NorFlash, const N: usize> Store<F, N> {
    pub(super) fn scan(&mut self) {
        let Some((mut newest, mut stage)) = self.newest_page() else {
            // Not an empty store: what is there is not known.
            let mut pages = 0..self.geometry.pages.get();
            self.lost = pages.all(|page| self.read(page, 0, &mut [0; PAGE_HEADER]).is_none());
            return;
        };
        // What could not be read a moment ago is not given up for the page before it.
        let next = self.header(self.place(newest.seq.wrapping_add(1)));
        if let Some((header, Stage::Sure)) = next
            && header.seq > newest.seq
        {
            (newest, stage) = (header, Stage::Sure);
        }
        let first = newest.seq.saturating_sub(newest.span.into());
        self.head = Head { seq: newest.seq, first, end: Self::FIRST, is_open: false };
        self.lost = newest.lost;
        let page = self.place(newest.seq);
        if stage == Stage::Sealed {
            // A flash that refuses to write a word twice leaves the doubt as it is.
            let _ = self.mark(page, Mark::Sealed);
            let _ = self.mark(page, Mark::Sure);
        }
        self.scan_older(first, newest);
        let settled = self.scan_newest(newest.seq);
        let next = newest.seq.wrapping_add(1);
        // A flash that cannot be written is still read, and the next store reports it.
        if !settled {
            let _ = self.open_page(false);
        } else if self.header(self.place(next)).is_some_and(|(header, _)| header.seq == next) {
            let _ = self.retire(self.place(next));
        }
    }

    fn newest_page(&mut self) -> Option<(PageHeader, Stage)> {
        let mut newest: Option<(PageHeader, Stage)> = None;
        for page in 0..self.geometry.pages.get() {
            let Some(found) = self.header(page) else { continue };
            let is_newer = newest.is_none_or(|(newest, _)| found.0.seq > newest.seq);
            if found.1 != Stage::Written && is_newer {
                newest = Some(found);
            }
        }
        newest
    }

    fn header(&mut self, page: u32) -> Option<(PageHeader, Stage)> {
        let mut bytes = [0; PAGE_HEADER];
        self.read(page, 0, &mut bytes)?;
        let header = PageHeader::decode(bytes, self.geometry)?;
        let belongs = header.seq != 0 && self.place(header.seq) == page;
        let stage = if self.is_marked(page, Mark::Sure) {
            Stage::Sure
        } else if self.is_marked(page, Mark::Sealed) && !self.is_marked(page, Mark::Void) {
            Stage::Sealed
        } else {
            Stage::Written
        };
        belongs.then_some((header, stage))
    }

    /// Each page says where the one before it ends.
    fn scan_older(&mut self, first: u32, newest: PageHeader) {
        for seq in first..newest.seq {
            let page = self.place(seq);
            let following = if seq.wrapping_add(1) == newest.seq {
                Some(newest)
            } else {
                let page = self.place(seq.wrapping_add(1));
                self.header(page).map(|(header, _)| header)
            };
            let following = following.filter(|header| header.seq == seq.wrapping_add(1));
            match following {
                Some(following) => self.scan_page(seq, page, following.previous_end.into()),
                None => self.damage(),
            }
        }
    }

    fn scan_page(&mut self, seq: u32, page: u32, end: usize) {
        let mut at = Self::FIRST;
        while at < end {
            match self.entry(seq, page, at) {
                Read::Entry(entry) if at + self.size(entry) <= end => {
                    self.remember(entry, page, at);
                    at += self.size(entry);
                }
                _ => return self.damage(),
            }
        }
    }

    /// Whether every start would read the end of the log at the same place.
    fn scan_newest(&mut self, seq: u32) -> bool {
        let page = self.place(seq);
        let mut settled = true;
        while self.head.end + ENTRY_HEADER <= F::ERASE_SIZE {
            let at = self.head.end;
            match self.entry(seq, page, at) {
                Read::Erased => break,
                Read::Entry(entry) if at + self.size(entry) <= F::ERASE_SIZE => {
                    let marks = at + self.size(entry) - 2 * F::WRITE_SIZE;
                    let sealed = !self.is_erased(page, marks, F::WRITE_SIZE);
                    settled = !self.is_erased(page, marks + F::WRITE_SIZE, F::WRITE_SIZE);
                    if !sealed && !settled {
                        break;
                    }
                    self.remember(entry, page, at);
                    self.head.end = at + self.size(entry);
                }
                _ => {
                    settled = false;
                    // A header is whole before anything is written behind it.
                    let rest = at + ENTRY_HEADER;
                    if !self.is_erased(page, rest, F::ERASE_SIZE - rest) {
                        self.damage();
                        self.head.end = F::ERASE_SIZE;
                    }
                    break;
                }
            }
        }
        settled
    }

    fn entry(&mut self, seq: u32, page: u32, at: usize) -> Read {
        let mut bytes = [0; ENTRY_HEADER];
        if self.read(page, at, &mut bytes).is_none() {
            return Read::Unreadable;
        }
        if bytes == [0xFF; ENTRY_HEADER] {
            return Read::Erased;
        }
        Entry::decode(bytes, self.geometry, seq, at).map_or(Read::Unreadable, Read::Entry)
    }

    fn remember(&mut self, entry: Entry, page: u32, at: usize) {
        // Only a program with room for fewer keys than the one before finds no slot.
        self.lost |= !self.note(entry, page, at);
    }

    /// Entries cannot be read, and of which keys is not known: what has been found before them
    /// may be out of date.
    fn damage(&mut self) {
        self.lost = true;
        for slot in &mut self.slots {
            slot.len = DAMAGED;
        }
    }
}

enum Read {
    Erased,
    Unreadable,
    Entry(Entry),
}
