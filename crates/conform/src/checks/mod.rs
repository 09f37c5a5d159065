//! The tests, by what they need; the table has them in the order of execution.

pub mod bits;
mod fold;
mod limits;
mod link;
mod literal;
mod memory;
mod motion;
mod params;
mod programs;
mod reads;
mod records;
mod search;
mod service;
mod table;
mod timed;
mod update;
mod water;

use crate::Level;
use crate::bench::Bench;
use crate::verdict::Step;

pub use memory::{Erased, Kept, write_back};
pub use table::TESTS;

/// A test.
#[derive(Clone, Copy)]
pub struct Test {
    /// Item that it tests.
    pub item: &'static str,
    /// Name of the test.
    pub name: &'static str,
    /// Level that permits it.
    pub level: Level,
    /// It tests a detail of ours in an item of the document.
    pub ours: bool,
    pub run: fn(&mut Bench<'_>) -> Step,
}

/// A 16-bit number in wire order (little-endian).
pub fn le(value: i32) -> [u8; 2] {
    i16::try_from(value).unwrap_or(if value < 0 { i16::MIN } else { i16::MAX }).to_le_bytes()
}

/// 16-bit numbers in wire order (little-endian).
pub fn les(values: &[i32]) -> Vec<u8> {
    values.iter().flat_map(|value| le(*value)).collect()
}
