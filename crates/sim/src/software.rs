//! The software of a monitor that can be updated (ours; docs/update.md): two slots and the record on a
//! flash of their own, a bootloader, and the receiver of the program that it has started.
//!
//! The simulator itself is the program, whatever an image has as its payload; its version is that of
//! the header. What a bootloader does takes no time, but for what it writes.

use core::fmt;
use std::sync::{Mutex, PoisonError};

use embedded_storage::nor_flash::NorFlash;
use lafet_device::hal;
use lafet_proto::crc::Crc32c;
use lafet_proto::update::Report;
use lafet_update::{
    Board, BoardName, Boot, Hash, Header, Layouts, Memory, Partition, PublicKey, Receiver,
    Recorded, SigningKey, Slot, Started, Version, boot,
};

use crate::flash::{Chip, Damaged, PAGE};

/// Pages of the record.
const RECORD_PAGES: usize = 4;
/// Pages of a slot: fewest and most.
const SLOT_PAGES: [usize; 2] = [4, 1024];
/// The layout in which a new monitor stores its parameters.
const LAYOUT: u16 = 1;
/// The number of the simulator's own key.
const OWN_KEY: u8 = 15;
/// The secret of the simulator's own key is here for all to read: it is good for simulators only.
const OWN_SECRET: [u8; 32] = *b"lafet: simulators only, not safe";
/// A bootloader that finds nothing to start looks again after so long, ms.
const NOTHING_MS: u64 = 5_000;
/// The watchdog resets a program that hangs after so long, ms.
const WATCHDOG_MS: u64 = 2_000;
const MAGIC: &[u8] = b"lafet software 1\n";

/// What becomes of an image that is started on trial.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trial {
    /// It answers, and can be confirmed.
    #[default]
    Good,
    /// It runs and answers nothing: after its 180 s it goes back by itself.
    DeadLink,
    /// It hangs as soon as it is started: its watchdog resets it.
    Hangs,
}

/// The software of a simulated monitor that can be updated.
#[derive(Clone, Debug)]
pub struct Software {
    /// The name of the board that images are for, 1 to 16 visible ASCII characters. No image is for a
    /// board of any other name: with one, the software cannot be updated.
    pub board: String,
    /// The keys that images are signed with, by numbers of 0 to 14; 15 is the simulator's own.
    pub keys: Vec<PublicKey>,
    /// The version that a new monitor has in slot A.
    pub version: [u16; 4],
    /// Bytes of each slot of a new monitor, 8 KiB to 2 MiB, whole pages of 2 KiB; what is less or more
    /// becomes the nearest of these. One page is the header's.
    pub slot_bytes: u32,
    /// The flash to start with, whose slots have the size that they had; without one it is a new
    /// monitor.
    pub flash: Option<SoftwareFlash>,
    /// What becomes of an image that is started on trial.
    pub trial: Trial,
}

impl Default for Software {
    fn default() -> Self {
        Self {
            board: "lafet-sim".to_owned(),
            keys: Vec::new(),
            version: [1, 0, 0, 0],
            slot_bytes: 128 * 1024,
            flash: None,
            trial: Trial::Good,
        }
    }
}

impl Software {
    /// The simulator's own key, number 15, with which the image of a new monitor is signed. It is no
    /// secret: it is good for simulators only.
    pub fn factory_key() -> SigningKey {
        SigningKey::new(OWN_KEY, OWN_SECRET)
    }
}

/// A flash with the slots and the record, as [`crate::sim::Sim::software_flash`] returned it.
#[derive(Clone, Debug)]
pub struct SoftwareFlash(Chip);

impl SoftwareFlash {
    /// Reads what [`crate::sim::Sim::software_flash`] returned.
    ///
    /// # Errors
    ///
    /// [`Damaged`] when it is anything else.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Damaged> {
        let (bytes, check) = bytes.split_last_chunk::<4>().ok_or(Damaged)?;
        let rest = bytes.strip_prefix(MAGIC).ok_or(Damaged)?;
        if checksum(bytes) != *check {
            return Err(Damaged);
        }
        let (pages, rest) = rest.split_first_chunk::<4>().ok_or(Damaged)?;
        let pages = u32::from_le_bytes(*pages) as usize;
        let [fewest, most] = SLOT_PAGES.map(|slot| 2 * slot + RECORD_PAGES);
        if !(fewest..=most).contains(&pages) || !pages.is_multiple_of(2) {
            return Err(Damaged);
        }
        let (counts, image) = rest.split_at_checked(4 * pages).ok_or(Damaged)?;
        let counts = counts.as_chunks::<4>().0.iter();
        let erases = counts.map(|count| u32::from_le_bytes(*count)).collect();
        Chip::of(image, erases).map(Self).ok_or(Damaged)
    }
}

/// A line of text, the number of pages (u32), the erases of each (u32), their bytes, a CRC-32C of all.
pub(crate) fn to_bytes(chip: &Chip) -> Vec<u8> {
    let erases = chip.erases();
    let mut bytes = MAGIC.to_vec();
    bytes.extend_from_slice(&(erases.len() as u32).to_le_bytes());
    bytes.extend(erases.iter().flat_map(|erases| erases.to_le_bytes()));
    bytes.extend_from_slice(chip.bytes());
    let check = checksum(&bytes);
    bytes.extend_from_slice(&check);
    bytes
}

fn checksum(bytes: &[u8]) -> [u8; 4] {
    let mut crc = Crc32c::new();
    crc.update(bytes);
    crc.finish().to_le_bytes()
}

fn partition(slot_pages: usize) -> Partition {
    let slot = (slot_pages * PAGE) as u32;
    Partition {
        slots: [0, slot],
        slot_pages: slot_pages as u16,
        record: 2 * slot,
        record_pages: RECORD_PAGES as u16,
    }
}

/// A receiver borrows the keys of its board for as long as it likes. Each list is kept once, for good.
fn kept(keys: Vec<PublicKey>) -> &'static [PublicKey] {
    static LISTS: Mutex<Vec<&'static [PublicKey]>> = Mutex::new(Vec::new());
    let mut lists = LISTS.lock().unwrap_or_else(PoisonError::into_inner);
    let known = lists.iter().copied().find(|known| *known == keys.as_slice());
    known.unwrap_or_else(|| {
        let list: &'static [PublicKey] = keys.leak();
        lists.push(list);
        list
    })
}

/// Puts an image into slot A, as a programmer does.
fn program(memory: &mut Memory<Chip>, board: &Board<'_>, version: Version) {
    let payload = b"lafetsim".repeat(64);
    let header = Header {
        size: 0,
        version,
        board: board.name,
        place: Some(Slot::A),
        key: OWN_KEY,
        revokes: 0,
        layouts: Layouts { oldest: LAYOUT, newest: LAYOUT },
        hash: Hash::default(),
    };
    let (start, behind) = (memory.start_of(Slot::A), memory.payload_of(Slot::A));
    let chip = memory.flash_mut();
    let signed = Software::factory_key().sign(&header, &payload);
    let programmed = signed
        .is_ok_and(|raw| chip.write(start, &raw).is_ok() && chip.write(behind, &payload).is_ok());
    debug_assert!(programmed, "a new chip takes everything");
}

/// What the slots are used by.
#[derive(Clone)]
enum State {
    /// Nothing runs.
    Stopped(Memory<Chip>),
    /// The program that the bootloader has started.
    Runs(Box<Receiver<'static, Chip>>),
}

/// The slots, and what runs.
#[derive(Clone)]
pub(crate) struct Programs {
    board: Board<'static>,
    trial: Trial,
    state: State,
}

impl fmt::Debug for Programs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Programs").field("running", &self.running()).finish_non_exhaustive()
    }
}

impl Programs {
    /// Nothing runs yet; `None` for a name that no board can have.
    pub(crate) fn new(software: Software, seed: u64) -> Option<Self> {
        let Software { board, keys, version, slot_bytes, flash, trial } = software;
        let own = Software::factory_key().public();
        let keys = core::iter::once(own).chain(keys).collect();
        let board = Board { name: BoardName::new(&board)?, keys: kept(keys) };
        let memory = if let Some(SoftwareFlash(chip)) = flash {
            let slot_pages = chip.erases().len().saturating_sub(RECORD_PAGES) / 2;
            Memory::new(chip, partition(slot_pages))
        } else {
            let [fewest, most] = SLOT_PAGES;
            let slot_pages = (slot_bytes as usize).div_ceil(PAGE).clamp(fewest, most);
            let chip = Chip::sized(2 * slot_pages + RECORD_PAGES, seed);
            let mut memory = Memory::new(chip, partition(slot_pages));
            program(&mut memory, &board, Version(version));
            memory
        };
        Some(Self { board, trial, state: State::Stopped(memory) })
    }

    /// The bootloader runs, then what it starts. Where that is nothing, or what hangs: after how long
    /// the next reset comes, ms.
    pub(crate) fn start(&mut self) -> Option<u64> {
        let none = State::Stopped(Memory::new(Chip::sized(0, 0), partition(0)));
        let mut memory = match core::mem::replace(&mut self.state, none) {
            State::Stopped(memory) => memory,
            State::Runs(receiver) => receiver.into_memory(),
        };
        let chip = memory.flash_mut();
        chip.power_on();
        chip.begin();
        let booted = boot(&mut memory, &self.board, || {});
        let Boot::Start { slot, header, trial } = booted else {
            self.state = State::Stopped(memory);
            return Some(NOTHING_MS);
        };
        if trial && self.trial == Trial::Hangs {
            self.state = State::Stopped(memory);
            return Some(WATCHDOG_MS);
        }
        let layout = match memory.record() {
            Recorded::Known(record) => record.layout,
            Recorded::Fresh | Recorded::Lost => header.layouts.newest,
        };
        let started = Started { slot, version: header.version, trial };
        let receiver = Receiver::new(memory, self.board, started, layout);
        self.state = State::Runs(Box::new(receiver));
        None
    }

    /// The program's part that updates.
    pub(crate) fn receiver(&mut self) -> Option<&mut dyn hal::Software> {
        match &mut self.state {
            State::Runs(receiver) => Some(&mut **receiver),
            State::Stopped(_) => None,
        }
    }

    /// What there is to say of the update; `None` while nothing runs.
    pub(crate) fn report(&self) -> Option<Report> {
        match &self.state {
            State::Runs(receiver) => Some(hal::Software::report(&**receiver)),
            State::Stopped(_) => None,
        }
    }

    /// What runs.
    pub(crate) fn running(&self) -> Option<Started> {
        match &self.state {
            State::Runs(receiver) => Some(receiver.report().started),
            State::Stopped(_) => None,
        }
    }

    /// It runs, and answers nothing.
    pub(crate) fn has_dead_link(&self) -> bool {
        self.trial == Trial::DeadLink && self.running().is_some_and(|started| started.trial)
    }

    pub(crate) fn chip(&self) -> &Chip {
        match &self.state {
            State::Stopped(memory) => memory.flash(),
            State::Runs(receiver) => receiver.memory().flash(),
        }
    }

    pub(crate) fn chip_mut(&mut self) -> &mut Chip {
        match &mut self.state {
            State::Stopped(memory) => memory.flash_mut(),
            State::Runs(receiver) => receiver.memory_mut().flash_mut(),
        }
    }

    /// The memory of parameters was used before it in this step, and has the same supply.
    pub(crate) fn follow(&mut self, memory: &Chip) {
        let chip = self.chip_mut();
        chip.wait_until(memory.busy_us());
        if memory.is_off() {
            chip.power_off();
        }
    }
}
