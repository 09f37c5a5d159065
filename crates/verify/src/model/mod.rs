//! The interlock of the monitor — deployment, search, extinguishing, lockout, limits, valves —
//! model-checked on the very functions that the firmware links.
//!
//! A state is a real [`lafet_device::Device`] in a small plant; an action is a request, a period of
//! time, a button, a fault or a loss of power. There is no second description of the device: the
//! laws are judged by outputs and answers. `docs/model.md` says what the abstraction can miss.

pub mod ask;
pub mod configuration;
pub mod fingerprint;
pub mod interlock;
pub mod law;
pub mod mandate;
pub mod monitor;
pub mod plant;
pub mod report;
pub mod view;
pub mod witness;
pub mod world;
