//! Receiving: what is taken, what is refused and why, where it goes on.

use crate::bench::{
    Chip, Image, KEYS, LAYOUT, WORD, factory, fields, image, payload, receive, signed, start,
    update,
};
use lafet_update::{
    BoardName, Hash, Header, Layouts, Phase, Receiver, Refusal, SigningKey, Slot, UNIT, Version,
};

type App = Receiver<'static, Chip<8, 256>>;

fn app() -> App {
    start(factory(&image(5, 512), 9)).ok().unwrap()
}

fn restart(app: App) -> App {
    start(app.into_memory().into_flash()).ok().unwrap()
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
        assert_eq!(app.begin(&raw, false), Err(reason));
        assert_eq!(app.report().phase, Phase::Idle);
        assert_eq!(touched(&app), before, "{reason}: nothing is written");
    }
    assert_eq!(app.begin(&signed_0(good), false), Ok(0));
    let placed = signed_0(Header { place: Some(Slot::B), ..good });
    assert_eq!(app.begin(&placed, false), Ok(0));
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
        assert_eq!(app.begin(&image(7, 512).raw, false), Err(Refusal::RevokedKey));
        app = restart(app);
    }
    let next = signed(&KEYS[2], &fields(7), payload(7, 512));
    assert_eq!(app.begin(&next.raw, false), Ok(0));
}

/// An unconfirmed image revokes nothing.
#[test]
fn a_trial_revokes_nothing() {
    let mut app = app();
    let revoking = signed(&KEYS[1], &Header { revokes: 1, ..fields(6) }, payload(6, 512));
    update(&mut app, &revoking).unwrap();
    app = restart(restart(app));
    assert_eq!(app.begin(&image(7, 512).raw, false), Ok(0));
}

/// Older images need a press at the board, each time, and the press holds for that image alone.
#[test]
fn an_older_image_needs_a_press() {
    let mut app = app();
    let older = image(4, 512);
    assert_eq!(app.begin(&older.raw, false), Err(Refusal::NotNewer));
    assert_eq!(app.begin(&older.raw, true), Ok(0));
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
    assert_eq!(app.begin(&image(5, 512).raw, false), Ok(0));
    assert_eq!(app.begin(&image(3, 512).raw, false), Err(Refusal::NotNewer));
}

/// Data out of their order, twice, beyond the end, of an odd size: refused, and nothing is lost.
#[test]
fn data_out_of_order() {
    let mut app = app();
    assert_eq!(app.data(0, &[0; 8]), Err(Refusal::NotBegun));
    let new = image(6, 512);
    app.begin(&new.raw, false).unwrap();
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
    assert_eq!(app.begin(&good.raw, false), Ok(0), "nothing of it is believed");
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
    app.begin(&new.raw, false).unwrap();
    for (index, bytes) in new.payload[..544].chunks(32).enumerate() {
        app.data(index as u32 * 32, bytes).unwrap();
    }
    // The same image again, in the same run: nothing is written.
    let before = touched(&app);
    assert_eq!(app.begin(&new.raw, false), Ok(544));
    assert_eq!(touched(&app), before);
    app = restart(app);
    assert_eq!(app.report().phase, Phase::Idle);
    assert_eq!(app.verify(), Err(Refusal::NotBegun));
    assert_eq!(app.begin(&new.raw, false), Ok(512));
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
    assert_eq!(app.begin(&second.raw, false), Ok(0));
    assert_eq!(app.begin(&first.raw, false), Ok(0));
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
    assert_eq!(app.begin(&image(7, 512).raw, false), Err(Refusal::OnTrial));
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
    app.begin(&other.raw, false).unwrap();
    app = restart(app);
    let report = app.report();
    assert_eq!((report.started.slot, report.started.trial), (Slot::A, false));
}
