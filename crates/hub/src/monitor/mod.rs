//! The monitors: their links, states, programs and what is published of them.

mod described;
pub mod link_series;
pub mod owner;
pub mod program;
pub mod station;
pub mod status;
pub mod stored;
mod summary;
pub mod view;
