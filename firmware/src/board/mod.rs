//! What a board has to provide beyond the process image.

#[cfg(feature = "lm3s6965")]
mod lm3s6965;
#[cfg(feature = "stm32f103")]
mod stm32f103;

#[cfg(feature = "lm3s6965")]
pub use lm3s6965::{INTERRUPTS, Lm3s6965 as Chosen};
#[cfg(feature = "stm32f103")]
pub use stm32f103::{INTERRUPTS, Stm32f103 as Chosen};

use lafet_device::Composition;
use lafet_device::hal::Hal;

/// How the program starts.
#[derive(Clone, Copy)]
pub struct Start {
    /// The clock, ms.
    pub now_ms: u32,
    /// What the monitor is built from.
    pub composition: &'static Composition,
    /// The address it has while its memory says none.
    pub address: u8,
}

/// A board: its process image and memory, the line, the clock, the watchdog. `Hal::reset` of a board
/// does not come back.
pub trait Board: Hal {
    /// Waits until the program may begin; it may have ended with a fault before.
    fn start(&mut self, after_fault: bool) -> Start;

    /// The watchdog has ended the last run.
    fn reset_by_watchdog(&mut self) -> bool;

    /// The program has begun.
    fn started(&mut self) {}

    /// The clock, ms.
    fn now_ms(&self) -> u32;

    /// The time of the step that is due now.
    fn due(&mut self) -> Option<u32>;

    /// The step is over.
    fn stepped(&mut self) {}

    /// What has come over the line and fits.
    fn receive<'b>(&mut self, buffer: &'b mut [u8]) -> &'b [u8];

    /// Sends a byte of a frame.
    fn put(&mut self, byte: u8);

    /// Lets go of the line, when all that was sent has left.
    fn release(&mut self) {}

    /// The program is alive.
    fn feed_watchdog(&mut self);
}
