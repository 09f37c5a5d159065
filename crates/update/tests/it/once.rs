//! What goes wrong once while power stays: a read, a write, an erase, a bit of the record. A signed
//! image is started all the same, none that was not committed, and the update comes to its end.

use crate::bench::{
    Chip, Image, KEYS, RECORD_PAGES, SLOT_PAGES, WORD, factory, fields, image, payload, receive,
    signed, start, update,
};
use crate::flash::{Blip, Cut, Torn};
use lafet_update::{Hash, Header, Receiver, Recorded, Refusal, Slot, Version};
use std::sync::LazyLock;

type Site = Chip<8, 256>;
type App = Receiver<'static, Site>;

const LEN: usize = 264;
const RECORD: usize = 2 * SLOT_PAGES as usize * 256;

/// Version 2 is running in slot B, confirmed; it has revoked key 2. Version 1 is kept in slot A.
fn updated() -> Site {
    let mut app = start(factory(&image(1, 8), 1)).ok().unwrap();
    let second = signed(&KEYS[0], &Header { revokes: 0b100, ..fields(2) }, payload(2, LEN));
    update(&mut app, &second).unwrap();
    app = restart(app);
    app.confirm(WORD).unwrap();
    app.into_memory().into_flash()
}

static THIRD: LazyLock<Image> = LazyLock::new(|| image(3, LEN));

fn restart(app: App) -> App {
    start(app.into_memory().into_flash()).ok().unwrap()
}

fn running(app: &App) -> (Slot, bool) {
    let started = app.report().started;
    (started.slot, started.trial)
}

/// The next update, as a sender goes on with it that is refused now and then; whether it was.
fn update_all_the_same(flash: Site, what: &str) -> (Site, bool) {
    let slot = SLOT_PAGES as usize * 256;
    let kept = flash.bytes()[slot..2 * slot].to_vec();
    let (mut flash, mut refused, mut committed) = (flash, false, false);
    let (mut asked, mut confirmed) = (false, false);
    for _ in 0..6 {
        let mut app = start(flash).unwrap_or_else(|_| panic!("{what}: nothing is started"));
        assert!(app.memory().flash().bytes()[slot..2 * slot] == kept, "{what}: it is running");
        match running(&app) {
            (Slot::B, trial) => {
                assert!(!trial && !confirmed, "{what}: back, trial {trial}");
                committed = (0..3).any(|_| {
                    let done = update(&mut app, &THIRD).is_ok();
                    refused |= !done;
                    done
                });
                assert!(committed, "{what}: it is not taken");
            }
            (Slot::A, true) => {
                assert!(committed, "{what}: it was not committed");
                asked = true;
                confirmed = (0..3).any(|_| {
                    let done = app.confirm(WORD).is_ok();
                    refused |= !done;
                    done
                });
                assert!(confirmed, "{what}: it cannot be confirmed");
            }
            (Slot::A, false) => {
                assert!(asked, "{what}: it was not confirmed");
                let revoked = signed(&KEYS[2], &fields(4), payload(4, 8)).raw;
                let begun = app.begin(&revoked, Hash::of(WORD), false);
                assert_eq!(begun, Err(Refusal::RevokedKey), "{what}");
                assert_eq!(app.report().started.version, Version([3, 0, 0, 0]), "{what}");
                return (app.into_memory().into_flash(), refused);
            }
        }
        flash = app.into_memory().into_flash();
    }
    panic!("{what}: the update does not come to an end");
}

/// And it stays so.
fn settled(mut flash: Site, what: &str) {
    for _ in 0..2 {
        let app = start(flash).unwrap_or_else(|_| panic!("{what}: nothing is started later"));
        assert_eq!(running(&app), (Slot::A, false), "{what}: later");
        flash = app.into_memory().into_flash();
    }
}

/// Each read of an update fails, or has a bit that is read wrongly.
#[test]
fn each_read() {
    let updated = updated();
    for blip in Blip::ALL {
        let mut refusals = 0;
        for at in 1.. {
            let mut flash = updated.clone();
            let at = flash.reads + at;
            let what = format!("{blip:?} in read {at}");
            flash.blip = Some((at..at + 1, blip));
            let (mut flash, refused) = update_all_the_same(flash, &what);
            refusals += u32::from(refused);
            let happened = flash.reads >= at;
            flash.blip = None;
            settled(flash, &what);
            if !happened {
                break;
            }
        }
        // What fails is read again; what is read wrongly is noticed by its hash or signature.
        assert_eq!(refusals > 0, blip == Blip::Misread, "{blip:?}: {refusals}");
    }
}

/// Each word of an update that is written, and each erase, fails, and leaves what a cut would.
#[test]
fn each_step() {
    let updated = updated();
    let mut refusals = 0;
    for torn in Torn::ALL {
        for step in 0.. {
            let what = format!("{torn:?} in step {step}");
            let flash = updated.clone();
            flash.fail(Cut { step, torn });
            let (flash, refused) = update_all_the_same(flash, &what);
            refusals += u32::from(refused);
            let happened = !flash.is_to_fail();
            flash.clear_cut();
            settled(flash, &what);
            if !happened {
                assert!(step > 100, "{step}");
                break;
            }
        }
    }
    assert!(refusals > 100, "{refusals}");
}

/// An update up to each of its stages, and what the next start starts.
fn stages() -> Vec<(&'static str, Site, (Slot, bool))> {
    let mut stages = vec![("before", updated(), (Slot::B, false))];
    let mut app = start(updated()).ok().unwrap();
    app.begin(&THIRD.raw, Hash::of(WORD), false).unwrap();
    stages.push(("begun", app.memory().flash().clone(), (Slot::B, false)));
    receive(&mut app, &THIRD, 24).unwrap();
    stages.push(("verified", app.memory().flash().clone(), (Slot::B, false)));
    app.commit(Hash::of(WORD)).unwrap();
    stages.push(("committed", app.memory().flash().clone(), (Slot::A, true)));
    app = restart(app);
    stages.push(("tried", app.memory().flash().clone(), (Slot::B, false)));
    let back = restart(start(app.memory().flash().clone()).ok().unwrap());
    stages.push(("failed", back.into_memory().into_flash(), (Slot::B, false)));
    app.confirm(WORD).unwrap();
    stages.push(("confirmed", app.memory().flash().clone(), (Slot::A, false)));
    stages
}

/// A bit of each word of the record flips: the next start starts what it would have, and the keys
/// that have been revoked are.
#[test]
fn each_word_of_the_record() {
    let revoked = signed(&KEYS[2], &fields(9), payload(9, 8)).raw;
    for (stage, flash, wanted) in stages() {
        for word in 0..usize::from(RECORD_PAGES) * 256 / 8 {
            let mut flash = flash.clone();
            flash.flip((RECORD + word * 8) * 8 + word * 11 % 64);
            let mut app = start(flash).ok().unwrap();
            assert_eq!(running(&app), wanted, "{stage}, word {word}");
            let begun = app.begin(&revoked, Hash::of(WORD), false);
            assert_eq!(begun, Err(Refusal::RevokedKey), "{stage}, word {word}");
        }
    }
}

/// Flips many bits in some pages of the record.
fn destroy(flash: &mut Site, pages: core::ops::Range<usize>) {
    for bit in ((RECORD + pages.start * 256) * 8..(RECORD + pages.end * 256) * 8).step_by(7) {
        flash.flip(bit);
    }
}

/// Either copy of the record is enough, and the other one is made again from it.
#[test]
fn each_copy_of_the_record() {
    for (stage, flash, wanted) in stages() {
        for (lost, then) in [(0..2, 2..4), (2..4, 0..2)] {
            let mut flash = flash.clone();
            destroy(&mut flash, lost);
            let app = start(flash).ok().unwrap();
            assert_eq!(running(&app), wanted, "{stage}");
            let mut flash = app.into_memory().into_flash();
            destroy(&mut flash, then);
            let mut app = start(flash).ok().unwrap();
            // A trial is followed by the way back.
            let next = if wanted.1 { (Slot::B, false) } else { wanted };
            assert_eq!(running(&app), next, "{stage}");
            let record = app.memory_mut().record();
            assert!(
                matches!(record, Recorded::Known(record) if record.revoked == 0b100),
                "{stage}"
            );
        }
    }
}

/// With both of them lost, what was confirmed last is started: never what was not committed, or has
/// failed.
#[test]
fn no_copy_of_the_record() {
    for (stage, mut flash, _) in stages() {
        destroy(&mut flash, 0..4);
        let app = start(flash).ok().unwrap();
        let confirmed = if stage == "confirmed" { Slot::A } else { Slot::B };
        assert_eq!(running(&app), (confirmed, false), "{stage}");
    }
}
