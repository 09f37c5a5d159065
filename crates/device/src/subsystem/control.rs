//! Placeholder.
use super::Env;
use crate::time::Millis;
use lafet_proto::{
    Status,
    flags::ControlFlags,
    request::{Quench, Trajectory},
};
/// Control
#[derive(Clone, Debug, Default)]
pub struct Control;
impl Control {
    pub(crate) fn start_quench(&mut self, _q: &Quench<'_>, _e: &Env<'_>) -> Status {
        Status::UNIMPLEMENTED
    }
    pub(crate) fn start_trajectory(&mut self, _q: &Trajectory<'_>, _e: &Env<'_>) -> Status {
        Status::UNIMPLEMENTED
    }
    pub(crate) fn stop(&mut self) {}
    pub(crate) fn is_active(&self) -> bool {
        false
    }
    pub(crate) fn note_manual(&mut self, _n: Millis) {}
    pub(crate) fn step(&mut self, _n: Millis, _e: &mut Env<'_>) {}
    pub(crate) fn flags(&self) -> ControlFlags {
        ControlFlags::empty()
    }
}
