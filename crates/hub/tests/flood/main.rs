//! Loads that a hub withstands. They take the machine, so they are not beside other tests.

#[path = "../support/mod.rs"]
mod support;

mod handshakes;
mod messages;
