//! What people use instead, each with its own way to say the same.

mod deku_rs;
mod mavlink_rs;
mod plain;
mod postcard_rs;
mod prost_rs;
mod rmodbus_rs;

use crate::case::Case;
use crate::values::{Drive, ROOM, Whole};

/// Cases of all of them.
pub fn cases() -> Vec<Case> {
    [
        plain::cases(),
        postcard_rs::cases(),
        deku_rs::cases(),
        prost_rs::cases(),
        mavlink_rs::cases(),
        rmodbus_rs::cases(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// What most of them work on.
struct State {
    input: Vec<u8>,
    out: [u8; ROOM],
    len: usize,
    drive: Drive,
    whole: Whole,
}

impl State {
    fn new(input: &[u8]) -> Self {
        let (drive, whole) = (Drive::SAMPLE, Whole::SAMPLE);
        Self { input: input.to_vec(), out: [0; ROOM], len: 0, drive, whole }
    }

    fn made(&self) -> bool {
        self.len > 0 && self.out[..self.len] == self.input[..]
    }

    /// One that has seen nothing yet.
    fn blank(input: &[u8]) -> Self {
        Self { drive: Drive::default(), whole: Whole::default(), ..Self::new(input) }
    }

    fn seen_drive(&self) -> bool {
        self.drive == Drive::SAMPLE
    }

    fn seen_whole(&self) -> bool {
        self.whole == Whole::SAMPLE
    }
}
