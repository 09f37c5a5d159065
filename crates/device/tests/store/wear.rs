//! Figures for docs/storage.md: `cargo test -p lafet-device --test store wear -- --nocapture`.

use crate::check::{start, value};
use crate::flash::Flash;
use lafet_device::Composition;
use lafet_device::Device;
use lafet_device::hal::{Key, Storage, StorageError};
use lafet_device::store::Store;

/// Notes the sizes of what a monitor leaves the factory with.
#[derive(Default)]
struct Sizes(Vec<(u16, usize)>);

impl Storage for Sizes {
    fn load<'b>(&mut self, _: Key, _: &'b mut [u8]) -> Result<Option<&'b [u8]>, StorageError> {
        Ok(None)
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        self.0.push((key.0, value.len()));
        Ok(())
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        Ok(())
    }
}

/// All that a monitor can store: numbers, programs, trajectories of 15 points, the correction
/// table, the lockout.
fn full_set() -> Vec<(u16, usize)> {
    let mut sizes = Sizes::default();
    Device::provision(&mut sizes, &Composition::FULL, 1).unwrap();
    let mut set = sizes.0;
    let next = set.iter().map(|(key, _)| key + 1).max().unwrap_or(1);
    let more = [16; 8].into_iter().chain([92; 8]).chain([258, 3]);
    set.extend((next..).zip(more));
    set
}

#[derive(Debug, Default)]
struct Figures {
    writes: u32,
    erases: u32,
    most_of_a_page: u32,
    /// In one call of `store`.
    most_erases: u32,
    most_words: u64,
}

/// Replaces values of the full set again and again, `pick` says which.
fn figures<const W: usize, const P: usize>(
    pages: usize,
    set: &[(u16, usize)],
    writes: u32,
    pick: impl Fn(u64) -> usize,
) -> Figures {
    let mut store: Store<_, 40> = start(Flash::<W, P>::new(pages, 1));
    for (key, len) in set {
        store.store(Key(*key), &value(*key, 0, *len)).unwrap();
    }
    let erases = store.flash().erases.clone();
    let mut figures = Figures { writes, ..Figures::default() };
    for version in 0..writes {
        let (key, len) = set[pick(store.flash().random()) % set.len()];
        let (opened, steps) = (store.opened(), store.flash().steps);
        store.store(Key(key), &value(key, (version % 65_000) as u16 + 1, len)).unwrap();
        figures.most_erases = figures.most_erases.max(store.opened() - opened);
        figures.most_words = figures.most_words.max(store.flash().steps - steps);
    }
    let worn: Vec<u32> =
        store.flash().erases.iter().zip(erases).map(|(now, was)| now - was).collect();
    figures.erases = worn.iter().sum();
    figures.most_of_a_page = *worn.iter().max().unwrap();
    assert!(figures.most_of_a_page - worn.iter().min().unwrap() <= 1, "levelled: {worn:?}");
    figures
}

fn show<const W: usize, const P: usize>(pages: usize) -> [Figures; 3] {
    let set = full_set();
    let last = set.len() - 1;
    let lockout = figures::<W, P>(pages, &set, 20_000, |_| last);
    let numbers = figures::<W, P>(pages, &set, 20_000, |random| random as usize % 14);
    let any = figures::<W, P>(pages, &set, 20_000, |random| random as usize);
    println!("{W}-byte words, {pages} pages of {P}:");
    for (name, figures) in [("lockout", &lockout), ("numbers", &numbers), ("any", &any)] {
        println!("  {name}: {figures:?}");
    }
    [lockout, numbers, any]
}

#[test]
fn full_set_and_wear() {
    let set = full_set();
    let bytes: usize = set.iter().map(|(_, len)| len).sum();
    println!("{} values, {bytes} bytes", set.len());
    assert!(set.len() <= lafet_device::store::KEYS);
    let all = [
        show::<2, 1024>(4),
        show::<2, 1024>(5),
        show::<2, 1024>(8),
        show::<4, 1024>(8),
        show::<8, 2048>(4),
        show::<8, 2048>(8),
        show::<4, 4096>(2),
        show::<8, 4096>(4),
    ];
    for [lockout, numbers, any] in all {
        // Many writes to an erase, even beside a full set that has to be carried along.
        assert!(lockout.erases * 10 < lockout.writes, "{lockout:?}");
        assert!(numbers.erases * 2 < numbers.writes, "{numbers:?}");
        assert!(any.erases < any.writes, "{any:?}");
    }
}
