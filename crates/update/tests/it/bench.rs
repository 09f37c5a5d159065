//! A board on a flash that can lose power, and images for it.

use crate::flash::Flash;
use lafet_update::{
    Board, BoardName, Boot, HEADER_LEN, Hash, Header, Layouts, Memory, Partition, PublicKey,
    Receiver, Refusal, SigningKey, Slot, Started, Version, boot,
};
use std::sync::LazyLock;

/// Pages of a slot.
pub const SLOT_PAGES: u16 = 5;
/// Pages of the record.
pub const RECORD_PAGES: u16 = 4;
/// The layout in which parameters are stored.
pub const LAYOUT: u16 = 2;
/// The word that confirms.
pub const WORD: &[u8] = b"confirmed by bench";

pub type Chip<const WORD: usize, const PAGE: usize> = Flash<WORD, PAGE>;

pub static KEYS: LazyLock<[SigningKey; 3]> =
    LazyLock::new(|| [0, 1, 2].map(|id| SigningKey::new(id, [id + 1; 32])));
static PUBLIC: LazyLock<[PublicKey; 3]> =
    LazyLock::new(|| [0, 1, 2].map(|id: usize| KEYS[id].public()));

pub fn board() -> Board<'static> {
    Board { name: BoardName::new("bench").unwrap(), keys: &*PUBLIC }
}

/// An image: its header, signed, and its payload.
#[derive(Clone)]
pub struct Image {
    pub raw: [u8; HEADER_LEN],
    pub payload: Vec<u8>,
}

impl Image {
    pub fn header(&self) -> Header {
        Header::parse(&self.raw).unwrap()
    }
}

/// What a header says unless a test wants it otherwise.
pub fn fields(major: u16) -> Header {
    Header {
        size: 0,
        version: Version([major, 0, 0, 0]),
        board: board().name,
        place: None,
        key: 0,
        revokes: 0,
        layouts: Layouts { oldest: 1, newest: 3 },
        hash: Hash::default(),
    }
}

pub fn payload(major: u16, len: usize) -> Vec<u8> {
    (0..len).map(|at| (at as u8).wrapping_mul(31).wrapping_add(major as u8)).collect()
}

pub fn image(major: u16, len: usize) -> Image {
    signed(&KEYS[0], &fields(major), payload(major, len))
}

pub fn signed(key: &SigningKey, header: &Header, payload: Vec<u8>) -> Image {
    Image { raw: key.sign(header, &payload).unwrap(), payload }
}

pub const fn partition(page: usize) -> Partition {
    let slot = SLOT_PAGES as u32 * page as u32;
    Partition {
        slots: [0, slot],
        slot_pages: SLOT_PAGES,
        record: 2 * slot,
        record_pages: RECORD_PAGES,
    }
}

/// A flash as it leaves the factory: `image` in slot A, nothing that means anything elsewhere,
/// and two pages behind it that updating must leave alone.
pub fn factory<const W: usize, const P: usize>(image: &Image, seed: u64) -> Chip<W, P> {
    let mut flash = Flash::new(usize::from(2 * SLOT_PAGES + RECORD_PAGES) + 2, seed);
    put(&mut flash, Slot::A, image);
    flash
}

/// Puts an image into a slot, as a programmer does.
pub fn put<const W: usize, const P: usize>(flash: &mut Chip<W, P>, slot: Slot, image: &Image) {
    use embedded_storage::nor_flash::NorFlash;
    let memory = memory(flash.clone());
    let (start, payload) = (memory.start_of(slot), memory.payload_of(slot));
    let end = start + u32::from(SLOT_PAGES) * P as u32;
    for page in (start..end).step_by(P) {
        flash.erase(page, page + P as u32).unwrap();
    }
    flash.write(start, &image.raw).unwrap();
    flash.write(payload, &image.payload).unwrap();
}

pub fn memory<const W: usize, const P: usize>(flash: Chip<W, P>) -> Memory<Chip<W, P>> {
    Memory::new(flash, partition(P))
}

/// Starts the board; its flash when nothing can be started.
pub fn start<const W: usize, const P: usize>(
    flash: Chip<W, P>,
) -> Result<Receiver<'static, Chip<W, P>>, Box<Chip<W, P>>> {
    let mut memory = memory(flash);
    match boot(&mut memory, &board(), || {}) {
        Boot::Start { slot, header, trial } => {
            let started = Started { slot, version: header.version, trial };
            Ok(Receiver::new(memory, board(), started, LAYOUT))
        }
        Boot::Nothing => Err(Box::new(memory.into_flash())),
    }
}

/// Receives and verifies an image, in parts of `part` bytes.
pub fn receive<const W: usize, const P: usize>(
    receiver: &mut Receiver<'_, Chip<W, P>>,
    image: &Image,
    part: usize,
) -> Result<(), Refusal> {
    let there = receiver.begin(&image.raw, Hash::of(WORD), false)?;
    for (index, bytes) in image.payload[there as usize..].chunks(part).enumerate() {
        receiver.data(there + (index * part) as u32, bytes)?;
    }
    receiver.verify()?;
    while receiver.report().phase == lafet_update::Phase::Verifying {
        receiver.poll()?;
    }
    Ok(())
}

/// The whole of an update, up to the restart.
pub fn update<const W: usize, const P: usize>(
    receiver: &mut Receiver<'_, Chip<W, P>>,
    image: &Image,
) -> Result<(), Refusal> {
    receive(receiver, image, 24)?;
    receiver.commit(Hash::of(WORD))
}
