//! The board `mps2`, QEMU's mps2-an385 with a Cortex-M3: what its bootloader and the program in each slot
//! share.
//!
//! The 16 MiB at 0x2100_0000 are a file of the host and so outlive power: they are the flash. The bootloader
//! is at 0, where the processor starts.
#![cfg_attr(not(test), no_std)]

pub mod flash;
pub mod handover;
pub mod lamp;
mod register;
pub mod software;
pub mod uart;
pub mod watchdog;

pub use flash::{Flash, Psram};
pub use lamp::Lamp;
pub use uart::Uart;
pub use watchdog::Watchdog;
