//! How deep the stack has been: it is painted at the start, and the paint that is left is counted.

use core::ptr::addr_of;

const PAINT: u32 = 0x5AC7_5AC7;
/// The frames of `paint` itself and of who called it, in words.
const OWN: usize = 32;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Paints what is free of the stack.
pub fn paint() {
    let mut place = addr_of!(_stack_end).cast_mut();
    let top = cortex_m::register::msp::read() as usize;
    while (place as usize) < top.saturating_sub(4 * OWN) {
        // SAFETY: inside the stack's memory, below everything that is in use.
        unsafe {
            place.write_volatile(PAINT);
            place = place.add(1);
        }
    }
}

/// Bytes used at most since then.
pub fn deepest() -> u32 {
    let (mut place, top) = (addr_of!(_stack_end), addr_of!(_stack_start) as usize);
    // SAFETY: inside the stack's memory.
    while (place as usize) < top && unsafe { place.read_volatile() } == PAINT {
        place = place.wrapping_add(1);
    }
    (top - place as usize) as u32
}
