//! What clients receive without asking: published values, and messages.

pub mod broadcast;
pub mod messages;
pub mod topics;
