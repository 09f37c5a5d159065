//! The tests, by what they need; the table is in the order in which they run.

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
mod water;

use crate::Level;
use crate::bench::Bench;
use crate::verdict::Step;

pub use memory::Erased;
pub use table::TESTS;

/// A test.
#[derive(Clone, Copy)]
pub struct Test {
    /// The item that it tests.
    pub item: &'static str,
    /// Its own name.
    pub name: &'static str,
    /// What it needs to be allowed.
    pub level: Level,
    /// It asks for a detail of ours in an item that is the document's.
    pub ours: bool,
    pub run: fn(&mut Bench<'_>) -> Step,
}

/// A number as it travels.
pub fn le(value: i32) -> [u8; 2] {
    i16::try_from(value).unwrap_or(if value < 0 { i16::MIN } else { i16::MAX }).to_le_bytes()
}

/// Numbers as they travel.
pub fn les(values: &[i32]) -> Vec<u8> {
    values.iter().flat_map(|value| le(*value)).collect()
}
