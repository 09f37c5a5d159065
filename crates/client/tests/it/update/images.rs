//! Image files: what they say, and what is wrong with those that are none.

use lafet_client::Lang;
use lafet_client::update::{FILE_MAX, Image, ImageError};
use lafet_proto::update::UNIT;

use super::model::{Dice, NEW, file, payload, sha};

/// What an image file says.
#[test]
fn an_image() {
    let image = Image::read(&file(NEW, 2, &payload(80))).unwrap();
    assert_eq!((image.version(), image.board()), (NEW, "board"));
    assert_eq!((image.slot(), image.key()), (Some(2), 3));
    assert_eq!(image.payload(), payload(80));
    assert_eq!(image.digest(), sha(&payload(80)));
    assert_eq!(image.header()[96..], [0xA5; 64]);
    let either = Image::read(&file(NEW, 0, &payload(8))).unwrap();
    assert_eq!(either.slot(), None);
}

/// Each wrong file has its error, in both languages.
#[test]
fn wrong_files() {
    let well = file(NEW, 2, &payload(80));
    let changed = |at: usize, byte: u8| {
        let mut bytes = well.clone();
        bytes[at] = byte;
        bytes
    };
    let (there, wanted) = (241, 240);
    let cases = [
        (Vec::new(), ImageError::Foreign),
        (b"\x7fELF".to_vec(), ImageError::Foreign),
        (changed(7, b'g'), ImageError::Foreign),
        (
            [&well[..], &vec![0; FILE_MAX][..]].concat(),
            ImageError::TooLarge { there: (FILE_MAX + 240) as u64 },
        ),
        (well[..100].to_vec(), ImageError::Cut { there: 100, wanted: 160 }),
        (well[..239].to_vec(), ImageError::Cut { there: 239, wanted }),
        ([&well[..], &[0][..]].concat(), ImageError::Longer { there, wanted }),
        (changed(8, 2), ImageError::Format { format: 2 }),
        (changed(12, 81), ImageError::Unit { size: 81 }),
        (changed(12, 0), ImageError::Unit { size: 0 }),
        (changed(24, 0), ImageError::Board),
        (changed(25, b' '), ImageError::Board),
        (changed(39, b'x'), ImageError::Board),
        (changed(40, 3), ImageError::Slot { slot: 3 }),
        (changed(41, 16), ImageError::Key { key: 16 }),
        (changed(42, 8), ImageError::RevokesItself { key: 3 }),
        (changed(44, 3), ImageError::Layouts { oldest: 3, newest: 2 }),
        (changed(10, 1), ImageError::Reserved),
        (changed(63, 1), ImageError::Reserved),
        (changed(95, well[95] ^ 1), ImageError::Digest),
        (changed(200, well[200] ^ 1), ImageError::Digest),
    ];
    for (bytes, wanted) in cases {
        let error = Image::read(&bytes).unwrap_err();
        assert_eq!(error, wanted);
        let (english, russian) = (error.to_string(), error.localized(Lang::Ru));
        let cyrillic = |text: &str| text.chars().any(|c| ('а'..='я').contains(&c));
        assert!(!cyrillic(&english) && cyrillic(&russian), "{english} / {russian}");
    }
}

/// Any bytes are refused, or are an image of exactly these bytes.
#[test]
fn any_bytes() {
    let well = file(NEW, 2, &payload(80));
    let mut dice = Dice(1);
    let check = |bytes: &[u8]| match Image::read(bytes) {
        Ok(image) => {
            assert_eq!([&image.header()[..], image.payload()].concat(), bytes);
            assert_eq!(image.digest(), sha(image.payload()));
            assert!(image.payload().len().is_multiple_of(UNIT) && !image.board().is_empty());
            assert!(image.slot().is_none_or(|slot| matches!(slot, 1 | 2)) && image.key() < 16);
            true
        }
        Err(_) => false,
    };
    assert!(check(&well));
    for end in 0..well.len() {
        assert!(!check(&well[..end]), "{end}");
    }
    for bit in 0..well.len() * 8 {
        let mut bytes = well.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let well = check(&bytes);
        assert!(!well || (16..96 + 64).contains(&(bit / 8)), "bit {bit}");
    }
    for _ in 0..20_000 {
        let len = dice.roll() as usize % 400;
        let mut bytes: Vec<u8> = (0..len).map(|_| dice.roll() as u8).collect();
        // Beginnings that pass the first checks, or some of them.
        let kept = dice.roll() as usize % 200;
        for (byte, good) in bytes.iter_mut().zip(well.iter().take(kept)) {
            *byte = *good;
        }
        assert!(!check(&bytes) || bytes.len() == well.len());
    }
}
