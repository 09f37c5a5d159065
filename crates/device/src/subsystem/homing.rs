//! §D/7 (ours) A position sensor that counts from where it was switched on: until its drive has been at an end
//! switch, nothing relies on its position.
//!
//! ```text
//!  on the switch ──leaves it by 1° or 1 mm──▶ off the switch ──the switch closes on the way there──▶ known
//! ```
//! Until then the drive has no limits (§3.17, `Limitless`), goes slowly, and no program has it. Nothing moves
//! by itself: who moves it to that end homes it.

use crate::composition::DriveKind;
use crate::image::{Axis, DriveInput};
use crate::params::Params;
use lafet_proto::param::Param;

/// A drive whose position is not known goes no faster, 0.1 °/s or 0.1 mm/s.
pub(crate) const HOMING_TENTHS: i32 = 30;
/// A drive that starts on its switch has left it after this way, ' or mm: a contact that opens by itself for a
/// moment is no way.
const LEFT_ARCMIN: u32 = 60;
const LEFT_MM: u32 = 1;

/// Where the position of a drive comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Homing {
    /// At which end it is homed: up/left (true) or down/right; `None` when the position is known.
    end: Option<bool>,
    /// It has to be homed, or has been.
    used: bool,
    /// It has started off the switch there, or has left it.
    left: bool,
    /// Reading when the inputs have settled.
    start: i32,
    /// What is added to each reading since it is known.
    offset: i32,
}

impl Homing {
    /// After a reset. A remote unit homes its drive itself, and a drive of limit switches has no position.
    pub fn starting(axis: Axis, kind: DriveKind, params: &Params) -> Self {
        let end = match of_axis(axis).map(|(homing, _)| params.get(homing)) {
            Some(1) if kind == DriveKind::Encoder => Some(false),
            Some(2) if kind == DriveKind::Encoder => Some(true),
            _ => None,
        };
        Self { end, used: end.is_some(), left: true, ..Self::default() }
    }

    /// Nothing moves while the inputs settle: where the drive is then, and that its switch counts as closed, is its start.
    pub fn note_start(&mut self, input: &DriveInput) {
        self.left &= !self.end.is_some_and(|up| is_closed(up, input));
        self.start = input.position;
    }

    /// The position can be relied on.
    pub const fn is_known(self) -> bool {
        self.end.is_none()
    }

    /// Its sensor need not know where it counts from.
    pub const fn is_used(self) -> bool {
        self.used
    }

    /// What is to be added to a reading.
    pub const fn offset(self) -> i32 {
        self.offset
    }

    /// A step of a drive that is driven up/left (true), down/right or not at all.
    pub fn step(&mut self, axis: Axis, way: Option<bool>, input: &DriveInput, params: &Params) {
        let (Some(up), Some((_, home))) = (self.end, of_axis(axis)) else { return };
        let far = if axis == Axis::Nozzle { LEFT_MM } else { LEFT_ARCMIN };
        let closed = is_closed(up, input);
        self.left |= !closed && input.position.abs_diff(self.start) >= far;
        // Both ends at a time are none.
        if closed && !is_closed(!up, input) && self.left && way == Some(up) {
            self.offset = params.get(home).saturating_sub(input.position);
            self.end = None;
        }
    }
}

/// The switch there, judged (§D/6).
const fn is_closed(up: bool, input: &DriveInput) -> bool {
    if up { input.max_switch } else { input.min_switch }
}

/// Homing and HomePosition. Deployment ends at its switches, whatever the position (§3.10).
const fn of_axis(axis: Axis) -> Option<(Param, Param)> {
    match axis {
        Axis::Vertical => Some((Param::VerticalHoming, Param::VerticalHomePosition)),
        Axis::Horizontal => Some((Param::HorizontalHoming, Param::HorizontalHomePosition)),
        Axis::Nozzle => Some((Param::NozzleHoming, Param::NozzleHomePosition)),
        Axis::Deployer => None,
    }
}
