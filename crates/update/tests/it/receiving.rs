//! Receiving: what is taken, what is refused and why, where it goes on.

use crate::bench::{
    Chip, Image, KEYS, LAYOUT, WORD, board, factory, fields, image, payload, receive, signed,
    start, update,
};
use crate::flash::{Blip, Cut, Torn};
use lafet_update::{
    BoardName, HEADER_LEN, Hash, Header, Layouts, Phase, Receiver, Refusal, SigningKey, Slot,
    Started, UNIT, Version,
};
use std::sync::atomic::{AtomicU32, Ordering};

type App = Receiver<'static, Chip<8, 256>>;

fn app() -> App {
    start(factory(&image(5, 512), 9)).ok().unwrap()
}

fn restart(app: App) -> App {
    start(app.into_memory().into_flash()).ok().unwrap()
}

fn begin(app: &mut App, raw: &[u8; HEADER_LEN]) -> Result<u32, Refusal> {
    app.begin(raw, Hash::of(WORD), false)
}

/// The steps and bytes of the flash: a refusal changes neither.
fn touched(app: &App) -> u64 {
    app.memory().flash().steps
}

/// Each check of `begin` is needed: an image that fails it alone is refused for that reason, before
/// anything is written.
#[test]
fn what_is_not_begun() {
    let bytes = || payload(6, 512);
    let signed_0 = |header: Header| signed(&KEYS[0], &header, bytes()).raw;
    let good = fields(6);
    let mut not_an_image = signed_0(good);
    not_an_image[0] = b'X';
    let mut format = signed_0(good);
    format[8] = 2;
    let mut malformed = signed_0(good);
    malformed[50] = 1;
    let mut forged = signed_0(good);
    forged[16] = 9;
    let too_large = KEYS[0].sign(&good, &payload(6, 4 * 256 + 8)).unwrap();
    let odd = KEYS[0].sign_header(&Header { size: 12, ..good });
    let nothing = KEYS[0].sign_header(&Header { size: 0, ..good });
    let itself = KEYS[0].sign_header(&Header { size: 8, revokes: 1, ..good });
    let cases = [
        (not_an_image, Refusal::NotAnImage),
        (format, Refusal::Format),
        (malformed, Refusal::Malformed),
        (signed_0(Header { board: BoardName::new("benches").unwrap(), ..good }), Refusal::Board),
        (signed_0(Header { place: Some(Slot::A), ..good }), Refusal::Place),
        (too_large, Refusal::Size),
        (odd, Refusal::Size),
        (nothing, Refusal::Size),
        (SigningKey::new(7, [1; 32]).sign(&good, &bytes()).unwrap(), Refusal::UnknownKey),
        (itself, Refusal::RevokesItself),
        (SigningKey::new(0, [9; 32]).sign(&good, &bytes()).unwrap(), Refusal::Signature),
        (forged, Refusal::Signature),
        (signed_0(fields(5)), Refusal::NotNewer),
        (signed_0(fields(4)), Refusal::NotNewer),
        (
            signed_0(Header { layouts: Layouts { oldest: 1, newest: LAYOUT - 1 }, ..good }),
            Refusal::Layout,
        ),
        (
            signed_0(Header { layouts: Layouts { oldest: LAYOUT + 1, newest: 9 }, ..good }),
            Refusal::Layout,
        ),
    ];
    let mut app = app();
    let before = touched(&app);
    for (raw, reason) in cases {
        assert_eq!(begin(&mut app, &raw), Err(reason));
        assert_eq!(app.report().phase, Phase::Idle);
        assert_eq!(touched(&app), before, "{reason}: nothing is written");
    }
    assert_eq!(begin(&mut app, &signed_0(good)), Ok(0));
    let placed = signed_0(Header { place: Some(Slot::B), ..good });
    assert_eq!(begin(&mut app, &placed), Ok(0));
}

/// A revoked key signs nothing more, in this and in every later start.
#[test]
fn a_revoked_key() {
    let mut app = app();
    let revoking = signed(&KEYS[1], &Header { revokes: 1, ..fields(6) }, payload(6, 512));
    update(&mut app, &revoking).unwrap();
    app = restart(app);
    assert!(app.confirm(WORD).is_ok());
    for _ in 0..2 {
        assert_eq!(begin(&mut app, &image(7, 512).raw), Err(Refusal::RevokedKey));
        app = restart(app);
    }
    let next = signed(&KEYS[2], &fields(7), payload(7, 512));
    assert_eq!(begin(&mut app, &next.raw), Ok(0));
}

/// An unconfirmed image revokes nothing.
#[test]
fn a_trial_revokes_nothing() {
    let mut app = app();
    let revoking = signed(&KEYS[1], &Header { revokes: 1, ..fields(6) }, payload(6, 512));
    update(&mut app, &revoking).unwrap();
    app = restart(restart(app));
    assert_eq!(begin(&mut app, &image(7, 512).raw), Ok(0));
}

/// Older images need a press at the board, each time, and the press holds for that image alone.
#[test]
fn an_older_image_needs_a_press() {
    let mut app = app();
    let older = image(4, 512);
    assert_eq!(begin(&mut app, &older.raw), Err(Refusal::NotNewer));
    assert_eq!(app.begin(&older.raw, Hash::of(WORD), true), Ok(0));
    for (index, bytes) in older.payload.chunks(64).enumerate() {
        app.data(index as u32 * 64, bytes).unwrap();
    }
    app.verify().unwrap();
    while app.report().phase == Phase::Verifying {
        app.poll().unwrap();
    }
    app.commit(Hash::of(WORD)).unwrap();
    app = restart(app);
    assert_eq!(app.report().started.version, Version([4, 0, 0, 0]));
    app.confirm(WORD).unwrap();
    app = restart(app);
    // What is newer than that needs no press again.
    assert_eq!(begin(&mut app, &image(5, 512).raw), Ok(0));
    assert_eq!(begin(&mut app, &image(3, 512).raw), Err(Refusal::NotNewer));
}

/// Data out of their order, twice, beyond the end, of an odd size: refused, and nothing is lost.
#[test]
fn data_out_of_order() {
    let mut app = app();
    assert_eq!(app.data(0, &[0; 8]), Err(Refusal::NotBegun));
    let new = image(6, 512);
    begin(&mut app, &new.raw).unwrap();
    assert_eq!(app.data(0, &new.payload[..64]), Ok(64));
    let before = touched(&app);
    for (offset, len) in [(0, 64), (128, 64), (56, 8), (64, 0), (64, 7), (64, 456), (u32::MAX, 8)] {
        let refused = app.data(offset, &vec![0; len]);
        assert_eq!(refused, Err(Refusal::Misplaced), "{len} at {offset}");
    }
    assert_eq!(app.verify(), Err(Refusal::Incomplete));
    assert_eq!(app.commit(Hash::default()), Err(Refusal::NotVerified));
    assert_eq!(touched(&app), before);
    assert_eq!(app.data(64, &new.payload[64..]), Ok(512));
    assert_eq!(app.commit(Hash::default()), Err(Refusal::NotVerified));
    app.verify().unwrap();
    assert_eq!(app.commit(Hash::default()), Err(Refusal::NotVerified), "while it is hashed");
    app.poll().unwrap();
    assert_eq!(app.report().phase, Phase::Verified);
    assert_eq!(app.data(512, &[0; 8]), Err(Refusal::NotBegun));
}

/// Any bit of the payload: found, and the image is received from its beginning again.
#[test]
fn a_flipped_bit_of_the_payload() {
    let mut app = app();
    let good = image(6, 2 * UNIT);
    for bit in 0..good.payload.len() * 8 {
        let mut bad = good.clone();
        bad.payload[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(receive(&mut app, &bad, 8), Err(Refusal::Hash), "bit {bit}");
        assert_eq!(app.report().phase, Phase::Idle);
        assert_eq!(app.commit(Hash::default()), Err(Refusal::NotVerified));
    }
    assert_eq!(begin(&mut app, &good.raw), Ok(0), "nothing of it is believed");
    receive(&mut app, &good, 8).unwrap();
}

/// Whatever the size of the parts, and of the image.
#[test]
fn sizes() {
    for len in [8, 248, 256, 264, 3 * 256 - 8, 3 * 256] {
        for part in [8, 24, 240, 256, 512] {
            let mut app = app();
            let new = image(6, len);
            receive(&mut app, &new, part).unwrap();
            app.commit(Hash::of(WORD)).unwrap();
            app = restart(app);
            assert_eq!(app.report().started.version, Version([6, 0, 0, 0]), "{len} by {part}");
        }
    }
}

/// After a loss of power it goes on at the page that was not complete.
#[test]
fn resumed() {
    let new = image(6, 3 * 256);
    let mut app = app();
    begin(&mut app, &new.raw).unwrap();
    for (index, bytes) in new.payload[..544].chunks(32).enumerate() {
        app.data(index as u32 * 32, bytes).unwrap();
    }
    // The same image again, in the same run: nothing is written.
    let before = touched(&app);
    assert_eq!(begin(&mut app, &new.raw), Ok(544));
    assert_eq!(touched(&app), before);
    app = restart(app);
    assert_eq!(app.report().phase, Phase::Idle);
    assert_eq!(app.verify(), Err(Refusal::NotBegun));
    assert_eq!(begin(&mut app, &new.raw), Ok(512));
    app = restart(app);
    update(&mut app, &new).unwrap();
    app = restart(app);
    assert_eq!(app.report().started.version, Version([6, 0, 0, 0]));
}

/// Another image in between: nothing of the first is believed.
#[test]
fn another_image() {
    let mut app = app();
    let (first, second) = (image(6, 512), image(7, 768));
    receive(&mut app, &first, 64).unwrap();
    assert_eq!(begin(&mut app, &second.raw), Ok(0));
    assert_eq!(begin(&mut app, &first.raw), Ok(0));
    update(&mut app, &second).unwrap();
    app = restart(app);
    assert_eq!(app.report().started.version, Version([7, 0, 0, 0]));
}

/// The word of another update confirms nothing; nor does any word without a trial.
#[test]
fn words() {
    let mut app = app();
    assert_eq!(app.confirm(WORD), Err(Refusal::NotOnTrial));
    update(&mut app, &image(6, 512)).unwrap();
    assert_eq!(app.confirm(WORD), Err(Refusal::NotOnTrial), "it does not run yet");
    app = restart(app);
    assert_eq!(begin(&mut app, &image(7, 512).raw), Err(Refusal::OnTrial));
    for wrong in [b"".as_slice(), b"another", &Hash::of(WORD).0] {
        assert_eq!(app.confirm(wrong), Err(Refusal::Word));
    }
    assert_eq!(app.confirm(WORD), Ok(()));
    assert_eq!(app.confirm(WORD), Err(Refusal::NotOnTrial));
    update(&mut app, &image(7, 512)).unwrap();
    app = restart(restart(app));
    assert_eq!(app.confirm(WORD), Err(Refusal::NotOnTrial), "it has gone back");
}

/// A page that cannot be written: the image is not there, the running one is.
#[test]
fn a_worn_page() {
    let mut app = app();
    let new = image(6, 512);
    let at = app.memory().payload_of(Slot::B) + 256;
    app.memory_mut().flash_mut().worn.push(at..at + 8);
    assert_eq!(receive(&mut app, &new, 64), Err(Refusal::Flash));
    assert_eq!(app.report().phase, Phase::Idle);
    app = restart(app);
    assert_eq!(app.report().started.version, Version([5, 0, 0, 0]));
}

/// An image that was written again between its verification and now is not committed twice.
#[test]
fn beginning_again_takes_back_a_commit() {
    let mut app = app();
    update(&mut app, &image(6, 512)).unwrap();
    let other: Image = image(7, 512);
    begin(&mut app, &other.raw).unwrap();
    app = restart(app);
    let report = app.report();
    assert_eq!((report.started.slot, report.started.trial), (Slot::A, false));
}

/// Two senders: what one has started the other does not commit, and each sees whose image it is.
#[test]
fn two_senders() {
    let mut app = app();
    let (mine, other) = (image(6, 512), image(7, 512));
    assert_eq!(app.report().image[..], image(5, 512).header().hash.0[..4], "what is running");
    receive(&mut app, &mine, 64).unwrap();
    assert_eq!(app.report().image[..], mine.header().hash.0[..4]);
    // The same image, to be confirmed by another.
    let word = Hash::of(b"another word");
    assert_eq!(app.begin(&mine.raw, word, false), Ok(512));
    assert_eq!(app.commit(Hash::of(WORD)), Err(Refusal::Word));
    assert_eq!(app.report().phase, Phase::Verified);
    app.begin(&other.raw, word, false).unwrap();
    assert_eq!(app.report().image[..], other.header().hash.0[..4]);
    for part in other.payload.chunks(64) {
        app.data(app.report().received, part).unwrap();
    }
    app.verify().unwrap();
    app.poll().unwrap();
    assert_eq!(app.commit(Hash::of(WORD)), Err(Refusal::Word));
    assert_eq!(app.commit(word), Ok(()));
    app = restart(app);
    assert_eq!(app.confirm(WORD), Err(Refusal::Word));
    assert_eq!(app.confirm(b"another word"), Ok(()));
}

/// A rejected payload is received from its beginning again, also when its marks could not be erased.
#[test]
fn a_rejected_payload_with_marks() {
    let mut app = app();
    let good = image(6, 512);
    let mut bad = good.clone();
    bad.payload[300] ^= 1;
    begin(&mut app, &bad.raw).unwrap();
    app.data(0, &bad.payload).unwrap();
    app.verify().unwrap();
    app.memory_mut().flash_mut().fail(Cut { step: 0, torn: Torn::Old });
    assert_eq!(app.poll(), Err(Refusal::Hash));
    assert!(!app.memory().flash().is_to_fail());
    assert_eq!(begin(&mut app, &good.raw), Ok(0));
}

/// The pages of the record, all of them full of what means nothing.
fn lose_record(app: &mut App) {
    for bit in (10 * 256 * 8..14 * 256 * 8).step_by(5) {
        app.memory_mut().flash_mut().flip(bit);
    }
}

/// A board of version 6 that has revoked key 0, its update confirmed.
fn revoked() -> App {
    let mut app = app();
    let revoking = signed(&KEYS[1], &Header { revokes: 1, ..fields(6) }, payload(6, 512));
    update(&mut app, &revoking).unwrap();
    app = restart(app);
    app.confirm(WORD).unwrap();
    restart(app)
}

/// A record that was read at the start is not taken for none because it cannot be read now.
#[test]
fn a_record_that_is_lost_meanwhile() {
    let mut app = revoked();
    // The image that runs revokes nothing itself.
    let signed_1 = |major| signed(&KEYS[1], &fields(major), payload(6, 512));
    update(&mut app, &signed_1(7)).unwrap();
    app = restart(app);
    app.confirm(WORD).unwrap();
    lose_record(&mut app);
    assert_eq!(begin(&mut app, &image(8, 512).raw), Err(Refusal::RevokedKey));
    assert_eq!(begin(&mut app, &signed_1(7).raw), Err(Refusal::NotNewer));
    assert_eq!(begin(&mut app, &signed_1(8).raw), Ok(0));
    // Nor is it lost any more.
    app = restart(app);
    assert_eq!(begin(&mut app, &image(8, 512).raw), Err(Refusal::RevokedKey));
}

/// Without any record, what runs says which versions are old and which keys are revoked.
#[test]
fn a_record_that_is_lost() {
    let mut app = revoked();
    lose_record(&mut app);
    app = restart(app);
    let started = app.report().started;
    assert_eq!((started.version, started.trial), (Version([6, 0, 0, 0]), false));
    assert_eq!(begin(&mut app, &image(7, 512).raw), Err(Refusal::RevokedKey));
    let older = signed(&KEYS[1], &fields(6), payload(6, 512));
    assert_eq!(begin(&mut app, &older.raw), Err(Refusal::NotNewer));
    assert_eq!(begin(&mut app, &signed(&KEYS[1], &fields(7), payload(7, 512)).raw), Ok(0));
}

/// What is confirmed for ever is what was signed, whatever is read wrongly meanwhile.
#[test]
fn misread_while_confirmed() {
    let signed_1 = |header: Header| signed(&KEYS[1], &header, payload(6, 64));
    let revoking = signed_1(Header { revokes: 1, ..fields(6) });
    let mut noticed = 0;
    // Of each of them another bit, all over the header.
    for seed in 0..300 {
        let mut app = start(factory(&image(5, 64), seed)).ok().unwrap();
        update(&mut app, &revoking).unwrap();
        app = restart(app);
        let flash = app.memory_mut().flash_mut();
        flash.blip = Some((flash.reads + 1..flash.reads + 2, Blip::Misread));
        if app.confirm(WORD).is_err() {
            noticed += 1;
            app.confirm(WORD).unwrap();
        }
        app = restart(app);
        assert_eq!(begin(&mut app, &image(7, 64).raw), Err(Refusal::RevokedKey));
        assert_eq!(begin(&mut app, &signed_1(fields(6)).raw), Err(Refusal::NotNewer));
        assert_eq!(begin(&mut app, &signed_1(fields(7)).raw), Ok(0));
    }
    assert_eq!(noticed, 300);
}

/// A commit whose trial the bootloader could not note is not tried later, when it is not expected.
#[test]
fn a_commit_that_was_not_tried() {
    let mut app = app();
    update(&mut app, &image(6, 512)).unwrap();
    app.memory_mut().flash_mut().worn.push(10 * 256..14 * 256);
    app = restart(app);
    let report = app.report();
    assert_eq!((report.started.slot, report.started.trial, report.pending), (Slot::A, false, true));
    for _ in 0..3000 {
        app.poll().unwrap();
        assert!(app.report().pending, "it cannot be stored");
    }
    app.memory_mut().flash_mut().worn.clear();
    for _ in 0..1025 {
        app.poll().unwrap();
    }
    assert!(!app.report().pending && app.report().failed);
    app = restart(app);
    let report = app.report();
    assert_eq!((report.started.slot, report.started.trial), (Slot::A, false));
}

/// A step that fails once does not keep the record from being stored.
#[test]
fn a_record_that_fails_once() {
    for torn in Torn::ALL {
        for step in 0.. {
            let mut app = app();
            receive(&mut app, &image(6, 8), 8).unwrap();
            app.memory().flash().fail(Cut { step, torn });
            assert_eq!(app.commit(Hash::of(WORD)), Ok(()), "{torn:?} in step {step}");
            let happened = !app.memory().flash().is_to_fail();
            app.memory().flash().clear_cut();
            app = restart(app);
            assert!(app.report().started.trial, "{torn:?} in step {step}");
            if !happened {
                assert!(step > 20, "{step}");
                break;
            }
        }
    }
}

/// A commit that is refused is not carried out by a later start either.
#[test]
fn a_commit_that_fails() {
    let mut app = app();
    receive(&mut app, &image(6, 512), 64).unwrap();
    app.memory_mut().flash_mut().worn.push(10 * 256..14 * 256);
    assert_eq!(app.commit(Hash::of(WORD)), Err(Refusal::Flash));
    assert!(app.report().pending);
    app.memory_mut().flash_mut().worn.clear();
    for _ in 0..1025 {
        app.poll().unwrap();
    }
    assert!(!app.report().pending);
    assert_eq!(app.report().phase, Phase::Verified);
    assert_eq!(app.commit(Hash::of(WORD)), Ok(()));
}

/// Makes what is in a slot one that does not verify.
fn spoil(app: &mut App, slot: Slot) {
    let at = app.memory().payload_of(slot) as usize;
    app.memory_mut().flash_mut().flip(at * 8 + 3);
}

/// A trial that nothing can be gone back from may be replaced, though its word is lost.
#[test]
fn a_trial_with_nothing_to_go_back_to() {
    let mut app = app();
    update(&mut app, &image(6, 512)).unwrap();
    app = restart(app);
    let next = image(7, 512);
    assert_eq!(begin(&mut app, &next.raw), Err(Refusal::OnTrial), "the old one is there");
    // One read that fails does not give it up.
    let flash = app.memory_mut().flash_mut();
    for at in flash.reads + 1..flash.reads + 12 {
        for blip in Blip::ALL {
            let mut flash = app.memory().flash().clone();
            flash.blip = Some((at..at + 1, blip));
            core::mem::swap(app.memory_mut().flash_mut(), &mut flash);
            assert_eq!(begin(&mut app, &next.raw), Err(Refusal::OnTrial), "{blip:?} in {at}");
            core::mem::swap(app.memory_mut().flash_mut(), &mut flash);
        }
    }
    spoil(&mut app, Slot::A);
    assert_eq!(begin(&mut app, &next.raw), Ok(0));
    app.data(0, &next.payload[..64]).unwrap();
    assert_eq!(app.confirm(WORD), Err(Refusal::NotOnTrial));
    // What ran on trial is all there is.
    app = restart(app);
    let report = app.report();
    assert_eq!((report.started.slot, report.started.trial), (Slot::B, false));
    update(&mut app, &next).unwrap();
    app = restart(app);
    assert_eq!((app.report().started.slot, app.confirm(WORD)), (Slot::A, Ok(())));
}

/// What runs is what an update goes back to, also where the record names the slot of another one.
#[test]
fn running_beside_the_record() {
    let mut app = app();
    update(&mut app, &image(6, 512)).unwrap();
    app = restart(app);
    app.confirm(WORD).unwrap();
    spoil(&mut app, Slot::B);
    app.memory_mut().flash_mut().worn.push(10 * 256..14 * 256);
    app = restart(app);
    assert_eq!(app.report().started.slot, Slot::A, "the kept one");
    app.memory_mut().flash_mut().worn.clear();
    let next = image(7, 512);
    begin(&mut app, &next.raw).unwrap();
    for _ in 0..3 {
        app = restart(app);
        let report = app.report();
        assert_eq!((report.started.slot, report.started.trial), (Slot::A, false));
        let there = begin(&mut app, &next.raw).unwrap() as usize;
        app.data(there as u32, &next.payload[there..][..64]).unwrap();
    }
    update(&mut app, &next).unwrap();
    app = restart(app);
    assert_eq!((app.report().started.slot, app.confirm(WORD)), (Slot::B, Ok(())));
}

/// Where an older image has taken the place of one that was confirmed, that one may be had again,
/// without a press; others not newer than it may not.
#[test]
fn the_confirmed_version_again() {
    let mut app = app();
    let confirmed = image(6, 512);
    update(&mut app, &confirmed).unwrap();
    app = restart(app);
    app.confirm(WORD).unwrap();
    assert_eq!(begin(&mut app, &confirmed.raw), Err(Refusal::NotNewer));
    spoil(&mut app, Slot::B);
    app = restart(app);
    let report = app.report();
    assert_eq!((report.started.version, report.lost), (Version([5, 0, 0, 0]), true));
    let between = Header { version: Version([5, 9, 0, 0]), ..fields(5) };
    let between = signed(&KEYS[0], &between, payload(5, 512));
    assert_eq!(begin(&mut app, &between.raw), Err(Refusal::NotNewer));
    // What is there has a bit flipped; then it is received from its beginning.
    assert_eq!(update(&mut app, &confirmed), Err(Refusal::Hash));
    update(&mut app, &confirmed).unwrap();
    app = restart(app);
    assert!(!app.report().lost, "what is on trial is no older one");
    assert_eq!((app.report().started.slot, app.confirm(WORD)), (Slot::B, Ok(())));
    assert_eq!(begin(&mut app, &confirmed.raw), Err(Refusal::NotNewer));
    assert!(!app.report().lost);
}

/// The trial of a word is ended by its digest alone, and only while there is one.
#[test]
fn ending_a_trial() {
    let (mine, other) = (Hash::of(WORD), Hash::of(b"another word"));
    let mut app = app();
    assert_eq!(app.abandon(mine), Err(Refusal::NotOnTrial));
    update(&mut app, &image(6, 512)).unwrap();
    assert_eq!(app.abandon(mine), Err(Refusal::NotOnTrial), "it does not run yet");
    app = restart(app);
    let steps = touched(&app);
    assert_eq!(app.abandon(other), Err(Refusal::Word));
    assert_eq!(app.abandon(mine), Ok(()));
    assert_eq!(touched(&app), steps, "it is the restart that ends it");
    assert_eq!(app.confirm(WORD), Ok(()));
    assert_eq!(app.abandon(mine), Err(Refusal::NotOnTrial));
}

/// A board that does not pass on that an image is on trial does not make it one that stays.
#[test]
fn a_trial_that_is_not_passed_on() {
    let mut app = app();
    assert!(!app.report().started.trial);
    update(&mut app, &image(6, 512)).unwrap();
    app = restart(app);
    let started = Started { trial: false, ..app.report().started };
    let mut app = Receiver::new(app.into_memory(), board(), started, LAYOUT);
    assert!(app.report().started.trial);
    assert_eq!(begin(&mut app, &image(7, 512).raw), Err(Refusal::OnTrial));
    assert_eq!(app.confirm(WORD), Ok(()));
    let started = app.report().started;
    assert!(!started.trial);
    let app = Receiver::new(app.into_memory(), board(), started, LAYOUT);
    assert!(!app.report().started.trial, "it is the active one");
}

static FED: AtomicU32 = AtomicU32::new(0);

/// The watchdog is fed while an order verifies a slot, three times where it has rotted.
#[test]
fn a_long_order_feeds_the_watchdog() {
    let mut app = app();
    update(&mut app, &image(6, 512)).unwrap();
    app = restart(app);
    spoil(&mut app, Slot::A);
    app.set_feed(|| {
        FED.fetch_add(1, Ordering::Relaxed);
    });
    assert_eq!(begin(&mut app, &image(7, 512).raw), Ok(0));
    // For each 64 bytes and each signature.
    let fed = FED.load(Ordering::Relaxed);
    assert!(fed > 3 * (512 / 64 + 1), "{fed}");
}
