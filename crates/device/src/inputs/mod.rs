//! §D/6 (ours) What is sensed is judged before it is used: subsystems see judged inputs alone.
//!
//! | what | rule | delay | shows as |
//! |---|---|---|---|
//! | a contact: end switches, valves' switches, `blocked` | counts when it has lasted ([`contacts`]), from the start on | 30 ms | the state it reports |
//! | a button that begins something: pressed, or released for the next press (`subsystem::buttons`) | counts when it has lasted | 30 ms; what ends something at once | its state, at once |
//! | a switch of Deployer against its position (`subsystem::deployer`) | neither is believed until the reset | 30 ms | InternalFault, InputFaults bit 16 |
//! | what a heater, a power stage or a drive's sensor says of itself | counts when it has lasted ([`lasted`]) | 30 ms | the fault it reports |
//! | a remote unit whose exchanges all break the protocol of its bus | counts as not online ([`units`]), until one is good | 0.1 s | ConnLost, ProtocolFault |
//! | what is sensed of a remote valve or Deployer that has just been driven | may be from before: the valve is not closed; a Deployer that is lost in this time is in between ([`units`]) | 0.2 s | the state it reports |
//! | the current loop of the pressure sensor, broken or shorted | counts when it has lasted ([`lasted`]); until then the pressure is what it was | 30 ms, at the start none | PressureSensorBreak, PressureSensorShort |
//! | water that flows though every valve says closed | no such switch is believed ([`water`]) | 3 s | CloseSensorFault, InputFaults bit 0 |
//! | a supply out of its range | what it forbids to begin | 0.3 s | BadPower, Denied from General |
//! | a detector whose spots all are as wide as its field, or that is not ready | no spot is believed (`subsystem::detector`) | at once | DeviceFault, InputFaults bit 2 of the first |
//! | a detector that was not ready | the barrel waits until that has lasted ([`lasted`]) | 30 ms | Canceled where it is missing for 1 s more than it is there |
//! | an open valve without flow and pressure | reported ([`water`]) | 10 s | InputFaults bit 1 |
//!
//! `guard` has besides, in the step in which it is sensed, every end switch that closes: it takes away and
//! ends nothing, so that a blip costs a drive a step and a true end switch stops it at once. Fault bits of a valve's
//! switches need no rule: for as long as one is on, its switch is not believed, which ends nothing either.

mod contacts;
mod units;
mod water;

pub(crate) use contacts::{Contacts, Debounce, STABLE_MS};
pub(crate) use units::{Heard, Stale};
pub(crate) use water::{FLOWING_LPS, Water};

/// Bits of the parameter InputFaults of General.
pub(crate) mod bit {
    /// Water flows though every valve is reported as closed.
    pub const WATER_UNASKED: i32 = 1;
    /// A valve is open, and there is neither flow nor pressure.
    pub const WATER_MISSING: i32 = 1 << 1;
    /// The detector's picture cannot be of fires.
    pub const SATURATED: i32 = 1 << 2;
    /// A valve was closed because no client has confirmed its water (§D/8).
    pub const UNCONFIRMED: i32 = 1 << 3;
    /// A drive has turned, or drawn current, though it was not fed: that of the first axis, the others follow.
    pub const RUNAWAY: i32 = 1 << 4;
    /// The position of a drive is not known (§D/7): that of the first axis, the others follow.
    pub const NOT_HOMED: i32 = 1 << 8;
    /// A drive rests farther from its last target than it may, as above.
    pub const MISSED: i32 = 1 << 12;
    /// A switch of Deployer has said that it is where its position says it is not.
    pub const DEPLOYER_DOUBTED: i32 = 1 << 16;
}

/// A step of what has to last for longer than a contact may blip: whether it has. `ms` says for how long it has lasted,
/// and 1; a step that is longer than any blip shows none.
pub(crate) const fn outlasts(ms: &mut u8, dt_ms: u32) -> bool {
    *ms = match *ms {
        _ if dt_ms > STABLE_MS => u8::MAX,
        0 => 1,
        before => before.saturating_add(dt_ms as u8),
    };
    *ms as u32 > STABLE_MS
}

/// Whether a fault that is sensed now has been for longer than a contact may blip; `ms` says how long it has been, or is
/// [`LASTED`]. It is gone at once: what it has ended does not go on.
#[inline(never)]
pub(crate) fn lasted(ms: &mut u8, dt_ms: u32, now: bool) -> bool {
    let dt_ms = dt_ms.min(LASTED.into()) as u8;
    *ms = if now { ms.saturating_add(dt_ms).min(LASTED) } else { 0 };
    *ms == LASTED
}

/// So long it lasts at least.
pub(crate) const LASTED: u8 = STABLE_MS as u8 + 1;

/// A condition that has to last, and to be gone for as long.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Lasting {
    ms: u16,
    /// It has lasted, and has not been gone for as long.
    pub holds: bool,
}

impl Lasting {
    /// A step in which it is the case, or not; it has to last for this long, ms.
    pub fn step(&mut self, dt_ms: u32, now: bool, limit_ms: u16) {
        let dt_ms = dt_ms.min(limit_ms.into()) as u16;
        self.ms = match now {
            true => self.ms.saturating_add(dt_ms).min(limit_ms),
            false => self.ms.saturating_sub(dt_ms),
        };
        self.holds = if self.holds { self.ms > 0 } else { self.ms >= limit_ms };
    }
}
