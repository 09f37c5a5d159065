//! What a fault leaves for GetCrashData (§3.20): kept in memory that no start clears.

use crate::board::{HANDLERS, INTERRUPTS};
use crate::register::Register;
use core::arch::naked_asm;
use core::hint::black_box;
use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;
use cortex_m_rt::{ExceptionFrame, exception};
use lafet_proto::status::FaultInfo;

/// Marks the record as written (ours).
const SIGNATURE: u32 = 0xDEAD_FA11;
/// Cortex-M3 (ours).
const ARCHITECTURE: u32 = 3;

const CFSR: Register = Register::at(0xE000_ED28);
const HFSR: Register = Register::at(0xE000_ED2C);
const MMFAR: Register = Register::at(0xE000_ED34);
const BFAR: Register = Register::at(0xE000_ED38);

#[unsafe(link_section = ".uninit.crash")]
static mut RECORD: MaybeUninit<[u32; 20]> = MaybeUninit::uninit();

/// The exception of the clock's watch, also recorded for a crystal that was dead from the start (ours).
const NMI: u32 = 2;

/// The record of the fault that has led to this start; it counts once.
pub fn take(by_watchdog: bool, by_crystal: bool) -> Option<FaultInfo> {
    // What is there is from before the start: the compiler must not take it for nothing.
    let record = black_box(addr_of_mut!(RECORD).cast::<[u32; 20]>());
    // SAFETY: any bits are words, and nothing else has the record now.
    let record = unsafe { &mut *record };
    let mut words = core::mem::take(record);
    if words[0] != SIGNATURE {
        if !by_watchdog && !by_crystal {
            return None;
        }
        // It was beyond recording: the stack was gone, or interrupts were off.
        words = [0; 20];
        [words[0], words[1]] = [SIGNATURE, ARCHITECTURE];
        words[19] = if by_watchdog { 0 } else { NMI };
    }
    Some(FaultInfo::from_words(words))
}

/// Records where the program was, and starts again: outputs fall to rest with the reset.
fn record(frame: &ExceptionFrame) -> ! {
    // SAFETY: nothing else runs any more.
    let place = unsafe { &mut *addr_of_mut!(RECORD) };
    // Word by word to where they stay: the stack may be nearly full.
    place.write([
        SIGNATURE,
        ARCHITECTURE,
        core::ptr::from_ref(frame) as usize as u32,
        frame.r0(),
        frame.r1(),
        frame.r2(),
        frame.r3(),
        frame.r12(),
        frame.lr(),
        frame.pc(),
        0,
        0,
        0,
        0,
        HFSR.read(),
        BFAR.read(),
        MMFAR.read(),
        CFSR.read(),
        0,
        frame.xpsr(),
    ]);
    cortex_m::asm::dsb();
    cortex_m::peripheral::SCB::sys_reset()
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    record(frame)
}

/// Any interrupt that has no handler of its own; that of the watchdog is one.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn DefaultHandler() {
    naked_asm!("mrs r0, msp", "b {record}", record = sym unexpected)
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

unsafe extern "C" fn unexpected(frame: &ExceptionFrame) -> ! {
    record(frame)
}
