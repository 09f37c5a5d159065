//! The store of the parameters on a flash: any contents at the start, then writes, erases, power
//! cuts and bit rot in any order, compared with a map of what must be stored.

use std::collections::{BTreeMap, BTreeSet};

use crate::fuzz::feed::Feed;
use crate::fuzz::flash::{Cut, Flash, Torn};
use lafet_device::hal::{Key, Storage, StorageError, VALUE_MAX};
use lafet_device::store::Store;

/// Keys 1 to this one are used; one more slot stays free.
const KEYS: u16 = 9;
const SLOTS: usize = 10;
/// Most operations of an input.
const OPERATIONS: u32 = 64;
/// A start may be cut off as well, but not the one after this many.
const CUT_STARTS: u32 = 4;

/// Result of reading each key.
type Values = BTreeMap<u16, Result<Option<Vec<u8>>, StorageError>>;

pub fn run(input: &[u8]) -> u64 {
    let mut feed = Feed::new(input);
    match feed.u8() % 5 {
        0 => Life::<1, 256>::run(2, &mut feed),
        1 => Life::<2, 256>::run(3, &mut feed),
        2 => Life::<2, 512>::run(2, &mut feed),
        3 => Life::<4, 384>::run(4, &mut feed),
        _ => Life::<8, 384>::run(3, &mut feed),
    }
}

/// How much is known about the contents of the store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trust {
    /// Exactly these values.
    Exact,
    /// A bit has flipped: at most one value is lost, and that is reported as an error.
    OneLost,
    /// More bits have flipped: a value that can be read was stored under that key at some time, and
    /// stays until it is replaced.
    AnyLost,
    /// The initial contents were arbitrary: what was read first stays until it is replaced.
    Foreign,
}

struct Life<const W: usize, const P: usize> {
    store: Store<Flash<W, P>, SLOTS>,
    values: Values,
    /// Every value ever stored, or to be stored.
    history: BTreeSet<(u16, Vec<u8>)>,
    trust: Trust,
    version: u16,
}

impl<const W: usize, const P: usize> Life<W, P> {
    fn run(pages: usize, feed: &mut Feed<'_>) -> u64 {
        let mut flash = Flash::<W, P>::new(pages, u64::from(feed.u16()));
        let kind = feed.u8();
        (flash.checked, flash.strict) = (kind & 1 != 0, kind & 2 != 0);
        let is_foreign = kind & 4 != 0;
        if is_foreign {
            let len = usize::from(feed.u16()) % (pages * P);
            put(&mut flash, feed.take(len));
        }
        let mut life = Self {
            store: mount(flash),
            values: (1..=KEYS).map(|key| (key, Ok(None))).collect(),
            history: BTreeSet::new(),
            trust: Trust::Exact,
            version: 0,
        };
        if is_foreign {
            life.trust = Trust::Foreign;
            life.adopt();
        }
        life.check("at the start");
        for _ in 0..OPERATIONS {
            if feed.is_empty() {
                break;
            }
            life.operate(feed);
        }
        life.store.flash().reads + life.store.flash().steps
    }

    /// Runs one operation, with a power cut in it if the input says so.
    fn operate(&mut self, feed: &mut Feed<'_>) {
        let code = feed.u8();
        if code >> 7 != 0 {
            self.cut(feed);
        }
        let mut after = self.values.clone();
        let (what, result) = match code % 16 {
            0..=7 => {
                let key = 1 + u16::from(feed.u8()) % KEYS;
                let value = self.value(key, feed);
                self.history.insert((key, value.clone()));
                let result = self.store.store(Key(key), &value);
                after.insert(key, Ok(Some(value)));
                ("store", result)
            }
            8 => ("prepare", self.store.prepare().map(|_| ())),
            9 => {
                after.values_mut().for_each(|value| *value = Ok(None));
                ("erase", self.store.erase())
            }
            10..=12 => {
                self.store = mount(self.store.flash().clone());
                ("restart", Ok(()))
            }
            _ => {
                self.rot(feed);
                after = self.values.clone();
                ("rot", Ok(()))
            }
        };
        if self.store.flash().is_off() {
            assert!(result.is_err() || matches!(what, "restart" | "rot"), "{what}: acknowledged");
            self.recover(feed, after, what);
        } else if result.is_ok() {
            self.values = after;
        } else {
            let is_known = matches!(self.trust, Trust::Exact | Trust::OneLost);
            assert!(what == "store" || !is_known, "{what}: {result:?}");
        }
        self.store.flash().clear_cut();
        self.check(what);
    }

    /// A value of which no other one is a part; sometimes the one already stored.
    fn value(&mut self, key: u16, feed: &mut Feed<'_>) -> Vec<u8> {
        self.version += u16::from(feed.chance());
        let len = usize::from(feed.u8()) % (P / 6).min(VALUE_MAX);
        let [v0, v1] = self.version.to_le_bytes();
        (0..len).map(|index| [v0, v1, key as u8, index as u8][index % 4]).collect()
    }

    fn cut(&mut self, feed: &mut Feed<'_>) {
        let torn = Torn::ALL[feed.below(Torn::ALL.len())];
        self.store.flash().cut(Cut { step: u64::from(feed.u8()), torn });
    }

    /// Flips bits while the power is off.
    fn rot(&mut self, feed: &mut Feed<'_>) {
        let mut flash = self.store.flash().clone();
        let bits = flash.bytes().len() * 8;
        let count = 1 + feed.below(4);
        (0..count).for_each(|_| flash.flip(usize::from(feed.u16()) % bits));
        self.store = mount(flash);
        self.trust = match self.trust {
            Trust::Exact if count == 1 => Trust::OneLost,
            Trust::Foreign => Trust::Foreign,
            _ => Trust::AnyLost,
        };
        if matches!(self.trust, Trust::AnyLost | Trust::Foreign) {
            self.adopt();
        }
    }

    /// Takes the present contents as what must be stored from now on.
    fn adopt(&mut self) {
        self.values = self.read();
        for (key, read) in &self.values {
            if let (Ok(Some(value)), true) = (read, self.trust != Trust::Foreign) {
                let is_ours = self.history.contains(&(*key, value.clone()));
                assert!(is_ours, "{key} reads {value:?}, which was never stored there");
            }
        }
    }

    /// Power returns after a cut: each value is the old or the new one, and if everything is known,
    /// all are old or all are new.
    fn recover(&mut self, feed: &mut Feed<'_>, after: Values, what: &str) {
        for left in (0..=CUT_STARTS).rev() {
            let flash = self.store.flash().clone().power_on();
            if left > 0 && feed.chance() {
                let torn = Torn::ALL[feed.below(Torn::ALL.len())];
                flash.cut(Cut { step: u64::from(feed.u8() % 32), torn });
            }
            self.store = mount(flash);
            if !self.store.flash().is_off() {
                break;
            }
        }
        self.store.flash().clear_cut();
        let held = self.read();
        match self.trust {
            Trust::Exact => {
                let before = &self.values;
                assert!(
                    held == after || held == *before,
                    "{what}: {held:?}\n  not {before:?}\n  nor {after:?}"
                );
            }
            Trust::OneLost => self.trust = Trust::AnyLost,
            Trust::AnyLost | Trust::Foreign => {}
        }
        self.adopt();
    }

    fn read(&mut self) -> Values {
        let mut values = Values::new();
        for key in 1..=KEYS {
            let mut buffer = [0; VALUE_MAX];
            let read = self.store.load(Key(key), &mut buffer);
            values.insert(key, read.map(|value| value.map(<[u8]>::to_vec)));
        }
        values
    }

    fn check(&mut self, what: &str) {
        let held = self.read();
        let trust = self.trust;
        let told = held.values().filter(|read| read.is_err()).count();
        match trust {
            Trust::Exact => assert!(told == 0, "{what}: {held:?}"),
            Trust::OneLost => assert!(told <= 1, "{what}: {held:?}"),
            Trust::AnyLost | Trust::Foreign => {}
        }
        for (key, read) in &held {
            let expected = &self.values[key];
            let is_told = trust == Trust::OneLost && read.is_err();
            assert!(
                read == expected || is_told,
                "{what}, {trust:?}: {key} reads {read:?}, not {expected:?}"
            );
        }
    }
}

fn mount<const W: usize, const P: usize>(flash: Flash<W, P>) -> Store<Flash<W, P>, SLOTS> {
    let pages = flash.pages();
    Store::mount(flash, 0, pages)
}

/// Writes bytes at the start of the flash.
fn put<const W: usize, const P: usize>(flash: &mut Flash<W, P>, bytes: &[u8]) {
    for (index, byte) in bytes.iter().enumerate() {
        let change = flash.bytes()[index] ^ byte;
        (0..8).filter(|bit| change >> bit & 1 != 0).for_each(|bit| flash.flip(index * 8 + bit));
    }
}
