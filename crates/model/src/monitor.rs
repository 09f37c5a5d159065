//! What is checked: the device itself, or something that stands in its place in a test.

use crate::plant::{ADDRESS, Plant};
use lafet_device::{Composition, Device, Source};
use std::fmt::Debug;

/// A monitor as the model drives it: the three entries of [`Device`], and a way to look inside.
pub trait Monitor: Clone + Debug + Send + Sync + 'static {
    /// Switched on.
    fn power_up(now_ms: u32, composition: &Composition, plant: &mut Plant) -> Self;

    /// Answers a frame; returns the length of the answer.
    fn handle(&mut self, now_ms: u32, payload: &[u8], out: &mut [u8]) -> usize;

    /// One cycle.
    fn step(&mut self, now_ms: u32, plant: &mut Plant);

    /// The device in it.
    fn device(&self) -> &Device;

    /// What it remembers besides the device.
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
