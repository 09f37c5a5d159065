//! The subsystems of §1, a file each, named after the status structures of §3.3.
//!
//! A subsystem answers requests (called by `chain`) and runs in time (`step`); it sees the
//! inputs and says what it wants of the outputs, which pass `guard` before they reach the HAL.

mod arrival;
pub mod buttons;
pub mod climatics;
pub mod conn;
pub mod control;
pub mod deployer;
pub mod detector;
pub mod drive;
pub mod general;
mod homing;
pub mod remote;
pub mod valve;
mod watch;

use crate::image::{AXES, Axis, Inputs};
use crate::params::Params;
use drive::Drive;

/// What Control and Detector see and use of the rest of the monitor.
pub(crate) struct Env<'a> {
    pub inputs: &'a Inputs,
    pub params: &'a mut Params,
    pub drives: &'a mut [Drive; AXES],
    /// In working position, or there is no Deployer.
    pub deployed: bool,
    /// Deployment was asked for and has ended without reaching the working position.
    pub deploy_failed: bool,
    /// Time since the last step, ms.
    pub dt_ms: u32,
    /// Pressure, 0.1 atm; `None` when its sensor is faulty.
    pub pressure_datm: Option<u16>,
}

impl Env<'_> {
    /// A drive by its axis.
    pub fn drive(&mut self, axis: Axis) -> &mut Drive {
        by_axis(self.drives, axis)
    }
}

/// A drive by its axis, without an index that could be wrong.
pub(crate) fn by_axis<T>(all: &mut [T; AXES], axis: Axis) -> &mut T {
    let [first, others @ ..] = all;
    match others.get_mut((axis as usize).wrapping_sub(1)) {
        Some(other) => other,
        None => first,
    }
}

/// What belongs to an axis, without an index that could be wrong.
pub(crate) fn of_axis<T>(all: &[T; AXES], axis: Axis) -> &T {
    let [first, ..] = all;
    all.get(axis as usize).unwrap_or(first)
}
