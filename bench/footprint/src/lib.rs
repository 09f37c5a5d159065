//! Counts the instructions of a message on the emulated chip, where one instruction takes one
//! nanosecond (`-icount shift=0`), and prints them through semihosting.
#![no_std]

#[cfg(feature = "lafet")]
pub mod lafet;

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_semihosting::{debug, hprintln};

/// Messages that are measured.
const MESSAGES: u32 = 1_000;
/// Turns of a loop of two instructions, against which the timer is held.
const TURNS: u32 = 1_000_000;
const RELOAD: u32 = 0x00FF_FFFF;

/// Sends and receives messages; ends the program with what it has counted.
pub fn measure(mut message: impl FnMut() -> bool) -> ! {
    let mut timer = cortex_m::Peripherals::take().map(|peripherals| peripherals.SYST);
    let Some(timer) = &mut timer else { exit(false) };
    let empty = ticks(timer, || turn(TURNS));
    let mut good = 0;
    let taken = ticks(timer, || good = (0..MESSAGES).filter(|_| message()).count() as u32);
    let instructions = u64::from(taken) * u64::from(2 * TURNS) / u64::from(empty.max(1));
    hprintln!("{}", instructions / u64::from(MESSAGES));
    exit(good == MESSAGES)
}

fn ticks(timer: &mut SYST, run: impl FnOnce()) -> u32 {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(RELOAD);
    timer.clear_current();
    timer.enable_counter();
    run();
    let left = SYST::get_current();
    timer.disable_counter();
    RELOAD - left
}

#[inline(never)]
fn turn(mut times: u32) {
    while times > 0 {
        // SAFETY: counts a register down.
        unsafe {
            core::arch::asm!("1:", "subs {0}, {0}, #1", "bne 1b", inout(reg) times);
        }
    }
}

fn exit(good: bool) -> ! {
    debug::exit(if good { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    #[allow(clippy::empty_loop, reason = "the emulator has ended")]
    loop {}
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(false)
}
