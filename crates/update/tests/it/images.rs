//! Headers: what they say comes back, and nothing else does.

use crate::bench::{KEYS, board, fields, image, payload, signed};
use lafet_update::{BoardName, Header, Layouts, Refusal, Slot, Version};

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
