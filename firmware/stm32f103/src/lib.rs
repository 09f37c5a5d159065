//! The board of a fire monitor on an STM32F103VC: `docs/board-stm32f103.md` is its page.
//!
//! Everything reaches the chip through [`bus::Bus`], so that the same code runs on the chip and
//! against a model of it. Section numbers of the form RM §n are those of ST's reference manual RM0008.
#![no_std]

pub mod analog;
pub mod board;
pub mod bus;
pub mod clock;
pub mod contacts;
pub mod drives;
pub mod flash;
pub mod line;
pub mod pins;
pub mod power;
pub mod record;
pub mod watchdog;

pub use board::{Memory, Stm32f103};
pub use bus::Bus;
