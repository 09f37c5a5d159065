//! The system under check: the device itself, or a test's replacement of it.

use crate::model::plant::{ADDRESS, Plant};
use lafet_device::{Composition, Device, Source};
use std::fmt::Debug;

/// A monitor as the model drives it: the three entry points of [`Device`], and access to its state.
pub trait Monitor: Clone + Debug + Send + Sync + 'static {
    /// Switches the monitor on.
    fn power_up(now_ms: u32, composition: &Composition, plant: &mut Plant) -> Self;

    /// Answers a frame; returns the length of the answer.
    fn handle(&mut self, now_ms: u32, payload: &[u8], out: &mut [u8]) -> usize;

    /// Runs one cycle.
    fn step(&mut self, now_ms: u32, plant: &mut Plant);

    /// The device inside.
    fn device(&self) -> &Device;

    /// State besides the device.
    fn extra(&self) -> u32 {
        0
    }
}

impl Monitor for Device {
    fn power_up(now_ms: u32, composition: &Composition, plant: &mut Plant) -> Self {
        Self::power_up(now_ms, composition, ADDRESS, None, plant)
    }

    fn handle(&mut self, now_ms: u32, payload: &[u8], out: &mut [u8]) -> usize {
        Self::handle(self, now_ms, Source::ExternalConn, payload, out)
    }

    fn step(&mut self, now_ms: u32, plant: &mut Plant) {
        Self::step(self, now_ms, plant);
    }

    fn device(&self) -> &Device {
        self
    }
}
