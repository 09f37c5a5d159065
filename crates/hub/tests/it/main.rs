//! Tests of the hub, in one program: it is linked once.
//!
//! Programs of their own are `safety`, which measures how soon a motion ends, `memory`, which measures
//! the memory of its process, `poll_cost`, which replaces its allocator, and `flood`, whose load would
//! delay others.

#[path = "../support/mod.rs"]
mod support;

mod cameras;
mod console;
mod description;
mod entry;
mod everywhere;
mod jets;
mod keep_out;
mod late;
mod load;
mod modbus;
mod packed;
mod plugs;
mod postgres;
mod recordings;
mod releases;
mod roles;
mod simulation;
mod state;
mod stream;
mod tune;
mod unread;
mod updates;
mod zones;
