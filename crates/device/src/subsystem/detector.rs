//! Placeholder.
use super::Env;
use crate::time::Millis;
use lafet_proto::{Status, flags::DetectorFlags, request::Seek, status::Hotbed};
/// Detector
#[derive(Clone, Debug, Default)]
pub struct Detector;
impl Detector {
    pub(crate) fn start_seek(&mut self, _q: &Seek, _e: &Env<'_>) -> Status {
        Status::UNIMPLEMENTED
    }
    pub(crate) fn start_justify(&mut self, _e: &Env<'_>) -> Status {
        Status::UNIMPLEMENTED
    }
    pub(crate) fn stop(&mut self) {}
    pub(crate) fn is_searching(&self) -> bool {
        false
    }
    pub(crate) fn is_justifying(&self) -> bool {
        false
    }
    pub(crate) fn step(&mut self, _n: Millis, _e: &mut Env<'_>) {}
    pub(crate) fn flags(&self) -> DetectorFlags {
        DetectorFlags::empty()
    }
    pub(crate) fn hotbeds(&self) -> &[Hotbed] {
        &[]
    }
}
