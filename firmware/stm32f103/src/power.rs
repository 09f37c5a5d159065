//! The supply of the chip, and the registers that a battery keeps over its absence (RM §5, §6).

use crate::bus::{Bus, Registers};
use stm32_metapac::bkp::regs::Dr;
use stm32_metapac::{BKP, PWR};

/// RM §5.4.1: 2.9 V.
const LEVEL: u8 = 0b111;
/// Marks the positions as those of a monitor at rest.
const STANDING: u16 = 0x57A9;

/// Starts watching the chip's supply, and opens the registers of the battery.
pub fn start(bus: &impl Bus) {
    bus.set(PWR.cr(), |cr| {
        cr.set_dbp(true);
        cr.set_pls(LEVEL);
        cr.set_pvde(true);
    });
}

/// Whether the chip's supply is about to go.
pub fn is_failing(bus: &impl Bus) -> bool {
    bus.get(PWR.csr()).pvdo()
}

/// The counts of the encoders as they were kept at rest; `None` after a motion that was not ended in
/// order, and when the battery was empty.
pub fn kept(bus: &impl Bus) -> Option<[i32; 4]> {
    let half = |n: usize| bus.get(BKP.dr(n & 15)).d();
    let mut counts = [0; 4];
    for (n, count) in counts.iter_mut().enumerate() {
        *count = (u32::from(half(2 * n)) | u32::from(half(2 * n + 1)) << 16).cast_signed();
    }
    (half(8) == STANDING && half(9) == check(&counts)).then_some(counts)
}

/// Stores the counts: the monitor is at rest.
pub fn keep(bus: &impl Bus, counts: &[i32; 4]) {
    for (n, count) in counts.iter().enumerate() {
        let count = count.cast_unsigned();
        bus.put(BKP.dr((2 * n) & 15), Dr(count & 0xFFFF));
        bus.put(BKP.dr((2 * n + 1) & 15), Dr(count >> 16));
    }
    bus.put(BKP.dr(9), Dr(check(counts).into()));
    bus.put(BKP.dr(8), Dr(STANDING.into()));
}

/// Invalidates the stored counts: the monitor moves.
pub fn forget(bus: &impl Bus) {
    bus.put(BKP.dr(8), Dr(0));
}

fn check(counts: &[i32; 4]) -> u16 {
    let sum =
        counts.iter().fold(0x5EED, |sum: u32, count| sum.rotate_left(5) ^ count.cast_unsigned());
    (sum ^ sum >> 16) as u16
}
