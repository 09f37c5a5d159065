//! Power cuts: in every word and every erase of an update, in the recovery, and at random.

use crate::bench::{
    Chip, Image, RECORD_PAGES, SLOT_PAGES, WORD, factory, image, memory, start, update,
};
use crate::flash::{Cut, Torn};
use lafet_update::{Slot, Version};

/// An update of a board whose power is cut.
struct Life<const W: usize> {
    flash: Chip<W, 256>,
    /// Slot A and what is behind the record: never to be written.
    kept: Vec<u8>,
    old: Version,
    new: Image,
    committed: bool,
    asked_to_confirm: bool,
    confirmed: bool,
    cuts_done: usize,
}

/// What may not change: the running slot, and what is not a part of the partition.
fn kept<const W: usize>(flash: &Chip<W, 256>) -> Vec<u8> {
    let (slot, record) = (usize::from(SLOT_PAGES) * 256, usize::from(RECORD_PAGES) * 256);
    [&flash.bytes()[..slot], &flash.bytes()[2 * slot + record..]].concat()
}

impl<const W: usize> Life<W> {
    fn new(flash: Chip<W, 256>, old: &Image, new: Image) -> Self {
        let (kept, old) = (kept(&flash), old.header().version);
        let (committed, asked_to_confirm, confirmed) = (false, false, false);
        Self { flash, kept, old, new, committed, asked_to_confirm, confirmed, cuts_done: 0 }
    }

    /// One start and what follows it, until power is cut or the board restarts itself; whether the
    /// update is done.
    fn run(&mut self, cut: Option<Cut>) -> bool {
        let new = self.new.header().version;
        let flash = self.flash.clone().power_on();
        if let Some(cut) = cut {
            flash.cut(cut);
        }
        let mut app = match start(flash) {
            Ok(app) => app,
            Err(flash) => {
                assert!(flash.is_off(), "nothing is started");
                self.end(*flash);
                return false;
            }
        };
        if app.memory().flash().is_off() {
            self.end(app.into_memory().into_flash());
            return false;
        }
        let report = app.report();
        let version = report.started.version;
        assert!(version == self.old || version == new);
        assert!(version == self.old || self.committed, "never one that was not committed");
        assert!(version == new || !self.confirmed, "never back once it was confirmed");
        assert_eq!(report.started.slot == Slot::A, version == self.old);
        let (result, done) = if version == self.old {
            assert!(!report.started.trial);
            // The record may be written though the answer is lost.
            self.committed = true;
            (update(&mut app, &self.new), false)
        } else if report.started.trial {
            self.asked_to_confirm = true;
            let result = app.confirm(WORD);
            self.confirmed |= result.is_ok();
            (result, result.is_ok())
        } else {
            assert!(self.asked_to_confirm, "only an image that was confirmed is not on trial");
            self.confirmed = true;
            (Ok(()), true)
        };
        let flash = app.into_memory().into_flash();
        assert!(result.is_ok() || flash.is_off(), "{result:?} without a cut");
        self.end(flash);
        done
    }

    fn end(&mut self, flash: Chip<W, 256>) {
        self.cuts_done += usize::from(flash.is_off());
        assert!(kept(&flash) == self.kept, "the running slot is never written");
        self.flash = flash;
    }

    /// Lives through these cuts, one a start, and comes to its end without more; whether all of
    /// them happened.
    fn through(&mut self, cuts: &[Option<Cut>]) -> bool {
        let wanted = cuts.iter().flatten().count();
        let mut cuts = cuts.iter();
        for _ in 0..2 * wanted + 4 {
            if self.run(cuts.next().copied().flatten()) {
                let mut flash = self.flash.clone().power_on();
                for _ in 0..2 {
                    let Ok(app) = start(flash) else { panic!("a bootable image") };
                    let started = app.report().started;
                    assert!(started.version == self.new.header().version && !started.trial);
                    flash = app.into_memory().into_flash();
                }
                let mut memory = memory(flash);
                let old = memory.verify(Slot::A, &crate::bench::board(), 0, &mut || {});
                assert!(old.is_ok(), "the old image is kept");
                return self.cuts_done >= wanted;
            }
        }
        panic!("the update does not come to an end");
    }
}

fn life<const W: usize>(seed: u64) -> Life<W> {
    let old = image(1, 8);
    Life::new(factory(&old, seed), &old, image(2, 264))
}

/// Cuts as (start, step) for as long as they happen.
fn each_cut<const W: usize>(mut found: impl FnMut(&[Option<Cut>], &Life<W>)) {
    for run in 0..2 {
        for torn in Torn::ALL {
            for step in 0.. {
                let mut cuts = vec![None; run];
                cuts.push(Some(Cut { step, torn }));
                let mut life = life::<W>(step);
                if !life.through(&cuts) {
                    assert!(step > 8, "the cuts happen");
                    break;
                }
                found(&cuts, &life);
            }
        }
    }
}

/// Power is cut once, in each word and each erase, torn in each way.
#[test]
fn one_cut_anywhere() {
    let mut count = 0;
    each_cut::<8>(|_, _| count += 1);
    assert!(count > 600, "{count}");
    let mut fine = 0;
    each_cut::<2>(|_, _| fine += 1);
    assert!(fine > count);
}

/// Power is cut, and cut once more in each word and each erase of the recovery; `stride` leaves
/// out some of the first cuts.
fn two_cuts(stride: u64) -> usize {
    let mut count = 0;
    for run in 0..2 {
        for step in (0..).step_by(stride as usize) {
            let first = Cut { step, torn: Torn::ALL[step as usize % 6] };
            let mut cuts = vec![None; run];
            cuts.push(Some(first));
            let mut before = life::<8>(step);
            if !before.through(&cuts) {
                break;
            }
            for again in 0.. {
                let torn = Torn::ALL[(step + again) as usize % 6];
                cuts.truncate(run + 1);
                cuts.push(Some(Cut { step: again, torn }));
                if !life::<8>(step).through(&cuts) {
                    break;
                }
                count += 1;
            }
        }
    }
    count
}

#[test]
fn a_cut_in_the_recovery() {
    let count = two_cuts(13);
    assert!(count > 1000, "{count}");
}

/// The long form: each pair of cuts.
#[test]
#[ignore = "minutes: `cargo test -p lafet-update -- --ignored`"]
fn each_pair_of_cuts() {
    let count = two_cuts(1);
    assert!(count > 10_000, "{count}");
}

/// At least so many cuts, up to six in an update, anywhere, in a flash that checks its words or
/// does not; returns how many updates that took.
fn random_cuts(wanted: usize) -> u64 {
    let mut cuts_done = 0;
    for seed in 0.. {
        if cuts_done >= wanted {
            return seed;
        }
        let dice: Chip<8, 256> = Chip::new(1, seed);
        let mut cuts = Vec::new();
        for _ in 0..1 + dice.random() % 6 {
            let torn = Torn::ALL[dice.random() as usize % 6];
            cuts.push(Some(Cut { step: dice.random() % 150, torn }));
        }
        let old = image(1, 8);
        let mut flash = factory::<8, 256>(&old, dice.random());
        flash.checked = dice.random().is_multiple_of(2);
        flash.strict = dice.random().is_multiple_of(4);
        let len = 8 + 8 * (dice.random() as usize % 60);
        let mut life = Life::new(flash, &old, image(2, len));
        life.through(&cuts);
        cuts_done += life.cuts_done;
    }
    0
}

/// The quick form.
#[test]
fn ten_thousand_random_cuts() {
    let updates = random_cuts(10_000);
    assert!(updates > 1000, "an update has six cuts at most: {updates}");
}

/// The long form.
#[test]
#[ignore = "half an hour: `cargo test -p lafet-update -- --ignored`"]
fn a_million_random_cuts() {
    let updates = random_cuts(1_000_000);
    assert!(updates > 100_000, "an update has six cuts at most: {updates}");
}
