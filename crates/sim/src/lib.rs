//! The world around a simulated fire monitor.
//!
//! [`world::World`] implements the HAL of `lafet-device`, so the very program of the monitor runs
//! in it. [`sim::Sim`] puts the two together on virtual time: a function of seed, configuration and
//! requests, the same trace byte for byte. It is plain synchronous code; sockets live elsewhere.
//!
//! [`site::Site`] is several monitors around the same fires; [`exercise`] runs scenarios on it.
//!
//! ```text
//! drive ─┐                          ┌─ detector ── fires in its field of view
//! valve ─┤→ water → jet → fire      ├─ climate, supply
//! unit ──┘   (internal bus)         └─ flash, faults
//! ```
#![forbid(unsafe_code)]

pub mod airborne;
pub mod calibration;
#[cfg(unix)]
pub mod chip;
pub mod climate;
pub mod condition;
mod contact;
pub mod detector;
pub mod drive;
pub mod event;
pub mod exercise;
pub mod fault;
pub mod fire;
pub mod fires;
pub mod flash;
pub mod foam;
pub mod gust;
pub mod line;
pub mod obstacle;
mod power;
pub mod radio;
pub mod rng;
pub mod scenario;
mod sensor;
pub mod sim;
pub mod site;
mod software;
pub mod throw;
pub mod unit;
pub mod valve;
pub mod water;
pub mod world;

pub use lafet_ballistics::{lumps as jet, nozzle};

/// The examples of the README are compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
