//! A power cut in every word and every erase of every operation, and in every one of the start
//! that follows, each with everything that may be left of what was being changed.

use crate::check::{Op, Values, perform, recovered, start, value};
use crate::flash::{Cut, Flash, Torn};
use lafet_device::store::Store;

/// Values appear, are replaced, grow, stay; pages fill and are recycled; a start in between;
/// all is erased.
pub fn operations(scale: usize) -> Vec<Op> {
    let mut ops = vec![Op::Store(1, value(1, 0, 5 * scale)), Op::Store(2, value(2, 0, 0))];
    for version in 1..4 {
        ops.push(Op::Store(3, value(3, version, scale * usize::from(version))));
        ops.push(Op::Store(4, value(4, version, 3 * scale - 1)));
    }
    ops.extend([
        Op::Restart,
        Op::Store(1, value(1, 1, 4 * scale)),
        Op::Prepare,
        Op::Store(5, value(5, 1, 2 * scale + 1)),
        Op::Store(3, value(3, 9, 1)),
        Op::Erase,
        Op::Store(2, value(2, 1, scale)),
        Op::Restart,
        Op::Erase,
    ]);
    ops
}

#[derive(Default, Debug)]
struct Count {
    cuts: u64,
    cuts_in_recovery: u64,
    new: u64,
}

fn sweep<const W: usize, const P: usize>(pages: usize, scale: usize, checked: bool) -> Count {
    let mut flash = Flash::<W, P>::new(pages, 1);
    flash.checked = checked;
    let mut store: Store<_, 8> = start(flash);
    let mut values = Values::new();
    let mut count = Count::default();
    for (number, op) in operations(scale).iter().enumerate() {
        let mut whole = store.clone();
        let (result, after) = perform(&mut whole, op, &values);
        assert_eq!(result, Ok(()), "{op:?}");
        for step in 0..whole.flash().steps - store.flash().steps {
            for torn in Torn::ALL {
                let cut = Cut { step, torn };
                let mut store = store.clone();
                store.flash().cut(cut);
                let (result, _) = perform(&mut store, op, &values);
                assert!(result.is_err(), "operation {number}, {cut:?}: acknowledged");
                let what = format!("{W}/{P}/{pages}: operation {number}, {cut:?}");
                recovery(store.into_flash().power_on(), [&values, &after], &what, &mut count);
            }
        }
        (store, values) = (whole, after);
    }
    count
}

fn recovery<const W: usize, const P: usize>(
    flash: Flash<W, P>,
    either: [&Values; 2],
    what: &str,
    count: &mut Count,
) {
    let pages = flash.pages();
    let mut store: Store<_, 8> = start(flash.clone());
    let steps = store.flash().steps - flash.steps;
    count.cuts += 1;
    count.new += u64::from(crate::check::read(&mut store).as_ref() == Ok(either[1]));
    recovered(&mut store, either, pages + 1).unwrap_or_else(|wrong| panic!("{what}: {wrong}"));
    for step in 0..steps {
        for torn in Torn::ALL {
            let cut = Cut { step, torn };
            let flash = flash.clone();
            flash.cut(cut);
            let store: Store<_, 8> = start(flash);
            let mut store: Store<_, 8> = start(store.into_flash().power_on());
            count.cuts_in_recovery += 1;
            recovered(&mut store, either, 2)
                .unwrap_or_else(|wrong| panic!("{what}, then {cut:?}: {wrong}"));
        }
    }
}

fn assert_swept(count: &Count) {
    println!("{count:?}");
    assert!(count.cuts > 800 && count.cuts_in_recovery > 1000, "{count:?}");
    // A store that never takes anything over would be power-safe too.
    assert!(count.new > 20 && count.new < count.cuts, "{count:?}");
}

#[test]
fn words_of_1_byte() {
    assert_swept(&sweep::<1, 160>(2, 2, false));
}

#[test]
fn words_of_2_bytes() {
    assert_swept(&sweep::<2, 192>(2, 4, false));
    assert_swept(&sweep::<2, 160>(3, 4, false));
}

#[test]
fn words_of_4_bytes() {
    assert_swept(&sweep::<4, 256>(2, 6, false));
    assert_swept(&sweep::<4, 160>(4, 4, false));
}

#[test]
fn words_of_8_bytes() {
    assert_swept(&sweep::<8, 384>(2, 6, false));
    assert_swept(&sweep::<8, 256>(3, 6, true));
}

#[test]
fn pages_of_1_kib() {
    assert_swept(&sweep::<8, 1024>(2, 24, true));
}
