//! What checks the device and the simulator, rather than being part of them.
//!
//! - [`interlock`]: what must never be driven, whatever the cause: the rules that the harnesses share;
//! - [`attribution`]: every output has a cause that holds, judged independently of the device;
//! - [`swarm`]: random lives of simulated monitors under that judgement; [`years`]: a long one;
//! - [`model`]: the interlock on every state that a request, a fault or time can lead to;
//! - [`fuzz`]: the targets of the fuzzer, linked with libFuzzer by the workspace `fuzz`;
//! - [`faults_table`], [`validation`]: tables of docs/faults.md and docs/physics.md, measured.
//!
//! The program `lafet-verify` runs them; `cargo xtask` calls it.
#![forbid(unsafe_code)]

#[cfg(feature = "sim")]
pub mod attribution;
#[cfg(feature = "sim")]
pub mod faults_table;
pub mod fuzz;
pub mod interlock;
#[cfg(feature = "model")]
pub mod model;
#[cfg(feature = "sim")]
pub mod swarm;
#[cfg(feature = "sim")]
pub mod validation;
#[cfg(feature = "sim")]
pub mod years;
