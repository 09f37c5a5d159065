//! Words of the chip by their address.

/// The word at this address.
pub(crate) fn read(address: usize) -> u32 {
    // SAFETY: the callers name registers and memory of the chip, always readable.
    unsafe { (address as *const u32).read_volatile() }
}

/// Writes the word at this address.
pub(crate) fn write(address: usize, value: u32) {
    // SAFETY: the callers name registers of the chip and memory that nothing else has.
    unsafe { (address as *mut u32).write_volatile(value) }
}
