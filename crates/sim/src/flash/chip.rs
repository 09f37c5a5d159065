//! A NOR flash chip: words that are written once, pages that are erased, time that both take, and
//! what a power cut leaves of the word or page it hits.

use std::collections::BTreeMap;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};

use crate::rng::Rng;

/// Bytes of a word.
pub const WORD: usize = 8;
/// Bytes of a page.
pub const PAGE: usize = 2048;
/// Pages of the memory of parameters.
pub const PAGES: usize = 4;
/// Time to write a word, µs: the most that the data sheet of an STM32L4 allows, as recalled.
pub const WRITE_US: u64 = 91;
/// Time to erase a page, µs; likewise.
pub const ERASE_US: u64 = 24_500;

/// What a power cut leaves of the word or page that was being changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Torn {
    /// It reads as before.
    Old,
    /// It reads as if all had been done.
    New,
    /// Each bit old or new.
    Mixed,
    /// Any bits.
    Random,
    /// Any of these, and another one each time it is read.
    Unstable,
}

impl Torn {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Old, Self::New, Self::Mixed, Self::Random, Self::Unstable];

    /// The name that scenarios use.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Old => "old",
            Self::New => "new",
            Self::Mixed => "mixed",
            Self::Random => "random",
            Self::Unstable => "unstable",
        }
    }
}

/// Where power is cut: in the word or erase after this many others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Words written and pages erased before it, counted from now.
    pub step: u64,
    /// What is left of that word or page.
    pub torn: Torn,
}

/// The chip did not do it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChipError;

impl NorFlashError for ChipError {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// The chip.
#[derive(Clone, Debug)]
pub struct Chip {
    bytes: Vec<u8>,
    /// Words that have been written since the last erase.
    written: Vec<bool>,
    /// Unstable words: what they were.
    unstable: BTreeMap<usize, [u8; WORD]>,
    erases: Vec<u32>,
    steps: u64,
    busy_us: u64,
    /// What has been changed since `begin`, so that a power cut can come in the middle of it.
    journal: Vec<Change>,
    cut: Option<Cut>,
    off: bool,
    rng: Rng,
    /// It cannot be read.
    pub(super) unreadable: bool,
    /// It can be neither written nor erased.
    pub(super) unwritable: bool,
}

#[derive(Clone, Debug)]
struct Change {
    from_us: u64,
    to_us: u64,
    word: usize,
    old: Vec<u8>,
}

impl Chip {
    /// An erased chip for the memory of parameters.
    pub fn new(seed: u64) -> Self {
        Self::sized(PAGES, seed)
    }

    /// An erased chip of so many pages.
    pub(crate) fn sized(pages: usize, seed: u64) -> Self {
        Self::with(vec![0xFF; PAGE * pages], vec![0; pages], seed)
    }

    /// A chip with this content and these erases of its pages; `None` unless there is a page for each.
    pub fn of(bytes: &[u8], erases: Vec<u32>) -> Option<Self> {
        (bytes.len() == PAGE * erases.len()).then(|| Self::with(bytes.to_vec(), erases, 1))
    }

    fn with(bytes: Vec<u8>, erases: Vec<u32>, seed: u64) -> Self {
        let written = bytes.chunks(WORD).map(|word| word != [0xFF; WORD]).collect();
        Self {
            bytes,
            written,
            unstable: BTreeMap::new(),
            erases,
            steps: 0,
            busy_us: 0,
            journal: Vec::new(),
            cut: None,
            off: false,
            rng: Rng::new(seed),
            unreadable: false,
            unwritable: false,
        }
    }

    /// Its contents.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// How often each page has been erased.
    pub fn erases(&self) -> &[u32] {
        &self.erases
    }

    /// Words written and pages erased so far.
    pub const fn steps(&self) -> u64 {
        self.steps
    }

    /// Time since `begin` in which it was written and erased, µs.
    pub const fn busy_us(&self) -> u64 {
        self.busy_us
    }

    /// Whether a cut has taken its power.
    pub const fn is_off(&self) -> bool {
        self.off
    }

    /// Whether its power will be cut in a word or erase to come.
    pub const fn is_cut_ahead(&self) -> bool {
        self.cut.is_some()
    }

    /// A cell has lost or gained charge.
    pub fn flip(&mut self, address: usize, bit: u8) {
        if let Some(byte) = self.bytes.get_mut(address) {
            *byte ^= 1 << (bit % 8);
        }
    }

    /// From here on time counts from 0.
    pub(crate) fn begin(&mut self) {
        self.busy_us = 0;
        self.journal.clear();
    }

    /// It is not used before this time after `begin`, µs.
    pub(crate) fn wait_until(&mut self, us: u64) {
        self.busy_us = self.busy_us.max(us);
    }

    /// Cuts the power at this word or erase; takes the cut back without one.
    pub(crate) const fn arm(&mut self, cut: Option<Cut>) {
        self.cut = cut;
    }

    pub(crate) const fn power_on(&mut self) {
        self.off = false;
    }

    pub(crate) const fn power_off(&mut self) {
        self.off = true;
    }

    /// Power failed at this time after `begin`: what was done later was not done, and what was being
    /// done then is torn.
    pub(crate) fn interrupt(&mut self, at_us: u64) {
        while let Some(Change { from_us, to_us, word, old }) = self.journal.pop() {
            if to_us <= at_us {
                break;
            }
            let torn = match from_us < at_us {
                true => Torn::ALL[self.rng.bits() as usize % Torn::ALL.len()],
                false => Torn::Old,
            };
            for (index, old) in old.as_chunks().0.iter().enumerate() {
                let new = self.word(word + index);
                self.tear(word + index, torn, *old, new);
                self.written[word + index] = from_us < at_us || *old != [0xFF; WORD];
            }
        }
        self.journal.clear();
    }

    fn word(&self, index: usize) -> [u8; WORD] {
        self.bytes.as_chunks().0[index]
    }

    fn torn(&mut self, torn: Torn, old: [u8; WORD], new: [u8; WORD]) -> [u8; WORD] {
        let (old, new) = (u64::from_le_bytes(old), u64::from_le_bytes(new));
        let word = match torn {
            Torn::Old => old,
            Torn::New => new,
            Torn::Mixed => {
                let mask = self.rng.bits();
                old & mask | new & !mask
            }
            Torn::Random => self.rng.bits(),
            Torn::Unstable => {
                let torn = Torn::ALL[self.rng.bits() as usize % 4];
                return self.torn(torn, old.to_le_bytes(), new.to_le_bytes());
            }
        };
        word.to_le_bytes()
    }

    fn tear(&mut self, index: usize, torn: Torn, old: [u8; WORD], new: [u8; WORD]) {
        self.unstable.remove(&index);
        let word = if torn == Torn::Unstable {
            self.unstable.insert(index, old);
            new
        } else {
            self.torn(torn, old, new)
        };
        self.put(index, word);
        self.written[index] = true;
    }

    fn put(&mut self, index: usize, word: [u8; WORD]) {
        self.bytes.as_chunks_mut().0[index] = word;
    }

    /// Counts a word or erase of `us`; how it is torn when power fails in it.
    fn step(&mut self, us: u64, word: usize, words: usize) -> Option<Torn> {
        self.steps += 1;
        let old = self.bytes[word * WORD..][..words * WORD].to_vec();
        let from_us = self.busy_us;
        self.busy_us += us;
        self.journal.push(Change { from_us, to_us: self.busy_us, word, old });
        let cut = self.cut.as_mut()?;
        if cut.step > 0 {
            cut.step -= 1;
            return None;
        }
        let torn = cut.torn;
        (self.cut, self.off) = (None, true);
        Some(torn)
    }
}

/// A program that asks for what the chip cannot do is wrong, not unlucky.
fn kept<T>(contract: Result<T, NorFlashErrorKind>) {
    assert!(contract.is_ok(), "the contract of the flash was broken");
}

impl ErrorType for Chip {
    type Error = ChipError;
}

impl ReadNorFlash for Chip {
    const READ_SIZE: usize = WORD;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), ChipError> {
        kept(check_read(self, offset, bytes.len()));
        if self.off || self.unreadable {
            return Err(ChipError);
        }
        let first = offset as usize;
        bytes.copy_from_slice(&self.bytes[first..first + bytes.len()]);
        if !self.unstable.is_empty() {
            for (index, chunk) in bytes.as_chunks_mut().0.iter_mut().enumerate() {
                if let Some(&old) = self.unstable.get(&(first / WORD + index)) {
                    *chunk = self.torn(Torn::Unstable, old, *chunk);
                }
            }
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Chip {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), ChipError> {
        kept(check_erase(self, from, to));
        for page in from as usize / PAGE..to as usize / PAGE {
            if self.off || self.unwritable {
                return Err(ChipError);
            }
            let words = PAGE / WORD;
            let torn = self.step(ERASE_US, page * words, words);
            self.erases[page] += 1;
            for index in page * words..(page + 1) * words {
                match torn {
                    Some(torn) => self.tear(index, torn, self.word(index), [0xFF; WORD]),
                    None => {
                        self.put(index, [0xFF; WORD]);
                        self.written[index] = false;
                        self.unstable.remove(&index);
                    }
                }
            }
        }
        if self.off { Err(ChipError) } else { Ok(()) }
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), ChipError> {
        kept(check_write(self, offset, bytes.len()));
        let first = offset as usize / WORD;
        for (index, word) in bytes.as_chunks().0.iter().enumerate() {
            if self.off || self.unwritable {
                return Err(ChipError);
            }
            let index = first + index;
            let zeros = *word == [0; WORD];
            assert!(zeros || !self.written[index], "a word is written twice at {offset:#x}");
            let old = self.word(index);
            match self.step(WRITE_US, index, 1) {
                Some(torn) => self.tear(index, torn, old, *word),
                None => {
                    self.put(index, *word);
                    self.written[index] = true;
                    self.unstable.remove(&index);
                }
            }
        }
        if self.off { Err(ChipError) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(chip: &mut Chip, word: u32) -> [u8; WORD] {
        let mut bytes = [0; WORD];
        chip.read(word * WORD as u32, &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn words_and_pages_take_their_time() {
        let mut chip = Chip::new(1);
        chip.write(0, &[1; 3 * WORD]).unwrap();
        assert_eq!((chip.steps(), chip.busy_us()), (3, 3 * WRITE_US));
        chip.begin();
        chip.erase(0, PAGE as u32).unwrap();
        assert_eq!((chip.busy_us(), chip.erases()), (ERASE_US, [1, 0, 0, 0].as_slice()));
        assert_eq!(read(&mut chip, 0), [0xFF; WORD]);
    }

    #[test]
    #[should_panic = "written twice"]
    fn a_word_is_written_once() {
        let mut chip = Chip::new(1);
        chip.write(0, &[0xFE; WORD]).unwrap();
        let _ = chip.write(0, &[0xFE; WORD]);
    }

    #[test]
    fn a_cut_tears_one_word() {
        for torn in Torn::ALL {
            let mut chip = Chip::new(3);
            chip.arm(Some(Cut { step: 1, torn }));
            assert_eq!(chip.write(0, &[0x5A; 3 * WORD]), Err(ChipError));
            assert!(chip.is_off() && chip.read(0, &mut [0; WORD]).is_err());
            chip.power_on();
            assert_eq!(read(&mut chip, 0), [0x5A; WORD]);
            assert_eq!(read(&mut chip, 2), [0xFF; WORD]);
            let seen: Vec<_> = (0..16).map(|_| read(&mut chip, 1)).collect();
            match torn {
                Torn::Old => assert!(seen.iter().all(|word| *word == [0xFF; WORD])),
                Torn::New => assert!(seen.iter().all(|word| *word == [0x5A; WORD])),
                Torn::Unstable => assert!(seen.iter().any(|word| *word != seen[0])),
                _ => assert!(seen.iter().all(|word| *word == seen[0])),
            }
        }
    }

    /// Power fails between the words of what the program took for done: they are not.
    #[test]
    fn a_cut_in_time_undoes_what_came_later() {
        let mut chip = Chip::new(3);
        chip.begin();
        chip.write(0, &[0x5A; 4 * WORD]).unwrap();
        chip.interrupt(2 * WRITE_US);
        assert_eq!(read(&mut chip, 1), [0x5A; WORD]);
        assert_eq!(read(&mut chip, 2), [0xFF; WORD]);
        assert_eq!(read(&mut chip, 3), [0xFF; WORD]);
        // What was never started can still be written.
        chip.write(2 * WORD as u32, &[1; WORD]).unwrap();
    }
}
