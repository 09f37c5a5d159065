//! The boards: what `lafet_turn::Board` asks for, on the chip.

#[cfg(feature = "emulated")]
mod emulated;
#[cfg(feature = "lm3s6965")]
mod lm3s6965;
#[cfg(feature = "mps2")]
mod mps2;
#[cfg(feature = "stm32f103")]
mod stm32f103;

#[cfg(feature = "lm3s6965")]
pub use lm3s6965::{HANDLERS, INTERRUPTS, start};
#[cfg(feature = "mps2")]
pub use mps2::{HANDLERS, INTERRUPTS, start};
#[cfg(feature = "stm32f103")]
pub use stm32f103::{HANDLERS, INTERRUPTS, start};

/// The handler of an interrupt, by its number.
pub type Handler = (usize, unsafe extern "C" fn());
