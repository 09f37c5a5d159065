//! The parts of `lafet shell`: how lines are taken apart, completed, edited, and typed ahead.

pub mod ahead;
pub mod complete;
pub mod editor;
pub mod words;
