//! A NOR flash that obeys the contract of `embedded_storage::nor_flash::NorFlash` and no more:
//! power can be cut in any word that is written and in any page that is erased, and what was
//! being changed then holds old bits, new bits or any, also others each time it is read.

use core::cell::Cell;
use core::ops::Range;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};

/// What a power cut leaves of the word or page that was being changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Torn {
    /// It reads as before; written again it would not hold.
    Old,
    /// It reads as if all had been done.
    New,
    /// Each bit old or new.
    Mixed,
    /// Any bits.
    Random,
    /// Each time it is read: old, new, mixed, any bits, or an error where words are checked.
    Unstable,
    /// All words of the call, in no order, each old, new, mixed, any bits or unstable.
    Scattered,
}

impl Torn {
    pub const ALL: [Self; 6] =
        [Self::Old, Self::New, Self::Mixed, Self::Random, Self::Unstable, Self::Scattered];
}

/// Where power is cut.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// In this word or erase, counted from now.
    pub step: u64,
    pub torn: Torn,
}

/// What is wrong with a read, while power stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blip {
    /// It fails.
    Failed,
    /// One bit is read wrongly, and nothing reports it.
    Misread,
}

impl Blip {
    pub const ALL: [Self; 2] = [Self::Failed, Self::Misread];
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed;

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl From<NorFlashErrorKind> for Failed {
    fn from(kind: NorFlashErrorKind) -> Self {
        panic!("the store broke the contract of the flash: {kind:?}")
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Word {
    /// Erased to the end and not written since.
    Erased,
    /// Written or torn; it holds until the next erase.
    Held,
    /// Torn between what it was and what it was to be.
    Unstable,
}

#[derive(Clone, Debug)]
pub struct Flash<const WORD: usize, const PAGE: usize> {
    bytes: Vec<u8>,
    words: Vec<Word>,
    /// What unstable words were.
    before: Vec<u8>,
    /// Words are checked: a torn one may be reported by an error.
    pub checked: bool,
    /// Only a whole erase makes a written word writable again, not even zeros may be written.
    pub strict: bool,
    /// Nothing can be read.
    pub deaf: bool,
    /// Writing to these addresses fails, as in a worn page.
    pub worn: Vec<Range<u32>>,
    /// This bit always has this value, and nothing reports it.
    pub stuck: Option<(usize, bool)>,
    /// What is wrong with these reads, by the number that `reads` gives them.
    pub blip: Option<(Range<u64>, Blip)>,
    random: Cell<u64>,
    cut: Cell<Option<Cut>>,
    /// Power is not cut: the step fails, and those that follow do not.
    stays_on: Cell<bool>,
    off: bool,
    pub reads: u64,
    pub steps: u64,
    /// Erases of each page.
    pub erases: Vec<u32>,
}

impl<const WORD: usize, const PAGE: usize> Flash<WORD, PAGE> {
    /// As it comes from the factory of another program: full of anything.
    pub fn new(pages: usize, seed: u64) -> Self {
        let mut flash = Self {
            bytes: vec![0; pages * PAGE],
            words: vec![Word::Held; pages * PAGE / WORD],
            before: vec![0; pages * PAGE],
            checked: false,
            strict: false,
            deaf: false,
            worn: Vec::new(),
            stuck: None,
            blip: None,
            random: Cell::new(seed),
            cut: Cell::new(None),
            stays_on: Cell::new(false),
            off: false,
            reads: 0,
            steps: 0,
            erases: vec![0; pages],
        };
        for index in 0..flash.bytes.len() {
            flash.bytes[index] = flash.random() as u8;
        }
        flash
    }

    pub fn cut(&self, cut: Cut) {
        self.cut.set(Some(cut));
        self.stays_on.set(false);
    }

    /// This step fails, once, and leaves what a cut would.
    pub fn fail(&self, cut: Cut) {
        self.cut.set(Some(cut));
        self.stays_on.set(true);
    }

    /// Whether that has not happened yet.
    pub fn is_to_fail(&self) -> bool {
        self.cut.get().is_some()
    }

    pub fn clear_cut(&self) {
        self.cut.set(None);
    }

    /// Whether the cut has happened.
    pub fn is_off(&self) -> bool {
        self.off
    }

    pub fn power_on(mut self) -> Self {
        self.off = false;
        self.cut.set(None);
        self
    }

    pub fn pages(&self) -> u16 {
        (self.bytes.len() / PAGE) as u16
    }

    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// A cell has lost or gained charge.
    pub fn flip(&mut self, bit: usize) {
        self.bytes[bit / 8] ^= 1 << (bit % 8);
    }

    /// SplitMix64.
    pub fn random(&self) -> u64 {
        self.random.set(self.random.get().wrapping_add(0x9E37_79B9_7F4A_7C15));
        let mut z = self.random.get();
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// What a torn word holds.
    fn torn(&self, choice: Torn, old: [u8; WORD], new: [u8; WORD]) -> ([u8; WORD], Word) {
        let (any, mask) = (self.random().to_le_bytes(), self.random().to_le_bytes());
        let mut bytes = old;
        for (index, byte) in bytes.iter_mut().enumerate() {
            *byte = match choice {
                Torn::Old => old[index],
                Torn::New => new[index],
                Torn::Mixed => old[index] & mask[index] | new[index] & !mask[index],
                _ => any[index],
            };
        }
        match choice {
            Torn::Unstable => (new, Word::Unstable),
            Torn::Scattered => self.torn(Torn::ALL[self.random() as usize % 5], old, new),
            _ => (bytes, Word::Held),
        }
    }

    fn tear(&mut self, index: usize, torn: Torn, old: [u8; WORD], new: [u8; WORD]) {
        let (bytes, state) = self.torn(torn, old, new);
        self.before[index * WORD..][..WORD].copy_from_slice(&old);
        self.bytes[index * WORD..][..WORD].copy_from_slice(&bytes);
        self.words[index] = state;
    }

    fn word(&self, index: usize) -> [u8; WORD] {
        self.bytes[index * WORD..][..WORD].try_into().unwrap()
    }

    /// Counts a step; how it is torn when power fails in it.
    fn step(&mut self) -> Option<Torn> {
        self.steps += 1;
        let cut = self.cut.get()?;
        if cut.step > 0 {
            self.cut.set(Some(Cut { step: cut.step - 1, ..cut }));
            return None;
        }
        self.cut.set(None);
        self.off = !self.stays_on.get();
        Some(cut.torn)
    }
}

impl<const WORD: usize, const PAGE: usize> ErrorType for Flash<WORD, PAGE> {
    type Error = Failed;
}

impl<const WORD: usize, const PAGE: usize> ReadNorFlash for Flash<WORD, PAGE> {
    const READ_SIZE: usize = WORD;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        check_read(self, offset, bytes.len())?;
        self.reads += 1;
        let blip = self.blip.as_ref().filter(|(reads, _)| reads.contains(&self.reads));
        let blip = blip.map(|(_, blip)| *blip);
        if self.off || self.deaf || blip == Some(Blip::Failed) {
            return Err(Failed);
        }
        let start = offset as usize;
        bytes.copy_from_slice(&self.bytes[start..start + bytes.len()]);
        if let Some((bit, value)) = self.stuck
            && let Some(byte) = (bit / 8).checked_sub(start).and_then(|index| bytes.get_mut(index))
        {
            *byte = *byte & !(1 << (bit % 8)) | u8::from(value) << (bit % 8);
        }
        for (index, chunk) in bytes.chunks_mut(WORD).enumerate() {
            if self.words[start / WORD + index] == Word::Unstable {
                if self.checked && self.random().is_multiple_of(2) {
                    return Err(Failed);
                }
                let choice = Torn::ALL[self.random() as usize % 4];
                let old = self.before[start + index * WORD..][..WORD].try_into().unwrap();
                let word = self.torn(choice, old, self.word(start / WORD + index)).0;
                chunk.copy_from_slice(&word);
            }
        }
        if blip == Some(Blip::Misread) {
            let bit = self.random() as usize % (bytes.len() * 8);
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const WORD: usize, const PAGE: usize> NorFlash for Flash<WORD, PAGE> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        check_erase(self, from, to)?;
        assert_eq!((to - from) as usize, PAGE, "one page at a time");
        if self.off {
            return Err(Failed);
        }
        let words = from as usize / WORD..to as usize / WORD;
        let torn = self.step();
        if torn.is_none() {
            self.erases[from as usize / PAGE] += 1;
        }
        for index in words {
            match torn {
                Some(torn) => self.tear(index, torn, self.word(index), [0xFF; WORD]),
                None => {
                    self.bytes[index * WORD..][..WORD].fill(0xFF);
                    self.words[index] = Word::Erased;
                }
            }
        }
        if torn.is_some() { Err(Failed) } else { Ok(()) }
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        check_write(self, offset, bytes.len())?;
        let end = offset + bytes.len() as u32;
        if self.off || self.worn.iter().any(|worn| worn.start < end && offset < worn.end) {
            return Err(Failed);
        }
        let first = offset as usize / WORD;
        let zeros = bytes.iter().all(|byte| *byte == 0);
        let count = bytes.len() / WORD;
        let before = self.cut.get().map(|_| self.bytes[offset as usize..][..bytes.len()].to_vec());
        if self.words[first..first + count].iter().any(|word| *word != Word::Erased) {
            assert!(zeros, "a word is written twice at {offset:#x}");
            if self.strict {
                return Err(Failed);
            }
        }
        for (index, word) in bytes.chunks(WORD).enumerate() {
            let word: [u8; WORD] = word.try_into().unwrap();
            match self.step() {
                None => {
                    self.bytes[(first + index) * WORD..][..WORD].copy_from_slice(&word);
                    self.words[first + index] = Word::Held;
                }
                Some(Torn::Scattered) => {
                    let before = before.unwrap_or_default();
                    for (index, (old, new)) in
                        before.chunks(WORD).zip(bytes.chunks(WORD)).enumerate()
                    {
                        let (old, new) = (old.try_into().unwrap(), new.try_into().unwrap());
                        self.tear(first + index, Torn::Scattered, old, new);
                    }
                    return Err(Failed);
                }
                Some(torn) => {
                    self.tear(first + index, torn, self.word(first + index), word);
                    return Err(Failed);
                }
            }
        }
        Ok(())
    }
}
