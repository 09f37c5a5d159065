//! What the measurement takes itself.
#![no_std]
#![no_main]

#[cortex_m_rt::entry]
fn main() -> ! {
    lafet_bench_footprint::measure(|| core::hint::black_box(true))
}
