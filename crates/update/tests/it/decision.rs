//! The decision of the start, as a table, and through the flash.

use crate::bench::{
    Chip, KEYS, WORD, board, factory, fields, image, memory, put, signed, start, update,
};
use crate::flash::Blip;
use lafet_update::{
    Board, BoardName, Boot, Hash, Header, Memory, Other, Record, Recorded, Refusal, Slot, Verified,
    Version, boot, decide,
};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

fn record(other: Other) -> Record {
    Record {
        active: Slot::A,
        other,
        floor: Version([5, 0, 0, 0]),
        revoked: 0b100,
        layout: 3,
        allowed: false,
        word: Hash::of(WORD),
    }
}

/// What is started, whether on trial, and what the record says of the other slot afterwards.
fn decided(
    record: &Record,
    noted: bool,
    a: Option<u16>,
    b: Option<u16>,
) -> (Option<Slot>, bool, Other) {
    let decision = decide(&Recorded::Known(*record), noted, |slot, revoked| {
        assert_eq!(revoked, record.revoked);
        let version = match slot {
            Slot::A => a,
            Slot::B => b,
        };
        let header = version.map(fields).ok_or(Refusal::Hash)?;
        Ok(Verified { header, trusted: false })
    });
    let before = if noted { Other::Tried } else { record.other };
    let other = decision.record.map_or(before, |record| record.other);
    (decision.start.map(|(slot, _)| slot), decision.trial, other)
}

#[test]
fn table() {
    use Other::{Committed, Empty, Failed, Kept, Tried};
    use Slot::{A, B};
    let (old, new) = (Some(5), Some(6));
    let rows = [
        // The active image is started, whatever lies in the other slot.
        (Empty, old, new, (Some(A), false, Empty)),
        (Kept, old, new, (Some(A), false, Kept)),
        (Failed, old, new, (Some(A), false, Failed)),
        // A committed one is tried once.
        (Committed, old, new, (Some(B), true, Tried)),
        (Tried, old, new, (Some(A), false, Failed)),
        // Not when it does not verify, and not when it is not newer.
        (Committed, old, None, (Some(A), false, Failed)),
        (Committed, old, old, (Some(A), false, Failed)),
        (Committed, old, Some(4), (Some(A), false, Failed)),
        // The active one no longer verifies: what was confirmed, or what failed, once more on trial.
        (Kept, None, Some(4), (Some(B), false, Failed)),
        (Failed, None, new, (Some(B), true, Tried)),
        (Tried, None, new, (Some(B), true, Tried)),
        (Committed, None, new, (Some(B), true, Tried)),
        // Never one that was not committed.
        (Empty, None, new, (None, false, Empty)),
        (Kept, None, None, (None, false, Kept)),
    ];
    for (other, a, b, wanted) in rows {
        let noted = other == Committed;
        assert_eq!(decided(&record(other), noted, a, b), wanted, "{other:?} {a:?} {b:?}");
    }
    let allowed = Record { allowed: true, ..record(Committed) };
    assert_eq!(decided(&allowed, true, old, Some(4)), (Some(B), true, Tried));
    // The kept one reads layouts 1 to 3: what is stored in another one keeps it locked out.
    let newer = Record { layout: 4, ..record(Kept) };
    assert_eq!(decided(&newer, false, None, Some(4)), (Some(B), true, Tried));
    // A trial that could not be noted begins only where there is nothing else.
    let committed = record(Committed);
    assert_eq!(decided(&committed, false, old, new), (Some(A), false, Committed));
    assert_eq!(decided(&committed, false, None, new), (Some(B), true, Committed));
    assert_eq!(decided(&committed, false, None, Some(4)), (None, false, Committed));
}

/// What was confirmed and is started in need is the active one from then on.
#[test]
fn the_kept_one_becomes_active() {
    let decision = decide(&Recorded::Known(record(Other::Kept)), false, |slot, _| match slot {
        Slot::A => Err(Refusal::Hash),
        Slot::B => Ok(Verified { header: fields(4), trusted: true }),
    });
    assert_eq!(decision.record.map(|record| record.active), Some(Slot::B));
}

/// Without a record the newest of those that are trusted is started, the first of two that are
/// alike; one that is not trusted only where there is no other, and on trial.
#[test]
fn without_a_record() {
    let (yes, no) = (true, false);
    let cases = [
        (Some((1, yes)), Some((2, yes)), Slot::B, false),
        (Some((2, yes)), Some((2, yes)), Slot::A, false),
        (None, Some((1, yes)), Slot::B, false),
        (Some((1, yes)), Some((2, no)), Slot::A, false),
        (Some((3, no)), Some((2, yes)), Slot::B, false),
        (Some((3, no)), Some((2, no)), Slot::A, true),
        (None, Some((2, no)), Slot::B, true),
    ];
    for recorded in [Recorded::Fresh, Recorded::Lost] {
        for (a, b, slot, trial) in cases {
            let decision = decide(&recorded, false, |slot, _| {
                let image = if slot == Slot::A { a } else { b };
                let (major, trusted) = image.ok_or(Refusal::Signature)?;
                Ok(Verified { header: fields(major), trusted })
            });
            assert_eq!(decision.start.map(|(slot, _)| slot), Some(slot), "{a:?} {b:?}");
            assert_eq!(decision.trial, trial, "{a:?} {b:?}");
            assert!(decision.record.is_none());
        }
    }
}

/// An update as it should go, and the one after it, back in the first slot.
#[test]
fn two_updates() {
    let flash: Chip<4, 256> = factory(&image(1, 512), 1);
    let mut app = start(flash).ok().unwrap();
    for (major, slot) in [(2, Slot::B), (3, Slot::A)] {
        update(&mut app, &image(major, 512)).unwrap();
        app = start(app.into_memory().into_flash()).ok().unwrap();
        let report = app.report();
        assert_eq!(report.started.slot, slot);
        assert!(report.started.trial && !report.failed);
        app.confirm(WORD).unwrap();
        assert!(!app.report().started.trial);
        app = start(app.into_memory().into_flash()).ok().unwrap();
        assert_eq!(app.report().started.version, Version([major, 0, 0, 0]));
        assert!(!app.report().started.trial);
    }
}

/// A new image that is not confirmed leads back to the old one, and may be committed once more
/// without being sent again.
#[test]
fn a_dead_link_leads_back() {
    let flash: Chip<4, 256> = factory(&image(1, 512), 2);
    let mut app = start(flash).ok().unwrap();
    let new = image(2, 512);
    update(&mut app, &new).unwrap();
    app = start(app.into_memory().into_flash()).ok().unwrap();
    assert!(app.report().started.trial);
    app = start(app.into_memory().into_flash()).ok().unwrap();
    let report = app.report();
    assert_eq!((report.started.slot, report.started.trial), (Slot::A, false));
    assert!(report.failed);
    assert_eq!(app.begin(&new.raw, Hash::of(WORD), false), Ok(512));
    update(&mut app, &new).unwrap();
    app = start(app.into_memory().into_flash()).ok().unwrap();
    assert_eq!(app.report().started.slot, Slot::B);
    assert_eq!(app.confirm(WORD), Ok(()));
}

/// Each check of the start is needed: an image that fails it alone is in the committed slot, and
/// is not started.
#[test]
fn what_the_bootloader_does_not_start() {
    let good = image(2, 512);
    let mut flipped = good.clone();
    flipped.payload[511] ^= 1;
    let mut forged = good.clone();
    forged.raw[159] ^= 1;
    let other_board = Header { board: BoardName::new("other").unwrap(), ..fields(2) };
    let elsewhere = Header { place: Some(Slot::B), ..fields(2) };
    let stranger = lafet_update::SigningKey::new(0, [77; 32]);
    let unknown = lafet_update::SigningKey::new(9, [77; 32]);
    let bytes = || good.payload.clone();
    let cases = [
        ("bit of the payload", flipped, Refusal::Hash),
        ("signature", forged, Refusal::Signature),
        ("board", signed(&KEYS[0], &other_board, bytes()), Refusal::Board),
        ("place", signed(&KEYS[0], &elsewhere, bytes()), Refusal::Place),
        ("stranger's key", signed(&stranger, &fields(2), bytes()), Refusal::Signature),
        ("unknown key", signed(&unknown, &fields(2), bytes()), Refusal::UnknownKey),
        ("revoked key", signed(&KEYS[2], &fields(2), bytes()), Refusal::RevokedKey),
    ];
    // The record of a board that has revoked key 2 and is about to try what is in slot B.
    let flash: Chip<4, 256> = factory(&image(1, 512), 3);
    let mut app = start(flash).ok().unwrap();
    let revoking = Header { revokes: 0b100, ..fields(1) };
    let newer = signed(&KEYS[0], &Header { version: Version([1, 5, 0, 0]), ..revoking }, bytes());
    update(&mut app, &newer).unwrap();
    app = start(app.into_memory().into_flash()).ok().unwrap();
    app.confirm(WORD).unwrap();
    app = start(app.into_memory().into_flash()).ok().unwrap();
    update(&mut app, &good).unwrap();
    let mut flash = app.into_memory().into_flash();
    let target = Slot::A;
    for (what, bad, reason) in cases {
        let mut flash = flash.clone();
        put(&mut flash, target, &bad);
        let verified = memory(flash.clone()).verify(target, &board(), 0b100, &mut || {});
        assert_eq!(verified, Err(reason), "{what}");
        let app = start(flash).ok().unwrap();
        let report = app.report();
        assert_eq!((report.started.slot, report.started.trial), (Slot::B, false), "{what}");
        assert!(report.failed, "{what}");
    }
    put(&mut flash, target, &good);
    assert!(start(flash).ok().unwrap().report().started.trial, "the good one is started");
}

/// A flash that cannot be written: the old image goes on, and no trial begins.
#[test]
fn a_worn_record() {
    let flash: Chip<4, 256> = factory(&image(1, 512), 4);
    let mut app = start(flash).ok().unwrap();
    update(&mut app, &image(2, 512)).unwrap();
    let mut flash = app.into_memory().into_flash();
    flash.worn.push(10 * 256..14 * 256);
    let report = start(flash.clone()).ok().unwrap().report();
    assert_eq!((report.started.slot, report.started.trial), (Slot::A, false));
    assert!(report.pending, "a later start may try it");
    // With the active image gone, the committed one is better than nothing.
    flash.flip(300 * 8);
    flash.worn.clear();
    put(&mut flash, Slot::A, &{
        let mut rotten = image(1, 512);
        rotten.payload[0] ^= 1;
        rotten
    });
    flash.worn.push(10 * 256..14 * 256);
    let mut app = start(flash).ok().unwrap();
    let report = app.report();
    assert_eq!((report.started.slot, report.started.trial), (Slot::B, true));
    app.memory_mut().flash_mut().worn.clear();
    assert_eq!(app.confirm(WORD), Ok(()));
}

/// Bits that rot in the active image: the one that was confirmed before is started.
#[test]
fn rot() {
    let flash: Chip<4, 256> = factory(&image(1, 512), 5);
    let mut app = start(flash).ok().unwrap();
    update(&mut app, &image(2, 512)).unwrap();
    app = start(app.into_memory().into_flash()).ok().unwrap();
    app.confirm(WORD).unwrap();
    let mut flash = app.into_memory().into_flash();
    let at = memory(flash.clone()).payload_of(Slot::B) as usize;
    flash.flip(at * 8 + 3);
    let report = start(flash.clone()).ok().unwrap().report();
    assert_eq!(report.started.slot, Slot::A);
    let at = memory(flash.clone()).payload_of(Slot::A) as usize;
    flash.flip(at * 8);
    assert!(start(flash).is_err(), "nothing is left to be started");
}

/// A board whose flash holds no image starts none.
#[test]
fn an_empty_board() {
    let flash: Chip<4, 256> = Chip::new(14, 6);
    let mut memory: Memory<_> = memory(flash);
    let board: Board<'_> = board();
    assert_eq!(boot(&mut memory, &board, || {}), Boot::Nothing);
}

/// A bootloader that dies of the committed image, wherever in it, does so once.
#[test]
fn a_bootloader_that_dies() {
    let flash: Chip<4, 256> = factory(&image(1, 512), 7);
    let mut app = start(flash).ok().unwrap();
    update(&mut app, &image(2, 512)).unwrap();
    let flash = app.into_memory().into_flash();
    // Once for the header, once for each 64 bytes of the payload.
    for last in 1..=9 {
        let mut memory = memory(flash.clone());
        let mut fed = 0;
        let died = catch_unwind(AssertUnwindSafe(|| {
            boot(&mut memory, &board(), || {
                fed += 1;
                if fed == last {
                    resume_unwind(Box::new("the watchdog"));
                }
            })
        }));
        assert!(died.is_err(), "it is fed {last} times");
        let report = start(memory.into_flash()).ok().unwrap().report();
        assert_eq!((report.started.slot, report.started.trial), (Slot::A, false));
        assert!(report.failed);
    }
}

/// The active image is not given up for one read, whatever is wrong with it.
#[test]
fn a_read_that_fails_once() {
    let flash: Chip<4, 256> = factory(&image(1, 512), 8);
    let mut app = start(flash).ok().unwrap();
    update(&mut app, &image(2, 512)).unwrap();
    app = start(app.into_memory().into_flash()).ok().unwrap();
    app.confirm(WORD).unwrap();
    let flash = app.into_memory().into_flash();
    for blip in Blip::ALL {
        for at in 1.. {
            let mut flash = flash.clone();
            let at = flash.reads + at;
            flash.blip = Some((at..at + 1, blip));
            let mut flash = start(flash).ok().unwrap().into_memory().into_flash();
            let happened = flash.reads >= at;
            flash.blip = None;
            let report = start(flash).ok().unwrap().report();
            assert_eq!((report.started.slot, report.started.trial), (Slot::B, false));
            if !happened {
                break;
            }
        }
    }
}
