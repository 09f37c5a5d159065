//! The parts of `lafet shell`: splitting, completing and editing lines, and typing ahead.

pub mod ahead;
pub mod complete;
pub mod editor;
pub mod words;
