//! Random power cuts: a million in CI, any number with `LAFET_STORE_CUTS`.
//!
//! `LAFET_STORE_CUTS=100000000 cargo test --release -p lafet-device --test store random --
//! --nocapture` is the long run; `LAFET_STORE_SEED` is the first seed, and replays a failure.

use crate::check::{KEYS, Op, Values, perform, read, start, value};
use crate::flash::{Cut, Flash, Torn};
use lafet_device::store::Store;

/// Starts in a row that are cut off too, at most.
const DEPTH: u64 = 3;
/// Power cuts in the life of one flash.
const CUTS_OF_A_LIFE: u64 = 500;

#[derive(Default, Debug)]
struct Count {
    cuts: u64,
    cuts_in_recovery: u64,
    taken_over: u64,
    stored: u64,
    refused: u64,
}

impl Count {
    fn add(&mut self, other: &Self) {
        self.cuts += other.cuts;
        self.cuts_in_recovery += other.cuts_in_recovery;
        self.taken_over += other.taken_over;
        self.stored += other.stored;
        self.refused += other.refused;
    }
}

/// One life of a flash: operations with a power cut in about every second one.
fn life<const W: usize, const P: usize>(pages: usize, seed: u64) -> Count {
    let mut flash = Flash::<W, P>::new(pages, seed);
    flash.checked = seed.is_multiple_of(2);
    let mut store: Store<_, 10> = start(flash);
    let (mut values, mut count) = (Values::new(), Count::default());
    while count.cuts < CUTS_OF_A_LIFE {
        let op = operation::<W, P>(store.flash());
        if store.flash().random().is_multiple_of(2) {
            cut(store.flash(), 40);
        }
        let (result, after) = perform(&mut store, &op, &values);
        let what = format!("{W}/{P}/{pages}, seed {seed}, cut {}: {op:?}", count.cuts);
        if store.flash().is_off() {
            assert!(result.is_err() || matches!(op, Op::Restart), "{what}: acknowledged");
            count.cuts += 1;
            restart(&mut store, &mut count);
            let held = read(&mut store);
            let is_new = held.as_ref() == Ok(&after);
            assert!(
                is_new || held.as_ref() == Ok(&values),
                "{what}: {held:?}\n  not {values:?}\n  nor {after:?}"
            );
            count.taken_over += u64::from(is_new && after != values);
            values = if is_new { after } else { values };
        } else if result.is_ok() {
            count.stored += 1;
            values = after;
        } else {
            assert!(matches!(op, Op::Store(..)), "{what}: {result:?}");
            count.refused += 1;
        }
        // The flash is as it was left, but the cut that did not come is taken back.
        store.flash().clear_cut();
        assert_eq!(read(&mut store).as_ref(), Ok(&values), "{what}: afterwards");
    }
    count
}

fn operation<const W: usize, const P: usize>(random: &Flash<W, P>) -> Op {
    let key = 1 + (random.random() % u64::from(KEYS)) as u16;
    let len = (random.random() % (P as u64 / 8)) as usize;
    match random.random() % 24 {
        0 => Op::Erase,
        1 => Op::Prepare,
        2..4 => Op::Restart,
        _ => Op::Store(key, value(key, random.random() as u16, len)),
    }
}

fn cut<const W: usize, const P: usize>(flash: &Flash<W, P>, steps: u64) {
    let torn = Torn::ALL[(flash.random() % 6) as usize];
    flash.cut(Cut { step: flash.random() % steps, torn });
}

/// Starts until one is not cut off.
fn restart<const W: usize, const P: usize>(store: &mut Store<Flash<W, P>, 10>, count: &mut Count) {
    for _ in 0..DEPTH {
        let flash = store.flash().clone().power_on();
        if flash.random().is_multiple_of(2) {
            cut(&flash, 24);
        }
        *store = start(flash);
        if !store.flash().is_off() {
            return;
        }
        count.cuts += 1;
        count.cuts_in_recovery += 1;
    }
    *store = start(store.flash().clone().power_on());
}

#[test]
fn random_cuts() {
    let number = |name, default: u64| {
        std::env::var(name).map_or(default, |text| text.parse().expect("a whole number"))
    };
    let wanted = number("LAFET_STORE_CUTS", 1_000_000);
    let first = number("LAFET_STORE_SEED", 1);
    let threads = std::thread::available_parallelism().map_or(1, usize::from) as u64;
    let run = |thread: u64| {
        let mut count = Count::default();
        let mut seed = first + thread;
        while count.cuts < wanted.div_ceil(threads) {
            count.add(&match seed % 6 {
                0 => life::<1, 256>(2, seed),
                1 => life::<2, 256>(3, seed),
                2 => life::<2, 512>(2, seed),
                3 => life::<4, 256>(4, seed),
                4 => life::<4, 384>(5, seed),
                _ => life::<8, 384>(3, seed),
            });
            seed += threads;
        }
        count
    };
    let mut count = Count::default();
    std::thread::scope(|scope| {
        let runs: Vec<_> = (0..threads).map(|thread| scope.spawn(move || run(thread))).collect();
        for thread in runs {
            count.add(&thread.join().unwrap());
        }
    });
    println!("{count:?}");
    assert!(count.cuts >= wanted, "{count:?}");
    // Cuts fell where something was taken over, in starts, and the memory was full at times.
    assert!(count.taken_over > wanted / 1000 && count.cuts_in_recovery > wanted / 100, "{count:?}");
    assert!(count.stored > wanted / 10 && count.refused > 0, "{count:?}");
}
