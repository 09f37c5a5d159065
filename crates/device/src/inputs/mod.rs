//! §D/6 (ours) What is sensed is judged before it is used: subsystems see judged inputs alone.
//!
//! | what | rule | delay | shows as |
//! |---|---|---|---|
//! | a contact: end switches, valves' switches, `blocked` | counts when it has lasted ([`contacts`]) | 30 ms | the state it reports |
//! | water that flows though every valve says closed | no such switch is believed ([`water`]) | 3 s | CloseSensorFault, InputFaults bit 0 |
//! | an open valve without flow and pressure | reported ([`water`]) | 10 s | InputFaults bit 1 |
//!
//! `guard` has besides, in the step in which it is sensed, every end switch that closes: it takes away and
//! ends nothing, so that a blip costs a drive a step and a true end switch stops it at once.

mod contacts;
mod water;

pub(crate) use contacts::{Contacts, Debounce};
pub(crate) use water::{FLOWING_LPS, Water};

/// Bits of the parameter InputFaults of General.
pub(crate) mod bit {
    /// Water flows though every valve is reported as closed.
    pub const WATER_UNASKED: i32 = 1;
    /// A valve is open, and there is neither flow nor pressure.
    pub const WATER_MISSING: i32 = 1 << 1;
    /// A drive has turned though it was not fed: that of the first axis, the others follow.
    pub const RUNAWAY: i32 = 1 << 4;
}
