//! The parts of `lafet shell`: splitting, completing and editing lines, and typing ahead, before
//! it is connected too.

pub mod ahead;
pub mod complete;
pub mod editor;
pub mod opening;
pub mod words;
