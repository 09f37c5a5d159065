//! Registers by their address.

/// A register of a peripheral.
#[derive(Clone, Copy)]
pub struct Register(*mut u32);

impl Register {
    /// The register at this address, which must be one of the chip's.
    pub const fn at(address: usize) -> Self {
        Self(address as *mut u32)
    }

    pub fn read(self) -> u32 {
        // SAFETY: the address is a register's, always readable.
        unsafe { self.0.read_volatile() }
    }

    #[cfg(feature = "emulated")]
    pub fn write(self, value: u32) {
        // SAFETY: the address is a register's, always writable.
        unsafe { self.0.write_volatile(value) }
    }
}
