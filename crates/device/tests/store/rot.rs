//! Flipped bits: any single one in the whole flash costs at most the value it hit, and that is
//! reported; more of them cost more, and that is reported too.

use crate::check::{KEYS, Values, start, value};
use crate::flash::Flash;
use lafet_device::hal::{Key, Storage, StorageError, VALUE_MAX};
use lafet_device::store::Store;

/// A log over all pages but one, with values in each.
pub fn image<const W: usize, const P: usize>(pages: usize) -> (Flash<W, P>, Values) {
    let mut store: Store<_, 10> = start(Flash::<W, P>::new(pages, 3));
    let mut values = Values::new();
    let mut version = 0;
    while store.opened() < pages as u32 + 2 {
        // Some keys are replaced often, some stay where they are.
        let key = [1, 2, 1, 3, 1, 4, 2, 5, 1, 6][usize::from(version) % 10];
        let fresh = value(key, version, 7 + usize::from(key) * 3);
        if version < 10 || key < 3 {
            store.store(Key(key), &fresh).unwrap();
            values.insert(key, fresh);
        }
        version += 1;
    }
    (store.into_flash(), values)
}

/// The keys that cannot be read; all others hold what they have to.
fn damaged<const W: usize, const P: usize>(
    store: &mut Store<Flash<W, P>, 10>,
    values: &Values,
    what: &str,
) -> Vec<u16> {
    let mut damaged = Vec::new();
    for key in 1..=KEYS {
        let mut buffer = [0; VALUE_MAX];
        match store.load(Key(key), &mut buffer) {
            Ok(value) => assert_eq!(value, values.get(&key).map(Vec::as_slice), "{what}: {key}"),
            Err(error) => {
                assert_eq!(error, StorageError::Read);
                damaged.push(key);
            }
        }
    }
    damaged
}

/// Flips each bit; how many of them cost a value.
fn sweep<const W: usize, const P: usize>(pages: usize) -> usize {
    let (flash, values) = image::<W, P>(pages);
    let mut costly = 0;
    for bit in 0..flash.bytes().len() * 8 {
        let mut rotten = flash.clone();
        rotten.flip(bit);
        let mut store: Store<_, 10> = start(rotten);
        let what = format!("{W}/{P}/{pages}, bit {bit}");
        let lost = damaged(&mut store, &values, &what);
        assert!(lost.len() <= 1, "{what}: {lost:?}");
        costly += lost.len();
        // The damage is still reported, and of the same value, when the ring has gone round.
        let mut values = values.clone();
        for round in 0..pages as u16 + 1 {
            let fresh = value(KEYS, round, 4);
            store.store(Key(KEYS), &fresh).unwrap();
            values.insert(KEYS, fresh);
            store = start(store.into_flash());
            assert_eq!(damaged(&mut store, &values, &what), lost, "{what}, later");
        }
        if let [key] = lost[..] {
            let fresh = value(key, 999, 5);
            store.store(Key(key), &fresh).unwrap();
            values.insert(key, fresh);
            assert_eq!(damaged(&mut store, &values, &what), [], "{what}, replaced");
        }
    }
    costly
}

#[test]
fn each_bit() {
    for costly in [
        sweep::<1, 256>(3),
        sweep::<2, 256>(4),
        sweep::<4, 320>(3),
        sweep::<8, 512>(2),
        sweep::<8, 384>(3),
    ] {
        // Values and their checksums alone: headers are repaired, marks are many bits.
        println!("{costly} bits cost a value");
        assert!(costly > 200, "{costly}");
    }
}

/// Where the header of an entry is, by its key and length.
fn header_of<const W: usize, const P: usize>(flash: &Flash<W, P>, key: u8, len: u8) -> usize {
    let at = flash.bytes().windows(4).rposition(|bytes| bytes == [key, 0, len, 0]);
    at.expect("the entry is in the flash")
}

#[test]
fn two_bits_of_a_header_are_reported() {
    let mut store: Store<_, 10> = start(Flash::<2, 256>::new(3, 3));
    for (key, len) in [(1, 10), (2, 11), (3, 12), (1, 13), (4, 14)] {
        store.store(Key(key), &value(key, 1, len)).unwrap();
    }
    let mut flash = store.into_flash();
    let at = header_of(&flash, 3, 12);
    flash.flip(at * 8);
    flash.flip(at * 8 + 9);
    let mut store: Store<_, 10> = start(flash);
    let mut buffer = [0; VALUE_MAX];
    // 3 is lost, and any of the others may have been replaced by what it was: also an unset one.
    for round in 0..5 {
        for key in [1, 2, 3, 4, 5] {
            let read = store.load(Key(key), &mut buffer);
            assert_eq!(read, Err(StorageError::Read), "key {key}, round {round}");
        }
        store.store(Key(6), &[round]).unwrap();
        store = start(store.into_flash());
    }
    store.store(Key(3), &[1, 2, 3]).unwrap();
    assert_eq!(store.load(Key(3), &mut buffer), Ok(Some(&[1, 2, 3][..])));
    assert_eq!(store.load(Key(6), &mut buffer), Ok(Some(&[4][..])));
    store.erase().unwrap();
    store = start(store.into_flash());
    assert_eq!(store.load(Key(1), &mut buffer), Ok(None));
    assert_eq!(store.load(Key(3), &mut buffer), Ok(None));
}

#[test]
fn a_lost_page_is_reported() {
    let (mut flash, values) = image::<4, 160>(4);
    let newest = (flash.pages() as usize + 2) % 4;
    let middle = (newest + 3) % 4;
    for bit in 0..128 {
        flash.flip((middle * 160) * 8 + bit);
    }
    let mut store: Store<_, 10> = start(flash);
    let lost = damaged(&mut store, &values, "a page");
    assert!(lost.contains(&KEYS), "an unset key may have been in that page: {lost:?}");
    assert!(lost.len() < usize::from(KEYS), "what was written later is there");
}

/// Copied from page to page, a damaged value stays what it is, and the store goes on.
#[test]
fn a_damaged_value_is_reported_wherever_it_is_copied() {
    let mut store: Store<_, 10> = start(Flash::<4, 256>::new(3, 3));
    store.store(Key(1), &value(1, 1, 20)).unwrap();
    let at = store.address_of(Key(1)).unwrap() as usize;
    store.flash_mut().flip(at * 8 + 3);
    for round in 0..40 {
        let fresh = value(2, round, 30);
        store.store(Key(2), &fresh).unwrap();
        let mut buffer = [0; VALUE_MAX];
        assert_eq!(store.load(Key(2), &mut buffer), Ok(Some(fresh.as_slice())));
        assert_eq!(store.load(Key(1), &mut buffer), Err(StorageError::Read), "round {round}");
    }
    assert!(store.opened() > 6);
}
