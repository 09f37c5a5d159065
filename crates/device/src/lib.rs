//! The software of a robotic fire monitor, for any board that implements [`hal::Hal`].
//!
//! Two entries: `Device::handle` answers a frame and changes state, and never touches hardware;
//! `Device::step` reads the inputs, runs the subsystems and writes the outputs, and never
//! touches the wire.
#![no_std]
#![forbid(unsafe_code)]
#![warn(clippy::missing_errors_doc)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::unreachable,
        clippy::todo
    )
)]

#[cfg(test)]
extern crate std;

mod answers;
pub mod cause;
mod chain;
pub mod composition;
mod device;
mod ear;
mod execute;
pub mod guard;
pub mod hal;
pub mod image;
mod inputs;
mod math;
pub mod params;
pub mod port;
#[cfg(feature = "update")]
mod software;
pub mod store;
pub mod subsystem;
pub mod time;

pub use cause::{Cause, Causes};
pub use chain::Way;
pub use composition::Composition;
pub use device::Device;
pub use subsystem::conn::Source;

/// The examples of the README are compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
