//! Operations, and what the store has to hold after them.

use crate::flash::Flash;
use lafet_device::hal::{Key, Storage, StorageError, VALUE_MAX};
use lafet_device::store::Store;
use std::collections::BTreeMap;

/// Keys 1 to this one are looked at.
pub const KEYS: u16 = 9;

pub type Values = BTreeMap<u16, Vec<u8>>;

#[derive(Clone, Debug)]
pub enum Op {
    Store(u16, Vec<u8>),
    Erase,
    Prepare,
    Restart,
}

/// A value that no other one is a part of.
pub fn value(key: u16, version: u16, len: usize) -> Vec<u8> {
    let [v0, v1] = version.to_le_bytes();
    (0..len).map(|index| [v0, v1, key as u8, index as u8][index % 4]).collect()
}

/// Performs an operation; what the store holds when it was done.
pub fn perform<const W: usize, const P: usize, const N: usize>(
    store: &mut Store<Flash<W, P>, N>,
    op: &Op,
    values: &Values,
) -> (Result<(), StorageError>, Values) {
    let mut after = values.clone();
    let result = match op {
        Op::Store(key, value) => {
            after.insert(*key, value.clone());
            store.store(Key(*key), value)
        }
        Op::Erase => {
            after.clear();
            store.erase()
        }
        Op::Prepare => store.prepare().map(|_| ()),
        Op::Restart => {
            *store = start(store.flash().clone());
            Ok(())
        }
    };
    (result, after)
}

pub fn start<const W: usize, const P: usize, const N: usize>(
    flash: Flash<W, P>,
) -> Store<Flash<W, P>, N> {
    let pages = flash.pages();
    Store::mount(flash, 0, pages)
}

/// All that the store holds.
pub fn read<const W: usize, const P: usize, const N: usize>(
    store: &mut Store<Flash<W, P>, N>,
) -> Result<Values, (u16, StorageError)> {
    let mut values = Values::new();
    for key in 1..=KEYS {
        let mut buffer = [0; VALUE_MAX];
        match store.load(Key(key), &mut buffer) {
            Ok(Some(value)) => _ = values.insert(key, value.to_vec()),
            Ok(None) => {}
            Err(error) => return Err((key, error)),
        }
    }
    Ok(values)
}

/// After a power cut: the store holds either of two sets of values, holds the same at each later
/// start, and goes on as if nothing had been. The set it holds; or what is wrong.
pub fn recovered<const W: usize, const P: usize, const N: usize>(
    store: &mut Store<Flash<W, P>, N>,
    either: [&Values; 2],
    more: u16,
) -> Result<(), String> {
    let held = read(store).map_err(|error| format!("cannot be read: {error:?}"))?;
    if !either.contains(&&held) {
        return Err(format!("holds {held:?}\n  not {:?}\n  nor {:?}", either[0], either[1]));
    }
    let mut expected = held;
    for round in 0..=more {
        *store = start(store.flash().clone().power_on());
        if store.flash().is_off() {
            return Err("still off".into());
        }
        let now = read(store).map_err(|error| format!("later {round}: {error:?}"))?;
        if now != expected {
            return Err(format!("later {round}: holds {now:?}\n  not {expected:?}"));
        }
        // Each first write after a start opens a page, so this goes round the ring.
        if round < more {
            let fresh = value(KEYS, 0x7700 + round, 3);
            let Ok(()) = store.store(Key(KEYS), &fresh) else {
                return Err(format!("later {round}: cannot be written"));
            };
            expected.insert(KEYS, fresh);
        }
    }
    Ok(())
}
