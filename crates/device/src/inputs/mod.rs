//! §D/6 (ours) What is sensed is judged before it is used: subsystems see judged inputs alone.
//!
//! | what | rule | delay | shows as |
//! |---|---|---|---|
//! | a contact: end switches, valves' switches, `blocked` | counts when it has lasted ([`contacts`]) | 30 ms | the state it reports |
//!
//! `guard` has besides, in the step in which it is sensed, every end switch that closes: it takes away and
//! ends nothing, so that a blip costs a drive a step and a true end switch stops it at once.

mod contacts;

pub(crate) use contacts::{Contacts, Debounce};
