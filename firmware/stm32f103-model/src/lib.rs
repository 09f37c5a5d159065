//! A model of the STM32F103VC and of what is wired to it, on the host: the board's own program runs in
//! it, against the plant of the simulator.
//!
//! The chip is modelled by its reference manual (RM0008; RM §n is a section of it), with numbers of its
//! own and nothing of the program's: [`chip`]. The wires are those of `docs/board-stm32f103.md`:
//! [`plant`]. [`settings`] reads what the factory knows of a board; [`rig`] runs the program, [`inspect`] looks whether a board is as it should be, and
//! [`wrong`] has boards that are not.

pub mod chip;
pub mod image;
pub mod inspect;
pub mod plant;
pub mod rig;
pub mod settings;
pub mod wrong;
