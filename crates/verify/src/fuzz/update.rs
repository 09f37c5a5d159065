//! The update of the software: any orders with any data, in any order, by their meaning and as bytes of the line,
//! restarts and power cuts, also in the recovery. What is started was signed for this board and committed, is never
//! older than what was confirmed, and its slot is never written.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use crate::fuzz::feed::Feed;
use crate::fuzz::flash::{Cut, Flash, Torn};
use embedded_storage::nor_flash::NorFlash as _;
use lafet_device::hal::Software as _;
use lafet_proto::update::{ORDER_MAX, Order};
use lafet_update::{
    Board, BoardName, Boot, HEADER_LEN, Hash, Header, Layouts, Memory, Partition, Phase, PublicKey,
    Receiver, SigningKey, Slot, Started, UNIT, Version, boot,
};

const SLOT_PAGES: u16 = 4;
const RECORD_PAGES: u16 = 4;
const LAYOUT: u16 = 1;
/// Images of versions 1 to this one are good; the first is there at the beginning.
const GOOD: u16 = 5;
/// Most operations of an input: many of them verify signatures.
const OPERATIONS: u32 = 32;
/// A start may be cut off as well, but not the one after this many.
const CUT_STARTS: u32 = 3;
/// Where a header has the hash of its payload.
const HASH: usize = 64;
const WORDS: [&[u8]; 2] = [b"the word", b"another word"];

/// An image.
struct Image {
    raw: [u8; HEADER_LEN],
    payload: Vec<u8>,
}

static KEYS: LazyLock<[SigningKey; 2]> =
    LazyLock::new(|| [0, 1].map(|id| SigningKey::new(id, [id + 1; 32])));
static PUBLIC: LazyLock<[PublicKey; 2]> =
    LazyLock::new(|| [0, 1].map(|id: usize| KEYS[id].public()));

fn board() -> Board<'static> {
    Board { name: BoardName::new("fuzz").expect("a name of a board"), keys: &*PUBLIC }
}

/// The good images by their versions, then what must never be started.
static POOL: LazyLock<Vec<Image>> = LazyLock::new(|| {
    let of = |major: u16| Header {
        size: 0,
        version: Version([major, 0, 0, 0]),
        board: board().name,
        place: None,
        key: 0,
        revokes: 0,
        layouts: Layouts { oldest: LAYOUT, newest: LAYOUT },
        hash: Hash::default(),
    };
    let signed = |key: &SigningKey, header: Header| {
        let major = header.version.0[0];
        let payload: Vec<u8> = (0..64 * major).map(|at| (at * 31 + major) as u8).collect();
        let raw = key.sign(&header, &payload).expect("what can be signed");
        Image { raw, payload }
    };
    // The fourth revokes the key of the others.
    let good = (1..=GOOD).map(|major| match major {
        4 | GOOD => signed(&KEYS[1], Header { revokes: 1, ..of(major) }),
        _ => signed(&KEYS[0], of(major)),
    });
    let stranger = SigningKey::new(0, [99; 32]);
    let other = BoardName::new("other").expect("a name of a board");
    let mut changed = signed(&KEYS[1], of(8));
    changed.payload[8] ^= 1;
    let mut renamed = signed(&KEYS[1], of(2));
    renamed.raw[16] = 9;
    let bad = [
        signed(&stranger, of(6)),
        signed(&KEYS[1], Header { board: other, ..of(7) }),
        changed,
        renamed,
    ];
    good.chain(bad).collect()
});

pub fn run(input: &[u8]) -> u64 {
    let mut feed = Feed::new(input);
    match feed.u8() % 3 {
        0 => Life::<8, 256>::run(&mut feed),
        1 => Life::<4, 512>::run(&mut feed),
        _ => Life::<2, 512>::run(&mut feed),
    }
}

type App<const W: usize, const P: usize> = Receiver<'static, Flash<W, P>>;

struct Life<const W: usize, const P: usize> {
    app: App<W, P>,
    /// The image that the last begin was of.
    of: usize,
    /// Versions that may have been committed.
    committed: BTreeSet<u16>,
    /// The version that was confirmed last; 0 once an older one was allowed.
    least: u16,
}

impl<const W: usize, const P: usize> Life<W, P> {
    const PARTITION: Partition = Partition {
        slots: [0, SLOT_PAGES as u32 * P as u32],
        slot_pages: SLOT_PAGES,
        record: 2 * SLOT_PAGES as u32 * P as u32,
        record_pages: RECORD_PAGES,
    };

    fn run(feed: &mut Feed<'_>) -> u64 {
        let flash = factory::<W, P>(u64::from(feed.u16()));
        let mut life = Self {
            app: start(flash).unwrap_or_else(|_| panic!("a new board starts")),
            of: 0,
            committed: BTreeSet::from([1]),
            least: 1,
        };
        for _ in 0..OPERATIONS {
            if feed.is_empty() {
                break;
            }
            life.operate(feed);
        }
        life.restart(feed);
        let flash = life.app.memory().flash();
        flash.reads + flash.steps
    }

    /// One operation, with a power cut in it if the input says so.
    fn operate(&mut self, feed: &mut Feed<'_>) {
        let code = feed.u8();
        if code >> 7 != 0 {
            let torn = Torn::ALL[feed.below(Torn::ALL.len())];
            self.app.memory().flash().cut(Cut { step: u64::from(feed.u8()), torn });
        }
        let running = self.running();
        match code % 16 {
            0 | 1 => self.begin(feed),
            2..=7 => self.data(feed),
            8 => self.any_data(feed),
            9 | 10 => self.verify(),
            11 => self.commit(feed),
            12 => self.confirm(feed),
            13 => self.bytes(feed),
            14 => _ = self.app.abandon(Hash::of(word(feed))),
            _ => self.restart(feed),
        }
        if code % 16 < 15 {
            assert!(self.running() == running, "the running slot is written");
        }
        if self.app.memory().flash().is_off() {
            self.restart(feed);
        }
        self.app.memory().flash().clear_cut();
    }

    /// The payload of the slot that is running, and what is behind it there.
    fn running(&self) -> Vec<u8> {
        let (memory, slot) = (self.app.memory(), self.app.report().started.slot);
        let (from, len) = (memory.payload_of(slot) as usize, memory.capacity());
        memory.flash().bytes()[from..from + len].to_vec()
    }

    fn begin(&mut self, feed: &mut Feed<'_>) {
        self.of = feed.below(POOL.len());
        let mut raw = POOL[self.of].raw;
        let how = feed.u8();
        if how & 3 == 3 {
            raw[feed.below(HEADER_LEN)] ^= feed.u8();
        }
        // A press at the board, which is seldom.
        let pressed = how >> 5 == 7;
        let started = self.app.begin(&raw, Hash::of(word(feed)), pressed);
        if pressed && started.is_ok() {
            self.least = 0;
        }
    }

    /// The next part of that image.
    fn data(&mut self, feed: &mut Feed<'_>) {
        let there = self.app.report().received;
        let rest = POOL[self.of].payload.get(there as usize..).unwrap_or_default();
        let part = &rest[..rest.len().min(UNIT * (1 + feed.below(19)))];
        let _ = self.app.data(there, part);
    }

    /// Any bytes, in their place or in any.
    fn any_data(&mut self, feed: &mut Feed<'_>) {
        let offset = if feed.chance() { self.app.report().received } else { feed.u32() };
        let len = usize::from(feed.u8()) % 128;
        let _ = self.app.data(offset, feed.take(len));
    }

    fn verify(&mut self) {
        let _ = self.app.verify();
        while self.app.report().phase == Phase::Verifying {
            let _ = self.app.poll();
        }
    }

    fn commit(&mut self, feed: &mut Feed<'_>) {
        let report = self.app.report();
        if matches!(report.phase, Phase::Verified | Phase::Committed) {
            // It may be stored though power fails in it.
            let of = POOL.iter().filter(|it| it.raw[HASH..].starts_with(&report.image));
            self.committed.extend(of.map(major));
        }
        let _ = self.app.commit(Hash::of(word(feed)));
    }

    fn confirm(&mut self, feed: &mut Feed<'_>) {
        let started = self.app.report().started;
        if self.app.confirm(word(feed)).is_ok() {
            assert!(started.trial, "what is not on trial is confirmed");
            self.least = started.version.0[0];
        }
    }

    /// As it comes over the line: any bytes, or an order with some of them changed.
    fn bytes(&mut self, feed: &mut Feed<'_>) {
        let mut buffer = [0; ORDER_MAX];
        let raw = &POOL[self.of].raw;
        let made = Order::Begin { header: raw, digest: &[0; 32] }.encode(&mut buffer);
        let mut data = match feed.chance() {
            true => made.unwrap_or_default().to_vec(),
            false => feed.take(ORDER_MAX).to_vec(),
        };
        let at = feed.below(data.len().max(1));
        let change = feed.u8();
        if let Some(byte) = data.get_mut(at) {
            *byte ^= change;
        }
        if let Ok((order, _)) = Order::decode(&data) {
            self.app.perform(&order);
        }
    }

    /// Power goes and comes back; it may go again while the bootloader is at work.
    fn restart(&mut self, feed: &mut Feed<'_>) {
        let mut flash = self.app.memory().flash().clone().power_on();
        for cut in 0.. {
            let kind = feed.u8();
            if cut < CUT_STARTS && kind & 3 == 3 {
                let torn = Torn::ALL[usize::from(kind >> 2) % Torn::ALL.len()];
                flash.cut(Cut { step: u64::from(feed.u8()) % 16, torn });
            }
            match start(flash) {
                Ok(app) => {
                    self.app = app;
                    break;
                }
                Err(off) => {
                    assert!(off.is_off(), "a board always starts");
                    flash = off.power_on();
                }
            }
        }
        self.is_rightly_started();
    }

    fn is_rightly_started(&self) {
        let report = self.app.report();
        let Version([version, ..]) = report.started.version;
        let memory = self.app.memory();
        let slot = report.started.slot;
        let lies = |at: u32, len: usize| &memory.flash().bytes()[at as usize..][..len];
        let good = POOL.iter().take(usize::from(GOOD));
        let started = good.filter(|it| major(it) == version).any(|it| {
            lies(memory.start_of(slot), HEADER_LEN) == it.raw
                && lies(memory.payload_of(slot), it.payload.len()) == it.payload
        });
        assert!(started, "version {version} is started, and was not signed so");
        assert!(self.committed.contains(&version), "version {version} was not committed");
        // Power that fails in the start itself is seen by the next one.
        if !memory.flash().is_off() {
            assert!(version >= self.least, "version {version} after {}", self.least);
        }
    }
}

fn word(feed: &mut Feed<'_>) -> &'static [u8] {
    WORDS[usize::from(feed.u8() & 7 == 7)]
}

fn major(image: &Image) -> u16 {
    u16::from_le_bytes([image.raw[16], image.raw[17]])
}

fn memory<const W: usize, const P: usize>(flash: Flash<W, P>) -> Memory<Flash<W, P>> {
    Memory::new(flash, Life::<W, P>::PARTITION)
}

/// A flash with the first image in slot A, and anything elsewhere.
fn factory<const W: usize, const P: usize>(seed: u64) -> Flash<W, P> {
    let mut flash = Flash::new(usize::from(2 * SLOT_PAGES + RECORD_PAGES), seed);
    let places = memory(flash.clone());
    let (header, payload) = (places.start_of(Slot::A), places.payload_of(Slot::A));
    let mut starts = (0..u32::from(SLOT_PAGES)).map(|page| page * P as u32);
    let erased = starts.try_for_each(|from| flash.erase(from, from + P as u32));
    let written = erased.and_then(|()| flash.write(header, &POOL[0].raw));
    written.and_then(|()| flash.write(payload, &POOL[0].payload)).expect("it is on");
    flash
}

/// Starts the board; its flash when nothing can be started.
fn start<const W: usize, const P: usize>(
    flash: Flash<W, P>,
) -> Result<App<W, P>, Box<Flash<W, P>>> {
    let mut memory = memory(flash);
    match boot(&mut memory, &board(), || {}) {
        Boot::Start { slot, header, trial } => {
            let started = Started { slot, version: header.version, trial };
            Ok(Receiver::new(memory, board(), started, LAYOUT))
        }
        Boot::Nothing => Err(Box::new(memory.into_flash())),
    }
}
