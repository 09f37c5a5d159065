//! The bootloader of the board `mps2`: decides which slot is started, verifies its image, starts it.
//!
//! All that it decides is `lafet_update::boot`. It drives nothing: until a program has started, every output
//! is as the reset has left it.

#![no_std]
#![no_main]

use cortex_m::peripheral::{SCB, SYST};
use cortex_m_rt::{ExceptionFrame, entry, exception};
use lafet_mps2::{Flash, Watchdog, handover, software};
use lafet_plant::flash::ADDRESS;
use lafet_update::{Boot, Started, boot};

/// How many interrupts the chip has; none is switched on.
const INTERRUPTS: usize = 32;
/// What could not be read may be read after this pause: about 5 s, in longest rounds of the timer (0.67 s).
const ROUNDS: u32 = 8;
const ROUND_TICKS: u32 = 0xFF_FFFF;
const TIMER_RUNS: u32 = 0b101;
const TIMER_IS_OVER: u32 = 1 << 16;

#[entry]
fn main() -> ! {
    let watchdog = Watchdog::start();
    let mut memory = software::memory(Flash::of_chip());
    let booted = match software::board() {
        Some(board) => boot(&mut memory, &board, || watchdog.feed()),
        None => Boot::Nothing,
    };
    match booted {
        Boot::Start { slot, header, trial } => {
            assert!(!(cfg!(feature = "panics") && trial), "a test");
            handover::leave(&Started { slot, version: header.version, trial });
            watchdog.feed();
            jump(ADDRESS + memory.payload_of(slot))
        }
        Boot::Nothing => {
            for _ in 0..ROUNDS {
                watchdog.feed();
                wait_a_round();
            }
            SCB::sys_reset()
        }
    }
}

/// Starts the program whose vector table is at this address.
fn jump(vectors: u32) -> ! {
    // SAFETY: the table is that of an image that was signed for this place; nothing else runs, no interrupt is
    // switched on, and nothing of the bootloader is used any more.
    unsafe {
        (*SCB::PTR).vtor.write(vectors);
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        cortex_m::asm::bootload(vectors as *const u32)
    }
}

fn wait_a_round() {
    // SAFETY: nothing else uses the timer.
    let timer = unsafe { &*SYST::PTR };
    // SAFETY: values that the registers take.
    unsafe {
        timer.rvr.write(ROUND_TICKS);
        timer.cvr.write(0);
        timer.csr.write(TIMER_RUNS);
    }
    while timer.csr.read() & TIMER_IS_OVER == 0 {}
}

/// What cannot go on starts again: an image that leads here on trial is not tried twice.
#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    SCB::sys_reset()
}

/// The watchdog's first call, an NMI, among them.
#[exception]
unsafe fn DefaultHandler(_: i16) {
    SCB::sys_reset()
}

unsafe extern "C" {
    #[link_name = "DefaultHandler"]
    fn unexpected();
}

/// As many interrupts as the chip has.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".vector_table.interrupts")]
static __INTERRUPTS: [unsafe extern "C" fn(); INTERRUPTS] = [unexpected; INTERRUPTS];

/// The library that verifies signatures checks its indices, which `cargo xtask firmware update` lists. Were one of
/// them wrong, the board would start again, with nothing driven: a trial has been noted by then, and ends.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    SCB::sys_reset()
}
