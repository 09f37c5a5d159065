//! The serial lines.

use crate::register::{read, write};

const LINE: usize = 0x4000_4000;
const PLANT: usize = 0x4000_5000;

const STATE: usize = 0x04;
const FULL_TO_SEND: u32 = 1;
const HAS_RECEIVED: u32 = 1 << 1;
const CONTROL: usize = 0x08;
const BOTH_WAYS: u32 = 0b11;
const DIVIDER: usize = 0x10;
/// 115,200 baud at 25 MHz.
const BAUD_115200: u32 = 217;
/// Looks until a byte must have left: several times as long as one takes.
const LOOKS: u32 = 4_096;

/// A serial line.
#[derive(Debug)]
pub struct Uart {
    base: usize,
    /// The other end takes nothing.
    blocked: bool,
}

impl Uart {
    /// The line of the monitor.
    pub fn line() -> Self {
        Self::start(LINE)
    }

    /// The line to the simulated plant.
    pub fn plant() -> Self {
        Self::start(PLANT)
    }

    fn start(base: usize) -> Self {
        write(base + DIVIDER, BAUD_115200);
        write(base + CONTROL, BOTH_WAYS);
        Self { base, blocked: false }
    }

    /// The byte that has come.
    pub fn read(&self) -> Option<u8> {
        (read(self.base + STATE) & HAS_RECEIVED != 0).then(|| read(self.base) as u8)
    }

    /// Sends a byte. In front of an end that takes nothing it is lost, since nothing may wait for that
    /// end, and those behind it at once.
    pub fn put(&mut self, byte: u8) {
        let looks = if self.blocked { 1 } else { LOOKS };
        self.blocked = (0..looks).all(|_| read(self.base + STATE) & FULL_TO_SEND != 0);
        if !self.blocked {
            write(self.base, byte.into());
        }
    }
}
