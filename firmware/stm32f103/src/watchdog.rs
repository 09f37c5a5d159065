//! The independent watchdog: a second without a finished step resets the chip (RM §19).

use crate::bus::{Bus, Registers};
use stm32_metapac::iwdg::regs::{Kr, Sr};
use stm32_metapac::iwdg::vals::Pr;
use stm32_metapac::{IWDG, RCC};

/// RM §19.4.1
const UNLOCK: u32 = 0x5555;
const RELOAD: u32 = 0xAAAA;
const START: u32 = 0xCCCC;
/// 40 kHz / 64 are 625 Hz; the oscillator may be at 30 to 60 kHz, so it is 0.67 to 1.33 s.
const TICKS: u16 = 625;
const LSI_LOOKS: u32 = 10_000;
/// Looks until new values must be in use, a ms or more: five cycles of the oscillator are 167 µs at most
/// (RM §19.4.4).
const UPDATE_LOOKS: u32 = 10_000;

/// Starts it; nothing but a reset ends it.
pub fn start(bus: &impl Bus) {
    // Its registers take new values with the clock it runs on.
    bus.change(RCC.csr(), |csr| csr.set_lsion(true));
    bus.wait(RCC.csr(), LSI_LOOKS, |csr| csr.lsirdy());
    // RM §19.3.2: any other key protects the two registers again, so they come before the start.
    bus.put(IWDG.kr(), Kr(UNLOCK));
    bus.set(IWDG.pr(), |pr| pr.set_pr(Pr::DIVIDE_BY64));
    bus.set(IWDG.rlr(), |rlr| rlr.set_rl(TICKS));
    // A reload before that takes the old value: 6.5 s until the first finished step. One that never ends is
    // no reason to have no watchdog.
    bus.wait(IWDG.sr(), UPDATE_LOOKS, |Sr(updating)| updating == 0);
    // RM §19.3: it starts at its greatest value.
    bus.put(IWDG.kr(), Kr(START));
    bus.put(IWDG.kr(), Kr(RELOAD));
}

/// A step is finished.
pub fn feed(bus: &impl Bus) {
    bus.put(IWDG.kr(), Kr(RELOAD));
}

/// Whether it was what ended the last run; the flags are cleared (RM §7.3.10).
pub fn has_bitten(bus: &impl Bus) -> bool {
    let bitten = bus.get(RCC.csr()).iwdgrstf();
    bus.change(RCC.csr(), |csr| csr.set_rmvf(true));
    bitten
}
