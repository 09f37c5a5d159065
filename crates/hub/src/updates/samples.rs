//! Images for tests. None is signed: that is for the monitor to find out.

use lafet_client::update::Image;
use lafet_proto::update::{HEADER_LEN, MAGIC};
use sha2::{Digest as _, Sha256};

/// An image of version `number`.0.0.0 for this slot (0: either); each number has a payload of its own.
pub fn image(number: u16, slot: u8) -> Image {
    made(number, slot, &payload(number, slot))
}

/// Version `number`.7.0.0 with the payload of version `number`.0.0.0 for either slot.
pub fn renamed(number: u16) -> Image {
    let mut bytes = bytes(number, 0, &payload(number, 0));
    bytes[18] = 7;
    Image::read(&bytes).unwrap()
}

fn payload(number: u16, slot: u8) -> Vec<u8> {
    format!("{number:6}{slot:2}").into_bytes().repeat(20)
}

fn made(number: u16, slot: u8, payload: &[u8]) -> Image {
    Image::read(&bytes(number, slot, payload)).unwrap()
}

/// The bytes of an image file.
pub fn bytes(number: u16, slot: u8, payload: &[u8]) -> Vec<u8> {
    let mut header = [0; HEADER_LEN];
    let digest = Sha256::digest(payload);
    let parts: [(usize, &[u8]); 7] = [
        (0, &MAGIC),
        (8, &[1]),
        (12, &(payload.len() as u32).to_le_bytes()),
        (16, &number.to_le_bytes()),
        (24, b"bench"),
        (40, &[slot, 3]),
        (64, digest.as_slice()),
    ];
    for (from, part) in parts {
        header[from..from + part.len()].copy_from_slice(part);
    }
    [&header[..], payload].concat()
}
