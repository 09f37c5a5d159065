//! Time passes over rest: the same as step by step, and much faster.

use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::{Inputs, Outputs};

use super::Sim;
use crate::world::STEP_MS;

/// Steps made one by one before it is looked again whether all rests: one, then ever more.
const BUSY_STEPS: u64 = 32;
/// How far ahead a monitor is asked whether it rests, in steps: an hour, ten seconds, one.
const SPANS: [u64; 3] = [360_000, 1_000, 100];

impl Sim {
    /// Moves time as [`Self::advance_ms`] does, to the very same state, but passes over times in
    /// which neither the world nor the monitor changes.
    ///
    /// The monitor rests when a step now and a step at the end of the time, with the inputs as
    /// they are, leave it as it is and drive the same: what waits for a moment in between would
    /// have come by the end. With a trace to keep, every step is made.
    pub fn pass_ms(&mut self, ms: u64) {
        let (mut left, mut busy) = (ms / STEP_MS, 1);
        while left > 0 {
            let rested = self.rest(left);
            left -= rested;
            self.passed_over_ms += rested * STEP_MS;
            if rested > 0 {
                busy = 1;
                continue;
            }
            for _ in 0..left.min(busy) {
                self.tick();
                left -= 1;
            }
            busy = BUSY_STEPS.min(busy * 2);
        }
    }

    /// Time that [`Self::pass_ms`] has not stepped through, ms.
    pub const fn passed_over_ms(&self) -> u64 {
        self.passed_over_ms
    }

    /// Passes over at most so many steps; over how many.
    fn rest(&mut self, most: u64) -> u64 {
        let waits = !self.powered || self.world.is_stalled();
        if waits || self.trace.is_some() || !self.monitor_rests(1) || !self.world.is_at_rest() {
            return 0;
        }
        let spans = SPANS.into_iter().map(|span| span.min(most));
        let Some(span) = spans.into_iter().find(|span| self.monitor_rests(*span)) else { return 0 };
        let steps = self.world.rest(span);
        if steps > 0 {
            self.device.step(self.device_ms(), &mut self.world);
        }
        steps
    }

    /// Whether a step of the monitor so many steps from now leaves all as it is.
    fn monitor_rests(&self, steps: u64) -> bool {
        let mut device = self.device.clone();
        let mut probe = Probe { inputs: self.world.inputs(), outputs: None, disturbed: false };
        let now_ms = self.device_ms().wrapping_add((steps * STEP_MS) as u32);
        device.step(now_ms, &mut probe);
        let drives_the_same = probe.outputs.as_ref() == Some(self.world.outputs());
        !probe.disturbed && drives_the_same && device.is_same_state(&self.device)
    }
}

/// Hardware on which a step is tried.
struct Probe<'a> {
    inputs: &'a Inputs,
    outputs: Option<Outputs>,
    /// It asked for more than inputs and outputs.
    disturbed: bool,
}

impl Hal for Probe<'_> {
    fn read(&mut self, inputs: &mut Inputs) {
        inputs.clone_from(self.inputs);
    }

    fn write(&mut self, outputs: &Outputs) {
        self.outputs = Some(*outputs);
    }

    fn reset(&mut self) {
        self.disturbed = true;
    }
}

impl Storage for Probe<'_> {
    fn load<'b>(&mut self, _: Key, _: &'b mut [u8]) -> Result<Option<&'b [u8]>, StorageError> {
        self.disturbed = true;
        Err(StorageError::Read)
    }

    fn store(&mut self, _: Key, _: &[u8]) -> Result<(), StorageError> {
        self.disturbed = true;
        Err(StorageError::Write)
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.disturbed = true;
        Err(StorageError::Write)
    }
}
