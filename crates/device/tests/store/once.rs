//! What fails once while power stays: a read, a bit that is read wrongly, a write, an erase. It
//! costs nothing that was stored, then or later.

use crate::check::{KEYS, Op, Values, perform, read, recovered, start, value};
use crate::cuts::operations;
use crate::flash::{Blip, Cut, Flash, Torn};
use crate::rot::image;
use lafet_device::hal::{Key, Storage};
use lafet_device::store::Store;

/// A start, all values, one that is stored, with something wrong in a read of these; how many reads
/// that is.
fn sweep_reads<const W: usize, const P: usize>(pages: usize, blip: Blip) -> u64 {
    let (flash, values) = image::<W, P>(pages);
    let mut after = values.clone();
    after.insert(1, value(1, 999, 9));
    let before = flash.reads;
    for at in before + 1.. {
        let what = format!("{W}/{P}/{pages}: {blip:?} in read {at}");
        let mut flash = flash.clone();
        flash.blip = Some((at..at + 1, blip));
        let mut store: Store<_, 10> = start(flash);
        assert_eq!(read(&mut store).as_ref(), Ok(&values), "{what}");
        let stored = store.store(Key(1), &after[&1]);
        assert!(read(&mut store).is_ok_and(|held| held == values || held == after), "{what}");
        let happened = store.flash().reads >= at;
        let mut flash = store.into_flash();
        flash.blip = None;
        let mut store: Store<_, 10> = start(flash);
        let either = if stored.is_ok() { [&after, &after] } else { [&values, &after] };
        recovered(&mut store, either, pages as u16 + 1)
            .unwrap_or_else(|wrong| panic!("{what}: {wrong}"));
        if !happened {
            return at - before;
        }
    }
    0
}

#[test]
fn each_read() {
    for blip in Blip::ALL {
        let reads = [
            sweep_reads::<1, 256>(3, blip),
            sweep_reads::<2, 256>(4, blip),
            sweep_reads::<8, 512>(2, blip),
            sweep_reads::<8, 384>(3, blip),
        ];
        assert!(reads.iter().all(|reads| *reads > 50), "{reads:?}");
    }
}

/// The header of the newest page cannot be read when pages are looked for, and can a moment later:
/// the page before it is not taken for the newest one, which would be erased then.
#[test]
fn the_newest_page_is_unreadable_for_a_moment() {
    let mut store: Store<_, 10> = start(Flash::<4, 256>::new(3, 1));
    let mut version = 0;
    // Its header is what a start reads first.
    while store.opened() < 6 {
        version += 1;
        store.store(Key(1), &value(1, version, 60)).unwrap();
    }
    store.store(Key(2), &[2]).unwrap();
    assert_eq!(store.opened(), 6);
    let values = Values::from([(1, value(1, version, 60)), (2, vec![2])]);
    let mut flash = store.into_flash();
    flash.blip = Some((flash.reads + 1..flash.reads + 4, Blip::Failed));
    let mut store: Store<_, 10> = start(flash);
    assert_eq!(read(&mut store).as_ref(), Ok(&values));
    recovered(&mut store, [&values, &values], 4).unwrap();
}

/// Each step of the operations fails, and leaves what a power cut would; the store goes on.
fn sweep_steps<const W: usize, const P: usize>(pages: usize, scale: usize) -> usize {
    let mut store: Store<_, 10> = start(Flash::<W, P>::new(pages, 1));
    let mut values = Values::new();
    let mut failed = 0;
    for (number, op) in operations(scale).iter().enumerate() {
        let mut whole = store.clone();
        let (result, after) = perform(&mut whole, op, &values);
        assert_eq!(result, Ok(()), "{op:?}");
        for step in 0..whole.flash().steps - store.flash().steps {
            for torn in Torn::ALL {
                let what = format!("{W}/{P}/{pages}: operation {number}, step {step}, {torn:?}");
                let mut store = store.clone();
                store.flash().fail(Cut { step, torn });
                let (result, _) = perform(&mut store, op, &values);
                assert!(!store.flash().is_to_fail(), "{what}");
                failed += usize::from(result.is_err());
                let held = read(&mut store).unwrap_or_else(|error| panic!("{what}: {error:?}"));
                let kept = if result.is_ok() { &after } else { &values };
                assert_eq!(&held, kept, "{what}");
                goes_on(store, [kept, &after], &what);
            }
        }
        (store, values) = (whole, after);
    }
    failed
}

/// The next value is stored in the same run; or there is none, and the next start finds either.
fn goes_on<const W: usize, const P: usize>(
    store: Store<Flash<W, P>, 10>,
    [kept, after]: [&Values; 2],
    what: &str,
) {
    let more = store.flash().pages() + 1;
    let mut later: Store<_, 10> = start(store.flash().clone());
    recovered(&mut later, [kept, after], more).unwrap_or_else(|wrong| panic!("{what}: {wrong}"));
    let mut store = store;
    let (result, next) = perform(&mut store, &Op::Store(KEYS, vec![7; 3]), kept);
    assert_eq!(result, Ok(()), "{what}: the next one");
    recovered(&mut store, [&next, &next], more).unwrap_or_else(|wrong| panic!("{what}: {wrong}"));
}

#[test]
fn each_step() {
    let failed =
        [sweep_steps::<1, 160>(2, 2), sweep_steps::<2, 160>(3, 4), sweep_steps::<8, 384>(2, 6)];
    assert!(failed.iter().all(|failed| *failed > 20), "{failed:?}");
}
