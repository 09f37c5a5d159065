//! The record of a fault for GetCrashData (§3.20), the same on every Cortex-M3 and on a model of one.

use lafet_device::hal::FaultInfo;

/// Its words.
pub type Words = [u32; 20];

/// Marks a record as written (ours).
const SIGNATURE: u32 = 0xDEAD_FA11;
/// Cortex-M3 (ours).
const ARCHITECTURE: u32 = 3;
/// The exception's number in the last word, the program status.
const NUMBER: u32 = 0x1FF;
/// The exception of the clock's watch, also recorded for a crystal that was dead from the start (ours).
pub const NMI: u32 = 2;

/// The record of a fault: where the stack was, what the processor has stacked there (r0 to r3, r12, lr, pc,
/// status), and hfsr, bfar, mmfar, cfsr. The status says what was interrupted.
// Inlined, so that each word goes where it stays: the stack may be nearly full.
#[inline(always)]
pub fn words(stack: u32, stacked: [u32; 8], [hfsr, bfar, mmfar, cfsr]: [u32; 4]) -> Words {
    let [r0, r1, r2, r3, r12, lr, pc, status] = stacked;
    [
        SIGNATURE,
        ARCHITECTURE,
        stack,
        r0,
        r1,
        r2,
        r3,
        r12,
        lr,
        pc,
        0,
        0,
        0,
        0,
        hfsr,
        bfar,
        mmfar,
        cfsr,
        0,
        status,
    ]
}

/// The status for an exception that is itself what went wrong: with its number, not that of the program or
/// handler that it interrupted.
#[inline(always)]
pub const fn status(stacked: u32, active: u32) -> u32 {
    stacked & !NUMBER | active & NUMBER
}

/// The record of the fault that has led to this start; it counts once.
#[inline(always)]
pub fn take(record: &mut Words, by_watchdog: bool, by_crystal: bool) -> Option<FaultInfo> {
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
