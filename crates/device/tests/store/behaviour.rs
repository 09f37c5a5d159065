//! What the store keeps and refuses, in each geometry, and how it takes a flash that fails.

use crate::check::{Op, Values, perform, read, recovered, start, value};
use crate::cuts::operations;
use crate::flash::{Cut, Flash, Torn};
use lafet_device::hal::{Key, Storage, StorageError, VALUE_MAX};
use lafet_device::store::Store;

fn keeps_all_sizes<const W: usize, const P: usize>(pages: usize) {
    let mut store: Store<_, 10> = start(Flash::<W, P>::new(pages, 7));
    let mut buffer = [0; VALUE_MAX];
    assert_eq!(store.load(Key(1), &mut buffer), Ok(None), "anything is not a value");
    for len in 0..=VALUE_MAX {
        let (first, second) = (value(1, len as u16, len), value(2, len as u16, VALUE_MAX - len));
        store.store(Key(1), &first).unwrap();
        store.store(Key(2), &second).unwrap();
        for _ in 0..2 {
            assert_eq!(store.load(Key(1), &mut buffer), Ok(Some(first.as_slice())));
            assert_eq!(store.load(Key(2), &mut buffer), Ok(Some(second.as_slice())));
            store = start(store.into_flash());
        }
    }
    let erased = store.opened();
    let most = *store.flash().erases.iter().max().unwrap();
    let least = *store.flash().erases.iter().min().unwrap();
    assert!(most - least <= 1 && least > 3, "levelled: {least} to {most} of {erased}");
    assert_eq!(store.flash().erases.iter().sum::<u32>(), erased);
}

#[test]
fn values_of_all_sizes_in_all_geometries() {
    keeps_all_sizes::<1, 1024>(2);
    keeps_all_sizes::<2, 1024>(3);
    keeps_all_sizes::<4, 2048>(2);
    keeps_all_sizes::<8, 1024>(5);
    keeps_all_sizes::<8, 4096>(2);
}

#[test]
fn the_same_value_is_not_written_again() {
    let mut store: Store<_, 10> = start(Flash::<2, 1024>::new(2, 1));
    store.store(Key(1), &[1, 2, 3]).unwrap();
    let steps = store.flash().steps;
    store.store(Key(1), &[1, 2, 3]).unwrap();
    assert_eq!(store.flash().steps, steps);
    store.store(Key(1), &[1, 2, 4]).unwrap();
    assert!(store.flash().steps > steps);
    let steps = store.flash().steps;
    store = start(store.into_flash());
    assert_eq!(store.flash().steps, steps, "a start after an orderly end writes nothing");
}

#[test]
fn full_is_refused_without_wear() {
    // Pages of 228 bytes, one of them free; entries of 40, five in each.
    for (pages, entries) in [(3, 10), (5, 20)] {
        let mut store: Store<_, 40> = start(Flash::<4, 256>::new(pages, 1));
        let mut key = 1;
        while store.store(Key(key), &value(key, 1, 20)).is_ok() {
            key += 1;
        }
        assert_eq!(key, entries + 1);
        let (erases, steps) = (store.flash().erases.clone(), store.flash().steps);
        assert_eq!(store.store(Key(key), &value(key, 1, 20)), Err(StorageError::Write));
        assert_eq!(store.store(Key(1), &[0; VALUE_MAX]), Err(StorageError::Write));
        assert_eq!(store.store(Key(1), &[0; VALUE_MAX + 1]), Err(StorageError::Write));
        assert_eq!((store.flash().erases.clone(), store.flash().steps), (erases, steps));
        let mut buffer = [0; VALUE_MAX];
        for key in 1..key {
            let expected = value(key, 1, 20);
            assert_eq!(store.load(Key(key), &mut buffer), Ok(Some(expected.as_slice())));
        }
        store.erase().unwrap();
        store.store(Key(1), &value(1, 2, 150)).unwrap();
    }
}

/// The short form of `cuts`: in one geometry, without a second cut in the recovery.
#[test]
fn a_power_cut_leaves_the_old_or_the_new() {
    let mut store: Store<_, 8> = start(Flash::<8, 256>::new(3, 1));
    let mut values = Values::new();
    let mut taken = 0;
    for op in operations(6) {
        let mut whole = store.clone();
        let (result, after) = perform(&mut whole, &op, &values);
        assert_eq!(result, Ok(()), "{op:?}");
        for step in 0..whole.flash().steps - store.flash().steps {
            for torn in [Torn::Old, Torn::New, Torn::Random, Torn::Unstable] {
                let mut store = store.clone();
                store.flash().cut(Cut { step, torn });
                assert!(perform(&mut store, &op, &values).0.is_err(), "{op:?}: acknowledged");
                let mut store: Store<_, 8> = start(store.into_flash().power_on());
                taken += u32::from(read(&mut store).as_ref() == Ok(&after) && after != values);
                recovered(&mut store, [&values, &after], 4)
                    .unwrap_or_else(|wrong| panic!("{op:?}, {step}, {torn:?}: {wrong}"));
            }
        }
        (store, values) = (whole, after);
    }
    assert!(taken > 5, "{taken}");
}

#[test]
fn keys_are_limited() {
    let mut store: Store<_, 2> = start(Flash::<4, 256>::new(3, 1));
    store.store(Key(1), &[1]).unwrap();
    store.store(Key(0xFFFF), &[2]).unwrap();
    assert_eq!(store.store(Key(3), &[3]), Err(StorageError::Write));
    store.store(Key(1), &[4]).unwrap();
    let mut buffer = [0; 4];
    assert_eq!(store.load(Key(0xFFFF), &mut buffer), Ok(Some(&[2][..])));
    assert_eq!(store.load(Key(0xFFFF), &mut []), Err(StorageError::Read), "no room to read it");
    // A program that knows of fewer keys cannot say that one was never set.
    let mut smaller: Store<_, 1> = start(store.into_flash());
    let reads = [1, 0xFFFF].map(|key| smaller.load(Key(key), &mut buffer).is_err());
    assert!(reads.contains(&true));
}

#[test]
fn erase_takes_all_and_costs_one_page() {
    let mut store: Store<_, 10> = start(Flash::<8, 1024>::new(4, 1));
    for key in 1..9 {
        store.store(Key(key), &value(key, 1, 200)).unwrap();
    }
    let erases = store.opened();
    store.erase().unwrap();
    assert_eq!(store.opened(), erases + 1);
    store.erase().unwrap();
    assert_eq!(store.opened(), erases + 1, "nothing to erase");
    assert_eq!(read(&mut store).unwrap().len(), 0);
    store = start(store.into_flash());
    assert_eq!(read(&mut store).unwrap().len(), 0);
    store.store(Key(3), &[1]).unwrap();
    store = start(store.into_flash());
    assert_eq!(read(&mut store).unwrap().len(), 1);
}

#[test]
fn after_prepare_nothing_is_erased() {
    let mut store: Store<_, 10> = start(Flash::<2, 1024>::new(4, 1));
    for version in 0..60 {
        let mut calls = 0;
        loop {
            let before = store.opened();
            let done = store.prepare().unwrap();
            assert_eq!(store.opened() - before, u32::from(done), "one page at a time");
            if !done {
                break;
            }
            calls += 1;
            assert!(calls < 4);
        }
        let erases = store.opened();
        store.store(Key(version % 5), &value(1, version, VALUE_MAX)).unwrap();
        assert_eq!(store.opened(), erases);
    }
    assert!(store.opened() > 15);
}

#[test]
fn a_worn_word_costs_nothing() {
    let mut flash = Flash::<4, 512>::new(3, 1);
    // In the middle of page 1, which is the first to be used.
    flash.worn.push(512 + 200..512 + 204);
    let mut store: Store<_, 10> = start(flash);
    for version in 0..200 {
        let key = 1 + version % 4;
        store.store(Key(key), &value(key, version, 30)).unwrap();
    }
    store = start(store.into_flash());
    let held = read(&mut store).unwrap();
    assert_eq!(held.len(), 4);
    for (key, held) in held {
        assert_eq!(held, value(key, 195 + key, 30));
    }
}

/// Stores short and long values while words are worn; what was acknowledged is there.
fn with_worn_words(word: u32, more: &[core::ops::Range<u32>]) {
    let mut flash = Flash::<4, 512>::new(3, 1);
    flash.worn.push(word..word + 4);
    flash.worn.extend_from_slice(more);
    let worn = flash.worn.clone();
    let mut store: Store<_, 10> = start(flash);
    let mut may_holds: [Vec<Option<Vec<u8>>>; 4] = core::array::from_fn(|_| vec![None]);
    for version in 0..24 {
        let key = version % 4;
        let fresh = value(key, version, if version % 3 == 0 { 100 } else { 8 });
        let may_hold = &mut may_holds[usize::from(key)];
        match store.store(Key(key), &fresh) {
            Ok(()) => *may_hold = vec![Some(fresh)],
            Err(_) => may_hold.push(Some(fresh)),
        }
        let mut later: Store<_, 10> = start(store.flash().clone());
        for (key, may_hold) in may_holds.iter().enumerate() {
            let mut buffer = [0; VALUE_MAX];
            let held = later.load(Key(key as u16), &mut buffer).unwrap().map(<[u8]>::to_vec);
            assert!(may_hold.contains(&held), "{worn:?}, key {key}: {held:?} not {may_hold:?}");
        }
    }
}

#[test]
fn worn_words_lose_nothing() {
    for word in (0..3 * 512).step_by(4) {
        with_worn_words(word, &[]);
        // Two failures in one call.
        with_worn_words(word, &[1024 + 60..1536, 0..0]);
        with_worn_words(word, &[512 + 300..1024, 100..512]);
    }
}

#[test]
fn a_stuck_bit_costs_nothing_or_is_reported() {
    for bit in (512 * 8..1024 * 8).step_by(5) {
        for stuck in [false, true] {
            let mut flash = Flash::<4, 512>::new(3, 1);
            flash.stuck = Some((bit, stuck));
            let mut store: Store<_, 10> = start(flash);
            let mut expected = [None; 4];
            for version in 0..40 {
                let key = version % 4;
                // The ring ends at a page that cannot be erased or opened.
                match store.store(Key(key), &[version as u8 ^ 0x55; 30]) {
                    Ok(()) => expected[usize::from(key)] = Some(version as u8 ^ 0x55),
                    Err(error) => assert_eq!(error, StorageError::Write),
                }
                // It is the first page to be used.
                assert!(stuck || expected == [None; 4], "bit {bit}: not erased, but used");
                store = start(store.into_flash());
                for (key, expected) in expected.iter().enumerate() {
                    let mut buffer = [0; 30];
                    let held = store.load(Key(key as u16), &mut buffer).unwrap();
                    assert_eq!(held, expected.map(|byte| [byte; 30]).as_ref().map(|v| &v[..]));
                }
            }
        }
    }
}

#[test]
fn a_page_that_cannot_be_erased_is_reported() {
    let mut store: Store<_, 10> = start(Flash::<4, 512>::new(2, 1));
    store.store(Key(1), &[1, 2, 3]).unwrap();
    // Power stays away: nothing can be read or written.
    store.flash().cut(Cut { step: 0, torn: Torn::Old });
    assert_eq!(store.store(Key(1), &[4]), Err(StorageError::Write));
    assert_eq!(store.load(Key(1), &mut [0; 8]), Err(StorageError::Read));
    assert_eq!(store.erase(), Err(StorageError::Write));
    assert_eq!(store.prepare(), Err(StorageError::Write));
    store = start(store.into_flash().power_on());
    assert_eq!(store.load(Key(1), &mut [0; 8]), Ok(Some(&[1, 2, 3][..])));
}

#[test]
fn other_geometry_is_a_new_store() {
    let mut store: Store<_, 10> = start(Flash::<4, 512>::new(4, 1));
    store.store(Key(1), &[1, 2, 3]).unwrap();
    let mut store: Store<_, 10> = Store::mount(store.into_flash(), 0, 3);
    assert_eq!(store.load(Key(1), &mut [0; 8]), Ok(None));
    store.store(Key(1), &[5]).unwrap();
    // Too few pages for a log: nothing is stored, and nothing fails in another way.
    for pages in [0, 1] {
        let mut store: Store<_, 10> = Store::mount(store.flash().clone(), 0, pages);
        assert_eq!(store.load(Key(1), &mut [0; 8]), Ok(None));
        assert_eq!(store.store(Key(1), &[5]), Err(StorageError::Write));
    }
}

#[test]
fn a_part_of_the_flash_is_enough() {
    let flash = Flash::<4, 512>::new(5, 1);
    let before = flash.bytes().to_vec();
    let mut store: Store<_, 10> = Store::mount(flash, 1024, 2);
    for version in 0..100 {
        store.store(Key(1), &value(1, version, 40)).unwrap();
    }
    let flash = store.into_flash();
    assert_eq!(flash.bytes()[..1024], before[..1024]);
    assert_eq!(flash.bytes()[2048..], before[2048..]);
    let mut store: Store<_, 10> = Store::mount(flash, 1024, 2);
    assert_eq!(store.load(Key(1), &mut [0; 40]), Ok(Some(value(1, 99, 40).as_slice())));
}

#[test]
fn a_flash_that_refuses_to_write_twice_works_too() {
    let mut flash = Flash::<8, 512>::new(3, 1);
    flash.strict = true;
    let mut store: Store<_, 10> = start(flash);
    for version in 0..100 {
        store.store(Key(version % 3), &value(1, version, 40)).unwrap();
        store = start(store.into_flash());
    }
    assert_eq!(store.load(Key(0), &mut [0; 40]), Ok(Some(value(1, 99, 40).as_slice())));
}

/// A flash that cannot be read at the start is no empty one: nothing is reported as unset, nothing is
/// stored on top of what was never read, and once it can be read again all is there.
#[test]
fn unreadable_at_the_start() {
    let mut store: Store<_, 8> = start(Flash::<4, 256>::new(3, 1));
    for version in 0..40 {
        store.store(Key(1), &value(1, version, 20)).unwrap();
    }
    let mut flash = store.into_flash();
    flash.deaf = true;
    let mut store: Store<_, 8> = start(flash);
    let mut buffer = [0; VALUE_MAX];
    for key in [1, 2] {
        assert_eq!(store.load(Key(key), &mut buffer), Err(StorageError::Read));
    }
    assert_eq!(store.store(Key(2), &[1]), Err(StorageError::Write));
    assert_eq!(store.erase(), Err(StorageError::Write));
    assert_eq!(store.prepare(), Err(StorageError::Write));
    store.flash_mut().deaf = false;
    store.store(Key(2), &[2]).unwrap();
    let mut store: Store<_, 8> = start(store.into_flash());
    assert_eq!(store.load(Key(1), &mut buffer), Ok(Some(&value(1, 39, 20)[..])));
    assert_eq!(store.load(Key(2), &mut buffer), Ok(Some(&[2][..])));
}

/// Where a value is, for tools that look at it or damage it.
#[test]
fn address_of_a_value() {
    let mut store: Store<_, 8> = start(Flash::<4, 256>::new(3, 1));
    store.store(Key(1), b"here").unwrap();
    store.store(Key(2), b"").unwrap();
    let at = store.address_of(Key(1)).unwrap() as usize;
    assert_eq!(&store.flash().bytes()[at..at + 4], b"here");
    assert_eq!((store.address_of(Key(2)), store.address_of(Key(3))), (None, None));
}

/// What a start finds after a power cut in the last step of an operation, or in that many before it:
/// the value, how many pages have been opened, and whether the first start, and the second, writes.
fn left_by(op: &Op, back: u64, torn: Torn) -> (Option<Vec<u8>>, u32, [bool; 2]) {
    let mut store: Store<_, 8> = start(Flash::<4, 512>::new(4, 1));
    store.store(Key(1), &[1; 9]).unwrap();
    if !matches!(op, Op::Store(..)) {
        store = start(store.into_flash());
    }
    let mut whole = store.clone();
    assert_eq!(perform(&mut whole, op, &Values::new()).0, Ok(()));
    let steps = whole.flash().steps - store.flash().steps;
    store.flash().cut(Cut { step: steps - 1 - back, torn });
    assert!(perform(&mut store, op, &Values::new()).0.is_err());
    let before = store.opened();
    let mut flash = store.into_flash().power_on();
    let writes = [(); 2].map(|()| {
        let steps = flash.steps;
        let store: Store<_, 8> = start(flash.clone());
        flash = store.into_flash();
        flash.steps > steps
    });
    let mut store: Store<_, 8> = start(flash);
    let held = store.load(Key(1), &mut [0; 9]).unwrap().map(<[u8]>::to_vec);
    (held, store.opened() - before, writes)
}

/// docs/storage.md, "The start": what has its first mark counts, what has none does not; the first
/// start settles it for all later ones, and writes nothing where there is no doubt.
#[test]
fn a_start_settles_what_a_cut_has_left() {
    let (old, new) = (Some(vec![1; 9]), Some(vec![2; 9]));
    let replace = Op::Store(1, vec![2; 9]);
    assert_eq!(left_by(&replace, 0, Torn::New), (new.clone(), 0, [false, false]));
    assert_eq!(left_by(&replace, 0, Torn::Old), (new.clone(), 1, [true, false]));
    assert_eq!(left_by(&replace, 1, Torn::New), (new, 1, [true, false]));
    assert_eq!(left_by(&replace, 1, Torn::Old), (old.clone(), 1, [true, false]));
    for (op, after) in [(Op::Prepare, &old), (Op::Erase, &None)] {
        assert_eq!(left_by(&op, 0, Torn::New), (after.clone(), 1, [false, false]), "{op:?}");
        assert_eq!(left_by(&op, 0, Torn::Old), (after.clone(), 1, [true, false]), "{op:?}");
        assert_eq!(left_by(&op, 1, Torn::New), (after.clone(), 1, [true, false]), "{op:?}");
        assert_eq!(left_by(&op, 1, Torn::Old), (old.clone(), 0, [true, false]), "{op:?}");
    }
}

/// Nothing is read beyond the end of a page: a value may reach up to it.
#[test]
fn a_value_that_ends_with_its_page() {
    // 28 bytes of header and marks, 8 of the entry's header, 4 of its checksum, 8 of its marks.
    let mut store: Store<_, 2> = start(Flash::<4, 256>::new(3, 1));
    for version in 0..5 {
        let fresh = value(1, version, 256 - 28 - 8 - 4 - 8);
        store.store(Key(1), &fresh).unwrap();
        store = start(store.into_flash());
        assert_eq!(store.load(Key(1), &mut [0; VALUE_MAX]), Ok(Some(fresh.as_slice())));
    }
    let longer = value(1, 9, 256 - 28 - 8 - 4 - 8 + 1);
    assert_eq!(store.store(Key(1), &longer), Err(StorageError::Write));
}

/// Pages count only where they were written: one page beside it a store is a new one.
#[test]
fn another_place_is_a_new_store() {
    let mut store: Store<_, 8> = Store::mount(Flash::<4, 512>::new(5, 1), 1024, 3);
    for version in 0..60 {
        store.store(Key(1), &value(1, version, 40)).unwrap();
    }
    for start in [512, 0] {
        let mut beside: Store<_, 8> = Store::mount(store.flash().clone(), start, 3);
        assert_eq!((beside.load(Key(1), &mut [0; 40]), beside.opened()), (Ok(None), 0));
        beside.store(Key(1), &[7]).unwrap();
        assert_eq!(beside.load(Key(1), &mut [0; 40]), Ok(Some(&[7][..])));
    }
}

/// A start finds what is in each page of the log, and knows what was never set.
#[test]
fn a_start_reads_every_page() {
    let mut store: Store<_, 10> = start(Flash::<4, 256>::new(5, 1));
    // Two in a page, so that four pages are full.
    for key in 1..=8 {
        store.store(Key(key), &value(key, 1, 60)).unwrap();
    }
    assert_eq!(store.opened(), 4);
    store = start(store.into_flash());
    let expected: Values = (1..=8).map(|key| (key, value(key, 1, 60))).collect();
    assert_eq!(read(&mut store), Ok(expected));
}

/// A flash that takes no value is not worn out by trying: once more in another page, and no more.
#[test]
fn a_failed_write_is_tried_once_more() {
    let mut flash = Flash::<4, 256>::new(5, 1);
    // Where the first value of a page is.
    flash.worn.extend((0..5).map(|page| page * 256 + 36..page * 256 + 40));
    let mut store: Store<_, 8> = start(flash);
    for opened in [2, 4] {
        assert_eq!(store.store(Key(1), &[1, 2, 3]), Err(StorageError::Write));
        assert_eq!(store.opened(), opened);
    }
}
