//! The decision of the start, as a table, and through the flash.

use crate::bench::{
    Chip, KEYS, WORD, board, factory, fields, image, memory, put, signed, start, update,
};
use lafet_update::{
    Board, BoardName, Boot, Hash, Header, Memory, Other, Record, Recorded, Refusal, Slot, Version,
    boot, decide,
};

fn record(other: Other) -> Record {
    Record {
        active: Slot::A,
        other,
        floor: Version([5, 0, 0, 0]),
        revoked: 0b100,
        allowed: false,
        word: Hash::of(WORD),
    }
}

/// What is started, whether on trial, and what the record says of the other slot afterwards.
fn decided(record: &Record, a: Option<u16>, b: Option<u16>) -> (Option<Slot>, bool, Other) {
    let decision = decide(&Recorded::Known(*record), |slot, revoked| {
        assert_eq!(revoked, record.revoked);
        let version = match slot {
            Slot::A => a,
            Slot::B => b,
        };
        version.map(fields).ok_or(Refusal::Hash)
    });
    let other = decision.record.map_or(record.other, |record| record.other);
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
        assert_eq!(decided(&record(other), a, b), wanted, "{other:?} {a:?} {b:?}");
    }
    let allowed = Record { allowed: true, ..record(Committed) };
    assert_eq!(decided(&allowed, old, Some(4)), (Some(B), true, Tried));
}

/// What was confirmed and is started in need is the active one from then on.
#[test]
fn the_kept_one_becomes_active() {
    let decision = decide(&Recorded::Known(record(Other::Kept)), |slot, _| match slot {
        Slot::A => Err(Refusal::Hash),
        Slot::B => Ok(fields(4)),
    });
    assert_eq!(decision.record.map(|record| record.active), Some(Slot::B));
}

/// Without a record the newest is started, and the first of two that are alike.
#[test]
fn without_a_record() {
    for recorded in [Recorded::Fresh, Recorded::Lost] {
        let cases =
            [(Some(1), Some(2), Slot::B), (Some(2), Some(2), Slot::A), (None, Some(1), Slot::B)];
        for (a, b, wanted) in cases {
            let decision = decide(&recorded, |slot, _| {
                let version = if slot == Slot::A { a } else { b };
                version.map(fields).ok_or(Refusal::Signature)
            });
            assert_eq!(decision.start.map(|(slot, _)| slot), Some(wanted));
            assert!(!decision.trial && decision.record.is_none());
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
    assert_eq!(app.begin(&new.raw, false), Ok(512));
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
        assert_eq!(memory(flash.clone()).verify(target, &board(), 0b100), Err(reason), "{what}");
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
    flash.worn.push(10 * 256..12 * 256);
    let report = start(flash.clone()).ok().unwrap().report();
    assert_eq!((report.started.slot, report.started.trial), (Slot::A, false));
    // With the active image gone, the committed one is better than nothing.
    flash.flip(300 * 8);
    flash.worn.clear();
    put(&mut flash, Slot::A, &{
        let mut rotten = image(1, 512);
        rotten.payload[0] ^= 1;
        rotten
    });
    flash.worn.push(10 * 256..12 * 256);
    let report = start(flash).ok().unwrap().report();
    assert_eq!((report.started.slot, report.started.trial), (Slot::B, true));
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
    let flash: Chip<4, 256> = Chip::new(12, 6);
    let mut memory: Memory<_> = memory(flash);
    let board: Board<'_> = board();
    assert_eq!(boot(&mut memory, &board), Boot::Nothing);
}
