//! What a fault leaves for GetCrashData (§3.20): kept in memory that no start clears.

use crate::board::{HANDLERS, INTERRUPTS};
use crate::register::Register;
use core::arch::naked_asm;
use core::hint::black_box;
use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;
use cortex_m_rt::{ExceptionFrame, exception};
use lafet_proto::status::FaultInfo;
use lafet_turn::fault::{self, Words};

const CFSR: Register = Register::at(0xE000_ED28);
const HFSR: Register = Register::at(0xE000_ED2C);
const MMFAR: Register = Register::at(0xE000_ED34);
const BFAR: Register = Register::at(0xE000_ED38);

#[unsafe(link_section = ".uninit.crash")]
static mut RECORD: MaybeUninit<Words> = MaybeUninit::uninit();

/// The record of the fault that has led to this start; it counts once.
pub fn take(by_watchdog: bool, by_crystal: bool) -> Option<FaultInfo> {
    // What is there is from before the start: the compiler must not take it for nothing.
    let record = black_box(addr_of_mut!(RECORD).cast::<Words>());
    // SAFETY: any bits are words, and nothing else has the record now.
    fault::take(unsafe { &mut *record }, by_watchdog, by_crystal)
}

/// Records where the program was, and starts again: outputs fall to rest with the reset.
fn record(frame: &ExceptionFrame, status: u32) -> ! {
    // SAFETY: nothing else runs any more.
    let place = unsafe { &mut *addr_of_mut!(RECORD) };
    let [r0, r1, r2, r3] = [frame.r0(), frame.r1(), frame.r2(), frame.r3()];
    let stacked = [r0, r1, r2, r3, frame.r12(), frame.lr(), frame.pc(), status];
    let causes = [HFSR.read(), BFAR.read(), MMFAR.read(), CFSR.read()];
    place.write(fault::words(core::ptr::from_ref(frame) as usize as u32, stacked, causes));
    cortex_m::asm::dsb();
    cortex_m::peripheral::SCB::sys_reset()
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    record(frame, frame.xpsr())
}

/// Any exception that has no handler of its own: an interrupt, as that of the watchdog, or the NMI of a crystal
/// that has failed.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn DefaultHandler() {
    naked_asm!("mrs r0, msp", "mrs r1, ipsr", "b {record}", record = sym unexpected)
}

/// As many interrupts as the chip has; cortex-m-rt would provide for the 240 that a Cortex-M3 can have.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".vector_table.interrupts")]
static __INTERRUPTS: [unsafe extern "C" fn(); INTERRUPTS] = interrupts();

const fn interrupts() -> [unsafe extern "C" fn(); INTERRUPTS] {
    let mut vectors: [unsafe extern "C" fn(); INTERRUPTS] = [DefaultHandler; INTERRUPTS];
    let mut rest = HANDLERS.as_slice();
    while let [(number, handler), others @ ..] = rest {
        vectors[*number] = *handler;
        rest = others;
    }
    vectors
}

unsafe extern "C" fn unexpected(frame: &ExceptionFrame, active: u32) -> ! {
    record(frame, fault::status(frame.xpsr(), active))
}
