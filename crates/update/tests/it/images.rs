//! Headers: what they say comes back, and nothing else does.

use crate::bench::{Chip, KEYS, board, fields, image, payload, signed};
use lafet_update::{
    Board, BoardName, Header, Layouts, PublicKey, Refusal, SigningKey, Slot, Version,
};

/// What was signed is read, every field of it.
#[test]
fn a_header_comes_back() {
    let mut wanted = fields(3);
    wanted.version = Version([3, 258, 4, 65535]);
    wanted.place = Some(Slot::B);
    wanted.revokes = 0b101;
    wanted.layouts = Layouts { oldest: 7, newest: 300 };
    let image = signed(&KEYS[1], &wanted, payload(3, 64));
    let header = Header::check(&image.raw, &board(), 0).unwrap();
    wanted.size = 64;
    wanted.key = 1;
    wanted.hash = lafet_update::Hash::of(&image.payload);
    assert_eq!(header, wanted);
    assert_eq!(header.version.to_string(), "3.258.4.65535");
    assert_eq!(header.board.as_str(), "bench");
}

/// The bytes of a header are fixed: images that were signed once stay readable.
#[test]
fn a_golden_header() {
    let image = image(2, 16);
    let hex: String = image.raw.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(hex, include_str!("golden.hex").trim());
}

/// Every bit of header and signature counts.
#[test]
fn a_flipped_bit_is_found() {
    let image = image(2, 16);
    for bit in 0..image.raw.len() * 8 {
        let mut raw = image.raw;
        raw[bit / 8] ^= 1 << (bit % 8);
        assert!(Header::check(&raw, &board(), 0).is_err(), "bit {bit}");
    }
    assert!(Header::check(&image.raw, &board(), 0).is_ok());
}

/// Points of the curve, of a small order and none, by their bytes.
fn point(dice: &Chip<8, 256>) -> [u8; 32] {
    let of = |first: u8, others: u8, last: u8| {
        let mut bytes = [others; 32];
        (bytes[0], bytes[31]) = (first, last);
        bytes
    };
    match dice.random() % 12 {
        0 => of(0, 0, 0),
        1 => of(1, 0, 0x80),
        2 => of(0xEC, 0xFF, 0x7F),
        3 => of(0xED, 0xFF, 0xFF),
        4 => scalar(dice),
        _ => SigningKey::new(0, std::array::from_fn(|_| dice.random() as u8)).public().bytes,
    }
}

/// Numbers at the edges of the order of the curve, of long runs of ones and zeros, of one pattern, and others.
fn scalar(dice: &Chip<8, 256>) -> [u8; 32] {
    const ORDER: [u8; 32] = [
        0xED, 0xD3, 0xF5, 0x5C, 0x1A, 0x63, 0x12, 0x58, 0xD6, 0x9C, 0xF7, 0xA2, 0xDE, 0xF9, 0xDE,
        0x14, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x10,
    ];
    let pattern = dice.random() as u8;
    let mut bytes = match dice.random() % 6 {
        0 => {
            let mut bytes = ORDER;
            bytes[0] = 0xEB + pattern % 4;
            return bytes;
        }
        1 => std::array::from_fn(|_| if dice.random().is_multiple_of(2) { 0xFF } else { 0 }),
        2 => [pattern; 32],
        3 => [0; 32],
        _ => std::array::from_fn(|_| dice.random() as u8),
    };
    // Below the order, but for the last ones: others are refused before anything is multiplied.
    bytes[31] &= if pattern.is_multiple_of(16) { 0xFF } else { 0x0F };
    bytes
}

/// Whatever the key and the signature are, the check ends and says that it is wrong: where this is built, the library
/// that verifies panics at an index that is out of range and at a sum that overflows.
#[test]
fn any_signature_is_judged() {
    let dice = Chip::new(1, 7);
    let mut raw = image(2, 16).raw;
    for round in 0..3_000 {
        let key = PublicKey { id: 0, bytes: point(&dice) };
        let keyed = Board { name: board().name, keys: &[key] };
        // Version and digest: what is signed.
        for place in (16..24).chain(64..96) {
            raw[place] = dice.random() as u8;
        }
        raw[96..128].copy_from_slice(&point(&dice));
        raw[128..].copy_from_slice(&scalar(&dice));
        let judged = Header::check(&raw, &keyed, 0);
        assert_eq!(judged, Err(Refusal::Signature), "round {round}: {key:?} {raw:02x?}");
    }
}

#[test]
fn versions() {
    let version = |text: &str| text.parse::<Version>();
    assert_eq!(version("1"), Ok(Version([1, 0, 0, 0])));
    assert_eq!(version("1.2.3.4"), Ok(Version([1, 2, 3, 4])));
    assert!(version("1.10").unwrap() > version("1.9.9").unwrap());
    for wrong in ["", ".", "1.", "1.2.3.4.5", "65536", "-1", "+1", "1.x", " 1"] {
        assert!(version(wrong).is_err(), "{wrong:?}");
    }
}

#[test]
fn names_of_boards() {
    assert_eq!(BoardName::new("stm32f103-board1").unwrap().as_str(), "stm32f103-board1");
    for wrong in ["", "seventeen-letters", "two words", "плата"] {
        assert!(BoardName::new(wrong).is_none(), "{wrong:?}");
    }
}

/// Payloads that no monitor would take are not signed.
#[test]
fn what_cannot_be_signed() {
    let key = &KEYS[0];
    assert_eq!(key.sign(&fields(1), &[]), Err(Refusal::Size));
    assert_eq!(key.sign(&fields(1), &[0; 12]), Err(Refusal::Size));
    let itself = Header { revokes: 1, ..fields(1) };
    assert_eq!(key.sign(&itself, &[0; 8]), Err(Refusal::RevokesItself));
    let layouts = Header { layouts: Layouts { oldest: 3, newest: 2 }, ..fields(1) };
    assert_eq!(key.sign(&layouts, &[0; 8]), Err(Refusal::Malformed));
}

/// The numbers of the reasons are fixed and each is used once.
#[test]
fn numbers_of_reasons() {
    for (index, refusal) in Refusal::ALL.iter().enumerate() {
        assert_eq!(usize::from(refusal.code()), index + 1, "{refusal}");
        assert_eq!(Refusal::from_code(refusal.code()), Some(*refusal));
    }
    assert_eq!(Refusal::from_code(0), None);
    assert_eq!(Refusal::from_code(200), None);
}
