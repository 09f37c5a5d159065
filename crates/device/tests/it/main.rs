//! Tests of the device, in one program: it is linked once.
//!
//! Programs of their own are `every_request`, `stops` and `store`: they are long, use all cores by
//! themselves, and `cargo xtask stops`, `cuts`, `coverage` and `mutants` run each alone.

#[path = "../common/mod.rs"]
mod common;

mod buttons;
mod causes;
mod configuration;
mod confirm;
mod contacts;
mod deployer;
mod drive;
mod general;
mod guard;
mod half_way;
mod homing;
mod lost;
mod params;
mod remote;
mod requests;
mod room;
mod runaway;
mod speed;
mod takeover;
mod valve;
mod watch;
mod water;
