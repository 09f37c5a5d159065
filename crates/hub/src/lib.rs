//! The hub: stub.

pub mod access;
pub mod authority;
pub mod beats;
pub mod clock;
pub mod config;
pub mod model;
pub mod store;
mod sync;
pub mod text;
pub mod topics;
