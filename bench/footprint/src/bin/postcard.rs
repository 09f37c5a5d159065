//! postcard with COBS, without a checksum.
#![no_std]
#![no_main]

use core::hint::black_box;

use postcard::accumulator::{CobsAccumulator, FeedResult};
use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Drive {
    request: u8,
    device: u8,
    status: u8,
    flags: u32,
    position: i16,
    current: u8,
    speed: u8,
}

static mut FRAMES: CobsAccumulator<256> = CobsAccumulator::new();

#[cortex_m_rt::entry]
fn main() -> ! {
    lafet_bench_footprint::measure(message)
}

fn message() -> bool {
    let (flags, position) = (black_box(0x41_0000), black_box(1200));
    let drive =
        Drive { request: 0xD4, device: 13, status: 0, flags, position, current: 21, speed: 9 };
    let mut wire = [0; 48];
    let Ok(sent) = postcard::to_slice_cobs(&drive, &mut wire) else { return false };
    // SAFETY: nothing else uses it; there is one thread, and no interrupt.
    let frames = unsafe { &mut *(&raw mut FRAMES) };
    match frames.feed::<Drive>(black_box(sent)) {
        FeedResult::Success { data, .. } => black_box(data) == drive,
        _ => false,
    }
}
