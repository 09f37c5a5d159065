//! Updating the software of a fire monitor (ours): signed images, two slots, a start that verifies.
//!
//! An image lies in one of two slots and is started where it lies. The running slot is never
//! written: an update is received into the other one ([`Receiver`]), verified, committed, and
//! started once, on trial. Unless it is confirmed over the link, the next start goes back
//! ([`boot()`]). The decision is a function of the record and of what verifies ([`decide`]).
//!
//! docs/update.md has the format, the reasons, and what has been tested.
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

mod boot;
mod decide;
mod hash;
mod image;
mod memory;
mod orders;
mod receive;
mod record;
mod refusal;
mod sign;

pub use boot::{Boot, boot};
pub use decide::{Decision, Verified, decide};
pub use hash::Hash;
pub use image::{
    Board, BoardName, HEADER_LEN, Header, Layouts, PublicKey, UNIT, Version, VersionError,
};
pub use memory::{Memory, Partition};
pub use receive::{HASHED_PER_POLL, Phase, Receiver, Report, Started};
pub use record::{Other, Record, Recorded, Slot};
pub use refusal::Refusal;
pub use sign::SigningKey;

/// The examples of the README are compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
