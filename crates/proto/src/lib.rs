//! The wire protocol of robotic fire monitors: bytes ⇄ link frame ⇄ records ⇄ [`Request`] / [`Answer`].
//!
//! ```text
//! bytes → link::Decoder → Frame → record::Records → Record → Request::decode / Answer::decode
//! bytes ← link::encode  ← Frame ← record::Writer  ← Record ← Request::encode / Answer::encode
//! ```
//!
//! Everything on the wire is little-endian and packed. Identifiers are hashes of names (§1):
//! unknown ones survive decoding as they came. The crate has no allocator, no I/O, no clock and
//! no path that panics; `docs/protocol.md` describes the protocol section by section.
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

pub mod answer;
pub mod asked;
pub mod bus;
pub mod crash;
pub mod crc;
pub mod dictionary;
mod error;
pub mod flags;
pub mod hash;
pub mod id;
mod ints;
pub mod link;
pub mod param;
pub mod record;
pub mod request;
pub mod status;
pub mod text;
pub mod update;

pub use answer::Answer;
pub use asked::Asked;
pub use error::{DecodeError, Expected};
pub use id::{ParamId, RequestId, Status, SubsystemId};
pub use ints::{Bytes, Ints};
pub use record::Record;
pub use request::Request;

/// The examples of the README are compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
