//! The supply of the chip, and the registers that a battery keeps over its absence (RM §5, §6).

use crate::bus::{Bus, Registers, address};
use crate::record;
use stm32_metapac::{BKP, PWR};

/// RM §5.4.1: 2.9 V.
const LEVEL: u8 = 0b111;
/// Marks the positions as those of a monitor at rest.
const STANDING: u32 = 0x57A9;
/// The registers: two for each count, the lower half first; then the mark and the check.
const MARK: u32 = 8;
const CHECK: u32 = 9;

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
/// order, when the battery was empty, and when they were kept under another record.
pub fn kept(bus: &impl Bus) -> Option<[i32; 4]> {
    let half = |n: u32| bus.read(place(n)) & 0xFFFF;
    let counts = [0, 2, 4, 6].map(|n| (half(n) | half(n + 1) << 16).cast_signed());
    (half(MARK) == STANDING && half(CHECK) == check(bus, &counts)).then_some(counts)
}

/// Stores the counts: the monitor is at rest.
pub fn keep(bus: &impl Bus, counts: &[i32; 4]) {
    for (n, count) in (0..).step_by(2).zip(counts) {
        let count = count.cast_unsigned();
        bus.write(place(n), count & 0xFFFF);
        bus.write(place(n + 1), count >> 16);
    }
    bus.write(place(CHECK), check(bus, counts));
    bus.write(place(MARK), STANDING);
}

/// Invalidates the stored counts: the monitor moves.
pub fn forget(bus: &impl Bus) {
    bus.write(place(MARK), 0);
}

/// RM §6.4: the first ten registers stand one behind another.
fn place(n: u32) -> u32 {
    address(BKP.dr(0)) + 4 * n
}

/// Of the counts, and of the record: in another scale they mean another position.
fn check(bus: &impl Bus, counts: &[i32; 4]) -> u32 {
    let sum = counts
        .iter()
        .fold(bus.read(record::CRC), |sum, count| sum.rotate_left(5) ^ count.cast_unsigned());
    (sum ^ sum >> 16) & 0xFFFF
}
